//! Snapshots stored during the run for the picture of deformed shells.

use serde::{Deserialize, Serialize};
use tegula::analysis::State;
use tegula::element::Nodal;

/// Instants in the picture.
pub(super) const INSTANTS: usize = 6;

/// The shell at an instant.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub(super) struct StoredSnapshot {
    /// Time.
    pub time: f64,
    /// Displacements of the nodal vectors.
    pub displacements: Vec<Nodal>,
    /// Von Mises stress, quad by quad.
    pub values: Vec<f64>,
}

/// True if a state is the first at or behind one of the evenly spaced instants.
pub(super) fn wanted(kept: &[StoredSnapshot], time: f64, end: f64) -> bool {
    let instants = (INSTANTS - 1) as f64;
    let number = |t: f64| (t / end * instants * (1.0 + 1e-9)).floor();
    kept.last().is_none_or(|last| time > last.time && number(time) > number(last.time))
}

/// Whether the last state is missing: it is shown wherever it stands between the evenly spaced instants.
pub(super) fn lacks(kept: &[StoredSnapshot], time: f64) -> bool {
    kept.last().is_none_or(|last| last.time < time)
}

/// The instants of the picture: the last state is worth more than one close before it.
pub(super) fn shown(kept: &[StoredSnapshot]) -> Vec<&StoredSnapshot> {
    let mut shown: Vec<&StoredSnapshot> = kept.iter().collect();
    if shown.len() > INSTANTS {
        shown.remove(INSTANTS - 1);
    }
    shown
}

/// Keeps a state.
pub(super) fn keep(kept: &mut Vec<StoredSnapshot>, state: &State, values: Vec<f64>) {
    kept.push(StoredSnapshot { time: state.time, displacements: state.u.clone(), values });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_state_of_a_failed_run_is_shown() {
        let state = |time: f64| State { time, ..State::default() };
        for (reached, times) in [
            (0.0, vec![0.0]),
            (0.13, vec![0.0, 0.13]),
            (0.47, vec![0.0, 0.2, 0.4, 0.47]),
            (0.95, vec![0.0, 0.2, 0.4, 0.6, 0.8, 0.95]),
            (1.0, vec![0.0, 0.2, 0.4, 0.6, 0.8, 1.0]),
        ] {
            let mut kept = Vec::new();
            for time in (0..=100).map(|i| 0.01 * f64::from(i)).filter(|&t| t <= reached + 1e-12) {
                if wanted(&kept, time, 1.0) {
                    keep(&mut kept, &state(time), Vec::new());
                }
            }
            if lacks(&kept, reached) {
                keep(&mut kept, &state(reached), Vec::new());
            }
            let found: Vec<f64> = shown(&kept).iter().map(|k| (k.time * 100.0).round() / 100.0).collect();
            assert_eq!(found, times);
        }
    }
}
