//! A few instants kept during the run for the picture of deformed shells.

use tegula::analysis::State;
use tegula::element::Nodal;

/// Instants in the picture.
pub(super) const INSTANTS: usize = 6;

/// The shell at an instant.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Kept {
    /// Time.
    pub time: f64,
    /// Displacements of the nodal vectors.
    pub displacements: Vec<Nodal>,
    /// Von Mises stress, quad by quad.
    pub values: Vec<f64>,
}

/// True if a state is the first at or behind one of the evenly spaced instants.
pub(super) fn wanted(kept: &[Kept], time: f64, end: f64) -> bool {
    let instants = (INSTANTS - 1) as f64;
    let number = |t: f64| (t / end * instants * (1.0 + 1e-9)).floor();
    kept.last().is_none_or(|last| time > last.time && number(time) > number(last.time))
}

/// Keeps a state.
pub(super) fn keep(kept: &mut Vec<Kept>, state: &State, values: Vec<f64>) {
    kept.push(Kept { time: state.time, displacements: state.u.clone(), values });
}
