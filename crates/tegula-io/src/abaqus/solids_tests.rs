#![allow(clippy::unwrap_used)]

use std::path::Path;

use proptest::prelude::*;
use tegula::Vec3;

use super::convert;
use super::tests::{json, mistakes};
use crate::deck::Deck;
use crate::mesh::MeshReader;
use crate::mesh::abaqus::Abaqus;
use crate::mesh::gmsh::Gmsh;
use crate::solved::{Solved, near};

const E: f64 = 2.1e5;
const L: f64 = 100.0;
const B: f64 = 10.0;
const H: f64 = 2.0;
/// Elements along the strip and across it.
const N: [usize; 2] = [20, 2];
const CLAMP: &str = "Root, ENCASTRE\n";
const FORCE: &str = "*CLOAD\nTip, 3, -0.5\n";

/// Number of a node: along the strip, across it, and 0 at the bottom or 1 at the top.
fn node(i: usize, j: usize, k: usize) -> usize {
    1 + i + (N[0] + 1) * (j + (N[1] + 1) * k)
}

/// Nodes with their places.
fn nodes() -> Vec<(usize, [f64; 3])> {
    let mut out = Vec::new();
    for k in 0..2 {
        for j in 0..=N[1] {
            for i in 0..=N[0] {
                let at = [L * i as f64 / N[0] as f64, B * j as f64 / N[1] as f64, H * (k as f64 - 0.5)];
                out.push((node(i, j, k), at));
            }
        }
    }
    out
}

/// Nodes of the elements.
fn elements() -> Vec<[usize; 8]> {
    let mut out = Vec::new();
    for j in 0..N[1] {
        for i in 0..N[0] {
            let side = |k| [node(i, j, k), node(i + 1, j, k), node(i + 1, j + 1, k), node(i, j + 1, k)];
            let ([a, b, c, d], [e, f, g, h]) = (side(0), side(1));
            out.push([a, b, c, d, e, f, g, h]);
        }
    }
    out
}

fn listed(numbers: impl IntoIterator<Item = usize>, between: &str) -> String {
    numbers.into_iter().map(|n| n.to_string()).collect::<Vec<_>>().join(between)
}

/// Nodes of an end of the strip, at the bottom and at the top.
fn end(i: usize) -> [Vec<usize>; 2] {
    [0, 1].map(|k| (0..=N[1]).map(|j| node(i, j, k)).collect())
}

/// Strip of continuum shells of the thickness 2 in the plane of x and y.
fn strip(poisson: f64, supports: &str, loads: &str) -> String {
    let mut out = String::from("*NODE, NSET=Nall\n");
    for (number, [x, y, z]) in nodes() {
        out += &format!("{number}, {x:?}, {y:?}, {z:?}\n");
    }
    out += "*ELEMENT, TYPE=SC8R, ELSET=Plate\n";
    for (i, corners) in elements().into_iter().enumerate() {
        // A list of nodes may continue on the next line.
        let [first, second] = [&corners[..5], &corners[5..]].map(|of| listed(of.iter().copied(), ", "));
        out += &format!("{}, {first},\n{second}\n", i + 1);
    }
    for (name, i) in [("Root", 0), ("Tip", N[0])] {
        let [bottom, top] = end(i).map(|of| listed(of, ", "));
        out += &format!(
            "*NSET, NSET={name} bottom\n{bottom}\n*NSET, NSET={name} top\n{top}\n*NSET, NSET={name}\n{name} bottom, {name} top\n"
        );
    }
    format!(
        "{out}*MATERIAL, NAME=Steel\n*ELASTIC\n2.1e5, {poisson}\n*SHELL SECTION, ELSET=Plate, MATERIAL=Steel, STACK DIRECTION=3\n2., 5\n\
         *BOUNDARY\n{supports}*STEP\n*STATIC\n{loads}*NODE PRINT, NSET=Tip\nU\n*END STEP\n"
    )
}

