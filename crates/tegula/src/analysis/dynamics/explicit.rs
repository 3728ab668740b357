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

use rayon::prelude::*;

use super::work;
use crate::Result;
use crate::analysis::State;
use crate::element::{Motion, Nodal};
use crate::system::assembly::add_follower_loads;
use crate::system::dof_map::CONSTRAINED;
use crate::system::{Assembly, EvaluationPoint, LocalFrames, Procedure, System, dot3};

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
        Ok(Self {
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

    /// Adds the free accelerations under the unbalanced forces `rest`.
    pub(super) fn accelerate(&self, rest: &[Nodal], a: &mut [Nodal]) {
        for (v, (a, r)) in a.iter_mut().zip(rest).enumerate() {
            let free = free_acceleration(&self.system.frames, v, *r, self.mass[v]);
            for i in 0..3 {
                a[i] += free[i];
            }
        }
    }

    /// Initialises loads, reactions and inertia at the state from which steps start.
    pub(super) fn begin(&mut self, state: &State) {
        self.find_loads(state);
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
        std::mem::swap(&mut self.loads, &mut self.loads_old);
        std::mem::swap(&mut self.reactions, &mut self.reactions_old);
        let rates = state.v.par_iter().zip(&state.a);
        self.middle.par_iter_mut().zip(rates).with_min_len(GRAIN).for_each(|(middle, (v, a))| {
            *middle = std::array::from_fn(|i| v[i] + 0.5 * dt * a[i]);
        });
        if !self.reactions.is_empty() {
            self.lead_supports(&state.u, dt, end);
        }
        state.u.par_iter_mut().zip(&self.middle).with_min_len(GRAIN).for_each(|(u, middle)| {
            (0..3).for_each(|i| u[i] += dt * middle[i]);
        });
        system.prescribe(end, &mut state.u);
        state.time = end;

        let velocity = self.damped.then_some(self.middle.as_slice());
        let motion = Motion::State { u: &state.u, velocity };
        let k = EvaluationPoint::new(system, motion, end, &state.history);
        self.assembly.forces(system, &k, &mut self.forces);
        self.find_loads(state);
        self.kick(state, dt);
        let before = self.inertia;
        self.inertia = self.free_inertia(&state.a);
        if !self.inertia.is_finite() {
            return Err(self.without_finite_acceleration(state));
        }
        state.swing += 0.125 * dt * dt * (self.inertia - before);
        if !self.reactions.is_empty() {
            system.prescribe_velocity_before(end, &mut state.v);
            system.prescribe_acceleration(end, &mut state.a);
            if system.has_kink(end) {
                // Lumped masses are not coupled: an impact changes prescribed velocities only.
                let before = system.kinetic_energy(&state.v);
                system.prescribe_velocity(end, &mut state.v);
                state.work += system.kinetic_energy(&state.v) - before;
            }
            if self.damped {
                // Reactions include the damping forces of the velocity at the end of the step; that of the half step is
                // unknown where a run is resumed.
                self.find_forces(state);
            }
            self.find_reactions(state);
        }
        self.account(state, dt);
        Ok(())
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
        let k = EvaluationPoint::new(self.system, motion, state.time, &state.history);
        self.assembly.forces(self.system, &k, &mut self.forces);
    }

    /// Loads at a state.
    fn find_loads(&mut self, state: &State) {
        self.loads.fill([0.0; 3]);
        self.system.add_dead_loads(state.time, 1.0, &mut self.loads);
        let motion = Motion::State { u: &state.u, velocity: None };
        add_follower_loads(self.system, &motion, state.time, 1.0, &mut self.loads);
    }

    /// Velocities and accelerations at the end of the step from the forces there.
    fn kick(&self, state: &mut State, dt: f64) {
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
    }

    /// Product a·M a of the free degrees of freedom.
    fn free_inertia(&self, a: &[Nodal]) -> f64 {
        let frames = &self.system.frames;
        let product = |(v, (a, m)): (usize, (&Nodal, &f64))| {
            if self.reactions.is_empty() {
                return m * dot3(*a, *a);
            }
            let local = frames.to_local(v, *a);
            let free = |c: &usize| frames.of(v)[*c] != CONSTRAINED;
            m * (0..3).filter(free).map(|c| local[c] * local[c]).sum::<f64>()
        };
        a.iter().zip(&self.mass).enumerate().map(product).sum()
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
        state.work += done + self.assembly.prescribed_strain_work(system, &state.history, ends.0, ends.1);
        if self.damped || system.mass_damping != 0.0 {
            let motion = Motion::Step { old: &self.u_old, new: &state.u, dt };
            let k = EvaluationPoint::new(system, motion, end, &state.history);
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
        let node = self.system.coordinates.nodes[v];
        let p = self.system.coordinates.position_of[node as usize] as usize;
        let [x, y, z] = self.system.coordinates.reference[p];
        format!("node {} at ({x:.4}, {y:.4}, {z:.4})", self.system.node_label(node))
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
