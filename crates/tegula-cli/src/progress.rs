//! Progress line of a run: updated in place on a terminal, printed at intervals elsewhere.

use std::cell::Cell;
use std::io::IsTerminal as _;
use std::time::Instant;

use indicatif::{ProgressBar, ProgressStyle};
use tegula_io::job::{JobObserver, Progress, Start};
use tegula_io::out::numbers::{counted, duration, grouped, significant};
use tegula_io::out::printable;

use crate::{interrupt, terminal};

/// Part of the run after which a plain line is printed.
const PLAIN_EVERY: f64 = 0.1;
/// Marks of the bar.
const MARKS: u64 = 1000;

/// Detail of the lines printed during a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Detail {
    /// Errors only.
    Nothing,
    /// The progress.
    Progress,
    /// Every step and event.
    Everything,
}

/// The progress of a run on standard error.
pub struct ProgressLine {
    detail: Detail,
    bar: Option<ProgressBar>,
    begun: Instant,
    statics: bool,
    from: f64,
    /// Where an analysis that is not resumed begins.
    first: f64,
    printed: f64,
    stopping: Cell<bool>,
}

impl ProgressLine {
    /// A line that says so much.
    pub fn new(detail: Detail) -> Self {
        let moving = detail > Detail::Nothing && std::io::stderr().is_terminal();
        let bar = moving.then(|| ProgressBar::new(MARKS));
        if let Some(bar) = &bar
            && let Ok(style) = ProgressStyle::with_template("{bar:30} {percent:>3} %  {msg}")
        {
            bar.set_style(style);
        }
        let begun = Instant::now();
        Self {
            detail,
            bar,
            begun,
            statics: false,
            from: 0.0,
            first: 0.0,
            printed: 0.0,
            stopping: Cell::new(false),
        }
    }

    /// Clears the moving line.
    pub fn close(&mut self) {
        if let Some(bar) = self.bar.take() {
            bar.finish_and_clear();
        }
    }

    fn say(&self, line: &str) {
        match &self.bar {
            Some(bar) => bar.suspend(|| tell!("{line}")),
            None if self.detail > Detail::Nothing => tell!("{line}"),
            None => {}
        }
    }

    /// Estimated remaining time (s), at the average speed so far.
    fn left(&self, progress: &Progress) -> Option<f64> {
        let (done, rest) = (progress.time - self.from, progress.end - progress.time);
        let seconds = self.begun.elapsed().as_secs_f64() * rest / done;
        (seconds.is_finite() && seconds > 0.0).then_some(seconds)
    }

    fn line(&self, progress: &Progress) -> String {
        let (place, length) = if self.statics { ("load factor", "increment") } else { ("time", "step size") };
        let left = self.left(progress).map_or(String::new(), |left| format!(", {} left", duration(left)));
        format!(
            "step {}: {place} {}, {length} {}, {}{left}",
            progress.step,
            significant(progress.time, 5),
            significant(progress.step_size, 3),
            counted(progress.iterations.into(), "iteration")
        )
    }
}

impl JobObserver for ProgressLine {
    fn on_start(&mut self, start: &Start) {
        (self.begun, self.from) = (Instant::now(), start.time);
        self.statics = start.analysis == "static";
        self.first = start.time.min(0.0);
        self.printed = (start.time - self.first) / (start.end - self.first);
        let place = if self.statics { "load factor" } else { "time" };
        let resumed = match start.time > 0.0 {
            true => format!(", from {place} {}", significant(start.time, 5)),
            false => String::new(),
        };
        let title = if start.title.is_empty() { String::new() } else { format!("{}: ", start.title) };
        self.say(&format!(
            "{title}{}, {} elements, {} unknowns{resumed}",
            start.described(),
            grouped(start.elements),
            grouped(start.unknowns)
        ));
    }

    fn on_step(&mut self, progress: &Progress) {
        let part = (progress.time - self.first) / (progress.end - self.first);
        if let Some(bar) = &self.bar {
            bar.set_position((part.clamp(0.0, 1.0) * MARKS as f64) as u64);
            bar.set_message(printable(&self.line(progress)).into_owned());
        }
        let due = part >= self.printed + PLAIN_EVERY || (part >= 1.0 && self.printed < 1.0);
        if self.detail == Detail::Everything || (self.bar.is_none() && due) {
            self.printed = part;
            self.say(&format!("{:3.0} %  {}", 100.0 * part, self.line(progress)));
        }
    }

    fn on_modes(&mut self, found: usize, wanted: usize, vectors: usize) {
        let message = format!("{found} of {wanted} modes, basis of {vectors} vectors");
        if let Some(bar) = &self.bar {
            bar.set_position(MARKS * found as u64 / wanted.max(1) as u64);
            bar.set_message(message);
        } else if self.detail == Detail::Everything {
            self.say(&message);
        }
    }

    fn on_event(&mut self, message: &str) {
        // Steps that are cut back are daily bread of step control; they stand in the log.
        if self.bar.is_some() || self.detail == Detail::Everything {
            self.say(message);
        }
    }

    fn on_warning(&mut self, message: &str) {
        if self.detail > Detail::Nothing {
            let warn = || terminal::report("warning", message);
            self.bar.as_ref().map_or_else(warn, |bar| bar.suspend(warn));
        }
    }

    fn interrupted(&self) -> bool {
        let stop = interrupt::requested();
        if stop && !self.stopping.replace(true) {
            self.say("stopping (once more to end the program at once)");
        }
        stop
    }
}
