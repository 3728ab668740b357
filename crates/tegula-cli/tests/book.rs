//! The book tells the truth about the patch tests.
#![allow(missing_docs, clippy::unwrap_used)]

use std::fs;
use std::path::Path;
use std::process::Command;

/// Cells of a Markdown table by rows; numbers, which say by how much a test fails, become `fails`.
fn verdicts(text: &str) -> Vec<Vec<String>> {
    let verdict = |cell: &str| if cell.parse::<f64>().is_ok() { "fails".into() } else { cell.to_string() };
    text.lines()
        .filter(|l| l.starts_with("| "))
        .map(|l| l.trim_matches('|').split('|').map(|c| verdict(c.trim())).collect())
        .collect()
}

#[test]
fn the_table_of_patch_tests_is_that_of_the_program() {
    let book = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../book/src/verification/patch-tests.md");
    let shown = verdicts(&fs::read_to_string(book).unwrap());
    let folder = tempfile::tempdir().unwrap();
    let run = Command::new(env!("CARGO_BIN_EXE_tegula"))
        .args(["verify", "patch", "--tables", folder.path().to_str().unwrap()])
        .output()
        .unwrap();
    assert!(run.status.success(), "{}", String::from_utf8(run.stdout).unwrap());
    let fresh = verdicts(&fs::read_to_string(folder.path().join("patch-tests.md")).unwrap());
    assert!(shown.len() > 10 && shown.iter().flatten().any(|c| c == "fails"), "{shown:?}");
    assert_eq!(shown, fresh, "compute it anew: tegula verify patch --tables book/src/verification");
}
