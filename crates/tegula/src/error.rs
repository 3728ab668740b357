//! Error type of the library: cause, place in the model, remedy.

use std::fmt;

/// Place of an issue in the model: the path of a model-file key, such as `loads[2].on`, or a place in the mesh.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Place {
    /// Path of the key in the model file, dots between tables and `[i]` for
    /// list entries (counted from 0): `conditions[0].on`. Empty: the whole model.
    pub key: String,
}

impl Place {
    /// A place named by the path of its key.
    pub fn key(path: impl Into<String>) -> Self {
        Self { key: path.into() }
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.key.is_empty() { f.write_str("model") } else { f.write_str(&self.key) }
    }
}

/// Issue: one thing wrong with a model, written for the person who has to repair it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Issue {
    /// Key of the model that is at fault.
    pub place: Place,
    /// Mistake, naming the element, set or node: one sentence.
    pub message: String,
    /// Remedy: one sentence.
    pub help: String,
}

impl Issue {
    /// A new issue at the key `place`.
    pub fn new(place: impl Into<String>, message: impl Into<String>, help: impl Into<String>) -> Self {
        Self { place: Place::key(place), message: message.into(), help: help.into() }
    }
}

impl fmt::Display for Issue {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {} ({})", self.place, self.message, self.help)
    }
}

/// Error of the library.
#[derive(Debug, Clone, thiserror::Error)]
pub enum Error {
    /// The model contradicts itself or cannot be computed; all issues found at once.
    #[error("the model has {}:\n{}", problems(.0.len()), list(.0))]
    Model(Vec<Issue>),
    /// No equilibrium was found; nothing is returned in its place.
    #[error("no equilibrium found at {at}: {reason}\n  {help}")]
    NotConverged {
        /// Load factor or time that could not be reached, as text.
        at: String,
        /// Reason, with the node or element where the residual is largest.
        reason: String,
        /// Remedies that the user can try.
        help: String,
    },
    /// An explicit motion is unstable: its energy balance is violated, or values are no longer finite.
    #[error("the motion cannot go on at {at}: {reason}\n  {help}")]
    Unstable {
        /// Time and step at which it ended, as text.
        at: String,
        /// Reason, with the node or element where it is worst.
        reason: String,
        /// Remedies that the user can try.
        help: String,
    },
    /// A linear system could not be solved.
    #[error("{what}\n  {help}")]
    Singular {
        /// Description of the singularity and its place.
        what: String,
        /// Remedies for the user.
        help: String,
    },
    /// The run was interrupted from outside; results up to the last finished step are complete.
    #[error("interrupted")]
    Interrupted,
    /// Failure outside the mechanics (an observer could not write, say).
    #[error("{0}")]
    Outside(String),
}

impl Error {
    /// An error of a single issue.
    pub fn model(place: impl Into<String>, message: impl Into<String>, help: impl Into<String>) -> Self {
        Self::Model(vec![Issue::new(place, message, help)])
    }
}

/// Result of the library.
pub type Result<T> = std::result::Result<T, Error>;

/// A number of problems in words.
pub fn problems(count: usize) -> String {
    if count == 1 { "1 problem".to_owned() } else { format!("{count} problems") }
}

fn list(issues: &[Issue]) -> String {
    issues.iter().map(|i| format!("  {i}")).collect::<Vec<_>>().join("\n")
}
