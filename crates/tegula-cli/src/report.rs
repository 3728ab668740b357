//! Reports of failures as text or JSON, and their exit codes.

use std::path::PathBuf;
use std::process::ExitCode;

use serde_json::{Value, json};
use tegula_io::deck::Diagnostic;
use tegula_io::job::JobError;

use crate::terminal;

/// Why the program did not do what it was asked to do.
#[derive(Debug)]
pub enum Failure {
    /// The command line is wrong.
    Usage(String),
    /// A file or folder cannot be used.
    File(String),
    /// The model has errors, or its file cannot be read.
    Model(Vec<Diagnostic>),
    /// The analysis failed.
    Analysis(String),
    /// The user interrupted the run; the folder holds the results so far, and a checkpoint where the run can be resumed.
    Interrupted(PathBuf, bool),
}

impl From<JobError> for Failure {
    fn from(error: JobError) -> Self {
        match error {
            JobError::Model(diagnostics) => Self::Model(diagnostics),
            JobError::Interrupted { folder, resumable } => Self::Interrupted(folder, resumable),
            JobError::Analysis { error, folder } => Self::Analysis(format!(
                "{error}\n  The results up to the last finished step are in {}",
                folder.display()
            )),
            other => Self::File(other.to_string()),
        }
    }
}

impl Failure {
    fn code(&self) -> u8 {
        match self {
            Self::File(_) | Self::Model(_) => 1,
            Self::Usage(_) => 2,
            Self::Analysis(_) => 3,
            Self::Interrupted(..) => 130,
        }
    }

    /// Prints the failure, as JSON on standard output where that is wanted, and gives its exit code.
    pub fn report(self, as_json: bool) -> ExitCode {
        if as_json {
            say!("{:#}", self.json());
        } else {
            self.print();
        }
        ExitCode::from(self.code())
    }

    fn print(&self) {
        match self {
            Self::Usage(message) | Self::File(message) | Self::Analysis(message) => {
                terminal::report("error", message);
            }
            Self::Model(diagnostics) => {
                diagnostics.iter().for_each(|d| terminal::report("error", &shown(d)));
                let errors: usize = diagnostics.iter().map(|d| d.hidden.max(1)).sum();
                if errors > 1 {
                    tell!("{errors} errors");
                }
            }
            Self::Interrupted(..) => tell!("{}", self.message()),
        }
    }

    fn message(&self) -> String {
        match self {
            Self::Usage(message) | Self::File(message) | Self::Analysis(message) => message.clone(),
            Self::Model(diagnostics) => format!("the model has {} errors", diagnostics.len()),
            Self::Interrupted(folder, true) => format!(
                "interrupted: the results up to the last finished step are in {}; --resume restarts from there",
                folder.display()
            ),
            Self::Interrupted(..) => {
                "interrupted: a modal analysis is one solve, so there are no modes; start it anew".into()
            }
        }
    }

    fn json(&self) -> Value {
        let status = if matches!(self, Self::Interrupted(..)) { "interrupted" } else { "failed" };
        let mut out = json!({ "status": status, "exit_code": self.code() });
        match self {
            Self::Model(diagnostics) => out["errors"] = diagnostics.iter().map(as_json).collect(),
            _ => out["errors"] = json!([{ "message": self.message() }]),
        }
        out
    }
}

/// A diagnostic as JSON; `line` and `column` are 0 where it concerns the whole file.
pub fn as_json(d: &Diagnostic) -> Value {
    json!({
        "file": d.file.display().to_string(),
        "line": d.line,
        "column": d.column,
        "key": d.key,
        "message": d.message,
        "help": d.help,
    })
}

/// Longest line of a model file that is shown (characters); a longer one would hide the message.
const LONGEST_LINE: usize = 200;

/// Prints what is doubtful about a model that can be computed.
pub fn warn(diagnostic: &Diagnostic) {
    terminal::report("warning", &shown(diagnostic));
}

/// Message of a diagnostic with its place, its line and its remedy.
fn shown(d: &Diagnostic) -> String {
    let mut out = if d.key.is_empty() { d.message.clone() } else { format!("{}: {}", d.key, d.message) };
    let number = d.line.to_string();
    let margin = " ".repeat(number.len());
    if d.line == 0 {
        out.push_str(&format!("\n{margin}--> {}", d.file.display()));
    } else {
        out.push_str(&format!("\n{margin}--> {}:{}:{}", d.file.display(), d.line, d.column));
        out.push_str(&snippet(d, &number).unwrap_or_default());
    }
    if !d.help.is_empty() {
        out.push_str(&format!("\n{margin} = help: {}", d.help));
    }
    out
}

/// Source line of a diagnostic with marks below the part that it concerns; of a longer part only the first line.
fn snippet(d: &Diagnostic, number: &str) -> Option<String> {
    let begin = d.text.get(..d.span.start)?.rfind('\n').map_or(0, |i| i + 1);
    let line = d.text.get(begin..)?.lines().next()?;
    if line.chars().count() > LONGEST_LINE {
        return None;
    }
    // One character on the screen for each in the text, so that the marks stand below the right ones.
    let visible: String =
        line.chars().map(|c| if c.is_control() || c == '\u{feff}' { ' ' } else { c }).collect();
    let before = d.text.get(begin..d.span.start)?.chars().count();
    let meant = d.text.get(d.span.clone())?.lines().next().unwrap_or_default().chars().count().max(1);
    let margin = " ".repeat(number.len());
    Some(format!(
        "\n{margin} |\n{number} | {}\n{margin} | {}{}",
        visible.trim_end(),
        " ".repeat(before),
        "^".repeat(meant)
    ))
}
