//! Composition of a step of a symmetric second-order scheme from sub-steps: fourth order.
//!
//! The error of a symmetric scheme has even powers of the step only. Sub-steps of the lengths γ₁Δt … γ₅Δt with `Σγ = 1` and `Σγ³ = 0`
//! therefore leave an error of fourth order (M. Suzuki, *Fractal decomposition of exponential operators*, Phys. Lett. A 146 (1990)
//! 319–323; E. Hairer, C. Lubich, G. Wanner, *Geometric numerical integration*, Sect. II.4). The middle one goes back in time.
//! The step conserves everything that all sub-steps conserve.
//!
//! **Velocities.** With constraints, the velocities of the scheme have a part across them, `M⁻¹Gᵀμ` with `Gᵀ` the directions of
//! constraint forces, that changes its sign from sub-step to sub-step and is of second order. It has no part in the motion, but in the
//! energy. The scheme carries it along ([`State::scheme_v`]); the velocities of the state are without it, the nearest ones in the norm
//! of the kinetic energy that satisfy the constraints. Accelerations and multipliers are those of the equations of index 1 at the
//! end of the step. All are of fourth order.

use super::step_end::Span;
use super::time_steps::{Attempt, TimeSteps, commit, finish, spring_without_force, trouble};
use super::trouble::Trouble;
use super::{constrained_start, impact, project_rates};
use crate::analysis::constraints::Rates;
use crate::analysis::newton::{Cause, Converged, Diverged, Newton};
use crate::analysis::{Observer, State, equilibrium};
use crate::element::Motion;
use crate::system::System;
use crate::{Error, Result};
use tegula_sparse::Factor as _;

/// Suzuki's sub-steps p, p, 1 − 4p, p, p with p = 1/(4 − 4^⅓), over the length of the step.
pub(super) const FOURTH_ORDER: [f64; 5] = [P, P, 1.0 - 4.0 * P, P, P];
const P: f64 = 0.414_490_771_794_375_7;

impl TimeSteps<'_> {
    /// Solves for the ends of all sub-steps and accepts the last one, unless the step has to be repeated shorter.
    pub(super) fn attempt_composed(&mut self, span: Span, observer: &mut dyn Observer) -> Result<Attempt> {
        let mut between = std::mem::take(&mut self.between);
        begin(&self.state, &mut between);
        let converged = self.compose(span, &mut between, observer);
        let outcome = match converged? {
            Err((trouble, reason)) => {
                self.state.next_step = 0.5 * span.dt;
                Ok(Attempt::TooLong(trouble, reason))
            }
            Ok(converged) => {
                swap(&mut self.state, &mut between);
                self.state.last_step = span.dt;
                consistent_end(self.system, &mut self.newton, &mut self.state)?;
                self.accept(span, 0.0, &converged, observer)
            }
        };
        self.between = between;
        outcome
    }

    /// Takes the sub-steps of a step one after another, from and to the state `between` them.
    fn compose(
        &mut self,
        span: Span,
        between: &mut State,
        observer: &mut dyn Observer,
    ) -> Result<std::result::Result<Converged, (Trouble, String)>> {
        let Self { system, scheme, newton, statistics, old_velocities, .. } = self;
        let parts = scheme.sub_steps();
        let mut sum = Converged::default();
        for (i, part) in parts.iter().enumerate() {
            let dt = part * span.dt;
            let end = if i + 1 == parts.len() { span.end } else { between.time + dt };
            let sub = Span { dt, end };
            scheme.begin(system, &mut newton.assembly, between, sub);
            newton.count_turns(system, between);
            let result = newton.solve(system, scheme.as_mut(), &between.history, &self.tolerances, observer);
            statistics.factorizations = newton.solver.factorizations() as u64;
            statistics.linear_iterations = newton.linear_iterations();
            let converged = match result {
                Ok(converged) => converged,
                Err(_) if observer.interrupted() => return Err(Error::Interrupted),
                Err(Diverged { reason, cause, iterations, .. }) => {
                    statistics.iterations += u64::from(iterations);
                    return Ok(Err((Trouble::Iteration(cause), reason)));
                }
            };
            statistics.iterations += u64::from(converged.iterations);
            if let Some(trouble) = trouble(system, between, dt.abs(), scheme.displacements()) {
                return Ok(Err(trouble));
            }
            if let Some(reason) = spring_without_force(system, newton, between, (scheme.displacements(), sub))
            {
                return Ok(Err((Trouble::Iteration(Cause::Flight), reason)));
            }
            finish(system, (scheme.as_mut(), newton), (old_velocities, between), sub);
            if i + 1 < parts.len() {
                commit(system, newton, between);
            }
            let (iterations, tangents) =
                (sum.iterations + converged.iterations, sum.tangents + converged.tangents);
            sum = Converged { iterations, tangents, ..converged };
        }
        Ok(Ok(sum))
    }
}

