//! Field files as other programs read them.

use std::fs;
use std::io::Read as _;
use std::path::Path;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;

use super::*;

/// An array of a VTU file by its name, read without the help of the writer.
fn array(path: &Path, name: &str) -> Vec<f64> {
    let text = fs::read_to_string(path).unwrap();
    let tag = text.split("<DataArray").find(|tag| tag.contains(&format!("Name=\"{name}\" "))).unwrap();
    let offset = tag.split("offset=\"").nth(1).unwrap().split('"').next().unwrap();
    let data = &text[text.find("\n_").unwrap() + 2 + offset.parse::<usize>().unwrap()..];
    let number = |bytes: &[u8], i: usize| u64::from_le_bytes(bytes[8 * i..8 * i + 8].try_into().unwrap());
    let blocks = number(&STANDARD.decode(&data[..12]).unwrap(), 0) as usize;
    let header = (8 * (3 + blocks)).div_ceil(3) * 4;
    let sizes = STANDARD.decode(&data[..header]).unwrap();
    let length: usize = (0..blocks).map(|k| number(&sizes, 3 + k) as usize).sum();
    let packed = STANDARD.decode(&data[header..header + length.div_ceil(3) * 4]).unwrap();
    let (mut at, mut bytes) = (0, Vec::new());
    for k in 0..blocks {
        let size = number(&sizes, 3 + k) as usize;
        flate2::read::ZlibDecoder::new(&packed[at..at + size]).read_to_end(&mut bytes).unwrap();
        at += size;
    }
    bytes.chunks(8).map(|b| f64::from_le_bytes(b.try_into().unwrap())).collect()
}

/// The last field file of a run.
fn last(folder: &Path, list: &str) -> std::path::PathBuf {
    folder.join(&PvdSeries::open(&folder.join(list)).unwrap().entries().last().unwrap().1)
}

fn run_text(text: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    run(&Deck::parse("m.toml", text).unwrap(), &options(folder.path(), false), &mut Unwatched).unwrap();
    folder
}

#[test]
fn field_files_hold_the_reference_mesh_unless_the_deformed_one_is_wanted() {
    let text = SWING.replace("SCHEME", "newmark");
    let reference: Vec<f64> = (0..3)
        .flat_map(|j| (0..5).flat_map(move |i| [0.25 * f64::from(i), 0.25 * f64::from(j), 0.0]))
        .collect();
    let folder = run_text(&text);
    let file = last(folder.path(), "fields.pvd");
    assert_eq!(array(&file, "Points"), reference);
    let displacement = array(&file, "displacement");
    assert!(displacement.iter().any(|u| u.abs() > 0.05), "{displacement:?}");
    let folder = run_text(&text.replace("[output]", "[output]\ndeformed = true"));
    let file = last(folder.path(), "fields.pvd");
    let found = array(&file, "Points");
    assert_eq!(array(&file, "displacement"), displacement);
    assert_eq!(found.len(), reference.len());
    for (i, x) in found.iter().enumerate() {
        assert!((x - reference[i] - displacement[i]).abs() < 1e-15, "{i}");
    }
}

/// A strip stretched along x by a force per length of 2 over a thickness of 0.02: σ = 100.
const STRETCHED: &str = r#"
[analysis]
type = "static"
linear = true
[mesh]
type = "plate"
size = [2.0, 1.0]
grid = { elements = [4, 2] }
[materials.m]
type = "isotropic"
young = 1e6
poisson = 0.0
strength = { xt = 400.0, xc = 400.0, yt = 400.0, yc = 400.0, s12 = 200.0 }
[[sections]]
material = "m"
thickness = 0.02
[[conditions]]
type = "clamp"
on = "u_min"
[[loads]]
type = "edge"
on = "u_max"
value = [2.0, 0.0, 0.0]
"#;

