//! Reasons why a time step is cut back, and what a user can do where even the shortest step fails.

use crate::analysis::newton::Cause;
use crate::model::TransientAnalysis;
use crate::system::System;

/// Reason why a time step is cut back.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Trouble {
    /// Local error above the tolerance.
    Inaccurate,
    /// Inverted element.
    Inverted,
    /// Point that leaves the end of a curve.
    LeavesCurve,
    /// Gain of energy.
    GainsEnergy,
    /// Iteration that does not converge.
    Iteration(Cause),
}

/// Advice for a motion whose cut-backs reach the smallest step: it fits the last failure, and is not in use already.
pub fn advice(system: &System, options: &TransientAnalysis, trouble: Trouble) -> String {
    if options.scheme.is_kinematic() {
        return "The mechanism locks there, or drives contradict each other or other joints. Change the drives, or end the analysis before."
            .into();
    }
    match trouble {
        Trouble::Inverted | Trouble::Iteration(Cause::Material) => {
            return "Look at the loads, the thickness and the material of this element, and at their units."
                .into();
        }
        Trouble::Iteration(Cause::Tangent) => {
            return "Check masses and supports: some degrees of freedom may have neither mass nor stiffness."
                .into();
        }
        Trouble::LeavesCurve => {
            return "Let the curve go on as far as its point moves, or end the analysis before, by `end_time` or a stop condition."
                .into();
        }
        Trouble::GainsEnergy => {
            return "Change the position of joints that lie in one line or plane, or take the scheme \"energy-momentum\" or a smaller \
                    `tolerance`."
                .into();
        }
        Trouble::Inaccurate | Trouble::Iteration(_) => {}
    }
    let mut list = Vec::new();
    if trouble == Trouble::Inaccurate {
        list.push("a larger `tolerance`");
    }
    if !options.scheme.conserves_energy() {
        list.push("the scheme \"energy-momentum\"");
    }
    if system.mass_damping == 0.0 && !system.has_rate_damping() {
        list.push("some damping");
    }
    if trouble != Trouble::Inaccurate && options.time_step.is_none() {
        list.push("a smaller `tolerance`, so that the motion up to there is more accurate");
    }
    list.push("a look at loads, initial velocities and units");
    if system.joints.iter().any(|joint| joint.drive.is_some()) {
        list.push(
            "a look at the drives: beyond a position in which the mechanism locks there is none (the scheme \"kinematic\" finds such positions)",
        );
    }
    format!("Try {}.", list.join(", or "))
}
