//! Kinematic analysis of rigid mechanisms, with inverse dynamics.
//!
//! Positions satisfy the constraints `g(u, t) = 0` of joints and drives, which leave no motion free. From the prediction
//! `u₀ + Δt v₀ + ½ Δt² a₀` Newton's method takes the least increments, in a norm of the masses,
//!
//! ```text
//! δ = −W⁻¹ Gᵀ (G W⁻¹ Gᵀ)⁻¹ g.
//! ```
//!
//! Velocities and accelerations follow from `G v = −∂g/∂t` and `G a = −Ġ v − …`, multipliers from the equations of motion
//! `M a + Gᵀλ = F`: E. J. Haug, *Computer aided kinematics and dynamics of mechanical systems* (1989), Sect. 3.6 and 11.2.

use super::drive_rates::time_of_accelerations;
use super::newmark::Newmark;
use super::{Integrator, Span, StepWork, constrained_start, equilibrium, impact};
use crate::analysis::State;
use crate::analysis::mobility;
use crate::analysis::newton::{Equation, Newton, Tolerances};
use crate::element::{Motion, Nodal, TangentWeights};
use crate::error::{Error, Result};
use crate::norm::larger;
use crate::system::assembly::TangentCoefficients;
use crate::system::{Assembly, System};

/// Difference between a displacement and its integral from the rates, over the way, above which the positions have jumped, and its
/// round-off over the size of the model.
const PART: f64 = 0.1;
const ROUND_OFF: f64 = 1e-8;

/// Positions, rates and multipliers at the end of a step.
pub struct Kinematics {
    /// Displacements, rates and multipliers, with the work of loads and drives.
    end: Newmark,
    /// State at the end of the step, of which the rates are found.
    state: State,
    /// Predicted displacements; behind the estimate of the error scratch space.
    predicted: Vec<Nodal>,
    no_multipliers: Vec<f64>,
    weights: TangentWeights,
    /// Whether no forces act: without masses, loads and springs the multipliers are round-off.
    forceless: bool,
}

impl Kinematics {
    /// Kinematics of a system without elastic parts.
    pub fn new(system: &System) -> Self {
        let zero = vec![[0.0; 3]; system.vectors()];
        let state = State { v: zero.clone(), a: zero.clone(), ..State::at_rest(system) };
        Self {
            end: Newmark::new(system, 0.25, 0.5, 0.0),
            state,
            predicted: zero,
            no_multipliers: vec![0.0; system.constraints()],
            weights: constrained_start::mass_weights(system),
            forceless: system.total_mass() == 0.0 && system.load_sets.is_empty() && !system.has_springs(),
        }
    }
}

impl Equation for Kinematics {
    fn motion(&self) -> Motion<'_> {
        Motion::State { u: &self.end.u, velocity: None }
    }

    fn parts(&self) -> TangentCoefficients {
        TangentCoefficients { weights: self.weights, mass: 1.0, time: self.end.time }
    }

    fn external_minus_inertia(&self, _system: &System, out: &mut [Nodal]) {
        out.fill([0.0; 3]);
    }

    fn apply(&mut self, _system: &System, increment: &[Nodal]) {
        super::statics::add(&mut self.end.u, increment);
    }

    fn multipliers(&self) -> &[f64] {
        &self.no_multipliers
    }

    fn prescribed(&self, system: &System, increment: &mut [Nodal]) -> bool {
        self.end.prescribed(system, increment)
    }

    fn energy_scale(&self, _system: &System, _assembly: &mut Assembly, _history: &[f64]) -> f64 {
        1.0
    }

    /// The size of the model: positions are found to a part of it, however short the step.
    fn displacement_scale(&self, _system: &System) -> f64 {
        1.0
    }
}

impl Integrator for Kinematics {
    fn begin(&mut self, system: &System, _assembly: &mut Assembly, state: &State, span: Span) {
        self.end.a_old.copy_from_slice(&state.a);
        self.end.start(system, state, span);
        for (((u, u_old), v), a) in self.end.u.iter_mut().zip(&state.u).zip(&state.v).zip(&state.a) {
            *u = std::array::from_fn(|i| u_old[i] + span.dt * (v[i] + 0.5 * span.dt * a[i]));
        }
        super::project_unit_vectors(system, &mut self.end.u);
        self.predicted.copy_from_slice(&self.end.u);
        self.state.coordinates.clone_from(&state.coordinates);
        self.state.angles.clone_from(&state.angles);
        self.state.history.clone_from(&state.history);
    }

