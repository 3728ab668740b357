//! `history.csv`: one row per step.

use tegula::System;
use tegula::analysis::Step;
use tegula::result::{Equilibrium, Probe, sensor_columns, sensor_values};
use tegula::system::Procedure;

use super::{bodies, forces};

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
pub(super) fn whole_row(
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
