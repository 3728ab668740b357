//! Page of a run that goes on: a server on the loopback interface with the latest shape, curves, progress and messages, and a button that
//! stops the run.
//!
//! The server is one of the standard library with a parser of the few requests there are: of the small servers for HTTP, `tiny_http` has had no
//! release since 2022, and neither time limits for its connections nor a bound on their number.
//!
//! Who knows the token in the address may see the run and stop it; every other request is refused. Nothing is read from the disk.

// Tests may unwrap; the code they test may not.
#![cfg_attr(test, allow(clippy::unwrap_used))]

mod http;
mod page;
mod rows;
mod server;
mod shapes;
mod slot;

use std::io;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use tegula::analysis::State;

use crate::job::{JobError, JobObserver, Prepared, Progress, RecordedStep, Start, Summary};
use crate::out::numbers::{counted, duration};
use server::Server;
use slot::{Heading, Kind, Message, Outcome, Slot};

/// Shortest time between two states that are handed to the clients.
const PERIOD: Duration = Duration::from_millis(200);
/// Part of the time of a run that may be spent on handing over states.
const MOST_OF_TIME: f64 = 0.01;
/// Time in which a page can fetch the end of a run.
const LAST_CALL: Duration = Duration::from_secs(5);
/// Time for other pages behind the first one that has the end.
const OTHERS: Duration = Duration::from_millis(1200);
/// Time for answers that have begun.
const LAST_ANSWERS: Duration = Duration::from_secs(20);
/// Number of recorded points whose displacements are shown.
const MOST_POINTS: usize = 8;
/// Columns that are shown of each history.
const COLUMNS: [&str; 8] = [
    "kinetic",
    "strain",
    "total",
    "dissipated",
    "iterations",
    "step_size",
    "path.position",
    "path.negative_eigenvalues",
];

/// Page of a run, and the observer that keeps it up to date.
pub struct RunPage {
    server: Server,
    /// Analysis that starts.
    heading: Option<Heading>,
    /// Numbers of the columns that are shown.
    columns: Vec<usize>,
    /// Rows that have not been handed over.
    rows: Vec<f64>,
    progress: Option<Progress>,
    messages: Vec<Message>,
    handed_over: Option<Instant>,
    /// Time between two states.
    pause: Duration,
}

impl RunPage {
    /// Serves the page of a run on a free port of this computer.
    ///
    /// # Errors
    /// There is no port, no thread, or no source of randomness.
    pub fn serve() -> io::Result<Self> {
        Ok(Self {
            server: Server::start()?,
            heading: None,
            columns: Vec::new(),
            rows: Vec::new(),
            progress: None,
            messages: Vec::new(),
            handed_over: None,
            pause: PERIOD,
        })
    }

    /// Address of the page. Its token is a secret.
    pub fn url(&self) -> String {
        self.server.url()
    }

    /// Shows how the run has ended.
    pub fn end(&mut self, outcome: &Result<Summary, JobError>) {
        self.hand_over(None);
        let (status, text) = match outcome {
            Ok(s) => ("complete", ended(s)),
            Err(JobError::Interrupted { resumable: true, .. }) => {
                ("interrupted", "the run can be resumed by --resume".into())
            }
            Err(JobError::Interrupted { .. }) => ("interrupted", String::new()),
            Err(error) => ("failed", error.to_string()),
        };
        self.slot().lock().outcome = Some(Outcome { status, text });
    }

