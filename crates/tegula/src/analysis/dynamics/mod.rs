//! Transient dynamics: consistent start, step control, energy balance; one file per integrator.

mod amplitude_check;
pub mod bdf2;
mod break_away;
mod composition;
mod constrained_start;
pub mod critical_step;
mod difference_energy;
mod drive_rates;
pub mod energy_momentum;
mod energy_watch;
mod explicit;
mod explicit_bodies;
mod explicit_joints;
mod explicit_run;
mod explicit_start;
mod fibre_watch;
mod generalized_alpha;
mod impact;
mod joint_events;
mod joint_impact;
mod joint_modes;
pub mod kinematics;
mod load_watch;
pub mod newmark;
mod predictor;
mod rank_watch;
mod rotation_watch;
pub mod schemes;
pub mod step_control;
mod step_end;
mod stick_slip;
mod time_steps;
mod tracked_coordinate;
pub(crate) mod triads;
mod trouble;

use super::newton::{Equation, Newton, Tolerances};
use super::{Balance, Observer, State, Statistics, Stepper, Stopped, equilibrium, statics, stepper};
use crate::element::{Motion, Nodal};
use crate::model::TransientAnalysis;
use crate::norm::larger;
use crate::system::dof_map::{CONSTRAINED, UnitVector};
use crate::system::{Assembly, Procedure, System, VectorKind, dot, dot3};
use crate::{Error, Result, Vec3};
pub use amplitude_check::{PassedOver, passed_over};
use constrained_start::Messages;
use explicit_run::ExplicitSteps;
pub use step_end::Span;
use time_steps::TimeSteps;

/// Time integration scheme: the equation of a step, its error estimate and its energy account.
///
/// To add a scheme, write a file of [`schemes`] and a line in the registry in `crates/tegula/src/model/scheme.rs`.
pub trait Integrator: Equation + Send {
    /// Starts a step from a state, with a prediction of its end.
    fn begin(&mut self, system: &System, assembly: &mut Assembly, state: &State, span: Span);
    /// Displacements at the present iterate of the end of the step.
    fn displacements(&self) -> &[Nodal];
    /// Velocities at the present iterate of the end of the step; empty for schemes that do not compute friction and stops of joints.
    fn velocities(&self) -> &[Nodal] {
        &[]
    }
    /// Changes the rates at the end of a converged step so that they satisfy the constraints. `newton` has solved the step.
    fn close_rates(&mut self, _system: &System, _newton: &mut Newton) {}
    /// Reason why the end of a converged step does not continue the motion at its start; the step is repeated with half of its length.
    ///
    /// # Errors
    /// The linear solver failed, or constraints do not determine the motion.
    fn interruption(
        &mut self,
        _system: &System,
        _newton: &mut Newton,
        _start: &State,
    ) -> Result<Option<String>> {
        Ok(None)
    }
    /// Writes displacements, velocities and accelerations at the end of a converged step to the state.
    fn finish(&mut self, system: &System, state: &mut State);
    /// Local error: root mean square error of position of the step over the model's length. `newton` has solved the step.
    fn local_error(&mut self, system: &System, newton: &mut Newton, state: &State) -> f64;
    /// External work (of loads other than constant gravity, of actuators, and of prescribed motions) and dissipation of the step.
    fn step_work(&mut self, system: &System, assembly: &mut Assembly, state: &State) -> StepWork;
    /// Energy that dampers would dissipate with the difference between velocities and the mean rates Δu/Δt of the steps, over all steps so far; 0 for
    /// schemes in which both belong together.
    fn unresolved(&self) -> f64 {
        0.0
    }
    /// Lengths of the sub-steps of which a step is composed, over the length of the step.
    fn sub_steps(&self) -> &'static [f64] {
        &[1.0]
    }
    /// Whether a converged step, the first of a motion, is repeated with better start values, which are written to the state.
    fn improves_start(&mut self, _system: &System, _newton: &mut Newton, _state: &mut State) -> bool {
        false
    }
    /// Convergence criteria of its iteration.
    fn tolerances(&self, max_iterations: u32) -> Tolerances;
}

