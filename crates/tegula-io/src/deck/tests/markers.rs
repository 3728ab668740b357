#![allow(clippy::unwrap_used)]

//! Points and directions by the names of markers.

use proptest::prelude::*;
use tegula::model::{Joint, Sensor};

use super::{check, errors, parse};

/// Four-bar linkage by coordinates.
const BY_COORDINATES: &str = r#"[analysis]
type = "transient"
end_time = 1.0
time_step = 0.01
scheme = { type = "energy-momentum" }
[[bodies]]
name = "crank"
at = [0.0, 0.25, 0.0]
mass = 1.0
shape = { type = "rod", length = 0.5 }
axes = [[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]]
[[bodies]]
name = "coupler"
at = [0.5, 0.5, 0.0]
mass = 2.0
shape = { type = "box", size = [1.0, 0.1, 0.1] }
[[bodies]]
name = "rocker"
at = [1.0, 0.25, 0.0]
mass = 1.0
shape = { type = "box", size = [0.1, 0.5, 0.1] }
[[beams]]
name = "spoke"
points = [[0.0, 0.0, 0.0], [0.0, 0.5, 0.0]]
elements = 4
direction = [1.0, 0.0, 0.0]
section = { type = "constants", axial = 1.0, shear = [1, 1], bending = [1, 1], torsion = 1, mass = 1, inertia = [1, 1] }
[[joints]]
type = "revolute"
name = "bearing"
between = ["ground", "crank"]
at = [0.0, 0.0, 0.0]
axis = [0.0, 0.0, 1.0]
[[joints]]
type = "universal"
name = "cardan"
between = ["crank", "coupler"]
at = [0.0, 0.5, 0.0]
axes = [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]]
[[joints]]
type = "spherical"
name = "ball"
between = ["coupler", "rocker"]
at = [1.0, 0.5, 0.0]
[[joints]]
type = "distance"
name = "rod"
between = ["ground", "rocker"]
points = [[0.0, 0.0, 0.0], [1.0, 0.5, 0.0]]
[[springs]]
name = "spring"
between = ["ground", "rocker"]
points = [[0.0, 0.0, 0.0], [1.0, 0.5, 0.0]]
stiffness = 10.0
[[torsion_springs]]
name = "coil"
between = ["ground", "crank"]
axis = [0.0, 0.0, -1.0]
stiffness = 1.0
[[sensors]]
type = "point"
name = "tip"
on = "coupler"
at = [1.0, 0.5, 0.0]
[[sensors]]
type = "angle"
name = "turn"
between = ["ground", "crank"]
axis = [0.0, 0.0, 1.0]
[[sensors]]
type = "distance"
name = "stroke"
between = ["ground", "rocker"]
points = [[0.0, 0.0, 0.0], [1.0, 0.5, 0.0]]
"#;

/// The linkage of `BY_COORDINATES` by markers.
pub(super) const BY_MARKERS: &str = r#"[analysis]
type = "transient"
end_time = 1.0
time_step = 0.01
scheme = { type = "energy-momentum" }
[[markers]]
name = "A"
at = [0, 0, 0]
[[markers]]
name = "B"
on = "A"
at = [0.0, 0.5, 0.0]
[[markers]]
name = "C"
on = "B"
at = [1.0, 0.0, 0.0]
[[markers]]
name = "crank middle"
on = "A"
at = [0.0, 0.25, 0.0]
[[bodies]]
name = "crank"
at = "crank middle"
mass = 1.0
shape = { type = "rod", length = 0.5 }
axes = ["B.y", "-B.x"]
[[bodies]]
name = "coupler"
at = [0.5, 0.5, 0.0]
mass = 2.0
shape = { type = "box", size = [1.0, 0.1, 0.1] }
[[bodies]]
name = "rocker"
at = [1.0, 0.25, 0.0]
mass = 1.0
shape = { type = "box", size = [0.1, 0.5, 0.1] }
[[beams]]
name = "spoke"
points = ["A", "B"]
elements = 4
direction = "A.x"
section = { type = "constants", axial = 1.0, shear = [1, 1], bending = [1, 1], torsion = 1, mass = 1, inertia = [1, 1] }
[[joints]]
type = "revolute"
name = "bearing"
between = ["ground", "crank"]
at = "A"
axis = "A.z"
[[joints]]
type = "universal"
name = "cardan"
between = ["crank", "coupler"]
at = "B"
axes = ["B.z", [1, 0, 0]]
[[joints]]
type = "spherical"
name = "ball"
between = ["coupler", "rocker"]
at = "C"
[[joints]]
type = "distance"
name = "rod"
between = ["ground", "rocker"]
points = [[0, 0, 0], "C"]
[[springs]]
name = "spring"
between = ["ground", "rocker"]
points = ["A", "C"]
stiffness = 10.0
[[torsion_springs]]
name = "coil"
between = ["ground", "crank"]
axis = "-A.z"
stiffness = 1.0
[[sensors]]
type = "point"
name = "tip"
on = "coupler"
at = "C"
[[sensors]]
type = "angle"
name = "turn"
between = ["ground", "crank"]
axis = "A.z"
[[sensors]]
type = "distance"
name = "stroke"
between = ["ground", "rocker"]
points = ["A", "C"]
"#;

