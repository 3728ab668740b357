//! Latest state of a run, shared by the run, which replaces it a few times per second, and the clients, which ask for what is new.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use serde::Serialize;

use super::rows::Rows;
use crate::job::Progress;

/// Number of messages that are kept.
const MOST_MESSAGES: usize = 200;

/// Kind of a message.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Kind {
    /// Event.
    Event,
    /// Warning.
    Warning,
}

/// Message of a run.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub(super) struct Message {
    /// Kind.
    pub kind: Kind,
    /// Text.
    pub text: String,
}

/// Analysis that is running.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct Heading {
    /// Title of the model.
    pub title: String,
    /// `static`, `path`, `modal`, `buckling` or `transient`.
    pub analysis: &'static str,
    /// The analysis in words.
    pub described: String,
    /// Shell elements.
    pub elements: usize,
    /// Unknowns.
    pub unknowns: usize,
    /// Time (load factor) where an analysis that is not resumed begins.
    pub first: f64,
    /// Time (load factor) at which it ends.
    pub end: f64,
    /// Names of the columns of the history that are shown.
    pub columns: Vec<String>,
}

/// End of a run.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub(super) struct Outcome {
    /// `complete`, `interrupted` or `failed`.
    pub status: &'static str,
    /// Explanation, in words.
    pub text: String,
}

/// Numbers of what a client has; all are 0 at first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Known {
    /// Number of its analysis.
    pub part: u64,
    /// Number of rows.
    pub row: u64,
    /// Number of messages.
    pub message: u64,
    /// Number of the shape.
    pub shape: u64,
}

/// Latest state of a run.
#[derive(Debug)]
pub(super) struct Content {
    /// Number of the analysis; 0 before the first one.
    pub part: u64,
    /// Analysis that is running.
    pub heading: Option<Heading>,
    /// Rows of its history.
    pub rows: Rows,
    /// Its last step.
    pub progress: Option<Progress>,
    /// Last messages of all analyses.
    messages: VecDeque<Message>,
    /// Number of all messages so far.
    message: u64,
    /// Reference configuration of the analysis, as [`super::shapes`] writes it.
    pub mesh: Arc<Vec<u8>>,
    /// Displacements, as [`super::shapes`] writes them.
    pub shape: Arc<Vec<u8>>,
    /// Number of shapes of the analysis so far.
    pub shapes: u64,
    /// End of the run.
    pub outcome: Option<Outcome>,
    /// Instant at which a client had all of a run that has ended.
    taken: Option<Instant>,
}

/// Reply to a client that asks for what is new.
#[derive(Debug, Serialize)]
pub(super) struct News {
    part: u64,
    #[serde(skip_serializing_if = "Option::is_none")]
    heading: Option<Heading>,
    row: u64,
    rows: Vec<f64>,
    progress: Option<[f64; 4]>,
    message: u64,
    messages: Vec<Message>,
    shape: u64,
    outcome: Option<Outcome>,
    /// Whether the run has ended and the client has all of it.
    whole: bool,
}

impl Content {
    fn new() -> Self {
        Self {
            part: 0,
            heading: None,
            rows: Rows::new(0),
            progress: None,
            messages: VecDeque::new(),
            message: 0,
            mesh: Arc::default(),
            shape: Arc::default(),
            shapes: 0,
            outcome: None,
            taken: None,
        }
    }

    /// Begins the next analysis, with its reference configuration.
    pub fn begin(&mut self, heading: Heading, mesh: Vec<u8>) {
        self.part += 1;
        self.rows = Rows::new(heading.columns.len());
        self.heading = Some(heading);
        self.progress = None;
        (self.mesh, self.shape, self.shapes) = (mesh.into(), Arc::default(), 0);
    }

    /// Appends a message, and drops the oldest one of many.
    pub fn say(&mut self, message: Message) {
        self.message += 1;
        self.messages.push_back(message);
        if self.messages.len() > MOST_MESSAGES {
            self.messages.pop_front();
        }
    }

