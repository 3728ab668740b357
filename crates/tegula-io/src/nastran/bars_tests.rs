#![allow(clippy::unwrap_used)]

use std::path::Path;

use proptest::prelude::*;
use serde_json::Value;
use tegula::Vec3;
use tegula::analysis::Silent;
use tegula::model::Analysis;

use super::convert;
use super::tests::{json, mistakes, model};
use crate::deck::Deck;
use crate::job::prepare;
use crate::mesh::MeshReader;
use crate::mesh::nastran::Nastran;
use crate::solved::{Solved, near};

const CONTROL: &str = "SOL 101\nCEND\nSPC = 1\nLOAD = 2\nBEGIN BULK\n";
const E: f64 = 2.1e5;
const G: f64 = E / 2.6;
const MATERIAL: &str = "MAT1,4,2.1+5,,.3\n";
const A: f64 = 100.0;
/// Moments of area about z and y, and torsion constant.
const I: [f64; 2] = [2000.0, 800.0];
const J: f64 = 1500.0;
const K: [f64; 2] = [0.8, 0.7];
const PROPERTY: &str = "PBAR,7,4,100.,2000.,800.,1500.\n,1.,2.\n,.8,.7\n";
const L: f64 = 100.0;

/// Four bars along x from node 1 to node 5, of which the second one runs backwards.
fn bars() -> String {
    let nodes: String =
        (0..5).map(|i| format!("GRID,{},,{:?},0.,0.\n", i + 1, 0.25 * L * f64::from(i))).collect();
    format!(
        "{nodes}CBAR,1,7,1,2,0.,1.,0.\nCBAR,2,7,3,2,0.,1.,0.\nCBAR,3,7,3,4,3.,2.,0.\nCBAR,4,7,4,5,0.,1.,0.\n"
    )
}

fn cantilever(property: &str, loads: &str) -> String {
    [CONTROL, &bars(), property, MATERIAL, "SPC1,1,123456,1\n", loads].concat()
}

/// Deflections of a cantilever of bars: F L³/3EI + F L/kGA in both planes, F L/EA, M L/GJ.
#[test]
fn a_cantilever_of_bars_bends_as_timoshenkos_beam() {
    let bent = Solved::new(&cantilever(PROPERTY, "FORCE,2,5,,1.,0.,2.,3.\n")).moved("CBAR 1.end");
    let deflection = |i: f64, k: f64| L.powi(3) / (3.0 * E * i) + L / (k * G * A);
    near(bent.y, 2.0 * deflection(I[0], K[0]), 1e-6);
    near(bent.z, 3.0 * deflection(I[1], K[1]), 1e-6);
    let pulled = Solved::new(&cantilever(PROPERTY, "FORCE,2,5,,20.,1.,0.,0.\nMOMENT,2,5,,5.,1.,0.,0.\n"));
    near(pulled.moved("CBAR 1.end").x, 20.0 * L / (E * A), 1e-4);
    near(pulled.turned("CBAR 1.end").x, 5.0 * L / (G * J), 1e-6);
    // Without K1 and K2 a bar is rigid in shear.
    let rigid = cantilever("PBAR,7,4,100.,2000.,800.,1500.\n", "FORCE,2,5,,1.,0.,2.,3.\n");
    near(Solved::new(&rigid).moved("CBAR 1.end").y, 2.0 * L.powi(3) / (3.0 * E * I[0]), 1e-6);
}

/// Under its weight a cantilever of n bars, whose mass is lumped at their ends, deflects by 1 + 1/(3n²) times q L⁴/8EI.
#[test]
fn the_mass_of_bars_is_lumped_at_their_ends() {
    let property = "PBAR,7,4,100.,2000.,800.,1500.\n";
    let material = "MAT1,4,2.1+5,,.3,1.-6\n";
    let four = [CONTROL, &bars(), property, material, "SPC1,1,123456,1\nGRAV,2,,10.,0.,-1.,0.\n"].concat();
    let one = format!(
        "{CONTROL}GRID,1,,0.,0.,0.\nGRID,2,,{L:?},0.,0.\nCBAR,1,7,1,2,0.,1.,0.\n{property}{material}SPC1,1,123456,1\nGRAV,2,,10.,0.,-1.,0.\n"
    );
    for (deck, n) in [(four, 4.0_f64), (one, 1.0)] {
        let beam = -1e-6 * A * 10.0 * L.powi(4) / (8.0 * E * I[0]);
        near(Solved::new(&deck).moved("CBAR 1.end").y, beam * (1.0 + 1.0 / (3.0 * n * n)), 1e-4);
    }
}