/// Strip as a file of Gmsh in the format 2.2, with both ends as physical surfaces.
fn gmsh() -> String {
    let mut out = String::from(
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n3\n2 1 \"Root\"\n2 2 \"Tip\"\n3 3 \"Plate\"\n$EndPhysicalNames\n",
    );
    let nodes = nodes();
    out += &format!("$Nodes\n{}\n", nodes.len());
    for (number, [x, y, z]) in nodes {
        out += &format!("{number} {x:?} {y:?} {z:?}\n");
    }
    let mut lines = Vec::new();
    for (group, i) in [(1, 0), (2, N[0])] {
        for j in 0..N[1] {
            let corners = [node(i, j, 0), node(i, j + 1, 0), node(i, j + 1, 1), node(i, j, 1)];
            lines.push(format!("3 2 {group} {group} {}", listed(corners, " ")));
        }
    }
    lines.extend(elements().into_iter().map(|corners| format!("5 2 3 1 {}", listed(corners, " "))));
    out += &format!("$EndNodes\n$Elements\n{}\n", lines.len());
    for (i, line) in lines.iter().enumerate() {
        out += &format!("{} {line}\n", i + 1);
    }
    out + "$EndElements\n"
}

fn model(deck: &str) -> serde_json::Value {
    let converted =
        convert(Path::new("s.inp"), deck.as_bytes(), "s.inp").unwrap_or_else(|e| panic!("{e:#?}"));
    serde_json::to_value(Deck::parse("s.toml", converted.text).unwrap().model).unwrap()
}

/// Displacement of the middle of the tip.
fn tip(deck: &str) -> Vec3 {
    Solved::new(deck).at(Vec3::new(L, 0.5 * B, 0.0))
}

#[test]
fn continuum_shells_are_the_middle_surface_of_hexahedra() {
    let deck = strip(0.3, CLAMP, FORCE);
    let mesh = Abaqus::parse(Path::new("s.inp"), deck.as_bytes(), 0.5).unwrap();
    let of_gmsh = Gmsh::parse(Path::new("s.msh"), gmsh().as_bytes(), 0.5).unwrap();
    assert_eq!((&mesh.positions, &mesh.quads), (&of_gmsh.positions, &of_gmsh.quads));
    assert_eq!((&mesh.normals, &mesh.thickness), (&of_gmsh.normals, &of_gmsh.thickness));
    for set in ["Root", "Root top", "Root bottom"] {
        assert_eq!(mesh.nodes_on(set), of_gmsh.nodes_on("Root"), "{set}");
    }
}

