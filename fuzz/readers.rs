//! Readers of files on arbitrary bytes: any answer will do, as long as there is one. The targets of the fuzzer and the test of the corpus
//! share these functions.
#![allow(dead_code)]

use std::fs;
use std::path::Path;

use tegula::analysis::State;
use tegula_io::deck::Deck;
use tegula_io::job::{JobError, Summary, prepare};
use tegula_io::memory::{self, Limit};
use tegula_io::mesh::vtu::Vtu;
use tegula_io::mesh::{MeshReader as _, node_table, readers, stl};
use tegula_io::out::vtu_file::VtuFile;
use tegula_io::out::{HistoryWriter, PvdSeries, csv, load_checkpoint, save_checkpoint};
use tegula_io::report;

/// Memory that a model may need at most to be compiled here: 4 MiB.
const SMALL: Limit = Limit { bytes: 4 << 20, source: "the fuzzer" };

/// Mesh files of every format, triangulated surfaces, and tables of displacements of nodes.
pub fn mesh_file(bytes: &[u8]) {
    let path = Path::new("file");
    for (_, _, parse) in readers() {
        let _ = parse(path, bytes, 1.0);
    }
    let _ = stl::parse(path, bytes);
    let _ = node_table::parse(path, bytes);
}

/// VTU files as meshes.
pub fn vtu_file(bytes: &[u8]) {
    let _ = Vtu::parse(Path::new("file"), bytes, 1.0);
}

/// Input files of Abaqus, CalculiX and Nastran.
pub fn keyword_input(bytes: &[u8]) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for name in ["file.inp", "file.bdf"] {
        let path = folder.path().join(name);
        fs::write(&path, bytes).expect("a temporary file");
        if let Ok(deck) = Deck::read(&path) {
            compile(&deck);
        }
    }
}

/// Model files.
pub fn model_file(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    // No file has this name, so that models find neither meshes nor surfaces.
    match Deck::parse("/nowhere/model.toml", text) {
        Ok(deck) => compile(&deck),
        Err(found) => assert!(!found.is_empty(), "refused without a reason"),
    }
}

/// Files of a result folder.
pub fn result_file(bytes: &[u8]) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = |name: &str| {
        let path = folder.path().join(name);
        fs::write(&path, bytes).expect("a temporary file");
        path
    };
    if let Ok(grid) = VtuFile::open(&file("fields.vtu")) {
        let _ = grid.coordinates();
        let _ = grid.cells();
        for array in &grid.arrays {
            let _ = grid.values(array);
        }
    }
    let _ = PvdSeries::open(&file("fields.pvd"));
    let _ = csv::read(&file("history.csv"));
    let _ = HistoryWriter::resume(&file("resumed.csv"), 1);
    file("summary.json");
    let _ = Summary::read(folder.path());
    let _ = report::Report::of(folder.path(), 10);
}

/// Part of a checkpoint that holds the state of the run.
#[derive(serde::Deserialize)]
struct Saved {
    #[serde(rename = "state")]
    _state: State,
}

/// Data of a checkpoint as the state of a run. A checkpoint ends with a checksum, which arbitrary bytes do not fit: it is put behind them.
pub fn checkpoint(bytes: &[u8]) {
    /// Letters, version and fingerprint.
    const HEADER: usize = 20;
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("checkpoint.bin");
    save_checkpoint(&path, 1, &()).expect("a temporary file");
    let mut file = fs::read(&path).expect("a temporary file")[..HEADER].to_vec();
    file.extend(bytes);
    file.extend(crc32fast::hash(&file).to_le_bytes());
    fs::write(&path, file).expect("a temporary file");
    let _ = load_checkpoint::<Saved>(&path, 1);
}

/// Compiles a model if it is small.
fn compile(deck: &Deck) {
    if memory::too_large(&deck.model, Some(SMALL)).is_some() {
        return;
    }
    if let Err(JobError::Model(found)) = prepare(deck) {
        assert!(!found.is_empty(), "refused without a reason");
    }
}