/// DIM1 lies along z, DIM2 along y: a rectangle of 2 × 6 bends about z with 2 · 6³/12.
#[test]
fn shapes_of_sections_have_their_moments() {
    let deflected = |property: &str| {
        Solved::new(&cantilever(property, "FORCE,2,5,,.01,0.,1.,1.\n")).moved("CBAR 1.end") / 0.01
    };
    let flexibility = |i: f64, shear: f64| L.powi(3) / (3.0 * E * i) + L / (G * shear);
    let rectangle = deflected("PBARL,7,4,,BAR\n,2.,6.\n");
    near(rectangle.y, flexibility(36.0, 10.0), 1e-4);
    near(rectangle.z, flexibility(4.0, 10.0), 1e-4);
    let hollow = deflected("PBARL,7,4,MSCBML0,BOX\n,4.,8.,.5,.5\n");
    let i = |a: f64, b: f64| (a * b.powi(3) - (a - 1.0) * (b - 1.0).powi(3)) / 12.0;
    // Shear is below 1 %; the web takes it.
    near(hollow.y, L.powi(3) / (3.0 * E * i(4.0, 8.0)), 1e-2);
    near(hollow.z, L.powi(3) / (3.0 * E * i(8.0, 4.0)), 1e-2);
    let round = deflected("PBARL,7,4,,ROD\n,3.\n");
    let of_ring = |r: f64, inner: f64| 0.25 * std::f64::consts::PI * (r.powi(4) - inner.powi(4));
    near(round.y, flexibility(of_ring(3.0, 0.0), 7.8 / 8.8 * std::f64::consts::PI * 9.0), 1e-4);
    let tube = deflected("PBARL,7,4,,TUBE\n,3.,2.\n");
    near(tube.z, L.powi(3) / (3.0 * E * of_ring(3.0, 2.0)), 1e-2);
    near(tube.y, tube.z, 1e-9);
    // The mass NSM is added: the section becomes one of constants.
    let heavy =
        cantilever("PBARL,7,4,,BAR\n,2.,6.,.25\n", "FORCE,2,5,,.01,0.,1.,1.\n").replace(".3\n", ".3,.5\n");
    let section = model(&heavy)["beams"][0]["section"].clone();
    assert_eq!((&section["type"], &section["mass"]), (&"constants".into(), &json("6.25")));
    near(Solved::new(&heavy).moved("CBAR 1.end").y / 0.01, rectangle.y, 1e-6);
}

