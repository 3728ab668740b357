//! Checkpoint data of a run, and their check against the model.

use std::path::Path;

use serde::{Deserialize, Serialize};
use tegula::System;
use tegula::analysis::{Balance, State, Statistics};
use tegula::element::Nodal;

use super::snapshots::StoredSnapshot;
use crate::out::{OutputError, load_checkpoint, save_checkpoint};

/// Checkpoint data: everything that a run restarts from.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub(super) struct CheckpointData {
    /// The state at the end of the last step.
    pub state: State,
    /// Its energies and momenta.
    pub balance: Balance,
    /// Resultants of supports and loads and their balance in the last step, as in the history, and the reactions on the nodal
    /// vectors; empty before the first one. They belong to the step, not to the state at its end alone.
    pub forces: (Vec<f64>, Vec<Nodal>),
    /// Pictures kept so far.
    pub kept: Vec<StoredSnapshot>,
    /// Counts and places.
    pub notes: RunCounters,
}

/// Counts and places in the files.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct RunCounters {
    /// Rows of the history.
    pub rows: u64,
    /// Field files.
    pub frames: usize,
    /// Iterations so far.
    pub iterations: u64,
    /// Factorisations so far.
    pub factorizations: u64,
    /// Repeated steps so far.
    pub cutbacks: u64,
    /// Iterations of the linear solver so far.
    pub linear_iterations: u64,
    /// Latest critical time step of an explicit scheme; 0 for others.
    #[serde(default)]
    pub critical_step: f64,
    /// Largest error of the energy balance of an explicit scheme so far.
    #[serde(default)]
    pub energy_error: f64,
    /// Time on the clock so far (s).
    pub wall_s: f64,
    /// Processor time so far (s).
    pub cpu_s: Option<f64>,
    /// Time of the last regular field file.
    pub last_frame: f64,
}

impl RunCounters {
    /// The counts of this part added to those of earlier parts.
    pub fn total(&self, part: &Statistics) -> Statistics {
        Statistics {
            steps: part.steps,
            iterations: self.iterations + part.iterations,
            factorizations: self.factorizations + part.factorizations,
            cutbacks: self.cutbacks + part.cutbacks,
            critical_step: if part.critical_step > 0.0 { part.critical_step } else { self.critical_step },
            energy_error: self.energy_error.max(part.energy_error),
            linear_iterations: self.linear_iterations + part.linear_iterations,
        }
    }
}

impl CheckpointData {
    /// Saves it for the model with this fingerprint.
    pub fn save(&self, path: &Path, model_fingerprint: u64) -> Result<(), OutputError> {
        save_checkpoint(path, model_fingerprint, self)
    }

    /// Loads what [`save`](Self::save) saved for the same model.
    pub fn load(path: &Path, model_fingerprint: u64, system: &System) -> Result<Self, OutputError> {
        let data: Self = load_checkpoint(path, model_fingerprint)?;
        match data.misfit(system) {
            None => Ok(data),
            Some(field) => {
                let problem = format!("its array `{field}` does not fit the model");
                Err(OutputError::damaged(path, problem, "Run without `--resume` to start anew"))
            }
        }
    }

    /// First array whose length is not that of the model.
    fn misfit(&self, system: &System) -> Option<&'static str> {
        let n = system.vectors();
        let reactions = Some(("reactions", self.forces.1.len())).filter(|(_, length)| *length > 0);
        let pictures = self.kept.iter().map(|kept| ("displacements of pictures", kept.displacements.len()));
        let own = || reactions.into_iter().chain(pictures).find(|(_, length)| *length != n);
        self.state.misfit(system).or_else(|| own().map(|(name, _)| name))
    }
}
