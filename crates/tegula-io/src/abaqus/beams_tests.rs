#![allow(clippy::unwrap_used)]

use std::f64::consts::PI;
use std::path::Path;

use proptest::prelude::*;
use tegula::Vec3;

use super::convert;
use super::tests::{json, mistakes};
use crate::deck::Deck;
use crate::solved::{Solved, near};

const E: f64 = 2.1e5;
const NU: f64 = 0.3;
const G: f64 = E / (2.0 * (1.0 + NU));
const L: f64 = 100.0;
const MATERIAL: &str = "*MATERIAL, NAME=Steel\n*ELASTIC\n2.1e5, 0.3\n";
const SECTION: &str =
    "*BEAM SECTION, ELSET=Beam, MATERIAL=STEEL, SECTION=RECT, TEMPERATURE=GRADIENTS\n2., 6.\n0., 0., 1.\n";

/// Four beams along x from node 1 to node 5, of which the second one runs backwards, clamped at node 1, with loads at node 5.
fn cantilever(section: &str, loads: &str) -> String {
    let nodes: String =
        (0..5).map(|i| format!("{}, {:?}, 0., 0.\n", i + 1, 0.25 * L * f64::from(i))).collect();
    format!(
        "*NODE, NSET=Nall\n{nodes}*ELEMENT, TYPE=B31, ELSET=Beam\n1, 1, 2\n2, 3, 2\n3, 3, 4\n4, 4, 5\n\
         *NSET, NSET=Tip\n5\n{MATERIAL}{section}*BOUNDARY\n1, ENCASTRE\n*STEP, NLGEOM\n*STATIC\n*CLOAD\n{loads}\
         *NODE PRINT, NSET=Tip\nU\n*END STEP\n"
    )
}

fn model(deck: &str) -> serde_json::Value {
    let converted =
        convert(Path::new("b.inp"), deck.as_bytes(), "b.inp").unwrap_or_else(|e| panic!("{e:#?}"));
    serde_json::to_value(Deck::parse("b.toml", converted.text).unwrap().model).unwrap()
}

/// Deflection of a cantilever under a force of 1: L³/3EI + L/kGA.
fn flexibility(moment: f64, shear_area: f64) -> f64 {
    L.powi(3) / (3.0 * E * moment) + L / (G * shear_area)
}

