//! Implicit schemes Newmark-β and Hilber–Hughes–Taylor α (HHT).
//!
//! ```text
//! u₁ = u₀ + Δt v₀ + Δt² ((½ − β) a₀ + β a₁)
//! v₁ = v₀ + Δt ((1 − γ) a₀ + γ a₁)
//! M a₁ + (1 − α_f)(C v₁ + f₁ − F₁) + α_f (C v₀ + f₀ − F₀) = 0
//! ```
//!
//! α_f = 0 is Newmark; HHT has α_f = −α, γ = ½ − α, β = (1 − α)²/4.
//! N. M. Newmark, *A method of computation for structural dynamics*, J. Eng. Mech. ASCE 85 (1959) 67–94;
//! H. M. Hilber, T. J. R. Hughes, R. L. Taylor, *Improved numerical dissipation for time integration
//! algorithms in structural dynamics*, Earthquake Eng. Struct. Dyn. 5 (1977) 283–292.
//!
//! **Inextensible directors.** Displacements satisfy d·d = 1 exactly, from which the first line gives the acceleration along the
//! director only to first order. Alone it would be no harm, since the constraint takes it up; but the mass couples a director with
//! the position and with other directors, the more the further the layers lie beside the mesh. The inertia forces
//! therefore take `a·d = −(1 − α_f) v₁·v₁ + α_f a₀·d` in its place, the acceleration of the time at which the forces act.
//!
//! Unconditionally stable for linear problems if 2β ≥ γ ≥ ½; not so for large rotations, where
//! automatic steps or the energy–momentum scheme are needed.

use super::predictor::{mean_acceleration, predict};
use super::{
    AT_REST, Integrator, RESOLUTION, Span, StepWork, energy_at_rest, hold_supported, project_rates,
    project_rates_of_directors, step_size, triads, turning_part, work,
};
use crate::Vec3;
use crate::analysis::State;
use crate::analysis::newton::{Equation, Newton, Tolerances};
use crate::analysis::statics::{add, prescribed_increment};
use crate::element::{Motion, Nodal, TangentWeights};
use crate::system::assembly::{TangentCoefficients, add_follower_loads};
use crate::system::{Assembly, EvaluationPoint, Internal, System};

/// Bound of |e|/|p| over (|δ|/|p|)², with e the error of the iteration, p = ½ Δt² ā the part of the prediction that the
/// acceleration makes, and δ the first increment. The increment is ½ Δt³ j with the rate j of the acceleration, six
/// times the error of the integration, so the iteration adds less than a tenth of that error.
const SHARE: f64 = 1.0 / 60.0;
/// Largest error of the iteration over the acceleration part ½ Δt² ā of the prediction, whatever the first increment.
const LARGEST_PART: f64 = 1e-4;
/// Error of the iteration over the first increment in the very first step, which begins without an acceleration.
const FIRST_STEP: f64 = 1e-7;

/// Methods of an [`Equation`] that has a [`Newmark`] as `newmark` and only other relations of the rates.
macro_rules! forwards_to_newmark {
    () => {
        fn motion(&self) -> Motion<'_> {
            self.newmark.motion()
        }

        fn multipliers(&self) -> &[f64] {
            self.newmark.multipliers()
        }

        fn change_multipliers(&mut self, change: &[f64]) {
            self.newmark.change_multipliers(change);
        }

        fn prescribed(&self, system: &System, increment: &mut [Nodal]) -> bool {
            self.newmark.prescribed(system, increment)
        }

        fn energy_scale(&self, system: &System, assembly: &mut Assembly, history: &[f64]) -> f64 {
            self.newmark.energy_scale(system, assembly, history)
        }

        fn displacement_scale(&self, system: &System) -> f64 {
            self.newmark.displacement_scale(system)
        }

        fn error_limit(&self, first: f64) -> f64 {
            self.newmark.error_limit(first)
        }
    };
}
pub(super) use forwards_to_newmark;