#[test]
fn a_cantilever_of_continuum_shells_is_that_of_hexahedra_and_of_beam_theory() {
    let found = model(&strip(0.3, CLAMP, FORCE));
    let section = &found["sections"][0];
    assert_eq!((&section["element"], &section["thickness"]), (&"solid-shell".into(), &json("2.0")));
    assert_eq!(found["conditions"], json(r#"[{"type": "clamp", "on": "Root"}]"#));
    assert_eq!(found["loads"][0]["value"], json("[0.0, 0.0, -1.0]"));
    assert_eq!(found["output"]["points"][0]["name"], "Tip 21 and 84");
    // Three nodes with a force of 1 each.
    let bending = 3.0 * L.powi(3) / (3.0 * E * B * H.powi(3) / 12.0);
    let shear = 3.0 * L / (5.0 / 6.0 * 0.5 * E * B * H);
    near(-tip(&strip(0.0, CLAMP, FORCE)).z, bending + shear, 2e-3);
    // The same model with the mesh of Gmsh.
    let folder = tempfile::tempdir().unwrap();
    let text = convert(Path::new("s.inp"), strip(0.3, CLAMP, FORCE).as_bytes(), "s.msh").unwrap().text;
    std::fs::write(folder.path().join("s.msh"), gmsh()).unwrap();
    let path = folder.path().join("s.toml");
    let (text, _) = text.split_once("\n[[output").unwrap();
    std::fs::write(&path, text.replace("\"abaqus\"", "\"gmsh\"")).unwrap();
    let of_gmsh = Solved::of(&Deck::read(&path).unwrap_or_else(|e| panic!("{e:#?}")));
    let own = tip(&strip(0.3, CLAMP, FORCE));
    let other = of_gmsh.at(Vec3::new(L, 0.5 * B, 0.0));
    assert!((own - other).norm() <= 1e-9 * other.norm(), "{own} {other}");
}

#[test]
fn pressures_act_into_the_elements() {
    let bent = |load: &str| tip(&strip(0.0, CLAMP, &format!("*DLOAD\nPlate, {load}\n"))).z;
    let sag = 0.01 * B * L.powi(4) / (8.0 * E * B * H.powi(3) / 12.0);
    near(-bent("P2, 0.01"), sag, 1e-2);
    near(bent("P1, 0.01"), sag, 1e-2);
    near(-bent("P2, 0.03\nPlate, P1, 0.02"), sag, 1e-2);
}

/// Displacements of the bottom and the top along x stretch and turn the end: a strip whose end turns by θ bends to a circle, and its end moves by θ L/2.
#[test]
fn displacements_of_both_sides_move_and_turn_the_middle_surface() {
    let turned = "Root, 1, 3\nTip bottom, 1, 1, 0.01\nTip top, 1, 1, -0.01\n";
    let deck = strip(0.0, turned, "");
    assert_eq!(
        model(&deck)["conditions"],
        json(
            r#"[{"type": "clamp", "on": "Root"},
            {"type": "fix", "on": "Tip bottom", "position": ["x"], "director": []},
            {"type": "prescribe", "on": "Tip bottom", "of": "director", "component": "x", "value": -0.01}]"#
        )
    );
    near(tip(&deck).z, 0.01 * L / 2.0, 1e-3);
    let both = model(&strip(0.0, "Root, 1, 3\nTip, 1, 1, 0.02\nRoot top, 2\n", ""))["conditions"].clone();
    assert_eq!(
        both,
        json(
            r#"[{"type": "clamp", "on": "Root"},
            {"type": "fix", "on": "Tip", "position": [], "director": ["x"]},
            {"type": "prescribe", "on": "Tip", "of": "position", "component": "x", "value": 0.02},
            {"type": "fix", "on": "Root top", "position": ["y"], "director": ["y"]}]"#
        )
    );
    // A plane of symmetry, by sets of both sides, each of which is written once.
    let symmetric = model(&strip(0.0, "Root bottom, XSYMM\nRoot top, XSYMM\n", ""))["conditions"].clone();
    let expected = r#"[{"type": "fix", "on": "Root bottom", "position": ["x"], "director": ["x"]}]"#;
    assert_eq!(symmetric, json(expected));
}

/// Thicknesses of layers are parts of the thickness of the elements.
#[test]
fn layers_fill_the_thickness_of_the_elements() {
    let deck = strip(0.3, CLAMP, FORCE).replace(
        "MATERIAL=Steel, STACK DIRECTION=3\n2., 5\n",
        "COMPOSITE\n0.3, 3, Steel, 0.\n0.1, 3, Steel, 90.\n",
    );
    let plies = model(&deck)["sections"][0]["layup"]["plies"].clone();
    near(plies[0]["thickness"].as_f64().unwrap(), 1.5, 1e-12);
    near(plies[1]["thickness"].as_f64().unwrap(), 0.5, 1e-12);
    // Of one material they are one layer.
    near(tip(&deck).z, tip(&strip(0.3, CLAMP, FORCE)).z, 1e-6);
}

