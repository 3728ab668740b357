//! Results in the formats of other programs: all instants of a run in one VTKHDF file, tables as Parquet files.

// Tests may unwrap; the code they test may not.
#![cfg_attr(test, allow(clippy::unwrap_used))]

use std::path::{Path, PathBuf};

use crate::job::Summary;
use crate::out::{OutputError, PvdSeries, csv, parquet, vtkhdf};

/// Lists of field files in a result folder; the first one with files is written.
const LISTS: [&str; 5] = ["fields.pvd", "modes.pvd", "bodies.pvd", "mode_bodies.pvd", "critical_modes.pvd"];

/// Outcome of [`to_vtkhdf`].
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Exported {
    /// List of the field files.
    pub list: PathBuf,
    /// Number of instants, or of modes.
    pub instants: usize,
    /// Number of files that the list names and that are not there; they are left out.
    pub missing: usize,
    /// Other lists with files in the folder.
    pub others: Vec<PathBuf>,
}

/// Writes the field files of a result folder, or those of a list (`.pvd`), into one VTKHDF file. The fields of a folder are taken where
/// it has some, else its modes, else its bodies.
///
/// # Errors
/// `input` is neither, it lists no field files, these are damaged or differ in mesh or arrays, or the file cannot be written.
pub fn to_vtkhdf(input: &Path, output: &Path) -> Result<Exported, OutputError> {
    let lists: Vec<PathBuf> = match input.is_dir() {
        true => LISTS.map(|list| input.join(list)).into_iter().filter(|list| list.is_file()).collect(),
        false => vec![input.to_owned()],
    };
    let mut found = Vec::new();
    for list in lists {
        let named = instants_of(&list)?;
        let count = named.len();
        let instants: Vec<_> = named.into_iter().filter(|(_, file)| file.is_file()).collect();
        if !instants.is_empty() {
            found.push((list, count, instants));
        }
    }
    let others = found.iter().skip(1).map(|(list, ..)| list.clone()).collect();
    let Some((list, count, instants)) = found.into_iter().next() else {
        return Err(OutputError::damaged(input, "it has no field files", remedy(input)));
    };
    vtkhdf::write(output, &instants)?;
    Ok(Exported { list, instants: instants.len(), missing: count - instants.len(), others })
}

/// Remedy for a folder without field files: those of its analysis steps.
fn remedy(input: &Path) -> String {
    let steps: Vec<String> = Summary::read(input).map_or(Vec::new(), |summary| {
        summary.analyses.iter().map(|step| format!("`{}`", step.folder)).collect()
    });
    if steps.is_empty() {
        "Give the result folder of a run with field files, or one of its lists (.pvd)".to_owned()
    } else {
        format!("Give the folder of one of its steps: {}", steps.join(", "))
    }
}

/// Time values and files of a list, in ascending order.
fn instants_of(list: &Path) -> Result<Vec<(f64, PathBuf)>, OutputError> {
    let folder = list.parent().unwrap_or(Path::new(""));
    let series = PvdSeries::open(list)?;
    let mut instants: Vec<_> =
        series.entries().iter().map(|(time, file)| (*time, folder.join(file))).collect();
    instants.sort_by(|a, b| a.0.total_cmp(&b.0));
    Ok(instants)
}

/// Writes a table of results (`.csv`) as a Parquet file; returns the numbers of its columns and of its rows.
///
/// # Errors
/// `input` is no table of numbers with a row of names, or the file cannot be written.
pub fn to_parquet(input: &Path, output: &Path) -> Result<(usize, usize), OutputError> {
    if input.is_dir() {
        let problem = "it is a folder, and a Parquet file has one table";
        return Err(OutputError::damaged(input, problem, "Give a table in it, such as `history.csv`"));
    }
    let columns = csv::read_columns(input)?;
    parquet::write(output, &columns)?;
    Ok((columns.len(), columns.first().map_or(0, |(_, rows)| rows.len())))
}
