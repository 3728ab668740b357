//! Histories: tables of numbers that grow by one row per step.
//!
//! Plain comma-separated text with a row of names. Numbers are printed with the fewest digits that read back
//! to the same bits, so a history is as good as the run that wrote it. A row is complete once its line feed is
//! there; what a stopped run left behind it is neither read nor continued.

use std::fs::{File, OpenOptions};
use std::io::{self, BufRead as _, BufReader, BufWriter, Seek as _, SeekFrom, Write as _};
use std::path::{Path, PathBuf};

use super::file::OutputError;

/// Appends rows to a history.
#[derive(Debug)]
pub struct HistoryWriter {
    path: PathBuf,
    names: Vec<String>,
    rows: u64,
    line: String,
    file: BufWriter<File>,
}

impl HistoryWriter {
    /// Starts a new history with the given column names, over an earlier file of that name.
    pub fn create(path: &Path, names: &[impl AsRef<str>]) -> Result<Self, OutputError> {
        let names: Vec<String> = names.iter().map(|n| n.as_ref().to_owned()).collect();
        if names.is_empty() {
            return Err(OutputError::refused(path, "a history needs at least one column"));
        }
        if let Some(name) = names.iter().find(|n| n.contains(['\n', '\r'])) {
            return Err(OutputError::refused(
                path,
                format!("the column name {name:?} has a line break in it"),
            ));
        }
        let header: Vec<String> = names.iter().map(|n| quoted(n)).collect();
        let file = File::create(path).map_err(|cause| OutputError::write(path, cause))?;
        let (path, line) = (path.to_path_buf(), String::new());
        let mut writer = Self { path, names, rows: 0, line, file: BufWriter::new(file) };
        writer.line = header.join(",");
        writer.put_line()?;
        writer.flush()?;
        Ok(writer)
    }

    /// Continues an earlier history after its first `keep_rows` rows; later rows are removed.
    pub fn resume(path: &Path, keep_rows: u64) -> Result<Self, OutputError> {
        if !path.exists() {
            let remedy = "Put it back, or run without `--resume` to start anew";
            return Err(OutputError::damaged(path, "it is no longer there", remedy));
        }
        let text = read_text(path)?;
        let mut end = 0;
        let mut lines = 0;
        for line in text.split_inclusive('\n').take_while(|line| line.ends_with('\n')) {
            if lines == keep_rows.saturating_add(1) {
                break;
            }
            end += line.len();
            lines += 1;
        }
        if lines == 0 {
            return Err(no_header(path));
        }
        if lines - 1 < keep_rows {
            return Err(OutputError::damaged(
                path,
                format!(
                    "it has {} complete rows, but the run to be resumed had written {keep_rows}",
                    lines - 1
                ),
                "Run without `--resume` to start anew",
            ));
        }
        let names = fields(text.lines().next().unwrap_or_default());
        let failed = |cause: io::Error| OutputError::write(path, cause);
        let mut file = OpenOptions::new().write(true).open(path).map_err(failed)?;
        file.set_len(end as u64).map_err(failed)?;
        file.seek(SeekFrom::End(0)).map_err(failed)?;
        let (path, line) = (path.to_path_buf(), String::new());
        Ok(Self { path, names, rows: keep_rows, line, file: BufWriter::new(file) })
    }

    /// Column names.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// Rows written so far, those of an earlier run included: argument of [`HistoryWriter::resume`].
    pub fn rows(&self) -> u64 {
        self.rows
    }

    /// Appends one row, one number per column. NaN and infinities are allowed.
    pub fn append(&mut self, row: &[f64]) -> Result<(), OutputError> {
        use std::fmt::Write as _;
        if row.len() != self.names.len() {
            let problem =
                format!("a row of {} numbers was given for {} columns", row.len(), self.names.len());
            return Err(OutputError::refused(&self.path, problem));
        }
        self.line.clear();
        for (i, value) in row.iter().enumerate() {
            let comma = if i == 0 { "" } else { "," };
            let _ = write!(self.line, "{comma}{value:?}");
        }
        self.put_line()?;
        self.rows += 1;
        Ok(())
    }

    /// Flushes appended rows to the operating system, so that other programs see them.
    pub fn flush(&mut self) -> Result<(), OutputError> {
        self.file.flush().map_err(|cause| OutputError::write(&self.path, cause))
    }

