//! Numbers of a report as text: compressed blocks, and fields rounded to 16 bits.

use std::io::Write as _;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::write::ZlibEncoder;
use serde::Serialize;

/// Code of a value that is not finite.
const MISSING: u16 = u16::MAX;
/// Largest code of a value.
const LARGEST: f64 = (u16::MAX - 1) as f64;

/// Blocks of bytes, each compressed by zlib and encoded in base64.
#[derive(Debug, Default)]
pub(super) struct Blocks {
    texts: Vec<String>,
    /// Characters of all blocks.
    pub size: usize,
}

/// Number of a block in a report.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub(super) struct Block(usize);

/// Values at several instants, rounded to the 65 534 steps between the least and the greatest.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct Rounded {
    /// Least value.
    pub least: f64,
    /// Greatest value.
    pub greatest: f64,
    /// Codes of each instant as differences from those of the instant before, modulo 2¹⁶.
    pub block: Block,
}

impl Blocks {
    /// Characters of 100 bytes at most: base64 has four for three bytes.
    pub const CHARACTERS: usize = 134;

    /// Adds a block.
    pub fn add(&mut self, bytes: impl IntoIterator<Item = u8>) -> Block {
        let bytes: Vec<u8> = bytes.into_iter().collect();
        let mut encoder = ZlibEncoder::new(Vec::new(), Compression::default());
        // Memory takes all that is written.
        let compressed = encoder.write_all(&bytes).and_then(|()| encoder.finish()).unwrap_or_default();
        let text = STANDARD.encode(compressed);
        self.size += text.len();
        self.texts.push(text);
        Block(self.texts.len() - 1)
    }

    /// Adds numbers in double precision.
    pub fn doubles<'a>(&mut self, values: impl IntoIterator<Item = &'a f64>) -> Block {
        self.add(values.into_iter().flat_map(|x| x.to_le_bytes()))
    }

    /// Adds numbers in single precision.
    pub fn singles<'a>(&mut self, values: impl IntoIterator<Item = &'a f64>) -> Block {
        self.add(values.into_iter().flat_map(|&x| (x as f32).to_le_bytes()))
    }

    /// Adds indices.
    pub fn indices<'a>(&mut self, values: impl IntoIterator<Item = &'a u32>) -> Block {
        self.add(values.into_iter().flat_map(|i| i.to_le_bytes()))
    }

    /// Adds the values of a field, one list for each instant.
    pub fn rounded(&mut self, instants: &[Vec<f64>]) -> Rounded {
        let finite = || instants.iter().flatten().copied().filter(|x| x.is_finite());
        let least = finite().min_by(f64::total_cmp).unwrap_or(0.0);
        let greatest = finite().max_by(f64::total_cmp).unwrap_or(0.0);
        // The range itself may be beyond the largest number.
        let step = greatest / LARGEST - least / LARGEST;
        let code = |x: f64| match (x.is_finite(), step > 0.0) {
            (false, _) => MISSING,
            (true, false) => 0,
            (true, true) => (x / step - least / step).round() as u16,
        };
        let mut before: Vec<u16> = Vec::new();
        let mut bytes = Vec::new();
        for values in instants {
            before.resize(values.len(), 0);
            for (value, before) in values.iter().zip(&mut before) {
                let code = code(*value);
                bytes.extend(code.wrapping_sub(*before).to_le_bytes());
                *before = code;
            }
        }
        Rounded { least, greatest, block: self.add(bytes) }
    }

    /// The blocks in the order of their numbers.
    pub fn texts(&self) -> &[String] {
        &self.texts
    }
}

#[cfg(test)]
pub(super) mod tests {
    use std::io::Read as _;

    use super::*;

    /// Bytes of a block.
    pub fn decoded(blocks: &Blocks, block: Block) -> Vec<u8> {
        let mut bytes = Vec::new();
        let compressed = STANDARD.decode(&blocks.texts[block.0]).unwrap();
        flate2::read::ZlibDecoder::new(&compressed[..]).read_to_end(&mut bytes).unwrap();
        bytes
    }

    /// Values of a field at all instants, of `count` values each.
    pub fn values(blocks: &Blocks, field: &Rounded, count: usize) -> Vec<Vec<f64>> {
        let bytes = decoded(blocks, field.block);
        let mut sum = vec![0_u16; count];
        let instants = bytes.chunks(2 * count).map(|instant| {
            instant
                .chunks(2)
                .zip(&mut sum)
                .map(|(b, sum)| {
                    *sum = sum.wrapping_add(u16::from_le_bytes([b[0], b[1]]));
                    let part = f64::from(*sum) / LARGEST;
                    if *sum == MISSING {
                        f64::NAN
                    } else {
                        field.least * (1.0 - part) + field.greatest * part
                    }
                })
                .collect()
        });
        instants.collect()
    }

    #[test]
    fn fields_keep_five_digits_of_their_range_and_gaps() {
        let instants: Vec<Vec<f64>> =
            (0..7).map(|t| (0..50).map(|i| f64::from(i * t).sin() * 1e3 - 1e4).collect()).collect();
        let mut with_gap = instants.clone();
        with_gap[3][4] = f64::NAN;
        with_gap[5][4] = f64::INFINITY;
        let mut blocks = Blocks::default();
        let field = blocks.rounded(&with_gap);
        let found = values(&blocks, &field, 50);
        assert_eq!(found.len(), 7);
        for (t, (found, expected)) in found.iter().zip(&instants).enumerate() {
            for (i, (x, y)) in found.iter().zip(expected).enumerate() {
                if i == 4 && (t == 3 || t == 5) {
                    assert!(x.is_nan());
                } else {
                    assert!((x - y).abs() <= 2e3 / LARGEST, "{t} {i}: {x} for {y}");
                }
            }
        }
    }

    #[test]
    fn fields_beyond_single_precision_keep_their_digits() {
        for size in [1e-300, 1e-42, 1e42, 1.7e308] {
            let instant: Vec<f64> = (0..50).map(|i| size * f64::from(i).sin()).collect();
            let mut blocks = Blocks::default();
            let field = blocks.rounded(std::slice::from_ref(&instant));
            for (x, y) in values(&blocks, &field, 50)[0].iter().zip(&instant) {
                assert!((x / size - y / size).abs() <= 2.0 / LARGEST, "{x:e} for {y:e}");
            }
        }
    }

    #[test]
    fn constant_fields_are_exact() {
        let mut blocks = Blocks::default();
        let field = blocks.rounded(&[vec![2.5, 2.5], vec![2.5, 2.5]]);
        assert_eq!(values(&blocks, &field, 2), [[2.5, 2.5], [2.5, 2.5]]);
        let none = blocks.rounded(&[vec![f64::NAN]]);
        assert!(values(&blocks, &none, 1)[0][0].is_nan());
        assert_eq!(blocks.size, blocks.texts().iter().map(String::len).sum::<usize>());
    }
}
