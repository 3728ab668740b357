//! Scanner of a Gmsh file: numbers and words from ASCII or binary bytes.

use std::path::Path;

use crate::mesh::{At, MeshError};

/// How the numbers of a section are written.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Encoding {
    /// Words with white space between them.
    Ascii,
    /// Fixed sizes; `big` tells the byte order, `wide` whether a `size_t` has 8 bytes (else 4).
    Binary { big: bool, wide: bool },
}

/// A place in the file that moves forward; every number is taken with a word for
/// what it means, which appears in the error when it is not there.
pub(super) struct Scanner<'a> {
    file: &'a Path,
    bytes: &'a [u8],
    position: usize,
    pub encoding: Encoding,
}

const DAMAGED: &str = "the file is cut off or damaged: save the mesh again in Gmsh";

impl<'a> Scanner<'a> {
    pub fn new(file: &'a Path, bytes: &'a [u8]) -> Self {
        Self { file, bytes, position: 0, encoding: Encoding::Ascii }
    }

    /// The name of the file without its folder.
    pub fn file_name(&self) -> String {
        self.file.file_name().unwrap_or(self.file.as_os_str()).to_string_lossy().into_owned()
    }

    /// The place from which the next item is read.
    pub fn position(&self) -> usize {
        self.position
    }

    /// An error of the whole file.
    pub fn whole(&self, message: impl Into<String>, help: impl Into<String>) -> MeshError {
        MeshError { file: self.file.to_owned(), at: At::File, message: message.into(), help: help.into() }
    }

    /// An error at an earlier [`Self::position`]: its line in a text file, else the byte.
    pub fn error(&self, position: usize, message: impl Into<String>, help: impl Into<String>) -> MeshError {
        let at = match self.encoding {
            Encoding::Ascii => {
                // The position may lie on white space before the item.
                let blank = self.rest(position).iter().take_while(|b| b.is_ascii_whitespace()).count();
                let end = if position + blank < self.bytes.len() { position + blank } else { position };
                At::Line(1 + self.bytes.iter().take(end).filter(|&&b| b == b'\n').count())
            }
            Encoding::Binary { .. } => At::Byte(position),
        };
        MeshError { at, ..self.whole(message, help) }
    }

