//! Contract of every registered reader of mesh files, on the example that it brings along.
#![allow(clippy::unwrap_used)]

use std::path::Path;

use tegula_io::mesh::readers;

#[test]
fn every_reader_reads_its_example_in_any_unit() {
    for (format, example, parse) in readers() {
        println!("contract: reader {format}");
        let path = Path::new("example");
        let mesh = parse(path, example, 1.0).unwrap();
        let large = parse(path, example, 1000.0).unwrap();
        assert!(!mesh.quads.is_empty(), "{format}: no quads");
        assert!(!mesh.set_names().is_empty(), "{format}: no sets");
        assert_eq!(tegula::mesh::quality::check(&mesh), [], "{format}");
        assert_eq!(mesh.quads, large.quads, "{format}");
        for (x, y) in mesh.positions.iter().zip(&large.positions) {
            assert!((x * 1000.0 - y).norm() <= 1e-12 * y.norm(), "{format}: {x:?} {y:?}");
        }
    }
}

#[test]
fn every_reader_survives_damaged_files() {
    for (format, example, parse) in readers() {
        let path = Path::new("damaged");
        for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(parse(path, example, bad).is_err(), "{format}: scale {bad}");
        }
        assert!(parse(path, b"no mesh", 1.0).is_err(), "{format}");
        let whole = parse(path, example, 1.0).unwrap();
        for length in 0..example.len() {
            if let Ok(mesh) = parse(path, &example[..length], 1.0) {
                assert!(mesh.quads.len() <= whole.quads.len(), "{format}: cut after {length} bytes");
            }
            let mut changed = example.to_vec();
            changed[length] = changed[length].wrapping_add(7);
            // Any answer will do, as long as there is one.
            let _ = parse(path, &changed, 1.0);
        }
    }
}
