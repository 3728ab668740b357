//! Mesh files of several parts and of folded sheets, from the model file on.

use std::fs;
use std::path::Path;

use tegula::analysis::{Silent, statics};
use tegula::model::Analysis;

use super::super::*;
use crate::deck::Deck;

/// Text of a mesh file of rows of elements of width 1 in y: each strip goes through its points (x, z) with nodes of its own,
/// 4 elements wide; the first and last row of nodes of all strips are the sets `left` and `right`.
fn strips(list: &[&[[f64; 2]]]) -> String {
    let (mut nodes, mut quads) = (String::new(), String::new());
    let (mut count, mut elements) = (0, 0);
    let mut element = |kind: u32, physical: u32, nodes: &[usize], quads: &mut String| {
        elements += 1;
        let list: Vec<String> = nodes.iter().map(usize::to_string).collect();
        quads.push_str(&format!("{elements} {kind} 2 {physical} {physical} {}\n", list.join(" ")));
    };
    for (s, points) in list.iter().enumerate() {
        let first = count;
        for [x, z] in *points {
            for j in 0..5 {
                count += 1;
                nodes.push_str(&format!("{count} {x} {} {z}\n", 0.25 * f64::from(j)));
            }
        }
        let node = |i: usize, j: usize| first + 1 + 5 * i + j;
        let last = points.len() - 1;
        for j in 0..4 {
            if s == 0 {
                element(1, 2, &[node(0, j), node(0, j + 1)], &mut quads);
            }
            if s + 1 == list.len() {
                element(1, 3, &[node(last, j), node(last, j + 1)], &mut quads);
            }
            for i in 0..last {
                element(3, 1, &[node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)], &mut quads);
            }
        }
    }
    format!(
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n3\n2 1 \"sheet\"\n1 2 \"left\"\n1 3 \"right\"\n\
         $EndPhysicalNames\n$Nodes\n{count}\n{nodes}$EndNodes\n$Elements\n{elements}\n{quads}$EndElements\n"
    )
}

fn deck(folder: &Path, mesh: &str, keys: &str) -> Deck {
    fs::write(folder.join("parts.msh"), mesh).unwrap();
    let text = format!(
        r#"
[analysis]
type = "static"
linear = true
[mesh]
type = "gmsh"
file = "parts.msh"
{keys}
[materials.steel]
type = "isotropic"
young = 1e9
poisson = 0.0
[[sections]]
material = "steel"
thickness = 0.02
[[conditions]]
type = "clamp"
on = "left"
[[conditions]]
type = "clamp"
on = "right"
[[loads]]
type = "traction"
on = "sheet"
value = [0.0, 0.0, 1.0]
"#
    );
    Deck::parse(folder.join("parts.toml"), text).unwrap()
}

/// Deflection at (1, 0, 0), and the warnings.
fn deflection(deck: &Deck) -> (f64, Vec<String>) {
    let prepared = prepare(deck).unwrap_or_else(|e| panic!("{e}"));
    let Analysis::Static(options) = &deck.model.analysis else { unreachable!() };
    let outcome = statics::run(&prepared.system, options, None, &mut Silent).unwrap();
    let node = prepared.mesh.nearest_node(tegula::Vec3::x()).unwrap();
    let warnings = prepared.warnings.iter().map(|w| format!("{}: {}", w.key, w.message)).collect();
    (outcome.state.u[prepared.system.coordinates.position_of[node as usize] as usize][2], warnings)
}

/// A beam of length 2 and stiffness EI, clamped at both ends, sags by `q 2⁴/384 EI`, and by `q/8 EI` with a cut in its
/// middle, shear apart.
#[test]
fn parts_meshed_apart_are_warned_about_and_merged_where_asked() {
    let folder = tempfile::tempdir().unwrap();
    let points: Vec<[f64; 2]> = (0..=80).map(|i| [f64::from(i) / 40.0, 0.0]).collect();
    let apart = strips(&[&points[..41], &points[40..]]);
    let stiffness = 1e9 * 0.02_f64.powi(3) / 12.0;
    let shear = 1.0 / (5.0 / 6.0 * 0.5e9 * 0.02);
    let joined = 16.0 / (384.0 * stiffness) + 0.5 * shear;
    let near =
        |found: f64, expected: f64| assert!((found / expected - 1.0).abs() < 2e-3, "{found} {expected}");
    let (sag, warnings) = deflection(&deck(folder.path(), &apart, ""));
    near(sag, 1.0 / (8.0 * stiffness) + 0.5 * shear);
    assert_eq!(
        warnings,
        [
            "mesh.merge_coincident: 2 parts of the mesh touch without being connected: 5 pairs of nodes coincide between \
          (1.0, 0.0, 0.0) and (1.0, 1.0, 0.0): 201 and 206, 202 and 207, 203 and 208, 204 and 209, and 1 more"
        ]
    );
    let (sag, warnings) = deflection(&deck(folder.path(), &apart, "merge_coincident = true"));
    near(sag, joined);
    assert!(warnings.is_empty(), "{warnings:?}");
    let (sag, warnings) = deflection(&deck(folder.path(), &apart, "merge_coincident = false"));
    near(sag, 1.0 / (8.0 * stiffness) + 0.5 * shear);
    assert!(warnings.is_empty(), "{warnings:?}");
    let whole = strips(&[&points]);
    let (sag, warnings) = deflection(&deck(folder.path(), &whole, ""));
    near(sag, joined);
    assert!(warnings.is_empty(), "{warnings:?}");
}

/// Facets of a cylinder that meet at 22.5 degrees count as folds only with a warning.
#[test]
fn coarse_curved_surfaces_are_warned_about() {
    let folder = tempfile::tempdir().unwrap();
    let arc: Vec<[f64; 2]> = (0..=4)
        .map(|k| (22.5 * f64::from(k)).to_radians())
        .map(|angle| [2.0 * angle.sin(), 2.0 * angle.cos()])
        .collect();
    let mesh = strips(&[&arc]);
    let of = |keys: &str| {
        let prepared = prepare(&deck(folder.path(), &mesh, keys)).unwrap_or_else(|e| panic!("{e}"));
        let warnings: Vec<String> =
            prepared.warnings.iter().map(|w| format!("{}: {}", w.key, w.message)).collect();
        (prepared.system.folds.lines.len(), warnings)
    };
    let (folds, warnings) = of("");
    assert_eq!((folds, warnings.len()), (3, 1), "{warnings:?}");
    assert!(
        warnings[0]
            .starts_with("mesh.file: 8 elements lie between two folds of 22.5 degrees in the same sense"),
        "{warnings:?}"
    );
    assert_eq!(of("fold_angle = 30"), (0, vec![]));
    assert_eq!(of("fold_angle = 20"), (3, vec![]));
    let Err(JobError::Model(found)) = prepare(&deck(folder.path(), &mesh, "fold_angle = 0.5")) else {
        panic!("no model error")
    };
    assert_eq!((found.len(), found[0].key.as_str()), (1, "mesh.fold_angle"));
}
