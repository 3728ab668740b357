use std::collections::BTreeMap;

use super::*;
use crate::mesh::Labels;

/// Rectangles of unit squares with nodes of their own, each given by its first corner and numbers of squares; `v` lies
/// along the third axis where the rectangle stands upright.
fn sheets(list: &[([f64; 3], [u32; 2], f64, bool)]) -> Mesh {
    let mut mesh = Mesh::default();
    for &(origin, [nu, nv], size, upright) in list {
        let first = mesh.positions.len() as u32;
        let v_axis = if upright { Vec3::z() } else { Vec3::y() };
        for j in 0..=nv {
            for i in 0..=nu {
                let x = Vec3::from(origin) + (Vec3::x() * f64::from(i) + v_axis * f64::from(j)) * size;
                mesh.positions.push(x);
            }
        }
        let node = |i, j| first + j * (nu + 1) + i;
        for j in 0..nv {
            for i in 0..nu {
                mesh.quads.push([node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)]);
            }
        }
    }
    mesh
}

#[test]
fn connected_meshes_have_no_seams() {
    let mesh = sheets(&[([0.0; 3], [5, 4], 0.1, false)]);
    assert!(mesh.seams().is_empty());
    assert_eq!(mesh.parts().iter().max(), Some(&0));
    // Parts that do not touch.
    let mesh = sheets(&[([0.0; 3], [5, 4], 0.1, false), ([0.0, 0.0, 0.01], [5, 4], 0.1, false)]);
    assert!(mesh.seams().is_empty());
    assert_eq!(mesh.parts().iter().max(), Some(&1));
}

#[test]
fn parts_with_nodes_at_one_place_have_a_seam() {
    for size in [1e-6, 1.0, 1e6] {
        let mut mesh =
            sheets(&[([0.0; 3], [2, 3], size, false), ([2.0 * size, 0.0, 0.0], [4, 3], size, false)]);
        // Rounding of a mesh file.
        mesh.positions[12].y += 1e-7 * size;
        let seams = mesh.seams();
        assert_eq!(seams.len(), 1);
        assert_eq!(seams[0].coincident, [[2, 12], [5, 17], [8, 22], [11, 27]]);
        assert!(seams[0].hanging.is_empty());
        assert_eq!(seams[0].extent[1], Vec3::new(2.0 * size, 3.0 * size, 0.0));
        // Beyond the tolerance.
        mesh.positions[12].y += 2e-3 * size;
        assert_eq!(mesh.coincident_nodes().len(), 3);
    }
}

#[test]
fn each_seam_is_found_by_itself() {
    // A web on a flange, and a third sheet beside the flange.
    let mesh = sheets(&[
        ([0.0; 3], [4, 4], 1.0, false),
        ([0.0, 2.0, 0.0], [4, 1], 1.0, true),
        ([4.0, 0.0, 0.0], [1, 4], 1.0, false),
    ]);
    let seams = mesh.seams();
    // All three meet at (4, 2, 0): one seam.
    assert_eq!(seams.len(), 1);
    assert_eq!(seams[0].coincident.len(), 5 + 5 + 1);
    let apart = sheets(&[
        ([0.0; 3], [4, 4], 1.0, false),
        ([0.0, 2.0, 0.0], [2, 1], 1.0, true),
        ([4.0, 0.0, 0.0], [1, 4], 1.0, false),
    ]);
    let counts: Vec<usize> = apart.seams().iter().map(|s| s.coincident.len()).collect();
    assert_eq!(counts, [5, 3]);
}

#[test]
fn nodes_on_edges_and_faces_of_other_parts_are_found() {
    // Two rows against one: every other node hangs.
    let mesh = sheets(&[([0.0; 3], [2, 2], 1.0, false), ([2.0, 0.0, 0.0], [3, 4], 0.5, false)]);
    let seams = mesh.seams();
    assert_eq!(seams.len(), 1);
    assert_eq!(seams[0].coincident, [[2, 9], [5, 17], [8, 25]]);
    assert_eq!(seams[0].hanging, [Hanging { node: 13, quad: 1 }, Hanging { node: 21, quad: 3 }]);
    // A web that stands in the middle of elements.
    let mesh = sheets(&[([0.0; 3], [3, 3], 1.0, false), ([0.5, 1.3, 0.0], [1, 1], 1.0, true)]);
    let seams = mesh.seams();
    assert_eq!(seams.len(), 1);
    assert!(seams[0].coincident.is_empty());
    assert_eq!(seams[0].hanging, [Hanging { node: 16, quad: 3 }, Hanging { node: 17, quad: 4 }]);
}

#[test]
fn merged_nodes_take_their_sets_with_them() {
    let mut mesh = sheets(&[([0.0; 3], [1, 1], 1.0, false), ([1.0, 0.0, 0.0], [1, 1], 1.0, false)]);
    mesh.positions.push(Vec3::new(1.0, 0.0, 0.0));
    mesh.node_sets = BTreeMap::from([("seam".into(), vec![3, 1, 4, 6]), ("right".into(), vec![7, 5])]);
    mesh.edge_sets = BTreeMap::from([("edge".into(), vec![[4, 6], [5, 7]])]);
    mesh.quad_sets = BTreeMap::from([("second".into(), vec![1])]);
    mesh.labels = Some(Labels { file: "a.msh".into(), nodes: (10..19).collect(), quads: vec![7, 8] });
    assert_eq!(mesh.merge_coincident_nodes(), Ok(2));
    assert_eq!(mesh.quads, [[0, 1, 3, 2], [1, 4, 5, 3]]);
    assert_eq!(mesh.node_sets["seam"], [3, 1]);
    assert_eq!(mesh.node_sets["right"], [5, 4]);
    assert_eq!(mesh.edge_sets["edge"], [[1, 3], [4, 5]]);
    // A node without elements is left alone.
    assert_eq!((mesh.positions.len(), mesh.node_label(4), mesh.node_label(6)), (7, 15, 18));
    assert!(mesh.seams().is_empty());
    assert_eq!(mesh.merge_coincident_nodes(), Ok(0));
}

#[test]
fn merging_does_not_collapse_elements() {
    let mut mesh = sheets(&[([0.0; 3], [1, 1], 1.0, false), ([1.0, 0.0, 0.0], [1, 1], 1.0, false)]);
    // A triangle, written as a quad with two nodes at one place.
    mesh.positions.extend([Vec3::new(1.0, -1.0, 0.0), Vec3::x(), Vec3::x()]);
    mesh.positions.push(Vec3::new(0.0, -1.0, 0.0));
    mesh.quads.push([8, 9, 10, 11]);
    let issues = mesh.merge_coincident_nodes().unwrap_err();
    assert_eq!(issues.len(), 1);
    assert!(issues[0].message.contains("would collapse element 2 at node 10"), "{}", issues[0]);
}

#[test]
fn seams_are_found_at_every_scale_of_a_graded_mesh() {
    let pair = |k: i32| {
        let (size, z) = (0.1_f64.powi(k), 5.0 * f64::from(k));
        [([0.0, 0.0, z], [40, 20], size, false), ([40.0 * size, 0.0, z], [40, 20], size, false)]
    };
    let mesh = sheets(&(0..6).flat_map(pair).collect::<Vec<_>>());
    let seams = mesh.seams();
    assert_eq!(seams.len(), 6);
    assert!(seams.iter().all(|s| s.coincident.len() == 21 && s.hanging.is_empty()));
}