#[test]
fn derived_fields_are_those_of_a_stretched_strip() {
    let folder = run_text(STRETCHED);
    let file = last(folder.path(), "fields.pvd");
    let close = |name: &str, components: usize, exact: &[f64]| {
        let found = array(&file, name);
        assert!(!found.is_empty() && found.len().is_multiple_of(components), "{name}");
        for entry in found.chunks(components) {
            for (x, e) in entry.iter().zip(exact) {
                assert!((x - e).abs() < 1e-6, "{name}: {entry:?}");
            }
        }
    };
    for surface in ["top", "bottom"] {
        close(&format!("stress_{surface}"), 3, &[100.0, 0.0, 0.0]);
        close(&format!("principal_{surface}"), 3, &[100.0, 0.0, 0.0]);
        close(&format!("stress_{surface}_nodal"), 6, &[100.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    }
    close("von_mises_nodal", 1, &[100.0]);
    close("axis_x", 3, &[1.0, 0.0, 0.0]);
    close("axis_y", 3, &[0.0, 1.0, 0.0]);
    close("axis_z", 3, &[0.0, 0.0, 1.0]);
    close("section", 1, &[1.0]);
    close("reserve_factor", 1, &[4.0]);
    assert_eq!(array(&file, "node"), (0..15).map(f64::from).collect::<Vec<_>>());
    assert_eq!(array(&file, "element"), (0..8).map(f64::from).collect::<Vec<_>>());
    // At the start there is no stress, and no factor by which it could grow.
    let first = array(&folder.path().join("fields/0000.vtu"), "reserve_factor");
    assert!(first.len() == 8 && first.iter().all(|x| x.is_nan()), "{first:?}");
}

#[test]
fn every_mode_has_its_own_entry() {
    let text = STRETCHED.replace("type = \"static\"\nlinear = true", "type = \"modal\"\nmodes = 8");
    let text = text.replace("poisson = 0.0", "poisson = 0.3\ndensity = 1.0");
    let start = text.find("[[conditions]]").unwrap();
    // Free: six rigid modes of the same frequency.
    let folder = run_text(&text[..start]);
    let series = PvdSeries::open(&folder.path().join("modes.pvd")).unwrap();
    let times: Vec<f64> = series.entries().iter().map(|e| e.0).collect();
    assert_eq!(times, (1..=8).map(f64::from).collect::<Vec<_>>());
    let shape = array(&last(folder.path(), "modes.pvd"), "Points");
    assert!(shape.contains(&2.0) && shape.iter().all(|x| (0.0..=2.0).contains(x)), "{shape:?}");
}

#[test]
fn long_runs_write_two_hundred_field_files() {
    let text =
        SWING.replace("scheme = { type = \"SCHEME\" }", "time_step = 2e-4").replace("interval = 0.02", "");
    let folder = run_text(&text);
    let count = |folder: &Path| PvdSeries::open(&folder.join("fields.pvd")).unwrap().entries().len();
    assert_eq!(Summary::read(folder.path()).unwrap().steps, 1000);
    assert_eq!(count(folder.path()), 201);
    let folder = run_text(&text.replace("pictures", "every = 300\npictures"));
    assert_eq!(count(folder.path()), 5);
}

/// A bar swings on a hinge and holds a beam: the files of bodies hold the bar's corners where its position and quaternion in the
/// history put them, and the resultants of the beam that are in the history.
#[test]
fn files_of_bodies_hold_their_places_and_the_resultants_of_beams() {
    let folder = run_text(MACHINE);
    assert!(!folder.path().join("fields").exists(), "there are no shells");
    let file = last(folder.path(), "bodies.pvd");
    let (names, rows) = csv::read(&folder.path().join("history.csv")).unwrap();
    let value = |name: &str| rows.last().unwrap()[names.iter().position(|n| n == name).unwrap()];
    let place = ["x", "y", "z"].map(|c| value(&format!("body.bar.{c}")));
    let [w, x, y, z] = ["q0", "q1", "q2", "q3"].map(|c| value(&format!("body.bar.{c}")));
    assert!(z.abs() > 0.05, "the bar has turned");
    let rotation = nalgebra::UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(w, x, y, z));
    let (points, moved) = (array(&file, "Points"), array(&file, "displacement"));
    assert_eq!(points[..3], [0.0, -0.05, -0.1], "the mesh is that of the reference");
    for (corner, u) in points.chunks(3).zip(moved.chunks(3)).take(8) {
        let arm = nalgebra::Vector3::new(corner[0] - 0.5, corner[1], corner[2]);
        let expected = rotation * arm + nalgebra::Vector3::from(place);
        for i in 0..3 {
            assert!((corner[i] + u[i] - expected[i]).abs() < 1e-12, "{corner:?} {u:?} {expected}");
        }
    }
    let part = array(&file, "part");
    let (force, moment) = (array(&file, "beam_force"), array(&file, "beam_moment"));
    assert!(part.len() == 6 + 6 && force[..18].iter().chain(&moment[..18]).all(|x| x.is_nan()));
    assert_eq!((part[5], part[6]), (0.0, 1.0));
    // The beam has one element with four sides and two ends.
    for (i, column) in ["v1", "v2", "n"].into_iter().enumerate() {
        let expected = value(&format!("beam.arm.end.{column}"));
        assert!(force[18..].chunks(3).all(|v| v[i] == expected), "{column}: {force:?} {expected}");
    }
    for (i, column) in ["m1", "m2", "t"].into_iter().enumerate() {
        assert!(moment[18..].chunks(3).all(|v| v[i] == value(&format!("beam.arm.end.{column}"))));
    }
    assert!(force[18..].iter().any(|v| v.abs() > 0.1), "{force:?}");
}

/// Mean rate over the step that ends at each row of a history, from the values in the rows and at the start.
fn mean_rates(times: &[f64], values: &[f64]) -> Vec<f64> {
    let of_step = |i: usize| (values[i] - values[i - 1]) / (times[i] - times[i - 1]);
    (0..values.len()).map(|i| if i == 0 { 0.0 } else { of_step(i) }).collect()
}

/// The angle of a torsion spring in the history is that of its body's quaternion, in degrees, and the moment belongs to it and to its mean
/// rate over the step.
#[test]
fn the_history_has_angle_and_moment_of_torsion_springs() {
    let folder = run_text(MACHINE);
    let (names, rows) = csv::read(&folder.path().join("history.csv")).unwrap();
    let column = |name: &str| -> Vec<f64> {
        rows.iter().map(|row| row[names.iter().position(|n| n == name).unwrap()]).collect()
    };
    let angles: Vec<f64> =
        column("body.bar.q3").iter().zip(column("body.bar.q0")).map(|(s, c)| 2.0 * s.atan2(c)).collect();
    let rates = mean_rates(&column("time"), &angles);
    for (row, (turned, rate)) in rows.iter().zip(angles.iter().zip(rates)) {
        let value = |name: &str| row[names.iter().position(|n| n == name).unwrap()];
        let angle = value("torsion_spring.coil.angle");
        assert!((angle - turned.to_degrees()).abs() < 1e-9, "{angle} {turned}");
        let moment = 3.0 * (turned - 0.5_f64.to_radians()) + 0.2 * rate;
        let found = value("torsion_spring.coil.moment");
        assert!((found - moment).abs() < 1e-9 * (1.0 + moment.abs()), "{found} {moment} {row:?}");
    }
    assert!(rows.len() > 15);
}

/// Accelerations of the history are the differences of its velocities over the steps: of a body that tumbles, and of a point mass.
#[test]
fn the_history_has_accelerations_of_bodies() {
    let folder = run_text(
        r#"
        [analysis]
        type = "transient"
        end_time = 0.02
        time_step = 1e-3
        scheme = { type = "energy-momentum" }
        [[bodies]]
        name = "top"
        at = [0.0, 0.0, 0.0]
        mass = 2.0
        inertia = [0.1, 0.2, 0.25]
        velocity = [1.0, 0.0, 0.0]
        angular_velocity = [3.0, 2.0, 4.0]
        [[bodies]]
        name = "drop"
        at = [1.0, 0.0, 0.0]
        mass = 0.5
        [[loads]]
        type = "gravity"
        value = [1.0, -2.0, 3.0]
        "#,
    );
    let (names, rows) = csv::read(&folder.path().join("history.csv")).unwrap();
    assert!(!names.iter().any(|name| name == "body.drop.alpha_x"));
    for pair in rows.windows(2) {
        let value = |row: usize, name: &str| pair[row][names.iter().position(|n| n == name).unwrap()];
        let dt = value(1, "time") - value(0, "time");
        for (body, velocity, acceleration, gravity) in [
            ("top", "vx", "ax", 1.0),
            ("top", "vy", "ay", -2.0),
            ("drop", "vx", "ax", 1.0),
            ("drop", "vz", "az", 3.0),
        ] {
            let velocity = format!("body.{body}.{velocity}");
            let rate = (value(1, &velocity) - value(0, &velocity)) / dt;
            let found = value(1, &format!("body.{body}.{acceleration}"));
            assert!(
                (found - rate).abs() < 1e-9 && (found - gravity).abs() < 1e-9,
                "{velocity}: {found} {rate}"
            );
        }
        for (spin, acceleration) in [("wx", "alpha_x"), ("wy", "alpha_y"), ("wz", "alpha_z")] {
            let [before, behind] = [0, 1].map(|row| value(row, &format!("body.top.{spin}")));
            let found = value(1, &format!("body.top.{acceleration}"));
            let rate = (behind - before) / dt;
            assert!(rate.abs() > 0.1 && (found / rate - 1.0).abs() < 1e-3, "{acceleration}: {found} {rate}");
        }
    }
    assert!(rows.len() > 15);
}

/// Length of a spring in the history is that of the body's position, and its force that of the length and of its mean rate over the step.
#[test]
fn the_history_has_length_and_force_of_springs() {
    let spring = r#"
    [[springs]]
    name = "pull"
    between = ["ground", "bar"]
    points = [[0.5, 1.0, 0.0], [0.5, 0.0, 0.0]]
    stiffness = 4.0
    damping = 0.3
    length = 0.8
    "#;
    let folder = run_text(&format!("{MACHINE}{spring}"));
    let (names, rows) = csv::read(&folder.path().join("history.csv")).unwrap();
    let value = |row: &[f64], name: &str| row[names.iter().position(|n| n == name).unwrap()];
    let of_row = |row: &Vec<f64>| {
        let x = nalgebra::Vector3::from(["x", "y", "z"].map(|c| value(row, &format!("body.bar.{c}"))));
        (x - nalgebra::Vector3::new(0.5, 1.0, 0.0)).norm()
    };
    let lengths: Vec<f64> = rows.iter().map(of_row).collect();
    let times: Vec<f64> = rows.iter().map(|row| value(row, "time")).collect();
    for (row, (expected, rate)) in rows.iter().zip(lengths.iter().zip(mean_rates(&times, &lengths))) {
        let (length, force) = (value(row, "spring.pull.length"), value(row, "spring.pull.force"));
        assert!((length - expected).abs() < 1e-12, "{row:?}");
        assert!((force - (4.0 * (length - 0.8) + 0.3 * rate)).abs() < 1e-9, "{row:?}");
    }
    assert!(lengths[lengths.len() - 1] > lengths[0] + 1e-3, "the bar falls: {lengths:?}");
}

/// Displacement, rotation, force and moment of a bushing in the history are those of the position and quaternion of its body and of their
/// mean rates over the step; without stiffness of rotations there are no columns of them.
#[test]
fn the_history_has_displacements_rotations_and_forces_of_bushings() {
    let folder = run_text(&format!("{MACHINE}{BUSHINGS}"));
    let (names, rows) = csv::read(&folder.path().join("history.csv")).unwrap();
    let of_slack = names.iter().filter(|name| name.starts_with("bushing.slack.")).count();
    assert_eq!((of_slack, names.contains(&"bushing.rubber.mz".to_owned())), (6, true), "{names:?}");
    let column = |name: &str| -> Vec<f64> {
        rows.iter().map(|row| row[names.iter().position(|n| n == name).unwrap()]).collect()
    };
    let turns: Vec<f64> =
        column("body.bar.q3").iter().zip(column("body.bar.q0")).map(|(s, c)| 2.0 * s.atan2(c)).collect();
    let rates = [turns.clone(), column("body.bar.x"), column("body.bar.y")]
        .map(|values| mean_rates(&column("time"), &values));
    for (i, row) in rows.iter().enumerate() {
        let value = |name: &str| row[names.iter().position(|n| n == name).unwrap()];
        let turned = turns[i];
        let u = [value("body.bar.x") - 0.5, value("body.bar.y")];
        let [turning, v @ ..] = [0, 1, 2].map(|k| rates[k][i]);
        for (found, expected) in [
            ("ux", u[0]),
            ("uy", u[1]),
            ("uz", 0.0),
            ("rz", turned.to_degrees()),
            ("fx", 4.0 * u[0] + 0.3 * v[0]),
            ("fy", 5.0 * u[1] + 0.2 * v[1]),
            ("mz", 2.0 * turned + 0.4 * turning),
        ] {
            let found = value(&format!("bushing.rubber.{found}"));
            assert!((found - expected).abs() < 1e-9 * (1.0 + expected.abs()), "{found} {expected} {row:?}");
        }
    }
    assert!(turns.iter().any(|turned| turned.abs() > 0.01), "{turns:?}");
}

/// A run with bushings that is interrupted and resumed has the history of the straight one.
#[test]
fn a_resumed_run_with_bushings_is_the_run_itself() {
    for scheme in ["energy-momentum", "generalized-alpha"] {
        let text = format!("{MACHINE}{BUSHINGS}").replace("energy-momentum", scheme);
        let (deck, folder) = (Deck::parse("m.toml", text).unwrap(), tempfile::tempdir().unwrap());
        let (straight, parts) = (folder.path().join("straight"), folder.path().join("parts"));
        run(&deck, &options(&straight, false), &mut Unwatched).unwrap();
        run(&deck, &options(&parts, false), &mut stop_after(7)).unwrap_err();
        run(&deck, &options(&parts, true), &mut Unwatched).unwrap();
        let read = |folder: &Path| fs::read(folder.join("history.csv")).unwrap();
        assert!(read(&straight) == read(&parts), "{scheme}");
    }
}

const BUSHINGS: &str = r#"
    [[bushings]]
    name = "rubber"
    between = ["ground", "bar"]
    at = [0.5, 0.0, 0.0]
    stiffness = [4.0, 5.0, 6.0, 1.0, 1.0, 2.0]
    damping = [0.3, 0.2, 0.1, 0.0, 0.0, 0.4]
    [[bushings]]
    name = "slack"
    between = ["ground", "bar"]
    at = [0.5, 0.0, 0.0]
    stiffness = [1.0, 1.0, 1.0, 0.0, 0.0, 0.0]
    "#;

const MACHINE: &str = r#"
    loads = [{ type = "gravity", value = [0, -9.81, 0] }]
    output = { pictures = false }
    [analysis]
    type = "transient"
    end_time = 0.2
    time_step = 0.01
    scheme = { type = "energy-momentum" }
    [materials.steel]
    type = "isotropic"
    young = 2e9
    poisson = 0.3
    density = 1000.0
    [[bodies]]
    name = "bar"
    at = [0.5, 0, 0]
    mass = 1.0
    shape = { type = "box", size = [1.0, 0.1, 0.2] }
    [[beams]]
    name = "arm"
    points = [[1.0, 0, 0], [1.5, 0, 0]]
    elements = 1
    direction = [0, 1, 0]
    section = { type = "rectangle", size = [0.05, 0.05] }
    material = "steel"
    [[joints]]
    type = "revolute"
    name = "hinge"
    between = ["ground", "bar"]
    at = [0, 0, 0]
    axis = [0, 0, 1]
    [[torsion_springs]]
    name = "coil"
    between = ["ground", "bar"]
    axis = [0, 0, 1]
    stiffness = 3.0
    damping = 0.2
    free_angle = 0.5
    [[joints]]
    type = "fixed"
    name = "weld"
    between = ["bar", "arm.start"]
    at = [1.0, 0, 0]
"#;
