#![allow(clippy::unwrap_used)]

use std::path::{Path, PathBuf};

use proptest::prelude::*;
use tegula::mesh::FieldValues;
use tegula::{Mesh, Vec3};

use super::{parse, read};

fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name)
}

fn load(name: &str) -> Mesh {
    read(&data(name), 1.0).unwrap_or_else(|error| panic!("{error}"))
}

fn assert_same(a: &Mesh, b: &Mesh) {
    assert_eq!(a.positions.len(), b.positions.len());
    for (x, y) in a.positions.iter().zip(&b.positions) {
        assert!((x - y).norm() < 1e-12, "{x} {y}");
    }
    assert_eq!(a.quads, b.quads);
    assert_eq!((&a.node_sets, &a.edge_sets, &a.quad_sets), (&b.node_sets, &b.edge_sets, &b.quad_sets));
}

fn area(mesh: &Mesh) -> Vec3 {
    let node = |i: u32| mesh.positions[i as usize];
    mesh.quads.iter().map(|&[a, b, c, d]| (node(c) - node(a)).cross(&(node(d) - node(b))) / 2.0).sum()
}

/// Error of a text, as printed.
fn error(text: &str) -> String {
    parse(Path::new("m.msh"), text.as_bytes(), 1.0).unwrap_err().to_string()
}

/// One quad in format 2.2 with the given further elements.
fn square(elements: &[&str]) -> String {
    format!(
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n\
         $PhysicalNames\n3\n0 1 \"tip\"\n1 2 \"side\"\n2 3 \"all\"\n$EndPhysicalNames\n\
         $Nodes\n5\n10 0 0 0\n20 1 0 0\n30 1 1 0\n40 0 1 0\n50 7 7 7\n$EndNodes\n\
         $Elements\n{}\n1 3 2 0 1 10 20 30 40\n{}\n$EndElements\n",
        elements.len() + 1,
        elements.join("\n")
    )
}

#[test]
fn all_variants_give_the_same_plate() {
    let mesh = load("plate-4-ascii.msh");
    assert_eq!((mesh.positions.len(), mesh.quads.len()), (15, 8));
    assert!((area(&mesh) - Vec3::new(0.0, 0.0, 2.0)).norm() < 1e-12);
    assert_eq!(mesh.node_sets["corner"], [3]);
    assert_eq!(mesh.node_sets["ends"], [0, 3]);
    assert_eq!(mesh.edge_sets["fixed edge"], [[5, 11], [11, 0]]);
    assert_eq!(mesh.edge_sets["seam"].len(), 2);
    assert_eq!(mesh.edge_sets["33"].len(), 4);
    assert_eq!(mesh.quad_sets["left"], [0, 1, 2, 3]);
    assert_eq!(mesh.quad_sets["right"], [4, 5, 6, 7]);
    assert_eq!(mesh.quad_sets["whole"], [0, 1, 2, 3, 4, 5, 6, 7]);
    for variant in ["2-ascii", "2-binary", "2-big-endian", "4-binary", "4-big-endian", "4-32-bit"] {
        assert_same(&mesh, &load(&format!("plate-{variant}.msh")));
    }
}

#[test]
fn all_variants_give_the_same_cylinder() {
    let mesh = load("cylinder-2-ascii.msh");
    assert_eq!((mesh.positions.len(), mesh.quads.len()), (20, 12));
    for p in &mesh.positions {
        assert!((p.xy().norm() - 2.0).abs() < 1e-12);
    }
    assert_eq!((mesh.edge_sets["bottom"].len(), mesh.edge_sets["top"].len()), (4, 4));
    for variant in ["2-binary", "4-ascii", "4-binary"] {
        assert_same(&mesh, &load(&format!("cylinder-{variant}.msh")));
    }
}

#[test]
fn a_negative_physical_group_turns_its_quads_around() {
    for variant in ["2-ascii", "2-binary", "4-ascii", "4-binary"] {
        let mesh = load(&format!("reversed-{variant}.msh"));
        assert_eq!(mesh.quads, [[0, 3, 2, 1]], "{variant}");
        assert_eq!(mesh.quad_sets["turned"], [0]);
        assert!((area(&mesh) - Vec3::new(0.0, 0.0, -1.0)).norm() < 1e-15);
    }
}

