//! Automatic time steps from the local error.

use crate::analysis::State;
use crate::model::TransientAnalysis;
use crate::system::System;

/// A step is repeated if its error is this many times the tolerance.
const REJECT: f64 = 2.0;
/// Aim below the tolerance, so that few steps are repeated.
const SAFETY: f64 = 0.9;
/// Largest growth from one step to the next.
const GROWTH: f64 = 1.5;
/// Largest reduction from one step to the next.
const REDUCTION: f64 = 0.3;
/// The step stays, and with it the factor, while the error would change it no more than this.
const KEEP: std::ops::Range<f64> = 0.9..1.4;
/// Tangents above which the step does not grow.
const MANY_TANGENTS: u32 = 10;

/// Chooses time steps so that the local error, root mean square of position over the model's
/// length, stays near the tolerance. The error of a second-order scheme grows with Δt³.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StepControl {
    tolerance: f64,
    fixed: Option<f64>,
    initial: Option<f64>,
    largest: f64,
    end: f64,
}

impl StepControl {
    /// From the options of an analysis.
    pub fn new(options: &TransientAnalysis) -> Self {
        Self {
            tolerance: options.tolerance,
            fixed: options.time_step,
            initial: options.initial_step,
            largest: options.max_step.unwrap_or(options.end_time),
            end: options.end_time,
        }
    }

    /// First step: free motion with the initial acceleration covers the tolerance.
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

    /// True if the error of a step can stand.
    pub fn accepts(&self, error: f64) -> bool {
        self.fixed.is_some() || error <= REJECT * self.tolerance
    }

    /// Length of the next step after one of length `dt` that took so many tangents.
    pub fn next(&self, dt: f64, error: f64, tangents: u32) -> f64 {
        if let Some(fixed) = self.fixed {
            // After a repeated smaller step the wanted one is approached again.
            return fixed.min(2.0 * dt);
        }
        let factor = if error > 0.0 { SAFETY * (self.tolerance / error).cbrt() } else { GROWTH };
        if KEEP.contains(&factor) {
            return dt;
        }
        let growth = if tangents > MANY_TANGENTS { 1.0 } else { GROWTH };
        (dt * factor.clamp(REDUCTION, growth)).min(self.largest)
    }
}
