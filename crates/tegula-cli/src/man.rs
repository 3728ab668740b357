//! `tegula man`

use std::path::PathBuf;

use clap::{Args, CommandFactory as _};

use crate::report::Failure;

/// Arguments of `tegula man`.
#[derive(Debug, Args)]
pub struct Arguments {
    /// Folder for the pages, such as ~/.local/share/man/man1; made where it does not exist
    folder: PathBuf,
}

/// Writes the manual pages of the program and its commands.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let folder = &arguments.folder;
    let failed =
        |error| Failure::File(format!("the manual pages cannot be written to {}: {error}", folder.display()));
    std::fs::create_dir_all(folder).map_err(failed)?;
    clap_mangen::generate_to(crate::Cli::command(), folder).map_err(failed)?;
    say!("read them with: man {}", folder.join("tegula.1").display());
    Ok(())
}
