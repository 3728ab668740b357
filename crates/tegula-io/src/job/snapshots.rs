//! Snapshots stored during the run for the picture of deformed shells.

use serde::{Deserialize, Serialize};
use tegula::analysis::State;
use tegula::element::Nodal;

use super::frames;

/// Instants in the picture.
pub(super) const INSTANTS: usize = 6;

/// The shell at an instant.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub(super) struct StoredSnapshot {
    /// Time (load factor).
    pub time: f64,
    /// Place in the course of the analysis, which grows: the time, or the parameter of a path.
    pub place: f64,
    /// Displacements of the nodal vectors.
    pub displacements: Vec<Nodal>,
    /// Von Mises stress, quad by quad.
    pub values: Vec<f64>,
}

/// True if a state is the first at or behind one of the evenly spaced instants.
///
/// The length of a path is not known beforehand: its states are kept at a distance that doubles whenever there are too many.
pub(super) fn wanted(kept: &mut Vec<StoredSnapshot>, state: &State, end: f64) -> bool {
    let instants = (INSTANTS - 1) as f64;
    let time = state.time;
    if state.path.is_some() {
        if kept.len() > 2 * INSTANTS {
            let mut number = 0;
            kept.retain(|_| {
                number += 1;
                number % 2 == 1
            });
        }
        let [first, second, .., last] = kept.as_slice() else { return true };
        return frames::place(state) - last.place >= second.place - first.place;
    }
    let number = |t: f64| (t / end * instants * (1.0 + 1e-9)).floor();
    kept.last().is_none_or(|last| time > last.time && number(time) > number(last.time))
}

/// Whether the last state is missing: it is shown wherever it stands between the evenly spaced instants.
pub(super) fn lacks(kept: &[StoredSnapshot], state: &State) -> bool {
    kept.last().is_none_or(|last| last.place < frames::place(state))
}

/// The instants of the picture: the last state is worth more than one close before it.
pub(super) fn shown(kept: &[StoredSnapshot]) -> Vec<&StoredSnapshot> {
    let mut shown: Vec<&StoredSnapshot> = kept.iter().collect();
    if shown.len() > INSTANTS + 1 {
        // Those of a path.
        let place = |i: usize| i * (kept.len() - 1) / (INSTANTS - 1);
        return (0..INSTANTS).map(|i| &kept[place(i)]).collect();
    }
    if shown.len() > INSTANTS {
        shown.remove(INSTANTS - 1);
    }
    shown
}

/// Keeps a state.
pub(super) fn keep(kept: &mut Vec<StoredSnapshot>, state: &State, values: Vec<f64>) {
    kept.push(StoredSnapshot {
        time: state.time,
        place: frames::place(state),
        displacements: state.u.clone(),
        values,
    });
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
                if wanted(&mut kept, &state(time), 1.0) {
                    keep(&mut kept, &state(time), Vec::new());
                }
            }
            if lacks(&kept, &state(reached)) {
                keep(&mut kept, &state(reached), Vec::new());
            }
            let found: Vec<f64> = shown(&kept).iter().map(|k| (k.time * 100.0).round() / 100.0).collect();
            assert_eq!(found, times);
        }
    }
}
