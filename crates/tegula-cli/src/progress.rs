//! One line that says how far a run is: moving on a terminal, now and then elsewhere.

use std::io::IsTerminal as _;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};
use tegula_io::job::{JobObserver, Progress, Start};

use crate::interrupt;

/// Part of the run after which a plain line is printed.
const PLAIN_EVERY: f64 = 0.1;
/// Marks of the bar.
const MARKS: u64 = 1000;

/// The progress of a run on standard error.
pub struct ProgressLine {
    quiet: bool,
    bar: Option<ProgressBar>,
    begun: Instant,
    from: f64,
    printed: f64,
}

impl ProgressLine {
    /// A line; `quiet` prints nothing.
    pub fn new(quiet: bool) -> Self {
        let bar = (!quiet && std::io::stderr().is_terminal()).then(|| ProgressBar::new(MARKS));
        if let Some(bar) = &bar
            && let Ok(style) = ProgressStyle::with_template("{bar:30} {percent:>3} %  {msg}")
        {
            bar.set_style(style);
        }
        Self { quiet, bar, begun: Instant::now(), from: 0.0, printed: 0.0 }
    }

    /// Clears the moving line.
    pub fn close(&mut self) {
        if let Some(bar) = self.bar.take() {
            bar.finish_and_clear();
        }
    }

    fn say(&self, line: &str) {
        match &self.bar {
            Some(bar) => bar.println(line),
            None if !self.quiet => eprintln!("{line}"),
            None => {}
        }
    }

    /// Time that is left, if the rest goes on as the part so far.
    fn left(&self, progress: &Progress) -> Option<Duration> {
        let (done, rest) = (progress.time - self.from, progress.end - progress.time);
        let seconds = self.begun.elapsed().as_secs_f64() * rest / done;
        Duration::try_from_secs_f64(seconds).ok()
    }
}

impl JobObserver for ProgressLine {
    fn on_start(&mut self, start: &Start) {
        (self.begun, self.from) = (Instant::now(), start.time);
        self.printed = start.time / start.end;
        let resumed = if start.time > 0.0 { format!(", from {}", start.time) } else { String::new() };
        let title = if start.title.is_empty() { String::new() } else { format!("{}: ", start.title) };
        self.say(&format!(
            "{title}{} analysis, {} elements, {} unknowns{resumed}",
            start.analysis, start.elements, start.unknowns
        ));
    }

    fn on_step(&mut self, progress: &Progress) {
        let part = progress.time / progress.end;
        let left = match self.left(progress) {
            Some(left) if part < 1.0 => format!(", {} left", in_words(left)),
            _ => String::new(),
        };
        let message = format!(
            "step {}  t {:.5}  dt {:.2e}  {} iterations{left}",
            progress.step, progress.time, progress.step_size, progress.iterations
        );
        if let Some(bar) = &self.bar {
            bar.set_position((part.clamp(0.0, 1.0) * MARKS as f64) as u64);
            bar.set_message(message);
        } else if part >= self.printed + PLAIN_EVERY || (part >= 1.0 && self.printed < 1.0) {
            self.printed = part;
            self.say(&format!("{:3.0} %  {message}", 100.0 * part));
        }
    }

    fn on_event(&mut self, message: &str) {
        // Repeated steps are daily bread of step control; they stand in the log.
        if self.bar.is_some() {
            self.say(message);
        }
    }

    fn on_warning(&mut self, message: &str) {
        self.say(&format!("warning: {message}"));
    }

    fn interrupted(&self) -> bool {
        interrupt::requested()
    }
}

fn in_words(time: Duration) -> String {
    let s = time.as_secs();
    match s {
        0..60 => format!("{s} s"),
        60..3600 => format!("{} min {:02} s", s / 60, s % 60),
        _ => format!("{} h {:02} min", s / 3600, s / 60 % 60),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_in_words() {
        let words = [5, 65, 3700].map(|s| in_words(Duration::from_secs(s)));
        assert_eq!(words, ["5 s", "1 min 05 s", "1 h 01 min"]);
    }
}
