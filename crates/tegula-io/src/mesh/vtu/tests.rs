//! Files of VTK, meshio and this program, all encodings, and what is refused.

use std::fs;
use std::path::{Path, PathBuf};

use tegula::mesh::FieldValues;

use super::*;
use crate::out::{DataArray, VtuGrid, vtu};

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/vtu")
}

/// Files of the plate of `tests/data/vtu.py`, by name.
fn plates() -> Vec<(String, Vec<u8>)> {
    let files = fs::read_dir(folder()).unwrap().map(|file| file.unwrap());
    let named = files.map(|file| (file.file_name().into_string().unwrap(), fs::read(file.path()).unwrap()));
    let mut out: Vec<_> =
        named.filter(|(name, _)| !["vtk-lz4.vtu", "meshio-cell-sets.vtu"].contains(&name.as_str())).collect();
    out.sort();
    out
}

fn read(bytes: &[u8]) -> Result<Mesh, String> {
    Vtu::parse(Path::new("a.vtu"), bytes, 1.0).map_err(|error| error.to_string())
}

fn refused(bytes: impl AsRef<[u8]>, wanted: &str) {
    match read(bytes.as_ref()) {
        Ok(_) => panic!("accepted, in place of: {wanted}"),
        Err(message) => {
            assert!(message.starts_with("a.vtu") && message.contains(wanted), "{message}\n{wanted}")
        }
    }
}

/// ASCII file of these cells, each with its type, on points i of the places (i mod 3, i div 3, 0); further arrays of points and cells.
fn ascii(points: usize, cells: &[(u8, &[u32])], [point_data, cell_data]: [&str; 2]) -> String {
    let list = |numbers: Vec<String>| numbers.join(" ");
    let coordinates = list((0..points).map(|i| format!("{} {} 0", i % 3, i / 3)).collect());
    let connectivity = list(cells.iter().flat_map(|(_, nodes)| nodes.iter()).map(u32::to_string).collect());
    let mut end = 0;
    let offsets = list(
        cells
            .iter()
            .map(|(_, nodes)| {
                end += nodes.len();
                end.to_string()
            })
            .collect(),
    );
    let kinds = list(cells.iter().map(|(kind, _)| kind.to_string()).collect());
    let array = |name: &str, content: &str| {
        format!("<DataArray type=\"Int64\" Name=\"{name}\" format=\"ascii\">{content}</DataArray>")
    };
    format!(
        "<VTKFile type=\"UnstructuredGrid\"><UnstructuredGrid><Piece NumberOfPoints=\"{points}\" NumberOfCells=\"{}\">\
         <Points><DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"ascii\">{coordinates}</DataArray></Points>\
         <Cells>{}{}{}</Cells><PointData>{point_data}</PointData><CellData>{cell_data}</CellData></Piece></UnstructuredGrid></VTKFile>",
        cells.len(),
        array("connectivity", &connectivity),
        array("offsets", &offsets),
        array("types", &kinds)
    )
}

fn integers(name: &str, values: &str) -> String {
    format!("<DataArray type=\"Int32\" Name=\"{name}\" format=\"ascii\">{values}</DataArray>")
}

#[test]
fn the_plate_is_the_same_in_every_encoding() {
    let files = plates();
    assert!(files.len() >= 18, "{}", files.len());
    for (name, bytes) in files {
        println!("{name}");
        let mesh = read(&bytes).unwrap();
        assert_eq!((mesh.positions.len(), mesh.quads.len()), (12, 6));
        assert_eq!(mesh.quads[4], [5, 6, 10, 9]);
        assert_eq!(mesh.positions[6], tegula::Vec3::new(2.0, 1.0, 0.0));
        let sets = mesh.set_names();
        assert_eq!(sets, ["all", "gmsh:physical:1", "gmsh:physical:2", "ref:0", "ref:5"]);
        assert_eq!(mesh.quad_sets["gmsh:physical:1"], [0, 3]);
        assert_eq!(mesh.quad_sets["gmsh:physical:2"], [1, 2, 4, 5]);
        assert_eq!(mesh.edge_sets["gmsh:physical:1"], [[0, 4], [4, 8]]);
        assert_eq!(mesh.node_sets["ref:5"], [3, 7, 11]);
        let FieldValues::Nodes(t) = mesh.field("t").unwrap() else { panic!("{name}") };
        assert_eq!((t.len(), t[6]), (12, 2.25), "{name}");
        assert_eq!(mesh.field("p").unwrap(), FieldValues::Quads(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]));
        assert_eq!(mesh.fields.vectors["velocity"], 3);
        assert_eq!(mesh.labels.unwrap().file, "a.vtu");
    }
}

