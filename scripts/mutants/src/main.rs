//! Mutant schemata (Untch, Offutt and Harrold 1993): all mutants of the source files are written into one copy of these files,
//! and the program chooses one of them at run time, so that it is compiled once.
//!
//! ```text
//! mutants SOURCE COPY DROPPED FILE...
//! ```
//!
//! reads the files, paths in the folder SOURCE, and writes them with their mutants into the folder COPY. DROPPED is a file with
//! the numbers of the mutants to leave out, because they do not compile. The list of all mutants goes to the standard output as
//! JSON, with the bytes of the copy where each of them lies: there the compiler points at if it does not compile.

mod defaults;
mod sites;
mod write;

use std::collections::BTreeSet;
use std::path::Path;
use std::{env, fs, process};

use serde_json::{Value, json};

use sites::Collector;
use write::Writer;

fn main() {
    if let Err(error) = run(&env::args().skip(1).collect::<Vec<_>>()) {
        eprintln!("{error}");
        process::exit(1);
    }
}

fn run(arguments: &[String]) -> Result<(), String> {
    let [source, copy, dropped, files @ ..] = arguments else {
        return Err("mutants SOURCE COPY DROPPED FILE...".into());
    };
    let read = |path: &Path| fs::read_to_string(path).map_err(|e| format!("{}: {e}", path.display()));
    let dropped: BTreeSet<u32> =
        read(Path::new(dropped))?.split_whitespace().filter_map(|n| n.parse().ok()).collect();
    let mut all: Vec<Value> = Vec::new();
    // Number 0 means no mutant.
    let mut next = 1;
    for file in files {
        let text = read(&Path::new(source).join(file))?;
        let tree = syn::parse_file(&text).map_err(|e| format!("{file}: {e}"))?;
        let mut collector = Collector::new(&text, next);
        syn::visit::visit_file(&mut collector, &tree);
        next = collector.next;
        let written = Writer::new(&text, &collector.sites, &dropped).file();
        let to = Path::new(copy).join(file);
        // An unchanged file keeps its time, so that it is not compiled again.
        if fs::read_to_string(&to).ok().as_ref() != Some(&written.text) {
            let folder = to.parent().unwrap_or(Path::new(""));
            fs::create_dir_all(folder)
                .and_then(|()| fs::write(&to, &written.text))
                .map_err(|e| format!("{}: {e}", to.display()))?;
        }
        for mutant in collector.mutants {
            let places = written.places.get(&mutant.number).cloned().unwrap_or_default();
            all.push(json!({
                "number": mutant.number, "file": file, "line": mutant.line, "column": mutant.column,
                "function": mutant.function, "kind": mutant.kind, "original": mutant.original,
                "mutant": mutant.replacement, "site": places.site, "branches": places.branches, "body": places.body,
            }));
        }
    }
    println!("{}", Value::from(all));
    Ok(())
}
