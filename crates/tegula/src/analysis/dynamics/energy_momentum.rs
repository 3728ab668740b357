//! Energy–momentum scheme (discrete energy–momentum method).
//!
//! Because the strains are quadratic in the nodal vectors, the discrete force
//!
//! ```text
//! f = B(q_mid)ᵀ H ½ (s₀ + s₁),   q_mid = ½ (q₀ + q₁)
//! ```
//!
//! does exactly the work `½ s₁ᵀHs₁ − ½ s₀ᵀHs₀` over the step. With
//! `M (v₁ − v₀)/Δt + f = F_mid` and `½ (v₀ + v₁) = (q₁ − q₀)/Δt` energy and both momenta are conserved for any step
//! that Newton's method can solve. J. C. Simo, N. Tarnow, *The discrete energy-momentum method*, ZAMP 43 (1992)
//! 757–792.
//!
//! The exact tangent `½ B(q_mid)ᵀ H B(q₁)` is slightly unsymmetric; `B(q_mid)` on both sides is
//! symmetric, costs an iteration more and gives the same result.

use super::composition::FOURTH_ORDER;
use super::predictor::{mean_acceleration, predict};
use super::{
    AT_REST, Integrator, RESOLUTION, Span, StepWork, energy_at_rest, hold_supported, step_size, work,
};
use crate::analysis::State;
use crate::analysis::newton::{Equation, Newton, Tolerances};
use crate::analysis::statics::{add, prescribed_increment};
use crate::element::{Motion, Nodal, TangentWeights};
use crate::system::assembly::{TangentCoefficients, add_follower_loads};
use crate::system::{Assembly, EvaluationPoint, Internal, System};

/// Energy–momentum scheme: conserves energy and momenta.
pub struct EnergyMomentum {
    dt: f64,
    time: f64,
    u: Vec<Nodal>,
    v: Vec<Nodal>,
    /// Mean accelerations of the step, (v₁ − v₀)/Δt.
    a: Vec<Nodal>,
    u_old: Vec<Nodal>,
    v_old: Vec<Nodal>,
    /// Scratch space for forces or velocities.
    buffer: Vec<Nodal>,
    internal: Vec<Nodal>,
    reaction: Vec<Nodal>,
    a_old: Vec<Nodal>,
    energy_scale: f64,
    /// Smallest scale of the increments.
    resolution: f64,
    mass_damping: f64,
    /// Lagrange multipliers of joints: constraint forces of the step.
    multipliers: Vec<f64>,
    /// Whether its steps are sub-steps of composed ones.
    composed: bool,
}

impl EnergyMomentum {
    /// Scheme for a system; `composed` selects steps of fourth order, composed of several.
    pub fn new(system: &System, composed: bool) -> Self {
        let zero = vec![[0.0; 3]; system.vectors()];
        Self {
            dt: 0.0,
            time: 0.0,
            u: zero.clone(),
            v: zero.clone(),
            a: zero.clone(),
            u_old: zero.clone(),
            v_old: zero.clone(),
            buffer: zero.clone(),
            internal: zero.clone(),
            reaction: zero.clone(),
            a_old: zero,
            energy_scale: 0.0,
            resolution: 0.0,
            mass_damping: system.mass_damping,
            multipliers: vec![0.0; system.constraints()],
            composed,
        }
    }

    /// Updates mean accelerations and velocities for a change of displacements, so that ½ (v₀ + v₁) = (u₁ − u₀)/Δt
    /// holds for free degrees of freedom. They are never formed from the difference of displacements: of a step much
    /// shorter than the motion that would leave round-off only.
    ///
    /// Constrained degrees of freedom take the velocities of their motion. The formula above would let an error of
    /// their velocity change its sign from step to step for ever.
    fn change_rates(&mut self, system: &System, change: &[Nodal]) {
        let second = 2.0 / (self.dt * self.dt);
        for (a, change) in self.a.iter_mut().zip(change) {
            (0..3).for_each(|i| a[i] += second * change[i]);
        }
        let frames = &system.frames;
        for prescribed in &frames.dofs().prescribed {
            let (n, c) = prescribed.place();
            let rate = prescribed
                .amplitude
                .map_or(0.0, |i| prescribed.value * system.amplitudes[i].rate_before(self.time));
            let mut local = frames.to_local(n, self.a[n]);
            local[c] = (rate - frames.to_local(n, self.v_old[n])[c]) / self.dt;
            self.a[n] = frames.to_global(n, local);
        }
        for (n, v) in self.v.iter_mut().enumerate() {
            *v = std::array::from_fn(|i| self.v_old[n][i] + self.dt * self.a[n][i]);
        }
        system.prescribe_velocity_before(self.time, &mut self.v);
    }

