//! Central differences with lumped mass in kick–drift–kick form: positions and velocities belong to equal times.
//!
//! ```text
//! v½ = v₀ + ½ Δt a₀
//! u₁ = u₀ + Δt v½
//! M a₁ = F₁ − f(u₁, v½) − α M v₁
//! v₁ = v½ + ½ Δt a₁
//! ```
//!
//! Stable below the critical time step. Strain-rate damping acts with the velocity of the half step, mass damping is
//! implicit. T. Belytschko, W. K. Liu, B. Moran, *Nonlinear Finite Elements for Continua and Structures* (2000), sect.
//! 6.2.
//!
//! It follows that `½ v·M v − ⅛ Δt² a·M a` gains exactly the work that all forces do by the trapezoidal rule. For
//! linear motions that is the work of the strain energy and the loads, so the energy balance without the *swing* term
//! `⅛ Δt² a·M a` is exact whatever the step; its residual is the error of nonlinear motions.
//!
//! [Rigid bodies](super::explicit_bodies) and [joints](super::explicit_joints) have files of their own.

use rayon::prelude::*;

use super::explicit_bodies::Bodies;
use super::explicit_joints::{Projection, Side};
use super::work;
use crate::analysis::State;
use crate::element::{Motion, Nodal};
use crate::norm::larger;
use crate::system::assembly::add_follower_loads;
use crate::system::coordinates::Body;
use crate::system::dof_map::CONSTRAINED;
use crate::system::{Assembly, EvaluationPoint, Internal, LocalFrames, Procedure, System, dot3};
use crate::{Result, Vec3};

/// Smallest number of nodal vectors that one task moves.
const GRAIN: usize = 4096;

/// Explicit integrator with its buffers; nothing is allocated after it is made.
pub(super) struct Explicit<'a> {
    system: &'a System,
    pub(super) assembly: Assembly,
    /// Mass of each nodal vector.
    pub(super) mass: Vec<f64>,
    u_old: Vec<Nodal>,
    /// Velocities at the midpoint of the step.
    middle: Vec<Nodal>,
    /// Loads at the end of the last step, and at its start.
    loads: Vec<Nodal>,
    loads_old: Vec<Nodal>,
    forces: Vec<Nodal>,
    /// Reactions of moving supports at the end of the last step, and at its start; empty without such supports.
    reactions: Vec<Nodal>,
    reactions_old: Vec<Nodal>,
    damped: bool,
    /// Product a·M a of the free degrees of freedom.
    inertia: f64,
    pub(super) bodies: Bodies,
    pub(super) joints: Option<Projection>,
    /// Multipliers at the start of the step, and zeros: forces of elements are those without joints.
    multipliers_old: Vec<f64>,
    without: Vec<f64>,
}

impl<'a> Explicit<'a> {
    /// Integrator for a system that was compiled for explicit integration.
    ///
    /// # Errors
    /// The system was compiled for other analyses.
    pub(super) fn new(system: &'a System) -> Result<Self> {
        system.require(&[Procedure::Explicit])?;
        let n = system.vectors();
        let mut mass = vec![0.0; n];
        system.pattern.for_each_mass(|i, j, m| {
            if i == j {
                mass[i] = m;
            }
        });
        let zero = vec![[0.0; 3]; n];
        let moving = if system.dofs().prescribed.is_empty() { Vec::new() } else { zero.clone() };
        let bodies = Bodies::new(system, &mass);
        Ok(Self {
            joints: Projection::new(system, &mass, &bodies),
            bodies,
            multipliers_old: vec![0.0; system.constraints()],
            without: vec![0.0; system.constraints()],
            system,
            assembly: Assembly::new(system),
            mass,
            u_old: zero.clone(),
            middle: zero.clone(),
            loads: zero.clone(),
            loads_old: zero.clone(),
            forces: zero,
            reactions: moving.clone(),
            reactions_old: moving,
            damped: system.has_rate_damping(),
            inertia: 0.0,
        })
    }

    /// Velocities in the middle of the last step.
    pub(super) fn middle(&self) -> &[Nodal] {
        &self.middle
    }

