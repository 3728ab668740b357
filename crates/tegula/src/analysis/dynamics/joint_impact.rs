//! Ends of steps at which a sliding joint comes to rest or reaches a stop: impacts by Newton's law of restitution,
//!
//! ```text
//! M (v⁺ − v⁻) = −Gᵀ Λ,   ṡ⁺ = −e ṡ⁻,   Λ compressive,
//! ```
//!
//! with impulses in all joints. Stops that are closed take part and open where they would pull. Impulses make no friction. The kinetic
//! energy changes by `−½ Σ Λ (ġ⁻ + ġ⁺)`: a stop dissipates `½ (1 − e) ṡ⁻ Λ`, and the rest is work of drives and prescribed motions.
//! A coordinate that comes to rest only for an instant, like the slider of a crank at its dead centre, turns back without an impact.
//! Ch. Glocker, *Set-valued force laws* (2001); F. Pfeiffer, Ch. Glocker, *Multibody dynamics with unilateral contacts* (1996).

use super::joint_events::JointEvents;
use super::joint_modes::{moving, stop_at};
use super::{constrained_start, impact, project_rates, triads};
use crate::Result;
use crate::analysis::State;
use crate::analysis::constraints::Rates;
use crate::analysis::newton::Newton;
use crate::constraint::{CoordinateLaw, CoordinateMode, CoordinateState, Joint};
use crate::element::{Motion, Nodal};
use crate::norm::larger;
use crate::system::System;

/// Velocity behind an impact over that before it, or at the start of the step, below which a coordinate stays at rest.
const STAYS: f64 = 1e-9;
/// Rate of a constraint behind an impact, over the largest one before it, that is round-off; and most attempts to close all.
const CLOSED: f64 = 1e-9;
const MOST_ATTEMPTS: u32 = 3;
/// Effective mass of a coordinate times the square of its rate at the start of the step, over twice the kinetic energy there, up to which
/// friction stops it. It is at most 1 in the configuration at the start.
const STOPPED: f64 = 10.0;

/// A relative coordinate in an impact.
struct Coordinate<'a> {
    joint: &'a Joint,
    law: &'a CoordinateLaw,
    /// Number of its constraint.
    row: usize,
    /// Rates at the start of the step, and before the impact.
    rate_at_start: f64,
    rate: f64,
    /// Stop at which it is held during the impact, 0 for rest; `None` where it is free.
    held: Option<f64>,
    /// Whether it hits its stop.
    hits: bool,
    /// Coefficient of restitution; 0 where it does not hit.
    restitution: f64,
    /// Whether it turns back at once where it comes to rest.
    turns: bool,
}

/// Passes the events at the end of a step: changes velocities, which were `at_start` at the start of the step, and modes, and accounts for
/// the energy. `plastic` impacts are so whatever the coefficient of restitution. Returns the messages.
///
/// # Errors
/// The mass matrix is singular.
pub(super) fn pass(
    system: &System,
    newton: &mut Newton,
    (at_start, state): (&[Nodal], &mut State),
    (events, plastic): (&JointEvents, bool),
) -> Result<Vec<String>> {
    let mut list = coordinates(system, state, (events, plastic));
    let struck = list.iter().any(|c| c.hits);
    newton.forget(state);
    newton.assembly.follow(system, &state.point_with_rates(system));
    impact::factor_mass(system, newton, state)?;
    if !struck {
        turn_back(system, newton, (at_start, state), &mut list)?;
        let stops = |k: usize| list[k].held.is_some() && events.reached(k).is_some();
        if !(0..list.len()).any(stops) {
            settle(system, state, (&list, struck));
            return Ok(Vec::new());
        }
    }
    // Velocities of schemes that conserve energy keep bodies rigid and joints closed up to the error of the step only; here they do so.
    let old = state.v.clone();
    let rigid = rigid_velocities(system, state, &old);
    let held: Vec<_> = list.iter().map(|c| c.held).collect();
    for (c, now) in list.iter_mut().zip(&state.coordinates) {
        c.held = c.held.filter(|_| now.mode.is_held());
    }
    collide(system, newton, state, (&rigid, &list))?;
    let closed = state.v.clone();
    list.iter_mut().zip(held).for_each(|(c, held)| c.held = held);
    for c in &mut list {
        c.rate = system.coordinate_rate(c.joint, c.law, [&state.u, &closed]);
    }
    let impulses = loop {
        let impulses = collide(system, newton, state, (&closed, &list))?;
        let pulls = |c: &&mut Coordinate| !c.hits && c.held.is_some_and(|side| side * impulses[c.row] < 0.0);
        match list.iter_mut().find(pulls).filter(|_| struck) {
            Some(opens) => opens.held = None,
            None => break impulses,
        }
    };
    let State { u, v, a, .. } = state;
    project_rates(system, u, v, a);
    let lost = |c: &Coordinate| 0.5 * (1.0 - c.restitution) * c.rate * impulses[c.row];
    let dissipated: f64 = list.iter().filter(|c| c.held.is_some()).map(lost).sum();
    let loss = system.kinetic_energy(&old) - system.kinetic_energy(&state.v);
    let supplied =
        system.joints.iter().any(|joint| joint.drive.is_some()) || !system.dofs().prescribed.is_empty();
    let of_impacts = if supplied { dissipated } else { loss };
    state.dissipated += of_impacts;
    state.work += of_impacts - loss;
    settle(system, state, (&list, struck));
    let message = |c: &Coordinate| {
        format!(
            "time {:.6e}: the joint \"{}\" hits its stop with the velocity {:.6e}; impacts at this time dissipate {dissipated:.6e}",
            state.time, c.joint.name, c.rate
        )
    };
    Ok(list.iter().filter(|c| c.hits).map(message).collect())
}

