//! Run of a model file: mesh, system, analysis, and all files of the result folder.
//!
//! | in the folder | is |
//! |---|---|
//! | `summary.json` | how the run ended, what it found, what it cost |
//! | `fields.pvd`, `fields/NNNN.vtu` | displacements, resultants, stresses |
//! | `history.csv` | motion of the points, energies, momenta, reactions: a row a step |
//! | `modes.csv`, `modes.pvd`, `modes/NNNN.vtu` | natural frequencies and mode shapes; load factors of buckling and buckling modes |
//! | `critical_modes.pvd`, `critical_modes/NNNN.vtu` | modes at the limit points and bifurcations of a path |
//! | `branch-N…` | folders with the paths that cross at the bifurcations of a path |
//! | `campbell.csv` | frequencies of a model over the angular velocity with which it turns |
//! | `frequency_response.csv`, `state_space*` | response to the inputs of a modal analysis |
//! | `*.png` | pictures of all that |
//! | `checkpoint.bin` | restart file, read by `run --resume` |
//! | `log.txt` | events |
//!
//! Where several analyses follow one another, each has such a folder of its own in the result folder, `1-preload`, whose
//! `summary.json` lists them.
//!
//! The summary has the status `running` until the run has ended, so incomplete results are recognised.
//! Nothing is printed: a [`JobObserver`] receives all events.

mod assembly;
mod bodies;
mod branches;
mod buckling;
mod campbell;
mod critical_modes;
pub(crate) mod drawn_outline;
mod eigenproblem;
mod fields;
mod folder;
mod forces;
mod frames;
mod history;
mod modal;
mod modes;
mod own_parts;
mod pictures;
mod prepare;
pub mod process;
mod recorder;
mod response;
mod resume;
mod run;
mod series;
mod snapshots;
mod steps;
mod summary;

use std::path::PathBuf;

use tegula::analysis::State;

use crate::deck::Diagnostic;
use crate::out::OutputError;

pub use assembly::{AssemblyResult, GapResult, MotionResult};
pub use fields::{directors, nodal, positions, von_mises};
pub use folder::{Claim, ResultFolder};
pub use forces::{AccelerationResult, BalanceResult, ForceResult};
pub use history::HistoryRows;
pub use own_parts::{OwnLoad, OwnParts};
pub use prepare::{Prepared, fingerprint_of, prepare, prepare_with};
pub use recorder::IMBALANCE;
pub use run::{run, run_with};
pub use summary::{
    BranchResult, CriticalResult, Energy, PointResult, Status, StepSummary, StopResult, Summary,
};

/// How to run.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct JobOptions {
    /// The result folder; made where it does not exist.
    pub folder: PathBuf,
    /// Restart from the checkpoint of the folder instead of the beginning.
    pub resume: bool,
    /// Replace the results of another model in the folder.
    pub force: bool,
}

/// Announcement of a run: analysis, size, first and last time.
#[derive(Debug, Clone, PartialEq)]
pub struct Start {
    /// Title of the model.
    pub title: String,
    /// `static`, `path`, `modal`, `buckling` or `transient`.
    pub analysis: &'static str,
    /// Scheme of time integration of a transient analysis, given or by default; empty for others.
    pub scheme: &'static str,
    /// Shell elements.
    pub elements: usize,
    /// Unknowns.
    pub unknowns: usize,
    /// Time (load factor) from which it starts; above 0 where an earlier run is resumed.
    pub time: f64,
    /// Time (load factor) at which it ends.
    pub end: f64,
}

impl Start {
    /// The analysis in words: `transient analysis by energy-momentum`.
    pub fn described(&self) -> String {
        match self.scheme {
            "" => format!("{} analysis", self.analysis),
            scheme => format!("{} analysis by {scheme}", self.analysis),
        }
    }
}

/// A finished step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Progress {
    /// Its number.
    pub step: u64,
    /// Time (load factor) at its end.
    pub time: f64,
    /// Its length.
    pub step_size: f64,
    /// Its iterations.
    pub iterations: u32,
    /// Time at which the analysis ends.
    pub end: f64,
}

/// State behind a finished step, and its row of the history.
#[derive(Clone, Copy)]
pub struct RecordedStep<'a> {
    /// Model and mesh.
    pub prepared: &'a Prepared,
    /// State at the end of the step.
    pub state: &'a State,
    /// Row of the history.
    pub row: &'a [f64],
}

/// Observer of a job: a progress line, a window, a test.
pub trait JobObserver {
    /// The model is compiled, the folder is ready, the analysis starts.
    fn on_start(&mut self, _start: &Start) {}
    /// Model and mesh of the analysis that starts, and the columns of its history; modal and buckling analyses have none.
    fn on_model(&mut self, _prepared: &Prepared, _columns: &[String]) {}
    /// A step is finished and recorded.
    fn on_step(&mut self, _progress: &Progress) {}
    /// Modes of a modal or buckling analysis that are found, of those wanted, and the number of vectors of the basis.
    fn on_modes(&mut self, _found: usize, _wanted: usize, _vectors: usize) {}
    /// State and history of the step that `on_step` has announced.
    fn on_recorded_step(&mut self, _step: &RecordedStep<'_>) {}
    /// Last state of the analysis, also where it has failed or was interrupted.
    fn on_last_state(&mut self, _prepared: &Prepared, _state: &State) {}
    /// Event of interest to the user; it is also written to `log.txt`.
    fn on_event(&mut self, _message: &str) {}
    /// Warning of input that is most likely not intended, or of unreliable results; it is also written to `log.txt`.
    fn on_warning(&mut self, _message: &str) {}
    /// The results cannot be written any more; the run is about to end.
    fn on_output_failure(&mut self, _error: &OutputError) {}
    /// Asked between iterations; true ends the run after the last finished step, resumable but for modal and buckling analyses.
    fn interrupted(&self) -> bool {
        false
    }
}

/// Job observer that ignores all events.
#[derive(Debug, Clone, Copy, Default)]
pub struct Unwatched;

impl JobObserver for Unwatched {}

/// Why a job did not end with complete results.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum JobError {
    /// The model file or its mesh is wrong; nothing was run.
    #[error("the model has {}:\n{}", tegula::error::problems(.0.len()), list(.0))]
    Model(Vec<Diagnostic>),
    /// A result could not be written, or a checkpoint not read.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// The result folder cannot be used.
    #[error("`{}` cannot be used as the result folder: {reason}", folder.display())]
    Folder {
        /// The folder.
        folder: PathBuf,
        /// Why not, and what to do.
        reason: String,
    },
    /// The analysis failed; what it had found up to there is in the folder.
    #[error("{error}")]
    Analysis {
        /// Error of the analysis.
        error: tegula::Error,
        /// The result folder.
        folder: PathBuf,
    },
    /// The observer asked to stop; the results up to the last finished step are in the folder.
    #[error("interrupted")]
    Interrupted {
        /// The result folder.
        folder: PathBuf,
        /// Whether the run can be resumed from there; modal and buckling analyses cannot.
        resumable: bool,
    },
}

fn list(diagnostics: &[Diagnostic]) -> String {
    diagnostics.iter().map(|d| format!("  {d}")).collect::<Vec<_>>().join("\n")
}

#[cfg(test)]
mod tests;