    /// Adds the accelerations under the unbalanced forces `rest` of a state without multipliers to those of the state; with joints it
    /// gets the multipliers, too.
    pub(super) fn accelerate(&mut self, rest: &[Nodal], state: &mut State) {
        let system = self.system;
        self.stand(state);
        let carried = self.bodies.carried();
        for (v, (a, r)) in state.a.iter_mut().zip(rest).enumerate() {
            if carried.binary_search(&(v as u32)).is_err() {
                let free = free_acceleration(&system.frames, v, *r, self.mass[v]);
                (0..3).for_each(|i| a[i] += free[i]);
            }
        }
        self.bodies.accelerate(system, rest, &mut state.a);
        system.dofs().carry(&mut state.a);
        if let Some(joints) = &mut self.joints {
            joints.constrain_accelerations(system, &self.bodies, state, Side::Behind);
        }
    }

    /// Lets bodies and joints stand where a state is.
    pub(super) fn stand(&mut self, state: &State) {
        self.bodies.take(self.system, &state.u, &state.v);
        if let Some(joints) = &mut self.joints {
            joints.count_turns(self.system, &state.angles);
            joints.take(self.system, &self.bodies, (&state.u, state.time));
        }
    }

    /// Initialises loads, reactions and inertia at the state from which steps start.
    pub(super) fn begin(&mut self, state: &State) {
        self.stand(state);
        self.find_loads(state, false);
        if !self.reactions.is_empty() {
            self.find_forces(state);
            self.find_reactions(state);
        }
        self.inertia = self.free_inertia(&state.a);
    }

    /// One step of length `dt` to the time `end`.
    ///
    /// # Errors
    /// Accelerations are no longer finite; the text gives the place.
    pub(super) fn step(&mut self, state: &mut State, dt: f64, end: f64) -> std::result::Result<(), String> {
        let system = self.system;
        self.u_old.copy_from_slice(&state.u);
        self.multipliers_old.copy_from_slice(&state.multipliers);
        std::mem::swap(&mut self.loads, &mut self.loads_old);
        std::mem::swap(&mut self.reactions, &mut self.reactions_old);
        self.drift(state, dt, end)?;
        let motion = Motion::Step { old: &self.u_old, new: &state.u, dt };
        let step = EvaluationPoint::new(system, motion, end, &state.history);
        if let Some(pole) = self.assembly.pole_in_step(system, &step, end - dt) {
            return Err(pole);
        }

        let velocity = self.damped.then_some(self.middle.as_slice());
        let motion = Motion::State { u: &state.u, velocity };
        let internal = Internal { history: &state.history, multipliers: &self.without };
        let k = EvaluationPoint::new(system, motion, end, internal);
        self.assembly.forces(system, &k, &mut self.forces);
        self.find_loads(state, true);
        self.kick(state, dt);
        self.close_rates(state);
        state.work += self.work_of_drives(state, dt);
        let before = self.inertia;
        self.inertia = self.free_inertia(&state.a);
        if !self.inertia.is_finite() {
            return Err(self.without_finite_acceleration(state));
        }
        state.swing += 0.125 * dt * dt * (self.inertia - before);
        if !self.reactions.is_empty() {
            if self.damped || self.joints.is_some() {
                // Reactions include the forces of joints, and the damping forces of the velocity at the end of the step; that of the half step is
                // unknown where a run is resumed.
                self.find_forces(state);
            }
            self.find_reactions(state);
        }
        self.account(state, dt);
        if system.has_kink(end) || system.has_jump_of_acceleration(end) {
            self.pass_jumps(state);
        }
        Ok(())
    }

    /// Passes a jump of the velocity or the acceleration of a prescribed motion or a drive at the end of a step. What a jump of velocities
    /// changes the kinetic energy by is work of the supports and drives. Lumped masses are not coupled: without joints only prescribed rates
    /// jump.
    fn pass_jumps(&mut self, state: &mut State) {
        let system = self.system;
        if system.has_kink(state.time) {
            let before = system.kinetic_energy(&state.v);
            system.prescribe_velocity(state.time, &mut state.v);
            self.constrain_velocities(state, Side::Behind);
            state.work += system.kinetic_energy(&state.v) - before;
        }
        if let Some(joints) = &mut self.joints {
            joints.release_accelerations(system, &self.bodies, state);
        }
        system.prescribe_acceleration(state.time, &mut state.a);
        self.constrain_accelerations(state, Side::Behind);
        self.inertia = self.free_inertia(&state.a);
        if !self.reactions.is_empty() {
            self.find_forces(state);
            self.find_reactions(state);
        }
    }