/// Newmark and HHT integrator.
pub struct Newmark {
    pub(super) beta: f64,
    pub(super) gamma: f64,
    alpha_f: f64,
    pub(super) dt: f64,
    pub(super) time: f64,
    pub(super) u: Vec<Nodal>,
    pub(super) v: Vec<Nodal>,
    pub(super) a: Vec<Nodal>,
    /// Velocities and accelerations that satisfy the constraints of inextensible directors; empty if there are none.
    on_constraints: [Vec<Nodal>; 2],
    u_old: Vec<Nodal>,
    v_old: Vec<Nodal>,
    pub(super) a_old: Vec<Nodal>,
    /// External forces minus damping and internal forces at the start of the step; only for α_f ≠ 0.
    old_rest: Vec<Nodal>,
    pub(super) loads_old: Vec<Nodal>,
    /// Scratch space for forces.
    buffer: Vec<Nodal>,
    reaction: Vec<Nodal>,
    supported: Vec<Nodal>,
    energy_scale: f64,
    /// Smallest scale of the increments.
    resolution: f64,
    /// Energy of ½ Δt² ā, the part of the prediction that the mean acceleration ā of the step before makes; `None` in
    /// the first step.
    predicted: Option<f64>,
    damped: bool,
    mass_damping: f64,
    /// Lagrange multipliers of joints.
    pub(super) multipliers: Vec<f64>,
    /// Energy that dampers would dissipate with the difference of velocities and mean rates, over all steps.
    pub(super) unresolved: f64,
}

impl Newmark {
    /// Integrator with parameters β, γ and α_f.
    pub fn new(system: &System, beta: f64, gamma: f64, alpha_f: f64) -> Self {
        let zero = vec![[0.0; 3]; system.vectors()];
        let turning = !system.linear && !system.dofs().unit.is_empty();
        Self {
            on_constraints: if turning { [zero.clone(), zero.clone()] } else { Default::default() },
            beta,
            gamma,
            alpha_f,
            dt: 0.0,
            time: 0.0,
            u: zero.clone(),
            v: zero.clone(),
            a: zero.clone(),
            u_old: zero.clone(),
            v_old: zero.clone(),
            a_old: zero.clone(),
            old_rest: zero.clone(),
            loads_old: zero.clone(),
            buffer: zero.clone(),
            reaction: zero.clone(),
            supported: zero,
            energy_scale: 0.0,
            resolution: 0.0,
            predicted: None,
            damped: system.has_rate_damping(),
            mass_damping: system.mass_damping,
            multipliers: vec![0.0; system.constraints()],
            unresolved: 0.0,
        }
    }

    /// Predicts displacements at the end of the step, with the consistent velocities and accelerations.
    ///
    /// Rates are never formed from the difference of displacements: of a step much shorter than the motion that would
    /// leave round-off only.
    fn predict(&mut self, system: &System, state: &State) {
        let (dt, beta, gamma) = (self.dt, self.beta, self.gamma);
        predict(state, dt, &mut self.u);
        for n in 0..self.u.len() {
            let mean = mean_acceleration(state, n);
            for i in 0..3 {
                let (v0, a0) = (self.v_old[n][i], self.a_old[n][i]);
                let a = (0.5 * mean[i] - (0.5 - beta) * a0) / beta;
                self.a[n][i] = a;
                self.v[n][i] = v0 + dt * ((1.0 - gamma) * a0 + gamma * a);
            }
        }
        let mut moved = std::mem::take(&mut self.buffer);
        hold_supported(system, &state.u, &mut self.u, &mut moved);
        self.change_rates(system, &moved);
        self.buffer = moved;
    }

