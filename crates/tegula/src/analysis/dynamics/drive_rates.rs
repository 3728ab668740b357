//! Velocities at the ends of steps against the rates of drives.
//!
//! Joints hold positions, not velocities. Those of a scheme that does not damp, `v₁ = 2 Δq/Δt − v₀`, alternate about the rate of a
//! drive: by about Δθ²/6 of it where a step turns a body by Δθ, and by more where the length of the steps changes.

use crate::analysis::State;
use crate::system::System;
use crate::{Error, Result};

/// Part of the largest rate of a drive by which the velocities of a step may miss it before a message says so, and before the
/// velocities are useless.
const MISSED: f64 = 0.1;
const LOST: f64 = 0.5;

/// Number of first steps that are not judged: from rest, the error is as large as the rate.
const FIRST_STEPS: u64 = 20;

/// Message about a driven joint whose velocities miss the rate of its drive.
///
/// # Errors
/// They miss it by half of it.
pub(super) fn check(system: &System, state: &State, conserves: bool) -> Result<Option<String>> {
    if state.step <= FIRST_STEPS {
        return Ok(None);
    }
    let missed = |joint: &crate::constraint::Joint| {
        let missed = system.missed_rate(joint, [&state.u, &state.v], state.time, MISSED)?;
        (missed > MISSED).then(|| (missed, joint.name.clone()))
    };
    let Some((missed, name)) = system.joints.iter().find_map(missed) else { return Ok(None) };
    let other = if conserves { ", or the scheme \"generalized-alpha\"" } else { "" };
    let reason = format!(
        "the velocities miss the rate of the drive \"{name}\" by {:.0} % of its largest one: the steps are long for the motion, and \
         velocities and reactions alternate about their mean",
        100.0 * missed
    );
    if missed <= LOST {
        return Ok(Some(format!("{reason}; take shorter steps{other}")));
    }
    Err(Error::NotConverged {
        at: format!("time {:.6e}", state.time),
        reason,
        help: format!("Results up to the step before are complete. Take shorter steps{other}."),
    })
}