    /// Positions at the end of a step, from the velocities at its middle.
    fn drift(&mut self, state: &mut State, dt: f64, end: f64) -> std::result::Result<(), String> {
        let system = self.system;
        let rates = state.v.par_iter().zip(&state.a);
        self.middle.par_iter_mut().zip(rates).with_min_len(GRAIN).for_each(|(middle, (v, a))| {
            *middle = std::array::from_fn(|i| v[i] + 0.5 * dt * a[i]);
        });
        if !self.reactions.is_empty() {
            self.lead_supports(&state.u, dt, end);
        }
        self.bodies.take(system, &state.u, &state.v);
        self.bodies.kick(&state.a, 0.5 * dt);
        state.u.par_iter_mut().zip(&self.middle).with_min_len(GRAIN).for_each(|(u, middle)| {
            (0..3).for_each(|i| u[i] += dt * middle[i]);
        });
        system.prescribe(end, &mut state.u);
        state.time = end;
        for body in 0..self.bodies.len() {
            self.bodies.drift(system, body, dt, &mut state.u)?;
        }
        system.dofs().carry(&mut state.u);
        if let Some(joints) = &mut self.joints {
            joints.count_turns(system, &state.angles);
            let motion = (self.u_old.as_slice(), self.middle.as_mut_slice(), state.u.as_mut_slice());
            joints.close(system, &mut self.bodies, motion, (dt, end))?;
        }
        self.bodies.arrive();
        for &v in self.bodies.carried() {
            let v = v as usize;
            self.middle[v] = std::array::from_fn(|i| (state.u[v][i] - self.u_old[v][i]) / dt);
        }
        let (old, new) = (&self.u_old, &state.u);
        let part = |v: usize, part: f64| std::array::from_fn(|i| old[v][i] + part * (new[v][i] - old[v][i]));
        if let Some(reason) = system.gear_turns_too_far(part, &state.angles) {
            return Err(reason);
        }
        system.continue_angles(part, &mut state.angles);
        Ok(())
    }

    /// Rates at the end of a step that supports and joints allow, before a jump that lies there.
    fn close_rates(&mut self, state: &mut State) {
        let (system, end) = (self.system, state.time);
        if !self.reactions.is_empty() {
            system.prescribe_velocity_before(end, &mut state.v);
            system.prescribe_acceleration_before(end, &mut state.a);
        }
        if let Some(joints) = &mut self.joints {
            joints.take(system, &self.bodies, (&state.u, end));
        }
        self.constrain_velocities(state, Side::Before);
        self.constrain_accelerations(state, Side::Before);
    }

    /// Changes velocities of a state to those that the joints allow.
    fn constrain_velocities(&mut self, state: &mut State, side: Side) {
        if let Some(joints) = &mut self.joints {
            joints.project_velocities(self.system, &self.bodies, state, side);
        }
    }

    /// Changes accelerations of a state to those that the joints allow, and finds its multipliers.
    fn constrain_accelerations(&mut self, state: &mut State, side: Side) {
        let (system, bodies) = (self.system, &self.bodies);
        // Those of bodies depend on the velocities that the joints allow.
        bodies.write_accelerations(system, system.mass_damping, &state.v, &mut state.a);
        if let Some(joints) = &mut self.joints {
            joints.constrain_accelerations(system, bodies, state, side);
        }
    }

    /// Work of the drives of joints in a step.
    fn work_of_drives(&self, state: &State, dt: f64) -> f64 {
        let start = (self.u_old.as_slice(), state.time - dt, self.multipliers_old.as_slice());
        let end = (state.u.as_slice(), state.time, state.multipliers.as_slice());
        self.system.work_of_driven_motions(start, end)
    }

