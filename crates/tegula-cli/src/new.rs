//! `tegula new`

use std::fs::OpenOptions;
use std::io::{ErrorKind, Write as _};
use std::path::{Path, PathBuf};

use clap::Args;
use clap::builder::PossibleValuesParser;
use tegula_io::deck;
use tegula_io::out::write_whole;

use crate::report::Failure;

/// Arguments of `tegula new`.
#[derive(Debug, Args)]
pub struct Arguments {
    /// Kind of model
    #[arg(value_parser = PossibleValuesParser::new(deck::template_kinds()))]
    kind: String,
    /// File to write [default: <KIND>.toml]
    file: Option<PathBuf>,
}

/// Writes the template and the files it needs; never over a file.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let kind = arguments.kind.as_str();
    let file = arguments.file.clone().unwrap_or_else(|| PathBuf::from(format!("{kind}.toml")));
    let stem = file.file_stem().unwrap_or(file.as_os_str()).to_string_lossy();
    if stem.contains(['"', '\\']) || stem.chars().any(char::is_control) {
        return Err(Failure::Usage(format!(
            "`{}` cannot stand in a model file; use a name without quotes and backslashes",
            file.display()
        )));
    }
    let Some((text, companions)) = deck::template_named(kind, &stem) else {
        return Err(Failure::Usage(format!("there is no template `{kind}`")));
    };
    let mut files = vec![(file.clone(), text)];
    let beside = |name: &str| file.parent().unwrap_or(Path::new("")).join(name);
    files.extend(companions.into_iter().map(|(name, text)| (beside(&name), text)));
    if files.iter().skip(1).any(|(path, _)| *path == file) {
        return Err(Failure::Usage(format!(
            "`{}` is the name of a mesh file; call the model .toml",
            file.display()
        )));
    }
    if let Some((taken, _)) = files.iter().find(|(path, _)| path.exists()) {
        return Err(exists(taken));
    }
    for (path, text) in &files {
        write(path, text)?;
        say!("{}", path.display());
    }
    refresh_schema(&beside(deck::SCHEMA_FILE))?;
    say!("next: tegula run {}", file.display());
    Ok(())
}

/// Writes the schema for editors beside the model, over an earlier one of this program only.
fn refresh_schema(path: &Path) -> Result<(), Failure> {
    let text = deck::schema_text();
    if !path.exists() {
        write(path, &text)?;
        say!("{}", path.display());
        return Ok(());
    }
    let there = std::fs::read_to_string(path).unwrap_or_default();
    if there != text && deck::is_schema(&there) {
        write_whole(path, |w| w.write_all(text.as_bytes())).map_err(|e| Failure::File(e.to_string()))?;
    }
    Ok(())
}

/// Writes a new file; never over a file.
pub fn write(path: &Path, text: &str) -> Result<(), Failure> {
    let written = OpenOptions::new()
        .write(true)
        .create_new(true)
        .open(path)
        .and_then(|mut f| f.write_all(text.as_bytes()));
    written.map_err(|e| match e.kind() {
        ErrorKind::AlreadyExists => exists(path),
        _ => Failure::File(format!("cannot write `{}`: {e}", path.display())),
    })
}

/// Refusal to write over a file.
pub fn exists(path: &Path) -> Failure {
    Failure::File(format!("`{}` exists already and is not overwritten; give another name", path.display()))
}
