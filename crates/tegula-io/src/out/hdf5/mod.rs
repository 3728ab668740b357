//! Writer of HDF5 files: groups, attributes and arrays of numbers in compressed chunks.
//!
//! The subset that VTKHDF files need, in the format of HDF5 1.10: superblock of version 3, object headers of version 2,
//! groups whose links stand in their headers, contiguous arrays, and chunked ones with a fixed array of chunk addresses.
//! All metadata that have a checksum are followed by Jenkins' lookup3 hash of their bytes.
//!
//! Chunks are written as they come, and the objects that name them afterwards, children before parents. Only the
//! superblock, which names the root group, is written last and stands first.
//!
//! See "HDF5 File Format Specification Version 3.0", <https://support.hdfgroup.org/documentation/hdf5/latest/_f_m_t3.html>.

mod checksum;
mod message;
#[cfg(test)]
pub(super) mod reader;

use std::io::{self, Seek, SeekFrom, Write};

use flate2::Compression;
use flate2::write::ZlibEncoder;

use checksum::lookup3;
use message::{Message, header};

/// Address that names nothing.
const UNDEFINED: u64 = u64::MAX;
/// Bytes of the superblock.
const SUPERBLOCK: u64 = 48;
/// First bytes of a file.
const SIGNATURE: [u8; 8] = *b"\x89HDF\r\n\x1a\n";
/// Bytes of addresses and of lengths.
const ADDRESS_SIZE: u8 = 8;

/// Kind of the numbers of an array, little endian.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Number {
    /// IEEE number of 64 bits.
    F64,
    /// Signed integer of 64 bits.
    I64,
    /// Unsigned integer of 8 bits.
    U8,
}

impl Number {
    /// Bytes of one number.
    pub(super) fn size(self) -> usize {
        match self {
            Self::F64 | Self::I64 => 8,
            Self::U8 => 1,
        }
    }
}

/// Value of an attribute.
#[derive(Debug, Clone)]
pub(super) enum Attribute {
    /// One integer.
    Integer(i64),
    /// A list of integers.
    Integers(Vec<i64>),
    /// Text of fixed length in ASCII.
    Ascii(String),
    /// A list of texts in UTF-8, padded to the longest.
    Texts(Vec<String>),
}

/// Place of an object or of a chunk in the file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Address(u64);

/// A chunk that has been written.
#[derive(Debug, Clone, Copy)]
pub(super) struct Chunk {
    address: u64,
    size: u64,
}

/// Shape of an array and of its chunks, which follow each other along the first axis.
#[derive(Debug, Clone)]
pub(super) struct Shape {
    /// Kind of the numbers.
    pub number: Number,
    /// Number of rows in all.
    pub rows: usize,
    /// Rows in a chunk.
    pub rows_per_chunk: usize,
    /// Numbers in a row; `None` for an array with one axis.
    pub columns: Option<usize>,
}

impl Shape {
    /// Array with one axis, in one chunk.
    pub(super) fn list(number: Number, rows: usize) -> Self {
        Self { number, rows, rows_per_chunk: rows, columns: None }
    }

    fn axes(&self, rows: usize) -> Vec<u64> {
        std::iter::once(rows).chain(self.columns).map(|n| n as u64).collect()
    }

    /// Bytes of so many rows.
    fn bytes(&self, rows: usize) -> u64 {
        self.axes(rows).iter().product::<u64>() * self.number.size() as u64
    }
}

/// Compresses the bytes of a chunk of numbers of `size` bytes each: all first bytes, all second bytes, and so on (HDF5's
/// filter `shuffle`), then zlib.
pub(super) fn compressed(bytes: &[u8], size: usize) -> io::Result<Vec<u8>> {
    let shuffled: Vec<u8> = (0..size).flat_map(|i| bytes.iter().skip(i).step_by(size).copied()).collect();
    let mut encoder = ZlibEncoder::new(Vec::with_capacity(bytes.len() / 2), Compression::fast());
    encoder.write_all(&shuffled)?;
    encoder.finish()
}

/// A file that is being written.
#[derive(Debug)]
pub(super) struct Hdf5Writer<W> {
    file: W,
    end: u64,
}

impl<W: Write + Seek> Hdf5Writer<W> {
    /// Begins an empty file.
    pub(super) fn new(mut file: W) -> io::Result<Self> {
        file.write_all(&[0; SUPERBLOCK as usize])?;
        Ok(Self { file, end: SUPERBLOCK })
    }

    /// Writes a chunk that [`compressed`] has made.
    pub(super) fn chunk(&mut self, compressed: &[u8]) -> io::Result<Chunk> {
        Ok(Chunk { address: self.append(compressed)?, size: compressed.len() as u64 })
    }