#[test]
fn coordinates_are_scaled() {
    let mesh = read(&data("plate-4-binary.msh"), 1e-3).unwrap();
    assert!((area(&mesh).z - 2e-6).abs() < 1e-18);
}

#[test]
fn node_numbers_may_have_gaps_and_unknown_sections_are_skipped() {
    let text = square(&["2 1 2 2 1 30 20", "3 15 2 1 1 30", "4 15 2 1 1 30", "5 3 2 3 1 10 20 30 40"]);
    let text = text.replace("$Nodes", "$Comments\n$Nodes 3\n$EndComments\r\n$Nodes");
    let mesh = parse(Path::new("m.msh"), text.as_bytes(), 1.0).unwrap();
    assert_eq!(mesh.positions.len(), 4);
    assert_eq!(mesh.quads, [[0, 1, 2, 3]]);
    assert_eq!(mesh.node_sets["tip"], [2]);
    assert_eq!(mesh.edge_sets["side"], [[2, 1]]);
    assert_eq!(mesh.quad_sets["all"], [0]);
}

#[test]
fn files_that_are_no_mesh() {
    let missing = read(Path::new("no/such.msh"), 1.0).unwrap_err();
    assert_eq!(
        missing.to_string(),
        "no/such.msh: there is no such mesh file\n  help: check the path; it is relative to the model file"
    );
    assert_eq!(missing.issue().place.key, "mesh.file");
    let directory = read(&data(""), 1.0).unwrap_err();
    assert_eq!(directory.message, "this is a directory, not a mesh file");
    assert_eq!(
        error(" \n"),
        "m.msh: the mesh file is empty\n  help: save the mesh again in Gmsh (File > Save Mesh)"
    );
    let scale = parse(Path::new("m.msh"), b"", 0.0).unwrap_err();
    assert_eq!(
        scale.to_string(),
        "m.msh: the factor on the coordinates is 0\n  help: give a scale above 0, such as 0.001 for a mesh drawn in millimetres"
    );
    const SAVE: &str = "save it as \"Version 4.1\" or \"Version 2 ASCII\" in Gmsh (File > Export, .msh)";
    assert_eq!(
        error("solid ascii\n"),
        format!("m.msh:1: this is not a Gmsh mesh: it does not begin with $MeshFormat\n  help: {SAVE}")
    );
    assert_eq!(
        error("$MeshFormat\n4.1 0\n"),
        format!("m.msh:2: expected version, file type and data size, found \"4.1 0\"\n  help: {SAVE}")
    );
    assert_eq!(
        error("$MeshFormat\n4 0 8\n$EndMeshFormat\n"),
        "m.msh:2: format 4 is not read, only 2.2 and 4.1\n  help: save it with \"Mesh.MshFileVersion = 4.1;\" in the .geo file, or gmsh -format msh41"
    );
    assert_eq!(
        error("$MeshFormat\n4.1 2 8\n"),
        format!("m.msh:2: the file type is \"2\", neither 0 (ASCII) nor 1 (binary)\n  help: {SAVE}")
    );
    assert_eq!(
        error("$MeshFormat\n4.1 1 16\n"),
        format!("m.msh:2: numbers of 16 bytes are not read, only 4 or 8\n  help: {SAVE}")
    );
    assert_eq!(
        error("$MeshFormat\n4.1 1 8\nabcd\n"),
        "m.msh:2: the number 1 that shows the byte order is missing\n  help: the file is damaged: save the mesh again in Gmsh"
    );
    assert_eq!(
        error("$MeshFormat\n4.1 0 8\n$EndMeshFormat\n"),
        "m.msh: the mesh holds no quadrilaterals\n  help: mesh the surfaces in Gmsh (gmsh -2) with \"Recombine Surface {:};\"; once there are physical groups only their elements are saved, so give the surfaces one, too"
    );
}