    fn news(&mut self, known: Known) -> News {
        let same = known.part == self.part;
        let row = if same { known.row } else { 0 };
        let now =
            Known { part: self.part, row: self.rows.count(), message: self.message, shape: self.shapes };
        let whole = self.outcome.is_some() && known == now;
        if whole {
            self.taken.get_or_insert_with(Instant::now);
        }
        let fresh = self.message.saturating_sub(known.message);
        let skipped = self.messages.len().saturating_sub(usize::try_from(fresh).unwrap_or(usize::MAX));
        News {
            part: now.part,
            heading: self.heading.clone().filter(|_| !same),
            row: now.row,
            rows: self.rows.behind(row),
            progress: self.progress.map(|p| [p.step as f64, p.time, p.step_size, p.iterations.into()]),
            message: now.message,
            messages: self.messages.iter().skip(skipped).cloned().collect(),
            shape: now.shape,
            outcome: self.outcome.clone(),
            whole,
        }
    }
}

/// Slot with the latest state of a run.
#[derive(Debug)]
pub(super) struct Slot(Mutex<Content>);

impl Slot {
    /// Slot of a run that has not begun.
    pub fn new() -> Self {
        Self(Mutex::new(Content::new()))
    }

    /// The latest state, to be replaced. It must be let go at once: clients wait for it.
    pub fn lock(&self) -> MutexGuard<'_, Content> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// News for a client, as JSON.
    pub fn news(&self, known: Known) -> Vec<u8> {
        // The text is made when the slot is free again.
        let news = self.lock().news(known);
        serde_json::to_vec(&news).unwrap_or_default()
    }

    /// Reference configuration.
    pub fn mesh(&self) -> Arc<Vec<u8>> {
        self.lock().mesh.clone()
    }

    /// Latest displacements.
    pub fn shape(&self) -> Arc<Vec<u8>> {
        self.lock().shape.clone()
    }

    /// Instant at which a client had all of the run, which has ended.
    pub fn taken(&self) -> Option<Instant> {
        self.lock().taken
    }
}

#[cfg(test)]
mod tests {
    use serde_json::{Value, json};

    use super::*;

    fn news(slot: &Slot, [part, row, message, shape]: [u64; 4]) -> Value {
        serde_json::from_slice(&slot.news(Known { part, row, message, shape })).unwrap()
    }

    #[test]
    fn clients_get_what_they_lack() {
        let slot = Slot::new();
        assert_eq!(news(&slot, [0; 4])["part"], 0);
        let heading = Heading {
            title: "a".into(),
            analysis: "static",
            described: "static analysis".into(),
            elements: 1,
            unknowns: 2,
            first: 0.0,
            end: 1.0,
            columns: vec!["time".into(), "strain".into()],
        };
        {
            let mut content = slot.lock();
            content.begin(heading, Vec::new());
            content.rows.append(&[0.0, 1.0, 0.5, f64::NAN]);
            (0..300).for_each(|i| content.say(Message { kind: Kind::Event, text: i.to_string() }));
        }
        let first = news(&slot, [0, 7, 0, 0]);
        assert_eq!((&first["part"], &first["row"], &first["message"]), (&json!(1), &json!(2), &json!(300)));
        assert_eq!(first["rows"], json!([0.0, 1.0, 0.5, null]));
        assert_eq!(first["heading"]["columns"], json!(["time", "strain"]));
        assert_eq!(first["messages"].as_array().unwrap().len(), MOST_MESSAGES);
        let second = news(&slot, [1, 1, 298, 0]);
        assert_eq!(second["rows"], json!([0.5, null]));
        assert_eq!(second["messages"][0], json!({ "kind": "event", "text": "298" }));
        assert!(second["heading"].is_null() && second["whole"] == false);
        slot.lock().outcome = Some(Outcome { status: "complete", text: String::new() });
        assert!(news(&slot, [1, 1, 300, 0])["whole"] == false && slot.taken().is_none());
        assert!(news(&slot, [1, 2, 300, 0])["whole"] == true && slot.taken().is_some());
    }
}
