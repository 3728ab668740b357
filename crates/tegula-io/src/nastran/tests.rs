#![allow(clippy::unwrap_used)]

use std::path::Path;

use proptest::prelude::*;
use serde_json::Value;

use super::convert;
use crate::deck::{Deck, Diagnostic};

pub(super) const CONTROL: &str = "SOL 101\nCEND\nTITLE = A \"strip\"\nSPC = 1\nLOAD = 2\nBEGIN BULK\n";
/// Strip of two shells in the plane z = 0, normals along z.
const MESH: &str = "GRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nGRID,3,,2.,0.,0.\nGRID,4,,0.,1.,0.\nGRID,5,,1.,1.,0.\nGRID,6,,2.,1.,0.\n\
                    CQUAD4,1,3,1,2,5,4\nCQUAD4,2,3,2,3,6,5\n";
pub(super) const SECTION: &str = "PSHELL,3,4,0.5,4,,4\n";
const MATERIAL: &str = "MAT1,4,210.+3,,0.3,7.85-9,1.2-5\n";
pub(super) const SUPPORT: &str = "SPC1,1,123456,1,4\n";
pub(super) const LOAD: &str = "FORCE,2,3,,-2.,0.,0.,1.\nFORCE,2,6,,2.,0.,0.,-1.\n";

fn deck(parts: [&str; 6]) -> String {
    parts.concat()
}

pub(super) fn strip() -> String {
    deck([CONTROL, MESH, SECTION, MATERIAL, SUPPORT, LOAD])
}

pub(super) fn text_of(deck: &str) -> String {
    match convert(Path::new("strip.bdf"), deck.as_bytes(), "strip.bdf") {
        Ok(converted) => {
            assert_eq!(converted.text.lines().count(), converted.lines.len());
            converted.text
        }
        Err(errors) => panic!("{errors:#?}"),
    }
}

pub(super) fn model(deck: &str) -> Value {
    serde_json::to_value(Deck::parse("strip.toml", text_of(deck)).unwrap().model).unwrap()
}

fn warning(deck: &str) -> String {
    let found = convert(Path::new("strip.bdf"), deck.as_bytes(), "strip.bdf").unwrap().warnings;
    found.into_iter().map(|issue| issue.message).collect()
}

/// Messages of a deck, each with its line.
pub(super) fn mistakes(deck: &str) -> Vec<(usize, String)> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("strip.bdf");
    std::fs::write(&path, deck).unwrap();
    let found: Vec<Diagnostic> = match Deck::read(&path) {
        Err(found) => found,
        Ok(deck) => match crate::job::prepare(&deck) {
            Err(crate::job::JobError::Model(found)) => found,
            other => panic!("{:?}", other.err()),
        },
    };
    found.into_iter().map(|d| (d.line, d.message)).collect()
}

/// Asserts the first message of the strip with a replaced part, and that it stands on the line that holds `to`.
fn refused(from: &str, to: &str, message: &str) {
    let deck = strip().replacen(from, to, 1);
    assert_ne!(deck, strip(), "{from}");
    let (line, found) = mistakes(&deck).remove(0);
    assert!(found.starts_with(message), "{found}\nfor {message}");
    let last = to.trim_end().lines().last().unwrap();
    let expected: Vec<usize> =
        deck.lines().enumerate().filter(|(_, l)| *l == last).map(|(i, _)| i + 1).collect();
    assert!(
        line == 0 || expected.contains(&line) || expected.contains(&(line + 1)),
        "{found}: line {line}, not {expected:?}"
    );
}

pub(super) fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap()
}

/// Text without comments and empty lines, and without the table of the mesh.
fn plain(text: &str) -> Vec<String> {
    let lines = text.lines().map(|line| line.split("  #").next().unwrap().to_owned());
    let file = ["type = \"nastran\"", "type = \"abaqus\"", "file = \"strip."];
    lines
        .filter(|line| {
            !line.is_empty() && !line.starts_with('#') && !file.iter().any(|f| line.starts_with(f))
        })
        .collect()
}

