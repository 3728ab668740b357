#![allow(clippy::unwrap_used)]

use std::path::Path;

use proptest::prelude::*;
use tegula::Model;

use super::convert;
use crate::deck::{Deck, Diagnostic};

/// Strip of two shells in the plane z = 0, normals along z.
const MESH: &str = "*HEADING\nA \"strip\"\n*NODE, NSET=NALL\n1, 0, 0\n2, 1, 0\n3, 2, 0\n4, 0, 1\n5, 1, 1\n6, 2, 1\n\
                    *ELEMENT, TYPE=S4, ELSET=Strip\n1, 1, 2, 5, 4\n2, 2, 3, 6, 5\n*NSET, NSET=Root\n1, 4\n*NSET, NSET=Tip\n3, 6\n\
                    *MATERIAL, NAME=Steel\n*ELASTIC\n210e3, 0.3\n*DENSITY\n7.85e-9\n*EXPANSION\n1.2e-5\n\
                    *SHELL SECTION, ELSET=STRIP, MATERIAL=STEEL\n0.5, 5\n";
const SUPPORT: &str = "*BOUNDARY\nROOT, 1, 6\n";
const STEP: &str = "*STEP, NLGEOM\n*STATIC\n0.25, 1.\n*CLOAD\nTIP, 3, -2.\n*END STEP\n";

/// Text of the model file of the strip with these supports and steps.
fn text(supports: &str, steps: &str) -> String {
    let deck = format!("{MESH}{supports}{steps}");
    let path = Path::new("strip.inp");
    match convert(path, deck.as_bytes(), "strip.inp") {
        Ok(converted) => {
            assert_eq!(converted.text.lines().count(), converted.lines.len());
            converted.text
        }
        Err(errors) => panic!("{errors:#?}"),
    }
}

fn model(supports: &str, steps: &str) -> Model {
    Deck::parse("strip.toml", text(supports, steps)).unwrap().model
}

/// Part of the model as JSON.
fn part(supports: &str, steps: &str, key: &str) -> serde_json::Value {
    serde_json::to_value(model(supports, steps)).unwrap()[key].clone()
}

pub(super) fn json(text: &str) -> serde_json::Value {
    serde_json::from_str(text).unwrap()
}

/// Messages of a deck, each with its line.
pub(super) fn mistakes(deck: &str) -> Vec<(usize, String)> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("strip.inp");
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

/// First mistake of the strip with these supports and steps: its line behind the mesh, and the message.
fn mistake(supports: &str, steps: &str) -> (usize, String) {
    let (line, message) = mistakes(&format!("{MESH}{supports}{steps}")).remove(0);
    (line - MESH.lines().count(), message)
}

#[test]
fn materials_and_sections_are_those_of_the_cards() {
    let strip = model(SUPPORT, STEP);
    assert_eq!(strip.title, "A \"strip\"");
    let materials = part(SUPPORT, STEP, "materials");
    let steel = &materials["Steel"];
    assert_eq!(steel["type"], "isotropic");
    for (key, value) in [("young", 210e3), ("poisson", 0.3), ("density", 7.85e-9), ("expansion", 1.2e-5)] {
        assert_eq!(steel[key], value, "{key}");
    }
    let section = &part(SUPPORT, STEP, "sections")[0];
    assert_eq!((&section["on"], &section["material"]), (&"Strip".into(), &"Steel".into()));
    assert_eq!(section["thickness"], 0.5);
    let analysis = part(SUPPORT, STEP, "analysis");
    assert_eq!((&analysis["type"], &analysis["load_steps"]), (&"static".into(), &4.into()));
    assert_eq!(analysis["linear"], false);
}

