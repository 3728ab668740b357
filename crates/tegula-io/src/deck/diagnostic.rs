//! Diagnostic: one mistake in a model file, with place and remedy.

use std::fmt;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Number of mistakes that are reported individually; of further ones only the number is reported.
pub const MOST_DIAGNOSTICS: usize = 100;

/// One thing wrong with a model file: where, what, and what to do about it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Diagnostic {
    /// The model file.
    pub file: PathBuf,
    /// Text of the file as it was read; empty where it could not be.
    pub text: Arc<str>,
    /// Line, counted from 1; 0 for the file as a whole (if it cannot be read, for example).
    pub line: usize,
    /// Column in characters, counted from 1; 0 for the file as a whole.
    pub column: usize,
    /// Range of bytes that the diagnostic concerns.
    pub span: Range<usize>,
    /// Path of the key, such as `loads[2].on`; empty for the whole model and for errors of syntax.
    pub key: String,
    /// Description of the mistake: one sentence.
    pub message: String,
    /// Remedy; may be empty.
    pub help: String,
    /// Number of further mistakes that this entry represents; nonzero only in the last entry of a long list.
    pub hidden: usize,
}

impl Diagnostic {
    /// A diagnostic of the file as a whole.
    pub(super) fn whole(file: &Path, message: impl Into<String>, help: impl Into<String>) -> Self {
        Self { line: 0, column: 0, ..Source::new(file, "").at(0..0, "", message, help) }
    }
}

/// Text of a model file with the places of its lines, so that many mistakes are located in little time.
#[derive(Debug, Clone)]
pub(super) struct Source {
    file: PathBuf,
    text: Arc<str>,
    /// Byte at which each line begins.
    lines: Vec<usize>,
}

impl Source {
    /// The text of the file at `file`.
    pub fn new(file: &Path, text: &str) -> Self {
        let lines = std::iter::once(0).chain(text.match_indices('\n').map(|(i, _)| i + 1)).collect();
        Self { file: file.to_owned(), text: text.into(), lines }
    }

    /// The text.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Bytes of a line, counted from 1, without blanks around it.
    pub fn line(&self, line: usize) -> Range<usize> {
        let start = self.lines.get(line.saturating_sub(1)).copied().unwrap_or(self.text.len());
        let content = self.text.get(start..).and_then(|rest| rest.lines().next()).unwrap_or_default();
        let first = start + content.len() - content.trim_start().len();
        first..first + content.trim().len()
    }

    /// A diagnostic of the bytes `span` of the text.
    pub fn at(
        &self,
        span: Range<usize>,
        key: impl Into<String>,
        message: impl Into<String>,
        help: impl Into<String>,
    ) -> Diagnostic {
        let text = &self.text;
        let start = floor(text, span.start);
        let end = floor(text, span.end).max(start);
        let line = self.lines.partition_point(|&first| first <= start).max(1);
        let before = text.get(self.lines[line - 1]..start).unwrap_or_default();
        Diagnostic {
            file: self.file.clone(),
            text: text.clone(),
            line,
            column: 1 + before.chars().filter(|&c| c != '\u{feff}').count(),
            span: start..end,
            key: key.into(),
            message: message.into(),
            help: help.into(),
            hidden: 0,
        }
    }

    /// First mistakes of a list of `all` ones, and an entry with the number of the remaining ones.
    pub fn limited(&self, mut found: Vec<Diagnostic>, all: usize) -> Vec<Diagnostic> {
        found.truncate(MOST_DIAGNOSTICS);
        let hidden = all - found.len();
        if hidden > 0 {
            let message = format!("{hidden} more mistakes are not shown");
            let help = format!("repair these {} first", found.len());
            found.push(Diagnostic { hidden, ..Diagnostic::whole(&self.file, message, help) });
        }
        found
    }
}

/// The greatest boundary of a character at or before `index`.
fn floor(text: &str, index: usize) -> usize {
    (0..=index.min(text.len())).rev().find(|&i| text.is_char_boundary(i)).unwrap_or(0)
}

impl fmt::Display for Diagnostic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:", self.file.display())?;
        if self.line > 0 {
            write!(f, "{}:{}:", self.line, self.column)?;
        }
        if !self.key.is_empty() {
            write!(f, " {}:", self.key)?;
        }
        write!(f, " {}", self.message)?;
        if !self.help.is_empty() {
            write!(f, "\n  help: {}", self.help)?;
        }
        Ok(())
    }
}

impl std::error::Error for Diagnostic {}