/// Coordinates before the impact. One that hits a stop lets all others loose that are held by friction alone.
fn coordinates<'a>(
    system: &'a System,
    state: &State,
    (events, plastic): (&JointEvents, bool),
) -> Vec<Coordinate<'a>> {
    let with_laws = || system.joints.iter().filter_map(|joint| Some((joint, joint.law_row()?)));
    let hits = |k: usize| events.reached(k).is_some_and(|side| side != 0.0);
    let struck = (0..with_laws().count()).any(hits);
    let of = |(k, (joint, (row, law))): (usize, (&'a Joint, (usize, &'a CoordinateLaw)))| {
        let held = match (events.reached(k), state.coordinates[k].mode) {
            (Some(side), _) => Some(side),
            (None, CoordinateMode::Held { stop, .. }) if !struck || stop != 0.0 => Some(stop),
            _ => None,
        };
        Coordinate {
            joint,
            law,
            row,
            rate_at_start: events.rate_before(k),
            rate: system.coordinate_rate(joint, law, [&state.u, &state.v]),
            held,
            hits: hits(k),
            restitution: if plastic || !hits(k) { 0.0 } else { law.restitution },
            turns: false,
        }
    };
    with_laws().enumerate().map(of).collect()
}

/// Finds the coordinates that come to rest only for an instant, like the slider of a crank at its dead centre. Their gradients vanish along
/// the motion of the mechanism: the [effective mass](effective_mass) `1/(g M⁻¹ gᵀ)` becomes infinite, and friction that stops them would
/// stop the whole mechanism. They go on in the other direction.
fn turn_back(
    system: &System,
    newton: &mut Newton,
    (at_start, state): (&[Nodal], &mut State),
    list: &mut [Coordinate],
) -> Result<()> {
    let energy = 2.0 * system.kinetic_energy(at_start);
    let rests = |k: &usize| list[*k].held.is_some() && !state.coordinates[*k].mode.is_held();
    let resting: Vec<_> = (0..list.len()).filter(rests).collect();
    for k in resting {
        let inertia = effective_mass(system, newton, (at_start, state), (list, k))?;
        if !(inertia * list[k].rate_at_start.powi(2) <= STOPPED * energy) {
            (list[k].held, list[k].turns) = (None, true);
        }
    }
    Ok(())
}

/// Impulse that stops a coordinate over its rate, where no friction holds others, found from any velocities along it; infinite where no
/// impulse stops it.
fn effective_mass(
    system: &System,
    newton: &mut Newton,
    (along, state): (&[Nodal], &mut State),
    (list, k): (&mut [Coordinate], usize),
) -> Result<f64> {
    let held: Vec<_> = list.iter().map(|c| c.held).collect();
    list.iter_mut().for_each(|c| c.held = c.held.filter(|side| *side != 0.0));
    list[k].held = None;
    let (joint, law, row) = (list[k].joint, list[k].law, list[k].row);
    let old = state.v.clone();
    let along = rigid_velocities(system, state, along);
    collide(system, newton, state, (&along, list))?;
    let closed = state.v.clone();
    let rate = system.coordinate_rate(joint, law, [&state.u, &closed]);
    list[k].held = Some(0.0);
    let impulse = collide(system, newton, state, (&closed, list))?[row];
    let moves_on = !(system.coordinate_rate(joint, law, [&state.u, &state.v]).abs() < 0.5 * rate.abs());
    state.v.copy_from_slice(&old);
    list.iter_mut().zip(held).for_each(|(c, held)| c.held = held);
    Ok(if moves_on { f64::INFINITY } else { (impulse / rate).abs() })
}