/// Copies the state at the start of a step to the one between its sub-steps, with the velocities of the scheme.
fn begin(state: &State, between: &mut State) {
    between.u.clone_from(&state.u);
    between.v.clear();
    between.v.extend_from_slice(state.velocities_of_scheme());
    between.a.clone_from(&state.a);
    between.mean_a.clone_from(&state.mean_a);
    between.history.clone_from(&state.history);
    between.multipliers.clone_from(&state.multipliers);
    between.angles.clone_from(&state.angles);
    (between.time, between.last_step) = (state.time, state.last_step);
    (between.work, between.dissipated) = (state.work, state.dissipated);
    between.energy_scale = state.energy_scale;
}

/// Hands the motion between sub-steps over to the state.
fn swap(state: &mut State, between: &mut State) {
    use std::mem::swap;
    swap(&mut state.u, &mut between.u);
    swap(&mut state.v, &mut between.v);
    swap(&mut state.mean_a, &mut between.mean_a);
    swap(&mut state.history, &mut between.history);
    swap(&mut state.angles, &mut between.angles);
    (state.time, state.work, state.dissipated) = (between.time, between.work, between.dissipated);
}

/// Velocities that satisfy the constraints at the end of a step, accelerations and multipliers of the equations of index 1 there. The
/// velocities of the scheme are kept aside.
///
/// # Errors
/// The mass matrix is singular.
fn consistent_end(system: &System, newton: &mut Newton, state: &mut State) -> Result<()> {
    newton.forget(state);
    newton.assembly.follow(system, &state.point_with_rates(system));
    impact::factor_mass(system, newton, state)?;
    if newton.constraints.is_some() || newton.assembly.frames.rotate_with_motion() {
        state.scheme_v.clone_from(&state.v);
        project_velocities(system, newton, state)?;
    }
    state.a.fill([0.0; 3]);
    state.multipliers.fill(0.0);
    system.prescribe_acceleration(state.time, &mut state.a);
    project_rates(system, &state.u, &mut state.v, &mut state.a);
    let rest = equilibrium::unbalanced(system, &mut newton.assembly, state);
    if newton.constraints.is_none() {
        impact::add_free_response(system, newton, &rest, &mut state.a);
    } else {
        constrained_start::add_response(system, newton, &rest, state);
    }
    Ok(())
}

/// Velocities `v = s + P y` next to those of a state in the norm of the mass matrix, which is factored: s are those of prescribed
/// motions, P y the ones of the free degrees of freedom, and joints stay closed.
fn project_velocities(system: &System, newton: &mut Newton, state: &mut State) -> Result<()> {
    let mut supported = vec![[0.0; 3]; system.vectors()];
    system.prescribe_velocity_before(state.time, &mut supported);
    let (mut field, mut impulse) = (state.v.clone(), vec![[0.0; 3]; system.vectors()]);
    for (x, s) in field.as_flattened_mut().iter_mut().zip(supported.as_flattened()) {
        *x -= s;
    }
    system.pattern.add_mass_product(1.0, &field, &mut impulse);
    let Newton { assembly, solver, constraints, .. } = newton;
    let mut free = vec![0.0; system.unknowns()];
    assembly.frames.reduce(&impulse, &mut free);
    solver.solve(&mut free);
    if let Some(constraints) = constraints {
        constrained_start::take_mass(system, assembly, (solver, constraints), state)?;
        let motion = Motion::State { u: &state.u, velocity: None };
        constraints.project(system, (&motion, state.time), Rates::First(&supported), &mut free);
    }
    assembly.frames.expand(&free, &mut field);
    for ((v, x), s) in state.v.iter_mut().zip(&field).zip(&supported) {
        *v = std::array::from_fn(|i| x[i] + s[i]);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::FOURTH_ORDER;

    #[test]
    fn sub_steps_fill_the_step_and_their_cubes_cancel() {
        let sum = |power: i32| FOURTH_ORDER.iter().map(|x| x.powi(power)).sum::<f64>();
        assert!((sum(1) - 1.0).abs() < 1e-15 && sum(3).abs() < 1e-15, "{} {}", sum(1), sum(3));
    }
}
