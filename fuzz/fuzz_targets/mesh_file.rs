//! Mesh files, triangulated surfaces and tables of nodes.
#![no_main]

#[path = "../readers.rs"]
mod readers;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| readers::mesh_file(bytes));
