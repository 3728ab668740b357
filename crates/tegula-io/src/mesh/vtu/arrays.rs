//! Arrays of numbers of a file.

use std::borrow::Cow;

use roxmltree::Node;

use super::Fault;
use super::document::line;
use super::encoding::{Encoding, Stream};

/// Source of the arrays of a file.
pub(super) struct Source<'a> {
    pub encoding: Encoding,
    pub appended: Option<Stream<'a>>,
}

/// Numbers of an array.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Numbers {
    /// Numbers of an integer type.
    Whole(Vec<i64>),
    /// Numbers of a floating-point type.
    Real(Vec<f64>),
}

/// Type of numbers, by their bytes.
#[derive(Debug, Clone, Copy)]
enum Kind {
    Signed(usize),
    Unsigned(usize),
    Float(usize),
}

impl Kind {
    fn named(name: &str) -> Option<Self> {
        Some(match name {
            "Int8" => Self::Signed(1),
            "Int16" => Self::Signed(2),
            "Int32" => Self::Signed(4),
            "Int64" => Self::Signed(8),
            "UInt8" => Self::Unsigned(1),
            "UInt16" => Self::Unsigned(2),
            "UInt32" => Self::Unsigned(4),
            "UInt64" => Self::Unsigned(8),
            "Float32" => Self::Float(4),
            "Float64" => Self::Float(8),
            _ => return None,
        })
    }

    fn size(self) -> usize {
        let (Self::Signed(size) | Self::Unsigned(size) | Self::Float(size)) = self;
        size
    }
}

impl Source<'_> {
    /// Numbers of an array, `tuples` times its components.
    ///
    /// # Errors
    /// The array is damaged, or has more or fewer numbers.
    pub fn numbers(&self, array: Node<'_, '_>, tuples: usize) -> Result<Numbers, Fault> {
        let name = array.attribute("Name").unwrap_or("Points");
        let failed =
            |problem: String| Fault::damaged(format!("the array \"{name}\" {problem}")).at_line(line(array));
        let kind = array.attribute("type").unwrap_or_default();
        let kind = Kind::named(kind).ok_or_else(|| failed(format!("has numbers of the type \"{kind}\"")))?;
        let components = components(array);
        let count = tuples.checked_mul(components).ok_or_else(|| failed("is too long".into()))?;
        match array.attribute("format") {
            Some("ascii") => words(array.text().unwrap_or_default(), kind, count).map_err(failed),
            Some("binary") => {
                let text: Vec<u8> =
                    array.text().unwrap_or_default().bytes().filter(|c| !c.is_ascii_whitespace()).collect();
                self.decoded(&Stream { data: Cow::Owned(text), base64: true }, kind, count).map_err(failed)
            }
            Some("appended") => {
                let offset = array.attribute("offset").and_then(|offset| offset.trim().parse().ok());
                let offset: usize = offset.ok_or_else(|| failed("has no offset".into()))?;
                let stream = self.appended.as_ref().and_then(|appended| appended.behind(offset));
                let beyond = || failed(format!("begins at {offset}, beyond the appended data"));
                self.decoded(&stream.ok_or_else(beyond)?, kind, count).map_err(failed)
            }
            other => Err(failed(format!("has the format \"{}\"", other.unwrap_or_default()))),
        }
    }

    fn decoded(&self, stream: &Stream<'_>, kind: Kind, count: usize) -> Result<Numbers, String> {
        let size = kind.size();
        let expected = count.checked_mul(size).ok_or("is too long")?;
        let mut bytes = self.encoding.bytes(stream, expected)?;
        if self.encoding.big {
            bytes.chunks_exact_mut(size).for_each(<[u8]>::reverse);
        }
        Ok(match kind {
            Kind::Float(4) => {
                Numbers::Real(bytes.as_chunks().0.iter().map(|b| f64::from(f32::from_le_bytes(*b))).collect())
            }
            Kind::Float(_) => {
                Numbers::Real(bytes.as_chunks().0.iter().map(|b| f64::from_le_bytes(*b)).collect())
            }
            Kind::Signed(_) => {
                let signed = |b: &[u8]| {
                    let shift = 64 - 8 * size as u32;
                    (unsigned(b) << shift).cast_signed() >> shift
                };
                Numbers::Whole(bytes.chunks_exact(size).map(signed).collect())
            }
            Kind::Unsigned(_) => {
                let whole =
                    |b: &[u8]| i64::try_from(unsigned(b)).map_err(|_| "has a number above 2^63".to_owned());
                Numbers::Whole(bytes.chunks_exact(size).map(whole).collect::<Result<_, _>>()?)
            }
        })
    }
}

fn unsigned(little_endian: &[u8]) -> u64 {
    little_endian.iter().rev().fold(0, |sum, &byte| sum << 8 | u64::from(byte))
}

/// Numbers of a text.
fn words(text: &str, kind: Kind, count: usize) -> Result<Numbers, String> {
    fn all<T: std::str::FromStr>(text: &str, count: usize) -> Result<Vec<T>, String> {
        let mut out = Vec::new();
        for word in text.split_ascii_whitespace() {
            let shown: String = word.chars().take(40).collect();
            out.push(word.parse().map_err(|_| format!("has \"{shown}\" where a number is expected"))?);
        }
        if out.len() != count {
            return Err(format!("has {} numbers, and {count} are expected", out.len()));
        }
        Ok(out)
    }
    Ok(match kind {
        Kind::Float(_) => Numbers::Real(all(text, count)?),
        Kind::Signed(_) | Kind::Unsigned(_) => Numbers::Whole(all(text, count)?),
    })
}

/// Number of components of an array.
pub(super) fn components(array: Node<'_, '_>) -> usize {
    array.attribute("NumberOfComponents").and_then(|n| n.trim().parse().ok()).unwrap_or(1)
}

/// True for arrays of integers of one byte.
pub(super) fn is_byte(array: Node<'_, '_>) -> bool {
    matches!(array.attribute("type"), Some("Int8" | "UInt8"))
}

/// True for arrays of numbers; others, as of strings, are passed over.
pub(super) fn is_numeric(array: Node<'_, '_>) -> bool {
    array.attribute("type").and_then(Kind::named).is_some()
}

impl Numbers {
    pub fn len(&self) -> usize {
        match self {
            Self::Whole(list) => list.len(),
            Self::Real(list) => list.len(),
        }
    }

    /// Numbers as floating-point ones.
    pub fn reals(&self) -> Cow<'_, [f64]> {
        match self {
            Self::Whole(list) => Cow::Owned(list.iter().map(|&x| x as f64).collect()),
            Self::Real(list) => Cow::Borrowed(list),
        }
    }

    /// Numbers as integers; `None` if one is none.
    pub fn into_whole(self) -> Option<Vec<i64>> {
        match self {
            Self::Whole(list) => Some(list),
            // Some programs write connectivity as floating-point numbers.
            Self::Real(list) => {
                let whole = |x: f64| (x.fract() == 0.0 && x.abs() < 9e15).then_some(x as i64);
                list.into_iter().map(whole).collect()
            }
        }
    }

    /// Numbers of another piece behind these.
    pub fn append(&mut self, more: Self) {
        match (&mut *self, more) {
            (Self::Whole(list), Self::Whole(more)) => list.extend(more),
            (_, more) => {
                let both = [&self.reals()[..], &more.reals()[..]].concat();
                *self = Self::Real(both);
            }
        }
    }
}
