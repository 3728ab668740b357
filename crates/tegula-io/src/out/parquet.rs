//! Parquet files of tables of numbers, for data frames (pandas, Polars, R, DuckDB).
//!
//! Every column has numbers of 64 bits (`DOUBLE`, required), stored one after another (`PLAIN`), one page to a column and row
//! group, without compression. The description at the end of the file is in Thrift's compact protocol.
//!
//! See "Apache Parquet", <https://parquet.apache.org/docs/file-format/>, and `parquet.thrift` there.

use std::io::{self, Write};
use std::path::Path;

use super::file::{OutputError, write_whole};

/// First and last bytes of a file.
const MAGIC: [u8; 4] = *b"PAR1";
/// Rows of a row group; a page of that many numbers has 8 MiB.
const ROWS_OF_A_GROUP: usize = 1 << 20;

/// Writes a table of named columns of the same length, whole or not at all. The bits of all numbers are kept.
///
/// # Errors
/// There are no columns, their lengths differ, two have one name, or the file cannot be written.
pub fn write(path: &Path, columns: &[(String, Vec<f64>)]) -> Result<(), OutputError> {
    let rows = columns.first().map_or(0, |(_, first)| first.len());
    let mut names: Vec<&str> = columns.iter().map(|(name, _)| name.as_str()).collect();
    names.sort_unstable();
    let problem = if columns.is_empty() {
        Some("it would have no columns".to_owned())
    } else if let Some(pair) = names.windows(2).find(|pair| pair[0] == pair[1]) {
        Some(format!("two columns have the name `{}`", pair[0]))
    } else {
        let odd = columns.iter().find(|(_, values)| values.len() != rows);
        odd.map(|(name, values)| {
            format!("the column `{name}` has {} rows, the first one {rows}", values.len())
        })
    };
    match problem {
        Some(problem) => Err(OutputError::refused(path, problem)),
        None => write_whole(path, |file| write_to(file, columns, rows, ROWS_OF_A_GROUP)),
    }
}

/// A column of a row group in the file: place of its page, and bytes of the page with its head.
struct Written {
    offset: u64,
    size: u64,
}

fn write_to(
    file: &mut dyn Write,
    columns: &[(String, Vec<f64>)],
    rows: usize,
    rows_of_a_group: usize,
) -> io::Result<()> {
    file.write_all(&MAGIC)?;
    let mut end = MAGIC.len() as u64;
    let mut groups = Vec::new();
    for begin in (0..rows).step_by(rows_of_a_group) {
        let count = rows_of_a_group.min(rows - begin);
        let mut group = Vec::with_capacity(columns.len());
        for (_, values) in columns {
            let head = page_head(count);
            let page: Vec<u8> = values[begin..begin + count].iter().flat_map(|x| x.to_le_bytes()).collect();
            file.write_all(&head)?;
            file.write_all(&page)?;
            let size = (head.len() + page.len()) as u64;
            group.push(Written { offset: end, size });
            end += size;
        }
        groups.push((count, group));
    }
    let description = description(columns, rows, &groups);
    file.write_all(&description)?;
    file.write_all(&(description.len() as u32).to_le_bytes())?;
    file.write_all(&MAGIC)
}

/// Numbers of `parquet.thrift`.
const DOUBLE: i64 = 5;
const REQUIRED: i64 = 0;
const PLAIN: i64 = 0;
const RLE: i64 = 3;
const UNCOMPRESSED: i64 = 0;
const DATA_PAGE: i64 = 0;

/// `PageHeader` of a page of so many numbers.
fn page_head(count: usize) -> Vec<u8> {
    let size = 8 * count as i64;
    let mut thrift = Thrift::default();
    thrift.structure(|page| {
        page.i32(1, DATA_PAGE);
        page.i32(2, size);
        page.i32(3, size);
        // Required columns have no levels, but their encodings must be named.
        page.field(5, STRUCT).structure(|data| {
            for (number, value) in [(1, count as i64), (2, PLAIN), (3, RLE), (4, RLE)] {
                data.i32(number, value);
            }
        });
    });
    thrift.bytes
}

/// `FileMetaData`.
fn description(columns: &[(String, Vec<f64>)], rows: usize, groups: &[(usize, Vec<Written>)]) -> Vec<u8> {
    let mut thrift = Thrift::default();
    thrift.structure(|file| {
        file.i32(1, 1);
        file.field(2, LIST).list(STRUCT, columns.len() + 1);
        file.structure(|root| {
            root.text(4, "table");
            root.i32(5, columns.len() as i64);
        });
        for (name, _) in columns {
            file.structure(|column| {
                column.i32(1, DOUBLE);
                column.i32(3, REQUIRED);
                column.text(4, name);
            });
        }
        file.i64(3, rows as i64);
        file.field(4, LIST).list(STRUCT, groups.len());
        for (count, group) in groups {
            file.structure(|thrift| row_group(thrift, columns, *count, group));
        }
        file.text(6, concat!("tegula version ", env!("CARGO_PKG_VERSION")));
    });
    thrift.bytes
}