#[test]
fn a_model_in_both_formats_is_one_model() {
    let keyword = "*HEADING\nA \"strip\"\n*NODE\n1, 0, 0\n2, 1, 0\n3, 2, 0\n4, 0, 1\n5, 1, 1\n6, 2, 1\n\
        *ELEMENT, TYPE=S4, ELSET=\"property 3\"\n1, 1, 2, 5, 4\n2, 2, 3, 6, 5\n\
        *NSET, NSET=\"SPC 123456\"\n1, 4\n*NSET, NSET=\"FORCE 2\"\n3, 6\n\
        *MATERIAL, NAME=material 4\n*ELASTIC\n210e3, 0.3\n*DENSITY\n7.85e-9\n*EXPANSION\n1.2e-5\n\
        *SHELL SECTION, ELSET=\"property 3\", MATERIAL=material 4\n0.5, 5\n*BOUNDARY\nSPC 123456, 1, 6\n\
        *STEP\n*STATIC\n*CLOAD\nFORCE 2, 3, -2.\n5, 1, 1.\n*DLOAD\n\"property 3\", P, 3.\n*END STEP\n";
    let path = Path::new("strip.inp");
    let other =
        crate::abaqus::convert(path, keyword.as_bytes(), "strip.inp").unwrap_or_else(|e| panic!("{e:#?}"));
    let own = format!("{}FORCE,2,5,,1.,1.,0.,0.\nPLOAD4,2,1,3.\nPLOAD2,2,3.,2\n", strip());
    let own = text_of(&own).replace("\"pressure 2\"", "\"property 3\"");
    assert_eq!(plain(&own), plain(&other.text));
    // Every format of the fields gives the same text.
    let small =
        strip().replace("GRID,2,,1.,0.,0.\n", "GRID    2               1.      0.      0.\n").replace(
            "MAT1,4,210.+3,,0.3,7.85-9,1.2-5\n",
            "MAT1*   4               2.1D5                           .3\n*       7.85-9          1.2E-5\n",
        );
    assert_eq!(plain(&text_of(&small)), plain(&text_of(&strip())));
}

#[test]
fn isotropic_constants_are_two_of_three() {
    let constants = |card: &str| {
        let found = model(&strip().replace(MATERIAL, card))["materials"]["material 4"].clone();
        (found["young"].as_f64().unwrap(), found["poisson"].as_f64().unwrap())
    };
    let near = |(a, b): (f64, f64), (c, d): (f64, f64)| (a / c - 1.0).abs() < 1e-12 && (b - d).abs() < 1e-12;
    assert!(near(constants("MAT1,4,200.,,0.25\n"), (200.0, 0.25)));
    assert!(near(constants("MAT1,4,200.,80.\n"), (200.0, 0.25)));
    assert!(near(constants("MAT1,4,,80.,0.25\n"), (200.0, 0.25)));
    assert!(near(constants("MAT1,4,200.,80.,0.25\n"), (200.0, 0.25)));
    refused(MATERIAL, "MAT1,4,200.,70.,0.25\n", "E is 200, but 2 (1 + NU) G is 175");
    refused(MATERIAL, "MAT1,4,200.\n", "MAT1 has fewer than two of E, G and NU");
    refused(MATERIAL, "MAT1,4,210000,,0.3\n", "E of MAT1 is \"210000\", which is no real number");
    refused(MATERIAL, "MAT1,4,200.,,0.3\nMAT1,4,200.,,0.3\n", "the material 4 is defined again");
    refused(MATERIAL, "MAT2,4,200.\n", "these cards are not read: MAT2 (line 16)");
    assert!(
        warning(&strip().replace(MATERIAL, "MAT1,4,200.,,.3,,,20.,.02\n"))
            .contains("GE of MAT1 (line 16), TREF of MAT1")
    );
}