#[test]
fn a_cantilever_of_beams_bends_as_timoshenkos_beam() {
    let deck = cantilever(SECTION, "Tip, 2, 0.02\nTip, 3, 0.03\n");
    let tip = Solved::new(&deck).moved("B31 1.end");
    // The side 2 lies along n1 = z, the side 6 along n2 = t × n1 = −y.
    near(tip.y, 0.02 * flexibility(2.0 * 6.0_f64.powi(3) / 12.0, 10.0), 1e-6);
    near(tip.z, 0.03 * flexibility(6.0 * 2.0_f64.powi(3) / 12.0, 10.0), 1e-6);
    let found = model(&deck);
    assert_eq!((&found["beams"][0]["name"], &found["beams"][1]), (&"B31 1".into(), &json("null")));
    assert_eq!(found["joints"][0]["between"], json(r#"["ground", "B31 1.start"]"#));
    assert_eq!((&found["mesh"], &found["analysis"]["linear"]), (&json(r#"{"type": "none"}"#), &false.into()));
    // Small displacements are those of small loads.
    let linear = deck.replace(", NLGEOM", "");
    let warnings = convert(Path::new("b.inp"), linear.as_bytes(), "b.inp").unwrap().warnings;
    assert_eq!(warnings.len(), 1);
    assert!(
        warnings[0]
            .message
            .contains("small displacements of *STATIC (line 23), which may have any size here"),
        "{warnings:?}"
    );
    let twisted = Solved::new(&cantilever(SECTION, "Tip, 4, 5.\nTip, 1, 20.\n"));
    // Torsion constant of a rectangle 3 : 1: 0.263 a b³ (S. Timoshenko, J. Goodier, *Theory of elasticity*, Sect. 109).
    near(twisted.turned("B31 1.end").x, 5.0 * L / (G * 0.263 * 6.0 * 8.0), 2e-3);
    near(twisted.moved("B31 1.end").x, 20.0 * L / (E * 12.0), 1e-3);
}

/// Deflections of CalculiX 2.20 for twenty of its B31, which it expands to solids; they are 0.1 % less than those of the beam.
#[test]
fn a_cantilever_of_beams_bends_as_in_calculix() {
    let tip = Solved::new(&cantilever(SECTION, "Tip, 2, 2.e-2\nTip, 3, 3.e-2\n")).moved("B31 1.end");
    near(tip.y, 8.832771e-4, 2e-3);
    near(tip.z, 1.189707e-2, 2e-3);
}

#[test]
fn shapes_of_sections_have_their_moments() {
    let loads = "Tip, 2, 0.001\nTip, 3, 0.001\n";
    let deflected = |lines: &str| {
        let section = format!("*BEAM SECTION, ELSET=Beam, MATERIAL=Steel, SECTION={lines}");
        Solved::new(&cantilever(&section, loads)).moved("B31 1.end") / 0.001
    };
    let of_ring = |r: f64, inner: f64| 0.25 * PI * (r.powi(4) - inner.powi(4));
    // Shear factors of a circle and of a thin ring by Cowper.
    let circle = flexibility(of_ring(3.0, 0.0), 7.8 / 8.8 * PI * 9.0);
    near(deflected("CIRC\n3.\n").y, circle, 1e-6);
    near(deflected("CIRC\n6., 6.\n1., 0., -1.\n").z, circle, 1e-6);
    // Without a direction n1 is −z.
    near(deflected("RECT\n2., 6.\n").z, flexibility(6.0 * 8.0 / 12.0, 10.0), 1e-6);
    near(deflected("PIPE\n3., 1.\n").y, L.powi(3) / (3.0 * E * of_ring(3.0, 2.0)), 1e-2);
    let hollow = deflected("BOX\n4., 8., .5, .5, .5, .5\n0., 0., 1.\n");
    let moment = |a: f64, b: f64| (a * b.powi(3) - (a - 1.0) * (b - 1.0).powi(3)) / 12.0;
    near(hollow.y, L.powi(3) / (3.0 * E * moment(4.0, 8.0)), 1e-2);
    near(hollow.z, L.powi(3) / (3.0 * E * moment(8.0, 4.0)), 1e-2);
}

/// Constants A, I11, I22 and J, with the shear factor 1 of such sections in Abaqus.
#[test]
fn general_sections_have_the_constants_of_their_card() {
    let general = "*BEAM GENERAL SECTION, ELSET=Beam, SECTION=GENERAL, DENSITY=8e-9\n12., 36., 0., 4., 10.5\n0., 1., 0.\n2.1e5, 80769.23\n";
    let deck = cantilever(general, "Tip, 2, 0.02\nTip, 3, 0.03\n");
    let tip = Solved::new(&deck).moved("B31 1.end");
    // I11 is about n1 = y, in the plane of x and z.
    near(tip.z, 0.03 * flexibility(36.0, 12.0), 1e-6);
    near(tip.y, 0.02 * flexibility(4.0, 12.0), 1e-6);
    let section = model(&deck)["beams"][0]["section"].clone();
    near(section["mass"].as_f64().unwrap(), 12.0 * 8e-9, 1e-12);
    near(section["inertia"][0].as_f64().unwrap(), 36.0 * 8e-9, 1e-12);
    assert_eq!(model(&deck), model(&deck.replace(", SECTION=GENERAL", "")), "the usual shape");
    let shape = "*BEAM GENERAL SECTION, ELSET=Beam, SECTION=RECT\n2., 6.\n0., 0., 1.\n2.1e5, 80769.2307692\n";
    let tip = Solved::new(&cantilever(shape, "Tip, 2, 0.02\nTip, 3, 0.03\n")).moved("B31 1.end");
    near(tip.y, 0.02 * flexibility(36.0, 10.0), 1e-6);
}

/// A node beside the axis orients a beam, and an arm at an angle is joined: F a³/3EI + F a² h/EI + F h/EA + F a/kGA at its end.
#[test]
fn beams_at_an_angle_are_joined_and_oriented_by_nodes_beside_them() {
    let (h, a, force): (f64, f64, f64) = (60.0, 40.0, 0.02);
    let deck = format!(
        "*NODE\n1, 0, 0, 0\n2, 0, 0, 60\n3, 40, 0, 60\n9, 0, 7, 30\n*ELEMENT, TYPE=B31, ELSET=Beam\n1, 1, 2, 9\n2, 2, 3\n\
         {MATERIAL}*BEAM SECTION, ELSET=Beam, MATERIAL=Steel, SECTION=RECT\n6., 2.\n0., 1., 0.\n*BOUNDARY\n1, 1, 6\n\
         *STEP, NLGEOM\n*STATIC\n*CLOAD\n3, 3, -{force}\n*END STEP\n"
    );
    let found = model(&deck);
    assert_eq!(found["joints"][0]["between"], json(r#"["B31 1.end", "B31 2.start"]"#));
    let stiffness = E * 6.0 * 8.0 / 12.0;
    let bending = a.powi(3) / (3.0 * stiffness) + a * a * h / stiffness;
    let others = h / (E * 12.0) + a / (5.0 / 6.0 * G * 12.0);
    near(-Solved::new(&deck).moved("B31 2.end").z, force * (bending + others), 1e-4);
}

/// A beam on two supports that turn sags by F L³/48EI + F L/4kGA in its middle.
#[test]
fn supports_of_beams_leave_rotations_free() {
    let deck = cantilever(SECTION, "3, 3, 0.3\n")
        .replace("1, ENCASTRE\n", "1, 1, 4\nTip, 2, 3\n")
        .replace("*NSET, NSET=Tip\n5\n", "*NSET, NSET=Tip\n5\n*NSET, NSET=Ends\n1, 5\n");
    let sag = L.powi(3) / (48.0 * E * 4.0) + L / (4.0 * G * 10.0);
    near(Solved::new(&deck).moved("B31 1.2").z, 0.3 * sag, 1e-5);
    // Cards of one node are taken together.
    let split = deck.replace("1, 1, 4\nTip, 2, 3\n", "Ends, 2, 3\n1, 1\n1, 4\n");
    near(Solved::new(&split).moved("B31 1.2").z, 0.3 * sag, 1e-5);
}

/// Strip of shells of the width 10, the thickness 1 and the length 100 with beams of 2 × 6 on its middle line, clamped at one end.
fn ribbed(loads: &str) -> String {
    let n = 20;
    let node = |i: usize, j: usize| 3 * i + j + 1;
    let mut out = String::from("*NODE, NSET=Nall\n");
    for i in 0..=n {
        for j in 0..3 {
            out += &format!("{}, {:?}, {:?}, 0.\n", node(i, j), L * i as f64 / n as f64, 5.0 * j as f64);
        }
    }
    out += "*ELEMENT, TYPE=S4, ELSET=Strip\n";
    for i in 0..n {
        for j in 0..2 {
            let corners = [node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)];
            out += &format!("{}, {}\n", 2 * i + j + 1, corners.map(|n| n.to_string()).join(", "));
        }
    }
    out += "*ELEMENT, TYPE=B31, ELSET=Rib\n";
    for i in 0..n {
        out += &format!("{}, {}, {}\n", 101 + i, node(i, 1), node(i + 1, 1));
    }
    out += "*NSET, NSET=Root\n1, 2, 3\n*NSET, NSET=Tip\n61, 62, 63\n*MATERIAL, NAME=Steel\n*ELASTIC\n2.1e5, 0.\n*DENSITY\n7.85e-9\n";
    out += "*SHELL SECTION, ELSET=Strip, MATERIAL=Steel\n1.\n";
    out += "*BEAM SECTION, ELSET=Rib, MATERIAL=Steel, SECTION=RECT\n2., 6.\n0., 1., 0.\n";
    format!("{out}*BOUNDARY\nRoot, 1, 6\n*STEP, NLGEOM\n*STATIC\n{loads}*END STEP\n")
}

/// Strip and rib have one axis, so their moments of area add up: 10/12 + 2 · 6³/12. The end moves by F L³/3EI, in CalculiX 2.20 with S4 and B31 by 0.0064693.
#[test]
fn beams_on_nodes_of_shells_stiffen_them() {
    let deck = ribbed("*CLOAD\nTip, 3, -0.05\n");
    let found = model(&deck);
    assert_eq!(found["beams"][0]["attached"], json(r#"["nodes of B31 101"]"#));
    assert_eq!(found["conditions"][0]["on"], "Root beside beams");
    assert_eq!(found["joints"][0]["type"], "fixed");
    let moment = 10.0 / 12.0 + 2.0 * 216.0 / 12.0;
    let sag = 0.15 * L.powi(3) / (3.0 * E * moment);
    let found = -Solved::new(&deck).at(Vec3::new(L, 5.0, 0.0)).z;
    near(found, sag, 5e-3);
    near(found, 0.006_469_304, 5e-3);
    // Gravity needs all elements.
    let all = deck.replace("*MATERIAL", "*ELSET, ELSET=All\nStrip, Rib\n*MATERIAL");
    let heavy = all.replace("*CLOAD\nTip, 3, -0.05\n", "*DLOAD\nAll, GRAV, 1e6, 0., 0., -1.\n");
    let weight = 7.85e-9 * 1e6 * (10.0 + 12.0);
    let sag = weight * L.powi(4) / (8.0 * E * moment);
    near(-Solved::new(&heavy).at(Vec3::new(L, 5.0, 0.0)).z, sag, 1e-2);
}

/// A column on one node of a plate turns about its own axis, as shells have no stiffness against that; a second foot holds it.
#[test]
fn columns_on_one_node_of_a_shell_are_told_to_turn_freely() {
    let rib = "*ELEMENT, TYPE=B31, ELSET=Rib\n";
    let deck = ribbed("*CLOAD\nTip, 3, -0.05\n");
    let start = deck.find(rib).unwrap() + rib.len();
    let end = start + deck[start..].find('*').unwrap();
    let nodes: Vec<u64> =
        deck[start..end].split([',', '\n']).filter_map(|field| field.trim().parse().ok()).collect();
    // Lines of the card have a number and two nodes; the first node of all is clamped.
    let [clamped, foot, other] = [nodes[1], nodes[2], nodes[5]];
    let told = |lines: &str| {
        let nodes = "*NODE\n9001, 50., 5., 30.\n9002, 60., 5., 30.\n";
        let changed = format!("{nodes}{}{lines}{}", &deck[..start], &deck[end..]);
        let found =
            convert(Path::new("b.inp"), changed.as_bytes(), "b.inp").unwrap_or_else(|e| panic!("{e:#?}"));
        found.warnings.iter().filter(|w| w.message.contains("turns freely about the normal")).count()
    };
    assert_eq!(told(&format!("101, {foot}, 9001\n")), 1);
    assert_eq!(told(&format!("101, {clamped}, 9001\n")), 0);
    assert_eq!(told(&format!("101, {foot}, 9001\n*BOUNDARY\n9001, 4, 6\n")), 0);
    assert_eq!(told(&format!("101, {foot}, 9001\n102, 9001, 9002\n103, 9002, {other}\n")), 0);
    assert_eq!(told(&deck[start..end]), 0);
}

#[test]
fn beams_that_have_no_counterpart_are_refused_by_line() {
    let deck = cantilever(SECTION, "Tip, 2, 0.02\n");
    for (from, to, line, message) in [
        ("SECTION=RECT", "SECTION=I", 17, "the section I of beams is not read"),
        ("SECTION=RECT", "SECTION=BOX", 18, "the section has 2 values on its first line"),
        ("2., 6.\n", "2., -6.\n", 18, "a size of the section RECT is -6"),
        ("2., 6.\n", "2., six\n", 18, "\"six\" is not a number"),
        ("TEMPERATURE=GRADIENTS", "OFFSET1=0.5", 17, "the parameter OFFSET1 of *BEAM SECTION is not read"),
        ("MATERIAL=STEEL", "MATERIAL=Wood", 17, "there is no material \"Wood\""),
        ("0., 0., 1.\n", "1., 0., 0.\n", 8, "the orientation vector of B31 1 is zero or along the bar"),
        ("ELSET=Beam, MAT", "ELSET=Rib, MAT", 17, "there is no element set \"Rib\""),
        ("2, 3, 2\n", "2, 2, 2\n", 9, "element 2 has node 2 at two corners"),
        ("2, 3, 2\n", "2, 3, 77\n", 9, "element 2 needs node 77"),
        ("2, 3, 2\n", "1, 3, 2\n", 9, "element 1 is defined again"),
        ("2, 3, 2\n", "2, 3\n", 9, "element 2 has 1 nodes, and a B31 has 2"),
        ("TYPE=B31", "TYPE=B32", 7, "elements of type B32 are not read"),
        ("1, ENCASTRE\n", "1, 1, 1, 0.1\n", 21, "the displacement 0.1 of B31 1.start is prescribed"),
        ("*CLOAD\n", "*DLOAD\nBeam, P1, 3.\n*CLOAD\n", 25, "P1 acts on the beam 1"),
        ("*CLOAD\n", "*DLOAD\nBeam, PZ, 3.\n*CLOAD\n", 25, "the distributed load \"PZ\" is not read"),
        ("*CLOAD\n", "*DLOAD\nBeam, P, 3.\n*CLOAD\n", 25, "P acts on the beam 1"),
        (
            "*BEAM SECTION",
            "*SHELL SECTION, ELSET=Beam, MATERIAL=Steel\n1.\n*BEAM SECTION",
            17,
            "element 1 of the set \"Beam\" is a beam",
        ),
        (
            "*BOUNDARY",
            "*BEAM SECTION, ELSET=Beam, MATERIAL=Steel, SECTION=CIRC\n1.\n*BOUNDARY",
            20,
            "the beam 1 has a section on line 17, too",
        ),
    ] {
        let changed = deck.replacen(from, to, 1);
        assert_ne!(changed, deck, "{from}");
        let found = mistakes(&changed);
        assert!(
            found.iter().any(|(at, told)| *at == line && told.starts_with(message)),
            "{found:?}\nfor {line} {message}"
        );
    }
    let general = "*BEAM GENERAL SECTION, ELSET=Beam, SECTION=GENERAL\n12., 36., 0., 4., 10.5\n0., 1., 0.\n2.1e5, 8e4\n";
    let deck = cantilever(general, "Tip, 2, 0.02\n");
    for (from, to, line, message) in [
        ("36., 0., 4.", "36., 1., 4.", 18, "the product of area I12 is 1"),
        ("36., 0., 4.", "36., 0., 0.", 18, "the section has the constants"),
        ("10.5\n", "10.5, 0., 3.\n", 18, "the warping constants"),
        ("0., 1., 0.\n", "\n", 17, "*BEAM GENERAL SECTION has 2 data lines"),
        ("2.1e5, 8e4\n", "2.1e5\n", 20, "these are no moduli of a beam"),
    ] {
        let changed = deck.replacen(from, to, 1);
        let found = mistakes(&changed);
        assert!(
            found.iter().any(|(at, told)| *at == line && told.starts_with(message)),
            "{found:?}\nfor {line} {message}"
        );
    }
}

/// Modes of a linear preload would be about the loaded state, which has large displacements here.
#[test]
fn modes_behind_linear_statics_of_beams_are_refused() {
    let deck =
        cantilever(SECTION, "Tip, 2, 0.02\n").replace(", NLGEOM", "") + "*STEP\n*FREQUENCY\n2\n*END STEP\n";
    assert!(
        mistakes(&deck)[0].1.starts_with("*FREQUENCY stands behind a linear *STATIC of a model with beams")
    );
}

proptest! {
    #[test]
    fn damaged_beams_never_panic(at in 0_usize..900, with in "[*,=0-9a-zA-Z .\n-]{0,12}", cut in 0_usize..30) {
        let deck = cantilever(SECTION, "Tip, 2, 0.02\n");
        let start = at.min(deck.len());
        let end = (start + cut).min(deck.len());
        let damaged = format!("{}{with}{}", &deck[..start], &deck[end..]);
        if let Ok(converted) = convert(Path::new("b.inp"), damaged.as_bytes(), "b.inp") {
            let _ = Deck::parse("b.toml", converted.text);
        }
    }
}
