//! Consistent start of a motion with joints: velocities that keep them closed, then accelerations and multipliers from the
//! equations of index 1,
//!
//! ```text
//! [ M  Gᵀ ] [ a ]   [ F − f_int ]
//! [ G  0  ] [ λ ] = [ −Ġ v      ].
//! ```

use super::joint_events::speed;
use super::joint_modes::moving;
use super::project_rates;
use crate::analysis::constraints::{Constraints, Rates};
use crate::analysis::direct::Direct;
use crate::analysis::newton::Newton;
use crate::analysis::{State, equilibrium};
use crate::constraint::{CoordinateMode, Joint};
use crate::element::{Motion, Nodal, TangentWeights};
use crate::error::{Error, Result};
use crate::norm::{larger, max_norm};
use crate::system::assembly::TangentCoefficients;
use crate::system::{Assembly, System};

/// Change of the velocities over their size, in the norm of the kinetic energy, that is worth a message.
const NOTEWORTHY: f64 = 1e-6;

/// Value of a constraint over its size above which a joint counts as open.
pub(super) const CLOSED: f64 = 1e-9;

/// Rate of a constraint that no motion makes vanish, over the largest rate of a drive, above which drives contradict each other.
pub(super) const DISAGREED: f64 = 1e-6;

/// Rate of a constraint over its size and the largest velocity or acceleration of the model that is round-off.
const ROUND_OFF: f64 = 1e-12;

/// Weights of the mass matrix with the augmented Lagrangian of the constraints, `M + Gᵀ γ G`.
pub(super) fn mass_weights(system: &System) -> TangentWeights {
    // Bodies without mass move in kinematic analyses, which have no elastic parts.
    let bodies = &system.coordinates.bodies;
    let massless = system.sections.is_empty() && bodies.iter().any(|body| body.mass == 0.0);
    let total = system.total_mass();
    let penalty = if massless { if total > 0.0 { total } else { 1.0 } } else { 0.0 };
    TangentWeights {
        stress: 0.0,
        direction: 0.0,
        force: 0.0,
        rate: 0.0,
        augmentation: 1.0,
        penalty,
        multiplier: 0.0,
    }
}

/// Assembles the mass matrix with the augmented Lagrangian of the constraints at a state.
pub(super) fn assemble_mass(system: &System, newton: &mut Newton, state: &State) {
    let parts = TangentCoefficients { weights: mass_weights(system), mass: 1.0, time: state.time };
    let mut forces = vec![[0.0; 3]; system.vectors()];
    newton.assembly.forces_and_tangent(system, &state.point(system), &parts, false, None, &mut forces);
}

/// Projects the velocities of a state onto those that keep the joints closed, in the norm of the mass matrix, which is
/// factored. Returns the size of the change and that of the velocities before, in the norm of the kinetic energy.
///
/// # Errors
/// The linear solver failed.
pub(super) fn project_velocities(
    system: &System,
    newton: &mut Newton,
    state: &mut State,
) -> Result<Option<[f64; 2]>> {
    let Newton { assembly, solver, constraints, .. } = newton;
    let Some(constraints) = constraints else { return Ok(None) };
    let motion = Motion::State { u: &state.u, velocity: None };
    take_mass(system, assembly, (solver, constraints), state)?;
    let mut free = vec![0.0; system.unknowns()];
    constraints.project(system, (&motion, state.time), Rates::First(&state.v), &mut free);
    let mut change = vec![[0.0; 3]; system.vectors()];
    assembly.frames.expand(&free, &mut change);
    let sizes = [&change, &state.v].map(|v| system.kinetic_energy(v).max(0.0).sqrt());
    super::statics::add(&mut state.v, &change);
    let State { u, v, a, .. } = state;
    project_rates(system, u, v, a);
    Ok(Some(sizes))
}

/// Takes the factored mass matrix of a state as the tangent of its constraints.
///
/// # Errors
/// The linear solver failed.
pub(super) fn take_mass(
    system: &System,
    assembly: &Assembly,
    (solver, constraints): (&mut Direct, &mut Constraints),
    state: &State,
) -> Result<()> {
    let taken =
        constraints.take(system, (&state.point(system), &mass_weights(system)), &assembly.frames, solver);
    taken.map_err(|reason| Error::Singular {
        what: format!("The velocities of the joints were not found: {reason}."),
        help: "Check masses, inertia and joints.".into(),
    })
}