    /// Updates velocities and accelerations for a change of displacements.
    pub(super) fn change_rates(&mut self, system: &System, change: &[Nodal]) {
        let second = 1.0 / (self.beta * self.dt * self.dt);
        let first = self.gamma / (self.beta * self.dt);
        for ((v, a), change) in self.v.iter_mut().zip(&mut self.a).zip(change) {
            for i in 0..3 {
                v[i] += first * change[i];
                a[i] += second * change[i];
            }
        }
        // Prescribed motions are known exactly, with their rates.
        system.prescribe_velocity_before(self.time, &mut self.v);
        system.prescribe_acceleration_before(self.time, &mut self.a);
        let [v, a] = &mut self.on_constraints;
        if !a.is_empty() {
            v.copy_from_slice(&self.v);
            a.copy_from_slice(&self.a);
            project_rates_of_directors(system, &self.u, v, a);
            for unit in system.dofs().unit.iter().filter(|_| self.alpha_f != 0.0) {
                let (i, d) = (unit.vector as usize, turning_part(system, &self.u, unit));
                let change = Vec3::from(self.a_old[i]) - Vec3::from(a[i]);
                a[i] = (Vec3::from(a[i]) + d * (self.alpha_f * d.dot(&change) / d.norm_squared())).into();
            }
        }
    }

    /// Accelerations of the inertia forces.
    fn accelerations(&self) -> &[Nodal] {
        let [_, a] = &self.on_constraints;
        if a.is_empty() { &self.a } else { a }
    }

    /// Starts a step from a state and the accelerations `a_old`, which are set before, with a prediction of its end.
    pub(super) fn start(&mut self, system: &System, state: &State, span: Span) {
        (self.dt, self.time) = (span.dt, span.end);
        self.u_old.copy_from_slice(&state.u);
        self.v_old.copy_from_slice(&state.v);
        self.multipliers.copy_from_slice(&state.multipliers);
        self.energy_scale = state.energy_scale;
        self.resolution = RESOLUTION * system.norm(&state.u);
        if !system.joints.is_empty() {
            let energy = energy_at_rest(system, self.time, &mut self.buffer);
            self.energy_scale = self.energy_scale.max(energy);
            self.resolution = self.resolution.max(AT_REST);
        }
        self.loads_old.fill([0.0; 3]);
        let mut loads = std::mem::take(&mut self.loads_old);
        self.loads(system, state.time, (&state.u, &state.v), &mut loads);
        self.loads_old = loads;
        self.predicted = (!state.mean_a.is_empty())
            .then(|| span.dt * span.dt / (2.0 * self.beta) * system.kinetic_energy(&state.mean_a));
        self.predict(system, state);
    }

    /// External minus inertia forces of these accelerations.
    pub(super) fn external_minus_inertia_of(
        &self,
        system: &System,
        accelerations: &[Nodal],
        out: &mut [Nodal],
    ) {
        let share = 1.0 - self.alpha_f;
        out.fill([0.0; 3]);
        self.loads(system, self.time, (&self.u, &self.v), out);
        for (o, old) in out.iter_mut().zip(&self.old_rest) {
            for i in 0..3 {
                o[i] = share * o[i] + self.alpha_f * old[i];
            }
        }
        system.pattern.add_mass_product(-1.0, accelerations, out);
        system.pattern.add_mass_product(-share * system.mass_damping, &self.v, out);
    }

    /// External minus inertia forces at the end of the step, with a weight on the mean of the loads at both ends, and minus the loads
    /// `before`.
    pub(super) fn weighted_external_minus_inertia(
        &self,
        system: &System,
        (weight, before): (f64, impl Fn(usize) -> Nodal),
        out: &mut [Nodal],
    ) {
        self.mean_loads(system, out);
        for (n, o) in out.iter_mut().enumerate() {
            let before = before(n);
            *o = std::array::from_fn(|i| weight * o[i] - before[i]);
        }
        system.pattern.add_mass_product(-1.0, self.accelerations(), out);
        system.pattern.add_mass_product(-system.mass_damping, &self.v, out);
    }

    /// Mean of the loads at both ends of the step.
    pub(super) fn mean_loads(&self, system: &System, out: &mut [Nodal]) {
        out.fill([0.0; 3]);
        self.loads(system, self.time, (&self.u, &self.v), out);
        for (o, old) in out.iter_mut().zip(&self.loads_old) {
            *o = std::array::from_fn(|i| 0.5 * (o[i] + old[i]));
        }
    }

