//! Input files of Abaqus, CalculiX and Nastran, converted to models.
#![no_main]

#[path = "../readers.rs"]
mod readers;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| readers::keyword_input(bytes));