    /// Writes everything to the disk itself: to be called before a checkpoint that counts on these rows.
    pub fn sync(&mut self) -> Result<(), OutputError> {
        self.flush()?;
        self.file.get_ref().sync_data().map_err(|cause| OutputError::write(&self.path, cause))
    }

    fn put_line(&mut self) -> Result<(), OutputError> {
        self.line.push('\n');
        self.file.write_all(self.line.as_bytes()).map_err(|cause| OutputError::write(&self.path, cause))
    }
}

/// Reads a history: the names of its columns, and its rows.
///
/// An unfinished last row (without its line feed) is omitted: the run that writes it may not have ended.
pub fn read(path: &Path) -> Result<(Vec<String>, Vec<Vec<f64>>), OutputError> {
    let mut rows = Vec::new();
    let names = for_each_row(path, |row| rows.push(row.to_vec()))?;
    Ok((names, rows))
}

/// Columns of a history with their names; an unfinished last row is omitted, as by [`read`].
pub fn read_columns(path: &Path) -> Result<Vec<(String, Vec<f64>)>, OutputError> {
    let mut columns: Vec<Vec<f64>> = Vec::new();
    let names = for_each_row(path, |row| {
        columns.resize_with(row.len(), Vec::new);
        columns.iter_mut().zip(row).for_each(|(column, x)| column.push(*x));
    })?;
    columns.resize_with(names.len(), Vec::new);
    Ok(names.into_iter().zip(columns).collect())
}

/// Hands the rows of a history to `take`, one after another; returns the names of its columns.
fn for_each_row(path: &Path, mut take: impl FnMut(&[f64])) -> Result<Vec<String>, OutputError> {
    let failed = |cause: io::Error| OutputError::read(path, cause);
    let mut file = BufReader::new(File::open(path).map_err(failed)?);
    let mut text = String::new();
    // A line without its line feed is not finished.
    let mut next = |text: &mut String| {
        text.clear();
        file.read_line(text).map_err(failed)?;
        Ok(text.pop() == Some('\n'))
    };
    if !next(&mut text)? {
        return Err(no_header(path));
    }
    let names = fields(text.trim_end_matches('\r'));
    let (mut row, mut number) = (Vec::with_capacity(names.len()), 1);
    while next(&mut text)? {
        number += 1;
        let line = text.trim_end_matches('\r');
        if line.trim().is_empty() {
            continue;
        }
        let damaged = |problem: String| {
            let remedy = "Correct that line, or remove it";
            OutputError::damaged(path, format!("line {number} {problem}"), remedy)
        };
        row.clear();
        for (column, field) in line.split(',').enumerate() {
            let value = field.trim().parse::<f64>();
            let column = names.get(column).map_or("one too many", |name| name.as_str());
            row.push(value.map_err(|_| damaged(format!("has `{field}` for a number in column `{column}`")))?);
        }
        if row.len() != names.len() {
            return Err(damaged(format!("has {} numbers, but there are {} columns", row.len(), names.len())));
        }
        take(&row);
    }
    Ok(names)
}

fn read_text(path: &Path) -> Result<String, OutputError> {
    std::fs::read_to_string(path).map_err(|cause| OutputError::read(path, cause))
}

fn no_header(path: &Path) -> OutputError {
    let remedy = "Restore the file from a copy, or run without `--resume` to start anew";
    OutputError::damaged(path, "it has no complete row of column names", remedy)
}

/// Name as written to the file, quoted where necessary.
fn quoted(name: &str) -> String {
    if name.is_empty() || name.contains([',', '"']) || name.trim() != name {
        format!("\"{}\"", name.replace('"', "\"\""))
    } else {
        name.to_owned()
    }
}

