//! Input files of Abaqus and CalculiX in the place of model files: mistakes of the model stand on the lines of the input file.

use std::path::Path;
use std::sync::Arc;

use tegula::Issue;

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
    let converted = abaqus::convert(path, bytes, mesh_file)
        .map_err(|errors| errors.iter().map(|error| diagnostic(path, &text, error)).collect::<Vec<_>>())?;
    let input = KeywordInput { text: text.into(), lines: converted.lines.into() };
    let mut deck = Deck::parse(path, converted.text)
        .map_err(|found| found.into_iter().map(|d| input.translated(d)).collect::<Vec<_>>())?;
    deck.warnings.extend(converted.ignored.map(|message| {
        Issue::new(
            "",
            message,
            "results are those of `[output]` in the model file, which `tegula convert` writes",
        )
    }));
    deck.input = Some(input);
    Ok(deck)
}

/// Mistake of an input file as a diagnostic.
fn diagnostic(path: &Path, text: &str, error: &MeshError) -> Diagnostic {
    match error.at {
        At::Line(line) => on_line(path, text, line, &error.message, &error.help),
        _ => Diagnostic::whole(path, error.message.as_str(), error.help.as_str()),
    }
}

/// A diagnostic of a whole line, counted from 1.
fn on_line(path: &Path, text: &str, line: usize, message: &str, help: &str) -> Diagnostic {
    let starts = std::iter::once(0).chain(text.match_indices('\n').map(|(i, _)| i + 1));
    let start = starts.into_iter().nth(line.saturating_sub(1)).unwrap_or(0);
    let content = text.get(start..).and_then(|rest| rest.lines().next()).unwrap_or_default();
    let blanks = content.len() - content.trim_start().len();
    Source::new(path, text).at(
        start + blanks..start + content.trim_end().len().max(blanks),
        "",
        message,
        help,
    )
}

impl KeywordInput {
    /// The diagnostic of a line of the model file at the line of the input file that it comes from.
    pub(super) fn translated(&self, d: Diagnostic) -> Diagnostic {
        let line = d.line.checked_sub(1).and_then(|i| self.lines.get(i)).copied().unwrap_or(0);
        let place = match line {
            0 => Diagnostic::whole(&d.file, "", ""),
            _ => on_line(&d.file, &self.text, line, "", ""),
        };
        let Diagnostic { key, message, help, hidden, .. } = d;
        Diagnostic { key, message, help, hidden, ..place }
    }
}
