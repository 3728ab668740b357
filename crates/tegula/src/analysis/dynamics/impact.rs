//! Impacts: the velocity of a prescribed motion jumps, and the masses coupled to it respond.
//!
//! The equations of motion integrated over the instant of a jump Δv_s of prescribed velocities, in which no other force
//! is infinite, are `M_ff Δv_f + M_fs Δv_s = 0`. Free degrees of freedom next to the prescribed ones therefore take a
//! velocity, too, if a consistent mass matrix couples them. At the start of a motion this is the projection of the
//! given velocities onto the shape functions.
//!
//! Strain-rate damping changes its forces with the velocities at once, and accelerations follow: `M_ff Δa_f = −Δf`.

use super::{constrained_start, project_rates};
use crate::analysis::newton::Newton;
use crate::analysis::{State, equilibrium};
use crate::element::{Motion, Nodal};
use crate::error::{Error, Result};
use crate::model::Scheme;
use crate::system::{EvaluationPoint, System};
use tegula_sparse::Factor;

/// Passes a jump of the velocity or the acceleration of a prescribed motion or a drive at the end of a step, which belongs to the motion before it.
/// Schemes with accelerations of instants start anew behind it: one of the other side would alternate about the right one from then on, and reactions
/// of the other side would do work in the next step. Returns the kinetic energy that an impact supplies.
///
/// # Errors
/// The mass matrix is singular.
pub(super) fn pass_jumps(
    system: &System,
    newton: &mut Newton,
    scheme: Scheme,
    state: &mut State,
) -> Result<f64> {
    let (kink, mean) = (system.has_kink(state.time), scheme.conserves_energy());
    let jump = !mean && system.has_jump_of_acceleration(state.time);
    let mut supplied = 0.0;
    if kink {
        supplied = pass_kink(system, newton, mean, state)?;
    } else if jump {
        take_mass(system, newton, state)?;
    }
    if jump && is_unconstrained(system, newton) {
        share_jump_of_acceleration(system, newton, state);
    }
    if !mean && (kink || jump) {
        start_anew(system, newton, state);
    }
    Ok(supplied)
}

/// Whether no constraint of joints and bodies ties accelerations to velocities.
fn is_unconstrained(system: &System, newton: &Newton) -> bool {
    newton.constraints.is_none() && system.dofs().triads.is_empty()
}

/// Updates velocities, and with them accelerations, from those before a kink of a prescribed motion to those behind it.
/// Mean accelerations of a step (`mean`), which satisfy no equation of an instant, stay. Returns the kinetic energy
/// that the impact supplies.
///
/// # Errors
/// The mass matrix is singular.
fn pass_kink(system: &System, newton: &mut Newton, mean: bool, state: &mut State) -> Result<f64> {
    let before = system.kinetic_energy(state.velocities_of_scheme());
    let old = state.v.clone();
    system.prescribe_velocity(state.time, &mut state.v);
    newton.forget(state);
    newton.assembly.follow(system, &state.point_with_rates(system));
    factor_mass(system, newton, state)?;
    share_jump(system, newton, &old, state);
    constrained_start::project_velocities(system, newton, state)?;
    if !mean && system.has_rate_damping() {
        change_accelerations(system, newton, &old, state);
    }
    for (i, carried) in state.scheme_v.iter_mut().enumerate() {
        (0..3).for_each(|c| carried[c] += state.v[i][c] - old[i][c]);
    }
    Ok(system.kinetic_energy(state.velocities_of_scheme()) - before)
}

/// Changes the accelerations by the response to the change of the internal forces that follows from the change of the
/// velocities from `old` ones; reuses the factor of the mass matrix.
fn change_accelerations(system: &System, newton: &mut Newton, old: &[Nodal], state: &mut State) {
    let (mut behind, mut change) = (vec![[0.0; 3]; old.len()], vec![[0.0; 3]; old.len()]);
    newton.assembly.forces(system, &state.point_with_rates(system), &mut behind);
    let motion = Motion::State { u: &state.u, velocity: Some(old) };
    let k = EvaluationPoint::new(system, motion, state.time, state.internal());
    newton.assembly.forces(system, &k, &mut change);
    for (change, behind) in change.as_flattened_mut().iter_mut().zip(behind.as_flattened()) {
        *change -= behind;
    }
    add_free_response(system, newton, &change, &mut state.a);
    project_rates(system, &state.u, &mut state.v, &mut state.a);
}

/// Starts a scheme anew behind a jump, from the velocities there, which [`pass_kink`] has found, and the accelerations and multipliers that
/// belong to them. Without joints and bodies accelerations do not depend on velocities but through damping, and are there already.
pub(super) fn start_anew(system: &System, newton: &mut Newton, state: &mut State) {
    state.mean_rates.iter_mut().for_each(Vec::clear);
    state.scheme_v.clear();
    state.scheme_loads.clear();
    if is_unconstrained(system, newton) {
        return;
    }
    state.acceleration_lag.clear();
    system.prescribe_acceleration(state.time, &mut state.a);
    project_rates(system, &state.u, &mut state.v, &mut state.a);
    let rest = equilibrium::unbalanced(system, &mut newton.assembly, state);
    if newton.constraints.is_none() {
        add_free_response(system, newton, &rest, &mut state.a);
    } else {
        constrained_start::add_response(system, newton, &rest, state);
    }
}