/// External work and dissipation of a step.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct StepWork {
    /// Work of loads other than constant gravity, of actuators, and of prescribed motions.
    pub work: f64,
    /// Energy dissipated by damping.
    pub dissipated: f64,
}

/// Outcome of a transient analysis.
#[derive(Debug, Clone, PartialEq)]
pub struct TransientOutcome {
    /// Final state.
    pub state: State,
    /// Energies and momenta of the final state.
    pub balance: Balance,
    /// Run counters.
    pub statistics: Statistics,
    /// Stop condition at which the analysis has ended; `None` at the end time.
    pub stopped: Option<Stopped>,
}

/// Smallest step over the end time; a run with shorter steps gives up.
const SMALLEST_STEP: f64 = 1e-10;

/// Integrates the motion from `start`, a state of the same analysis (from its first state where `None`).
///
/// # Errors
/// A step did not converge even after cut-backs to the smallest length, the user interrupted, or the observer does not know the
/// column of a stop condition.
pub fn run(
    system: &System,
    options: &TransientAnalysis,
    start: Option<State>,
    observer: &mut dyn Observer,
) -> Result<TransientOutcome> {
    let mut steps = steps(system, options, start)?;
    let stopped = stepper::run(steps.as_mut(), &options.stop, observer)?;
    let (state, balance, statistics) = steps.finish();
    Ok(TransientOutcome { state, balance, statistics, stopped })
}

/// Time steps of a transient analysis from `start`, a state of the same analysis (from its first state where `None`).
///
/// # Errors
/// There is not enough memory, the mass is singular, an amplitude has no value at time 0, or the system was compiled for
/// another analysis.
pub fn steps<'a>(
    system: &'a System,
    options: &'a TransientAnalysis,
    start: Option<State>,
) -> Result<Box<dyn Stepper + 'a>> {
    let explicit = options.scheme.is_explicit();
    system.require(&[if explicit { Procedure::Explicit } else { Procedure::Transient }])?;
    Ok(match options.scheme.integrator(system) {
        Some(scheme) => Box::new(TimeSteps::new(system, options, scheme, start)?),
        None => Box::new(ExplicitSteps::new(system, options, start)?),
    })
}

/// First state of the step with its initial velocities, prescribed values at time 0, and accelerations that satisfy the
/// equations of motion there: `M a = F − f_int − C v`. Returns also what is worth a message.
fn initial_state(system: &System, newton: &mut Newton) -> Result<(State, Messages)> {
    let mut state = initial_motion(system);
    newton.assembly.follow(system, &state.point_with_rates(system));
    impact::factor_mass(system, newton, &state)?;
    impact::share_jump(system, newton, &given_velocities(system), &mut state);
    let messages = constrained_start::consistent_velocities(system, newton, &mut state)?;
    let rest = equilibrium::unbalanced(system, &mut newton.assembly, &state);
    if !rest.as_flattened().iter().all(|force| force.is_finite())
        && let Some(reason) = newton.assembly.reason_without_forces(system, &state.point_with_rates(system))
    {
        return Err(Error::NotConverged {
            at: format!("time {:.6e}", state.time),
            reason,
            help: "Look at the formula, and at the velocities at the start.".into(),
        });
    }
    if newton.constraints.is_none() {
        impact::add_free_response(system, newton, &rest, &mut state.a);
    } else {
        constrained_start::accelerate(system, newton, &rest, &mut state)?;
    }
    state.energy_scale = larger(system.kinetic_energy(&state.v), state.dissipated);
    if system.start.is_some() {
        // A preloaded model may not move at all: round-off is that of its strain energy.
        let strain = newton.assembly.strain_energy(system, &state.point(system));
        state.energy_scale = state.energy_scale.max(strain);
    }
    commit_jump(system, &mut newton.assembly, &mut state);
    Ok((state, messages))
}

