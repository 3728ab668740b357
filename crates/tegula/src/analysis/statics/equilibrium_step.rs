//! Step from one equilibrium to the next, by load steps or along a path: what refuses it, and what it does to the state.

use super::{StaticEquation, follower_work, reactions_at};
use crate::Vec3;
use crate::analysis::State;
use crate::element::{Motion, Nodal};
use crate::system::{Assembly, EvaluationPoint, Internal, OffCurve, System};

/// Why the equilibrium of an equation is refused as the one that follows a state, as text: an angle, a curve or a spring may have
/// gone over to another solution.
pub fn refusal(
    system: &System,
    assembly: &Assembly,
    (state, equation): (&State, &StaticEquation),
) -> Option<String> {
    if let Some(reason) = system.angle_turns_too_far([&state.angles, &equation.angles]) {
        return Some(reason);
    }
    if let Some(OffCurve::TooFar(reason) | OffCurve::PastEnd(reason)) =
        system.off_curve(&state.u, &equation.u)
    {
        return Some(reason);
    }
    if let Some(reason) = spring_that_turns_round(system, [&state.u, &equation.u], equation.time) {
        return Some(reason);
    }
    let motion = Motion::Step { old: &state.u, new: &equation.u, dt: f64::INFINITY };
    let step = EvaluationPoint::new(system, motion, equation.time, &state.history);
    assembly.pole_in_step(system, &step, system.time_of_drives(state.time))
}

/// Makes the equilibrium of an equation the state: work of the step, displacements, load factor, multipliers, angles and history. The
/// `reactions` at the last equilibrium, empty where no motion is prescribed, become those of this one; `force` is scratch space.
pub fn take(
    system: &System,
    assembly: &mut Assembly,
    (state, equation): (&mut State, &StaticEquation),
    (force, reactions): (&mut [Nodal], &mut Vec<Nodal>),
) {
    let target = equation.time;
    state.work += follower_work(system, (&state.u, state.time), (&equation.u, target), force);
    if !reactions.is_empty() {
        // Before the history is committed: the stress at the end of the step must be that of the step.
        let internal = Internal { history: &state.history, multipliers: &equation.multipliers };
        let end = EvaluationPoint::at_rest(system, &equation.u, target, internal);
        let after = reactions_at(system, assembly, &end);
        for forces in [&*reactions, &after] {
            state.work += 0.5 * system.work_of_prescribed(forces, &state.u, &equation.u);
        }
        *reactions = after;
    }
    // A step without rates, in the middle of which actuators act.
    let motion = Motion::Step { old: &state.u, new: &equation.u, dt: f64::INFINITY };
    let middle = EvaluationPoint::new(system, motion, 0.5 * (state.time + target), &state.history);
    state.work += assembly.work_of_actuators(system, &middle);
    let before = (state.u.as_slice(), state.time, state.multipliers.as_slice());
    state.work += system.work_of_driven_motions(before, (&equation.u, target, &equation.multipliers));
    state.multipliers.copy_from_slice(&equation.multipliers);
    state.u.copy_from_slice(&equation.u);
    state.time = target;
    state.step += 1;
    let motion = Motion::State { u: &state.u, velocity: None };
    state.dissipated += assembly.commit(system, motion, state.time, &mut state.history);
    state.angles.copy_from_slice(&equation.angles);
}

/// Spring whose direction changes by more than 90° between two configurations, as text: its points may have passed each other, and the
/// equilibrium be that of the other side.
fn spring_that_turns_round(system: &System, u: [&[Nodal]; 2], time: f64) -> Option<String> {
    let at = |u: &[Nodal], v: usize| Vec3::from(system.coordinates.reference[v]) + Vec3::from(u[v]);
    let (name, _) = system
        .springs
        .iter()
        .find(|(_, spring)| spring.turns_round(|v| at(u[0], v), |v| at(u[1], v), time))?;
    Some(format!("the spring \"{name}\" turns by more than 90° in the step, or its points pass each other"))
}
