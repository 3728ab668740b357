//! STL files, ASCII and binary: closed surfaces of rigid bodies.
//!
//! A binary file has a header of 80 bytes, the number of triangles as a little-endian 32-bit integer, and 50 bytes for each triangle:
//! normal and three corners as 32-bit floats, and two bytes without meaning. Its length tells it from an ASCII file, since headers
//! of binary files may begin with `solid`, too. Stored normals are ignored: the order of the corners gives the orientation.
//!
//! Format: 3D Systems, *Stereolithography Interface Specification* (1988); M. Burns, *Automated Fabrication* (1993), section 6.5.

use std::path::Path;

use tegula::model::TriangulatedSurface;

use super::{At, MeshError, load};

/// Bytes before the first triangle of a binary file.
const HEADER: usize = 84;
/// Bytes of a triangle in a binary file.
const TRIANGLE: usize = 50;

/// Corners of a triangle.
type Corners = [[f64; 3]; 3];

/// Surface of the STL file at `path` in its own units, and the bytes of the file.
///
/// # Errors
/// The file cannot be read or is damaged, or its surface is not the boundary of a solid.
pub fn read(path: &Path) -> Result<(TriangulatedSurface, Vec<u8>), MeshError> {
    let bytes = load(path, ("STL file", ".stl"))?;
    Ok((parse(path, &bytes)?, bytes))
}

/// Surface of the bytes of an STL file; `path` only appears in errors.
///
/// # Errors
/// The bytes are damaged, or the surface is not the boundary of a solid.
pub fn parse(path: &Path, bytes: &[u8]) -> Result<TriangulatedSurface, MeshError> {
    let failed = |Fault { at, message, help }: Fault| MeshError {
        file: path.to_owned(),
        at,
        message,
        help: help.into_owned(),
    };
    let corners = triangles(bytes).map_err(failed)?;
    TriangulatedSurface::new(&corners).map_err(|defect| MeshError {
        file: path.to_owned(),
        at: At::File,
        message: defect.message,
        help: defect.help,
    })
}

/// Mistake in a file.
struct Fault {
    at: At,
    message: String,
    help: std::borrow::Cow<'static, str>,
}

fn fault(at: At, message: impl Into<String>, help: &'static str) -> Fault {
    Fault { at, message: message.into(), help: help.into() }
}

const DAMAGED: &str = "export or copy the file again: it is damaged or was not written to its end";

fn triangles(bytes: &[u8]) -> Result<Vec<Corners>, Fault> {
    let count = bytes.get(80..HEADER).and_then(|n| n.try_into().ok()).map(u32::from_le_bytes);
    let length = count.map(|n| HEADER as u64 + TRIANGLE as u64 * u64::from(n));
    let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes).trim_ascii_start();
    let is_text = !bytes.contains(&0);
    if length == Some(bytes.len() as u64) {
        return binary(&bytes[HEADER..]);
    }
    if is_text && text.get(..5).is_some_and(|word| word.eq_ignore_ascii_case(b"solid")) {
        return Scanner::new(bytes).triangles();
    }
    if bytes.is_empty() {
        return Err(fault(At::File, "the file is empty", "export the surface again"));
    }
    match count.filter(|_| !is_text) {
        Some(count) => {
            let whole = (bytes.len() - HEADER) / TRIANGLE;
            let rest = bytes.len() - HEADER - whole * TRIANGLE;
            Err(fault(
                At::Byte(bytes.len()),
                format!(
                    "the header of the binary file announces {count} triangles, but the file holds {whole} and {rest} bytes more"
                ),
                DAMAGED,
            ))
        }
        None => Err(fault(
            At::File,
            "this is no STL file: it does not begin with `solid`, and has no header of a binary file",
            "export the surface as STL",
        )),
    }
}

/// Triangles of a binary file behind its header.
fn binary(bytes: &[u8]) -> Result<Vec<Corners>, Fault> {
    let mut out = Vec::with_capacity(bytes.len() / TRIANGLE);
    for (i, triangle) in bytes.chunks_exact(TRIANGLE).enumerate() {
        let mut numbers = triangle[12..48].chunks_exact(4).map(|x| {
            let bytes = x.try_into().unwrap_or_default();
            f64::from(f32::from_le_bytes(bytes))
        });
        let mut corner = || std::array::from_fn(|_| numbers.next().unwrap_or(f64::NAN));
        let corners: Corners = [corner(), corner(), corner()];
        if !corners.iter().flatten().all(|x| x.is_finite()) {
            return Err(fault(
                At::Byte(HEADER + i * TRIANGLE),
                format!("triangle {} has a coordinate that is not a finite number", i + 1),
                "repair the surface in the program that made it, and export it again",
            ));
        }
        out.push(corners);
    }
    Ok(out)
}