/// Diagnostics of the linkage with `from` replaced.
pub(super) fn with(from: &str, to: &str) -> String {
    assert!(BY_MARKERS.contains(from), "{from}");
    errors(&BY_MARKERS.replacen(from, to, 1))
}

#[test]
fn a_linkage_by_markers_is_the_one_by_coordinates() {
    let deck = parse(BY_MARKERS).unwrap();
    assert_eq!(deck.model, parse(BY_COORDINATES).unwrap().model);
    assert_eq!(deck.warnings, []);
    // A written model has coordinates and is read back without the markers.
    let written = toml::to_string(&deck.model).unwrap();
    assert!(!written.contains("markers"));
    assert_eq!(parse(&written).unwrap().model, deck.model);
}

#[test]
fn the_slider_crank_by_markers_is_the_one_of_the_example() {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/slider_crank.toml");
    let text = std::fs::read_to_string(path).unwrap();
    let mut named = text.clone();
    for (count, from, to) in [
        (1, "at = [0.0, 0.1, 0.12]\naxis = [1.0, 0.0, 0.0]", "at = \"A\"\naxis = \"A.z\""),
        (1, "at = [0.0, 0.1, 0.2]", "at = \"B\""),
        (3, "at = [0.2, 0.0, 0.0]", "at = \"C\""),
        (1, "axis = [1.0, 0.0, 0.0]", "axis = \"C.x\""),
        (1, "axes = [[1.0, 0.0, 0.0],", "axes = [\"C.x\","),
    ] {
        assert_eq!(named.matches(from).count(), count, "{from}");
        named = named.replace(from, to);
    }
    // The crank shaft runs along x: a cyclic permutation of the axes of space.
    named += "
[[markers]]
name = \"A\"
at = [0.0, 0.1, 0.12]
axes = [[0.0, 2.0, 0.0], [0.0, 0.0, 5.0]]
[[markers]]
name = \"B\"
at = [0.0, 0.1, 0.2]
[[markers]]
name = \"C\"
at = [0.2, 0.0, 0.0]
";
    assert_eq!(parse(&named).unwrap().model, parse(&text).unwrap().model);
}

/// The example is the linkage that its drawing shows, with the coordinates of its hinges.
#[test]
fn the_flexible_four_bar_by_markers_is_the_one_by_coordinates() {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/flexible_four_bar.toml");
    let text = std::fs::read_to_string(path).unwrap();
    let first = text.find("[[markers]]").unwrap();
    let behind = first + text[first..].find("[[bodies]]").unwrap();
    let mut plain = text[..first].to_owned() + &text[behind..];
    for (name, at) in [
        ("A", "[0.0, 0.0, 0.0]"),
        ("B", "[0.0, 0.2, 0.0]"),
        ("C", "[0.8, 0.2, 0.0]"),
        ("D", "[0.8, -0.4, 0.0]"),
    ] {
        plain = plain.replace(&format!("at = \"{name}\""), &format!("at = {at}"));
        plain = plain.replace(&format!("\"{name}.x\""), "[1.0, 0.0, 0.0]");
        plain = plain.replace(&format!("\"{name}.y\""), "[0.0, 1.0, 0.0]");
        plain = plain.replace(&format!("\"{name}.z\""), "[0.0, 0.0, 1.0]");
    }
    let deck = parse(&text).unwrap();
    assert_eq!(deck.model, parse(&plain).unwrap().model);
    assert_eq!(deck.warnings, []);
}