    /// Work of the reactions over prescribed motions: that of forces over the change of displacement, that of inertia
    /// over Δt ½ (v₀ + v₁), which is the kinetic energy it gives. `internal` are the internal forces.
    fn work_of_supports(&mut self, system: &System, internal: &mut [Nodal], buffer: &mut [Nodal]) -> f64 {
        if system.dofs().prescribed.is_empty() {
            return 0.0;
        }
        // The reaction is the residual of the equation of motion at the constrained degrees of freedom.
        self.external_minus_inertia(system, buffer);
        for (f, r) in internal.iter_mut().zip(buffer.iter()) {
            (0..3).for_each(|i| f[i] -= r[i]);
        }
        let total = system.work_of_prescribed(internal, &self.u_old, &self.u);
        self.reaction.fill([0.0; 3]);
        system.pattern.add_mass_product(1.0, &self.a, &mut self.reaction);
        for (n, slip) in buffer.iter_mut().enumerate() {
            *slip = std::array::from_fn(|i| {
                0.5 * self.dt * (self.v_old[n][i] + self.v[n][i]) - (self.u[n][i] - self.u_old[n][i])
            });
        }
        total + system.product_of_prescribed(&self.reaction, buffer)
    }

    fn loads(&self, system: &System, out: &mut [Nodal]) {
        let middle = self.time - 0.5 * self.dt;
        system.add_dead_loads(middle, 1.0, out);
        add_follower_loads(system, &self.motion(), middle, 1.0, out);
    }
}

impl Equation for EnergyMomentum {
    fn motion(&self) -> Motion<'_> {
        Motion::Step { old: &self.u_old, new: &self.u, dt: self.dt }
    }

    fn parts(&self) -> TangentCoefficients {
        TangentCoefficients {
            weights: TangentWeights {
                stress: 0.5,
                direction: 0.5,
                force: 1.0,
                rate: 1.0 / self.dt,
                augmentation: 2.0 / (self.dt * self.dt),
                penalty: 0.0,
                multiplier: 0.0,
            },
            mass: 2.0 / (self.dt * self.dt) + self.mass_damping / self.dt,
            time: self.time - 0.5 * self.dt,
        }
    }

    fn external_minus_inertia(&self, system: &System, out: &mut [Nodal]) {
        out.fill([0.0; 3]);
        self.loads(system, out);
        system.pattern.add_mass_product(-1.0, &self.a, out);
        if system.mass_damping != 0.0 {
            system.pattern.add_mass_product(-system.mass_damping / self.dt, &self.u, out);
            system.pattern.add_mass_product(system.mass_damping / self.dt, &self.u_old, out);
        }
    }

    fn apply(&mut self, system: &System, increment: &[Nodal]) {
        add(&mut self.u, increment);
        self.change_rates(system, increment);
    }

    fn multipliers(&self) -> &[f64] {
        &self.multipliers
    }

    fn change_multipliers(&mut self, change: &[f64]) {
        self.multipliers.iter_mut().zip(change).for_each(|(x, change)| *x += change);
    }

    fn prescribed(&self, system: &System, increment: &mut [Nodal]) -> bool {
        prescribed_increment(system, self.time, &self.u, increment)
    }

    fn energy_scale(&self, system: &System, _assembly: &mut Assembly, _history: &[f64]) -> f64 {
        self.energy_scale.max(system.kinetic_energy(&self.v))
    }

    fn displacement_scale(&self, system: &System) -> f64 {
        step_size(system, &self.u_old, &self.u).max(self.resolution)
    }
}