#[test]
fn orthotropic_materials_have_the_direction_of_the_first_side() {
    let ply = "MAT8,4,140.,10.,.3,5.,4.,3.,1.6-9\n+,1.-6,2.-5\n";
    let strip = strip().replace(MATERIAL, ply);
    let found = model(&strip);
    let material = &found["materials"]["material 4"];
    assert_eq!(
        (&material["young"], &material["poisson"]),
        (&json("[140.0, 10.0, 10.0]"), &json("[0.3, 0.0, 0.0]"))
    );
    assert_eq!(
        (&material["shear"], &material["expansion"]),
        (&json("[5.0, 4.0, 3.0]"), &json("[1e-6, 2e-5, 2e-5]"))
    );
    let layup = &found["sections"][0]["layup"];
    assert_eq!((&layup["plies"][0]["angle"], &layup["direction"]), (&json("0.0"), &json("[1.0, 0.0, 0.0]")));
    // The angle runs from the side of the first two nodes about the normal; the second element begins at another corner.
    let turned = strip
        .replace("CQUAD4,1,3,1,2,5,4", "CQUAD4,1,3,1,2,5,4,90.")
        .replace("CQUAD4,2,3,2,3,6,5", "CQUAD4,2,3,3,6,5,2");
    assert_eq!(model(&turned)["sections"][0]["layup"]["direction"], json("[0.0, 1.0, 0.0]"));
    let sections = model(&turned.replace(",90.", ",30."))["sections"].clone();
    assert_eq!(
        (&sections[0]["on"], &sections[1]["on"]),
        (&"property 3 direction 1".into(), &"property 3 direction 2".into())
    );
    let direction = &sections[0]["layup"]["direction"];
    assert!(
        (direction[0].as_f64().unwrap() - 0.75_f64.sqrt()).abs() < 1e-12
            && (direction[1].as_f64().unwrap() - 0.5).abs() < 1e-12
    );
    let blank = strip.replace("5.,4.,3.", "5.,,3.");
    assert!(
        mistakes(&blank)[0]
            .1
            .starts_with("G1Z of MAT8 4 is blank or 0, which stands for rigid transverse shear")
    );
    let system = strip.replace("CQUAD4,1,3,1,2,5,4", "CQUAD4,1,3,1,2,5,4,9");
    assert!(mistakes(&system)[0].1.starts_with("a coordinate system MCID gives the axes"));
    let basic = turned.replace("1,2,5,4,90.", "1,2,5,4,0").replace("2,3,3,6,5,2", "2,3,3,6,5,2,0");
    assert_eq!(model(&basic)["sections"][0]["layup"]["direction"], json("[1.0, 0.0, 0.0]"));
    // It has no effect where the material has no axes.
    assert_eq!(
        model(&super::tests::strip().replace("1,2,5,4\n", "1,2,5,4,9\n"))["sections"][0]["thickness"],
        0.5
    );
}

#[test]
fn shells_are_refused_where_they_are_other_shells_in_nastran() {
    for (card, message) in [
        ("PSHELL,3,4,0.5,,,4\n", "MID2 of PSHELL 3 is blank: this is a membrane"),
        (
            "PSHELL,3,4,0.5,4\n",
            "MID3 of PSHELL 3 is blank: this is a plate that is rigid in transverse shear",
        ),
        ("PSHELL,3,4,0.5,5,,4\n", "MID2 of PSHELL 3 is 5, and MID1 is 4"),
        ("PSHELL,3,4,0.5,4,1.5,4\n", "12I/T**3 of PSHELL 3 is 1.5"),
        ("PSHELL,3,4,0.5,4,,4,1.\n", "TS/T of PSHELL 3 is 1, which is not read"),
        ("PSHELL,3,4,0.5,4,,4,,3.\n", "the mass NSM of PSHELL is 3."),
        ("PSHELL,3,4,0.5,4,,4\n,,,7\n", "the material MID4 of PSHELL is 7"),
        ("PSHELL,3,4,,4,,4\n", "the thickness T of PSHELL is missing"),
        ("PSHELL,3,7,.5,7,,7\n", "there is no material 7 among MAT1 and MAT8"),
        ("PSHELL,3,4,.5,4,,4\nPSHELL,3,4,.5,4,,4\n", "the property 3 is defined again"),
    ] {
        refused(SECTION, card, message);
    }
    let missing = mistakes(&strip().replace(SECTION, "PSHELL,8,4,.5,4,,4\n")).remove(0);
    assert_eq!(missing, (13, "element 1 needs the property 3, which the file does not define".into()));
    let full = strip().replace(SECTION, "PSHELL,3,4,0.5,4,1.,4,.833333,0.,+\n+,-.25,.25\n");
    assert_eq!(model(&full)["sections"][0]["thickness"], 0.5);
    assert!(warning(&full).contains("Z1 of PSHELL (line 16), Z2 of PSHELL (line 16)"), "{}", warning(&full));
}

