//! The book tells the truth about the patch tests, and all about the model file.
#![allow(missing_docs, clippy::unwrap_used)]

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::process::Command;

use serde_json::Value;

/// Cells of a Markdown table by rows; numbers, which say by how much a test fails, become `fails`.
fn verdicts(text: &str) -> Vec<Vec<String>> {
    let number = |cell: &str| cell.parse::<f64>().is_ok_and(f64::is_finite);
    let verdict = |cell: &str| if number(cell) { "fails".into() } else { cell.to_string() };
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

/// Names of keys, and words that keys may hold, anywhere in a schema.
fn words(schema: &Value, out: &mut BTreeSet<String>) {
    match schema {
        Value::Object(fields) => {
            if let Some(Value::Object(properties)) = fields.get("properties") {
                out.extend(properties.keys().cloned());
            }
            let texts = fields
                .get("const")
                .into_iter()
                .chain(fields.get("enum").and_then(Value::as_array).into_iter().flatten());
            out.extend(texts.filter_map(Value::as_str).map(str::to_owned));
            fields.values().for_each(|v| words(v, out));
        }
        Value::Array(items) => items.iter().for_each(|v| words(v, out)),
        _ => {}
    }
}

#[test]
fn the_book_names_every_key_and_word_of_the_model_file() {
    let schema = Command::new(env!("CARGO_BIN_EXE_tegula")).arg("schema").output().unwrap();
    let mut all = BTreeSet::new();
    words(&serde_json::from_slice(&schema.stdout).unwrap(), &mut all);
    assert!(all.len() > 150 && all.contains("thickness") && all.contains("solid-shell"), "{all:?}");
    let pages: String = ["model-file.md", "composites.md", "bodies-and-joints.md"]
        .map(|page| {
            fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../../book/src").join(page))
                .unwrap()
        })
        .concat();
    let named = |word: &String| {
        [format!("`{word}`"), format!("`{word}.NAME`"), format!("\"{word}\"")]
            .iter()
            .any(|w| pages.contains(w))
    };
    let missing: Vec<_> = all.iter().filter(|w| !named(w)).collect();
    assert!(missing.is_empty(), "say in book/src/model-file.md what these are: {missing:?}");
}
