//! Relative coordinates of joints with friction or stops in a checkpoint: five numbers each.

use tegula::constraint::{CoordinateMode, CoordinateState};

/// Joint, value, whether it is held, place where it is held or direction of motion, and stop.
pub(super) fn numbers(states: &[CoordinateState]) -> Vec<f64> {
    let of_one = |state: &CoordinateState| match state.mode {
        CoordinateMode::Moving(direction) => [state.joint as f64, state.value, 0.0, direction, 0.0],
        CoordinateMode::Held { at, stop } => [state.joint as f64, state.value, 1.0, at, stop],
    };
    states.iter().flat_map(of_one).collect()
}

/// States from their numbers.
pub(super) fn states(numbers: &[f64]) -> Vec<CoordinateState> {
    let of_one = |x: &[f64]| CoordinateState {
        joint: x[0] as usize,
        value: x[1],
        mode: if x[2] == 0.0 {
            CoordinateMode::Moving(x[3])
        } else {
            CoordinateMode::Held { at: x[3], stop: x[4] }
        },
    };
    numbers.chunks_exact(5).map(of_one).collect()
}