#[test]
fn elements_that_cannot_be_computed_are_named_with_the_remedy() {
    let help = "recombine the triangles with \"Recombine Surface {:};\" in the .geo file or Mesh > Recombine 2D in Gmsh, and where some remain add \"Mesh.SubdivisionAlgorithm = 1;\"";
    let message = "the mesh holds 8 triangles of 3 nodes (the first is element 1), but only quadrilaterals of 4 nodes and one layer of hexahedra of 8 nodes can be computed";
    let place = |name: &str| read(&data(name), 1.0).unwrap_err().to_string();
    let path = data("triangles-4-ascii.msh");
    assert_eq!(place("triangles-4-ascii.msh"), format!("{}:53: {message}\n  help: {help}", path.display()));
    let path = data("triangles-4-binary.msh");
    assert_eq!(
        place("triangles-4-binary.msh"),
        format!("{}: byte 1259: {message}\n  help: {help}", path.display())
    );

    let order = "use order 1: \"Mesh.ElementOrder = 1;\" in the .geo file or Mesh > Set order 1 in Gmsh";
    let second = read(&data("plate-4-second-order.msh"), 1.0).unwrap_err();
    assert_eq!(
        second.message,
        "the mesh holds 8 lines of 3 nodes (the first is element 3), 8 quadrilaterals of 9 nodes (the first is element 11), but only quadrilaterals of 4 nodes and one layer of hexahedra of 8 nodes can be computed"
    );
    assert_eq!(second.help, order);

    assert_eq!(
        error(&square(&["2 4 2 0 1 10 20 30 40"])),
        "m.msh:21: the mesh holds 1 solid of 4 nodes (element 2), but only quadrilaterals of 4 nodes and one layer of hexahedra of 8 nodes can be computed\n  help: mesh the surfaces only (gmsh -2) and give no physical volume, or extrude them by one layer with \"Layers{1}; Recombine;\""
    );
    assert_eq!(
        error(&square(&["2 9 0 10 20 30 40 10 20"])),
        format!(
            "m.msh:21: the mesh holds 1 triangle of 6 nodes (element 2), but only quadrilaterals of 4 nodes and one layer of hexahedra of 8 nodes can be computed\n  help: {help}; {order}"
        )
    );
    assert_eq!(
        error(&square(&["2 99 0 10"])),
        "m.msh:21: element 2 is of type 99, which is unknown here\n  help: use quadrilaterals of order 1: \"Recombine Surface {:};\" and \"Mesh.ElementOrder = 1;\" in the .geo file"
    );
}

#[test]
fn nodes_and_groups_that_do_not_fit() {
    assert_eq!(
        error(&square(&["2 15 2 1 1 50"])),
        "m.msh:21: node 50 of the physical point \"tip\" belongs to no element\n  help: put the point into its surface with \"Point{…} In Surface{…};\" in the .geo file, or take it out of the group"
    );
    assert_eq!(
        error(&square(&["2 1 2 2 1 10 30"])),
        "m.msh:21: the line from node 10 to node 30 of the physical curve \"side\" is not the side of an element\n  help: put the curve into its surface with \"Curve{…} In Surface{…};\" in the .geo file, or take it out of the group"
    );
    assert_eq!(
        error(&square(&["2 3 2 0 1 10 20 30 60"])),
        "m.msh:21: element 2 needs node 60, which $Nodes does not list\n  help: the file is damaged: save the mesh again in Gmsh"
    );
    assert_eq!(
        error(&square(&["2 3 2 0 1 10 20 30 10"])),
        "m.msh:21: element 2 has node 10 at two corners\n  help: remove collapsed quadrilaterals, such as those at the pole of a sphere: mesh that part unstructured"
    );
    assert_eq!(
        error(&square(&["2 3 2 3 1 10 20 30 50"])),
        "m.msh: the element set \"all\" holds 1 of 2 elements\n  help: \"all\" stands for the whole mesh in model files: give the set another name"
    );
    assert_eq!(
        error(&square(&[]).replace("50 7 7 7", "50 7 nan 7")),
        "m.msh:16: node 50 has a coordinate that is not a finite number\n  help: repair the geometry, or the scale of the mesh, and mesh it again"
    );
    assert_eq!(
        error(&square(&[]).replace("50 7 7 7", "40 7 7 7")),
        "m.msh:16: node 40 is listed twice\n  help: renumber the nodes: open the mesh in Gmsh and save it again"
    );
}

