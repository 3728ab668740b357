//! Tables of reference numbers.

use std::collections::BTreeMap;

/// A row: column name to text.
pub struct Record(BTreeMap<String, String>);

impl Record {
    /// Text of a column; empty if there is none.
    pub fn text(&self, column: &str) -> &str {
        self.0.get(column).map_or("", String::as_str)
    }

    /// Number of a column; not a number if there is none, which no comparison passes.
    pub fn number(&self, column: &str) -> f64 {
        self.text(column).parse().unwrap_or(f64::NAN)
    }
}

/// Rows of a table: comment lines begin with `#`, the first other line names the columns.
pub fn records(text: &str) -> Vec<Record> {
    let mut lines = text.lines().filter(|l| !l.starts_with('#'));
    let columns: Vec<&str> = lines.next().unwrap_or_default().split(',').collect();
    lines
        .map(|line| {
            Record(columns.iter().map(|c| c.to_string()).zip(line.split(',').map(str::to_string)).collect())
        })
        .collect()
}
