//! Predictor of an implicit step: where the iteration begins.
//!
//! ```text
//! u₁ ≈ u₀ + Δt v₀ + ½ Δt² ā,   ā = (v₀ − v₋₁)/Δt₋₁
//! ```
//!
//! with the mean acceleration ā of the step before. The acceleration a₀ itself would spoil the prediction where the
//! scheme has no numerical damping: that of modes far stiffer than the step resolves changes its sign from step to
//! step. The mean is nearly free of these modes. In the first step, and in linear models, whose first increment is
//! exact, it is left out.

use crate::analysis::State;
use crate::element::Nodal;

/// Predicts the displacements at the end of a step of length `dt` from a state.
pub(super) fn predict(state: &State, dt: f64, u: &mut [Nodal]) {
    let half = 0.5 * dt * dt;
    for (n, u) in u.iter_mut().enumerate() {
        let a = mean_acceleration(state, n);
        *u = std::array::from_fn(|i| state.u[n][i] + dt * state.v[n][i] + half * a[i]);
    }
}

/// Mean acceleration of a nodal vector in the step before, used in the prediction.
pub(super) fn mean_acceleration(state: &State, n: usize) -> Nodal {
    state.mean_a.get(n).copied().unwrap_or_default()
}

/// Stores the mean accelerations of a finished step of length `dt`, which began with the velocities `before`.
pub(super) fn remember(before: &[Nodal], dt: f64, state: &mut State) {
    state.mean_a.resize(state.v.len(), [0.0; 3]);
    for ((mean, old), new) in state.mean_a.iter_mut().zip(before).zip(&state.v) {
        *mean = std::array::from_fn(|i| (new[i] - old[i]) / dt);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_constant_acceleration_is_predicted_exactly_whatever_the_steps() {
        let at = |t: f64| [[1.0 - 2.0 * t + 1.5 * t * t, 0.0, -t * t]];
        let rate = |t: f64| [[-2.0 + 3.0 * t, 0.0, -2.0 * t]];
        let mut state = State { u: at(0.3).into(), v: rate(0.3).into(), ..State::default() };
        let mut u = [[0.0; 3]];
        predict(&state, 0.1, &mut u);
        assert!((u[0][0] - (at(0.3)[0][0] + 0.1 * rate(0.3)[0][0])).abs() < 1e-15, "free flight at first");
        remember(&rate(0.1), 0.2, &mut state);
        predict(&state, 0.7, &mut u);
        for i in 0..3 {
            assert!((u[0][i] - at(1.0)[0][i]).abs() < 1e-14, "{u:?}");
        }
    }
}