/// Velocities that keep bodies rigid at the displacements of a state.
fn rigid_velocities(system: &System, state: &State, v: &[Nodal]) -> Vec<Nodal> {
    let mut v = v.to_vec();
    triads::project_velocities(system, &state.u, &mut v);
    v
}

/// Changes the velocities from `old` ones by the impulses of all joints, which are returned. The mass matrix is factored.
fn collide(
    system: &System,
    newton: &mut Newton,
    state: &mut State,
    (old, list): (&[Nodal], &[Coordinate]),
) -> Result<Vec<f64>> {
    let mode = |c: &Coordinate, at: f64| {
        c.held.map_or(CoordinateMode::Moving(0.0), |stop| CoordinateMode::Held { at, stop })
    };
    let modes: Vec<CoordinateState> = state
        .coordinates
        .iter()
        .zip(list)
        .map(|(now, c)| CoordinateState { mode: mode(c, now.value), ..*now })
        .collect();
    state.v.copy_from_slice(old);
    if let Some(constraints) = &mut newton.constraints {
        constraints.set_modes(&modes);
        constraints.set_friction(false);
        constraints.begin_step();
    }
    let Newton { assembly, solver, constraints, .. } = newton;
    let Some(constraints) = constraints else { return Ok(Vec::new()) };
    constrained_start::take_mass(system, assembly, (solver, constraints), state)?;
    let motion = Motion::State { u: &state.u, velocity: None };
    let (mut free, mut change) = (vec![0.0; system.unknowns()], vec![[0.0; 3]; old.len()]);
    let mut impulses = vec![0.0; system.constraints()];
    let hits = |row: usize| list.iter().find(|c| c.row == row && c.hits);
    let largest = |rates: &[f64]| {
        let closed = rates.iter().enumerate().filter(|(row, _)| hits(*row).is_none());
        closed.map(|(_, rate)| rate.abs()).fold(0.0, larger)
    };
    let before = largest(constraints.rates(system, (&motion, state.time), Rates::First(old)));
    for attempt in 0..MOST_ATTEMPTS {
        // Behind the first attempt, coordinates that have hit their stops keep their new rates.
        let restitution =
            |row: usize| hits(row).map_or(0.0, |c| if attempt == 0 { c.restitution } else { -1.0 });
        let found = constraints.impact(system, (&motion, state.time), &state.v, restitution, &mut free);
        impulses.iter_mut().zip(found).for_each(|(sum, x)| *sum += x);
        assembly.frames.expand(&free, &mut change);
        super::statics::add(&mut state.v, &change);
        if largest(constraints.rates(system, (&motion, state.time), Rates::First(&state.v)))
            <= CLOSED * before
        {
            break;
        }
        // Constraints that were left out as dependent are open.
        constraints.readmit();
    }
    constraints.set_friction(true);
    Ok(impulses)
}

/// Sets the modes behind an impact.
fn settle(system: &System, state: &mut State, (list, struck): (&[Coordinate], bool)) {
    let fastest = list.iter().map(|c| c.rate.abs()).fold(0.0, larger);
    for (k, c) in list.iter().enumerate() {
        let rate = system.coordinate_rate(c.joint, c.law, [&state.u, &state.v]);
        let now = &mut state.coordinates[k];
        let at = now.value;
        now.mode = match (c.held, now.mode) {
            (None, CoordinateMode::Moving(direction)) if c.turns => CoordinateMode::Moving(-direction),
            (None, CoordinateMode::Moving(_))
                if c.law.has_friction() && rate.abs() <= STAYS * c.rate_at_start.abs() =>
            {
                CoordinateMode::Held { at, stop: stop_at(c.law, at) }
            }
            (Some(_), held @ CoordinateMode::Held { .. }) => held,
            (Some(_), _) if c.restitution == 0.0 => CoordinateMode::Held { at, stop: stop_at(c.law, at) },
            (None, held @ CoordinateMode::Held { .. }) if rate.abs() <= STAYS * fastest => held,
            (None, moves @ CoordinateMode::Moving(_)) if !struck => moves,
            _ => moving(c.law, rate),
        };
    }
}
