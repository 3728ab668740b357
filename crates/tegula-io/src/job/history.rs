//! `history.csv`: one row per step.

use tegula::System;
use tegula::analysis::{Balance, State};
use tegula::result::Probe;

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

/// Names of the columns.
pub(super) fn names(probes: &[Probe]) -> Vec<String> {
    let mut out = vec!["time".to_owned()];
    for probe in probes {
        out.extend(["x", "y", "z", "ux", "uy", "uz"].map(|c| format!("{}.{c}", probe.name)));
    }
    out.extend(BEHIND.map(str::to_owned));
    out
}

/// The row of a step.
pub(super) fn row(
    system: &System,
    probes: &[Probe],
    state: &State,
    balance: &Balance,
    iterations: u32,
    step_size: f64,
) -> Vec<f64> {
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