    /// Writes an array whose bytes are given, without compression.
    pub(super) fn array(&mut self, shape: &Shape, bytes: &[u8]) -> io::Result<Address> {
        debug_assert_eq!(bytes.len() as u64, shape.bytes(shape.rows));
        let address = if bytes.is_empty() { UNDEFINED } else { self.append(bytes)? };
        let layout = Message::contiguous(address, bytes.len() as u64);
        self.object(&[
            Message::dataspace(&shape.axes(shape.rows)),
            Message::datatype(shape.number),
            Message::fill_value(),
            layout,
        ])
    }

    /// Writes the header of an array whose chunks stand in the file already.
    pub(super) fn chunked_array(
        &mut self,
        shape: &Shape,
        chunks: &[Chunk],
        attributes: &[(&str, Attribute)],
    ) -> io::Result<Address> {
        let size = shape.bytes(shape.rows_per_chunk);
        if size == 0 || chunks.is_empty() {
            return self.array(shape, &[]);
        }
        let index = self.fixed_array(chunks, size)?;
        let mut messages = vec![
            Message::dataspace(&shape.axes(shape.rows)),
            Message::datatype(shape.number),
            Message::fill_value(),
            Message::filters(shape.number.size()),
            Message::chunked(
                &shape.axes(shape.rows_per_chunk),
                shape.number.size(),
                page_bits(chunks.len()),
                index,
            ),
        ];
        messages.extend(attributes.iter().map(|(name, value)| Message::attribute(name, value)));
        self.object(&messages)
    }

    /// Writes a group of objects that stand in the file already.
    pub(super) fn group(
        &mut self,
        members: &[(&str, Address)],
        attributes: &[(&str, Attribute)],
    ) -> io::Result<Address> {
        let mut messages = vec![Message::link_info(), Message::group_info()];
        messages.extend(members.iter().map(|(name, object)| Message::link(name, object.0)));
        messages.extend(attributes.iter().map(|(name, value)| Message::attribute(name, value)));
        self.object(&messages)
    }

    /// Writes the superblock, which makes the file complete.
    pub(super) fn finish(&mut self, root: Address) -> io::Result<()> {
        let mut block = SIGNATURE.to_vec();
        // Version; no flags.
        block.extend([3, ADDRESS_SIZE, ADDRESS_SIZE, 0]);
        for address in [0, UNDEFINED, self.end, root.0] {
            block.extend(address.to_le_bytes());
        }
        block.extend(lookup3(&block).to_le_bytes());
        self.file.seek(SeekFrom::Start(0))?;
        self.file.write_all(&block)?;
        self.file.flush()
    }

    /// Index of chunks: a header, and a block of address, size and mask of omitted filters for each chunk.
    fn fixed_array(&mut self, chunks: &[Chunk], chunk_size: u64) -> io::Result<u64> {
        const CLIENT_FILTERED_CHUNKS: u8 = 1;
        // Bytes for the size of a compressed chunk, which may exceed that of the numbers by a little.
        let size_bytes = (1 + (chunk_size.ilog2() as usize + 8) / 8).min(8);
        let entry = ADDRESS_SIZE as usize + size_bytes + 4;
        let header_size = 4 + 4 + 8 + 8 + 4;
        let (at, count) = (self.end, chunks.len() as u64);
        let mut header = b"FAHD".to_vec();
        header.extend([0, CLIENT_FILTERED_CHUNKS, entry as u8, page_bits(chunks.len())]);
        header.extend(count.to_le_bytes());
        header.extend((at + header_size).to_le_bytes());
        header.extend(lookup3(&header).to_le_bytes());
        self.append(&header)?;
        let mut block = b"FADB".to_vec();
        block.extend([0, CLIENT_FILTERED_CHUNKS]);
        block.extend(at.to_le_bytes());
        for chunk in chunks {
            block.extend(chunk.address.to_le_bytes());
            block.extend(&chunk.size.to_le_bytes()[..size_bytes]);
            block.extend([0; 4]);
        }
        block.extend(lookup3(&block).to_le_bytes());
        self.append(&block)?;
        Ok(at)
    }

    fn object(&mut self, messages: &[Message]) -> io::Result<Address> {
        self.append(&header(messages)).map(Address)
    }

    /// Writes bytes at the end, and returns where they begin.
    fn append(&mut self, bytes: &[u8]) -> io::Result<u64> {
        let begin = self.end;
        self.file.write_all(bytes)?;
        self.end += bytes.len() as u64;
        Ok(begin)
    }
}

/// Logarithm of the entries in a page of a fixed array: one page for all, which the format stores without pages.
fn page_bits(entries: usize) -> u8 {
    entries.next_power_of_two().trailing_zeros().max(10) as u8
}