#[test]
fn plies_run_from_the_bottom_to_the_top() {
    let layup = |card: &str| model(&strip().replace(SECTION, card))["sections"][0]["layup"].clone();
    let plies = |layup: &Value| -> Vec<(f64, f64)> {
        let plies = layup["plies"].as_array().unwrap().iter();
        plies.map(|ply| (ply["angle"].as_f64().unwrap(), ply["thickness"].as_f64().unwrap())).collect()
    };
    let two = layup("PCOMP,3,,,,,,,,+\n+,4,.1,0.,YES,4,.2,45.,NO\n");
    assert_eq!(plies(&two), [(0.0, 0.1), (45.0, 0.2)]);
    assert_eq!(two["offset"], json("0.0"));
    let same = layup("PCOMP,3,-.3,,,,,,SYM\n,4,.1,0.,,,,90.\n,,.2\n");
    assert_eq!(plies(&same), [(0.0, 0.1), (90.0, 0.1), (0.0, 0.2), (0.0, 0.2), (90.0, 0.1), (0.0, 0.1)]);
    let offset = layup("PCOMP,3,0.,,,,,,\n,4,.1,0.\n")["offset"].as_f64().unwrap();
    assert!((offset - 0.05).abs() < 1e-15, "{offset}");
    // Plies without axes have a direction, too: the x axis may be normal to them.
    assert_eq!(layup("PCOMP,3\n,4,.1\n")["direction"], json("[1.0, 0.0, 0.0]"));
    let bottom = layup("PCOMP,3,-.05,,,,,,\n,4,.1,0.\n");
    assert_eq!(bottom["offset"], json("0.0"));
    for (card, message) in [
        ("PCOMP,3,,1.\n,4,.1\n", "the mass NSM of PCOMP is 1."),
        ("PCOMP,3,,,,,,,MEM\n,4,.1\n", "LAM = MEM of PCOMP 3 is not read"),
        ("PCOMP,3\n", "PCOMP 3 has no plies"),
        ("PCOMP,3\n,,.1\n", "the first ply of PCOMP has no material"),
        ("PCOMP,3\n,4,.1,0.,MAYBE\n", "SOUT of PCOMP 3 is \"MAYBE\""),
    ] {
        let found = mistakes(&strip().replace(SECTION, card)).remove(0).1;
        assert!(found.starts_with(message), "{found}\nfor {message}");
    }
}

