//! `ARCHITECTURE.md` is true: paths and types that it names exist, and rooms import each other in its order.
#![allow(clippy::unwrap_used)]

use std::collections::{BTreeMap, BTreeSet};
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

/// Source text without comments and without the unit tests at its end.
fn code(path: &Path) -> String {
    let text = std::fs::read_to_string(path).unwrap();
    let code = text.split("#[cfg(test)]\nmod tests {").next().unwrap();
    code.lines().filter(|line| !line.trim_start().starts_with("//")).collect::<Vec<_>>().join("\n")
}

/// Source files below a folder, but for modules that exist in tests only.
fn sources(folder: &Path, out: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_stem().unwrap().to_str().unwrap().to_owned();
        let parent = ["mod.rs", "lib.rs", "main.rs"]
            .map(|name| folder.join(name))
            .into_iter()
            .chain([folder.with_extension("rs")])
            .find(|p| p.exists())
            .unwrap();
        let test_only = code_of_tests(&parent).contains(&name);
        if !test_only && path.is_dir() {
            sources(&path, out);
        } else if !test_only && path.extension().is_some_and(|e| e == "rs") {
            out.push(path);
        }
    }
}

/// Modules that a file declares for tests only.
fn code_of_tests(path: &Path) -> Vec<String> {
    let text = std::fs::read_to_string(path).unwrap();
    text.split("#[cfg(test)]\nmod ")
        .skip(1)
        .filter_map(|rest| rest.split_once(';'))
        .map(|(name, _)| name.to_owned())
        .filter(|name| name.chars().all(|c| c.is_alphanumeric() || c == '_'))
        .collect()
}

/// Rooms of a crate with the rooms that each imports. Items that `lib.rs` re-exports belong to their room.
fn imports(source: &Path) -> BTreeMap<String, BTreeSet<String>> {
    let library = std::fs::read_to_string(source.join("lib.rs")).unwrap();
    let exported = |item: &str| {
        let line = library.lines().find(|l| {
            l.starts_with("pub use ")
                && l.split(|c: char| !c.is_alphanumeric() && c != '_').any(|word| word == item)
        })?;
        line.strip_prefix("pub use ")?.split("::").next().map(str::to_owned)
    };
    let mut out: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    let mut files = Vec::new();
    sources(source, &mut files);
    for file in files {
        let inside = file.strip_prefix(source).unwrap();
        let room = inside.components().next().unwrap().as_os_str().to_str().unwrap().trim_end_matches(".rs");
        let found = out.entry(room.to_owned()).or_default();
        let text = code(&file);
        for used in text.split("crate::").skip(1) {
            // Registries name the files of kinds wherever these lie: `crate::analysis::…::$file`.
            let path = used.split(|c: char| c.is_whitespace() || ";,)>".contains(c)).next().unwrap();
            if path.contains('$') {
                continue;
            }
            let names = match used.strip_prefix('{') {
                Some(list) => list.split('}').next().unwrap().split(',').map(str::trim).collect(),
                None => vec![used],
            };
            for name in names {
                let name: String = name.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
                let name = exported(&name).unwrap_or(name);
                if name != room {
                    found.insert(name);
                }
            }
        }
    }
    out
}

/// Rooms on a circle of imports, where there is one.
fn circle(imports: &BTreeMap<String, BTreeSet<String>>) -> Vec<&str> {
    let mut left: BTreeMap<&str, BTreeSet<&str>> = imports
        .iter()
        .map(|(room, used)| {
            (room.as_str(), used.iter().map(String::as_str).filter(|u| imports.contains_key(*u)).collect())
        })
        .collect();
    // Rooms that import no other one left are taken out until nothing changes.
    loop {
        let Some(free) = left.iter().find(|(_, used)| used.is_empty()).map(|(room, _)| *room) else {
            return left.into_keys().collect();
        };
        left.remove(free);
        left.values_mut().for_each(|used| {
            used.remove(free);
        });
    }
}

#[test]
fn no_two_rooms_import_each_other() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    for name in ["tegula", "tegula-io", "tegula-sparse"] {
        let found = imports(&root.join(name).join("src"));
        assert!(found.len() > 3, "{name}: {found:?}");
        assert_eq!(circle(&found), Vec::<&str>::new(), "{name}: {found:#?}");
    }
}

#[test]
fn a_circle_of_imports_is_found() {
    let room = |name: &str, used: &[&str]| {
        (name.to_owned(), used.iter().map(|u| (*u).to_owned()).collect::<BTreeSet<_>>())
    };
    let open = BTreeMap::from([room("a", &["b", "c"]), room("b", &["c", "Vec3"]), room("c", &[])]);
    assert_eq!(circle(&open), Vec::<&str>::new());
    let closed = BTreeMap::from([room("a", &["b"]), room("b", &["c"]), room("c", &["a"]), room("d", &["a"])]);
    assert_eq!(circle(&closed), ["a", "b", "c", "d"]);
}

fn architecture() -> String {
    std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../../ARCHITECTURE.md")).unwrap()
}

/// Types and traits that the crates define.
fn defined_types() -> BTreeSet<String> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let mut out = BTreeSet::new();
    let crates =
        ["crates/tegula-sparse", "crates/tegula", "crates/tegula-io", "crates/tegula-cli", "verification"];
    for name in crates {
        let mut files = Vec::new();
        sources(&root.join(name).join("src"), &mut files);
        for file in files {
            for line in code(&file).lines() {
                let mut words =
                    line.split(|c: char| !c.is_alphanumeric() && c != '_').filter(|w| !w.is_empty());
                if words.any(|w| ["struct", "enum", "trait", "type"].contains(&w)) {
                    out.extend(words.next().map(str::to_owned));
                }
            }
        }
    }
    out
}

/// Types that a text names between backticks.
fn named_types(text: &str) -> Vec<String> {
    let camel = |w: &String| {
        w.starts_with(|c: char| c.is_ascii_uppercase())
            && w.chars().all(|c| c.is_ascii_alphanumeric())
            && w.contains(|c: char| c.is_ascii_lowercase())
    };
    quoted(text).into_iter().filter(camel).collect()
}

#[test]
fn types_of_the_architecture_exist_and_it_is_short() {
    let (text, defined) = (architecture(), defined_types());
    assert!(text.lines().count() < 150, "{} lines", text.lines().count());
    let named = named_types(&text);
    assert!(named.len() > 20, "{named:?}");
    let missing: Vec<_> = named.iter().filter(|t| !defined.contains(*t)).collect();
    assert!(missing.is_empty(), "ARCHITECTURE.md names types that do not exist: {missing:?}");
    assert_eq!(named_types("`Nowhere`, `System`, `H`, `Cargo.toml`"), ["Nowhere", "System"]);
    assert!(!defined.contains("Nowhere"));
}

#[test]
fn rooms_import_rooms_above_them_only() {
    let text = architecture();
    let room = |line: &str| {
        let path = line.strip_prefix("| `crates/tegula/src/")?;
        Some(path.split('`').next()?.to_owned())
    };
    let order: Vec<String> = text.lines().filter_map(room).collect();
    assert!(order.len() > 8, "{order:?}");
    for (name, used) in imports(&Path::new(env!("CARGO_MANIFEST_DIR")).join("src")) {
        let Some(place) = order.iter().position(|o| *o == name) else { continue };
        let below: Vec<_> = used.iter().filter(|u| order[place..].contains(u)).collect();
        assert!(below.is_empty(), "{name} imports {below:?}, which stand below it");
    }
}