#[test]
fn an_element_given_twice_is_refused_with_its_numbers() {
    const HELP: &str = "help: remove one of them; one thickness has to count for both";
    let twice = |element: &str| error(&square(&[element]));
    // The same group, another entity, rotated, reversed.
    for element in
        ["7 3 2 0 1 10 20 30 40", "7 3 2 3 2 10 20 30 40", "7 3 2 3 1 20 30 40 10", "7 3 2 3 1 40 30 20 10"]
    {
        assert_eq!(
            twice(element),
            format!("m.msh:21: elements 1 and 7 have the same four nodes\n  {HELP}"),
            "{element}"
        );
    }
    // Once more for another physical group: that is how format 2.2 writes it.
    assert!(parse(Path::new("m.msh"), square(&["7 3 2 3 1 10 20 30 40"]).as_bytes(), 1.0).is_ok());
    let four = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Entities\n0 0 1 0\n1 0 0 0 1 1 0 1 5 0\n$EndEntities\n\
        $Nodes\n1 4 1 4\n2 1 0 4\n1\n2\n3\n4\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n$EndNodes\n\
        $Elements\n1 2 8 9\n2 1 3 2\n8 1 2 3 4\n9 1 2 3 4\n$EndElements\n";
    assert_eq!(error(four), format!("m.msh:24: elements 8 and 9 have the same four nodes\n  {HELP}"));
}

#[test]
fn heads_of_sections_have_to_say_the_truth() {
    let four = |nodes: u32, elements: u32, x: &str| {
        format!(
            "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n1 {nodes} 1 4\n2 1 0 4\n1\n2\n3\n4\n0 0 0\n1 0 0\n{x} 1 0\n\
             0 1 0\n$EndNodes\n$Elements\n1 {elements} 8 8\n2 1 3 1\n8 1 2 3 4\n$EndElements\n"
        )
    };
    const DAMAGED: &str = "help: the file is cut off or damaged: save the mesh again in Gmsh";
    assert!(parse(Path::new("m.msh"), four(4, 1, "1").as_bytes(), 1.0).is_ok());
    assert_eq!(
        error(&four(5, 1, "1")),
        format!("m.msh:5: the section begins with 5 nodes but holds 4\n  {DAMAGED}")
    );
    assert_eq!(
        error(&four(4, 7, "1")),
        format!("m.msh:17: the section begins with 7 elements but holds 1\n  {DAMAGED}")
    );
    // The line of the coordinate, not that of the number of the node.
    assert!(
        error(&four(4, 1, "nan")).starts_with("m.msh:13: node 3 has a coordinate"),
        "{}",
        error(&four(4, 1, "nan"))
    );
}

#[cfg(unix)]
#[test]
fn devices_without_end_are_refused() {
    let error = read(Path::new("/dev/zero"), 1.0).unwrap_err();
    assert_eq!(error.message, "this is a device or a pipe, not a mesh file");
}

#[test]
fn the_mesh_knows_the_numbers_of_the_file() {
    let mesh = parse(Path::new("a/m.msh"), square(&[]).as_bytes(), 1.0).unwrap();
    let labels = mesh.labels.clone().unwrap();
    assert_eq!((labels.file.as_str(), labels.nodes, labels.quads), ("m.msh", vec![10, 20, 30, 40], vec![1]));
    assert_eq!((mesh.node_label(2), mesh.quad_label(0)), (30, 1));
}