#[test]
fn cell_sets_of_meshio_are_sets() {
    let mesh = read(&fs::read(folder().join("meshio-cell-sets.vtu")).unwrap()).unwrap();
    assert_eq!(mesh.quad_sets["left-right:0"], [0, 3]);
    assert_eq!(mesh.quad_sets["left-right:1"], [1, 2, 4, 5]);
}

#[test]
fn files_of_this_program_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("0000.vtu");
    let n = 40;
    let points: Vec<[f64; 3]> =
        (0..=n).flat_map(|i| [0.0, 1.0].map(|y| [f64::from(i), y, 1.0 / f64::from(i + 1)])).collect();
    let quads: Vec<[u32; 4]> = (0..n).map(|i| [2 * i, 2 * i + 2, 2 * i + 3, 2 * i + 1]).collect();
    let thickness: Vec<f64> = (0..points.len()).map(|i| (i as f64).sin() / 3.0).collect();
    let stress: Vec<f64> = (0..=n).map(|i| if i == 1 { f64::NAN } else { f64::from(i) / 7.0 }).collect();
    let displacement = vec![0.5; 3 * points.len()];
    let grid = VtuGrid {
        points: &points,
        quads: &quads,
        // A beam, which is no side of an element.
        lines: &[[0, 3]],
        point_data: vec![
            DataArray::new("t", 1, &thickness[..]),
            DataArray::new("displacement", 3, displacement),
        ],
        cell_data: vec![DataArray::new("von_mises", 1, &stress[..])],
        time: 0.25,
    };
    vtu::write(&path, &grid).unwrap();
    let mesh = read(&fs::read(&path).unwrap()).unwrap();
    assert_eq!(mesh.quads, quads);
    assert!(mesh.positions.iter().zip(&points).all(|(a, b)| <[f64; 3]>::from(*a) == *b));
    assert_eq!(mesh.field("t").unwrap(), FieldValues::Nodes(&thickness));
    let FieldValues::Quads(read) = mesh.field("von_mises").unwrap() else { panic!("nodes") };
    assert!(read[1].is_nan() && read[39] == 39.0 / 7.0 && read.len() == 40);
    assert_eq!(mesh.fields.vectors["displacement"], 3);
    assert_eq!(mesh.set_names(), ["all"]);
}

#[test]
fn other_cells_are_refused_by_name_and_number() {
    let quad: (u8, &[u32]) = (9, &[0, 1, 4, 3]);
    let of = |kind: u8, nodes: &[u32]| ascii(9, &[quad, (kind, nodes)], ["", ""]);
    refused(of(5, &[1, 2, 4]), "a triangle of 3 points (cell 1)");
    refused(of(42, &[0, 1, 2, 3, 4]), "a polyhedron of 5 points (cell 1)");
    refused(of(7, &[1, 2, 5, 8, 4]), "a polygon of 5 points (cell 1)");
    refused(of(23, &[0, 2, 8, 6, 1, 5, 7, 3]), "a quadratic quadrilateral of 8 points (cell 1)");
    refused(of(23, &[0, 2, 8, 6, 1, 5, 7, 3]), "use elements of first order");
    refused(of(99, &[0]), "a cell of the type 99 of 1 points (cell 1)");
    refused(of(9, &[1, 2, 4]), "a quadrilateral of 3 points (cell 1)");
    refused(of(9, &[1, 2, 9, 4]), "cell 1 has the point 9, and there are 9 points");
    refused(of(9, &[1, 2, 2, 4]), "cell 1 has point 2 at two corners");
    refused(of(9, &[3, 4, 1, 0]), "cells 0 and 1 have the same four points");
    refused(ascii(3, &[(3, &[0, 1])], ["", ""]), "holds no quadrilaterals");
    let polygon = read(of(7, &[1, 2, 5, 4]).as_bytes()).unwrap();
    let pixel = read(of(8, &[1, 2, 4, 5]).as_bytes()).unwrap();
    assert_eq!(polygon.quads, [[0, 1, 4, 3], [1, 2, 5, 4]]);
    assert_eq!(pixel.quads, polygon.quads);
    assert_eq!(polygon.labels.unwrap().nodes, [0, 1, 2, 3, 4, 5]);
}

