//! Files of both formats, and damaged ones.

use std::fmt::Write as _;
use std::path::Path;

use tegula::model::TriangulatedSurface;

use super::{Corners, parse};

/// Tetrahedron of volume 4/3 with coordinates that single precision holds.
const TETRAHEDRON: [Corners; 4] = {
    let [o, x, y, z] = [[1.0, 0.5, 0.25], [3.0, 0.5, 0.25], [1.0, 2.5, 0.25], [1.0, 0.5, 2.25]];
    [[o, y, x], [o, z, y], [o, x, z], [x, y, z]]
};

fn ascii(name: &str, triangles: &[Corners]) -> String {
    let mut out = format!("solid {name}\n");
    for corners in triangles {
        out += "  facet normal 0 0 0\n    outer loop\n";
        corners.iter().for_each(|[x, y, z]| writeln!(out, "      vertex {x:e} {y} {z}").unwrap());
        out += "    endloop\n  endfacet\n";
    }
    out + &format!("endsolid {name}\n")
}

fn binary(header: &str, triangles: &[Corners]) -> Vec<u8> {
    let mut out = format!("{header:80}").into_bytes();
    out.extend((triangles.len() as u32).to_le_bytes());
    for corners in triangles {
        let numbers = [0.0; 3].iter().chain(corners.iter().flatten()).map(|x| *x as f32);
        out.extend(numbers.flat_map(f32::to_le_bytes));
        out.extend([0, 0]);
    }
    out
}

fn read(bytes: impl AsRef<[u8]>) -> Result<TriangulatedSurface, String> {
    parse(Path::new("part.stl"), bytes.as_ref()).map_err(|error| error.to_string())
}

fn refused(bytes: impl AsRef<[u8]>, parts: &[&str]) {
    let message = read(bytes).unwrap_err();
    assert!(message.starts_with("part.stl") && message.contains("help: "), "{message}");
    assert!(parts.iter().all(|part| message.contains(part)), "{message}");
}

#[test]
fn both_formats_give_the_same_surface() {
    let found = read(ascii("part", &TETRAHEDRON)).unwrap();
    assert!((found.volume - 4.0 / 3.0).abs() < 1e-14, "{}", found.volume);
    assert!((found.centre - tegula::Vec3::new(1.5, 1.0, 0.75)).norm() < 1e-14, "{}", found.centre);
    // Exporters write such headers in front of binary data, too.
    for header in ["", "solid part", "solid\npart\nfacet normal"] {
        assert_eq!(read(binary(header, &TETRAHEDRON)).unwrap(), found, "{header}");
    }
}

#[test]
fn ascii_files_are_read_as_programs_write_them() {
    let plain = ascii("part", &TETRAHEDRON);
    let found = read(&plain).unwrap();
    let two = ascii("a facet of endsolid", &TETRAHEDRON[..2]) + "\n" + &ascii("", &TETRAHEDRON[2..]);
    let tabs = plain.replace("  ", "\t").replace('\n', "\r\n");
    let mut latin = plain.clone().into_bytes();
    latin.splice(6..6, [0xfc, 0xe9]);
    let nan = plain.replacen("normal 0 0 0", "normal nan -nan(ind) 1.#QNAN", 1);
    let variants = [two, tabs, plain.to_uppercase(), format!("\u{feff}\n {plain}"), nan];
    for text in variants.map(String::into_bytes).into_iter().chain([latin]) {
        assert_eq!(read(&text).unwrap(), found, "{}", String::from_utf8_lossy(&text));
    }
}

#[test]
fn damaged_files_are_refused_with_their_places() {
    let text = ascii("part", &TETRAHEDRON);
    let lines: Vec<&str> = text.lines().collect();
    refused(lines[..18].join("\n"), &["part.stl:18: ", "ends within a solid, behind 2 whole triangles"]);
    refused(text.replacen("2.25", "nan", 1), &["part.stl:12: ", "`nan` is not a finite number"]);
    refused(text.replacen("0.25", "0,25", 1), &["part.stl:4: ", "`0,25` is not a finite number"]);
    let square = text.replacen("    endloop", "      vertex 0 0 0\n    endloop", 1);
    refused(square, &["part.stl:7: ", "`endloop` is expected here, but there is `vertex`", "three vertices"]);
    refused("solid empty\nendsolid empty\n", &["has no triangles"]);
    refused("", &["is empty"]);
    refused("o cube\nv 1 2 3\n".repeat(20), &["no STL file"]);

    let bytes = binary("solid part", &TETRAHEDRON);
    refused(&bytes[..200], &["announces 4 triangles, but the file holds 2 and 16 bytes more", "byte 200"]);
    refused(
        [&bytes[..], b"\0\0"].concat(),
        &["announces 4 triangles, but the file holds 4 and 2 bytes more"],
    );
    refused(&bytes[..60], &["ends within a solid, behind 0 whole triangles"]);
    refused(&binary("part", &TETRAHEDRON)[..60], &["no STL file"]);
    refused(binary("", &[]), &["has no triangles"]);
    let mut bad = TETRAHEDRON;
    bad[2][1][0] = f64::NAN;
    refused(binary("", &bad), &["byte 184: triangle 3 has a coordinate that is not a finite number"]);
    refused(binary("", &TETRAHEDRON[..3]), &["not closed: 3 edges", "from (1, 2.5, 0.25) to (3, 0.5, 0.25)"]);
}

#[test]
fn any_bytes_have_an_answer() {
    for whole in [ascii("part", &TETRAHEDRON).into_bytes(), binary("solid part", &TETRAHEDRON)] {
        for length in 0..whole.len() {
            // The end of the last line may be missing.
            assert!(read(&whole[..length]).is_err() || length + 6 >= whole.len(), "{length}");
            let mut changed = whole.clone();
            changed[length] = changed[length].wrapping_add(7);
            let _ = read(&changed);
        }
    }
}