    /// Local error of position from that of the nodal vectors, whose part across the constraints is left out: positions satisfy them.
    pub(super) fn tangential_error(
        &self,
        system: &System,
        newton: &mut Newton,
        (error, scratch): (&mut [Nodal], &mut [Nodal]),
    ) -> f64 {
        if !system.linear {
            scratch.fill([0.0; 3]);
            triads::project_rates(system, &self.u, error, scratch);
        }
        if let Some(constraints) = &mut newton.constraints {
            constraints.take_tangential_part(system, (&self.motion(), self.time), error);
        }
        system.position_rms(|v| error[v])
    }

    /// Adds the loads of a motion, given by displacements and velocities.
    pub(super) fn loads(&self, system: &System, time: f64, (u, v): (&[Nodal], &[Nodal]), out: &mut [Nodal]) {
        system.add_dead_loads(time, 1.0, out);
        let motion = Motion::State { u, velocity: Some(v) };
        add_follower_loads(system, &motion, time, 1.0, out);
    }
}

impl Equation for Newmark {
    fn motion(&self) -> Motion<'_> {
        Motion::State { u: &self.u, velocity: self.damped.then_some(self.v.as_slice()) }
    }

    fn parts(&self) -> TangentCoefficients {
        let rate = self.gamma / (self.beta * self.dt);
        let share = 1.0 - self.alpha_f;
        TangentCoefficients {
            weights: TangentWeights {
                stress: 1.0,
                direction: 1.0,
                force: share,
                rate,
                augmentation: 0.0,
                penalty: 0.0,
                multiplier: 0.0,
            },
            mass: 1.0 / (self.beta * self.dt * self.dt) + share * self.mass_damping * rate,
            time: self.time,
        }
    }

    fn external_minus_inertia(&self, system: &System, out: &mut [Nodal]) {
        self.external_minus_inertia_of(system, self.accelerations(), out);
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

    /// Bound of the iteration error. An error e of the end of a step is an impulse M e/(β Δt), which adds up from step
    /// to step: e must vanish with Δt⁴ where the error of the integration vanishes with Δt³. The first increment δ
    /// corrects the prediction, of which p = ½ Δt² ā is a part, so it is of the order of Δt³ and |δ|/|p| of the order
    /// of Δt over the time scale of the motion. Hence |e| ≤ κ |p| with κ a part of (|δ|/|p|)², all in the energy norm.
    fn error_limit(&self, first: f64) -> f64 {
        let Some(predicted) = self.predicted else { return FIRST_STEP * FIRST_STEP * first };
        let scale = predicted.max(first);
        if scale == 0.0 {
            return f64::INFINITY;
        }
        let part = (SHARE * first / scale).min(LARGEST_PART);
        part * part * scale
    }
}

impl Integrator for Newmark {
    fn begin(&mut self, system: &System, assembly: &mut Assembly, state: &State, span: Span) {
        self.a_old.copy_from_slice(&state.a);
        self.start(system, state, span);
        if self.alpha_f != 0.0 {
            let velocity = self.damped.then_some(state.v.as_slice());
            let motion = Motion::State { u: &state.u, velocity };
            let k = EvaluationPoint::new(system, motion, state.time, &state.history);
            assembly.forces(system, &k, &mut self.old_rest);
            for (r, f) in self.old_rest.iter_mut().zip(&self.loads_old) {
                for i in 0..3 {
                    r[i] = f[i] - r[i];
                }
            }
            system.pattern.add_mass_product(-system.mass_damping, &state.v, &mut self.old_rest);
            self.add_old_constraint_forces(system, assembly, &k, &state.a);
        }
    }

    fn displacements(&self) -> &[Nodal] {
        &self.u
    }

