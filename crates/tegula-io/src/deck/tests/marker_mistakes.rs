//! Mistakes in the names of markers.

use super::errors;
use super::markers::{BY_MARKERS, with};

#[test]
fn references_that_mean_nothing_are_refused() {
    insta::assert_snapshot!(with("at = \"C\"", "at = \"crank middel\""), @r#"
    m.toml:59:6: joints[2].at: there is no marker "crank middel"
      help: did you mean "crank middle"?
    "#);
    insta::assert_snapshot!(with("at = \"C\"", "at = \"somewhere\""), @r#"
    m.toml:59:6: joints[2].at: there is no marker "somewhere"
      help: give three coordinates, or a marker by its name; the markers are "A", "B", "C", "crank middle"
    "#);
    insta::assert_snapshot!(with("at = \"C\"", "at = \"rocker\""), @r#"
    m.toml:59:6: joints[2].at: there is no marker "rocker"
      help: this is a body; a marker has its place with `on = "rocker"`
    "#);
    insta::assert_snapshot!(with("at = \"C\"", "at = \"C.x\""), @r#"
    m.toml:59:6: joints[2].at: expected a point, found "C.x"
      help: the point of the marker is "C", without sign and axis
    "#);
    insta::assert_snapshot!(with("at = \"C\"", "at = \"-C\""), @r#"
    m.toml:59:6: joints[2].at: expected a point, found "-C"
      help: the point of the marker is "C", without sign and axis
    "#);
    insta::assert_snapshot!(with("axis = \"A.z\"", "axis = \"A\""), @r#"
    m.toml:48:8: joints[0].axis: expected a direction, found the point "A"
      help: name an axis of the marker: "A.x", "A.y" or "A.z"
    "#);
    insta::assert_snapshot!(with("axis = \"A.z\"", "axis = \"A.w\""), @r#"
    m.toml:48:8: joints[0].axis: a marker has no axis "w"
      help: its axes are "A.x", "A.y" and "A.z"
    "#);
    insta::assert_snapshot!(with("axis = \"A.z\"", "axis = \"z\""), @r#"
    m.toml:48:8: joints[0].axis: there is no marker "z"
      help: give three components, or an axis of a marker such as "NAME.x"; the markers are "A", "B", "C", "crank middle"
    "#);
    insta::assert_snapshot!(with("axes = [\"B.y\", \"-B.x\"]", "axes = [\"B.y\", \"B\"]"), @r#"
    m.toml:26:16: bodies[0].axes[1]: expected a direction, found the point "B"
      help: name an axis of the marker: "B.x", "B.y" or "B.z"
    "#);
    insta::assert_snapshot!(with("axes = [\"B.y\", \"-B.x\"]", "axes = \"B\""), @r#"
    m.toml:26:8: bodies[0].axes: expected a list of 2 lists, found the string "B"
      help: write a list with an entry for each: ["B", …]
    "#);
    insta::assert_snapshot!(with("mass = 1.0", "mass = 1.0\nvelocity = \"A.x\""), @r#"
    m.toml:25:12: bodies[0].velocity: expected a list of 3 numbers, found the string "A.x"
      help: Velocity of the mass centre at the start [length/time].
    "#);
    insta::assert_snapshot!(super::with("size = [10, 1.0]", "size = [10, 1.0]\norigin = \"corner\""), @r#"
    m.toml:8:10: mesh.origin: there is no marker "corner"
      help: give three coordinates, or a marker by its name; the model has no [[markers]]
    "#);
}

#[test]
fn markers_without_a_place_are_refused() {
    insta::assert_snapshot!(with("on = \"B\"", "on = \"crank midle\""), @r#"
    m.toml:15:6: markers[2].on: there is no marker or body "crank midle"
      help: did you mean "crank middle"?
    "#);
    insta::assert_snapshot!(with("on = \"B\"", "on = \"elsewhere\""), @r#"
    m.toml:15:6: markers[2].on: there is no marker or body "elsewhere"
      help: name another marker or a body, or leave `on` out to give coordinates along the axes of space
    "#);
    insta::assert_snapshot!(with("on = \"B\"", "on = \"C\""), @r#"
    m.toml:15:6: markers[2].on: the place depends on itself: C → C
      help: give one of them by coordinates along the axes of space
    "#);
    insta::assert_snapshot!(with("at = [0, 0, 0]", "at = [0, 0, 0]\non = \"C\""), @r#"
    m.toml:9:6: markers[0].on: the place depends on itself: A → C → B → A
      help: give one of them by coordinates along the axes of space
    "#);
    insta::assert_snapshot!(with("at = [0, 0, 0]", "at = [0, 0, 0]\non = \"crank\""), @r#"
    m.toml:9:6: markers[0].on: the place depends on itself: A → crank → crank middle → A
      help: give one of them by coordinates along the axes of space
    "#);
    insta::assert_snapshot!(with("name = \"crank middle\"\non = \"A\"", "name = \"crank\"\non = \"crank\""), @r#"
    m.toml:19:6: markers[3].on: both a marker and a body are named "crank"
      help: rename one of them
    m.toml:23:6: bodies[0].at: there is no marker "crank middle"
      help: give three coordinates, or a marker by its name; the markers are "A", "B", "C", "crank"
    "#);
    insta::assert_snapshot!(with("name = \"C\"\non = \"B\"\nat = [1.0, 0.0, 0.0]", "name = \"C\"\non = \"rocker\"\nat = [1e308, 0, 0]\n[[markers]]\nname = \"D\"\non = \"C\"\nat = [1e308, 0, 0]"), @r#"
    m.toml:17:1: markers[3].at: the coordinates in space are too large
      help: check the units
    m.toml:63:6: joints[2].at: the point has the component 1e308; products of such numbers cannot be computed
      help: give numbers of a size up to 1e100; check the units
    m.toml:68:22: joints[3].points[1]: the point has the component 1e308; products of such numbers cannot be computed
      help: give numbers of a size up to 1e100; check the units
    m.toml:72:10: springs[0].points: the point has the component 1e308; products of such numbers cannot be computed
      help: give numbers of a size up to 1e100; check the units
    m.toml:83:6: sensors[0].at: the point has the component 1e308; products of such numbers cannot be computed
      help: give numbers of a size up to 1e100; check the units
    m.toml:93:10: sensors[2].points: the point has the component 1e308; products of such numbers cannot be computed
      help: give numbers of a size up to 1e100; check the units
    "#);
}

#[test]
fn mistakes_in_names_of_markers_are_placed_and_hide_nothing() {
    insta::assert_snapshot!(with("name = \"C\"", "name = \"B\""), @r#"
    m.toml:14:8: markers[2].name: two markers are named "B"
      help: give each marker its own name
    m.toml:59:6: joints[2].at: there is no marker "C"
      help: give three coordinates, or a marker by its name; the markers are "A", "B", "crank middle"
    m.toml:64:22: joints[3].points[1]: there is no marker "C"
      help: give three coordinates, or a marker by its name; the markers are "A", "B", "crank middle"
    m.toml:68:16: springs[0].points[1]: there is no marker "C"
      help: give three coordinates, or a marker by its name; the markers are "A", "B", "crank middle"
    m.toml:79:6: sensors[0].at: there is no marker "C"
      help: give three coordinates, or a marker by its name; the markers are "A", "B", "crank middle"
    m.toml:89:16: sensors[2].points[1]: there is no marker "C"
      help: give three coordinates, or a marker by its name; the markers are "A", "B", "crank middle"
    "#);
    insta::assert_snapshot!(with("name = \"C\"", "name = \"C.x\""), @r#"
    m.toml:14:8: markers[2].name: "C.x" cannot name a marker
      help: use letters, digits, blanks, '_' and '-', and begin with a letter, a digit or '_'
    m.toml:59:6: joints[2].at: there is no marker "C"
      help: give three coordinates, or a marker by its name; the markers are "A", "B", "C.x", "crank middle"
    m.toml:64:22: joints[3].points[1]: there is no marker "C"
      help: give three coordinates, or a marker by its name; the markers are "A", "B", "C.x", "crank middle"
    m.toml:68:16: springs[0].points[1]: there is no marker "C"
      help: give three coordinates, or a marker by its name; the markers are "A", "B", "C.x", "crank middle"
    m.toml:79:6: sensors[0].at: there is no marker "C"
      help: give three coordinates, or a marker by its name; the markers are "A", "B", "C.x", "crank middle"
    m.toml:89:16: sensors[2].points[1]: there is no marker "C"
      help: give three coordinates, or a marker by its name; the markers are "A", "B", "C.x", "crank middle"
    "#);
    insta::assert_snapshot!(with("name = \"C\"", "name = \"-C\""), @r#"
    m.toml:14:8: markers[2].name: "-C" cannot name a marker
      help: use letters, digits, blanks, '_' and '-', and begin with a letter, a digit or '_'
    m.toml:59:6: joints[2].at: there is no marker "C"
      help: give three coordinates, or a marker by its name; the markers are "-C", "A", "B", "crank middle"
    m.toml:64:22: joints[3].points[1]: there is no marker "C"
      help: give three coordinates, or a marker by its name; the markers are "-C", "A", "B", "crank middle"
    m.toml:68:16: springs[0].points[1]: there is no marker "C"
      help: give three coordinates, or a marker by its name; the markers are "-C", "A", "B", "crank middle"
    m.toml:79:6: sensors[0].at: there is no marker "C"
      help: give three coordinates, or a marker by its name; the markers are "-C", "A", "B", "crank middle"
    m.toml:89:16: sensors[2].points[1]: there is no marker "C"
      help: give three coordinates, or a marker by its name; the markers are "-C", "A", "B", "crank middle"
    "#);
    insta::assert_snapshot!(with("name = \"C\"\n", ""), @r#"
    m.toml:13:1: markers[2]: missing key "name"
      help: add "name", a string: Name of the marker: letters, digits, blanks, `_` and `-`; it begins with a letter, a digit or `_`.
    m.toml:58:6: joints[2].at: there is no marker "C"
      help: give three coordinates, or a marker by its name; the markers are "A", "B", "crank middle"
    m.toml:63:22: joints[3].points[1]: there is no marker "C"
      help: give three coordinates, or a marker by its name; the markers are "A", "B", "crank middle"
    m.toml:67:16: springs[0].points[1]: there is no marker "C"
      help: give three coordinates, or a marker by its name; the markers are "A", "B", "crank middle"
    m.toml:78:6: sensors[0].at: there is no marker "C"
      help: give three coordinates, or a marker by its name; the markers are "A", "B", "crank middle"
    m.toml:88:16: sensors[2].points[1]: there is no marker "C"
      help: give three coordinates, or a marker by its name; the markers are "A", "B", "crank middle"
    "#);
}

#[test]
fn mistakes_in_places_and_axes_of_markers_are_placed_and_hide_nothing() {
    insta::assert_snapshot!(with("at = [0, 0, 0]", "at = [0, nan, 0]"), @r#"
    m.toml:8:10: markers[0].at[1]: nan is not a finite number
      help: Point in the reference configuration, along the axes of space, or of `on` from its origin (length).
    "#);
    insta::assert_snapshot!(with("at = [0, 0, 0]", "at = \"B\""), @r#"
    m.toml:8:6: markers[0].at: expected a list of 3 numbers, found the string "B"
      help: Point in the reference configuration, along the axes of space, or of `on` from its origin (length).
    "#);
    insta::assert_snapshot!(with("at = [0, 0, 0]\n", ""), @r#"
    m.toml:6:1: markers[0]: missing key "at"
      help: add "at", a list of 3 numbers: Point in the reference configuration, along the axes of space, or of `on` from its origin (length).
    "#);
    insta::assert_snapshot!(with("at = [0, 0, 0]", "at = [0, 0, 0]\naxes = [[1, 1, 0], [-2, -2, 0]]"), @r#"
    m.toml:9:8: markers[0].axes: the two directions are parallel
      help: give two directions that span a plane
    "#);
    insta::assert_snapshot!(with("at = [0, 0, 0]", "at = [0, 0, 0]\naxes = [[1, 1, 0], [0, 0, 0]]"), @r#"
    m.toml:9:8: markers[0].axes[1]: the direction has length 0
      help: give a direction of any length above 0
    "#);
    insta::assert_snapshot!(super::with("title = \"t\"", "title = \"t\"\nmarkers = \"A\""), @r#"
    m.toml:2:11: markers: expected a list of tables, found the string "A"
      help: Points and axes with names, by which other keys give points and directions.
    "#);
    // The mass of a body is checked although the place of a joint is unknown.
    insta::assert_snapshot!(errors(&BY_MARKERS.replace("at = \"C\"", "at = \"Q\"").replace("mass = 2.0", "mass = -2.0")), @r#"
    m.toml:30:8: bodies[1].mass: the mass is -2; it must be above 0
      help: give a positive number in the model's units
    m.toml:59:6: joints[2].at: there is no marker "Q"
      help: give three coordinates, or a marker by its name; the markers are "A", "B", "C", "crank middle"
    m.toml:79:6: sensors[0].at: there is no marker "Q"
      help: give three coordinates, or a marker by its name; the markers are "A", "B", "C", "crank middle"
    "#);
}
