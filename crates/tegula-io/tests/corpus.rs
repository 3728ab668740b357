//! The files that the fuzzer found to reach every branch of the readers, and those that once made a reader fail.
#![allow(clippy::unwrap_used, clippy::expect_used)]

use std::fs::File;
use std::io::{BufRead as _, BufReader};
use std::path::Path;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use flate2::read::GzDecoder;

#[path = "../../../fuzz/readers.rs"]
mod fuzzed;

/// Feeds all files of the corpus of a target to its readers; there are `least` of them or more.
fn feed(target: &str, least: usize, read: fn(&[u8])) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/corpus").join(target);
    let lines = BufReader::new(GzDecoder::new(File::open(path.with_extension("gz")).unwrap())).lines();
    let files = lines.map(|line| read(&STANDARD.decode(line.unwrap()).unwrap())).count();
    assert!(files >= least, "{target}: {files} files");
}

#[test]
fn files_of_the_corpus_are_read_or_refused() {
    feed("mesh_file", 1000, fuzzed::mesh_file);
    feed("vtu_file", 1000, fuzzed::vtu_file);
    feed("result_file", 500, fuzzed::result_file);
    feed("checkpoint", 30, fuzzed::checkpoint);
}

#[test]
fn input_files_of_the_corpus_are_converted_or_refused() {
    feed("keyword_input", 1000, fuzzed::keyword_input);
}

#[test]
fn model_files_of_the_corpus_are_compiled_or_refused() {
    feed("model_file", 1000, fuzzed::model_file);
}
