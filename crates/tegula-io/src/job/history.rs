//! `history.csv`: one row per step.

use tegula::analysis::{State, Step};
use tegula::model::Analysis;
use tegula::result::{Equilibrium, Probe, ReactionFinder, sensor_columns, sensor_values};
use tegula::system::Procedure;
use tegula::{Model, System};

use super::{Prepared, bodies, forces};

/// Columns per recorded point.
pub(super) const PER_POINT: usize = 6;
/// Names of the columns behind the points.
pub(super) const BEHIND: [&str; 14] = [
    "kinetic",
    "strain",
    "potential",
    "work",
    "dissipated",
    "total",
    "px",
    "py",
    "pz",
    "lx",
    "ly",
    "lz",
    "iterations",
    "step_size",
];

/// Columns of a path: its parameter, and the negative eigenvalues of the tangent.
pub(super) const PATH: [&str; 2] = ["path.position", "path.negative_eigenvalues"];

/// Rows of the history of a run: motion of the points and bodies, energies, momenta, forces, sensors.
pub struct HistoryRows {
    columns: Vec<String>,
    finder: ReactionFinder,
}

impl HistoryRows {
    /// Rows of an analysis of a prepared model.
    pub fn new(model: &Model, prepared: &Prepared) -> Self {
        let scheme = match &model.analysis {
            Analysis::Transient(analysis) => Some(analysis.scheme),
            Analysis::Static(_) | Analysis::Path(_) | Analysis::Modal(_) | Analysis::Buckling(_) => None,
        };
        Self {
            columns: columns(&prepared.system, &prepared.probes),
            finder: ReactionFinder::new(&prepared.system, scheme),
        }
    }

    /// Names of the columns.
    pub fn columns(&self) -> &[String] {
        &self.columns
    }

    /// Reactions, loads and inertia of a state by itself.
    pub(super) fn forces_at(&mut self, system: &System, state: &State) -> Equilibrium {
        self.finder.find(system, None, state)
    }

    /// Row of a step behind a state, which is empty before the first one; the forces in the step, and its length.
    pub fn row(&mut self, prepared: &Prepared, before: &State, step: &Step) -> (Vec<f64>, Equilibrium, f64) {
        let Prepared { system, probes, .. } = prepared;
        let step_size = match before.u.is_empty() {
            true => 0.0,
            // Not every step is reported.
            false if system.procedure == Procedure::Explicit => step.state.last_step,
            false => step.state.time - before.time,
        };
        let forces = self.finder.find(system, Some(before), step.state);
        (whole_row((system, probes), step, step_size, &forces), forces, step_size)
    }
}

/// Names of all columns of a run.
pub(super) fn columns(system: &System, probes: &[Probe]) -> Vec<String> {
    let parts = [
        names(probes),
        forces::names(system),
        bodies::names(system),
        sensor_columns(system),
        if system.procedure == Procedure::Path { PATH.map(str::to_owned).to_vec() } else { Vec::new() },
    ];
    parts.concat()
}

/// Names of the columns of points and energies.
pub(super) fn names(probes: &[Probe]) -> Vec<String> {
    let mut out = vec!["time".to_owned()];
    for probe in probes {
        out.extend(["x", "y", "z", "ux", "uy", "uz"].map(|c| format!("{}.{c}", probe.name)));
    }
    out.extend(BEHIND.map(str::to_owned));
    out
}

/// Row of a step, with the forces in it.
fn whole_row(
    (system, probes): (&System, &[Probe]),
    step: &Step,
    step_size: f64,
    forces: &Equilibrium,
) -> Vec<f64> {
    let mut out = row(system, probes, step, step_size);
    out.extend(forces::row(forces));
    out.extend(bodies::row(system, step.state));
    out.extend(sensor_values(system, step.state));
    if let Some(path) = &step.state.path {
        out.extend([path.position, step.state.negative_pivots as f64]);
    }
    out
}

/// Columns of points and energies.
fn row(system: &System, probes: &[Probe], step: &Step, step_size: f64) -> Vec<f64> {
    let Step { state, balance, iterations, .. } = *step;
    let mut out = vec![state.time];
    for probe in probes {
        out.extend(probe.position(system, state));
        out.extend(probe.displacement(state));
    }
    let b = balance;
    out.extend([b.kinetic, b.strain, b.potential, b.work, b.dissipated, b.total]);
    out.extend(b.momentum);
    out.extend(b.angular_momentum);
    out.extend([f64::from(iterations), step_size]);
    out
}