/// `RowGroup`.
fn row_group(thrift: &mut Thrift, columns: &[(String, Vec<f64>)], count: usize, group: &[Written]) {
    thrift.field(1, LIST).list(STRUCT, columns.len());
    for ((name, _), written) in columns.iter().zip(group) {
        thrift.structure(|chunk| {
            chunk.i64(2, 0);
            chunk.field(3, STRUCT).structure(|column| {
                column.i32(1, DOUBLE);
                column.field(2, LIST).list(I32, 1).zigzag(PLAIN);
                column.field(3, LIST).list(BINARY, 1).binary(name);
                column.i32(4, UNCOMPRESSED);
                column.i64(5, count as i64);
                column.i64(6, written.size as i64);
                column.i64(7, written.size as i64);
                column.i64(9, written.offset as i64);
            });
        });
    }
    thrift.i64(2, group.iter().map(|written| written.size as i64).sum());
    thrift.i64(3, count as i64);
}

/// Types of Thrift's compact protocol.
const I32: u8 = 5;
const I64: u8 = 6;
const BINARY: u8 = 8;
const LIST: u8 = 9;
const STRUCT: u8 = 12;

/// Bytes in Thrift's compact protocol.
#[derive(Default)]
struct Thrift {
    bytes: Vec<u8>,
    /// Number of the field before, in this structure.
    latest: u8,
}

impl Thrift {
    /// Fields of a structure, in ascending order of their numbers, and its end.
    fn structure(&mut self, fields: impl FnOnce(&mut Self)) {
        let outer = std::mem::take(&mut self.latest);
        fields(self);
        self.bytes.push(0);
        self.latest = outer;
    }

    /// Head of a field; its number is at most 15 above that of the field before.
    fn field(&mut self, number: u8, kind: u8) -> &mut Self {
        self.bytes.push((number - self.latest) << 4 | kind);
        self.latest = number;
        self
    }

    fn i32(&mut self, number: u8, value: i64) {
        self.field(number, I32).zigzag(value);
    }

    fn i64(&mut self, number: u8, value: i64) {
        self.field(number, I64).zigzag(value);
    }

    fn text(&mut self, number: u8, text: &str) {
        self.field(number, BINARY).binary(text);
    }

    /// Head of a list.
    fn list(&mut self, kind: u8, length: usize) -> &mut Self {
        if length < 15 {
            self.bytes.push((length as u8) << 4 | kind);
        } else {
            self.bytes.push(0xf0 | kind);
            self.varint(length as u64);
        }
        self
    }

    fn binary(&mut self, text: &str) {
        self.varint(text.len() as u64);
        self.bytes.extend(text.as_bytes());
    }

    /// Signed integer, with its sign in the lowest bit.
    fn zigzag(&mut self, value: i64) {
        self.varint((value << 1 ^ value >> 63) as u64);
    }

    /// Seven bits a byte, the lowest ones first; the highest bit says that another byte follows.
    fn varint(&mut self, mut value: u64) {
        while value >= 0x80 {
            self.bytes.push(value as u8 | 0x80);
            value >>= 7;
        }
        self.bytes.push(value as u8);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn integers_and_lists_are_those_of_the_compact_protocol() {
        let mut thrift = Thrift::default();
        thrift.structure(|s| {
            // Zigzag: -1 becomes 1, 300 becomes 600 = 0b100_1011000.
            s.i32(1, -1);
            s.i64(4, 300);
            s.field(5, LIST).list(I32, 2);
            s.field(6, LIST).list(I32, 16);
            s.text(7, "ä");
        });
        let expected = [0x15, 1, 0x36, 0xd8, 4, 0x19, 0x25, 0x19, 0xf5, 16, 0x18, 2, 0xc3, 0xa4, 0];
        assert_eq!(thrift.bytes, expected);
    }

    #[test]
    fn pages_hold_the_bits_of_the_columns() {
        let columns = [
            ("t".to_owned(), vec![0.0, 1.0, 2.0, 3.0, 4.0]),
            ("x".to_owned(), vec![-0.0, f64::NAN, f64::INFINITY, 5e-324, 1.0 / 3.0]),
        ];
        let mut file = Vec::new();
        write_to(&mut file, &columns, 5, 2).unwrap();
        assert!(file.starts_with(b"PAR1") && file.ends_with(b"PAR1"));
        let mut at = 4;
        for rows in [0..2, 2..4, 4..5] {
            for (_, values) in &columns {
                let count = rows.len() as u8;
                // A data page of 8 n bytes: n values, plain.
                let head = [0x15, 0, 0x15, 16 * count, 0x15, 16 * count, 0x2c, 0x15, 2 * count, 0x15, 0];
                assert_eq!(file[at..][..11], head);
                assert_eq!(file[at + 11..][..6], [0x15, 6, 0x15, 6, 0, 0]);
                let page: Vec<u8> = values[rows.clone()].iter().flat_map(|x| x.to_le_bytes()).collect();
                assert_eq!(file[at + 17..][..page.len()], page);
                at += 17 + page.len();
            }
        }
        let length = u32::from_le_bytes(*file[at..file.len() - 4].last_chunk().unwrap());
        assert_eq!(at + length as usize + 8, file.len());
    }

    #[test]
    fn tables_that_are_none_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.parquet");
        let refusal = |columns: &[(String, Vec<f64>)]| write(&path, columns).unwrap_err().to_string();
        assert!(refusal(&[]).contains("no columns"));
        let column = |name: &str, rows: usize| (name.to_owned(), vec![0.0; rows]);
        assert!(refusal(&[column("a", 1), column("b", 2)]).contains("the column `b` has 2 rows"));
        assert!(refusal(&[column("a", 1), column("b", 1), column("a", 1)]).contains("the name `a`"));
        assert!(!path.exists());
    }
}