    fn displacements(&self) -> &[Nodal] {
        &self.end.u
    }

    /// Finds the rates and the multipliers, and compares the displacement with its integral from the rates at both ends (trapezoidal rule,
    /// with the correction of Euler and Maclaurin): behind a jump to another position that the joints admit they do not fit.
    fn interruption(
        &mut self,
        system: &System,
        newton: &mut Newton,
        start: &State,
    ) -> Result<Option<String>> {
        let Self { end, state, .. } = self;
        state.time = time_of_accelerations(system, end.time, end.dt);
        state.u.copy_from_slice(&end.u);
        state.v.fill([0.0; 3]);
        state.a.fill([0.0; 3]);
        state.multipliers.fill(0.0);
        newton.assembly.follow(system, &state.point(system));
        impact::factor_mass(system, newton, state)?;
        constrained_start::project_velocities(system, newton, state)?;
        determined(system, newton, state)?;
        let forces = equilibrium::unbalanced(system, &mut newton.assembly, state);
        constrained_start::add_response(system, newton, &forces, state);
        if self.forceless {
            state.multipliers.fill(0.0);
        }
        newton.forget(state);
        end.v.copy_from_slice(&state.v);
        end.a.copy_from_slice(&state.a);
        end.multipliers.copy_from_slice(&state.multipliers);
        // Where an acceleration jumps, as that of a drive that sets off, the rule without accelerations is the better one.
        let dt = end.dt;
        let mut differences = [0.0, dt * dt / 12.0].map(|weight| {
            for (n, apart) in self.predicted.iter_mut().enumerate() {
                *apart = std::array::from_fn(|i| {
                    let mean = 0.5 * dt * (start.v[n][i] + end.v[n][i]);
                    end.u[n][i] - start.u[n][i] - mean + weight * (end.a[n][i] - start.a[n][i])
                });
            }
            system.norm(&self.predicted)
        });
        differences.sort_by(f64::total_cmp);
        let [apart, _] = differences;
        let [before, behind] = [&start.v, &end.v].map(|field| system.norm(field));
        let way = 0.5 * dt * (before + behind);
        Ok((!(apart <= larger(PART * way, ROUND_OFF))).then(|| {
            "positions at the end of the step do not follow from those at its start: the mechanism would jump, or reaches a position \
             beyond which its drives cannot move it"
                .into()
        }))
    }

    fn finish(&mut self, system: &System, state: &mut State) {
        self.end.finish(system, state);
    }

    /// Distance of the positions from their prediction, which vanishes with Δt³.
    fn local_error(&mut self, system: &System, _newton: &mut Newton, _state: &State) -> f64 {
        let Self { end, predicted, .. } = self;
        system.position_rms(|v| std::array::from_fn(|i| end.u[v][i] - predicted[v][i]))
    }

    fn step_work(&mut self, system: &System, assembly: &mut Assembly, state: &State) -> StepWork {
        self.end.step_work(system, assembly, state)
    }

    fn tolerances(&self, max_iterations: u32) -> Tolerances {
        // Positions follow from constraints alone, no energy from the positions.
        Tolerances { energy: f64::INFINITY, increment: 1e-11, max_iterations }
    }
}

/// Refuses a position in which joints and drives leave motions free: the positions that follow are not determined.
///
/// # Errors
/// The free motions, with their bodies and axes.
pub(super) fn determined(system: &System, newton: &Newton, state: &State) -> Result<()> {
    let independent = newton.constraints.as_ref().map_or(0, |constraints| constraints.independent().count());
    if independent >= system.unknowns() {
        return Ok(());
    }
    let missing = system.unknowns() - independent;
    let free = mobility::free_motions(system, state, Some(missing));
    let at = if state.time > 0.0 {
        format!("time {:.6e}: in this singular position", state.time)
    } else {
        "at the start".into()
    };
    let named = if free.is_empty() { String::new() } else { format!(": {}", free.join("; ")) };
    Err(Error::model(
        "joints",
        format!("{at} joints and drives leave {missing} motion(s) free{named}"),
        "drive them by joints `driven-angle` or `driven-length`, hold them by joints, or use the scheme \"energy-momentum\"",
    ))
}
