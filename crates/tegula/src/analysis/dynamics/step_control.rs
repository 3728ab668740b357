//! Automatic time step control by the local truncation error.

use crate::analysis::State;
use crate::model::TransientAnalysis;
use crate::system::System;

/// Multiple of the tolerance above which the error of a step leads to its repetition.
const REJECT: f64 = 2.0;
/// Safety factor on the new step length, so that few steps are repeated.
const SAFETY: f64 = 0.9;
/// Largest growth from one step to the next.
const GROWTH: f64 = 1.5;
/// Largest reduction from one step to the next.
const REDUCTION: f64 = 0.3;
/// Range of the proposed change of the step in which the step, and with it the factor, is kept.
const KEEP: std::ops::Range<f64> = 0.9..1.4;
/// Ratio to the wanted length below which a step counts as shortened by a stop.
const SHORTENED: f64 = 0.999;
/// Number of tangents above which the step does not grow.
const MANY_TANGENTS: u32 = 10;

/// Step control: chooses time steps so that the local error, root mean square of position over the model's length,
/// stays near the tolerance. The error of a second-order scheme grows with Δt³.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StepControl {
    tolerance: f64,
    fixed: Option<f64>,
    initial: Option<f64>,
    largest: f64,
    end: f64,
}

impl StepControl {
    /// Step control from the options of an analysis.
    pub fn new(options: &TransientAnalysis) -> Self {
        Self {
            tolerance: options.tolerance,
            fixed: options.time_step,
            initial: options.initial_step,
            largest: options.max_step.unwrap_or(options.end_time),
            end: options.end_time,
        }
    }

    /// First step: in it free motion with the initial acceleration covers about the tolerance.
    pub fn first(&self, system: &System, state: &State) -> f64 {
        let acceleration = system.position_rms(|v| state.a[v]);
        let velocity = system.position_rms(|v| state.v[v]);
        let mut step = 0.01 * self.end;
        if acceleration > 0.0 {
            step = step.min((self.tolerance / acceleration).sqrt());
        }
        if velocity > 0.0 {
            step = step.min(10.0 * self.tolerance.sqrt() / velocity);
        }
        self.fixed.or(self.initial).unwrap_or(step).min(self.largest)
    }

    /// Whether the error of a step is acceptable.
    pub fn accepts(&self, error: f64) -> bool {
        self.fixed.is_some() || error <= REJECT * self.tolerance
    }

    /// Length of the next step after one of length `dt` that factored `tangents` tangents. The step was `wanted` as
    /// long, or longer where a stop has shortened it.
    pub fn next(&self, dt: f64, wanted: f64, error: f64, tangents: u32) -> f64 {
        if let Some(fixed) = self.fixed {
            // After a cut-back the constant length is approached again.
            return fixed.min(wanted.max(2.0 * dt));
        }
        let factor = if error > 0.0 { SAFETY * (self.tolerance / error).cbrt() } else { f64::INFINITY };
        if dt < SHORTENED * wanted && dt * factor >= wanted {
            return wanted;
        }
        if KEEP.contains(&factor) {
            return dt;
        }
        let growth = if tangents > MANY_TANGENTS { 1.0 } else { GROWTH };
        let limit = if dt < SHORTENED * wanted { f64::INFINITY } else { growth };
        (dt * factor.clamp(REDUCTION, limit)).min(self.largest)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn control() -> StepControl {
        StepControl { tolerance: 1e-5, fixed: None, initial: None, largest: 1.0, end: 10.0 }
    }

    /// The local error goes with Δt³: the next step would have 0.9³ of the tolerance.
    #[test]
    fn the_next_step_aims_below_the_tolerance_with_the_third_power() {
        let c = control();
        for error in [0.6e-5, 1.2e-5, 1.9e-5, 0.22e-5] {
            let next = c.next(0.1, 0.1, error, 1);
            if next != 0.1 {
                let expected = error * (next / 0.1).powi(3);
                assert!((expected / (0.9_f64.powi(3) * 1e-5) - 1.0).abs() < 1e-12, "{error}: {next}");
            }
        }
        assert!(c.next(0.1, 0.1, 1.2e-5, 1) < 0.1 && c.next(0.1, 0.1, 0.22e-5, 1) > 0.14);
    }

    #[test]
    fn steps_keep_their_length_near_the_tolerance_and_change_within_limits() {
        let c = control();
        for error in [0.3e-5, 0.5e-5, 0.99e-5] {
            assert_eq!(c.next(0.1, 0.1, error, 1), 0.1, "{error}");
        }
        assert_eq!(c.next(0.1, 0.1, 0.0, 1), 0.1 * GROWTH);
        assert_eq!(c.next(0.1, 0.1, 1e-12, 1), 0.1 * GROWTH);
        assert_eq!(c.next(0.1, 0.1, 1e-12, 11), 0.1);
        assert_eq!(c.next(0.1, 0.1, 1.0, 1), 0.1 * REDUCTION);
        assert_eq!(c.next(0.9, 0.9, 1e-12, 1), 1.0);
    }

    #[test]
    fn a_step_is_repeated_above_twice_the_tolerance_unless_its_length_is_constant() {
        let c = control();
        assert!(c.accepts(1.99e-5) && !c.accepts(2.01e-5) && !c.accepts(f64::NAN));
        assert!(StepControl { fixed: Some(0.1), ..c }.accepts(1.0));
    }

    #[test]
    fn a_step_that_a_stop_has_shortened_gives_way_to_the_wanted_one() {
        let c = control();
        assert_eq!(c.next(1e-8, 0.1, 1e-30, 1), 0.1);
        // Its error, taken to the wanted length, would be 16 tolerances.
        let next = c.next(0.05, 0.1, 2e-5, 1);
        assert!((next / (0.9 * 0.05 * 0.5_f64.cbrt()) - 1.0).abs() < 1e-12, "{next}");
        let fixed = StepControl { fixed: Some(0.1), ..c };
        assert_eq!(fixed.next(1e-8, 0.1, 1.0, 1), 0.1);
        // After a cut the step grows again.
        assert_eq!(fixed.next(0.025, 0.025, 1.0, 1), 0.05);
    }
}