impl Integrator for EnergyMomentum {
    fn begin(&mut self, system: &System, _assembly: &mut Assembly, state: &State, span: Span) {
        (self.dt, self.time) = (span.dt, span.end);
        self.u_old.copy_from_slice(&state.u);
        self.v_old.copy_from_slice(&state.v);
        self.a_old.copy_from_slice(&state.a);
        self.multipliers.copy_from_slice(&state.multipliers);
        self.energy_scale = state.energy_scale;
        self.resolution = RESOLUTION * system.norm(&state.u);
        if !system.joints.is_empty() {
            let energy = energy_at_rest(system, self.time, &mut self.buffer);
            self.energy_scale = self.energy_scale.max(energy);
            self.resolution = self.resolution.max(AT_REST);
        }
        predict(state, span.dt, &mut self.u);
        for (n, a) in self.a.iter_mut().enumerate() {
            *a = mean_acceleration(state, n);
        }
        let mut moved = std::mem::take(&mut self.buffer);
        hold_supported(system, &state.u, &mut self.u, &mut moved);
        self.change_rates(system, &moved);
        self.buffer = moved;
    }

    fn displacements(&self) -> &[Nodal] {
        &self.u
    }

    fn velocities(&self) -> &[Nodal] {
        &self.v
    }

    fn finish(&mut self, system: &System, state: &mut State) {
        state.a.copy_from_slice(&self.a);
        state.u.copy_from_slice(&self.u);
        state.v.copy_from_slice(&self.v);
        state.multipliers.copy_from_slice(&self.multipliers);
        if !self.composed && system.is_mechanism() {
            state.middle.resize(self.u.len(), [0.0; 3]);
            for (middle, (old, new)) in state.middle.iter_mut().zip(self.u_old.iter().zip(&self.u)) {
                *middle = std::array::from_fn(|i| 0.5 * (old[i] + new[i]));
            }
        }
    }

    /// Error of the midpoint rule, Δt³/12 times the rate of the acceleration, from the mean accelerations of two steps.
    /// In the first step the initial acceleration replaces that of the step before.
    fn local_error(&mut self, system: &System, _newton: &mut Newton, state: &State) -> f64 {
        let factor = self.dt.powi(3) / 12.0 / (0.5 * (self.dt + state.last_step));
        system.position_rms(|n| std::array::from_fn(|i| factor * (self.a[n][i] - self.a_old[n][i])))
    }

    fn step_work(&mut self, system: &System, assembly: &mut Assembly, state: &State) -> StepWork {
        let mut buffer = std::mem::take(&mut self.buffer);
        let mut internal = std::mem::take(&mut self.internal);
        buffer.fill([0.0; 3]);
        self.loads(system, &mut buffer);
        let loads = work(&buffer, &self.u_old, &self.u);
        let gravity =
            system.constant_gravity_potential(&self.u_old) - system.constant_gravity_potential(&self.u);
        for (n, mean) in buffer.iter_mut().enumerate() {
            *mean = std::array::from_fn(|i| (self.u[n][i] - self.u_old[n][i]) / self.dt);
        }
        let k = EvaluationPoint::new(
            system,
            self.motion(),
            self.parts().time,
            Internal { history: &state.history, multipliers: &self.multipliers },
        );
        let power = assembly.dissipated_power(system, &k)
            + 2.0 * system.mass_damping * system.kinetic_energy(&buffer);
        let actuators = assembly.work_of_actuators(system, &k);
        if !system.dofs().prescribed.is_empty() {
            assembly.forces(system, &k, &mut internal);
        }
        let drives =
            system.work_of_drives([&self.u_old, &self.u], self.parts().time, |i| self.multipliers[i]);
        let supports = self.work_of_supports(system, &mut internal, &mut buffer) + drives;
        (self.buffer, self.internal) = (buffer, internal);
        StepWork {
            work: loads - gravity + supports + actuators,
            dissipated: self.dt * power + system.work_against_laws([&self.u_old, &self.u], &self.multipliers),
        }
    }

    fn sub_steps(&self) -> &'static [f64] {
        if self.composed { &FOURTH_ORDER } else { &[1.0] }
    }

    fn tolerances(&self, max_iterations: u32) -> Tolerances {
        // Energy and momenta are conserved up to the residual of the iteration, which therefore goes down to round-off.
        Tolerances { energy: 1e-20, increment: 1e-8, max_iterations }
    }
}