#[test]
fn damaged_files() {
    const DAMAGED: &str = "the file is cut off or damaged: save the mesh again in Gmsh";
    let whole = square(&[]);
    assert_eq!(
        error(&whole.replace("30 1 1 0", "30 1 one 0")),
        format!("m.msh:14: expected a coordinate of a node, found \"one\"\n  help: {DAMAGED}")
    );
    assert_eq!(
        error(&whole.replace("$Nodes\n5", "$Nodes\n6")),
        format!("m.msh:17: expected the number of a node, found \"$EndNodes\"\n  help: {DAMAGED}")
    );
    assert_eq!(
        error(&whole.replace("$Nodes\n5", "$Nodes\n4")),
        "m.msh:16: expected $EndNodes, found \"50 7 7 7\"\n  help: the section $Nodes holds more than its count says: save the mesh again in Gmsh"
    );
    assert_eq!(
        error(&whole.replace("$Nodes\n5", "$Nodes\n-5")),
        format!("m.msh:11: expected the number of nodes, found \"-5\"\n  help: {DAMAGED}")
    );
    assert_eq!(
        error(&whole.replace("$Elements\n1", "$Elements\n18446744073709551615")),
        format!("m.msh:22: expected the number of an element, found \"$EndElements\"\n  help: {DAMAGED}")
    );
    assert_eq!(
        error(whole.split("30 40\n").next().unwrap()),
        format!("m.msh:20: the file ends where a node of an element should be\n  help: {DAMAGED}")
    );
    assert_eq!(
        error(&whole.replace("$EndNodes", "$Endnodes")),
        "m.msh:17: expected $EndNodes, found \"$Endnodes\"\n  help: the section $Nodes holds more than its count says: save the mesh again in Gmsh"
    );
    assert_eq!(
        error(&whole.replace("$Nodes", "$Notes")),
        format!("m.msh:11: $Notes has no $EndNotes\n  help: {DAMAGED}")
    );
    assert_eq!(
        error(&whole.replace("\n$Nodes", "\nstray\n$Nodes")),
        format!(
            "m.msh:10: expected the begin of a section such as $Nodes, found \"stray\"\n  help: {DAMAGED}"
        )
    );
    assert_eq!(
        error(&whole.replace("0 1 \"tip\"", "0 1 tip")),
        "m.msh:6: expected a physical name such as 2 1 \"shell\", found \"0 1 tip\"\n  help: the section $PhysicalNames is damaged: save the mesh again in Gmsh"
    );
    let latin = whole.as_bytes().iter().map(|&b| if b == b'p' { 0xe4 } else { b }).collect::<Vec<u8>>();
    assert_eq!(
        parse(Path::new("m.msh"), &latin, 1.0).unwrap_err().to_string(),
        "m.msh:6: expected a physical name, found bytes that are not UTF-8 text\n  help: give the physical groups names in UTF-8, or save the mesh again in Gmsh"
    );
    let head = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n";
    assert_eq!(
        error(&format!("{head}$PartitionedEntities\n2\n")),
        "m.msh:4: the mesh is partitioned\n  help: save it whole: Mesh > Unpartition in Gmsh, or gmsh -2 without -part"
    );
    assert_eq!(
        error(&format!("{head}$Nodes\n1 1 1 1\n4 1 0 1\n")),
        format!("m.msh:6: expected the dimension of a block, 0 to 3, found \"4\"\n  help: {DAMAGED}")
    );
    let late = format!(
        "{head}$Elements\n1 1 1 1\n2 1 3 1\n1 1 2 3 4\n$EndElements\n$Entities\n0 0 0 0\n$EndEntities\n"
    );
    assert_eq!(
        error(&late),
        "m.msh:9: $Entities stands behind $Elements\n  help: put the sections in the order $Entities, $Nodes, $Elements, as Gmsh does"
    );
}

/// Counts are never believed before the data is seen: this must neither run long nor take memory.
#[test]
fn huge_counts_in_binary_files_end_with_the_data() {
    let mut bytes = b"$MeshFormat\n4.1 1 8\n\x01\0\0\0\n$EndMeshFormat\n$Nodes\n".to_vec();
    bytes.extend([0xff; 32]);
    bytes.extend([2, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0]);
    bytes.extend([0xff; 8]);
    let end = bytes.len();
    assert_eq!(
        parse(Path::new("m.msh"), &bytes, 1.0).unwrap_err().to_string(),
        format!(
            "m.msh: byte {end}: the file ends where the number of a node should be\n  help: the file is cut off or damaged: save the mesh again in Gmsh"
        )
    );
}

proptest! {
    #[test]
    fn no_bytes_panic(bytes in proptest::collection::vec(any::<u8>(), 0..300), variant in 0..4usize) {
        let head: [&[u8]; 4] = [
            b"",
            b"$MeshFormat\n2.2 1 8\n\x01\0\0\0\n$EndMeshFormat\n$Elements\n9\n",
            b"$MeshFormat\n4.1 1 8\n\x01\0\0\0\n$EndMeshFormat\n$Entities\n",
            b"$MeshFormat\n4.1 1 4\n\0\0\0\x01\n$EndMeshFormat\n$Elements\n",
        ];
        let _ = parse(Path::new("m.msh"), &[head[variant], &bytes].concat(), 1.0);
    }

    #[test]
    fn no_damage_to_a_valid_file_panics(
        file in 0..7usize,
        changes in proptest::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..6),
        cut in any::<prop::sample::Index>(),
        removed in 0..5usize,
    ) {
        let names = ["2-ascii", "2-binary", "2-big-endian", "4-ascii", "4-binary", "4-big-endian", "4-32-bit"];
        let mut bytes = std::fs::read(data(&format!("plate-{}.msh", names[file]))).unwrap();
        for (place, value) in changes {
            let i = place.index(bytes.len());
            bytes[i] = value;
        }
        let start = cut.index(bytes.len());
        bytes.drain(start..(start + removed).min(bytes.len()));
        if let Ok(mesh) = parse(Path::new("m.msh"), &bytes, 1.0) {
            let count = mesh.positions.len() as u32;
            prop_assert!(mesh.quads.iter().flatten().all(|&n| n < count));
        }
    }
}

