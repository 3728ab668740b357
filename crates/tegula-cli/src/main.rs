//! `tegula`, the command line program.
//!
//! Exit codes: 0 done; 1 wrong command line or files; 2 errors in the model; 3 the analysis failed; 4 a comparison
//! of `verify` missed its tolerance; 130 interrupted (the results up to the last finished step are complete,
//! `--resume` goes on, but for a modal analysis).

/// Like `println!`, but whoever reads may stop reading, as in `tegula schema | head`.
macro_rules! say {
    ($($text:tt)*) => {{
        use std::io::Write as _;
        let _ = writeln!(std::io::stdout(), $($text)*);
    }};
}

mod check;
mod info;
mod interrupt;
mod locking;
mod new;
mod progress;
mod report;
mod run;
mod schema;
mod verify;

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
  1    wrong command line or files
  2    errors in the model
  3    the analysis failed (not converged, singular)
  4    verify: a comparison missed its tolerance
  130  interrupted; results up to the last step are complete, --resume goes on (not modal)

Begin with:  tegula new transient flag.toml  &&  tegula run flag.toml";

#[derive(Debug, Subcommand)]
enum Command {
    /// Run a model and write its results into a folder
    Run(run::Arguments),
    /// Check a model without running it: all its errors at once, or a summary
    Check(check::Arguments),
    /// Write a commented model file to begin with
    New(new::Arguments),
    /// Print the JSON Schema of the model file, for editors
    Schema,
    /// Print version, threads and instruction set, or the summary of a model or result
    Info(info::Arguments),
    Verify(verify::Verify),
    Locking(locking::Locking),
}

fn main() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => {
            // Help and version are no errors; nothing can be done if even printing fails.
            let _ = error.print();
            return ExitCode::from(u8::from(error.use_stderr()));
        }
    };
    let outcome = match cli.command {
        Command::Run(arguments) => run::run(&arguments),
        Command::Check(arguments) => check::run(&arguments),
        Command::New(arguments) => new::run(&arguments),
        Command::Schema => schema::run(),
        Command::Info(arguments) => info::run(&arguments),
        Command::Verify(verify) => return verify.run(),
        Command::Locking(locking) => return locking.run(),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => failure.report(),
    }
}
