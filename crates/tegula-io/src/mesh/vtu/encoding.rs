//! Bytes of arrays: base64 or raw, in one piece or in compressed blocks.
//!
//! ```text
//! uncompressed: n bytes | data
//! compressed:   n blocks | size of a block | size of the last block, if it is shorter | compressed size of each block | blocks
//! ```
//!
//! In base64 the header of compressed arrays is encoded by itself, and writers differ for that of uncompressed ones. Padding ends a stream and another one
//! begins behind it, so that both are read alike.

use std::borrow::Cow;
use std::io::Read as _;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use flate2::read::ZlibDecoder;

/// Encoding of the arrays of a file.
#[derive(Debug, Clone, Copy)]
pub(super) struct Encoding {
    /// Big endian.
    pub big: bool,
    /// Bytes of the numbers in headers: 4 or 8.
    pub word: usize,
    /// Compressed by zlib.
    pub zlib: bool,
}

/// Encoded data, which may go on behind an array.
#[derive(Debug, Clone)]
pub(super) struct Stream<'a> {
    pub data: Cow<'a, [u8]>,
    pub base64: bool,
}

const SHORT: &str = "ends early";

impl Stream<'_> {
    /// Data from an offset on.
    pub fn behind(&self, offset: usize) -> Option<Stream<'_>> {
        Some(Stream { data: Cow::Borrowed(self.data.get(offset..)?), base64: self.base64 })
    }

    /// The first bytes, as many as `wanted`; a number in a file, which reserves no memory.
    fn start(&self, wanted: usize) -> Result<Cow<'_, [u8]>, String> {
        if !self.base64 {
            return self.data.get(..wanted).map(Cow::Borrowed).ok_or_else(|| SHORT.to_owned());
        }
        let (mut out, mut rest) = (Vec::new(), &self.data[..]);
        while out.len() < wanted {
            let most = (wanted - out.len()).div_ceil(3).saturating_mul(4).min(rest.len());
            let padding = rest[..most].iter().position(|&c| c == b'=');
            let (now, later) =
                rest.split_at_checked(padding.map_or(most, |at| (at / 4 + 1) * 4)).ok_or(SHORT)?;
            if now.is_empty() {
                return Err(SHORT.into());
            }
            STANDARD.decode_vec(now, &mut out).map_err(|_| "is not in base64")?;
            rest = later;
        }
        out.truncate(wanted);
        Ok(Cow::Owned(out))
    }
}

impl Encoding {
    /// Bytes of an array, which has `expected` of them.
    ///
    /// # Errors
    /// The data are damaged, or there are more or fewer: the reason, which continues the sentence *the array …*.
    pub fn bytes(&self, stream: &Stream<'_>, expected: usize) -> Result<Vec<u8>, String> {
        if expected == 0 {
            return Ok(Vec::new());
        }
        let bytes = if self.zlib { self.unpacked(stream, expected)? } else { self.plain(stream, expected)? };
        if bytes.len() != expected {
            return Err(format!("has {} bytes, and {expected} are expected", bytes.len()));
        }
        Ok(bytes)
    }

    fn plain(&self, stream: &Stream<'_>, expected: usize) -> Result<Vec<u8>, String> {
        let length = self.number(&stream.start(self.word)?, 0)?;
        if length != expected {
            return Err(format!("has {length} bytes by its header, and {expected} are expected"));
        }
        let whole = stream.start(length.checked_add(self.word).ok_or(SHORT)?)?;
        Ok(whole.get(self.word..).unwrap_or_default().to_vec())
    }

    fn unpacked(&self, stream: &Stream<'_>, expected: usize) -> Result<Vec<u8>, String> {
        let blocks = self.number(&stream.start(self.word)?, 0)?;
        let words = blocks.checked_add(3).filter(|&words| words <= stream.data.len()).ok_or(SHORT)?;
        let begin = words.checked_mul(self.word).ok_or(SHORT)?;
        let header = stream.start(begin)?;
        let sizes: Vec<usize> = (3..words).map(|k| self.number(&header, k)).collect::<Result<_, _>>()?;
        let end = sizes.iter().try_fold(begin, |sum, &size| sum.checked_add(size)).ok_or(SHORT)?;
        let whole = stream.start(end)?;
        let (mut bytes, mut rest) = (Vec::new(), whole.get(begin..).unwrap_or_default());
        for size in sizes {
            let block;
            (block, rest) = rest.split_at_checked(size).ok_or(SHORT)?;
            let most = (expected - bytes.len()) as u64 + 1;
            ZlibDecoder::new(block)
                .take(most)
                .read_to_end(&mut bytes)
                .map_err(|error| format!("cannot be decompressed: {error}"))?;
            if bytes.len() > expected {
                return Err(format!("has more than the {expected} bytes that are expected"));
            }
        }
        Ok(bytes)
    }

    /// A number of a header.
    fn number(&self, header: &[u8], place: usize) -> Result<usize, String> {
        let bytes = header.get(place * self.word..(place + 1) * self.word).ok_or(SHORT)?;
        let value = bytes.iter().enumerate().fold(0_u64, |sum, (i, &byte)| {
            let at = if self.big { self.word - 1 - i } else { i };
            sum | u64::from(byte) << (8 * at)
        });
        usize::try_from(value).map_err(|_| SHORT.to_owned())
    }
}