#[test]
fn lines_and_vertices_belong_to_sets_or_are_passed_over() {
    let cells: [(u8, &[u32]); 4] = [(9, &[0, 1, 4, 3]), (4, &[0, 1, 4]), (1, &[3]), (2, &[])];
    let mesh = read(ascii(9, &cells, ["", &integers("g", "1 2 3 4")]).as_bytes()).unwrap();
    assert_eq!(mesh.edge_sets["g:2"], [[0, 1], [1, 3]]);
    assert_eq!(mesh.node_sets["g:3"], [2]);
    assert_eq!(mesh.quad_sets["g:1"], [0]);
    let loose: [(u8, &[u32]); 3] = [(9, &[0, 1, 4, 3]), (3, &[0, 4]), (1, &[8])];
    assert!(read(ascii(9, &loose, ["", ""]).as_bytes()).is_ok());
    refused(
        ascii(9, &loose, ["", &integers("g", "1 2 3")]),
        "the line from point 0 to 4 of cell 1, of the group \"g:2\", is not in the mesh",
    );
    refused(
        ascii(9, &[cells[0], loose[2]], ["", &integers("g", "1 3")]),
        "the vertex at point 8 of cell 1, of the group \"g:3\", is not in the mesh",
    );
}

#[test]
fn truth_values_are_sets_of_their_name() {
    let cells: [(u8, &[u32]); 3] = [(9, &[0, 1, 4, 3]), (9, &[1, 2, 5, 4]), (3, &[0, 8])];
    let bytes = |name: &str, values: &str| integers(name, values).replace("Int32", "UInt8");
    let cell_data = bytes("inner part", "0 1 0") + &bytes("none", "0 0 0");
    let mesh = read(ascii(9, &cells, [&bytes("held", "1 0 0 1 0 0 0 0 0"), &cell_data]).as_bytes()).unwrap();
    assert_eq!(mesh.set_names(), ["all", "held", "inner part"]);
    assert_eq!((&mesh.node_sets["held"][..], &mesh.quad_sets["inner part"][..]), (&[0, 3][..], &[1][..]));
    let numbers = read(ascii(9, &cells[..2], ["", &bytes("g", "0 2")]).as_bytes()).unwrap();
    assert_eq!(numbers.set_names(), ["all", "g:0", "g:2"]);
    refused(ascii(9, &cells[..2], ["", &bytes("all", "0 1")]), "all");
}

#[test]
fn numbers_of_points_are_no_groups() {
    let points = "7 7 7 7 7 7 7 7 7";
    let text = ascii(
        9,
        &[(9, &[0, 1, 4, 3])],
        [&(integers("ids", points) + &integers("vtkIds", points) + &integers("g", points)), ""],
    );
    let mesh = read(text.replace("<PointData>", "<PointData GlobalIds=\"ids\">").as_bytes()).unwrap();
    assert_eq!(mesh.node_sets.keys().collect::<Vec<_>>(), ["g:7"]);
    assert!(mesh.field("ids").is_ok(), "it still is a field");
}

