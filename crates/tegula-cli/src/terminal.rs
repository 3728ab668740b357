//! Standard output and standard error, which may be closed, full, or read by somebody who stops reading.
//!
//! Nothing here panics. Text from model files passes through [`printable`], so that it cannot steer a terminal.

use std::fmt;
use std::io::{ErrorKind, IsTerminal as _, Write as _};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};

use tegula_io::out::printable;

/// Why the standard output could not take everything.
static UNWRITTEN: OnceLock<String> = OnceLock::new();
/// Whether nothing is written: of several ranks of a run one tells what happens.
static SILENT: AtomicBool = AtomicBool::new(false);

/// A line on standard output. Whoever reads may stop reading, as in `tegula schema | head`.
macro_rules! say {
    ($($text:tt)*) => { $crate::terminal::output(format_args!($($text)*)) };
}

/// A line on standard error.
macro_rules! tell {
    ($($text:tt)*) => { $crate::terminal::error(format_args!($($text)*)) };
}

/// Writes nothing from now on.
#[cfg(feature = "petsc")]
pub fn silence() {
    SILENT.store(true, Ordering::Relaxed);
}

/// Writes again.
#[cfg(feature = "petsc")]
pub fn speak() {
    SILENT.store(false, Ordering::Relaxed);
}

fn is_silent() -> bool {
    SILENT.load(Ordering::Relaxed)
}

/// Writes a line to standard output; a failure is kept for `unwritten`.
pub fn output(text: fmt::Arguments<'_>) {
    if is_silent() {
        return;
    }
    let line = format!("{}\n", printable(&text.to_string()));
    let mut stdout = std::io::stdout().lock();
    match stdout.write_all(line.as_bytes()).and_then(|()| stdout.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => drop(UNWRITTEN.set(error.to_string())),
        _ => {}
    }
}

/// Writes a line to standard error, where that is possible.
pub fn error(text: fmt::Arguments<'_>) {
    if is_silent() {
        return;
    }
    let line = format!("{}\n", printable(&text.to_string()));
    let _ = std::io::stderr().lock().write_all(line.as_bytes());
}

/// Why the standard output lacks something, but for a reader who has stopped reading.
pub fn unwritten() -> Option<&'static str> {
    UNWRITTEN.get().map(String::as_str)
}

/// Writes a message that begins with `error:` or `warning:`, that word in colour on a terminal.
pub fn report(word: &str, message: &str) {
    if is_silent() {
        return;
    }
    let (message, plain) = (printable(message), std::env::var_os("NO_COLOR").is_some());
    let colour = if word == "error" { "\x1b[1;31m" } else { "\x1b[1;33m" };
    let line = if std::io::stderr().is_terminal() && !plain {
        format!("{colour}{word}:\x1b[0m {message}\n")
    } else {
        format!("{word}: {message}\n")
    };
    let _ = std::io::stderr().lock().write_all(line.as_bytes());
}
