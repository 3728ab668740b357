//! `ARCHITECTURE.md` tells the truth: every path that it names exists.
#![allow(clippy::unwrap_used)]

use std::path::{Path, PathBuf};

/// Text between single backticks, code blocks left out.
fn quoted(text: &str) -> Vec<String> {
    let mut out = Vec::new();
    let mut block = false;
    for line in text.lines() {
        if line.trim_start().starts_with("```") {
            block = !block;
        } else if !block {
            out.extend(line.split('`').skip(1).step_by(2).map(str::to_string));
        }
    }
    out
}

/// True for what is meant as a path of the repository: `a/b`, `a/` or a file name with a known ending.
fn is_path(text: &str) -> bool {
    let plain = text.chars().all(|c| c.is_ascii_alphanumeric() || "/._-*{},".contains(c));
    let endings = [".rs", ".md", ".toml", ".csv", ".json", ".sh", ".yml", ".py", ".msh"];
    plain
        && !text.starts_with('/')
        && (text.contains('/') || endings.iter().any(|e| text.len() > e.len() && text.ends_with(e)))
}

/// The alternatives of `a/{b,c}.rs`, and the folder of `a/*.rs`.
fn expanded(path: &str) -> Vec<String> {
    if let (Some(open), Some(close)) = (path.find('{'), path.find('}')) {
        let (before, after) = (&path[..open], &path[close + 1..]);
        return path[open + 1..close]
            .split(',')
            .flat_map(|p| expanded(&format!("{before}{p}{after}")))
            .collect();
    }
    match path.find('*') {
        Some(star) => vec![path[..star].rfind('/').map_or("", |slash| &path[..slash]).to_string()],
        None => vec![path.to_string()],
    }
}

/// Paths count from the root or from the sources of a crate.
fn missing(root: &Path, text: &str) -> Vec<String> {
    let bases: Vec<PathBuf> =
        ["", "crates", "crates/tegula", "crates/tegula/src", "crates/tegula-io/src", "crates/tegula-cli/src"]
            .iter()
            .map(|b| root.join(b))
            .collect();
    quoted(text)
        .into_iter()
        .filter(|p| is_path(p))
        .flat_map(|p| expanded(&p))
        .filter(|p| !bases.iter().any(|b| b.join(p).exists()))
        .collect()
}

#[test]
fn paths_of_the_architecture_exist() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let text = std::fs::read_to_string(root.join("ARCHITECTURE.md")).unwrap();
    let named = quoted(&text).iter().filter(|p| is_path(p)).count();
    assert!(named > 50, "{named} paths");
    let missing = missing(&root, &text);
    assert!(missing.is_empty(), "ARCHITECTURE.md names paths that do not exist: {missing:?}");
}

#[test]
fn missing_paths_are_found() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let text = "`element/ems.rs`, `crates/tegula/`, `f = S n`, `element/{ems,none}.rs`, `Cargo.toml`, `src/nowhere/`\n\
                ```\n`in/a/block.rs`\n```\n`model/*.rs`, `nonsense.md`";
    assert_eq!(missing(&root, text), ["element/none.rs", "src/nowhere/", "nonsense.md"]);
}