    /// Waits until a page has fetched the end of the run, for five seconds at most, or until `hurry` says so.
    pub fn close(self, hurry: impl Fn() -> bool) {
        let begun = Instant::now();
        loop {
            let waited = begun.elapsed();
            let taken = self.slot().taken().is_some_and(|taken| taken.elapsed() > OTHERS);
            let over = taken || waited > LAST_CALL;
            if hurry() || waited > LAST_ANSWERS || (over && self.server.connections() == 0) {
                return;
            }
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    fn slot(&self) -> &Slot {
        &self.server.shared().slot
    }

    fn is_due(&self) -> bool {
        self.handed_over.is_none_or(|last| last.elapsed() >= self.pause)
    }

    /// Hands over rows, progress and messages, and a state where there is one.
    fn hand_over(&mut self, state: Option<(&Prepared, &State)>) {
        let begun = Instant::now();
        let slot = &self.server.shared().slot;
        let shape = state.map(|(prepared, state)| {
            let (part, shapes) = {
                let content = slot.lock();
                (content.part, content.shapes)
            };
            shapes::shape(part, shapes + 1, prepared, state)
        });
        let mut content = slot.lock();
        content.rows.append(&self.rows);
        content.progress = self.progress.or(content.progress);
        self.messages.drain(..).for_each(|message| content.say(message));
        if let Some(shape) = shape {
            content.shape = shape.into();
            content.shapes += 1;
        }
        drop(content);
        self.rows.clear();
        let now = Instant::now();
        self.handed_over = Some(now);
        self.pause = PERIOD.max((now - begun).div_f64(MOST_OF_TIME));
    }

    fn say(&mut self, kind: Kind, text: &str) {
        self.messages.push(Message { kind, text: text.to_owned() });
        if self.is_due() {
            self.hand_over(None);
        }
    }
}

/// Findings and cost of a run in one line.
fn ended(s: &Summary) -> String {
    let found = s.frequencies_hz.as_ref().or(s.load_factors.as_ref());
    let done = match found {
        Some(found) => counted(found.len() as u64, "mode"),
        None => format!("{}, {}", counted(s.steps, "step"), counted(s.cutbacks, "cut-back")),
    };
    format!("{done}, {}", duration(s.wall_s))
}

/// Numbers of the columns that are shown: time, displacements of points, energies, step size, and those of a path.
fn shown(columns: &[String]) -> Vec<usize> {
    let point = |name: &str| ["x", "y", "z"].iter().any(|c| name.ends_with(&format!(".u{c}")));
    // A bushing has displacements of its own.
    let points = columns.iter().enumerate().take_while(|(_, name)| *name != "kinetic");
    let points = points.filter(|(_, name)| point(name)).map(|(i, _)| i).take(3 * MOST_POINTS);
    let others = columns.iter().enumerate().filter(|(_, name)| COLUMNS.contains(&name.as_str()));
    (0..columns.len().min(1)).chain(points).chain(others.map(|(i, _)| i)).collect()
}

impl JobObserver for RunPage {
    fn on_start(&mut self, start: &Start) {
        // Rows behind the last state belong to the analysis before.
        self.hand_over(None);
        self.progress = None;
        self.heading = Some(Heading {
            title: start.title.clone(),
            analysis: start.analysis,
            described: start.described(),
            elements: start.elements,
            unknowns: start.unknowns,
            first: start.time.min(0.0),
            end: start.end,
            columns: Vec::new(),
        });
    }

    fn on_model(&mut self, prepared: &Prepared, columns: &[String]) {
        self.columns = shown(columns);
        let Some(mut heading) = self.heading.take() else { return };
        heading.columns = self.columns.iter().map(|&i| columns[i].clone()).collect();
        let part = self.slot().lock().part + 1;
        let mesh = shapes::mesh(part, prepared);
        self.slot().lock().begin(heading, mesh);
    }

    fn on_step(&mut self, progress: &Progress) {
        self.progress = Some(*progress);
        // Analyses that find modes record no steps.
        if self.columns.is_empty() && self.is_due() {
            self.hand_over(None);
        }
    }

    fn on_recorded_step(&mut self, step: &RecordedStep<'_>) {
        self.rows.extend(self.columns.iter().filter_map(|&i| step.row.get(i)));
        if self.is_due() {
            self.hand_over(Some((step.prepared, step.state)));
        }
    }

    fn on_last_state(&mut self, prepared: &Prepared, state: &State) {
        self.hand_over(Some((prepared, state)));
    }

    fn on_event(&mut self, message: &str) {
        self.say(Kind::Event, message);
    }

    fn on_warning(&mut self, message: &str) {
        self.say(Kind::Warning, message);
    }

    fn interrupted(&self) -> bool {
        self.server.shared().stop.load(Ordering::Acquire)
    }
}

#[cfg(test)]
mod tests;
