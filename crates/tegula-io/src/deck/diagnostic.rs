//! One thing wrong with a model file, for the person who has to repair it.

use std::fmt;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// One thing wrong with a model file: where, what, and what to do about it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Diagnostic {
    /// The model file.
    pub file: PathBuf,
    /// Line, counted from 1; 0 where the file as a whole is meant (it cannot be read, say).
    pub line: usize,
    /// Column in characters, counted from 1; 0 where the file as a whole is meant.
    pub column: usize,
    /// Bytes of the text that are meant.
    pub span: Range<usize>,
    /// Path of the key, such as `loads[2].on`; empty for the whole model and for errors of syntax.
    pub key: String,
    /// What is wrong: one sentence.
    pub message: String,
    /// What to do about it; may be empty.
    pub help: String,
}

impl Diagnostic {
    /// A diagnostic of the bytes `span` of `text`.
    pub(super) fn new(
        file: &Path,
        text: &str,
        span: Range<usize>,
        key: impl Into<String>,
        message: impl Into<String>,
        help: impl Into<String>,
    ) -> Self {
        let start = floor(text, span.start);
        let end = floor(text, span.end).max(start);
        let before = text.get(..start).unwrap_or_default();
        let line = before.rsplit('\n').next().unwrap_or_default();
        Self {
            file: file.to_owned(),
            line: 1 + before.matches('\n').count(),
            column: 1 + line.chars().filter(|&c| c != '\u{feff}').count(),
            span: start..end,
            key: key.into(),
            message: message.into(),
            help: help.into(),
        }
    }

    /// A diagnostic of the file as a whole.
    pub(super) fn whole(file: &Path, message: impl Into<String>, help: impl Into<String>) -> Self {
        Self { line: 0, column: 0, ..Self::new(file, "", 0..0, "", message, help) }
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