#[test]
fn a_layer_of_hexahedra_becomes_its_middle_surface() {
    let mesh = load("layer-2-ascii.msh");
    assert_eq!((mesh.positions.len(), mesh.quads.len()), (20, 12));
    for (p, t) in mesh.positions.iter().zip(mesh.thickness.as_ref().unwrap()) {
        assert!((p.xy().norm() - 2.0).abs() < 1e-12 && (t - 0.1).abs() < 1e-12, "{p} {t}");
    }
    // Exact normals, all to the same side, and elements that run around them.
    let normals = mesh.normals.as_ref().unwrap();
    let first = mesh.positions[mesh.quads[0][0] as usize];
    let side = normals[0][0].dot(&first).signum();
    for (quad, normals) in mesh.quads.iter().zip(normals) {
        let [a, b, c, d] = quad.map(|n| mesh.positions[n as usize]);
        for (n, x) in normals.iter().zip([a, b, c, d]) {
            let radial = Vec3::new(x.x, x.y, 0.0) / 2.0;
            assert!((n - radial * side).norm() < 1e-12, "{n}");
            assert!((c - a).cross(&(d - b)).dot(n) > 0.0);
        }
    }
    assert_eq!((mesh.quad_sets["shell"].len(), mesh.quad_sets["outside"].len()), (12, 12));
    assert_eq!((mesh.edge_sets["fixed"].len(), mesh.edge_sets["rim"].len()), (3, 4));
    assert_eq!((mesh.node_sets["corner"].len(), &mesh.node_sets["tip"]), (1, &mesh.node_sets["corner"]));
    for variant in ["2-binary", "4-ascii", "4-binary"] {
        let other = load(&format!("layer-{variant}.msh"));
        assert_same(&mesh, &other);
        assert_eq!(mesh.labels.as_ref().unwrap().nodes, other.labels.as_ref().unwrap().nodes);
    }
}

/// Cubes of side 1 with their corners at the given places, in format 2.2, and further elements.
fn cubes(at: &[[u64; 3]], more: &str) -> String {
    let node = |[x, y, z]: [u64; 3]| 1 + x + 10 * y + 100 * z;
    let mut nodes = std::collections::BTreeMap::new();
    let mut elements = String::new();
    for (e, &[x, y, z]) in at.iter().enumerate() {
        elements += &format!("{} 5 2 0 1", e + 1);
        for [i, j, k] in
            [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]]
        {
            let place = [x + i, y + j, z + k];
            nodes.insert(node(place), place);
            elements += &format!(" {}", node(place));
        }
        elements += "\n";
    }
    let listed: String = nodes.iter().map(|(n, [x, y, z])| format!("{n} {x} {y} {z}\n")).collect();
    format!(
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n2\n2 7 \"side\"\n3 8 \"side\"\n$EndPhysicalNames\n\
         $Nodes\n{}\n{listed}$EndNodes\n$Elements\n{}\n{elements}{more}$EndElements\n",
        nodes.len(),
        at.len() + more.lines().count()
    )
}

