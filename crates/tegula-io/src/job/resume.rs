//! Conversion between the state of a run and the arrays of a checkpoint.

mod coordinates;

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Serialize};
use tegula::System;
use tegula::analysis::lagged_tangent::LaggedTangent;
use tegula::analysis::{Balance, State, Statistics, Watched};
use tegula::element::Nodal;

use super::snapshots::StoredSnapshot;
use crate::out::{Checkpoint, OutputError};

const REMEDY: &str = "Run without `--resume` to start anew";

/// Checkpoint data: everything that a run restarts from.
#[derive(Debug, Clone, PartialEq, Default)]
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
        let (s, b) = (&self.state, &self.balance);
        let scalars = [s.time, s.next_step, s.last_step, s.work, s.dissipated, s.energy_scale, s.swing];
        let path_so_far =
            [s.displacement_scale, f64::from(u8::from(s.other_form)), s.negative_pivots as f64, s.compliance];
        let met: Vec<f64> = s.watched.met.iter().map(|&condition| condition as f64).collect();
        let coordinates = coordinates::numbers(&s.coordinates);
        let energies = [b.kinetic, b.strain, b.potential, b.work, b.dissipated, b.total];
        let momenta = [b.momentum, b.angular_momentum];
        let mut arrays: BTreeMap<String, Cow<[f64]>> = [
            ("u", s.u.as_flattened()),
            ("v", s.v.as_flattened()),
            ("a", s.a.as_flattened()),
            ("mean a", s.mean_a.as_flattened()),
            ("scheme v", s.scheme_v.as_flattened()),
            ("acceleration lag", s.acceleration_lag.as_flattened()),
            ("history", &s.history),
            ("multipliers", &s.multipliers),
            ("angles", &s.angles),
            ("coordinates", &coordinates),
            ("watched columns", &s.watched.values),
            ("stop condition met", &met),
            ("scalars", &scalars),
            ("forces", &self.forces.0),
            ("reactions", self.forces.1.as_flattened()),
            ("load path", &path_so_far),
            ("energies", &energies),
            ("momenta", momenta.as_flattened()),
        ]
        .into_iter()
        .map(|(name, values)| (name.to_owned(), values.into()))
        .collect();
        let t = &s.tangent;
        let counts =
            [u32::from(t.valid), t.steps, t.iterations, t.last, t.pause, t.next_pause].map(f64::from);
        arrays.insert("tangent".into(), [&[t.time, t.dt], counts.as_slice()].concat().into());
        if t.valid {
            arrays.insert("tangent u".into(), t.u.as_flattened().into());
            arrays.insert("tangent v".into(), t.v.as_flattened().into());
            arrays.insert("tangent history".into(), t.history.as_slice().into());
        }
        for (i, kept) in self.kept.iter().enumerate() {
            arrays.insert(format!("picture {i} time"), vec![kept.time].into());
            arrays.insert(format!("picture {i} displacements"), kept.displacements.as_flattened().into());
            arrays.insert(format!("picture {i} values"), kept.values.as_slice().into());
        }
        let notes = serde_json::to_value(self.notes)
            .map_err(|e| OutputError::refused(path, format!("its notes cannot be written: {e}")))?;
        Checkpoint { model_fingerprint, step: s.step, time: s.time, arrays, notes }.save(path)
    }

    /// Loads what [`save`](Self::save) saved for the same model.
    pub fn load(path: &Path, model_fingerprint: u64, system: &System) -> Result<Self, OutputError> {
        let checkpoint = Checkpoint::load_for(path, model_fingerprint)?;
        let wrong = |what: &str| {
            OutputError::damaged(path, format!("its array `{what}` does not fit the model"), REMEDY)
        };
        let array = |name: &str, length: Option<usize>| {
            let found = checkpoint.arrays.get(name).ok_or_else(|| wrong(name))?;
            if length.is_some_and(|n| n != found.len()) { Err(wrong(name)) } else { Ok(found.to_vec()) }
        };
        let n = system.vectors();
        let history = system.groups.iter().map(|g| g.len() * g.history_per_element()).sum();
        let fixed = |name: &str, length: usize| array(name, Some(length));
        let all_or_none = |name: &str| {
            let found = vectors(&array(name, None)?);
            if found.is_empty() || found.len() == n { Ok(found) } else { Err(wrong(name)) }
        };
        // Checkpoints of models without sensors and stop conditions may be older than these.
        let newer = |name: &str| checkpoint.arrays.get(name).cloned().unwrap_or_default().to_vec();
        let angles = newer("angles");
        if angles.len() != system.angle_sensors().count() {
            return Err(wrong("angles"));
        }
        let met = newer("stop condition met").first().map(|&condition| condition as usize);
        let watched = Watched { values: newer("watched columns"), met };
        let scalars = fixed("scalars", 7)?;
        let path_so_far = fixed("load path", 4)?;
        let energies = fixed("energies", 6)?;
        let momenta = fixed("momenta", 6)?;
        let t = fixed("tangent", 8)?;
        let mut tangent = LaggedTangent {
            valid: t[2] != 0.0,
            time: t[0],
            dt: t[1],
            steps: t[3] as u32,
            iterations: t[4] as u32,
            last: t[5] as u32,
            pause: t[6] as u32,
            next_pause: t[7] as u32,
            ..LaggedTangent::default()
        };
        if tangent.valid {
            tangent.u = vectors(&fixed("tangent u", 3 * n)?);
            tangent.v = all_or_none("tangent v")?;
            tangent.history = fixed("tangent history", history)?;
        }
        let state = State {
            // The forces of the last step are written; those of the next one bring their own.
            middle: Vec::new(),
            time: scalars[0],
            step: checkpoint.step,
            u: vectors(&fixed("u", 3 * n)?),
            v: all_or_none("v")?,
            a: all_or_none("a")?,
            mean_a: all_or_none("mean a")?,
            scheme_v: all_or_none("scheme v")?,
            acceleration_lag: all_or_none("acceleration lag")?,
            history: fixed("history", history)?,
            multipliers: fixed("multipliers", system.constraints())?,
            angles,
            coordinates: coordinates::states(checkpoint.arrays.get("coordinates").map_or(&[][..], |x| x)),
            watched,
            next_step: scalars[1],
            last_step: scalars[2],
            work: scalars[3],
            dissipated: scalars[4],
            energy_scale: scalars[5],
            swing: scalars[6],
            displacement_scale: path_so_far[0],
            other_form: path_so_far[1] != 0.0,
            negative_pivots: path_so_far[2] as usize,
            compliance: path_so_far[3],
            tangent,
        };
        let balance = Balance {
            kinetic: energies[0],
            strain: energies[1],
            potential: energies[2],
            work: energies[3],
            dissipated: energies[4],
            total: energies[5],
            momentum: [momenta[0], momenta[1], momenta[2]],
            angular_momentum: [momenta[3], momenta[4], momenta[5]],
        };
        let mut kept = Vec::new();
        while checkpoint.arrays.contains_key(&format!("picture {} time", kept.len())) {
            let i = kept.len();
            kept.push(StoredSnapshot {
                time: fixed(&format!("picture {i} time"), 1)?[0],
                displacements: vectors(&fixed(&format!("picture {i} displacements"), 3 * n)?),
                values: array(&format!("picture {i} values"), None)?,
            });
        }
        let notes = serde_json::from_value(checkpoint.notes.clone())
            .map_err(|e| OutputError::damaged(path, format!("its notes cannot be read: {e}"), REMEDY))?;
        let forces = (array("forces", None)?, all_or_none("reactions")?);
        Ok(Self { state, balance, forces, kept, notes })
    }
}

fn vectors(values: &[f64]) -> Vec<Nodal> {
    values.as_chunks::<3>().0.to_vec()
}