#[test]
fn pieces_follow_one_another() {
    let one = ascii(4, &[(9, &[0, 1, 3, 2])], [&integers("g", "1 1 2 2"), ""]);
    let begin = one.find("<Piece").unwrap();
    let end = one.find("</UnstructuredGrid>").unwrap();
    let empty = "<Piece NumberOfPoints=\"0\" NumberOfCells=\"0\"></Piece>";
    let with = |second: &str| format!("{}{empty}{second}{}", &one[..end], &one[end..]);
    // Points 0 1 2 in a row and 3 above the first one.
    let second = one[begin..end].to_owned();
    let mut mesh = read(with(&second).as_bytes()).unwrap();
    assert_eq!(mesh.quads, [[0, 1, 3, 2], [4, 5, 7, 6]]);
    assert_eq!(mesh.node_sets["g:2"], [2, 3, 6, 7]);
    assert_eq!(mesh.merge_coincident_nodes().unwrap(), 4);
    assert_eq!(mesh.field("g").unwrap(), FieldValues::Nodes(&[1.0, 1.0, 2.0, 2.0]));
    refused(
        with(&second.replace("\"g\"", "\"h\"")),
        "the array \"h\" stands twice in a piece, or not in every piece",
    );
    refused(with(&second.replace(&integers("g", "1 1 2 2"), "")), "the array \"g\" stands twice in a piece");
}

#[test]
fn mistakes_name_the_array_and_the_remedy() {
    let whole = String::from_utf8(fs::read(folder().join("vtk-ascii.vtu")).unwrap()).unwrap();
    let changed = |from: &str, to: &str| {
        assert!(whole.contains(from), "{from}");
        whole.replacen(from, to, 1)
    };
    refused("", "the mesh file is empty");
    refused("solid", "this is no VTU file");
    refused("<a/>", "its first element is `a`");
    refused(changed("\"UnstructuredGrid\"", "\"PUnstructuredGrid\""), "name one of the pieces");
    refused(changed("\"UnstructuredGrid\"", "\"PolyData\""), "data of the type \"PolyData\"");
    refused(changed("\"LittleEndian\"", "\"Middle\""), "`byte_order` of the file is \"Middle\"");
    refused(changed("\"UInt64\"", "\"UInt16\""), "`header_type` of the file is \"UInt16\"");
    refused(
        fs::read(folder().join("vtk-lz4.vtu")).unwrap(),
        "\"vtkLZ4DataCompressor\"\n  help: save it with the compressor ZLib",
    );
    refused(
        changed("1 1.5 2 2.5", "1 1.5 two 2.5"),
        "a.vtu:6: the array \"t\" has \"two\" where a number is expected",
    );
    refused(changed("1 1.5 2 2.5", "1 1.5 2"), "the array \"t\" has 11 numbers, and 12 are expected");
    refused(
        changed("NumberOfPoints=\"12\"", "NumberOfPoints=\"4000000000000000000\""),
        "the array \"Points\"",
    );
    refused(
        changed("NumberOfCells=\"8\"", "NumberOfCells=\"9\""),
        "the array \"types\" has 8 numbers, and 9 are expected",
    );
    refused(changed("Name=\"offsets\"", "Name=\"ends\""), "the cells have no array \"offsets\"");
    refused(changed("format=\"ascii\"", "format=\"text\""), "the array \"t\" has the format \"text\"");
    let mut raw = fs::read(folder().join("vtk-raw-plain.vtu")).unwrap();
    let data = raw.windows(14).position(|w| w == b"  <AppendedDat").unwrap();
    raw.truncate(data + 100);
    refused(&raw, "the array \"Points\" begins at");
    let mut raw = fs::read(folder().join("vtk-raw-plain.vtu")).unwrap();
    raw.truncate(raw.windows(2).rposition(|w| w == b"</").unwrap() - 23);
    refused(&raw, "the array \"types\" ends early");
    let text = String::from_utf8(fs::read(folder().join("vtk-appended-plain.vtu")).unwrap()).unwrap();
    refused(
        text.replacen("offset=\"0\"", "offset=\"99999\"", 1),
        "begins at 99999, beyond the appended data",
    );
    refused(text.replacen("encoding=\"base64\"", "encoding=\"hex\"", 1), "the encoding \"hex\"");
    for scale in [0.0, f64::NAN] {
        let error = Vtu::parse(Path::new("a.vtu"), whole.as_bytes(), scale).unwrap_err();
        assert!(error.to_string().contains("the factor on the coordinates is"), "{error}");
    }
}