/// An arm across the end of a column: F a³/3EI + F a² h/EI + F h/EA + F a/kGA at its end.
#[test]
fn bars_at_an_angle_are_joined_in_their_node() {
    let (h, a, force): (f64, f64, f64) = (60.0, 40.0, 2.0);
    let deck = [
        CONTROL,
        "GRID,1,,0.,0.,0.\nGRID,2,,0.,0.,60.\nGRID,3,,40.,0.,60.\nGRID,9,,0.,0.,99.\n",
        "CBAR,1,7,1,2,1.,0.,0.\nCBAR,2,7,2,3,9\n",
        PROPERTY,
        MATERIAL,
        "SPC1,1,123456,1\nFORCE,2,3,,2.,0.,0.,-1.\n",
    ]
    .concat();
    let found = model(&deck);
    assert_eq!(found["joints"][0]["between"], json(r#"["CBAR 1.end", "CBAR 2.start"]"#));
    assert_eq!(found["beams"].as_array().unwrap().len(), 2);
    let bending = a.powi(3) / (3.0 * E * I[0]) + a * a * h / (E * I[0]);
    let others = h / (E * A) + a / (K[0] * G * A);
    near(-Solved::new(&deck).moved("CBAR 2.end").z, force * (bending + others), 1e-4);
}

/// A beam on two supports sags by F L³/48EI + F L/4kGA, with pin flags at clamped ends and with supports that turn.
#[test]
fn pin_flags_and_supports_of_bars_leave_rotations_free() {
    let sag = |i: f64, k: f64| L.powi(3) / (48.0 * E * i) + L / (4.0 * k * G * A);
    let pinned = cantilever(PROPERTY, "FORCE,2,3,,1.,0.,2.,0.\n")
        .replace("CBAR,1,7,1,2,0.,1.,0.\n", "CBAR,1,7,1,2,0.,1.,0.\n,6\n")
        .replace("CBAR,4,7,4,5,0.,1.,0.\n", "CBAR,4,7,4,5,0.,1.,0.\n,,6\n")
        .replace("123456,1\n", "123456,1,5\n");
    assert_eq!(model(&pinned)["joints"][0]["between"], json(r#"["ground", "CBAR 1.start"]"#));
    near(Solved::new(&pinned).moved("CBAR 1.2").y, 2.0 * sag(I[0], K[0]), 1e-6);
    let supported = cantilever(PROPERTY, "FORCE,2,3,,1.,0.,2.,3.\n")
        .replace("SPC1,1,123456,1\n", "SPC1,1,1234,1\nSPC1,1,23,5\n");
    let solved = Solved::new(&supported);
    near(solved.moved("CBAR 1.2").y, 2.0 * sag(I[0], K[0]), 1e-6);
    near(solved.moved("CBAR 1.2").z, 3.0 * sag(I[1], K[1]), 1e-6);
    // Constraints of one node are taken together.
    let symmetric = cantilever(PROPERTY, "FORCE,2,5,,1.,0.,2.,0.\n")
        .replace("123456,1\n", "156,1\nSPC1,1,345,1\nSPC1,1,2,1\n");
    assert_eq!(model(&symmetric)["joints"][0]["type"], "fixed");
}

/// Strip of shells of the width 0.1 and the thickness 0.01, with bars as a rib of 0.03 × 0.005 under its middle line, on two supports.
fn ribbed(property: &str, supports: &str, load: &str) -> String {
    let n = 20;
    let node = |i: usize, j: usize| 3 * i + j + 1;
    let mut out = String::from(CONTROL);
    for i in 0..=n {
        for j in 0..3 {
            out += &format!("GRID,{},,{:?},{:?},0.\n", node(i, j), i as f64 / n as f64, 0.05 * j as f64);
        }
    }
    for i in 0..n {
        for j in 0..2 {
            let corners =
                [node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)].map(|n| n.to_string());
            out += &format!("CQUAD4,{},3,{}\n", 2 * i + j + 1, corners.join(","));
        }
        let [a, b] = [node(i, 1), node(i + 1, 1)];
        out += &format!("CBAR,{},7,{a},{b},0.,0.,1.\n,,,0.,0.,-.02,0.,0.,-.02\n", 101 + i);
    }
    out + "MAT1,4,2.1+11,,0.,7800.\nPSHELL,3,4,.01,4,,4\n" + property + supports + load
}

/// Second moment of area of the T-section of sheet and rib.
fn of_ribbed_strip() -> f64 {
    let (sheet, rib) = (0.1 * 0.01, 0.03 * 0.005);
    let distance: f64 = 0.02;
    0.1 * 0.01_f64.powi(3) / 12.0
        + 0.005 * 0.03_f64.powi(3) / 12.0
        + sheet * rib / (sheet + rib) * distance.powi(2)
}

const RIB: &str = "PBARL,7,4,,BAR\n,.005,.03\n";

/// Under a uniform pressure the middle of a strip on two supports sags by 5 q b L⁴/384 EI, with EI of the T-section.
#[test]
fn bars_with_offsets_stiffen_a_plate_on_two_supports() {
    let supports = "SPC1,1,123,2\nSPC1,1,13,1,3\nSPC1,1,3,61,62,63\n";
    let deck = ribbed(RIB, supports, "PLOAD2,2,-100.,1,THRU,40\n");
    let found = model(&deck);
    let beam = &found["beams"][0];
    assert_eq!((&beam["attached"], &found["beams"][1]), (&json(r#"["nodes of CBAR 101"]"#), &Value::Null));
    assert_eq!(found["joints"][0]["type"], "spherical");
    let sag = 5.0 * 100.0 * 0.1 / (384.0 * 2.1e11 * of_ribbed_strip());
    near(-Solved::new(&deck).at(Vec3::new(0.5, 0.05, 0.0)).z, sag, 5e-3);
}

/// A square plate on supports along its edges with two ribs that cross in its middle: the ribs share a node of the plate, and the deflection is symmetric.
#[test]
fn crossing_bars_are_joined_at_the_node_of_the_plate() {
    let n = 8;
    let node = |i: usize, j: usize| (n + 1) * i + j + 1;
    let mut out = String::from(CONTROL);
    for i in 0..=n {
        for j in 0..=n {
            out += &format!("GRID,{},,{:?},{:?},0.\n", node(i, j), i as f64 / n as f64, j as f64 / n as f64);
            let edge = [i, j].iter().any(|k| k % n == 0);
            out += &if edge { format!("SPC1,1,3,{}\n", node(i, j)) } else { String::new() };
        }
    }
    for i in 0..n {
        for j in 0..n {
            let corners = [node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)];
            out += &format!("CQUAD4,{},3,{}\n", n * i + j + 1, corners.map(|n| n.to_string()).join(","));
        }
        let half = n / 2;
        for (k, [a, b]) in
            [[node(i, half), node(i + 1, half)], [node(half, i), node(half, i + 1)]].into_iter().enumerate()
        {
            out += &format!("CBAR,{},7,{a},{b},0.,0.,1.\n,,,0.,0.,-.02,0.,0.,-.02\n", 100 * (k + 1) + i);
        }
    }
    out += "SPC1,1,12,1\nSPC1,1,2,73\nMAT1,4,2.1+11,,.3\nPSHELL,3,4,.01,4,,4\nPLOAD2,2,-100.,1,THRU,64\n";
    let found = model(&(out.clone() + RIB));
    let between = |joint: &Value| joint["between"] == json(r#"["CBAR 100.4", "CBAR 200.4"]"#);
    assert!(found["joints"].as_array().unwrap().iter().any(between), "{}", found["joints"]);
    let solved = Solved::new(&(out + RIB));
    let sag = |x: f64, y: f64| -solved.at(Vec3::new(x, y, 0.0)).z;
    near(sag(0.25, 0.5), sag(0.5, 0.25), 1e-6);
    near(sag(0.25, 0.5), sag(0.75, 0.5), 1e-3);
    // Without ribs 0.00406 q a⁴/D (S. Timoshenko, S. Woinowsky-Krieger, *Theory of plates and shells*, Table 8).
    let bare = 0.00406 * 100.0 * 12.0 * (1.0 - 0.09) / (2.1e11 * 1e-6);
    assert!((0.1..0.6).contains(&(sag(0.5, 0.5) / bare)), "{} {bare}", sag(0.5, 0.5));
}

/// Clamped at one end, sheet and rib bend under a force at the other one by F L³/3EI.
#[test]
fn bars_end_in_the_clamp_of_their_shell() {
    let force = "FORCE,2,62,,10.,0.,0.,-1.\n";
    let deck = ribbed(RIB, "SPC1,1,123456,1,2,3\n", force);
    let found = model(&deck);
    assert_eq!(found["conditions"][0]["on"], "SPC 123456 beside bars");
    assert_eq!(
        (&found["joints"][0]["type"], &found["joints"][0]["at"]),
        (&"fixed".into(), &json("[0.0, 0.05, 0.0]"))
    );
    let sag = 10.0 / (3.0 * 2.1e11 * of_ribbed_strip());
    near(-Solved::new(&deck).at(Vec3::new(1.0, 0.05, 0.0)).z, sag, 5e-3);
    // Where the file is a mesh alone, a set has all supported nodes as without bars.
    let mesh = Nastran::parse(Path::new("frame.bdf"), deck.as_bytes(), 1.0).unwrap();
    let count = |set: &str| mesh.nodes_on(set).unwrap().len();
    assert_eq!(
        (count("SPC 123456"), count("SPC 123456 beside bars"), count("nodes of CBAR 101")),
        (3, 2, 21)
    );
    // A rigid element that holds the end of the bars has a joint with their last cross-section.
    let held = ribbed(RIB, "GRID,99,,1.2,.05,0.\nRBE2,5,99,123456,61,62,63\nSPC1,1,123456,99\n", force);
    let found = model(&held);
    assert_eq!(found["joints"][0]["between"], json(r#"["RBE2 5", "CBAR 101.end"]"#));
    assert_eq!(found["beams"][0]["attached"], json(r#"["nodes of CBAR 101"]"#));
}

/// A column of 20 bars without shear along x, of the length 1000.
fn column(control: &str, material: &str, cards: &str) -> String {
    let mut out = String::from(control);
    for i in 1..=21 {
        out += &format!("GRID,{i},,{:?},0.,0.\n", 50.0 * f64::from(i - 1));
    }
    for i in 1..=20 {
        out += &format!("CBAR,{i},7,{i},{},0.,1.,0.\n", i + 1);
    }
    out + "PBAR,7,4,100.,2000.,800.,1500.\n" + material + cards
}

/// On two supports it buckles under π² E I/L² (L. Euler) about its weak axis, y; clamped at one end its lowest frequency is 1.8751² √(EI/ρA L⁴).
#[test]
fn a_column_of_bars_has_the_buckling_load_of_euler_and_the_frequency_of_a_cantilever() {
    let prepared = |deck: String| {
        let deck = Deck::parse("column.toml", super::tests::text_of(&deck)).unwrap();
        let prepared = prepare(&deck).unwrap_or_else(|e| panic!("{e}"));
        (prepared, deck.model.analysis)
    };
    let control = "SOL 105\nCEND\nSPC = 1\nSUBCASE 1\nLOAD = 2\nSUBCASE 2\nMETHOD = 3\nBEGIN BULK\n";
    let cards = "EIGRL,3,,,1\nSPC1,1,1234,1\nSPC1,1,23,21\nFORCE,2,21,,1.,-1.,0.,0.\n";
    let (column_model, analysis) = prepared(column(control, MATERIAL, cards));
    let Analysis::Buckling(options) = &analysis else { unreachable!() };
    let found = tegula::analysis::buckling::run(&column_model.system, options, &mut Silent).unwrap();
    let euler = std::f64::consts::PI.powi(2) * E * I[1] / 1e6;
    near(found.modes[0].factor, euler, 5e-3);
    let control = "SOL 103\nCEND\nSPC = 1\nMETHOD = 3\nBEGIN BULK\n";
    let clamp = "EIGRL,3,,,1\nSPC1,1,123456,1\n";
    let (cantilever, _) = prepared(column(control, "MAT1,4,2.1+5,,.3,8.-9\n", clamp));
    let found = tegula::analysis::modal::run(&cantilever.system, 1, None, &mut Silent).unwrap();
    near(found.modes[0].omega, 1.8751_f64.powi(2) * (E * I[1] / (8e-9 * A * 1e12)).sqrt(), 5e-3);
    // Modes need a mass.
    let message = mistakes(&column(control, MATERIAL, clamp)).remove(0).1;
    assert!(message.contains("the constant `mass` is 0"), "{message}");
}

#[test]
fn requested_cross_sections_have_columns_in_the_history() {
    let deck = cantilever(PROPERTY, "FORCE,2,5,,1.,0.,1.,0.\n")
        .replace("SPC = 1\n", "SPC = 1\nSET 3 = 3,5\nDISP = 3\n");
    let found = model(&deck);
    assert_eq!(found["beams"][0]["history"], json("[0, 2, 4]"));
    assert_eq!((&found["output"]["points"], &found["analysis"]["linear"]), (&json("[]"), &false.into()));
    let warning =
        convert(Path::new("frame.bdf"), deck.as_bytes(), "frame.bdf").unwrap().warnings[0].message.clone();
    for part in [
        "C1 of PBAR (line 18), C2 of PBAR (line 18)",
        "small displacements of SOL 101 (line 1), which may have any size here, as the model has CBAR 1 (line 13)",
    ] {
        assert!(warning.contains(part), "{warning}");
    }
}

#[test]
fn bars_that_have_no_counterpart_are_refused_with_element_and_field() {
    let deck = cantilever(PROPERTY, "FORCE,2,5,,1.,0.,1.,0.\n");
    let bar = "CBAR,1,7,1,2,0.,1.,0.\n";
    for (from, to, message) in [
        (bar, "CBAR,1,7,1,2,0.,1.,0.,EOO\n", "OFFT of CBAR 1 is \"EOO\""),
        (bar, "CBAR,1,7,1,2,0.,1.,0.\n,1\n", "PA of CBAR 1 is \"1\""),
        (bar, "CBAR,1,7,1,2,0.,1.,0.\n,,45\n", "PB of CBAR 1 is \"45\""),
        (
            bar,
            "CBAR,1,7,1,2,0.,1.,0.\n,,,0.,1.\n",
            "CBAR 1 has an offset WA at node 1, which belongs to no shell",
        ),
        (bar, "CBAR,1,7,1,2,2.,0.,0.\n", "the orientation vector of CBAR 1 is zero or along the bar"),
        (bar, "CBAR,1,7,1,2\n", "the orientation vector of CBAR 1 is zero or along the bar"),
        (bar, "CBAR,1,7,1,1,0.,1.,0.\n", "both ends of CBAR 1 are in one place"),
        (bar, "CBAR,1,7,1,77,0.,1.,0.\n", "CBAR 1 needs node 77"),
        (bar, "CBAR,2,7,1,2,0.,1.,0.\n", "element 2 is defined again"),
        (bar, "CBAR,1,8,1,2,0.,1.,0.\n", "CBAR 1 needs the property 8"),
        ("CBAR,2", "CBEAM,2", "CBEAM is not read"),
        ("PBAR,7,4", "PBAR,7,5", "there is no material 5 among MAT1"),
        ("1500.\n", "0.\n", "J of PBAR 7 is 0"),
        ("1500.\n", "\n", "J of PBAR is missing"),
        (",.8,.7\n", ",.8,.7,3.\n", "the product of inertia I12 of PBAR is 3."),
        (
            "SPC1,1,123456,1\n",
            "SPC1,1,123456,1\nSPC,1,5,1,.2\n",
            "the displacement 0.2 of CBAR 1.end is prescribed",
        ),
        (PROPERTY, "PBARL,7,4,,I\n,2.\n", "the type \"I\" of PBARL 7 is not read"),
        (PROPERTY, "PBARL,7,4,,BOX\n,4.,8.,.5,.6\n", "the walls of PBARL 7 have the thicknesses 0.5 and 0.6"),
        (PROPERTY, "PBARL,7,4,MYBARS,ROD\n,4.\n", "the group \"MYBARS\" of PBARL 7"),
        (PROPERTY, "PBARL,7,4,,BAR\n,4.\n", "DIM2 of PBARL is missing"),
        (PROPERTY, "PBARL,7,4,,TUBE,4.\n,4.,2.\n", "field 6 of PBARL is 4."),
    ] {
        let changed = deck.replacen(from, to, 1);
        assert_ne!(changed, deck, "{from}");
        let found = mistakes(&changed).remove(0).1;
        assert!(found.starts_with(message), "{found}\nfor {message}");
    }
    let loose = deck.replace(bar, "CBAR,1,7,1,2,0.,1.,0.\n,456\n").replace("123456,1", "123456,5");
    assert!(mistakes(&loose)[0].1.starts_with("all bars at node 1 are released there by pin flags"));
}

proptest! {
    #[test]
    fn damaged_bars_never_panic(at in 0_usize..900, with in "[*+,=0-9a-zA-Z .$\t\n-]{0,12}", cut in 0_usize..30) {
        let more = "CQUAD4,9,3,1,2,4,5\nRBE2,5,3,123456,4,5\nRBE3,6,,5,123,1.,123,1,2,3.,123,4\nFORCE,2,5,,1.,0.,1.,0.\n";
        let deck = cantilever(PROPERTY, more);
        let start = at.min(deck.len());
        let end = (start + cut).min(deck.len());
        let damaged = format!("{}{with}{}", &deck[..start], &deck[end..]);
        if let Ok(converted) = convert(Path::new("frame.bdf"), damaged.as_bytes(), "frame.bdf") {
            let _ = Deck::parse("frame.toml", converted.text);
        }
    }
}