    fn rest(&self, position: usize) -> &'a [u8] {
        self.bytes.get(position..).unwrap_or_default()
    }

    fn skip_blank(&mut self) {
        self.position += self.rest(self.position).iter().take_while(|b| b.is_ascii_whitespace()).count();
    }

    fn ends(&self, what: &str) -> MeshError {
        self.error(self.bytes.len(), format!("the file ends where {what} should be"), DAMAGED)
    }

    /// The name of the next section without its `$`; none at the end of the file.
    pub fn next_section(&mut self) -> Result<Option<&'a str>, MeshError> {
        self.skip_blank();
        if self.rest(self.position).is_empty() {
            return Ok(None);
        }
        let start = self.position;
        let line = self.line("a section")?;
        match line.strip_prefix('$') {
            Some(name) if !name.is_empty() && !name.starts_with("End") => Ok(Some(name)),
            _ => Err(self.error(
                start,
                format!("expected the begin of a section such as $Nodes, found \"{}\"", excerpt(line)),
                DAMAGED,
            )),
        }
    }

    /// Takes the `$End…` of a section whose content has been read.
    pub fn end_section(&mut self, name: &str) -> Result<(), MeshError> {
        self.skip_blank();
        let start = self.position;
        let line = self.line(&format!("$End{name}"))?;
        if line.strip_prefix("$End") == Some(name) {
            return Ok(());
        }
        Err(self.error(
            start,
            format!("expected $End{name}, found \"{}\"", excerpt(line)),
            format!("the section ${name} holds more than its count says: save the mesh again in Gmsh"),
        ))
    }

    /// Moves behind the `$End…` of a section that is not needed.
    pub fn skip_section(&mut self, name: &str) -> Result<(), MeshError> {
        let start = self.position;
        let end = format!("$End{name}").into_bytes();
        let found = self.rest(start).windows(end.len()).position(|window| window == end);
        match found {
            Some(offset) => {
                self.position = start + offset + end.len();
                Ok(())
            }
            None => Err(self.error(start, format!("${name} has no $End{name}"), DAMAGED)),
        }
    }

    /// The rest of the line, trimmed; also in binary files, which mix text and numbers.
    pub fn line(&mut self, what: &str) -> Result<&'a str, MeshError> {
        let rest = self.rest(self.position);
        if rest.is_empty() {
            return Err(self.ends(what));
        }
        let length = rest.iter().position(|&b| b == b'\n').unwrap_or(rest.len());
        let start = self.position;
        self.position = (start + length + 1).min(self.bytes.len());
        match std::str::from_utf8(&rest[..length]) {
            Ok(line) => Ok(line.trim()),
            Err(_) => Err(self.error(
                start,
                format!("expected {what}, found bytes that are not UTF-8 text"),
                "give the physical groups names in UTF-8, or save the mesh again in Gmsh",
            )),
        }
    }

    /// A count on a line of its own, text in binary files too (format 2.2).
    pub fn text_count(&mut self, what: &str) -> Result<u64, MeshError> {
        let start = self.position;
        let line = self.line(what)?;
        line.parse().map_err(|_| self.unexpected(start, what, line))
    }

    /// Compares the number of things that the head of a section at `start` promises with the number found.
    pub fn total(&self, start: usize, what: &str, (promised, found): (u64, u64)) -> Result<(), MeshError> {
        if promised == found {
            return Ok(());
        }
        Err(self.error(
            start,
            format!("the section begins with {promised} {what} but holds {found}"),
            DAMAGED,
        ))
    }

    fn unexpected(&self, start: usize, what: &str, found: &str) -> MeshError {
        self.error(start, format!("expected {what}, found \"{}\"", excerpt(found)), DAMAGED)
    }

    fn word<T: std::str::FromStr>(&mut self, what: &str) -> Result<T, MeshError> {
        self.skip_blank();
        let start = self.position;
        let rest = self.rest(start);
        let length = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
        if length == 0 {
            return Err(self.ends(what));
        }
        self.position += length;
        let word = String::from_utf8_lossy(&rest[..length]);
        word.parse().map_err(|_| self.unexpected(start, what, &word))
    }

    /// The next `length` bytes of a binary section.
    pub fn bytes(&mut self, length: usize, what: &str) -> Result<&'a [u8], MeshError> {
        match self.rest(self.position).get(..length) {
            Some(bytes) => {
                self.position += length;
                Ok(bytes)
            }
            None => Err(self.ends(what)),
        }
    }

    fn array<const N: usize>(&mut self, big: bool, what: &str) -> Result<[u8; N], MeshError> {
        let mut array = [0; N];
        array.copy_from_slice(self.bytes(N, what)?);
        if big {
            array.reverse();
        }
        Ok(array)
    }

    /// A C `int`.
    pub fn int(&mut self, what: &str) -> Result<i64, MeshError> {
        match self.encoding {
            Encoding::Ascii => self.word(what),
            Encoding::Binary { big, .. } => Ok(i32::from_le_bytes(self.array(big, what)?).into()),
        }
    }

    /// A C `int` that cannot be negative: a count, or the number of a node.
    pub fn natural(&mut self, what: &str) -> Result<u64, MeshError> {
        let start = self.position;
        let value = self.int(what)?;
        u64::try_from(value).map_err(|_| self.unexpected(start, what, &value.to_string()))
    }

    /// A C `size_t`.
    pub fn size(&mut self, what: &str) -> Result<u64, MeshError> {
        match self.encoding {
            Encoding::Ascii => self.word(what),
            Encoding::Binary { big, wide: true } => Ok(u64::from_le_bytes(self.array(big, what)?)),
            Encoding::Binary { big, wide: false } => Ok(u32::from_le_bytes(self.array(big, what)?).into()),
        }
    }

    /// A C `double`.
    pub fn double(&mut self, what: &str) -> Result<f64, MeshError> {
        match self.encoding {
            Encoding::Ascii => self.word(what),
            Encoding::Binary { big, .. } => Ok(f64::from_le_bytes(self.array(big, what)?)),
        }
    }
}

/// The first characters of what was found, fit for a message.
fn excerpt(text: &str) -> String {
    let mut short: String =
        text.chars().take(40).map(|c| if c.is_control() { '\u{fffd}' } else { c }).collect();
    if text.chars().nth(40).is_some() {
        short.push('…');
    }
    short
}