#[test]
fn constraints_of_a_node_are_taken_together() {
    for (cards, expected) in [
        ("SPC1,1,123456,1,THRU,4\n", r#"[{"type": "clamp", "on": "SPC 123456"}]"#),
        ("SPC1,1,123,1,4\nSPC1,1,456,4,1\n", r#"[{"type": "clamp", "on": "SPC 123456"}]"#),
        ("SPCADD,1,8,9\nSPC,8,1,123,,4,123\nSPC1,9,3,4,1\n", r#"[{"type": "spherical", "on": "SPC 123"}]"#),
        (
            "SPC1,1,6,1,2,3,4,5,6\nSPC1,1,3,1\n",
            r#"[{"type": "fix", "on": "SPC 36", "position": ["z"], "director": []}]"#,
        ),
        ("SPC1,1,4,1,4\n", r#"[{"type": "fix", "on": "SPC 4", "position": [], "director": ["y"]}]"#),
        ("SPC1,1,156,1,4\n", r#"[{"type": "symmetry", "on": "SPC 156", "normal": [1.0, 0.0, 0.0]}]"#),
        (
            "SPC,1,3,1,0.02\nSPC,7,3,2,5.\n",
            r#"[{"type": "prescribe", "on": "SPC 1", "of": "position", "component": "x", "value": 0.02}]"#,
        ),
        (
            "SPC1,1,3,1\nSPC,1,4,3,0.,2,3,0.5\n",
            r#"[{"type": "fix", "on": "SPC 3", "position": ["z"], "director": []},
                {"type": "prescribe", "on": "SPC 3 no 2", "of": "position", "component": "z", "value": 0.5}]"#,
        ),
    ] {
        assert_eq!(model(&strip().replace(SUPPORT, cards))["conditions"], json(expected), "{cards}");
    }
    let permanent =
        strip().replace(SUPPORT, "SPC1,1,1,1\n").replace("GRID,1,,0.,0.,0.", "GRID,1,,0.,0.,0.,,23");
    assert_eq!(model(&permanent)["conditions"], json(r#"[{"type": "spherical", "on": "SPC 123"}]"#));
    for (cards, message) in [
        ("SPC1,1,127,1\n", "\"127\" is not a list of degrees of freedom"),
        ("SPC1,1,123,1,99\n", "the file has no node 99"),
        ("SPC1,2,123,1\n", "there is no SPC or SPC1 of the set 1"),
        ("SPC,1,1,1,0.5\nSPC1,1,1,1\n", "degree of freedom 1 of node 1 gets 0, and 0.5 on line 17"),
        ("SPC,1,1,4,0.5\n", "the rotation 0.5 is prescribed"),
        ("SPC,1,1,1,5\n", "the displacement of SPC is \"5\", which is no real number"),
        ("SPC1,1,,1\n", "\"\" is not a list of degrees of freedom"),
    ] {
        let found = mistakes(&strip().replace(SUPPORT, cards)).remove(0).1;
        assert!(found.starts_with(message), "{found}\nfor {message}");
    }
}

#[test]
fn supports_at_a_fold_are_parted_by_normals() {
    // The second sheet stands on the first one along the line of the nodes 3 and 6.
    let folded = strip()
        .replace(
            "CQUAD4,2,3,2,3,6,5\n",
            "CQUAD4,2,3,2,3,6,5\nGRID,7,,2.,0.,1.\nGRID,8,,2.,1.,1.\nCQUAD4,3,3,3,7,8,6\n",
        )
        .replace(SUPPORT, "SPC1,1,246,1,2,3,7\nSPC1,1,123456,4\n");
    let found = model(&folded)["conditions"].clone();
    let all: Vec<(&Value, &Value)> =
        found.as_array().unwrap().iter().map(|c| (&c["type"], &c["on"])).collect();
    assert_eq!(all.len(), 4, "{found}");
    assert!(
        all.iter()
            .take(3)
            .all(|(kind, on)| *kind == "symmetry" && on.as_str().unwrap().starts_with("SPC 246")),
        "{found}"
    );
}

#[test]
fn loads_add_and_pressures_act_along_the_normal() {
    let loads = |control: &str, cards: &str| {
        let found = model(&strip().replace("LOAD = 2", control).replace(LOAD, cards))["loads"].clone();
        let list = found.as_array().unwrap().clone();
        list.iter().map(|l| (l["type"].clone(), l["on"].clone(), l["value"].clone())).collect::<Vec<_>>()
    };
    let of = |kind: &str, on: &str, value: &str| (Value::from(kind), Value::from(on), json(value));
    // N is no unit vector, and forces of one node add.
    let twice =
        loads("LOAD = 2", "FORCE,2,3,0,2.,0.,0.,3.\nFORCE,2,3,,1.,1.,0.,0.\nMOMENT,2,6,,2.,0.,4.,0.\n");
    assert_eq!(twice, [of("force", "3", "[1.0, 0.0, 6.0]"), of("moment", "6", "[0.0, 8.0, 0.0]")]);
    let pressure = loads("LOAD = 2", "PLOAD4,2,1,3.,3.,,,THRU,2\nPLOAD2,2,1.,1\n");
    assert_eq!(pressure, [of("pressure", "1", "-4.0"), of("pressure", "2", "-3.0")]);
    let combined = loads(
        "LOAD = 9",
        "LOAD,9,2.,3.,2,-1.,5\n,.5,6\nFORCE,2,3,,1.,1.,0.,0.\nPLOAD4,5,2,1.\nGRAV,6,,10.,0.,3.,-4.\n",
    );
    let mut gravity = of("gravity", "", "[0.0, 30.0, -40.0]");
    gravity.1 = Value::Null;
    assert_eq!(combined, [of("force", "3", "[6.0, 0.0, 0.0]"), of("pressure", "2", "2.0"), gravity]);
    for (cards, message) in [
        ("FORCE,2,3,5,2.,1.\n", "the coordinate system of FORCE is 5"),
        ("FORCE,2,3,,2,1.\n", "the scale factor of FORCE is \"2\""),
        ("FORCE,2,33,,2.,1.\n", "the file has no node 33"),
        ("FORCE,3,3,,2.,1.\n", "there are no loads of the set 2"),
        ("LOAD,2,1.,1.,3\nFORCE,2,3,,2.,1.\n", "LOAD 2 has the number of a load set"),
        ("LOAD,2,1.,1.,3\n", "there are no loads of the set 3"),
        ("PLOAD4,2,1,3.,2.\n", "the pressure at corner 2 is 2, and 3 at the first one"),
        ("PLOAD4,2,1,3.\n,,1.,0.,0.\n", "\"1.\" of PLOAD4 is not read"),
        ("PLOAD4,2,9,3.\n", "the file has no element 9"),
        ("PLOAD4,2,1,3.,,,,5,6\n", "the fields 8 and 9 of PLOAD4"),
        ("PLOAD,2,1.,1,2,5,4\n", "these cards are not read: PLOAD (line 18)"),
    ] {
        let found = mistakes(&strip().replace(LOAD, cards)).remove(0).1;
        assert!(found.starts_with(message), "{found}\nfor {message}");
    }
}

#[test]
fn rigid_elements_are_rigid_patches() {
    let rigid = strip().replace(
        LOAD,
        "GRID,9,,3.,.5,0.\nRBE2,1,9,123456,3,6\nFORCE,2,9,,1.,0.,0.,2.\nMOMENT,2,9,,1.,3.,0.,0.\n",
    );
    let found = model(&rigid);
    let body = &found["bodies"][0];
    assert_eq!((&body["name"], &body["at"]), (&"RBE2 1".into(), &json("[3.0, 0.5, 0.0]")));
    assert_eq!(body["attached"], json("[\"nodes of RBE2 1\"]"));
    assert_eq!(
        (&found["loads"][0]["on"], &found["loads"][1]["value"]),
        (&"RBE2 1".into(), &json("[3.0, 0.0, 0.0]"))
    );
    let held = model(&rigid.replace(SUPPORT, "SPC1,1,123456,1,4,9\n"));
    assert_eq!(
        (&held["joints"][0]["type"], &held["conditions"][0]["type"]),
        (&"fixed".into(), &"clamp".into())
    );
    assert_eq!(model(&rigid.replace(SUPPORT, "SPC1,1,123,1,4,9\n"))["joints"][0]["type"], "spherical");
    for (from, to, message) in [
        ("123456,3,6", "123,3,6", "RBE2 holds the degrees of freedom \"123\""),
        ("123456,3,6", "123456,3,77", "RBE2 1 needs node 77"),
        ("123456,3,6", "123456,3,6,1.-5", "the thermal expansion of RBE2 is not read"),
        ("SPC1,1,123456,1,4", "SPC1,1,123456,1,4,3", "node 3 is supported, and RBE2 1 of line"),
        (
            "SPC1,1,123456,1,4",
            "SPC1,1,123456,1,4\nSPC,1,9,3,.1",
            "the displacement 0.1 of RBE2 1 is prescribed",
        ),
        ("RBE2", "RBE3", "field 3 of RBE3 is 9"),
        (
            "RBE2,1,9,123456,3,6",
            "RBE2,1,9,123456,3\nRBE2,2,9,123456,6",
            "RBE2 2 has the same number or the same independent node as the RBE2 on line 19",
        ),
    ] {
        let found = mistakes(&rigid.replacen(from, to, 1)).remove(0).1;
        assert!(found.starts_with(message), "{found}\nfor {message}");
    }
}

#[test]
fn solution_sequences_are_analyses() {
    let analysis =
        |control: &str, cards: &str| model(&strip().replace(CONTROL, control).replace(LOAD, cards));
    let linear = model(&strip())["analysis"].clone();
    assert_eq!((&linear["type"], &linear["linear"]), (&"static".into(), &true.into()));
    let modes =
        analysis("SOL 103\nCEND\nSPC = 1\nMETHOD = 7\nBEGIN BULK\n", "EIGRL,7,,,5\n")["analysis"].clone();
    assert_eq!((&modes["type"], &modes["modes"]), (&"modal".into(), &5.into()));
    let buckling = "SOL SEBUCKL\nCEND\nSPC = 1\nSUBCASE 1\nLOAD = 2\nSUBCASE 2\nMETHOD = 7\nBEGIN BULK\n";
    let found = analysis(buckling, &format!("{LOAD}EIGRL,7,,,3\n"));
    assert_eq!((&found["analysis"]["factors"], &found["analysis"]["signs"]), (&3.into(), &"both".into()));
    assert_eq!(found["loads"][0]["value"], json("[0.0, 0.0, -2.0]"));
    let large =
        "SOL 106\nCEND\nSPC = 1\nLOAD = 2\nNLPARM = 8\nBEGIN BULK\nPARAM,LGDISP,1\nNLPARM,8,4,,AUTO\n";
    let found = analysis(large, LOAD)["analysis"].clone();
    assert_eq!((&found["linear"], &found["load_steps"]), (&false.into(), &4.into()));
    let small = analysis(&large.replace("PARAM,LGDISP,1\n", ""), LOAD)["analysis"].clone();
    assert_eq!(small["linear"], true);
    assert_eq!(
        analysis(&large.replace("PARAM,LGDISP,1\n", "").replace("106", "400"), LOAD)["analysis"]["linear"],
        false
    );
    let two = "SOL 101\nCEND\nSPC = 1\nSUBCASE 1\nLOAD = 2\nSUBCASE 5\nLOAD = 3\nBEGIN BULK\n";
    let steps = analysis(two, &format!("{LOAD}FORCE,3,3,,1.,1.,0.,0.\n"))["steps"].clone();
    assert_eq!((&steps[0]["name"], &steps[1]["name"]), (&"subcase 1".into(), &"subcase 5".into()));
    assert_eq!(
        (&steps[1]["loads"][0]["value"], &steps[1]["loads"][1]),
        (&json("[1.0, 0.0, 0.0]"), &Value::Null)
    );
}

#[test]
fn control_that_is_not_read_is_refused() {
    for (control, message) in [
        ("SOL 144\nCEND\nBEGIN BULK\n", "SOL 144 is not read"),
        ("CEND\nBEGIN BULK\n", "the file has no SOL"),
        (
            "RESTART\nSOL 101\nCEND\nBEGIN BULK\n",
            "the statement RESTART of the executive control is not read",
        ),
        (
            "SOL 101\nCEND\nMPC = 3\nTEMPERATURE(LOAD) = 4\nBEGIN BULK\n",
            "these commands of the case control are not read: MPC (line 3), TEMPERATURE (line 4)",
        ),
        ("SOL 101\nCEND\nLOAD = two\nBEGIN BULK\n", "LOAD is \"two\""),
        ("SOL 103\nCEND\nSPC = 1\nBEGIN BULK\n", "there is no METHOD"),
        ("SOL 103\nCEND\nSPC = 1\nMETHOD = 7\nBEGIN BULK\n", "there is no EIGRL or EIGR 7"),
        (
            "SOL 103\nCEND\nSPC = 1\nMETHOD = 7\nBEGIN BULK\nEIGRL,7,,99.\n",
            "the number ND of modes of EIGRL is missing",
        ),
        (
            "SOL 103\nCEND\nSPC = 1\nMETHOD = 7\nBEGIN BULK\nEIGRL,7,5.,99.,3\n",
            "EIGRL asks for modes above 5",
        ),
        ("SOL 105\nCEND\nSPC = 1\nLOAD = 2\nBEGIN BULK\n", "SOL 105 has two subcases here"),
        (
            "SOL 101\nCEND\nSUBCASE 1\nSPC = 1\nLOAD = 2\nSUBCASE 2\nLOAD = 2\nBEGIN BULK\n",
            "subcase 2 has other supports than the first one",
        ),
        ("SOL 101\nCEND\nSPC = 1\nBEGIN BULK\nPARAM,WTMASS,.00259\n", "PARAM,WTMASS is .00259"),
        ("SOL 101\nCEND\nSPC = 1\nBEGIN BULK\nPARAM,LGDISP,2\n", "PARAM,LGDISP is 2"),
        ("SOL 101\nCEND\nSPC = 1\nBEGIN BULK\nPARAM,INREL,-1\n", "PARAM,INREL is not read"),
        ("SOL 101\nCEND\nSPC = 1\nBEGIN BULK\nPARAM,XYZ,-1\n", "PARAM,XYZ is not read"),
    ] {
        let found = mistakes(&strip().replace(CONTROL, control)).remove(0).1;
        assert!(found.starts_with(message), "{found}\nfor {message}");
    }
}

#[test]
fn requests_are_named_in_a_warning_but_for_displacements_of_few_nodes() {
    let control = CONTROL.replace(
        "BEGIN BULK\n",
        "SET 4 = 3,\n6\nDISP(PLOT) = 4\nSTRESS = ALL\nSPCF = ALL\nBEGIN BULK\nPARAM,AUTOSPC,YES\nPARAM,K6ROT,100.\nPARAM,WTMASS,1.\nCORD2R,1\n",
    );
    let deck = strip().replace(CONTROL, &control);
    let points = model(&deck)["output"]["points"].clone();
    assert_eq!((&points[0]["name"], &points[1]["on"]), (&"node 3".into(), &"6".into()));
    assert_eq!(
        warning(&deck),
        "parts of the input file without effect: CORD2R (line 15), PARAM,AUTOSPC (line 12), PARAM,K6ROT (line 13), PARAM,WTMASS (line 14), SPCFORCES (line 10), STRESS (line 9)"
    );
    assert_eq!(warning(&strip()), "");
    // A title that ends with a comma swallows no command.
    let comma = model(&strip().replace("A \"strip\"", "Strip,"));
    assert_eq!((&comma["title"], comma["conditions"].as_array().unwrap().len()), (&"Strip,".into(), 1));
}

#[test]
fn unknown_cards_are_listed_with_their_lines() {
    let found = mistakes(&format!("{}TEMPD,1,20.\nTEMP,1,2,20.\nTEMPD,2,20.\n", strip()));
    let base = strip().lines().count();
    let list = format!(
        "these cards are not read: TEMP (line {}), TEMPD (lines {}, {})",
        base + 2,
        base + 1,
        base + 3
    );
    assert_eq!(found, [(base + 1, list)]);
}

#[test]
fn mistakes_of_the_model_stand_on_the_lines_of_the_input_file() {
    refused(SECTION, "PSHELL,3,4,-0.5,4,,4\n", "");
    // A moment about the normal is an error of the model.
    let drilling = strip().replace(LOAD, "MOMENT,2,3,,1.,0.,0.,1.\n");
    let line = drilling.lines().position(|line| line.starts_with("MOMENT")).unwrap() + 1;
    let found = mistakes(&drilling).remove(0);
    assert!(found.0.abs_diff(line) <= 1, "{found:?}");
}

#[test]
fn a_converted_model_is_the_model_of_the_input_file() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["strip.bdf", "strip.NAS", "strip.dat"] {
        let path = folder.path().join(name);
        std::fs::write(&path, strip()).unwrap();
        let direct = Deck::read(&path).unwrap();
        let written = folder.path().join(format!("{name}.toml"));
        std::fs::write(&written, &Deck::convert(&path, name).unwrap().text).unwrap();
        let again = Deck::read(&written).unwrap();
        assert_eq!(direct.model, again.model);
        let (a, b) = (crate::job::prepare(&direct).unwrap(), crate::job::prepare(&again).unwrap());
        assert_eq!((a.fingerprint, a.mesh.quads.len()), (b.fingerprint, 2));
    }
}

proptest! {
    #[test]
    fn damaged_decks_never_panic(at in 0_usize..700, with in "[*+,=0-9a-zA-Z .$\t\n-]{0,12}", cut in 0_usize..30) {
        let deck = strip();
        let start = at.min(deck.len());
        let end = (start + cut).min(deck.len());
        let damaged = format!("{}{with}{}", &deck[..start], &deck[end..]);
        if let Ok(converted) = convert(Path::new("strip.bdf"), damaged.as_bytes(), "strip.bdf") {
            let _ = Deck::parse("strip.toml", converted.text);
        }
    }

    #[test]
    fn damaged_examples_never_panic(at in 0_usize..40000, byte in any::<u8>(), cut in 0_usize..60) {
        let mut deck = include_bytes!("../../../../examples/box_beam.bdf").to_vec();
        let start = at.min(deck.len());
        let end = (start + cut).min(deck.len());
        deck.splice(start..end, [byte]);
        if let Ok(converted) = convert(Path::new("strip.bdf"), &deck, "strip.bdf") {
            let _ = Deck::parse("strip.toml", converted.text);
        }
    }
}
