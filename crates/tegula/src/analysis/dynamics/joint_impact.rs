//! Ends of steps at which a sliding joint comes to rest or reaches a stop: impacts by Newton's law of restitution,
//!
//! ```text
//! M (v⁺ − v⁻) = −Gᵀ Λ,   ṡ⁺ = −e ṡ⁻,   Λ compressive,
//! ```
//!
//! with impulses in all joints. Stops that are closed take part and open where they would pull. Impulses make no friction.
//! Ch. Glocker, *Set-valued force laws* (2001); F. Pfeiffer, Ch. Glocker, *Multibody dynamics with unilateral contacts* (1996).

use super::joint_events::{moving, stop_at};
use super::{constrained_start, impact, project_rates};
use crate::Result;
use crate::analysis::State;
use crate::analysis::newton::Newton;
use crate::constraint::{CoordinateMode, CoordinateState};
use crate::element::Motion;
use crate::system::System;

/// Velocity behind an impact over that before it, below which a coordinate that friction holds stays at rest.
const STAYS: f64 = 1e-9;

/// Events at the end of a step: for each coordinate the stop reached (−1, 1), 0 where it comes to rest, and whether the impact is plastic
/// whatever the coefficient of restitution. Changes velocities and modes; returns the messages.
///
/// # Errors
/// The mass matrix is singular.
pub(super) fn pass(
    system: &System,
    newton: &mut Newton,
    state: &mut State,
    (reached, plastic): (&[Option<f64>], bool),
) -> Result<Vec<String>> {
    let joints: Vec<_> = system
        .joints
        .iter()
        .filter_map(|joint| joint.law_row().map(|(row, law)| (row, joint, law)))
        .collect();
    let hits = |k: usize| reached[k].is_some_and(|side| side != 0.0);
    let struck = (0..joints.len()).any(hits);
    let old = state.v.clone();
    let before = system.kinetic_energy(&old);
    let rates: Vec<f64> =
        joints.iter().map(|(_, joint, law)| system.coordinate_rate(joint, law, [&state.u, &old])).collect();
    let mut holds: Vec<Option<f64>> = Vec::new();
    for (k, coordinate) in state.coordinates.iter().enumerate() {
        holds.push(match (reached[k], coordinate.mode) {
            (Some(side), _) => Some(side),
            (None, CoordinateMode::Held { stop, .. }) if !struck || stop != 0.0 => Some(stop),
            _ => None,
        });
    }
    let e = |k: usize| if plastic || !hits(k) { 0.0 } else { joints[k].2.restitution };
    loop {
        let modes: Vec<CoordinateState> = state
            .coordinates
            .iter()
            .zip(&holds)
            .map(|(coordinate, hold)| CoordinateState {
                mode: hold.map_or(CoordinateMode::Moving(0.0), |stop| CoordinateMode::Held {
                    at: coordinate.value,
                    stop,
                }),
                ..*coordinate
            })
            .collect();
        state.v.clone_from(&old);
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
        let of_row = |i: usize| joints.iter().position(|(row, ..)| *row == i).map_or(0.0, e);
        let mut free = vec![0.0; system.unknowns()];
        let impulses = constraints.impact(system, (&motion, state.time), &old, of_row, &mut free);
        let pulls =
            |k: &usize| holds[*k].is_some_and(|side| side * impulses[joints[*k].0] < 0.0) && !hits(*k);
        let opened = (0..joints.len()).find(pulls);
        let mut change = vec![[0.0; 3]; old.len()];
        assembly.frames.expand(&free, &mut change);
        constraints.set_friction(true);
        super::statics::add(&mut state.v, &change);
        match opened.filter(|_| struck) {
            Some(k) => holds[k] = None,
            None => break,
        }
    }
    let State { u, v, a, .. } = state;
    project_rates(system, u, v, a);
    let lost = before - system.kinetic_energy(&state.v);
    state.dissipated += lost;
    let fastest = rates.iter().map(|rate| rate.abs()).fold(0.0, crate::norm::larger);
    let mut messages = Vec::new();
    for (k, (_, joint, law)) in joints.iter().enumerate() {
        let rate = system.coordinate_rate(joint, law, [&state.u, &state.v]);
        let coordinate = &mut state.coordinates[k];
        let held = CoordinateMode::Held { at: coordinate.value, stop: stop_at(law, coordinate.value) };
        coordinate.mode = match (holds[k], coordinate.mode) {
            (Some(_), mode @ CoordinateMode::Held { .. }) => mode,
            (Some(_), _) if e(k) == 0.0 => held,
            (None, mode @ CoordinateMode::Held { .. }) if rate.abs() <= STAYS * fastest => mode,
            (_, CoordinateMode::Moving(_)) if !struck && holds[k].is_none() => coordinate.mode,
            _ => moving(law, rate),
        };
        if hits(k) {
            messages.push(format!(
                "time {:.6e}: the joint \"{}\" hits its stop with the velocity {:.6e}; impacts at this time dissipate {lost:.6e}",
                state.time, joint.name, rates[k]
            ));
        }
    }
    Ok(messages)
}