/// Commits the history variables of the first state: prescribed strains and motions that jump at time 0 may let
/// materials yield at once, and what this dissipates belongs to the first energies.
fn commit_jump(system: &System, assembly: &mut Assembly, state: &mut State) {
    let motion = Motion::State { u: &state.u, velocity: None };
    state.dissipated += assembly.commit(system, motion, state.time, &mut state.history);
}

/// Velocities before supports act: those in which the step before has ended, and the initial velocities of the model.
fn given_velocities(system: &System) -> Vec<Nodal> {
    let mut given = system.initial_velocity.clone();
    given.resize(system.vectors(), [0.0; 3]);
    if let Some(start) = &system.start {
        statics::add(&mut given, &start.v);
    }
    given
}

/// Displacements and velocities at time 0, and accelerations of constrained degrees of freedom only.
fn initial_motion(system: &System) -> State {
    let n = system.vectors();
    let mut state = State { v: given_velocities(system), a: vec![[0.0; 3]; n], ..State::first(system) };
    // Supports hold from the start: an initial velocity along constrained directions is not possible.
    let mut supported = vec![[0.0; 3]; n];
    system.frames.constrained_part(&state.v, &mut supported);
    for (v, s) in state.v.iter_mut().zip(&supported) {
        for i in 0..3 {
            v[i] -= s[i];
        }
    }
    system.prescribe(0.0, &mut state.u);
    system.prescribe_velocity(0.0, &mut state.v);
    system.prescribe_acceleration(0.0, &mut state.a);
    project_rates(system, &state.u, &mut state.v, &mut state.a);
    state
}

/// Energies and momenta of a state.
pub fn balance(system: &System, assembly: &mut Assembly, state: &State) -> Balance {
    let kinetic = system.kinetic_energy(state.velocities_of_scheme());
    let strain = assembly.strain_energy(system, &state.point(system));
    let potential = system.constant_gravity_potential(&state.u);
    let (momentum, angular_momentum) = system.momentum(&state.u, &state.v);
    Balance {
        kinetic,
        strain,
        potential,
        work: state.work,
        dissipated: state.dissipated,
        total: kinetic + strain + potential + state.dissipated - state.work,
        momentum: momentum.into(),
        angular_momentum: angular_momentum.into(),
    }
}

/// Work of a force over a change of the nodal vectors.
pub(super) fn work(force: &[Nodal], from: &[Nodal], to: &[Nodal]) -> f64 {
    dot(force, to) - dot(force, from)
}

/// Smallest displacement of a step over that of its start to which increments are compared: what is below is round-off, as in
/// a preloaded model at rest.
pub(super) const RESOLUTION: f64 = 1e-10;

/// Displacement over the model's length, and energy over that of the loads along it, below which a mechanism is at rest.
pub(super) const AT_REST: f64 = 1e-8;

/// Energy below which a mechanism is at rest: from that of the loads along the model's length.
pub(super) fn energy_at_rest(system: &System, time: f64, loads: &mut [Nodal]) -> f64 {
    loads.fill([0.0; 3]);
    system.add_dead_loads(time, 1.0, loads);
    AT_REST * system.length * loads.iter().map(|f| dot3(*f, *f).sqrt()).sum::<f64>()
}

/// Norm of the change of the nodal vectors in a step.
pub(super) fn step_size(system: &System, from: &[Nodal], to: &[Nodal]) -> f64 {
    let mut sum = 0.0;
    for (v, kind) in system.coordinates.kinds.iter().enumerate() {
        let d: Nodal = std::array::from_fn(|i| to[v][i] - from[v][i]);
        let s = dot3(d, d);
        sum += if *kind == VectorKind::Position { s / (system.length * system.length) } else { s };
    }
    (sum / from.len().max(1) as f64).sqrt()
}

