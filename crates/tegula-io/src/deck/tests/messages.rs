#![allow(clippy::unwrap_used)]

//! Every message of the validator, word for word.

use super::with;

#[test]
fn unknown_keys_come_with_the_one_that_was_meant() {
    insta::assert_snapshot!(with("thickness", "tickness"), @r#"
    m.toml:16:1: sections[0].tickness: unknown key "tickness"
      help: did you mean "thickness"?
    "#);
    insta::assert_snapshot!(with("[analysis]", "[analisis]"), @r#"
    m.toml:2:2: analisis: unknown key "analisis"
      help: did you mean "analysis"?
    "#);
    insta::assert_snapshot!(with("type = \"static\"\n", "typ = \"static\"\n"), @r#"
    m.toml:3:1: analysis.typ: unknown key "typ"
      help: did you mean "type"?
    "#);
    insta::assert_snapshot!(with("load_steps = 4", "end_time = 4.0"), @r#"
    m.toml:4:1: analysis.end_time: unknown key "end_time"
      help: "end_time" is a key of the type "transient", not of "static"
    "#);
    insta::assert_snapshot!(with("load_steps = 4", "[damping]\nmas=1\n"), @r#"
    m.toml:5:1: damping.mas: unknown key "mas"
      help: did you mean "mass"?
    "#);
    insta::assert_snapshot!(with("load_steps = 4", "damping = {mass=1}\n"), @r#"
    m.toml:4:1: analysis.damping: unknown key "damping"
      help: it belongs to the top level of the file: [damping]
    "#);
    insta::assert_snapshot!(with("load_steps = 4", "loads = []"), @r#"
    m.toml:4:1: analysis.loads: unknown key "loads"
      help: it belongs to the top level of the file: [[loads]]
    "#);
    insta::assert_snapshot!(with("load_steps = 4", "title = \"x\""), @r#"
    m.toml:4:1: analysis.title: unknown key "title"
      help: it belongs to the top level of the file, before the first [table]
    "#);
    insta::assert_snapshot!(with("load_steps = 4", "xyzzy = \"x\""), @r#"
    m.toml:4:1: analysis.xyzzy: unknown key "xyzzy"
      help: the keys here are "type", "linear", "method", "load_steps", "max_iterations", "max_cutbacks", "allow_unstable", "inertia_relief", "linear_solver", "stop", "continue"
    "#);
    insta::assert_snapshot!(with("[mesh.grid]\n", ""), @r#"
    m.toml:8:1: mesh.elements: unknown key "elements"
      help: it belongs into the table "grid": grid.elements
    "#);
    insta::assert_snapshot!(with("thickness = 0.1", "thickness = 0.1\nyoung = 3.0"), @r#"
    m.toml:17:1: sections[0].young: unknown key "young"
      help: "young" is a key of "materials"; here there are "on", "element", "material", "thickness", "thickness_distribution", "layup", "shear_correction", "shear_stabilization", "ans_shear", "ans_thickness", "eas", "membrane", "thickness_eas", "thickness_points", "total_mass", "retardation_time"
    "#);
    insta::assert_snapshot!(with("[output]\ninterval = 0.1", "output = 3"), @r#"
    m.toml:25:1: loads[0].output: unknown key "output"
      help: it belongs to the top level of the file: [output]
    "#);
    insta::assert_snapshot!(with("[output]\ninterval = 0.1", "[analysis.scheme]\n"), @r#"
    m.toml:25:11: analysis.scheme: unknown key "scheme"
      help: "scheme" is a key of the type "transient", not of "static"
    "#);
    insta::assert_snapshot!(with("interval = 0.1", "\"a b\" = 3"), @r#"
    m.toml:26:1: output."a b": unknown key "a b"
      help: the keys here are "points", "cuts", "fields", "interval", "every", "at", "deformed", "units", "pictures", "stills"
    "#);
    insta::assert_snapshot!(with("[materials.steel]", "[materials.\"my.steel\"]\nw = 1"), @r#"
    m.toml:11:1: materials."my.steel".w: unknown key "w"
      help: the keys here are "type", "young", "poisson", "density", "expansion", "strength"
    "#);
    insta::assert_snapshot!(with("[output]", "[output]\nname = 3"), @r#"
    m.toml:26:1: output.name: unknown key "name"
      help: the keys here are "points", "cuts", "fields", "interval", "every", "at", "deformed", "units", "pictures", "stills"
    "#);
}

#[test]
fn missing_keys_are_named_with_what_they_are() {
    insta::assert_snapshot!(with("value = [0, 0, 4e4]\n", ""), @r#"
    m.toml:21:1: loads[0]: missing key "value"
      help: add "value", a list of 3 numbers: The load as a vector `[x, y, z]` in global axes: force, moment, or either per length or area.
    "#);
    insta::assert_snapshot!(with("type = \"static\"\n", ""), @r#"
    m.toml:2:1: analysis: missing key "type"
      help: add "type", one of "static", "path", "modal", "buckling", "transient"
    "#);
    insta::assert_snapshot!(with("interval = 0.1", "points = [{ name = \"a\" , at = [1,2]}, {on = \"b\"}]"), @r#"
    m.toml:26:31: output.points[0].at: expected 3 numbers, found 2
      help: Position in the reference configuration (length); the nearest node is taken.
    m.toml:26:39: output.points[1]: missing key "name"
      help: add "name", a string: Name of the point in histories, plots and `summary.json`.
    "#);
}

#[test]
fn unknown_words_come_with_the_allowed_ones() {
    insta::assert_snapshot!(with("\"static\"\nload_steps = 4", "\"statik\""), @r#"
    m.toml:3:8: analysis.type: unknown type "statik"
      help: did you mean "static"? (one of "static", "path", "modal", "buckling", "transient")
    "#);
    insta::assert_snapshot!(with("load_steps = 4", "method = \"mixd\""), @r#"
    m.toml:4:10: analysis.method: unknown value "mixd"
      help: did you mean "mixed"? (one of "mixed", "displacement")
    "#);
    insta::assert_snapshot!(with("load_steps = 4", "method = \"abc\""), @r#"
    m.toml:4:10: analysis.method: unknown value "abc"
      help: one of "mixed", "displacement"
    "#);
    insta::assert_snapshot!(with("[\"x\"]", "[\"w\"]"), @r#"
    m.toml:20:13: conditions[0].position[0]: unknown value "w"
      help: one of "x", "y", "z"
    "#);
    insta::assert_snapshot!(with("interval = 0.1", "fields = [\"velocity\", \"von_mises\", 3]"), @r#"
    m.toml:26:23: output.fields[1]: unknown value "von_mises"
      help: did you mean "von-mises"? (one of "displacement", "director", "velocity", "reaction", "membrane", "bending", "shear", "surface-stress", "von-mises", "energy-density", "ply-stress", "failure", "plastic-strain", "principal-stress", "nodal-means", "axes", "numbers")
    m.toml:26:36: output.fields[2]: expected a string, found the integer 3
      help: one of "displacement", "director", "velocity", "reaction", "membrane", "bending", "shear", "surface-stress", "von-mises", "energy-density", "ply-stress", "failure", "plastic-strain", "principal-stress", "nodal-means", "axes", "numbers"
    "#);
    insta::assert_snapshot!(with("type = \"isotropic\"\nyoung = 210e9", "type = \"orthotropik\""), @r#"
    m.toml:11:8: materials.steel.type: unknown type "orthotropik"
      help: did you mean "orthotropic"? (one of "isotropic", "orthotropic", "neo-hookean", "mooney-rivlin", "plastic")
    "#);
}

#[test]
fn numbers_have_to_be_in_range_and_finite() {
    insta::assert_snapshot!(with("load_steps = 4", "load_steps = -4"), @r#"
    m.toml:4:14: analysis.load_steps: -4 is out of range
      help: give an integer from 1 to 4294967295
    "#);
    insta::assert_snapshot!(with("load_steps = 4", "load_steps = 99999999999999999999999999999999999999999999999999"), @r#"
    m.toml:4:14: analysis.load_steps: 9999999999999999999999999999999999999999… is out of range
      help: give an integer from 1 to 4294967295
    "#);
    insta::assert_snapshot!(with("young = 210e9", "young = inf"), @r#"
    m.toml:12:9: materials.steel.young: inf is not a finite number
      help: Young's modulus E [force/area], above 0.
    "#);
    insta::assert_snapshot!(with("young = 210e9", "young = -nan"), @r#"
    m.toml:12:9: materials.steel.young: -nan is not a finite number
      help: Young's modulus E [force/area], above 0.
    "#);
    insta::assert_snapshot!(with("young = 210e9", "young = 1e999"), @r#"
    m.toml:12:9: materials.steel.young: the number 1e999 is too large
      help: give a number below 1.7e308
    "#);
    insta::assert_snapshot!(with("young = 210e9", "young = 100000000000000000000"), @r#"
    m.toml:12:9: materials.steel.young: the integer 100000000000000000000 is too large
      help: write it with an exponent, such as 1e20
    "#);
    insta::assert_snapshot!(with("elements = [16, 2]", "elements = [16, -2]"), @r#"
    m.toml:9:17: mesh.grid.elements[1]: -2 is out of range
      help: give an integer from 1 to 4294967295
    "#);
}

#[test]
fn tables_and_lists_are_told_apart() {
    insta::assert_snapshot!(with("size = [10, 1.0]", "size = [10, 1.0, 3]"), @r#"
    m.toml:7:8: mesh.size: expected 2 numbers, found 3
      help: Lengths along u and v (length).
    "#);
    insta::assert_snapshot!(with("size = [10, 1.0]", "size = 10"), @r#"
    m.toml:7:8: mesh.size: expected a list of 2 numbers, found the integer 10
      help: Lengths along u and v (length).
    "#);
    insta::assert_snapshot!(with("[materials.steel]", "[materials]"), @r#"
    m.toml:11:1: materials: expected a table for each name, found the key "type"
      help: put a name of your choice into the header: [materials.NAME]
    "#);
    insta::assert_snapshot!(with("[materials.steel]", "[[materials]]"), @r#"
    m.toml:10:1: materials: expected a table of things by name, found a list
      help: write a table for each, with a name of your choice: [materials.NAME]
    "#);
    insta::assert_snapshot!(with("[[sections]]", "[sections]"), @r#"
    m.toml:14:1: sections: expected a list of tables, found a table
      help: write the header with double brackets, once for each entry: [[sections]]
    "#);
    insta::assert_snapshot!(with("[mesh.grid]", "[[mesh.grid]]"), @r#"
    m.toml:8:1: mesh.grid: expected a table, found a list
      help: write the header with single brackets, once: [mesh.grid]
    "#);
    insta::assert_snapshot!(with("[\"x\"]", "\"x\""), @r#"
    m.toml:20:12: conditions[0].position: expected a list of strings, found the string "x"
      help: write it in brackets: ["x"]
    "#);
    insta::assert_snapshot!(with("type = \"static\"\nload_steps = 4", "type = \"transient\"\nend_time = 1\nscheme = \"hht\""), @r#"
    m.toml:5:10: analysis.scheme: expected a table, found the string "hht"
      help: write it as a table: scheme = { type = "hht", … }
    "#);
}

#[test]
fn values_have_to_be_of_the_right_kind() {
    insta::assert_snapshot!(with("type = \"static\"\n", "type = 3\n"), @r#"
    m.toml:3:8: analysis.type: expected a string, found the integer 3
      help: one of "static", "path", "modal", "buckling", "transient"
    "#);
    insta::assert_snapshot!(with("load_steps = 4", "load_steps = 4.0"), @r#"
    m.toml:4:14: analysis.load_steps: expected an integer, found the number 4.0
      help: write it without a point: 4
    "#);
    insta::assert_snapshot!(with("load_steps = 4", "load_steps = 4.5"), @r#"
    m.toml:4:14: analysis.load_steps: expected an integer, found the number 4.5
      help: Load steps to begin with; a step that does not converge is cut back by itself.
    "#);
    insta::assert_snapshot!(with("load_steps = 4", "load_steps = \"4\""), @r#"
    m.toml:4:14: analysis.load_steps: expected an integer, found the string "4"
      help: write it without quotes: 4
    "#);
    insta::assert_snapshot!(with("load_steps = 4", "method = 3"), @r#"
    m.toml:4:10: analysis.method: expected a string, found the integer 3
      help: one of "mixed", "displacement"
    "#);
    insta::assert_snapshot!(with("load_steps = 4", "linear = \"true\""), @r#"
    m.toml:4:10: analysis.linear: expected true or false, found the string "true"
      help: write true or false, without quotes
    "#);
    insta::assert_snapshot!(with("size = [10, 1.0]", "size = [10, \"1\"]"), @r#"
    m.toml:7:13: mesh.size[1]: expected a number, found the string "1"
      help: write it without quotes: 1
    "#);
    insta::assert_snapshot!(with("size = [10, 1.0]", "size = [10, \"1,5\"]"), @r#"
    m.toml:7:13: mesh.size[1]: expected a number, found the string "1,5"
      help: write it without quotes, with a decimal point: 1.5
    "#);
    insta::assert_snapshot!(with("young = 210e9", "young = 1979-05-27"), @r#"
    m.toml:12:9: materials.steel.young: expected a number, found a date
      help: Young's modulus E [force/area], above 0.
    "#);
    insta::assert_snapshot!(with("on = \"u_min\"", "on = 3"), @r#"
    m.toml:19:6: conditions[0].on: expected a string, found the integer 3
      help: write it in quotes: "3"
    "#);
    insta::assert_snapshot!(with("load_steps = 4", "method = false"), @r#"
    m.toml:4:10: analysis.method: expected a string, found false
      help: one of "mixed", "displacement"
    "#);
    insta::assert_snapshot!(with("size = [10, 1.0]", "size = [10, [1]]"), @r#"
    m.toml:7:13: mesh.size[1]: expected a number, found a list
      help: Lengths along u and v (length).
    "#);
}

#[test]
fn springs_and_torsion_springs_have_formulas_of_their_own() {
    let spring = |keys: &str| {
        let table = format!(
            "[[springs]]\nname = \"mount\"\nbetween = [\"ground\", \"u_max_v_max\"]\npoints = [[0.0, 0.0, 1.0], [1.0, 1.0, 0.0]]\n{keys}"
        );
        with("[output]\ninterval = 0.1", &table)
    };
    assert_eq!(spring("force = \"20*x\""), "");
    insta::assert_snapshot!(spring("moment = \"20*x\""), @r#"
    m.toml:29:1: springs[0].moment: unknown key "moment"
      help: "moment" is a key of "torsion_springs"; here there are "name", "between", "points", "stiffness", "damping", "force", "across", "length"
    "#);
}
