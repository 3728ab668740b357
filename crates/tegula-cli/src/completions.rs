//! `tegula completions`

use clap::{Args, CommandFactory as _};
use clap_complete::Shell;

use crate::report::Failure;

/// Arguments of `tegula completions`.
#[derive(Debug, Args)]
pub struct Arguments {
    /// Shell
    shell: Shell,
}

/// Prints the script with which a shell completes commands and options.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let mut script = Vec::new();
    clap_complete::generate(arguments.shell, &mut crate::Cli::command(), "tegula", &mut script);
    say!("{}", String::from_utf8_lossy(&script).trim_end());
    Ok(())
}