/// Projects the velocities of the first state. Returns messages about what was changed.
///
/// # Errors
/// The linear solver failed, or a joint is open.
pub(super) fn consistent_velocities(
    system: &System,
    newton: &mut Newton,
    state: &mut State,
) -> Result<Messages> {
    newton.count_turns(system, state);
    let motion = Motion::State { u: &state.u, velocity: None };
    let open = newton.constraints.as_ref().and_then(|c| c.violation(system, (&motion, state.time), CLOSED));
    if let Some(open) = open {
        return Err(Error::model(
            "joints",
            format!("{open} at the start"),
            "let the joint connect points that coincide in the reference configuration",
        ));
    }
    let before = system.kinetic_energy(&state.v);
    let Some([changed, size]) = project_velocities(system, newton, state)? else {
        return Ok(Messages::default());
    };
    agreed(system, newton, state, Order::First)?;
    super::joint_events::JointEvents::start(system, state)?;
    if let Some(constraints) = newton.constraints.as_mut().filter(|_| !state.coordinates.is_empty()) {
        constraints.set_modes(&state.coordinates);
        take_mass(system, &newton.assembly, (&mut newton.solver, constraints), state)?;
    }
    let mut messages = Messages::default();
    if system.start.as_ref().is_some_and(|start| !start.v.is_empty()) {
        account_for_impact(system, (before, changed * changed), state);
    }
    messages.note_change(system, [changed, size], [before, system.kinetic_energy(&state.v)]);
    Ok(messages)
}

/// Messages about the first state of an analysis.
#[derive(Debug, Default)]
pub(super) struct Messages {
    pub events: Vec<String>,
    pub warnings: Vec<String>,
}

/// Change of velocities over them, in the norm of the kinetic energy, above which it is a warning.
const LARGE_CHANGE: f64 = 0.01;

impl Messages {
    /// Notes that velocities of a size were changed by that much, in the norm of the kinetic energy, which was and is the given ones.
    pub fn note_change(&mut self, system: &System, [changed, size]: [f64; 2], [before, after]: [f64; 2]) {
        let engaged = engaged(system);
        if !engaged.is_empty() && changed > NOTEWORTHY * size {
            self.events.push(format!(
                "the joint(s) {engaged} stop(s) a motion at the start: a plastic impact dissipates the kinetic energy {:.6e}, of {before:.6e}",
                changed * changed
            ));
        } else if changed > 0.0 && !(size > NOTEWORTHY * changed) {
            self.events.push("the velocities of drives at the start set the model in motion at once".into());
        } else if changed > NOTEWORTHY * size {
            let message = format!(
                "the velocities at the start did not keep the joints closed: they were changed by {:.2} % (in the norm of the kinetic \
                 energy), which goes from {before:.6e} to {after:.6e}",
                100.0 * changed / size
            );
            if changed > LARGE_CHANGE * size {
                self.warnings.push(message)
            } else {
                self.events.push(message)
            }
        }
    }
}

/// Names of the joints with constraints that the step before has not had.
fn engaged(system: &System) -> String {
    let joints = system.joints.iter().filter(|joint| joint.engages);
    joints.map(|joint| format!("\"{}\"", joint.name)).collect::<Vec<_>>().join(", ")
}

/// Counts the impact by which a motion continues with other constraints, in the energies of the first state: the kinetic energy `lost` of
/// the lost velocities is dissipated (Carnot's theorem; plastic impact), and the rest of the change from the kinetic energy `before`,
/// zero without drives, is work of these.
pub(super) fn account_for_impact(system: &System, (before, lost): (f64, f64), state: &mut State) {
    state.dissipated += lost;
    if system.joints.iter().any(|joint| joint.drive.is_some()) {
        state.work += system.kinetic_energy(&state.v) - before + lost;
    }
}

/// Order of the rates of constraints.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Order {
    First,
    Second,
}

