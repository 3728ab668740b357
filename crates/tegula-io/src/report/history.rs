//! Curves of a report: tables of numbers in columns.

use std::path::Path;

use serde::Serialize;

use super::blocks::{Block, Blocks};
use crate::out::numbers::significant;
use crate::out::{OutputError, csv};

/// Largest number of rows in a report.
const MOST_ROWS: usize = 4000;

/// Table of numbers.
#[derive(Debug, Serialize)]
pub(super) struct Table {
    /// Names of the columns.
    pub names: Vec<String>,
    /// Number of rows.
    pub rows: usize,
    /// Number of rows in the file.
    pub available: usize,
    /// Columns, one behind the other, in double precision.
    pub block: Block,
}

/// Reads a table and every `n`-th row of it, so that there are at most 4000, and the last; `None` where there is no such file, or no row in it.
pub(super) fn read(path: &Path, blocks: &mut Blocks) -> Result<Option<Table>, OutputError> {
    if !path.is_file() {
        return Ok(None);
    }
    let (names, rows) = csv::read(path)?;
    let available = rows.len();
    let stride = available.div_ceil(MOST_ROWS).max(1);
    let shown: Vec<&Vec<f64>> = rows
        .iter()
        .enumerate()
        .filter(|(i, _)| i % stride == 0 || i + 1 == available)
        .map(|(_, row)| row)
        .collect();
    if shown.is_empty() {
        return Ok(None);
    }
    let columns = (0..names.len()).flat_map(|c| shown.iter().filter_map(move |row| row.get(c)));
    let block = blocks.doubles(columns);
    Ok(Some(Table { rows: shown.len(), names, available, block }))
}

/// Labels of the states of a path, whose values are the path parameter: their load factors.
pub(super) fn loads_at(path: &Path, values: &[f64]) -> Result<Vec<String>, OutputError> {
    let (names, rows) = csv::read(path)?;
    let Some(position) = names.iter().position(|name| name == "path.position") else { return Ok(Vec::new()) };
    let label = |value: &f64| {
        let distance = |row: &&Vec<f64>| (row[position] - value).abs();
        let nearest = rows.iter().min_by(|a, b| distance(a).total_cmp(&distance(b)));
        nearest.map_or_else(String::new, |row| format!("load factor {}", significant(row[0], 7)))
    };
    Ok(values.iter().map(label).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::out::HistoryWriter;

    #[test]
    fn long_tables_keep_their_first_and_last_rows() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.csv");
        let mut blocks = Blocks::default();
        assert!(read(&path, &mut blocks).unwrap().is_none());
        let mut table = HistoryWriter::create(&path, &["t", "u"]).unwrap();
        for i in 0..10_000 {
            table.append(&[f64::from(i), 0.5 * f64::from(i)]).unwrap();
        }
        table.flush().unwrap();
        let table = read(&path, &mut blocks).unwrap().unwrap();
        assert_eq!((table.available, table.rows), (10_000, 3334));
        let bytes = super::super::blocks::tests::decoded(&blocks, table.block);
        let numbers: Vec<f64> = bytes.chunks(8).map(|b| f64::from_le_bytes(b.try_into().unwrap())).collect();
        assert_eq!(numbers.len(), 2 * 3334);
        assert_eq!((numbers[0], numbers[1], numbers[3333], numbers[3334 + 3333]), (0.0, 3.0, 9999.0, 4999.5));
    }
}
