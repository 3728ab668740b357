//! `tegula`, the command line program.
//!
//! Exit codes: 0 done; 1 errors in the model or its files; 2 wrong command line; 3 the analysis failed; 4 a comparison
//! of `verify` missed its tolerance; 130 interrupted (the results up to the last finished step are complete,
//! `--resume` continues the run, except for a modal analysis).
#![deny(clippy::print_stdout, clippy::print_stderr)]

#[macro_use]
mod terminal;

mod check;
mod completions;
mod convert;
mod html_report;
mod info;
mod interrupt;
mod locking;
mod man;
mod new;
mod progress;
#[cfg(feature = "petsc")]
mod ranks;
#[cfg(not(feature = "petsc"))]
#[path = "one_rank.rs"]
mod ranks;
mod render;
mod report;
mod run;
mod schema;
mod threads;
mod verify;
mod watched;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

/// Flexible multibody dynamics with thin and moderately thick shells.
#[derive(Debug, Parser)]
#[command(name = "tegula", version, after_help = EXIT_CODES, arg_required_else_help = true)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

const EXIT_CODES: &str = "Exit codes:
  0    done
  1    errors in the model or its files
  2    wrong command line
  3    the analysis failed (not converged, singular)
  4    verify: a comparison missed its tolerance
  130  interrupted; results up to the last step are complete, --resume restarts from there (not modal)

Begin with:  tegula new transient flag.toml  &&  tegula run flag.toml";

#[derive(Debug, Subcommand)]
enum Command {
    /// Run a model and write its results into a folder
    Run(run::Arguments),
    /// Check a model without running it: all its errors at once, or a summary
    Check(check::Arguments),
    /// Write a commented model file to begin with
    New(new::Arguments),
    /// Write the model file that corresponds to an input file of Abaqus, CalculiX or Nastran, or results in the formats of other programs: VTKHDF, Parquet
    Convert(convert::Arguments),
    /// Write the report of a result folder, or of a model file: one HTML file with moving shapes, checks, curves and tables, or with the mesh, supports, loads and sets
    Report(html_report::Arguments),
    /// Draw a picture or a film of a result folder
    Render(render::Arguments),
    /// Print the JSON Schema of the model file, for editors
    Schema,
    /// Print version, threads and instruction set, or the summary of a model or result
    Info(info::Arguments),
    Verify(verify::Verify),
    Locking(locking::Locking),
    /// Print the script with which a shell completes commands and options
    Completions(completions::Arguments),
    /// Write the manual pages of the program and its commands into a folder
    Man(man::Arguments),
}

fn main() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => {
            // Help and version are no errors; nothing can be done if even printing fails.
            let _ = error.print();
            return ExitCode::from(if error.use_stderr() { 2 } else { 0 });
        }
    };
    let (outcome, as_json) = match cli.command {
        Command::Run(arguments) => (run::run(&arguments), arguments.json),
        Command::Check(arguments) => (check::run(&arguments), arguments.json),
        Command::New(arguments) => (new::run(&arguments), false),
        Command::Convert(arguments) => (convert::run(&arguments), false),
        Command::Report(arguments) => (html_report::run(&arguments), false),
        Command::Render(arguments) => (render::run(&arguments), false),
        Command::Schema => (schema::run(), false),
        Command::Info(arguments) => (info::run(&arguments), arguments.json),
        Command::Completions(arguments) => (completions::run(&arguments), false),
        Command::Man(arguments) => (man::run(&arguments), false),
        Command::Verify(verify) => return verify.run(),
        Command::Locking(locking) => return locking.run(),
    };
    if let Err(failure) = outcome {
        return failure.report(as_json);
    }
    // Whoever asked for text must know that it is not whole.
    match terminal::unwritten() {
        Some(reason) => {
            terminal::report("error", &format!("cannot write to standard output: {reason}"));
            ExitCode::from(1)
        }
        None => ExitCode::SUCCESS,
    }
}