/// Reader of the words of an ASCII file.
struct Scanner<'a> {
    words: Box<dyn Iterator<Item = (usize, &'a [u8])> + 'a>,
    /// Line of the last word, counted from 1.
    line: usize,
    out: Vec<Corners>,
}

impl<'a> Scanner<'a> {
    fn new(bytes: &'a [u8]) -> Self {
        let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
        let lines = (1..).zip(bytes.split(|byte| *byte == b'\n'));
        let words = lines.flat_map(|(line, text)| {
            let words = text.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
            // Names of solids reach to the end of their lines.
            let first = words.clone().next().unwrap_or_default();
            let named = is(first, "solid") || is(first, "endsolid");
            words.take(if named { 1 } else { usize::MAX }).map(move |word| (line, word))
        });
        Self { words: Box::new(words), line: 1, out: Vec::new() }
    }

    fn next(&mut self) -> Option<&'a [u8]> {
        let (line, word) = self.words.next()?;
        self.line = line;
        Some(word)
    }

    /// All triangles of all solids.
    fn triangles(mut self) -> Result<Vec<Corners>, Fault> {
        while let Some(word) = self.next() {
            if !is(word, "solid") {
                return Err(self.unexpected("solid", word));
            }
            loop {
                match self.next() {
                    Some(word) if is(word, "endsolid") => break,
                    Some(word) if is(word, "facet") => self.facet()?,
                    Some(word) => return Err(self.unexpected("facet` or `endsolid", word)),
                    None => return Err(self.ends_early()),
                }
            }
        }
        Ok(self.out)
    }

    /// Triangle behind the word `facet`.
    fn facet(&mut self) -> Result<(), Fault> {
        self.expect("normal")?;
        for _ in 0..3 {
            // Some programs write normals of degenerate triangles as `nan`.
            self.next().ok_or_else(|| self.ends_early())?;
        }
        self.expect("outer")?;
        self.expect("loop")?;
        let mut corners = [[0.0; 3]; 3];
        for corner in &mut corners {
            self.expect("vertex")?;
            for x in corner {
                *x = self.number()?;
            }
        }
        self.expect("endloop")?;
        self.expect("endfacet")?;
        self.out.push(corners);
        Ok(())
    }

    fn expect(&mut self, wanted: &str) -> Result<(), Fault> {
        match self.next() {
            Some(word) if is(word, wanted) => Ok(()),
            Some(word) => Err(self.unexpected(wanted, word)),
            None => Err(self.ends_early()),
        }
    }

    fn number(&mut self) -> Result<f64, Fault> {
        let Some(word) = self.next() else { return Err(self.ends_early()) };
        let number = std::str::from_utf8(word).ok().and_then(|word| word.parse::<f64>().ok());
        match number {
            Some(x) if x.is_finite() => Ok(x),
            _ => Err(fault(
                At::Line(self.line),
                format!("the coordinate `{}` is not a finite number", shown(word)),
                "repair the surface in the program that made it, and export it again",
            )),
        }
    }

    fn unexpected(&self, wanted: &str, found: &[u8]) -> Fault {
        let message = format!("`{wanted}` is expected here, but there is `{}`", shown(found));
        fault(
            At::Line(self.line),
            message,
            "facets are triangles with three vertices each: export the surface again",
        )
    }

    fn ends_early(&self) -> Fault {
        let message = format!("the file ends within a solid, behind {} whole triangles", self.out.len());
        fault(At::Line(self.line), message, DAMAGED)
    }
}

fn is(word: &[u8], wanted: &str) -> bool {
    word.eq_ignore_ascii_case(wanted.as_bytes())
}

/// Beginning of a word, for messages.
fn shown(word: &[u8]) -> String {
    String::from_utf8_lossy(word).chars().take(40).collect()
}

#[cfg(test)]
mod tests;
