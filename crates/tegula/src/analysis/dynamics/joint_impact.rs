//! Ends of steps at which a sliding joint comes to rest or reaches a stop: impacts by Newton's law of restitution,
//!
//! ```text
//! M (v⁺ − v⁻) = −Gᵀ Λ,   ṡ⁺ = −e ṡ⁻,   Λ compressive,
//! ```
//!
//! with impulses in all joints. Stops that are closed take part and open where they would pull. Impulses make no friction. The kinetic
//! energy changes by `−½ Σ Λ (ġ⁻ + ġ⁺)`: a stop dissipates `½ (1 − e) ṡ⁻ Λ`, and the rest is work of drives and prescribed motions.
//! Ch. Glocker, *Set-valued force laws* (2001); F. Pfeiffer, Ch. Glocker, *Multibody dynamics with unilateral contacts* (1996).

use super::joint_events::{JointEvents, moving, stop_at};
use super::{constrained_start, impact, project_rates};
use crate::Result;
use crate::analysis::State;
use crate::analysis::newton::Newton;
use crate::constraint::{CoordinateLaw, CoordinateMode, CoordinateState, Joint};
use crate::element::{Motion, Nodal};
use crate::system::System;

/// Velocity behind an impact over that before it, below which a coordinate that friction holds stays at rest.
const STAYS: f64 = 1e-9;

/// A relative coordinate in an impact.
struct Coordinate<'a> {
    joint: &'a Joint,
    law: &'a CoordinateLaw,
    /// Number of its constraint.
    row: usize,
    /// Rate before the impact.
    rate: f64,
    /// Stop at which it is held during the impact, 0 for rest; `None` where it is free.
    held: Option<f64>,
    /// Whether it hits its stop.
    hits: bool,
    /// Coefficient of restitution; 0 where it does not hit.
    restitution: f64,
}

/// Passes the events at the end of a step: changes velocities and modes, and accounts for the energy. `plastic` impacts are so whatever
/// the coefficient of restitution. Returns the messages.
///
/// # Errors
/// The mass matrix is singular.
pub(super) fn pass(
    system: &System,
    newton: &mut Newton,
    state: &mut State,
    (events, plastic): (&JointEvents, bool),
) -> Result<Vec<String>> {
    let mut list = coordinates(system, state, (events, plastic));
    let struck = list.iter().any(|c| c.hits);
    let old = state.v.clone();
    let before = system.kinetic_energy(&old);
    let impulses = loop {
        let impulses = collide(system, newton, state, (&old, &list))?;
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
    state.dissipated += dissipated;
    state.work += system.kinetic_energy(&state.v) - before + dissipated;
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
            rate: system.coordinate_rate(joint, law, [&state.u, &state.v]),
            held,
            hits: hits(k),
            restitution: if plastic || !hits(k) { 0.0 } else { law.restitution },
        }
    };
    with_laws().enumerate().map(of).collect()
}

/// Changes the velocities from `old` ones by the impulses of all joints, which are returned.
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
    newton.forget(state);
    newton.assembly.follow(system, &state.point_with_rates(system));
    if let Some(constraints) = &mut newton.constraints {
        constraints.set_modes(&modes);
        constraints.set_friction(false);
    }
    impact::factor_mass(system, newton, state)?;
    let Newton { assembly, solver, constraints, .. } = newton;
    let Some(constraints) = constraints else { return Ok(Vec::new()) };
    constrained_start::take_mass(system, assembly, (solver, constraints), state)?;
    let motion = Motion::State { u: &state.u, velocity: None };
    let restitution = |row: usize| list.iter().find(|c| c.row == row).map_or(0.0, |c| c.restitution);
    let (mut free, mut change) = (vec![0.0; system.unknowns()], vec![[0.0; 3]; old.len()]);
    let impulses = constraints.impact(system, (&motion, state.time), old, restitution, &mut free).to_vec();
    constraints.set_friction(true);
    assembly.frames.expand(&free, &mut change);
    super::statics::add(&mut state.v, &change);
    Ok(impulses)
}

/// Sets the modes behind an impact.
fn settle(system: &System, state: &mut State, (list, struck): (&[Coordinate], bool)) {
    let fastest = list.iter().map(|c| c.rate.abs()).fold(0.0, crate::norm::larger);
    for (k, c) in list.iter().enumerate() {
        let rate = system.coordinate_rate(c.joint, c.law, [&state.u, &state.v]);
        let now = &mut state.coordinates[k];
        now.mode = match (c.held, now.mode) {
            (Some(_), held @ CoordinateMode::Held { .. }) => held,
            (Some(_), _) if c.restitution == 0.0 => {
                CoordinateMode::Held { at: now.value, stop: stop_at(c.law, now.value) }
            }
            (None, held @ CoordinateMode::Held { .. }) if rate.abs() <= STAYS * fastest => held,
            (None, moves @ CoordinateMode::Moving(_)) if !struck => moves,
            _ => moving(c.law, rate),
        };
    }
}