/// Refuses drives that contradict each other or other joints: rates of constraints that do not vanish, however the model
/// moves.
///
/// # Errors
/// There are such drives: their names.
pub(super) fn agreed(system: &System, newton: &mut Newton, state: &State, order: Order) -> Result<()> {
    let drives = || {
        system.joints.iter().filter(|joint| joint.drive.is_some()).map(|joint| {
            let drive = system.drive(joint, state.time);
            (joint, if order == Order::First { drive.rate } else { drive.acceleration }.abs())
        })
    };
    let largest = drives().map(|(_, rate)| rate).fold(0.0, larger);
    let Some(constraints) = newton.constraints.as_mut().filter(|_| largest > 0.0) else { return Ok(()) };
    let motion = Motion::State { u: &state.u, velocity: None };
    let smallest = ROUND_OFF * free_rate(system, state, order);
    let rates = match order {
        Order::First => Rates::First(&state.v),
        Order::Second => Rates::Second(&state.v, &state.a),
    };
    let rates = constraints.rates(system, (&motion, state.time), rates);
    let open = |joint: &&Joint| {
        let sizes = joint.rows.iter().map(|row| larger(DISAGREED * largest, smallest * row.size));
        rates[joint.multipliers()].iter().zip(sizes).any(|(r, limit)| !(r.abs() <= limit))
    };
    if !system.joints.iter().any(|joint| open(&joint)) {
        return Ok(());
    }
    let names: Vec<_> =
        drives().filter(|(_, rate)| *rate > 0.0).map(|(joint, _)| format!("\"{}\"", joint.name)).collect();
    Err(Error::model(
        "joints",
        format!(
            "the drives {} contradict each other, or other joints hold what they drive",
            names.join(", ")
        ),
        "leave out drives of the same motion, or joints that prevent it",
    ))
}

/// Velocity of a model, or the acceleration that its loads would give it without joints, whose round-off the rate of a drive that hardly
/// moves is not told from [1/time, 1/time²].
fn free_rate(system: &System, state: &State, order: Order) -> f64 {
    if order == Order::First {
        return speed(system, &state.v);
    }
    let (loads, mass) = (equilibrium::external(system, &state.point(system)), system.total_mass());
    let loaded = if mass > 0.0 { max_norm(loads.as_flattened()) / (mass * system.length) } else { 0.0 };
    larger(speed(system, &state.a), loaded)
}

/// Accelerations and multipliers at the start from the `forces` on all nodal vectors. Coordinates that friction holds move where drives make
/// them: their directions are those of the accelerations without friction.
///
/// # Errors
/// Drives contradict each other, or the linear solver failed.
pub(super) fn accelerate(
    system: &System,
    newton: &mut Newton,
    forces: &[Nodal],
    state: &mut State,
) -> Result<()> {
    let first = (state.a.clone(), state.multipliers.clone());
    add_response(system, newton, forces, state);
    let Err(contradiction) = agreed(system, newton, state, Order::Second) else { return Ok(()) };
    let held: Vec<_> = (0..state.coordinates.len())
        .filter(|&k| matches!(state.coordinates[k].mode, CoordinateMode::Held { stop: 0.0, .. }))
        .collect();
    if held.is_empty() {
        return Err(contradiction);
    }
    for _ in 0..2 {
        // First without friction, then with that of the directions found.
        for &k in &held {
            let c = &mut state.coordinates[k];
            let joint = &system.joints[c.joint];
            let Some((_, law)) = joint.law_row() else { continue };
            c.mode = match c.mode {
                CoordinateMode::Held { .. } => CoordinateMode::Moving(0.0),
                _ => moving(law, system.coordinate_acceleration(joint, law, [&state.u, &state.v, &state.a])),
            };
        }
        let Newton { assembly, solver, constraints, .. } = newton;
        let Some(constraints) = constraints else { break };
        constraints.set_modes(&state.coordinates);
        take_mass(system, assembly, (solver, constraints), state)?;
        state.a.clone_from(&first.0);
        state.multipliers.clone_from(&first.1);
        add_response(system, newton, forces, state);
        agreed(system, newton, state, Order::Second)?;
    }
    Ok(())
}

/// Adds the response of the constrained masses to forces on all nodal vectors to the accelerations of the first state, and
/// corrects the multipliers.
pub(super) fn add_response(system: &System, newton: &mut Newton, forces: &[Nodal], state: &mut State) {
    let Newton { assembly, solver, constraints, .. } = newton;
    let Some(constraints) = constraints else { return };
    let mut free = vec![0.0; system.unknowns()];
    assembly.frames.reduce(forces, &mut free);
    tegula_sparse::Factor::solve(solver, &mut free);
    let motion = Motion::State { u: &state.u, velocity: None };
    let rates = Rates::Second(&state.v, &state.a);
    let given = (rates, state.multipliers.as_slice());
    let multipliers = constraints.project_accelerations(system, (&motion, state.time), given, &mut free);
    // The forces contain those of the multipliers at the end of the step before.
    state.multipliers.iter_mut().zip(multipliers).for_each(|(multiplier, change)| *multiplier += change);
    let mut response = vec![[0.0; 3]; system.vectors()];
    assembly.frames.expand(&free, &mut response);
    super::statics::add(&mut state.a, &response);
}