/// The names in a header line.
fn fields(line: &str) -> Vec<String> {
    let mut names = Vec::new();
    let (mut name, mut in_quotes) = (String::new(), false);
    let mut chars = line.chars().peekable();
    while let Some(c) = chars.next() {
        match c {
            '"' if in_quotes && chars.peek() == Some(&'"') => {
                chars.next();
                name.push('"');
            }
            '"' => in_quotes = !in_quotes,
            ',' if !in_quotes => names.push(std::mem::take(&mut name)),
            c => name.push(c),
        }
    }
    names.push(name);
    names
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::fs;

    #[test]
    fn names_and_odd_numbers_survive() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("h.csv");
        let names = ["time [s]", "a, b", "say \"x\"", " edge "];
        let mut writer = HistoryWriter::create(&path, &names).unwrap();
        let rows = [[0.1 + 0.2, f64::MIN_POSITIVE / 8.0, -0.0, 1e300], [f64::INFINITY, 1e22, 123.0, -7e-9]];
        for row in &rows {
            writer.append(row).unwrap();
        }
        writer.append(&[f64::NAN; 4]).unwrap();
        assert!(writer.append(&[1.0]).unwrap_err().to_string().contains("1 numbers was given for 4 columns"));
        writer.sync().unwrap();
        let (read_names, read_rows) = read(&path).unwrap();
        assert_eq!(read_names, names);
        for (row, read) in rows.iter().zip(&read_rows) {
            assert!(row.iter().zip(read).all(|(a, b)| a.to_bits() == b.to_bits()), "{row:?} {read:?}");
        }
        assert!(read_rows.len() == 3 && read_rows[2].iter().all(|x| x.is_nan()));
        let columns = read_columns(&path).unwrap();
        assert!(columns.iter().map(|(name, _)| name).eq(&names));
        for (i, (_, column)) in columns.iter().enumerate() {
            assert!(column.iter().zip(&read_rows).all(|(x, row)| x.to_bits() == row[i].to_bits()));
            assert_eq!(column.len(), 3);
        }
        HistoryWriter::create(&path, &names).unwrap();
        assert!(read_columns(&path).unwrap().iter().all(|(_, column)| column.is_empty()));
        fs::write(&path, "time,x").unwrap();
        assert!(read_columns(&path).unwrap_err().to_string().contains("no complete row of column names"));
    }

    proptest! {
        #[test]
        fn every_finite_number_reads_back_to_its_bits(bits in any::<u64>()) {
            let value = f64::from_bits(bits);
            prop_assume!(value.is_finite());
            prop_assert_eq!(format!("{value:?}").parse::<f64>().unwrap().to_bits(), bits);
        }
    }

    #[test]
    fn resuming_cuts_back_and_goes_on() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("h.csv");
        let mut writer = HistoryWriter::create(&path, &["t", "x"]).unwrap();
        for i in 0..10 {
            writer.append(&[f64::from(i), 1.0]).unwrap();
        }
        writer.flush().unwrap();
        // The run was killed within a row.
        let mut text = fs::read_to_string(&path).unwrap();
        text.push_str("10.0,0.");
        fs::write(&path, &text).unwrap();
        assert_eq!(read(&path).unwrap().1.len(), 10);

        let message = HistoryWriter::resume(&path, 11).unwrap_err().to_string();
        assert!(message.contains("10 complete rows"), "{message}");
        assert_eq!(fs::read_to_string(&path).unwrap(), text, "a refused resume changes nothing");

        let mut writer = HistoryWriter::resume(&path, 10).unwrap();
        assert_eq!(writer.names(), ["t", "x"]);
        writer.append(&[10.0, 2.0]).unwrap();
        drop(writer);
        let mut writer = HistoryWriter::resume(&path, 4).unwrap();
        writer.append(&[4.5, 3.0]).unwrap();
        assert_eq!(writer.rows(), 5);
        writer.flush().unwrap();
        let times: Vec<f64> = read(&path).unwrap().1.iter().map(|row| row[0]).collect();
        assert_eq!(times, [0.0, 1.0, 2.0, 3.0, 4.5]);
        HistoryWriter::resume(&path, 0).unwrap();
        assert!(read(&path).unwrap().1.is_empty());
    }

    #[test]
    fn damage_is_named_by_line_and_column() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("h.csv");
        let problem = |text: &str| {
            fs::write(&path, text).unwrap();
            read(&path).unwrap_err().to_string()
        };
        let message = problem("t,x\n1,2\n3,abc\n");
        assert!(
            message.contains("line 3") && message.contains("`abc`") && message.contains("`x`"),
            "{message}"
        );
        assert!(problem("t,x\n1,2\n3\n").contains("has 1 numbers"));
        assert!(problem("t,x\n1,2,3\n").contains("has 3 numbers"));
        assert!(problem("t,x").contains("column names"));
        assert!(HistoryWriter::resume(&path, 0).is_err());
        let none: [&str; 0] = [];
        assert!(HistoryWriter::create(&path, &none).is_err());
        assert!(HistoryWriter::create(&path, &["a\nb"]).is_err());
    }
}