/// Starts a scheme anew behind a step that is much shorter than the next one, as across a jump of a load. The accelerations and multipliers of
/// BDF2 there are means over both sides of the jump.
///
/// # Errors
/// The mass matrix is singular.
pub(super) fn leave_short_step(system: &System, newton: &mut Newton, state: &mut State) -> Result<()> {
    state.acceleration_lag.clear();
    let constrained = newton.constraints.is_some() || !system.dofs().triads.is_empty();
    if state.scheme_loads.is_empty() || !constrained {
        return Ok(());
    }
    take_mass(system, newton, state)?;
    start_anew(system, newton, state);
    Ok(())
}

/// Takes the factored mass matrix of a state in place of the tangent, also for the constraints.
///
/// # Errors
/// The mass matrix is singular.
pub(super) fn take_mass(system: &System, newton: &mut Newton, state: &mut State) -> Result<()> {
    newton.forget(state);
    newton.assembly.follow(system, &state.point_with_rates(system));
    factor_mass(system, newton, state)?;
    let Newton { assembly, solver, constraints, .. } = newton;
    constraints.as_mut().map_or(Ok(()), |constraints| {
        constrained_start::take_mass(system, assembly, (solver, constraints), state)
    })
}

/// Adds the response of the mass matrix, with its factor, to forces on free degrees of freedom.
pub(super) fn add_free_response(system: &System, newton: &mut Newton, forces: &[Nodal], field: &mut [Nodal]) {
    let mut free = vec![0.0; system.unknowns()];
    newton.assembly.frames.reduce(forces, &mut free);
    newton.solver.solve(&mut free);
    let mut response = vec![[0.0; 3]; forces.len()];
    newton.assembly.frames.expand(&free, &mut response);
    for (x, change) in field.as_flattened_mut().iter_mut().zip(response.as_flattened()) {
        *x += change;
    }
}

/// Factors the mass matrix of a state in the local frames that the assembly follows; with the augmented Lagrangian of
/// constraints.
///
/// # Errors
/// The mass matrix is singular.
pub(super) fn factor_mass(system: &System, newton: &mut Newton, state: &State) -> Result<()> {
    let inertia = if newton.constraints.is_none() {
        let mut mass = vec![0.0; system.pattern.values()];
        newton.assembly.mass_values(system, &mut mass);
        newton.solver.factor(&mass)
    } else {
        constrained_start::assemble_mass(system, newton, state);
        newton.solver.factor(&newton.assembly.values)
    };
    if inertia.is_ok_and(|i| i.negative == 0) {
        return Ok(());
    }
    let rod = system.coordinates.bodies.iter().find(|body| {
        let (_, euler) = body.inertia();
        let moments = euler.symmetric_eigenvalues();
        body.directors.is_some() && moments.iter().filter(|e| **e > 1e-12 * euler.norm()).count() < 2
    });
    Err(match rod {
        Some(body) => Error::Singular {
            what: format!(
                "Body \"{}\" has no inertia about its axis, and no joint keeps it from turning about it.",
                body.name
            ),
            help:
                "Give the body a shape or an inertia with a moment about this axis, or a joint that holds it; of a body \
                 with one attached node the axis is the director, attach another node."
                    .into(),
        },
        None => Error::Singular {
            what: "The mass matrix is singular: some degrees of freedom have no mass.".into(),
            help: "Give every material a density, or the section a `total_mass`.".into(),
        },
    })
}

/// Adds `−M_ff⁻¹ M_fs Δv_s` to the free velocities, with the factor of the mass matrix. Δv_s is the change from the
/// `old` velocities along prescribed degrees of freedom.
pub(super) fn share_jump(system: &System, newton: &mut Newton, old: &[Nodal], state: &mut State) {
    let mut new = old.to_vec();
    system.prescribe_velocity(state.time, &mut new);
    if add_coupled_response(system, newton, [old, &new], &mut state.v) {
        project_rates(system, &state.u, &mut state.v, &mut state.a);
    }
}

/// Changes the accelerations to those behind a jump of the prescribed ones: no force jumps, and the free ones change by `−M_ff⁻¹ M_fs Δa_s`.
fn share_jump_of_acceleration(system: &System, newton: &mut Newton, state: &mut State) {
    let old = state.a.clone();
    system.prescribe_acceleration(state.time, &mut state.a);
    let new = state.a.clone();
    if add_coupled_response(system, newton, [&old, &new], &mut state.a) {
        project_rates(system, &state.u, &mut state.v, &mut state.a);
    }
    state.acceleration_lag.clear();
}

/// Adds `−M_ff⁻¹ M_fs Δ` to the free degrees of freedom of a field of rates, with the factor of the mass matrix, where Δ is the change of the
/// prescribed ones from `old` to `new`. Returns whether there is one.
fn add_coupled_response(
    system: &System,
    newton: &mut Newton,
    [old, new]: [&[Nodal]; 2],
    field: &mut [Nodal],
) -> bool {
    let mut jump = new.to_vec();
    for (jump, old) in jump.as_flattened_mut().iter_mut().zip(old.as_flattened()) {
        *jump -= old;
    }
    if jump.as_flattened().iter().all(|&x| x == 0.0) {
        return false;
    }
    let mut impulse = vec![[0.0; 3]; jump.len()];
    system.pattern.add_mass_product(-1.0, &jump, &mut impulse);
    add_free_response(system, newton, &impulse, field);
    true
}
