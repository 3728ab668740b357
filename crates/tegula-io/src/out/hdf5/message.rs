//! Messages of object headers.

use super::checksum::lookup3;
use super::{Attribute, Number, UNDEFINED};

/// One message of an object header: its kind and its bytes.
#[derive(Debug)]
pub(super) struct Message {
    kind: u8,
    bytes: Vec<u8>,
}

/// Object header of version 2 with the messages in its only chunk.
pub(super) fn header(messages: &[Message]) -> Vec<u8> {
    const SIZE_OF_FOUR_BYTES: u8 = 2;
    let size: usize = messages.iter().map(|message| 4 + message.bytes.len()).sum();
    let mut bytes = b"OHDR".to_vec();
    bytes.extend([2, SIZE_OF_FOUR_BYTES]);
    bytes.extend((size as u32).to_le_bytes());
    for message in messages {
        bytes.push(message.kind);
        bytes.extend((message.bytes.len() as u16).to_le_bytes());
        bytes.push(0);
        bytes.extend(&message.bytes);
    }
    bytes.extend(lookup3(&bytes).to_le_bytes());
    bytes
}

impl Message {
    /// Lengths along the axes.
    pub(super) fn dataspace(axes: &[u64]) -> Self {
        Self { kind: 0x01, bytes: dataspace(axes) }
    }

    /// Kind of the numbers.
    pub(super) fn datatype(number: Number) -> Self {
        Self { kind: 0x03, bytes: datatype(number) }
    }

    /// Zero for what was not written; nothing here is.
    pub(super) fn fill_value() -> Self {
        Self { kind: 0x05, bytes: vec![3, 0x0a] }
    }

    /// Bytes of the array at one place.
    pub(super) fn contiguous(address: u64, size: u64) -> Self {
        let mut bytes = vec![3, 1];
        bytes.extend(address.to_le_bytes());
        bytes.extend(size.to_le_bytes());
        Self { kind: 0x08, bytes }
    }

    /// Chunks of the given lengths, with a fixed array as index.
    pub(super) fn chunked(axes: &[u64], size: usize, page_bits: u8, index: u64) -> Self {
        const FIXED_ARRAY: u8 = 3;
        let lengths = || axes.iter().copied().chain([size as u64]);
        // Readers insist on the fewest bytes that hold all lengths.
        let bytes_of_length = lengths().max().map_or(1, |longest| (longest.max(1).ilog2() as usize + 8) / 8);
        let mut bytes = vec![4, 2, 0, axes.len() as u8 + 1, bytes_of_length as u8];
        for length in lengths() {
            bytes.extend(&length.to_le_bytes()[..bytes_of_length]);
        }
        bytes.extend([FIXED_ARRAY, page_bits]);
        bytes.extend(index.to_le_bytes());
        Self { kind: 0x08, bytes }
    }

    /// Filters `shuffle` and `deflate`, in the order of writing.
    pub(super) fn filters(size: usize) -> Self {
        const SHUFFLE: u16 = 2;
        const DEFLATE: u16 = 1;
        /// Level of compression, which readers do not need.
        const LEVEL: u32 = 1;
        let mut bytes = vec![2, 2];
        for (filter, parameter) in [(SHUFFLE, size as u32), (DEFLATE, LEVEL)] {
            for word in [filter, 0, 1] {
                bytes.extend(word.to_le_bytes());
            }
            bytes.extend(parameter.to_le_bytes());
        }
        Self { kind: 0x0b, bytes }
    }

    /// Named value.
    pub(super) fn attribute(name: &str, value: &Attribute) -> Self {
        let (datatype, dataspace, data) = match value {
            Attribute::Integer(x) => (datatype(Number::I64), dataspace(&[]), x.to_le_bytes().to_vec()),
            Attribute::Integers(list) => {
                let data = list.iter().flat_map(|x| x.to_le_bytes()).collect();
                (datatype(Number::I64), dataspace(&[list.len() as u64]), data)
            }
            Attribute::Ascii(text) => {
                (text_type(text.len(), false), dataspace(&[]), text.as_bytes().to_vec())
            }
            Attribute::Texts(list) => {
                let length = list.iter().map(String::len).max().unwrap_or(0).max(1);
                let padded = |text: &String| {
                    let mut bytes = text.clone().into_bytes();
                    bytes.resize(length, 0);
                    bytes
                };
                let data = list.iter().flat_map(padded).collect();
                (text_type(length, true), dataspace(&[list.len() as u64]), data)
            }
        };
        let mut bytes = vec![3, 0];
        for length in [name.len() + 1, datatype.len(), dataspace.len()] {
            bytes.extend((length as u16).to_le_bytes());
        }
        bytes.push(CHARSET_UTF8);
        bytes.extend(name.as_bytes());
        bytes.push(0);
        for part in [datatype, dataspace, data] {
            bytes.extend(part);
        }
        Self { kind: 0x0c, bytes }
    }

    /// Links of a group stand in its header.
    pub(super) fn link_info() -> Self {
        let mut bytes = vec![0, 0];
        bytes.extend(UNDEFINED.to_le_bytes());
        bytes.extend(UNDEFINED.to_le_bytes());
        Self { kind: 0x02, bytes }
    }

    /// Nothing is said about the number of links.
    pub(super) fn group_info() -> Self {
        Self { kind: 0x0a, bytes: vec![0, 0] }
    }

    /// Member of a group.
    pub(super) fn link(name: &str, object: u64) -> Self {
        const LENGTH_OF_TWO_BYTES: u8 = 1;
        const HAS_CHARSET: u8 = 0x10;
        let mut bytes = vec![1, LENGTH_OF_TWO_BYTES | HAS_CHARSET, CHARSET_UTF8];
        bytes.extend((name.len() as u16).to_le_bytes());
        bytes.extend(name.as_bytes());
        bytes.extend(object.to_le_bytes());
        Self { kind: 0x06, bytes }
    }
}

const CHARSET_UTF8: u8 = 1;

fn dataspace(axes: &[u64]) -> Vec<u8> {
    let (scalar, simple) = (0, 1);
    let mut bytes = vec![2, axes.len() as u8, 0, if axes.is_empty() { scalar } else { simple }];
    bytes.extend(axes.iter().flat_map(|length| length.to_le_bytes()));
    bytes
}

fn datatype(number: Number) -> Vec<u8> {
    let size = number.size() as u32;
    let mut bytes = match number {
        // Implied first bit of the mantissa, sign at bit 63.
        Number::F64 => vec![0x11, 0x20, 63, 0],
        Number::I64 => vec![0x10, 0x08, 0, 0],
        Number::U8 => vec![0x10, 0x00, 0, 0],
    };
    bytes.extend(size.to_le_bytes());
    // First bit, and number of bits.
    bytes.extend(0_u16.to_le_bytes());
    bytes.extend((8 * size as u16).to_le_bytes());
    if number == Number::F64 {
        // Place and length of exponent and mantissa, and bias.
        bytes.extend([52, 11, 0, 52]);
        bytes.extend(1023_u32.to_le_bytes());
    }
    bytes
}

/// Text of fixed length, padded by zeros.
fn text_type(length: usize, utf8: bool) -> Vec<u8> {
    const PADDED_BY_ZEROS: u8 = 1;
    let mut bytes = vec![0x13, PADDED_BY_ZEROS | if utf8 { CHARSET_UTF8 << 4 } else { 0 }, 0, 0];
    bytes.extend((length as u32).to_le_bytes());
    bytes
}