    /// Velocities at the midpoint of the step that bring the supports to their prescribed positions.
    fn lead_supports(&mut self, u: &[Nodal], dt: f64, end: f64) {
        let frames = &self.system.frames;
        // The buffer of the reactions of two steps ago is reused.
        self.reactions.copy_from_slice(u);
        self.system.prescribe(end, &mut self.reactions);
        for (v, (middle, next)) in self.middle.iter_mut().zip(&self.reactions).enumerate() {
            let mut local = frames.to_local(v, *middle);
            let change = frames.to_local(v, std::array::from_fn(|i| (next[i] - u[v][i]) / dt));
            for (c, number) in frames.of(v).into_iter().enumerate() {
                if number == CONSTRAINED {
                    local[c] = change[c];
                }
            }
            *middle = frames.to_global(v, local);
        }
    }

    /// Internal forces of a state.
    fn find_forces(&mut self, state: &State) {
        let velocity = self.damped.then_some(state.v.as_slice());
        let motion = Motion::State { u: &state.u, velocity };
        let k = EvaluationPoint::new(self.system, motion, state.time, state.internal());
        self.assembly.forces(self.system, &k, &mut self.forces);
    }

    /// Loads at a state, with the velocities of the half step before, as those of dampers, or with those of the state.
    fn find_loads(&mut self, state: &State, of_half_step: bool) {
        let Self { loads, middle, system, .. } = self;
        loads.fill([0.0; 3]);
        system.add_dead_loads(state.time, 1.0, loads);
        let velocity = Some(if of_half_step { middle.as_slice() } else { state.v.as_slice() });
        let motion = Motion::State { u: &state.u, velocity };
        add_follower_loads(system, &motion, state.time, 1.0, loads);
    }

    /// Velocities and accelerations at the end of the step from the forces there.
    fn kick(&mut self, state: &mut State, dt: f64) {
        let (frames, alpha) = (&self.system.frames, self.system.mass_damping);
        let damping = 1.0 + 0.5 * dt * alpha;
        let forces = self.forces.par_iter().zip(&self.loads).zip(&self.mass).zip(&self.middle);
        let rates = state.v.par_iter_mut().zip(&mut state.a);
        rates.zip(forces).with_min_len(GRAIN).enumerate().for_each(
            |(n, ((v, a), (((f, load), m), middle)))| {
                let rest = std::array::from_fn(|i| load[i] - f[i]);
                let free = free_acceleration(frames, n, rest, *m);
                for i in 0..3 {
                    v[i] = (middle[i] + 0.5 * dt * free[i]) / damping;
                    a[i] = free[i] - alpha * v[i];
                }
            },
        );
        if !self.bodies.is_empty() {
            let (loads, forces) = (&self.loads, &self.forces);
            let rest = |v: usize| Vec3::from(loads[v]) - Vec3::from(forces[v]);
            self.bodies.kick_by_forces(self.system, rest, (0.5 * dt, damping), &mut state.v);
        }
    }

    /// Product a·M a of the free degrees of freedom.
    fn free_inertia(&self, a: &[Nodal]) -> f64 {
        let frames = &self.system.frames;
        let carried = self.bodies.carried();
        let product = |(v, (a, m)): (usize, (&Nodal, &f64))| {
            if !carried.is_empty() && carried.binary_search(&(v as u32)).is_ok() {
                return 0.0;
            }
            if self.reactions.is_empty() {
                return m * dot3(*a, *a);
            }
            let local = frames.to_local(v, *a);
            let free = |c: &usize| frames.of(v)[*c] != CONSTRAINED;
            m * (0..3).filter(free).map(|c| local[c] * local[c]).sum::<f64>()
        };
        a.iter().zip(&self.mass).enumerate().map(product).sum::<f64>() + self.bodies.inertia(a)
    }

    /// Reactions of a state from its internal forces and loads.
    fn find_reactions(&mut self, state: &State) {
        for (v, f) in self.forces.iter_mut().enumerate() {
            for i in 0..3 {
                let inertia = state.a[v][i] + self.system.mass_damping * state.v[v][i];
                f[i] += self.mass[v] * inertia - self.loads[v][i];
            }
        }
        self.system.frames.constrained_part(&self.forces, &mut self.reactions);
    }