/// Cells that ParaView does not show, sets of one name, legacy files, plane points.
#[test]
fn files_that_would_be_misunderstood_are_refused() {
    let whole = String::from_utf8(fs::read(folder().join("vtk-ascii.vtu")).unwrap()).unwrap();
    let cells = whole.split("NumberOfCells=\"").nth(1).and_then(|rest| rest.split('"').next()).unwrap();
    let count: usize = cells.parse().unwrap();
    let array = |kind: &str, name: &str, first: u8, others: u8| {
        let values: Vec<String> =
            (0..count).map(|i| if i == 0 { first } else { others }.to_string()).collect();
        format!(
            "<DataArray type=\"{kind}\" Name=\"{name}\" format=\"ascii\">{}</DataArray>",
            values.join(" ")
        )
    };
    let at = whole.find("<CellData").unwrap();
    let end = at + whole[at..].find('>').unwrap() + 1;
    let with = |arrays: &str| format!("{}{arrays}{}", &whole[..end], &whole[end..]);
    read(with(&array("UInt8", "vtkGhostType", 0, 0)).as_bytes()).unwrap();
    refused(with(&array("UInt8", "vtkGhostType", 32, 0)), "cell 0 is hidden or a duplicate");
    let both = array("UInt8", "part:3", 1, 0) + &array("Int32", "part", 4, 3);
    refused(with(&both), "both have a set with the name \"part:3\"");
    refused("# vtk DataFile Version 3.0\n", "a legacy file of VTK");
}

#[test]
fn nested_elements_and_entities_do_no_harm() {
    let whole = String::from_utf8(fs::read(folder().join("vtk-ascii.vtu")).unwrap()).unwrap();
    let nested = format!("{}{}", "<a>".repeat(100_000), "</a>".repeat(100_000));
    let _ = read(whole.replacen("<PointData>", &format!("{nested}<PointData>"), 1).as_bytes());
    let bomb = "<!DOCTYPE a [<!ENTITY b \"1111111111\"><!ENTITY c \"&b;&b;&b;&b;&b;&b;&b;&b;\">]>";
    refused(
        whole.replacen("<VTKFile", &format!("{bomb}<VTKFile"), 1),
        "this is no VTU file, or a damaged one",
    );
}

/// A block of zeros that is 1000 times as long as its compressed data is not decompressed beyond the expected length.
#[test]
fn blocks_that_grow_beyond_their_array_are_refused() {
    let bytes = fs::read(folder().join("vtk-binary-zlib.vtu")).unwrap();
    let text = String::from_utf8(bytes).unwrap().replacen(
        "type=\"Float64\" Name=\"t\"",
        "type=\"Float32\" Name=\"t\"",
        1,
    );
    refused(text, "the array \"t\" has more than the 48 bytes that are expected");
}

/// 200 files with one to eight damages each, by a generator of fixed seed: a byte changed, taken out or doubled, or the end cut off.
#[test]
fn damaged_files_are_read_or_refused() {
    let files = plates();
    let mut state = 0x2545_f491_4f6c_dd1d_u64;
    let mut below = |n: usize| {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state % n as u64) as usize
    };
    let mut failed = 0;
    for round in 0..200 {
        let (name, whole) = &files[round % files.len()];
        let mut bytes = whole.clone();
        for _ in 0..=below(8) {
            let at = below(bytes.len());
            match below(8) {
                0 => bytes.truncate(at.max(1)),
                1 => drop(bytes.remove(at)),
                2 => bytes.insert(at, bytes[at]),
                3 => bytes[at] = b'9',
                _ => bytes[at] = bytes[at].wrapping_add(below(255) as u8),
            }
        }
        match read(&bytes) {
            Ok(mesh) => assert!(mesh.quads.len() <= 8, "{name}"),
            Err(message) => failed += usize::from(message.contains("help: ")),
        }
    }
    assert!(failed > 100, "{failed} of 200");
}
