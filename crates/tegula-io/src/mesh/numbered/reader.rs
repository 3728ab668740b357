//! Text of a file, and errors at its lines.

use std::borrow::Cow;
use std::path::Path;

use crate::mesh::{At, MeshError};

/// Longest part of a line that a message repeats (characters).
const SHOWN: usize = 40;

/// Reader of one file: makes its errors.
#[derive(Debug, Clone, Copy)]
pub struct Reader<'a> {
    path: &'a Path,
}

impl<'a> Reader<'a> {
    /// A reader whose errors name the file at `path`.
    pub fn new(path: &'a Path) -> Self {
        Self { path }
    }

    /// Name of the file without its folder.
    pub fn file_name(&self) -> String {
        self.path.file_name().unwrap_or(self.path.as_os_str()).to_string_lossy().into_owned()
    }

    /// An error at a line.
    pub fn error(&self, line: usize, message: impl Into<String>, help: impl Into<String>) -> MeshError {
        MeshError {
            file: self.path.to_owned(),
            at: At::Line(line),
            message: message.into(),
            help: help.into(),
        }
    }

    /// An error of the file as a whole.
    pub fn whole(&self, message: impl Into<String>, help: impl Into<String>) -> MeshError {
        MeshError { at: At::File, ..self.error(0, message, help) }
    }
}

/// Text of the bytes of a file; bytes that are no UTF-8, as comments may have them, become replacement characters.
pub fn text(bytes: &[u8]) -> Cow<'_, str> {
    String::from_utf8_lossy(bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes))
}

/// Beginning of a text that a message repeats.
pub fn shown(text: &str) -> String {
    match text.char_indices().nth(SHOWN) {
        Some((end, _)) => format!("{}…", text.get(..end).unwrap_or_default()),
        None => text.to_owned(),
    }
}
