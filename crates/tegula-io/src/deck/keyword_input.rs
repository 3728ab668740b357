//! Input files of Abaqus, CalculiX and Nastran in the place of model files: mistakes of the model stand on the lines of the input file.

use std::path::Path;
use std::sync::Arc;

use super::diagnostic::Source;
use super::{Deck, Diagnostic};
use crate::mesh::nastran::file as nastran_file;
use crate::mesh::numbered::text;
use crate::mesh::{At, MeshError};
use crate::{abaqus, nastran};

/// Input file that a model was made of.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct KeywordInput {
    text: Arc<str>,
    /// Line of the input file for each line of the model file; 0 for none.
    lines: Arc<[usize]>,
}

/// Program that an input file is written for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Format {
    /// Abaqus or CalculiX.
    Abaqus,
    /// Nastran.
    Nastran,
}

/// Format of an input file by its name; `None` for model files. A file `.dat` is one of Nastran where it has `BEGIN BULK`.
pub(super) fn by_name(path: &Path, bytes: &[u8]) -> Option<Format> {
    let is = |end: &str| path.extension().is_some_and(|own| own.eq_ignore_ascii_case(end));
    if is("inp") {
        Some(Format::Abaqus)
    } else if is("bdf") || is("nas") || (is("dat") && by_content(bytes) == Format::Nastran) {
        Some(Format::Nastran)
    } else {
        None
    }
}

/// Format of an input file by its content.
pub(super) fn by_content(bytes: &[u8]) -> Format {
    match nastran_file::is_complete(&text(bytes)) {
        true => Format::Nastran,
        false => Format::Abaqus,
    }
}

/// Model of the bytes of an input file, whose name the model gives as `mesh_file`.
pub(super) fn parse(
    path: &Path,
    bytes: &[u8],
    format: Format,
    mesh_file: &str,
) -> Result<Deck, Vec<Diagnostic>> {
    let text = text(bytes);
    let convert = match format {
        Format::Abaqus => abaqus::convert,
        Format::Nastran => nastran::convert,
    };
    let converted = convert(path, bytes, mesh_file).map_err(|errors| {
        let source = Source::new(path, &text);
        errors.iter().map(|error| diagnostic(&source, path, error)).collect::<Vec<_>>()
    })?;
    let input = KeywordInput { text: text.into(), lines: converted.lines.into() };
    let mut deck = Deck::parse(path, converted.text).map_err(|found| input.translated(path, found))?;
    deck.warnings.extend(converted.warnings);
    deck.input = Some(input);
    Ok(deck)
}

/// Mistake of an input file as a diagnostic.
fn diagnostic(source: &Source, path: &Path, error: &MeshError) -> Diagnostic {
    let (message, help) = (error.message.as_str(), error.help.as_str());
    match error.at {
        At::Line(line) => source.at(source.line(line), "", message, help),
        _ => Diagnostic::whole(path, message, help),
    }
}

impl KeywordInput {
    /// The diagnostics of lines of the model file at the lines of the input file at `path` that they come from.
    pub(super) fn translated(&self, path: &Path, found: Vec<Diagnostic>) -> Vec<Diagnostic> {
        let source = Source::new(path, &self.text);
        let origin = |d: &Diagnostic| d.line.checked_sub(1).and_then(|i| self.lines.get(i)).copied();
        let moved = |d: Diagnostic| {
            let place = match origin(&d) {
                None | Some(0) => Diagnostic::whole(path, "", ""),
                Some(line) => source.at(source.line(line), "", "", ""),
            };
            let Diagnostic { key, message, help, hidden, .. } = d;
            Diagnostic { key, message, help, hidden, ..place }
        };
        found.into_iter().map(moved).collect()
    }
}
