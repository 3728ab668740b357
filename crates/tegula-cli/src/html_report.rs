//! `tegula report`

use std::path::{Path, PathBuf};

use clap::Args;
use tegula_io::report;

use crate::report::Failure;
use crate::terminal;

/// Arguments of `tegula report`.
#[derive(Debug, Args)]
pub struct Arguments {
    /// Result folder of a run
    result: PathBuf,
    /// File to write [default: report.html in the result folder]
    #[arg(short, long, value_name = "FILE")]
    out: Option<PathBuf>,
}

/// Writes a report.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let file = arguments.out.clone().unwrap_or_else(|| arguments.result.join("report.html"));
    write(&arguments.result, &file)?;
    say!("{}", file.display());
    Ok(())
}

/// Writes the report of a result folder, and says what it does not show.
pub fn write(folder: &Path, file: &Path) -> Result<(), Failure> {
    let notes = report::write(folder, file).map_err(|e| Failure::File(e.to_string()))?;
    notes.iter().for_each(|note| terminal::report("note", note));
    Ok(())
}