#[test]
fn orthotropic_constants_and_plies_are_read() {
    let ply = "*MATERIAL, NAME=P\n*ELASTIC, TYPE=ENGINEERING CONSTANTS\n140e3, 10e3, 9e3, .3, .2, .4, 5e3, 4e3,\n3e3\n\
               *MATERIAL, NAME=L\n*ELASTIC, TYPE=LAMINA\n100., 10., .25, 5., 4., 3.\n";
    let composite = MESH.replace(
        "*SHELL SECTION, ELSET=STRIP, MATERIAL=STEEL\n0.5, 5\n",
        &format!("{ply}*SHELL SECTION, ELSET=Strip, COMPOSITE\n0.1, 3, P, 45.\n0.2, , l\n"),
    );
    let deck = format!("{composite}{SUPPORT}{STEP}");
    let converted = convert(Path::new("strip.inp"), deck.as_bytes(), "strip.inp").unwrap();
    let model = serde_json::to_value(Deck::parse("m.toml", converted.text).unwrap().model).unwrap();
    let p = &model["materials"]["P"];
    assert_eq!(p["young"], json("[140e3, 10e3, 9e3]"));
    assert_eq!((&p["poisson"], &p["shear"]), (&json("[0.3, 0.2, 0.4]"), &json("[5e3, 4e3, 3e3]")));
    let l = &model["materials"]["L"];
    assert_eq!((&l["young"], &l["poisson"]), (&json("[100.0, 10.0, 10.0]"), &json("[0.25, 0.0, 0.0]")));
    let plies = &model["sections"][0]["layup"]["plies"];
    assert_eq!((&plies[0]["angle"], &plies[0]["thickness"]), (&json("45.0"), &json("0.1")));
    assert_eq!((&plies[1]["material"], &plies[1]["angle"]), (&"L".into(), &json("0.0")));
}

