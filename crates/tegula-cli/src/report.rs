//! What went wrong, for people, and the exit code that says so to programs.

use std::path::PathBuf;
use std::process::ExitCode;

use miette::{GraphicalReportHandler, LabeledSpan, NamedSource, SourceCode};
use tegula_io::deck::Diagnostic;
use tegula_io::job::JobError;

/// Why the program did not do what it was asked to do.
#[derive(Debug)]
pub enum Failure {
    /// The command line or a file is wrong.
    Usage(String),
    /// The model has errors.
    Model(Vec<Diagnostic>),
    /// The analysis failed.
    Analysis(String),
    /// The user stopped it; the folder holds the results so far, from which it can go on or not.
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
            other => Self::Usage(other.to_string()),
        }
    }
}

impl Failure {
    /// Prints it and gives its exit code.
    pub fn report(self) -> ExitCode {
        match self {
            Self::Usage(message) => {
                eprintln!("error: {message}");
                ExitCode::from(1)
            }
            Self::Model(diagnostics) => {
                // A model file that cannot even be read is a wrong file, not a wrong model.
                let code =
                    if diagnostics.iter().all(|d| d.line == 0) && !readable(&diagnostics) { 1 } else { 2 };
                show(&diagnostics);
                ExitCode::from(code)
            }
            Self::Analysis(message) => {
                eprintln!("error: {message}");
                ExitCode::from(3)
            }
            Self::Interrupted(folder, resumable) => {
                if resumable {
                    eprintln!(
                        "interrupted: the results up to the last finished step are in {}; --resume goes on from there",
                        folder.display()
                    );
                } else {
                    eprintln!(
                        "interrupted: a modal analysis is one solve, so there are no modes; start it anew"
                    );
                }
                ExitCode::from(130)
            }
        }
    }
}

fn readable(diagnostics: &[Diagnostic]) -> bool {
    diagnostics.iter().all(|d| std::fs::read(&d.file).is_ok())
}

/// Longest line of a model file that is shown (characters).
const LONGEST_LINE: usize = 200;

/// Prints what is doubtful about a model that can be computed.
pub fn warn(message: &str) {
    eprintln!("warning: {message}");
}

/// Prints diagnostics with the lines they speak of.
fn show(diagnostics: &[Diagnostic]) {
    let handler = GraphicalReportHandler::new();
    for diagnostic in diagnostics {
        let bytes = std::fs::read(&diagnostic.file).unwrap_or_default();
        let text = String::from_utf8_lossy(&bytes).into_owned();
        // Control characters would reach the terminal; blanks of the same length keep the place.
        let visible = |c: char| if c.is_control() && !"\n\r\t".contains(c) { ' ' } else { c };
        let text: String = text
            .chars()
            .flat_map(|c| std::iter::repeat_n(visible(c), if visible(c) == c { 1 } else { c.len_utf8() }))
            .collect();
        let snippet = Snippet::new(diagnostic, text);
        let mut out = String::new();
        // A line that fills the screen hides the message; the place stands in front of it anyway.
        let long = snippet.surroundings().any(|line| line.chars().count() > LONGEST_LINE);
        if diagnostic.line == 0 || long || handler.render_report(&mut out, &snippet).is_err() {
            eprintln!("error: {diagnostic}\n");
        } else {
            eprintln!("{}", out.trim_start_matches('\n'));
        }
    }
    if diagnostics.len() > 1 {
        eprintln!("{} errors", diagnostics.len());
    }
}

/// A diagnostic in the shape that the report's printer wants.
#[derive(Debug)]
struct Snippet {
    message: String,
    line: usize,
    help: String,
    source: NamedSource<String>,
    label: LabeledSpan,
}

impl Snippet {
    fn new(d: &Diagnostic, text: String) -> Self {
        // Long tables would fill the screen: their first line is enough.
        let start = d.span.start.min(text.len());
        let rest = text.get(start..d.span.end.min(text.len())).unwrap_or_default();
        let length = rest.lines().next().unwrap_or_default().len().max(1).min(text.len() - start);
        let message = if d.key.is_empty() { d.message.clone() } else { format!("{}: {}", d.key, d.message) };
        Self {
            message,
            line: d.line,
            help: d.help.clone(),
            source: NamedSource::new(d.file.display().to_string(), text),
            label: LabeledSpan::new(None, start, length),
        }
    }

    /// The line meant and those before and behind it, which are shown with it.
    fn surroundings(&self) -> impl Iterator<Item = &str> {
        self.source.inner().lines().skip(self.line.saturating_sub(2)).take(3)
    }
}

impl std::fmt::Display for Snippet {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.message)
    }
}

impl std::error::Error for Snippet {}

impl miette::Diagnostic for Snippet {
    fn help<'a>(&'a self) -> Option<Box<dyn std::fmt::Display + 'a>> {
        (!self.help.is_empty()).then(|| Box::new(&self.help) as Box<dyn std::fmt::Display>)
    }

    fn source_code(&self) -> Option<&dyn SourceCode> {
        Some(&self.source)
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        Some(Box::new(std::iter::once(self.label.clone())))
    }
}