#[test]
fn hexahedra_that_are_no_single_layer_are_refused() {
    let block: Vec<[u64; 3]> = (0..27).map(|k| [k % 3, k / 3 % 3, k / 9]).collect();
    assert!(error(&cubes(&block, "")).contains("hexahedron 1 has neighbours in all three directions"));
    // An L of three has one direction without neighbours, a cross of two layers has none.
    assert!(parse(Path::new("m.msh"), cubes(&[[0, 0, 0], [1, 0, 0], [0, 1, 0]], "").as_bytes(), 1.0).is_ok());
    let two: Vec<[u64; 3]> = (0..18).map(|k| [k % 3, k / 3 % 3, k / 9]).collect();
    assert!(error(&cubes(&two, "")).contains("in all three directions"));
    // A corner around which the thickness would have to turn.
    let corner = error(&cubes(&[[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0], [0, 0, 1]], ""));
    assert!(corner.contains("in all three directions"), "{corner}");
    let bend = error(&cubes(&[[0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 1, 0], [2, 0, 1]], ""));
    assert!(bend.contains("one layer"), "{bend}");
    assert!(error(&cubes(&[[0, 0, 0]], "9 3 2 0 1 1 2 12 12\n")).contains("is not the face of a hexahedron"));
    let twice = cubes(&[[0, 0, 0]], "9 5 2 0 1 1 2 12 11 101 102 112 111\n");
    assert!(error(&twice).contains("hexahedra 1 and 9 have the same eight nodes"));
    let names = cubes(&[[0, 0, 0]], "8 3 2 7 1 1 2 12 11\n9 5 2 8 1 1 2 12 11 101 102 112 111\n");
    assert!(error(&names).contains("both called \"side\""), "{}", error(&names));
}

#[test]
fn the_thin_direction_of_a_single_hexahedron_is_its_thickness() {
    for thin in 0..3 {
        let text = cubes(&[[0, 0, 0]], "");
        let text: String = text
            .lines()
            .map(|line| {
                let words: Vec<&str> = line.split(' ').collect();
                if words.len() == 4 && !line.starts_with('$') {
                    let mut x: Vec<f64> = words[1..].iter().map(|w| w.parse().unwrap()).collect();
                    x[thin] *= 0.1;
                    format!("{} {} {} {}\n", words[0], x[0], x[1], x[2])
                } else {
                    format!("{line}\n")
                }
            })
            .collect();
        let mesh = parse(Path::new("m.msh"), text.as_bytes(), 1.0).unwrap();
        assert!(mesh.thickness.as_ref().unwrap().iter().all(|t| (t - 0.1).abs() < 1e-15));
        assert!(mesh.positions.iter().all(|p| (p[thin] - 0.05).abs() < 1e-15));
        assert!(mesh.normals.as_ref().unwrap()[0][0][thin] > 0.5, "from the first face to the second");
    }
}

#[test]
fn views_become_fields() {
    for name in ["views-2-ascii.msh", "views-2-binary.msh", "views-4-ascii.msh", "views-4-binary.msh"] {
        let mesh = load(name);
        assert_eq!((mesh.positions.len(), mesh.quads.len()), (6, 2), "{name}");
        // The last of two time steps.
        let expected: Vec<f64> = mesh.positions.iter().map(|x| 1.0 + x.x / 2.0 + x.y / 4.0).collect();
        assert_eq!(mesh.field("t").unwrap(), FieldValues::Nodes(&expected), "{name}");
        let FieldValues::Quads(p) = mesh.field("p").unwrap() else { panic!("{name}") };
        assert!((0..2).all(|q| p[q] == mesh.quad_label(q) as f64), "{name}: {p:?}");
        assert_eq!(mesh.fields.vectors["u"], 3, "{name}");
    }
    let view =
        |rows: &str| square(&[]) + &format!("$NodeData\n1\n\"t\"\n1\n0.0\n3\n0\n1\n{rows}\n$EndNodeData\n");
    let mesh = parse(Path::new("m.msh"), view("2\n10 1.5\n40 2").as_bytes(), 1.0).unwrap();
    let FieldValues::Nodes(t) = mesh.field("t").unwrap() else { panic!("elements") };
    assert!((t[0], t[3]) == (1.5, 2.0) && t[1].is_nan() && t[2].is_nan(), "{t:?}");
    assert!(error(&view("3\n10 1.5\n40 2")).contains("expected the number of a node or element of a view"));
    assert!(error(&view("1\n10 1.5\n40 2")).contains("expected $EndNodeData"));
    assert!(error(&view("99999999999999\n10 x")).contains("expected a value of a view, found \"x\""));
    assert!(
        error(&view("2\n10 1.5\n40 2").replace("3\n0\n1\n2", "1\n0")).contains("no number of components")
    );
}