/// Points and axes of joints on their second side, by markers on bodies as they are drawn.
#[test]
fn second_sides_of_joints_take_markers() {
    let path =
        std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/assembled_four_bar.toml");
    let text = std::fs::read_to_string(path).unwrap();
    let text = text.replace(
        "second_at = \"rocker foot\"",
        "second_at = \"rocker foot\"\nsecond_axis = \"-rocker foot.y\"",
    );
    let deck = parse(&text).unwrap();
    let sides: Vec<_> = deck.model.joints.iter().map(|joint| joint.common().second_side()).collect();
    let at = [None, Some([0.0, 0.4, 0.0]), Some([0.6, 0.3, 0.0]), Some([0.6, 0.0, 0.0]), None];
    for (side, expected) in sides.iter().zip(at) {
        assert_eq!(side.at.is_some(), expected.is_some());
        let apart = side.at.iter().flatten().zip(expected.iter().flatten()).map(|(a, b)| (a - b).abs());
        assert!(apart.sum::<f64>() < 1e-15, "{side:?}");
    }
    // The axis y of the rocker, as it is drawn, points along −x.
    assert_eq!(sides[3].axis, Some([1.0, 0.0, 0.0]));
    assert_eq!(deck.warnings, []);
}

/// Places and axes of a chain of markers and bodies, computed by hand with rotations of the triangle 3, 4, 5.
#[test]
fn frames_of_markers_and_bodies_are_carried_along() {
    let text = r#"
[analysis]
type = "transient"
end_time = 1.0
time_step = 0.01
scheme = { type = "energy-momentum" }
[[markers]]
name = "D"
on = "arm"
at = [2.0, 0.0, 0.0]
[[markers]]
name = "C"
on = "B"
at = [1.0, 1.0, 1.0]
[[markers]]
name = "B"
on = "A"
at = [10.0, 0.0, 5.0]
axes = [[0.0, 0.0, 2.0], [0.0, 5.0, 1.0]]
[[markers]]
name = "A"
at = [1.0, 2.0, 3.0]
axes = [[0.6, 0.8, 0.0], [-1.6, 1.2, 0.0]]
[[bodies]]
name = "arm"
at = "A"
mass = 1.0
inertia = [1.0, 1.0, 1.0]
axes = ["A.y", "-A.x"]
"#;
    let sensor =
        |at: &str| format!("[[sensors]]\ntype = \"point\"\nname = \"{at}\"\non = \"arm\"\nat = \"{at}\"\n");
    let axis = |axis: &str| {
        format!(
            "[[sensors]]\ntype = \"angle\"\nname = \"{axis}\"\nbetween = [\"ground\", \"arm\"]\naxis = \"{axis}\"\n"
        )
    };
    let expected = [
        ("A", [1.0, 2.0, 3.0]),
        ("B", [7.0, 10.0, 8.0]),
        ("C", [5.6, 9.8, 9.0]),
        ("D", [-0.6, 3.2, 3.0]),
        ("A.z", [0.0, 0.0, 1.0]),
        ("B.x", [0.0, 0.0, 1.0]),
        ("B.y", [-0.8, 0.6, 0.0]),
        ("-B.z", [0.6, 0.8, 0.0]),
        ("C.z", [-0.6, -0.8, 0.0]),
        ("D.x", [-0.8, 0.6, 0.0]),
        ("D.y", [-0.6, -0.8, 0.0]),
        ("D.z", [0.0, 0.0, 1.0]),
    ];
    let one = |(name, _): &(&str, [f64; 3])| if name.contains('.') { axis(name) } else { sensor(name) };
    let model = parse(&(text.to_owned() + &expected.iter().map(one).collect::<String>())).unwrap().model;
    let close = |found: [f64; 3], wanted: [f64; 3], name: &str| {
        assert!((0..3).all(|k| (found[k] - wanted[k]).abs() <= 4e-15), "{name}: {found:?}, {wanted:?}");
    };
    for ((name, wanted), sensor) in expected.iter().zip(&model.sensors) {
        let found = match sensor {
            Sensor::Point(point) => point.at.unwrap(),
            Sensor::Angle(angle) => angle.axis,
            other => panic!("{other:?}"),
        };
        close(found, *wanted, name);
    }
    close(model.bodies[0].at, [1.0, 2.0, 3.0], "arm");
    close(model.bodies[0].axes[0], [-0.8, 0.6, 0.0], "arm");
    close(model.bodies[0].axes[1], [-0.6, -0.8, 0.0], "arm");
}

