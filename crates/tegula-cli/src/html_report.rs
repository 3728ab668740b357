//! `tegula report`

use std::path::{Path, PathBuf};

use clap::Args;
use tegula_io::deck::{Deck, STANDARD_INPUT};
use tegula_io::report;

use crate::report::Failure;
use crate::{run, terminal};

/// Arguments of `tegula report`.
#[derive(Debug, Args)]
pub struct Arguments {
    /// Result folder of a run; or a model file, which is shown with its mesh, supports, loads and sets
    #[arg(value_name = "RESULT or MODEL")]
    result: PathBuf,
    /// File to write [default: report.html in the result folder; of a model file its name with the ending .html, in the present folder]
    #[arg(short, long, value_name = "FILE")]
    out: Option<PathBuf>,
}

/// Writes a report.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let of_model = arguments.result.is_file() || arguments.result == Path::new(STANDARD_INPUT);
    let file = if of_model {
        let deck = Deck::read(&arguments.result).map_err(Failure::Model)?;
        let own = || format!("{}.html", run::name_of(&deck.path).display()).into();
        let file = arguments.out.clone().unwrap_or_else(own);
        tell_notes(&report::write_model(&deck, &file)?);
        file
    } else {
        let file = arguments.out.clone().unwrap_or_else(|| arguments.result.join("report.html"));
        write(&arguments.result, &file)?;
        file
    };
    // What is written to the standard output is the report alone.
    if !file.starts_with("/dev") {
        say!("{}", file.display());
    }
    Ok(())
}

/// Writes the report of a result folder, and says what it does not show.
pub fn write(folder: &Path, file: &Path) -> Result<(), Failure> {
    tell_notes(&report::write(folder, file).map_err(|e| Failure::File(e.to_string()))?);
    Ok(())
}

fn tell_notes(notes: &[String]) {
    notes.iter().for_each(|note| terminal::report("note", note));
}
