//! The energy–momentum scheme.
//!
//! Because the strains are quadratic in the nodal vectors, the discrete force
//!
//! ```text
//! f = S(q_mid)ᵀ H ½ (s₀ + s₁),   q_mid = ½ (q₀ + q₁)
//! ```
//!
//! does exactly the work `½ s₁ᵀHs₁ − ½ s₀ᵀHs₀` over the step. With
//! `M (v₁ − v₀)/Δt + f = F_mid` and `½ (v₀ + v₁) = (q₁ − q₀)/Δt` energy and both momenta are
//! kept for any step that Newton's method can solve. J. C. Simo, N. Tarnow, *The discrete
//! energy-momentum method*, ZAMP 43 (1992) 757–792.
//!
//! The exact tangent `½ S(q_mid)ᵀ H S(q₁)` is slightly unsymmetric; `S(q_mid)` on both sides is
//! symmetric, costs an iteration more and gives the same result.

use super::predictor::predict;
use super::{Exchange, Integrator, copy_supported, step_size, work};
use crate::analysis::State;
use crate::analysis::newton::{Equation, Tolerances};
use crate::analysis::statics::{add, prescribed_increment};
use crate::element::{Kinematics, Motion, Nodal, TangentWeights};
use crate::system::assembly::{TangentParts, add_follower_loads};
use crate::system::{Assembly, System};

/// Conserves energy and momenta.
pub struct EnergyMomentum {
    dt: f64,
    time: f64,
    u: Vec<Nodal>,
    v: Vec<Nodal>,
    u_old: Vec<Nodal>,
    v_old: Vec<Nodal>,
    /// Forces or velocities that only pass through.
    buffer: Vec<Nodal>,
    internal: Vec<Nodal>,
    reaction: Vec<Nodal>,
    a_old: Vec<Nodal>,
    energy_scale: f64,
    mass_damping: f64,
}

impl EnergyMomentum {
    /// For a system.
    pub fn new(system: &System) -> Self {
        let zero = vec![[0.0; 3]; system.vectors()];
        Self {
            dt: 0.0,
            time: 0.0,
            u: zero.clone(),
            v: zero.clone(),
            u_old: zero.clone(),
            v_old: zero.clone(),
            buffer: zero.clone(),
            internal: zero.clone(),
            reaction: zero.clone(),
            a_old: zero,
            energy_scale: 0.0,
            mass_damping: system.mass_damping,
        }
    }

    fn update_rates(&mut self) {
        let factor = 2.0 / self.dt;
        for n in 0..self.u.len() {
            for i in 0..3 {
                self.v[n][i] = factor * (self.u[n][i] - self.u_old[n][i]) - self.v_old[n][i];
            }
        }
    }

    fn mean_acceleration(&self, n: usize) -> Nodal {
        std::array::from_fn(|i| (self.v[n][i] - self.v_old[n][i]) / self.dt)
    }

    fn loads(&self, system: &System, out: &mut [Nodal]) {
        let middle = self.time - 0.5 * self.dt;
        system.add_dead_loads(middle, 1.0, out);
        add_follower_loads(system, &self.kinematics(system), middle, 1.0, out);
    }
}

impl Equation for EnergyMomentum {
    fn kinematics<'a>(&'a self, system: &'a System) -> Kinematics<'a> {
        let motion = Motion::Step { old: &self.u_old, new: &self.u, dt: self.dt };
        Kinematics::new(&system.reference, motion, system.linear, self.time - 0.5 * self.dt)
    }

    fn parts(&self) -> TangentParts {
        TangentParts {
            weights: TangentWeights { stress: 0.5, direction: 0.5, force: 1.0, rate: 1.0 / self.dt },
            mass: 2.0 / (self.dt * self.dt) + self.mass_damping / self.dt,
            time: self.time - 0.5 * self.dt,
        }
    }

    fn rest(&self, system: &System, out: &mut [Nodal]) {
        out.fill([0.0; 3]);
        self.loads(system, out);
        system.pattern.add_mass_product(-1.0 / self.dt, &self.v, out);
        system.pattern.add_mass_product(1.0 / self.dt, &self.v_old, out);
        if system.mass_damping != 0.0 {
            system.pattern.add_mass_product(-system.mass_damping / self.dt, &self.u, out);
            system.pattern.add_mass_product(system.mass_damping / self.dt, &self.u_old, out);
        }
    }

    fn apply(&mut self, _system: &System, increment: &[Nodal]) {
        add(&mut self.u, increment);
        self.update_rates();
    }

    fn prescribed(&self, system: &System, increment: &mut [Nodal]) -> bool {
        prescribed_increment(system, self.time, &self.u, increment)
    }

    fn energy_scale(&self, system: &System, _assembly: &mut Assembly) -> f64 {
        self.energy_scale.max(system.kinetic_energy(&self.v))
    }

    fn displacement_scale(&self, system: &System) -> f64 {
        step_size(system, &self.u_old, &self.u)
    }
}

impl Integrator for EnergyMomentum {
    fn begin(&mut self, system: &System, _assembly: &mut Assembly, state: &State, dt: f64) {
        self.dt = dt;
        self.time = state.time + dt;
        self.u_old.copy_from_slice(&state.u);
        self.v_old.copy_from_slice(&state.v);
        self.a_old.copy_from_slice(&state.a);
        self.energy_scale = state.energy_scale;
        predict(state, dt, &mut self.u);
        copy_supported(system, &state.u, &mut self.u);
        self.update_rates();
    }

    fn displacements(&self) -> &[Nodal] {
        &self.u
    }

    fn finish(&mut self, _system: &System, state: &mut State) {
        for n in 0..self.u.len() {
            state.a[n] = self.mean_acceleration(n);
        }
        state.u.copy_from_slice(&self.u);
        state.v.copy_from_slice(&self.v);
    }

    /// Error of the midpoint rule, Δt³/12 times the rate of the acceleration, from the mean
    /// accelerations of two steps. In the first step the initial acceleration stands for the step before.
    fn local_error(&self, system: &System, state: &State) -> f64 {
        let factor = self.dt.powi(3) / 12.0 / (0.5 * (self.dt + state.last_step));
        system.position_rms(|n| {
            let a = self.mean_acceleration(n);
            std::array::from_fn(|i| factor * (a[i] - self.a_old[n][i]))
        })
    }

    fn exchange(&mut self, system: &System, assembly: &mut Assembly, _state: &State) -> Exchange {
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
        let k = self.kinematics(system);
        let power = assembly.dissipated_power(system, &k)
            + 2.0 * system.mass_damping * system.kinetic_energy(&buffer);
        let mut supports = 0.0;
        if !system.numbering.prescribed.is_empty() {
            // The reaction is what the equation of motion leaves over at the supported coordinates.
            assembly.forces(system, &k, &mut internal);
            self.rest(system, &mut buffer);
            for (f, r) in internal.iter_mut().zip(&buffer) {
                for i in 0..3 {
                    f[i] -= r[i];
                }
            }
            system.numbering.supported_part(&internal, &mut self.reaction);
            supports = work(&self.reaction, &self.u_old, &self.u);
        }
        (self.buffer, self.internal) = (buffer, internal);
        Exchange { work: loads - gravity + supports, dissipated: self.dt * power }
    }

    fn tolerances(&self, max_iterations: u32) -> Tolerances {
        // Energy and momenta are kept to what the iteration leaves over of the forces: go to the rounding floor.
        Tolerances { energy: 1e-20, increment: 1e-8, max_iterations }
    }
}