#[test]
fn meshes_and_conditions_take_markers() {
    let places = "type = \"plate\"\norigin = \"corner\"\nu_axis = \"corner.y\"\nv_axis = \"corner.z\"";
    let text = super::MODEL
        .replace("type = \"plate\"", places)
        .replace("elements = [16, 2]", "elements = [16, 2]\npoints = { tip = \"corner\" }")
        .replace("interval = 0.1", "interval = 0.1\npoints = [{ name = \"p\", at = \"corner\" }]")
        .replace(
            "[[loads]]",
            "[[conditions]]\ntype = \"symmetry\"\non = \"v_min\"\nnormal = \"-corner.z\"\n[[markers]]\nname = \"corner\"\nat = [1, 2, 3]\n[[loads]]",
        );
    let found = parse(&text).unwrap().model;
    let of_coordinates = text
        .replace("\"corner.y\"", "[0, 1, 0]")
        .replace("\"corner.z\"", "[0, 0, 1]")
        .replace("\"-corner.z\"", "[0, 0, -1]")
        .replace("= \"corner\" }", "= [1, 2, 3] }")
        .replace("origin = \"corner\"", "origin = [1, 2, 3]");
    let wanted = parse(&of_coordinates).unwrap();
    assert_eq!(found, wanted.model);
    assert_eq!(wanted.warnings.len(), 1);
}

#[test]
fn markers_that_nothing_uses_are_told() {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/slider_crank.toml");
    let text = std::fs::read_to_string(path).unwrap().replacen("[[bodies]]", "[[markers]]\nname = \"end\"\nat = [1, 0, 0]\n\n[[markers]]\nname = \"spare\"\non = \"end\"\nat = [1, 0, 0]\n\n[[bodies]]", 1);
    let deck = parse(&text).unwrap();
    let told = deck.locate(&deck.warnings);
    assert_eq!(told.len(), 1);
    insta::assert_snapshot!(told[0], @r#"
    m.toml:20:1: markers[1]: nothing uses the marker "spare"
      help: leave it out, or name it in place of coordinates
    "#);
    assert_eq!(crate::job::prepare(&deck).ok().unwrap().warnings, told);
}

/// A marker on a body without axes has no place, and the body is told, too.
#[test]
fn a_body_without_axes_carries_no_marker() {
    let text = BY_MARKERS.replace("name = \"C\"\non = \"B\"", "name = \"C\"\non = \"rocker\"");
    let flat =
        |axes: &str| text.replace("at = [1.0, 0.25, 0.0]", &format!("at = [1.0, 0.25, 0.0]\naxes = {axes}"));
    insta::assert_snapshot!(errors(&flat("[[0, 1, 0], [0, 2, 0]]")), @r#"
    m.toml:15:6: markers[2].on: the body "rocker" has no axes for a marker
      help: give its `axes` as two directions that span a plane
    m.toml:35:8: bodies[2].axes: the two directions are parallel
      help: give two directions that span a plane
    "#);
    insta::assert_snapshot!(errors(&flat("[\"A.x\", \"-A.x\"]")), @r#"
    m.toml:35:8: bodies[2].axes: the two directions are parallel
      help: give two directions that span a plane
    m.toml:60:6: joints[2].at: the marker has no place
      help: check the marker and what it is on
    "#);
}

/// A chain of any length is placed without recursion.
#[test]
fn long_chains_of_markers_are_placed() {
    const LENGTH: usize = 20_000;
    let mut text = BY_MARKERS.replace("at = \"C\"", "at = \"m0\"");
    for i in 0..LENGTH {
        let on = if i + 1 < LENGTH { format!("on = \"m{}\"\n", i + 1) } else { String::new() };
        text += &format!("[[markers]]\nname = \"m{i}\"\nat = [0.5, 0, 0]\n{on}");
    }
    let model = parse(&text).unwrap().model;
    let Joint::Spherical(ball) = &model.joints[2] else { panic!("{:?}", model.joints) };
    assert_eq!(ball.at, [0.5 * LENGTH as f64, 0.0, 0.0]);
    let found = parse(&(text + "on = \"m0\"\n")).unwrap_err();
    assert_eq!(found.len(), 1, "{found:#?}");
    assert!(found[0].message.starts_with("the place depends on itself: m0 → m1 → "), "{}", found[0].message);
}

proptest! {
    #[test]
    fn no_change_of_markers_panics(
        changes in proptest::collection::vec((any::<prop::sample::Index>(), 0..30usize, "([a-z\\[\\]{}=.,\"0-9\né-]|\"A\"|on = |\"C\\.x\"){0,4}"), 1..5),
    ) {
        let mut text = BY_MARKERS.to_owned();
        for (place, removed, inserted) in changes {
            let letters: Vec<char> = text.chars().collect();
            let start = place.index(letters.len() + 1);
            let end = (start + removed).min(letters.len());
            text = letters[..start].iter().chain(&inserted.chars().collect::<Vec<_>>()).chain(&letters[end..]).collect();
        }
        check(&text)?;
    }
}
