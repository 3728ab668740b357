//! Consistent start of explicit steps: velocities that keep joints closed, accelerations and multipliers.

use super::constrained_start::{CLOSED, DISAGREED, Messages, account_for_impact};
use super::explicit::Explicit;
use super::explicit_joints::{Projection, Side};
use crate::analysis::constraints::Rates;
use crate::analysis::{State, equilibrium};
use crate::system::System;
use crate::{Error, Result};

/// Makes a first state consistent: velocities, then accelerations and multipliers.
///
/// # Errors
/// A joint is open, or drives contradict each other.
pub(super) fn start(system: &System, scheme: &mut Explicit, state: &mut State) -> Result<Messages> {
    let mut messages = Messages::default();
    scheme.stand(state);
    if let Some(joints) = &mut scheme.joints {
        let (violation, joint) = joints.violation(system, (&state.u, state.time));
        if let Some(joint) = joint.filter(|_| !(violation <= CLOSED)) {
            return Err(Error::model(
                "joints",
                format!(
                    "joint \"{}\" is open by {violation:.1e} of the model's size at the start",
                    joint.name
                ),
                "let the joint connect points that coincide in the reference configuration",
            ));
        }
        let before = (system.kinetic_energy(&state.v), state.v.clone());
        joints.project_velocities(system, &scheme.bodies, state, Side::Behind);
        agreed(system, joints, state)?;
        let mut change = before.1.clone();
        for (x, v) in change.as_flattened_mut().iter_mut().zip(state.v.as_flattened()) {
            *x = v - *x;
        }
        let sizes = [&change, &before.1].map(|v| system.kinetic_energy(v).max(0.0).sqrt());
        if system.start.as_ref().is_some_and(|start| !start.v.is_empty()) {
            account_for_impact(system, (before.0, sizes[0] * sizes[0]), state);
        }
        messages.note_change(system, sizes, [before.0, system.kinetic_energy(&state.v)]);
        messages.warnings.extend(joints.redundant(system));
        super::project_rates(system, &state.u, &mut state.v, &mut state.a);
    }
    state.multipliers.fill(0.0);
    let rest = equilibrium::unbalanced(system, &mut scheme.assembly, state);
    scheme.accelerate(&rest, state);
    Ok(messages)
}

/// Refuses drives that contradict each other or other joints.
///
/// # Errors
/// There are such drives: the names of the joints.
fn agreed(system: &System, joints: &mut Projection, state: &State) -> Result<()> {
    let largest = Projection::largest_drive(system, state.time);
    if !(largest > 0.0) {
        return Ok(());
    }
    joints.rates(system, (&state.u, state.time), Rates::First(&state.v), Side::Behind);
    let open = joints.contradictory(system, DISAGREED * largest);
    if open.is_empty() {
        return Ok(());
    }
    let names: Vec<String> = open.iter().map(|joint| format!("\"{}\"", joint.name)).collect();
    Err(Error::model(
        "joints",
        format!(
            "the drives contradict each other, or other joints hold what they drive: {} do not close",
            names.join(", ")
        ),
        "leave out drives of the same motion, or joints that prevent it",
    ))
}
