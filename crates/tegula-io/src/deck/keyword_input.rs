//! Input files of Abaqus and CalculiX in the place of model files: mistakes of the model stand on the lines of the input file.

use std::path::Path;
use std::sync::Arc;

use super::diagnostic::Source;
use super::{Deck, Diagnostic};
use crate::abaqus;
use crate::mesh::{At, MeshError};

/// Input file that a model was made of.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct KeywordInput {
    text: Arc<str>,
    /// Line of the input file for each line of the model file; 0 for none.
    lines: Arc<[usize]>,
}

/// Whether a file is an input file by its name.
pub(super) fn is_input(path: &Path) -> bool {
    path.extension().is_some_and(|end| end.eq_ignore_ascii_case("inp"))
}

/// Model of the bytes of an input file, whose name the model gives as `mesh_file`.
pub(super) fn parse(path: &Path, bytes: &[u8], mesh_file: &str) -> Result<Deck, Vec<Diagnostic>> {
    let text = crate::mesh::abaqus::cards::text(bytes);
    let converted = abaqus::convert(path, bytes, mesh_file).map_err(|errors| {
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
