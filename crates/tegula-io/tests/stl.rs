//! Bodies with STL files, from the model file to the results.
#![allow(clippy::unwrap_used)]

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use tegula_io::deck::Deck;
use tegula_io::job::{self, JobOptions, Unwatched};
use tegula_io::out::csv;

const MODEL: &str = r#"
[analysis]
type = "transient"
end_time = 0.1
time_step = 0.01
scheme = { type = "energy-momentum" }
[[bodies]]
name = "part"
at = [1.0, 2.0, 3.0]
density = 2.5
velocity = [0.5, 0.0, 0.0]
angular_velocity = [0.0, 4.0, 0.0]
shape = { type = "stl", file = "parts/box.stl", scale = 0.1 }
"#;

/// ASCII file of a box from the origin.
fn cuboid(size: [f64; 3]) -> String {
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let mut out = "solid box\n".to_owned();
    for [a, b, c, d] in faces {
        for t in [[a, b, c], [a, c, d]] {
            out += "facet normal 0 0 0\nouter loop\n";
            for i in t {
                let x: [f64; 3] = std::array::from_fn(|k| if i >> k & 1 == 1 { size[k] } else { 0.0 });
                writeln!(out, "vertex {} {} {}", x[0], x[1], x[2]).unwrap();
            }
            out += "endloop\nendfacet\n";
        }
    }
    out + "endsolid box\n"
}

fn deck(folder: &Path, text: &str) -> Deck {
    fs::create_dir_all(folder.join("parts")).unwrap();
    fs::write(folder.join("parts/box.stl"), cuboid([2.0, 4.0, 6.0])).unwrap();
    fs::write(folder.join("model.toml"), text).unwrap();
    Deck::read(folder.join("model.toml")).unwrap()
}

fn options(folder: &Path, resume: bool) -> JobOptions {
    JobOptions { folder: folder.join("results"), resume, force: false }
}

#[test]
#[ignore = "long"]
fn body_of_a_file_beside_the_model_has_its_mass_centre_and_is_drawn() {
    let folder = tempfile::tempdir().unwrap();
    let deck = deck(folder.path(), MODEL);
    let prepared = job::prepare(&deck).unwrap();
    assert!((prepared.system.total_mass() - 2.5 * 0.2 * 0.4 * 0.6).abs() < 1e-12);
    job::run(&deck, &options(folder.path(), false), &mut Unwatched).unwrap();
    let results = folder.path().join("results");
    let (names, rows) = csv::read(&results.join("history.csv")).unwrap();
    let first = |name: &str| rows[0][names.iter().position(|n| n == name).unwrap()];
    for (axis, expected) in [("x", 1.1), ("y", 2.2), ("z", 3.3)] {
        let found = first(&format!("body.part.{axis}"));
        assert!((found - expected).abs() < 1e-12, "{axis}: {found}");
    }
    // Kinetic energy ½ m v² + ½ J ω² with J = m (0.2² + 0.6²)/12.
    let mass = 2.5 * 0.2 * 0.4 * 0.6;
    let kinetic = 0.5 * mass * 0.25 + 0.5 * mass * (0.04 + 0.36) / 12.0 * 16.0;
    assert!((first("kinetic") - kinetic).abs() < 1e-12, "{}", first("kinetic"));
    let drawn = fs::read_to_string(results.join("bodies/0000.vtu")).unwrap();
    assert!(drawn.contains("NumberOfPoints=\"8\" NumberOfCells=\"12\""), "{}", &drawn[..600]);
    assert!(fs::read_dir(&results).unwrap().any(|f| f.unwrap().file_name() == "snapshots.png"));
}

/// A run is not resumed with another surface: the results so far belong to the old one.
#[test]
fn changed_surface_is_another_model() {
    let folder = tempfile::tempdir().unwrap();
    let deck = deck(folder.path(), MODEL);
    let before = job::prepare(&deck).unwrap().fingerprint;
    assert_eq!(job::prepare(&deck).unwrap().fingerprint, before);
    fs::write(folder.path().join("parts/box.stl"), cuboid([2.0, 4.0, 6.5])).unwrap();
    assert_ne!(job::prepare(&deck).unwrap().fingerprint, before);
}

/// Steps compile the model again, with its surfaces.
#[test]
#[ignore = "long"]
fn models_with_steps_have_their_surfaces_in_all_of_them() {
    let folder = tempfile::tempdir().unwrap();
    let analysis = "analysis = { type = \"transient\", end_time = 0.1, time_step = 0.01, scheme = { type = \"energy-momentum\" } }";
    let step = |name: &str| format!("[[steps]]\nname = \"{name}\"\n{analysis}\n");
    let steps = step("first") + &step("second") + &MODEL[MODEL.find("[[bodies]]").unwrap()..];
    let deck = deck(folder.path(), &steps);
    let summary = job::run(&deck, &options(folder.path(), false), &mut Unwatched).unwrap();
    assert_eq!(summary.analyses.len(), 2);
}

#[test]
fn wrong_files_are_reported_at_their_keys_with_all_other_mistakes() {
    let folder = tempfile::tempdir().unwrap();
    let second = MODEL[MODEL.find("[[bodies]]").unwrap()..]
        .replace("box.stl", "none.stl")
        .replace("\"part\"", "\"b\"");
    let text = MODEL.replace("box.stl", "hole.stl").replace("at = [1", "mass = 1.0\nat = [1") + &second;
    let deck = deck(folder.path(), &text);
    let whole = cuboid([1.0; 3]);
    let open =
        whole.replacen(&whole[whole.find("facet").unwrap()..=whole.find("endfacet\n").unwrap() + 8], "", 1);
    fs::write(folder.path().join("parts/hole.stl"), open).unwrap();
    let message = job::prepare(&deck).err().expect("the files are wrong").to_string();
    assert!(message.contains("parts/hole.stl: the surface is not closed: 3 edges"), "{message}");
    assert!(message.contains("there is no such STL file") && message.contains("none.stl"), "{message}");
    assert!(message.contains("body \"part\" has a mass and a density"), "{message}");
}