    fn finish(&mut self, system: &System, state: &mut State) {
        project_rates(system, &self.u, &mut self.v, &mut self.a);
        state.u.copy_from_slice(&self.u);
        state.v.copy_from_slice(&self.v);
        state.a.copy_from_slice(&self.a);
        state.multipliers.copy_from_slice(&self.multipliers);
    }

    /// `|(β − 1/6) Δt² (a₁ − a₀)|`, the leading term of the error of position.
    fn local_error(&mut self, system: &System, _newton: &mut Newton, _state: &State) -> f64 {
        let factor = (self.beta - 1.0 / 6.0) * self.dt * self.dt;
        system.position_rms(|v| std::array::from_fn(|i| factor * (self.a[v][i] - self.a_old[v][i])))
    }

    fn step_work(&mut self, system: &System, assembly: &mut Assembly, state: &State) -> StepWork {
        let StepWork { work, dissipated } = self.work_by_mean_rates(system, assembly, state);
        let noise = self.dissipation_of_rates_at_ends(system, assembly, state);
        StepWork { work, dissipated: dissipated + noise }
    }

    fn unresolved(&self) -> f64 {
        self.unresolved
    }

    fn tolerances(&self, max_iterations: u32) -> Tolerances {
        Tolerances { energy: 1e-12, increment: 1e-3, max_iterations }
    }
}

impl Newmark {
    /// Work and dissipation of a step, in which dampers act with the mean rates Δu/Δt.
    pub(super) fn work_by_mean_rates(
        &mut self,
        system: &System,
        assembly: &mut Assembly,
        state: &State,
    ) -> StepWork {
        let mut loads = std::mem::take(&mut self.buffer);
        loads.fill([0.0; 3]);
        self.loads(system, self.time, (&self.u, &self.v), &mut loads);
        let trapezoid =
            0.5 * (work(&self.loads_old, &self.u_old, &self.u) + work(&loads, &self.u_old, &self.u));
        let gravity =
            system.constant_gravity_potential(&self.u_old) - system.constant_gravity_potential(&self.u);
        for (n, mean) in loads.iter_mut().enumerate() {
            *mean = std::array::from_fn(|i| (self.u[n][i] - self.u_old[n][i]) / self.dt);
        }
        let motion = Motion::Step { old: &self.u_old, new: &self.u, dt: self.dt };
        let internal = Internal { history: &state.history, multipliers: &self.multipliers };
        let k = EvaluationPoint::new(system, motion, self.time, internal);
        let power =
            assembly.dissipated_power(system, &k) + 2.0 * system.mass_damping * system.kinetic_energy(&loads);
        self.buffer = loads;
        let middle = EvaluationPoint { time: self.time - 0.5 * self.dt, ..k };
        let actuators = assembly.work_of_actuators(system, &middle);
        let prescribed = self.work_of_supports(system, assembly, state);
        let before = (self.u_old.as_slice(), self.time - self.dt, state.multipliers.as_slice());
        let drives = system.work_of_driven_motions(before, (&self.u, self.time, &self.multipliers));
        StepWork { work: trapezoid - gravity + prescribed + drives + actuators, dissipated: self.dt * power }
    }

    /// Difference between the work of the damping forces at the ends of the step, C ½ (v₀ + v₁) · Δu, and that of the mean rates r = Δu/Δt.
    ///
    /// A damper that is much stiffer than the mass over the step keeps its velocity, but not its displacement: r alternates about the
    /// mean of the ends, and with its square the dissipation would exceed the work of the loads by far. In terms of the power P with
    /// δ = ½ (v₀ + v₁) − r it is `½ Δt [P(r + δ) − P(r) − P(δ)]`, which vanishes with noise of the velocities that alternates from step to step.
    fn dissipation_of_rates_at_ends(
        &mut self,
        system: &System,
        assembly: &mut Assembly,
        state: &State,
    ) -> f64 {
        if !self.is_damped() {
            return 0.0;
        }
        let mut power = |of| self.power_of_rates(system, assembly, state, of);
        let [ends, mean, between] = [power([0.5, 0.5, 0.0]), power([0.0, 0.0, 1.0]), power([0.5, 0.5, -1.0])];
        self.unresolved += self.dt * between;
        0.5 * self.dt * (ends - mean - between)
    }