/// Copies the constrained degrees of freedom of a field: a prediction must not move them.
pub(super) fn copy_supported(system: &System, from: &[Nodal], to: &mut [Nodal]) {
    for (v, to) in to.iter_mut().enumerate() {
        let inextensible = system.coordinates.inextensible.get(v) == Some(&true) && system.dofs().is_free(v);
        if (inextensible && !system.linear) || system.dofs().is_carried(v) {
            continue;
        }
        let old = system.frames.to_local(v, from[v]);
        let mut local = system.frames.to_local(v, *to);
        for (i, number) in system.frames.of(v).into_iter().enumerate() {
            if number == CONSTRAINED {
                local[i] = old[i];
            }
        }
        *to = system.frames.to_global(v, local);
    }
    project_unit_vectors(system, to);
}

/// Resets the constrained degrees of freedom of a prediction to their old values, and finds by how much that moves it.
///
/// Inextensible directors are moved along themselves: round-off across them, divided by the square of a short step,
/// would be an acceleration.
pub(super) fn hold_supported(system: &System, from: &[Nodal], to: &mut [Nodal], moved: &mut [Nodal]) {
    moved.copy_from_slice(to);
    copy_supported(system, from, to);
    for (moved, to) in moved.iter_mut().zip(to.iter()) {
        (0..3).for_each(|i| moved[i] = to[i] - moved[i]);
    }
    if system.linear {
        return;
    }
    triads::keep_stretch(system, to, moved);
    for unit in system.dofs().unit.iter().filter(|unit| unit.fixed.is_none()) {
        let v = unit.vector as usize;
        let d = Vec3::from(system.coordinates.reference[v]) + Vec3::from(to[v]);
        moved[v] = (d * d.dot(&Vec3::from(moved[v]))).into();
    }
}

/// Projects inextensible directors onto their length, and those of rigid bodies onto rotations.
pub(in crate::analysis) fn project_unit_vectors(system: &System, u: &mut [Nodal]) {
    if system.linear {
        return;
    }
    triads::project_directors(system, u);
    for unit in &system.dofs().unit {
        let v = unit.vector as usize;
        let reference = Vec3::from(system.coordinates.reference[v]);
        u[v] = (unit.project(reference + Vec3::from(u[v]), &reference) - reference).into();
    }
}

/// Projection of rates onto the constraint manifold of rigid bodies, and of inextensible directors d: velocities satisfy v·d = 0, and
/// accelerations a·d = −v·v. The drift that the integration of the free vectors leaves would grow from step to step.
pub(super) fn project_rates(system: &System, u: &[Nodal], v: &mut [Nodal], a: &mut [Nodal]) {
    triads::project_rates(system, u, v, a);
    project_rates_of_directors(system, u, v, a);
}

/// An inextensible director without the component in which it is supported: the vector then rotates on a circle, whose radius need not
/// be its length.
pub(super) fn turning_part(system: &System, u: &[Nodal], unit: &UnitVector) -> Vec3 {
    let i = unit.vector as usize;
    let mut d = Vec3::from(system.coordinates.reference[i]);
    if !system.linear {
        d += Vec3::from(u[i]);
    }
    unit.fixed.map_or(d, |axis| d - axis * axis.dot(&d))
}

/// The part of [`project_rates`] for inextensible directors.
pub(super) fn project_rates_of_directors(system: &System, u: &[Nodal], v: &mut [Nodal], a: &mut [Nodal]) {
    for unit in &system.dofs().unit {
        let i = unit.vector as usize;
        let d = turning_part(system, u, unit);
        let (mut rate, mut second) = (Vec3::from(v[i]), Vec3::from(a[i]));
        if let Some(axis) = unit.fixed {
            rate -= axis * axis.dot(&rate);
            second -= axis * axis.dot(&second);
        }
        let radius = d.norm_squared();
        rate -= d * (d.dot(&rate) / radius);
        let inwards = if system.linear { 0.0 } else { rate.norm_squared() };
        second -= d * ((d.dot(&second) + inwards) / radius);
        v[i] = rate.into();
        a[i] = second.into();
    }
}