#[test]
fn continuum_shells_that_have_no_counterpart_are_refused_by_line() {
    let deck = strip(0.3, CLAMP, FORCE);
    let line = |deck: &str, text: &str| deck.lines().position(|line| line.starts_with(text)).unwrap() + 1;
    let corners = "1, 1, 2, 23, 22, 64,\n65, 86, 85\n";
    for (from, to, at, message) in [
        ("STACK DIRECTION=3", "STACK DIRECTION=1", "*SHELL SECTION", "STACK DIRECTION=1 is not read"),
        ("\n2., 5\n", "\n2.1, 5\n", "2.1, 5", "the section is 2.1 thick, but the mesh is 2.000000 thick"),
        (CLAMP, "Root top, 1, 3\n", "Root top, 1", "node 64 is held along x, and node 1 on the other side"),
        (CLAMP, "Root, 1, 3\nTip top, 1, 1, 0.1\n", "Tip top, 1", "node 84 is held along x, and node 21 on"),
        (CLAMP, "Root, 4, 4, 0.1\n", "Root, 4", "the rotation 0.1 is prescribed, and nodes of continuum"),
        ("Tip, 3, -0.5", "Tip top, 3, -0.5", "Tip top, 3", "node 84 is loaded along z, and node 21 on"),
        (
            "Tip, 3, -0.5",
            "Tip top, 3, 1.\nTip bottom, 3, 2.",
            "Tip top, 3",
            "the nodes of Tip top at the bottom have the force 2",
        ),
        ("Tip, 3, -0.5", "Tip, 4, -0.5", "Tip, 4", "nodes of continuum shells have no rotations, so they"),
        ("*CLOAD", "*CLOAD, FOLLOWER", "Tip, 3", "nodes of continuum shells have no rotations, so they"),
        (FORCE, "*DLOAD\nPlate, P, 1.\n", "Plate, P", "P does not act on the elements of Plate"),
        (FORCE, "*DLOAD\nPlate, P3, 1.\n", "Plate, P3", "the distributed load \"P3\" is not read"),
        (corners, "1, 64, 65, 86, 85, 1,\n2, 23, 22\n", "2, 2, 3", "element 2 does not continue the layer"),
        (
            corners,
            "1, 22, 23, 2, 1, 85,\n86, 65, 64\n",
            "1, 22",
            "the nodes 5 to 8 of element 1 do not lie above",
        ),
        (corners, "1, 1, 2, 23, 22, 64,\n65, 86\n", "65, 86", "element 1 has 7 nodes, and an SC8R has 8"),
        (
            "*NSET, NSET=Root bottom",
            "*ELEMENT, TYPE=S4\n99, 1, 2, 23, 22\n*NSET, NSET=Root bottom",
            "1, 1, 2",
            "the file has continuum shells SC8R, and shells S4",
        ),
        (
            "*NSET, NSET=Root bottom",
            "*ELEMENT, TYPE=B31\n99, 1, 2\n*NSET, NSET=Root bottom",
            "99, 1, 2",
            "the B31 99 has the node 1 of a continuum shell",
        ),
    ] {
        let changed = deck.replacen(from, to, 1);
        assert_ne!(changed, deck, "{from}");
        let (found, line) = (mistakes(&changed), line(&changed, at));
        assert!(
            found.iter().any(|(at, told)| *at == line && told.starts_with(message)),
            "{found:?}\nfor {line} {message}"
        );
    }
}

proptest! {
    #[test]
    fn damaged_continuum_shells_never_panic(at in 0_usize..2600, with in "[*,=0-9a-zA-Z .\n-]{0,12}", cut in 0_usize..30) {
        let deck = strip(0.3, CLAMP, FORCE);
        let from = deck.find("*ELEMENT").unwrap();
        let start = (from + at).min(deck.len());
        let end = (start + cut).min(deck.len());
        let damaged = format!("{}{with}{}", &deck[..start], &deck[end..]);
        if let Ok(converted) = convert(Path::new("s.inp"), damaged.as_bytes(), "s.inp") {
            let _ = Deck::parse("s.toml", converted.text);
        }
    }
}