    /// Whether forces depend on velocities.
    pub(super) fn is_damped(&self) -> bool {
        self.damped || self.mass_damping != 0.0
    }

    /// Power that dampers dissipate in the middle of the step with these parts of the velocities at its start and its end, and of the mean rate Δu/Δt.
    pub(super) fn power_of_rates(
        &mut self,
        system: &System,
        assembly: &mut Assembly,
        state: &State,
        [start, end, mean]: [f64; 3],
    ) -> f64 {
        let Self { u, v, u_old, v_old, dt, buffer: middle, reaction: rate, .. } = self;
        for n in 0..u.len() {
            middle[n] = std::array::from_fn(|i| 0.5 * (u_old[n][i] + u[n][i]));
            rate[n] = std::array::from_fn(|i| {
                start * v_old[n][i] + end * v[n][i] + mean * ((u[n][i] - u_old[n][i]) / *dt)
            });
        }
        let motion = Motion::State { u: middle, velocity: Some(rate) };
        let internal = Internal { history: &state.history, multipliers: &self.multipliers };
        let k = EvaluationPoint::new(system, motion, self.time, internal);
        assembly.dissipated_power(system, &k) + 2.0 * self.mass_damping * system.kinetic_energy(rate)
    }

    /// Adds the constraint forces of inextensible directors at the start of the step.
    ///
    /// They act along the directors at the start. The equation at the end of the step is projected onto the planes normal to
    /// the directors there, in which they have a component; omitting it would be an error of first order.
    fn add_old_constraint_forces(
        &mut self,
        system: &System,
        assembly: &mut Assembly,
        k: &EvaluationPoint,
        acceleration: &[Nodal],
    ) {
        if system.linear || system.dofs().unit.is_empty() {
            return;
        }
        assembly.follow(system, k);
        self.buffer.copy_from_slice(&self.old_rest);
        system.pattern.add_mass_product(-1.0, acceleration, &mut self.buffer);
        assembly.frames.constrained_part(&self.buffer, &mut self.supported);
        for unit in &system.dofs().unit {
            let v = unit.vector as usize;
            for i in 0..3 {
                self.old_rest[v][i] -= self.supported[v][i];
            }
        }
    }

    /// Work of the reactions over prescribed motions, by the trapezoidal rule.
    fn work_of_supports(&mut self, system: &System, assembly: &mut Assembly, state: &State) -> f64 {
        if system.dofs().prescribed.is_empty() {
            return 0.0;
        }
        let mut total = 0.0;
        let (mut reaction, mut loads) =
            (std::mem::take(&mut self.reaction), std::mem::take(&mut self.buffer));
        let [old, new] = [&state.multipliers, &self.multipliers]
            .map(|multipliers| Internal { history: &state.history, multipliers });
        for (u, v, a, time, internal) in
            [(&state.u, &state.v, &state.a, state.time, old), (&self.u, &self.v, &self.a, self.time, new)]
        {
            loads.fill([0.0; 3]);
            let motion = Motion::State { u, velocity: Some(v) };
            let k = EvaluationPoint::new(system, motion, time, internal);
            assembly.forces(system, &k, &mut reaction);
            self.loads(system, time, (u, v), &mut loads);
            system.pattern.add_mass_product(1.0, a, &mut reaction);
            system.pattern.add_mass_product(system.mass_damping, v, &mut reaction);
            for (r, f) in reaction.iter_mut().zip(&loads) {
                for i in 0..3 {
                    r[i] -= f[i];
                }
            }
            // Inextensible directors are left out: they rotate, and no support does work on them.
            total += 0.5 * system.work_of_prescribed(&reaction, &self.u_old, &self.u);
        }
        (self.reaction, self.buffer) = (reaction, loads);
        total
    }
}
