//! Reader for tests: follows the file from its superblock, and checks every checksum on its way.

use std::collections::BTreeMap;
use std::io::Read as _;

use super::{Number, SIGNATURE, UNDEFINED, lookup3};

/// A file in memory.
pub(in super::super) struct Hdf5File<'a>(pub &'a [u8]);

/// An array with the lengths of its axes.
pub(in super::super) struct Array {
    /// Lengths of the axes.
    pub axes: Vec<u64>,
    /// Number of chunks; none for a contiguous array.
    pub chunks: Option<usize>,
    bytes: Vec<u8>,
}

impl Array {
    /// Values of an array of numbers of 64 bits.
    pub(in super::super) fn floats(&self) -> Vec<f64> {
        self.bytes.as_chunks::<8>().0.iter().map(|b| f64::from_le_bytes(*b)).collect()
    }

    /// Values of an array of integers of 64 bits.
    pub(in super::super) fn integers(&self) -> Vec<i64> {
        self.bytes.as_chunks::<8>().0.iter().map(|b| i64::from_le_bytes(*b)).collect()
    }
}

impl Hdf5File<'_> {
    /// Little endian number of so many bytes.
    fn number(&self, at: u64, bytes: usize) -> u64 {
        number(&self.0[at as usize..][..bytes])
    }

    /// Asserts that the bytes are followed by their checksum.
    fn check(&self, begin: u64, end: u64) {
        let sum = lookup3(&self.0[begin as usize..end as usize]);
        assert_eq!(self.number(end, 4), u64::from(sum));
    }

    /// Address of an object by its path.
    pub(in super::super) fn find(&self, path: &str) -> u64 {
        assert_eq!((&self.0[..8], self.0[8]), (&SIGNATURE[..], 3));
        self.check(0, 44);
        assert_eq!(self.number(28, 8), self.0.len() as u64);
        path.split('/').fold(self.number(36, 8), |group, name| self.members(group)[name])
    }

    /// Members of a group.
    pub(in super::super) fn members(&self, group: u64) -> BTreeMap<String, u64> {
        let links = self.messages(group).into_iter().filter(|(kind, _)| *kind == 6);
        links
            .map(|(_, link)| {
                let (name, object) = link[5..].split_at(link.len() - 13);
                (String::from_utf8(name.to_vec()).unwrap(), number(object))
            })
            .collect()
    }

    /// Value of an attribute.
    pub(in super::super) fn attribute(&self, object: u64, name: &str) -> Vec<u8> {
        let named = |(kind, bytes): &(u8, &[u8])| *kind == 12 && bytes[9..].starts_with(name.as_bytes());
        let (_, bytes) = self.messages(object).into_iter().find(named).unwrap();
        let before: u64 = [2, 4, 6].map(|at| number(&bytes[at..at + 2])).iter().sum();
        bytes[9 + before as usize..].to_vec()
    }

    fn messages(&self, object: u64) -> Vec<(u8, &[u8])> {
        assert_eq!(&self.0[object as usize..][..6], b"OHDR\x02\x02");
        let end = object + 10 + self.number(object + 6, 4);
        self.check(object, end);
        let (mut at, mut messages) = (object + 10, Vec::new());
        while at < end {
            let (kind, size) = (self.0[at as usize], self.number(at + 1, 2));
            messages.push((kind, &self.0[at as usize + 4..][..size as usize]));
            at += 4 + size;
        }
        messages
    }

    /// Values of an array.
    pub(in super::super) fn array(&self, path: &str) -> Array {
        let messages: BTreeMap<u8, &[u8]> = self.messages(self.find(path)).into_iter().collect();
        let (space, kind, layout) = (messages[&1], messages[&3], messages[&8]);
        let axes: Vec<u64> = space[4..].chunks(8).map(number).collect();
        let size = number(&kind[4..8]) as usize;
        let all = axes.iter().product::<u64>() as usize * size;
        if layout[..2] == [3, 1] {
            assert_eq!(number(&layout[10..]), all as u64);
            let at = number(&layout[2..10]);
            let bytes = if at == UNDEFINED { Vec::new() } else { self.0[at as usize..][..all].to_vec() };
            return Array { axes, chunks: None, bytes };
        }
        let (rank, width) = (layout[3] as usize, layout[4] as usize);
        let lengths: Vec<u64> = layout[5..][..rank * width].chunks(width).map(number).collect();
        assert!(layout[..3] == [4, 2, 0] && rank == axes.len() + 1 && lengths[rank - 1] == size as u64);
        assert!(size == 1 || size == Number::F64.size());
        let chunk_size = lengths.iter().product::<u64>();
        let index = number(&layout[rank * width + 7..]);
        let chunks = self.chunks(index, chunk_size);
        let mut bytes = Vec::new();
        for chunk in &chunks {
            let mut shuffled = Vec::new();
            flate2::read::ZlibDecoder::new(*chunk).read_to_end(&mut shuffled).unwrap();
            assert_eq!(shuffled.len() as u64, chunk_size);
            let count = shuffled.len() / size;
            bytes.extend((0..shuffled.len()).map(|i| shuffled[i % size * count + i / size]));
        }
        assert_eq!(bytes.len(), all);
        Array { axes, chunks: Some(chunks.len()), bytes }
    }

    fn chunks(&self, index: u64, chunk_size: u64) -> Vec<&[u8]> {
        let bytes_of_size = (1 + (chunk_size.ilog2() as usize + 8) / 8).min(8);
        assert_eq!(&self.0[index as usize..][..6], b"FAHD\x00\x01");
        self.check(index, index + 24);
        let entry = self.number(index + 6, 1);
        assert_eq!(entry, 12 + bytes_of_size as u64);
        let (count, block) = (self.number(index + 8, 8), self.number(index + 16, 8));
        assert!(count <= 1 << self.number(index + 7, 1), "one page");
        assert_eq!(&self.0[block as usize..][..6], b"FADB\x00\x01");
        assert_eq!(self.number(block + 6, 8), index);
        self.check(block, block + 14 + count * entry);
        let chunk = |i: u64| {
            let at = block + 14 + i * entry;
            let (begin, size) = (self.number(at, 8), self.number(at + 8, bytes_of_size));
            &self.0[begin as usize..][..size as usize]
        };
        (0..count).map(chunk).collect()
    }
}

/// Little endian number.
fn number(bytes: &[u8]) -> u64 {
    bytes.iter().rev().fold(0, |sum, byte| sum << 8 | u64::from(*byte))
}