    /// Adds the work and dissipation of the step that ended, and commits the history variables.
    fn account(&mut self, state: &mut State, dt: f64) {
        let (system, end) = (self.system, state.time);
        let trapezoid = |old: &[Nodal], new: &[Nodal]| {
            0.5 * (work(old, &self.u_old, &state.u) + work(new, &self.u_old, &state.u))
        };
        let mut done = 0.0;
        if !system.dead_loads.is_empty() || !system.followers.is_empty() {
            done += trapezoid(&self.loads_old, &self.loads);
            done +=
                system.constant_gravity_potential(&state.u) - system.constant_gravity_potential(&self.u_old);
        }
        if !self.reactions.is_empty() {
            for reactions in [&self.reactions_old, &self.reactions] {
                done += 0.5 * system.work_of_prescribed(reactions, &self.u_old, &state.u);
            }
        }
        let ends = ((self.u_old.as_slice(), end - dt), (state.u.as_slice(), end));
        if system.has_actuators() {
            let motion = Motion::Step { old: &self.u_old, new: &state.u, dt };
            let internal = Internal { history: &state.history, multipliers: &self.without };
            let k = EvaluationPoint::new(system, motion, end - 0.5 * dt, internal);
            done += self.assembly.work_of_actuators(system, &k);
        }
        state.work += done + self.assembly.prescribed_strain_work(system, &state.history, ends.0, ends.1);
        if self.damped || system.mass_damping != 0.0 {
            let motion = Motion::Step { old: &self.u_old, new: &state.u, dt };
            let internal = Internal { history: &state.history, multipliers: &self.without };
            let k = EvaluationPoint::new(system, motion, end, internal);
            let strains = if self.damped { self.assembly.dissipated_power(system, &k) } else { 0.0 };
            state.dissipated +=
                dt * (strains + 2.0 * system.mass_damping * system.kinetic_energy(&self.middle));
        }
        if !state.history.is_empty() {
            let motion = Motion::State { u: &state.u, velocity: None };
            state.dissipated += self.assembly.commit(system, motion, end, &mut state.history);
        }
    }

    /// Message with the place where accelerations are no longer finite.
    fn without_finite_acceleration(&self, state: &State) -> String {
        match self.assembly.without_answer(self.system) {
            Some(element) => format!("the forces of {element} are no longer finite"),
            None => format!("the acceleration of {} is no longer finite", self.fastest(state)),
        }
    }

    /// Rate of the motion of bodies [1/time]: their angular velocity, and their velocity over the length of the model, or the root of these
    /// accelerations, whichever is largest.
    pub(super) fn rate(&self, state: &State) -> f64 {
        let (system, length) = (self.system, self.system.length);
        let of = |body: &Body| {
            let [v, a] =
                [&state.v, &state.a].map(|field| Vec3::from(field[body.centre as usize]).norm() / length);
            larger(v, a.sqrt())
        };
        let bodies = &system.coordinates.bodies;
        bodies.iter().map(of).fold(self.bodies.rate(&state.v, &state.a), larger)
    }

    /// Node whose motion has the largest kinetic energy, or one that is not finite, as text.
    pub(super) fn fastest(&self, state: &State) -> String {
        let energy = |v: usize| {
            let twice = self.mass[v] * dot3(state.v[v], state.v[v]);
            if twice.is_finite() { twice } else { f64::INFINITY }
        };
        let all = 0..self.mass.len();
        let Some(v) = all.reduce(|a, b| if energy(b) > energy(a) { b } else { a }) else {
            return "the model".into();
        };
        self.system.place_name(v)
    }
}

/// Acceleration of a nodal vector under a force, zero along constrained directions.
#[inline]
fn free_acceleration(frames: &LocalFrames, vector: usize, force: Nodal, mass: f64) -> Nodal {
    let mut local = frames.to_local(vector, force);
    for (x, number) in local.iter_mut().zip(frames.of(vector)) {
        *x = if number == CONSTRAINED { 0.0 } else { *x / mass };
    }
    frames.to_global(vector, local)
}