#[test]
fn supports_have_their_counterparts() {
    for (lines, expected) in [
        ("Root, 1, 6", r#"[{"type": "clamp", "on": "Root"}]"#),
        ("root, ENCASTRE", r#"[{"type": "clamp", "on": "Root"}]"#),
        // The rotation about the normal makes no difference.
        ("Root, 1, 5", r#"[{"type": "clamp", "on": "Root"}]"#),
        ("Root, 1, 3\nRoot, 4\nRoot, 5", r#"[{"type": "clamp", "on": "Root"}]"#),
        ("Root, PINNED", r#"[{"type": "spherical", "on": "Root"}]"#),
        ("4, 1, 3\n4, 6", r#"[{"type": "spherical", "on": "4"}]"#),
        ("Root, 3", r#"[{"type": "fix", "on": "Root", "position": ["z"], "director": []}]"#),
        ("Root, 4, 4, 0.", r#"[{"type": "fix", "on": "Root", "position": [], "director": ["y"]}]"#),
        ("Root, 5, 5", r#"[{"type": "fix", "on": "Root", "position": [], "director": ["x"]}]"#),
        ("Root, 6, 6\nTip, 1", r#"[{"type": "fix", "on": "Tip", "position": ["x"], "director": []}]"#),
        ("Root, XSYMM", r#"[{"type": "symmetry", "on": "Root", "normal": [1.0, 0.0, 0.0]}]"#),
        (
            "Root, XSYMM\nRoot, 3",
            r#"[{"type": "symmetry", "on": "Root", "normal": [1.0, 0.0, 0.0]},
                {"type": "fix", "on": "Root", "position": ["z"], "director": []}]"#,
        ),
        // In the plane of the sheet this symmetry holds the whole director.
        ("Nall, ZSYMM", r#"[{"type": "fix", "on": "NALL", "position": ["z"], "director": ["x", "y"]}]"#),
        // These nodes lie in no plane normal to x.
        ("Nall, XSYMM", r#"[{"type": "fix", "on": "NALL", "position": ["x"], "director": ["x"]}]"#),
        ("Root, XASYMM", r#"[{"type": "fix", "on": "Root", "position": ["y", "z"], "director": ["y"]}]"#),
        (
            "Tip, 1, 1, 0.02\nTip, 2",
            r#"[{"type": "fix", "on": "Tip", "position": ["y"], "director": []},
                {"type": "prescribe", "on": "Tip", "of": "position", "component": "x", "value": 0.02}]"#,
        ),
    ] {
        let found = part(&format!("*BOUNDARY\n{lines}\n"), STEP, "conditions");
        assert_eq!(found, json(expected), "{lines}");
    }
}

#[test]
fn supports_without_counterparts_are_refused() {
    for (lines, line, message) in [
        ("Root, 4, 4, 0.1", 2, "the rotation 0.1 is prescribed"),
        ("Root, 1, 7", 2, "\"7\" is not a degree of freedom"),
        ("Root, 3, 1", 2, "the last degree of freedom, 1, is before"),
        ("Root, 1, 3, nan", 2, "\"nan\" is not a number"),
        ("Root, 1\nroot, 1, 1, 0.5", 3, "degree of freedom 1 gets 0.5, and 0 on line"),
        ("Strip, 1", 2, "there is no node set \"Strip\""),
        ("17, 1", 2, "the file has no node 17"),
    ] {
        let (found, text) = mistake(&format!("*BOUNDARY\n{lines}\n"), STEP);
        assert_eq!(found, line, "{lines}: {text}");
        assert!(text.starts_with(message), "{text}\nfor {message}");
    }
    // A sheet inclined to the axes.
    let inclined = MESH
        .replace("2, 1, 0\n3, 2, 0", "2, 1, 0, 1\n3, 2, 0, 2")
        .replace("5, 1, 1\n6, 2, 1", "5, 1, 1, 1\n6, 2, 1, 2");
    let found = mistakes(&format!("{inclined}*BOUNDARY\nRoot, 1, 4\n{STEP}"));
    assert!(
        found[0].1.starts_with("the fixed rotations 4 of Root are no components of the directors"),
        "{found:?}"
    );
    let deck = format!("{inclined}*BOUNDARY\nRoot, YSYMM\n{STEP}");
    let text = convert(Path::new("s.inp"), deck.as_bytes(), "s.inp").unwrap().text;
    assert!(text.contains("position = [\"y\"]\ndirector = [\"y\"]"), "{text}");
}

#[test]
fn loads_act_on_every_node_and_pressures_against_the_director() {
    let step = |cards: &str| format!("*STEP\n*STATIC\n{cards}*END STEP\n");
    let found = part(SUPPORT, &step("*CLOAD\nTip, 1, 2.\n3, 2, -1.\nTIP, 3, 5\nTip, 5, 4.\n"), "loads");
    let expected = r#"[{"type": "force", "on": "Tip", "value": [2.0, 0.0, 5.0]},
        {"type": "force", "on": "3", "value": [0.0, -1.0, 0.0]},
        {"type": "moment", "on": "Tip", "value": [0.0, 4.0, 0.0]}]"#;
    let names = |value: &serde_json::Value| {
        value
            .as_array()
            .unwrap()
            .iter()
            .map(|l| (l["type"].clone(), l["on"].clone(), l["value"].clone()))
            .collect::<Vec<_>>()
    };
    assert_eq!(names(&found), names(&json(expected)));
    let found =
        part(SUPPORT, &step("*CLOAD, FOLLOWER\nTip, 1, 2.\nTip, 5, 4.\n*CLOAD\nTip, 3, 1.\n"), "loads");
    let expected = r#"[{"type": "follower-force", "on": "Tip", "value": [2.0, 0.0, 0.0]},
        {"type": "follower-moment", "on": "Tip", "value": [0.0, 4.0, 0.0]},
        {"type": "force", "on": "Tip", "value": [0.0, 0.0, 1.0]}]"#;
    assert_eq!(names(&found), names(&json(expected)));
    let found = part(SUPPORT, &step("*DLOAD\nStrip, P, 3.\nstrip, GRAV, 10., 0, 3, -4\n"), "loads");
    let expected = r#"[{"type": "pressure", "on": "Strip", "value": -3.0},
        {"type": "gravity", "on": null, "value": [0.0, 6.0, -8.0]}]"#;
    assert_eq!(names(&found), names(&json(expected)));
    for (cards, line, message) in [
        ("*CLOAD\nTip, 3, 1.\n6, 3, 2.\n", 6, "node 6 is loaded in the direction 3 on line"),
        ("*CLOAD\nTip, 7, 1.\n", 5, "\"7\" is not a direction"),
        ("*CLOAD, AMPLITUDE=a\nTip, 1, 1.\n", 4, "the parameter AMPLITUDE of *CLOAD is not read"),
        ("*CLOAD\nTip, 1\n", 5, "a line of *CLOAD has 3 values"),
        ("*DLOAD\n1, P, 1.\nStrip, P, 2.\n", 6, "element 1 has a pressure on line"),
        ("*DLOAD\n1, GRAV, 9.81, 0, 0, -1\n", 5, "gravity acts on the set \"1\" alone"),
        ("*DLOAD\nStrip, GRAV, 9.81, 0, 0, 0\n", 5, "the direction of gravity has no length"),
        ("*DLOAD\nStrip, EDNOR1, 9.81\n", 5, "the distributed load \"EDNOR1\" is not read"),
        ("*DLOAD\n9, P, 1\n", 5, "the file has no element 9"),
    ] {
        let (found, text) = mistake("", &step(cards));
        assert_eq!(found, line - 1, "{cards}: {text}");
        assert!(text.starts_with(message), "{text}\nfor {message}");
    }
}

#[test]
fn analyses_of_steps_are_read() {
    let analysis = |step: &str| part(SUPPORT, &format!("*STEP\n{step}*END STEP\n"), "analysis");
    let linear = analysis("*STATIC\n*CLOAD\nTip, 3, 1.\n");
    assert_eq!((&linear["type"], &linear["linear"]), (&"static".into(), &true.into()));
    let modes = analysis("*FREQUENCY, SOLVER=SPOOLES\n7\n");
    assert_eq!((&modes["type"], &modes["modes"]), (&"modal".into(), &7.into()));
    let buckling = analysis("*BUCKLE\n3, 0.001\n*CLOAD\nTip, 1, -1.\n");
    assert_eq!((&buckling["type"], &buckling["factors"]), (&"buckling".into(), &3.into()));
    for (step, line, message) in [
        ("*STEP\n*END STEP\n", 1, "the step has 0 analyses"),
        ("*STEP\n*STATIC\n*BUCKLE\n1\n*END STEP\n", 3, "the step has 2 analyses"),
        ("*STEP\n*STATIC\n", 1, "the step has no end"),
        ("*STEP\n*STATIC\n1e-9, 1.\n*END STEP\n", 3, "these are no first increment and period"),
        ("*STEP\n*STATIC, RIKS\n*END STEP\n", 2, "*STATIC, RIKS is not read"),
        ("*STEP\n*FREQUENCY\n0\n*END STEP\n", 3, "\"0\" is not the number of modes"),
        ("*STEP\n*FREQUENCY\n99999999999\n*END STEP\n", 3, "\"99999999999\" is not the number of modes"),
        ("*STEP\n*FREQUENCY\n4\n*CLOAD\nTip, 1, 1.\n*END STEP\n", 4, "the step of line"),
        ("*STATIC\n", 1, "*STATIC stands outside of a step"),
    ] {
        let (found, text) = mistake("", step);
        assert_eq!(found, line, "{step}: {text}");
        assert!(text.starts_with(message), "{text}\nfor {message}");
    }
    assert!(mistakes(MESH)[0].1.starts_with("the file has no *STEP"));
}

#[test]
fn loads_of_statics_continue_in_later_steps() {
    let steps = "*STEP, NLGEOM, NAME=first\n*STATIC\n*CLOAD\nTip, 1, 2.\n*END STEP\n*STEP\n*STATIC\n*DLOAD\nStrip, P, 1.\n*END STEP\n\
                 *STEP\n*STATIC\n*CLOAD, OP=NEW\nTip, 1, 3.\n*END STEP\n*STEP\n*FREQUENCY\n4\n*END STEP\n";
    let found = part(SUPPORT, steps, "steps");
    let of = |step: usize| -> Vec<String> {
        let loads = found[step]["loads"].as_array().cloned().unwrap_or_default();
        loads.iter().map(|load| format!("{} {}", load["type"].as_str().unwrap(), load["value"])).collect()
    };
    assert_eq!(found[0]["name"], "first");
    assert_eq!(of(0), ["force [2.0,0.0,0.0]"]);
    assert_eq!(of(1), ["force [2.0,0.0,0.0]", "pressure -1.0"]);
    assert_eq!(of(2), ["pressure -1.0", "force [3.0,0.0,0.0]"]);
    assert_eq!((of(3).len(), &found[3]["analysis"]["type"]), (0, &"modal".into()));
    let again = steps.replace(", OP=NEW", "");
    assert!(mistake(SUPPORT, &again).1.starts_with("the step adds to the loads by *CLOAD"));
    let perturbed = steps.replacen("*STEP\n", "*STEP, PERTURBATION\n", 1);
    assert!(mistake(SUPPORT, &perturbed).1.starts_with("a static perturbation among several steps"));
}

#[test]
fn unknown_cards_are_listed_with_their_lines() {
    let found = mistakes(&format!(
        "{MESH}*AMPLITUDE, NAME=A\n0, 0, 1, 1\n*PLASTIC\n1., 0.\n*AMPLITUDE, NAME=B\n0, 0\n*CONTACT PAIR\nA, B\n{SUPPORT}{STEP}"
    ));
    let base = MESH.lines().count();
    let list = format!(
        "these cards are not read: *AMPLITUDE (lines {}, {}), *PLASTIC (line {})",
        base + 1,
        base + 5,
        base + 3
    );
    assert_eq!(found[0], (base + 1, list));
    assert_eq!(found[1], (base + 7, "*CONTACT PAIR: there is no contact".into()));
    assert_eq!(found.len(), 2, "{found:?}");
}

#[test]
fn requests_are_warnings_but_for_displacements_of_few_nodes() {
    let step =
        STEP.replace("*END", "*NODE PRINT, NSET=Tip\nU, RF\n*NODE FILE\nU\n*EL PRINT, ELSET=Strip\nS\n*END");
    let deck = format!("{MESH}{SUPPORT}{step}");
    let converted = convert(Path::new("strip.inp"), deck.as_bytes(), "strip.inp").unwrap();
    let line = deck.lines().position(|line| line == "*NODE FILE").unwrap() + 1;
    let expected = format!(
        "cards of the input file without effect: *EL PRINT (line {}), *NODE FILE (line {line})",
        line + 2
    );
    let messages: Vec<&str> = converted.warnings.iter().map(|warning| warning.message.as_str()).collect();
    assert_eq!(messages, [expected]);
    let points = part(SUPPORT, &step, "output")["points"].clone();
    assert_eq!(
        (&points[0]["name"], &points[0]["on"], &points[1]["on"]),
        (&"Tip 3".into(), &"3".into(), &"6".into())
    );
}

#[test]
fn mistakes_of_the_model_stand_on_the_lines_of_the_input_file() {
    let base = MESH.lines().count();
    let thin = MESH.replace("0.5, 5", "-0.5, 5");
    let found = mistakes(&format!("{thin}{SUPPORT}{STEP}"));
    assert_eq!(found[0].0, base, "{found:?}");
    // A moment about the normal is an error of the model.
    let drilling = STEP.replace("TIP, 3, -2.", "TIP, 6, -2.");
    let (line, text) = mistake(SUPPORT, &drilling);
    assert_eq!(line, 2 + 5, "{text}");
    let uncovered = MESH
        .replace("ELSET=STRIP, MATERIAL", "ELSET=Half, MATERIAL")
        .replace("*MATERIAL", "*ELSET, ELSET=HALF\n1\n*MATERIAL");
    assert!(!mistakes(&format!("{uncovered}{SUPPORT}{STEP}")).is_empty());
}

#[test]
fn a_converted_model_is_the_model_of_the_input_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("strip.inp");
    std::fs::write(&path, format!("{MESH}{SUPPORT}{STEP}")).unwrap();
    let direct = Deck::read(&path).unwrap();
    let written = folder.path().join("model.toml");
    std::fs::write(&written, &Deck::convert(&path, "strip.inp").unwrap().text).unwrap();
    let again = Deck::read(&written).unwrap();
    assert_eq!(direct.model, again.model);
    let (a, b) = (crate::job::prepare(&direct).unwrap(), crate::job::prepare(&again).unwrap());
    assert_eq!(a.fingerprint, b.fingerprint);
    assert_eq!((a.mesh.quads.len(), a.system.unknowns()), (2, b.system.unknowns()));
}

#[test]
fn loads_on_sets_that_list_a_member_twice_are_refused() {
    let mesh =
        MESH.replace("*MATERIAL,", "*NSET, NSET=Twice\nTip, 6\n*ELSET, ELSET=Both\n1, 2, 1\n*MATERIAL,");
    let told = |steps: &str| mistakes(&format!("{mesh}{SUPPORT}{steps}")).remove(0).1;
    assert_eq!(told(&STEP.replace("TIP", "twice")), "the set \"Twice\" lists node 6 twice");
    let pressure = STEP.replace("*CLOAD\nTIP, 3, -2.", "*DLOAD\nBOTH, P, 1.");
    assert_eq!(told(&pressure), "the set \"BOTH\" lists element 1 twice");
    // A support holds a node once, however often it is named.
    let path = Path::new("strip.inp");
    let deck = format!("{mesh}*BOUNDARY\nTWICE, 3\n{SUPPORT}{STEP}");
    assert!(convert(path, deck.as_bytes(), "strip.inp").is_ok());
}

#[test]
fn ranges_meet_their_last_number() {
    let mesh = MESH.replace("*MATERIAL,", "*NSET, NSET=Odd, GENERATE\n1, 6, 2\n*MATERIAL,");
    assert_eq!(
        mistakes(&format!("{mesh}{SUPPORT}{STEP}")).remove(0).1,
        "the range from 1 by 2 does not meet its last number 6"
    );
}

#[test]
fn names_in_quotes_are_the_names_without_them() {
    let mesh = MESH.replace("NSET=Tip", "NSET=\"The Tip\"");
    let deck = format!("{mesh}{SUPPORT}{}", STEP.replace("TIP,", "\"The Tip\","));
    let converted = convert(Path::new("strip.inp"), deck.as_bytes(), "strip.inp").unwrap();
    let strip = Deck::parse("strip.toml", converted.text).unwrap().model;
    assert_eq!(serde_json::to_value(strip).unwrap()["loads"][0]["on"], "The Tip");
}

#[test]
fn the_rim_of_a_curved_sheet_in_a_plane_is_a_plane_of_symmetry() {
    let mesh = MESH.replace("2, 1, 0\n", "2, 1, 0, 0.3\n").replace("5, 1, 1\n", "5, 1, 1, 0.3\n");
    let deck = format!("{mesh}*BOUNDARY\nROOT, XSYMM\nTIP, 3\n{STEP}");
    let converted = convert(Path::new("strip.inp"), deck.as_bytes(), "strip.inp").unwrap();
    let strip = Deck::parse("strip.toml", converted.text).unwrap().model;
    let condition = serde_json::to_value(strip).unwrap()["conditions"][0].clone();
    assert_eq!((&condition["type"], &condition["on"]), (&"symmetry".into(), &"Root".into()));
    assert_eq!(condition["normal"], json("[1.0, 0.0, 0.0]"));
    // Without the displacement along x there is no plane.
    let free = deck.replace("ROOT, XSYMM", "ROOT, 5, 6");
    assert!(convert(Path::new("strip.inp"), free.as_bytes(), "strip.inp").is_err());
}

#[test]
fn modes_about_loaded_states_come_with_a_message_unless_the_step_is_a_perturbation() {
    let ambiguous = |head: &str, before: &str| {
        let deck = format!("{MESH}{SUPPORT}{before}{head}\n*FREQUENCY\n3\n*END STEP\n");
        let warnings = convert(Path::new("strip.inp"), deck.as_bytes(), "strip.inp").unwrap().warnings;
        warnings.into_iter().map(|warning| warning.message).collect::<Vec<_>>()
    };
    let found = ambiguous("*STEP", STEP).remove(0);
    assert!(
        found.starts_with("*FREQUENCY on line") && found.contains("CalculiX takes the unloaded structure"),
        "{found}"
    );
    assert!(ambiguous("*STEP, PERTURBATION", STEP).is_empty());
    assert!(ambiguous("*STEP", &STEP.replace(", NLGEOM", "")).is_empty());
    assert!(ambiguous("*STEP", "").is_empty());
}

proptest! {
    #[test]
    fn damaged_decks_never_panic(at in 0_usize..900, with in "[*,=0-9a-zA-Z .\n-]{0,12}", cut in 0_usize..30) {
        let deck = format!("{MESH}{SUPPORT}{STEP}");
        let start = at.min(deck.len());
        let end = (start + cut).min(deck.len());
        let damaged = format!("{}{with}{}", &deck[..start], &deck[end..]);
        if let Ok(converted) = convert(Path::new("strip.inp"), damaged.as_bytes(), "strip.inp") {
            let _ = Deck::parse("strip.toml", converted.text);
        }
    }

    #[test]
    fn damaged_examples_never_panic(at in 0_usize..4200, byte in any::<u8>(), cut in 0_usize..60) {
        let mut deck = include_bytes!("../../../../examples/sze_cantilever.inp").to_vec();
        let start = at.min(deck.len());
        let end = (start + cut).min(deck.len());
        deck.splice(start..end, [byte]);
        if let Ok(converted) = convert(Path::new("strip.inp"), &deck, "strip.inp") {
            let _ = Deck::parse("strip.toml", converted.text);
        }
    }
}
