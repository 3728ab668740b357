//! Generalised-α method, also for motions with constraints (differential-algebraic equations of index 3).
//!
//! ```text
//! u₁ = u₀ + Δt v₀ + Δt² ((½ − β) a₀ + β a₁)
//! v₁ = v₀ + Δt ((1 − γ) a₀ + γ a₁)
//! (1 − α_m) a₁ + α_m a₀ = (1 − α_f) q̈₁ + α_f q̈₀
//! M q̈₁ + C v₁ + f₁ − F₁ + G₁ᵀλ₁ = 0,   g(u₁) = 0
//! ```
//!
//! with the spectral radius ρ at high frequencies `α_m = (2ρ − 1)/(ρ + 1)`, `α_f = ρ/(ρ + 1)`, `γ = ½ + α_f − α_m`,
//! `β = ¼ (1 + α_f − α_m)²`. The equations of motion hold at the end of the step; the auxiliary accelerations a are those of the time
//! `t + (α_m − α_f) Δt`. J. Chung, G. M. Hulbert, *A time integration algorithm for structural dynamics with improved numerical
//! dissipation*, J. Appl. Mech. 60 (1993) 371–375; M. Arnold, O. Brüls, *Convergence of the generalized-α scheme for constrained
//! mechanical systems*, Multibody Syst. Dyn. 18 (2007) 185–202.
//!
//! The method of Hilber, Hughes and Taylor (HHT) is that of `α_m = 0`, `α_f = −α`: for linear forces the same recurrence, and with joints
//! that of index 3 in place of the forces between the ends of the step. Its spectral radius at high frequencies is `(1 + α)/(1 − α)`.
//!
//! **Start.** With `a₀ = q̈₀` at the start the multipliers would be of first order. The first step is therefore repeated with
//! `a₀ = q̈₀ + (α_m − α_f)(q̈₁ − q̈₀)`, with the accelerations q̈₁ that it has given. A change of the step scales the difference
//! of a and q̈; behind a much shorter step, as one to the end of a jump of a load, the motion starts anew.
//!
//! **Rates.** At the end of a step the velocities are projected onto the constraints of joints, and those of bodies onto rigid motions,
//! with the change `δv/(γΔt)` of the auxiliary accelerations that this takes, and the multipliers that belong to it: the
//! stabilised formulation of index 2 (M. Arnold, O. Brüls, A. Cardona, *Error analysis of generalized-α Lie group time integration
//! methods for constrained mechanical systems*, Numer. Math. 129 (2015) 149–179). Without it the velocities across the constraints are
//! of second order and damped by ρ in a step, but a rotation by Δθ turns the share Δθ of them into the directions that the constraints leave
//! free: a free body that turns by 0.1 rad a step gains energy exponentially for ρ = 0.9. Inextensible directors, whose inertia is small,
//! keep theirs for ρ < 1.

use super::drive_rates::time_of_rates;
use super::newmark::{Newmark, forwards_to_newmark};
use super::{Integrator, Span, StepWork, project_rates, triads};
use crate::analysis::State;
use crate::analysis::newton::{Equation, Newton, Tolerances};
use crate::element::{Motion, Nodal};
use crate::system::assembly::TangentCoefficients;
use crate::system::{Assembly, System};

/// Repetitions of the first step: each reduces the error of the auxiliary accelerations at the start to a sixteenth or less.
const STARTS: u32 = 3;

/// Generalised-α integrator.
pub struct GeneralizedAlpha {
    alpha_m: f64,
    alpha_f: f64,
    /// The step with the auxiliary accelerations.
    newmark: Newmark,
    /// Accelerations q̈ at the end and at the start of the step.
    acceleration: Vec<Nodal>,
    acceleration_old: Vec<Nodal>,
    /// Local error of the nodal vectors, and scratch space.
    error: Vec<Nodal>,
    scratch: Vec<Nodal>,
    /// Repetitions of the first step that are left.
    starts: u32,
    /// Whether convergence is judged as sharply as joints and bodies need it.
    sharp: bool,
}

impl GeneralizedAlpha {
    /// Integrator with the spectral radius ρ at high frequencies, from 0 to 1.
    pub fn new(system: &System, rho: f64) -> Self {
        Self::with_parameters(system, (2.0 * rho - 1.0) / (rho + 1.0), rho / (rho + 1.0))
    }

    /// Integrator of the HHT method with α from −1/3 to 0.
    pub fn hht(system: &System, alpha: f64) -> Self {
        Self::with_parameters(system, 0.0, -alpha)
    }

    fn with_parameters(system: &System, alpha_m: f64, alpha_f: f64) -> Self {
        let lead = alpha_f - alpha_m;
        let zero = vec![[0.0; 3]; system.vectors()];
        Self {
            alpha_m,
            alpha_f,
            newmark: Newmark::new(system, 0.25 * (1.0 + lead) * (1.0 + lead), 0.5 + lead, 0.0),
            acceleration: zero.clone(),
            acceleration_old: zero.clone(),
            error: zero.clone(),
            scratch: zero,
            starts: 0,
            sharp: system.constraints() > 0 || !system.dofs().triads.is_empty(),
        }
    }

    /// α_m − α_f: time of the auxiliary accelerations, from the end of the step, over the step.
    fn lag(&self) -> f64 {
        self.alpha_m - self.alpha_f
    }

    /// Share of a change of the auxiliary accelerations in that of the accelerations.
    fn share(&self) -> f64 {
        (1.0 - self.alpha_m) / (1.0 - self.alpha_f)
    }

    /// Accelerations that belong to the auxiliary ones.
    fn accelerations(&mut self, system: &System) {
        let (m, f) = (self.alpha_m, self.alpha_f);
        let auxiliary = self.newmark.a.iter().zip(&self.newmark.a_old);
        for ((new, old), (a, a_old)) in
            self.acceleration.iter_mut().zip(&self.acceleration_old).zip(auxiliary)
        {
            *new = std::array::from_fn(|i| ((1.0 - m) * a[i] + m * a_old[i] - f * old[i]) / (1.0 - f));
        }
        system.prescribe_acceleration_before(self.newmark.time, &mut self.acceleration);
    }
}

impl Equation for GeneralizedAlpha {
    forwards_to_newmark!();

    fn parts(&self) -> TangentCoefficients {
        let mut parts = self.newmark.parts();
        let (dt, share) = (self.newmark.dt, self.share());
        let auxiliary = 1.0 / (self.newmark.beta * dt * dt);
        parts.mass += (share - 1.0) * auxiliary;
        parts.weights.augmentation = share * auxiliary;
        parts
    }

    fn external_minus_inertia(&self, system: &System, out: &mut [Nodal]) {
        self.newmark.external_minus_inertia_of(system, &self.acceleration, out);
    }

    fn apply(&mut self, system: &System, increment: &[Nodal]) {
        self.newmark.apply(system, increment);
        self.accelerations(system);
    }
}

impl Integrator for GeneralizedAlpha {
    fn begin(&mut self, system: &System, _assembly: &mut Assembly, state: &State, span: Span) {
        self.acceleration_old.copy_from_slice(&state.a);
        self.newmark.a_old.copy_from_slice(&state.a);
        if state.acceleration_lag.is_empty() {
            self.starts = STARTS;
        }
        for (a, lag) in self.newmark.a_old.iter_mut().zip(&state.acceleration_lag) {
            (0..3).for_each(|i| a[i] += span.dt * lag[i]);
        }
        self.newmark.start(system, state, span);
        self.accelerations(system);
    }

    fn improves_start(&mut self, system: &System, newton: &mut Newton, state: &mut State) -> bool {
        if self.starts == 0 || self.lag() == 0.0 {
            return false;
        }
        // Without the projection the accelerations across the constraints are of first order.
        self.close_rates(system, newton);
        self.starts -= 1;
        state.acceleration_lag.resize(system.vectors(), [0.0; 3]);
        let change = self.lag() / self.newmark.dt;
        for ((lag, new), old) in
            state.acceleration_lag.iter_mut().zip(&self.acceleration).zip(&self.acceleration_old)
        {
            *lag = std::array::from_fn(|i| change * (new[i] - old[i]));
        }
        true
    }

    fn displacements(&self) -> &[Nodal] {
        self.newmark.displacements()
    }

    /// Changes auxiliary accelerations and multipliers so that the velocities at the end of the step satisfy the constraints.
    fn close_rates(&mut self, system: &System, newton: &mut Newton) {
        let share = self.share();
        let Self { newmark, acceleration, error: old, .. } = self;
        let Newmark { u, v, a, dt, beta, gamma, time, multipliers, .. } = newmark;
        old.copy_from_slice(v);
        triads::project_velocities(system, u, v);
        if let Some(constraints) = &mut newton.constraints {
            // By the tangent, with M as the part of the mass, the change of v is −βΔt²/share M⁻¹Gᵀ times these multipliers.
            let time = time_of_rates(system, *time, *dt);
            let change = constraints.project_velocities(system, (u, time), v);
            let factor = *beta * *dt / *gamma;
            multipliers
                .iter_mut()
                .zip(change)
                .for_each(|(multiplier, change)| *multiplier += factor * change);
        }
        let rate = 1.0 / (*gamma * *dt);
        for n in 0..v.len() {
            for i in 0..3 {
                let change = rate * (v[n][i] - old[n][i]);
                a[n][i] += change;
                acceleration[n][i] += share * change;
            }
        }
    }

    fn finish(&mut self, system: &System, state: &mut State) {
        if self.lag() == 0.0 {
            project_rates(system, &self.newmark.u, &mut self.newmark.v, &mut self.acceleration);
        } else {
            let dt = self.newmark.dt;
            state.acceleration_lag.resize(system.vectors(), [0.0; 3]);
            for ((lag, a), acceleration) in
                state.acceleration_lag.iter_mut().zip(&self.newmark.a).zip(&self.acceleration)
            {
                *lag = std::array::from_fn(|i| (a[i] - acceleration[i]) / dt);
            }
        }
        state.u.copy_from_slice(&self.newmark.u);
        state.v.copy_from_slice(&self.newmark.v);
        state.a.copy_from_slice(&self.acceleration);
        state.multipliers.copy_from_slice(&self.newmark.multipliers);
    }

    /// `|(β + ½ (α_m − α_f) − 1/6) Δt² (a₁ − a₀)|`, the leading term of the error of position. Its part across the constraints is
    /// left out: positions satisfy them, and where the step changes the multipliers are of first order.
    fn local_error(&mut self, system: &System, newton: &mut Newton, _state: &State) -> f64 {
        let lag = self.lag();
        let Self { newmark, error, scratch, .. } = self;
        let Newmark { beta, dt, a, a_old, .. } = &*newmark;
        let factor = (beta + 0.5 * lag - 1.0 / 6.0) * dt * dt;
        for ((error, new), old) in error.iter_mut().zip(a).zip(a_old) {
            *error = std::array::from_fn(|i| factor * (new[i] - old[i]));
        }
        newmark.tangential_error(system, newton, (error, scratch))
    }

    fn step_work(&mut self, system: &System, assembly: &mut Assembly, state: &State) -> StepWork {
        // Prescribed motions take the inertia of the accelerations.
        std::mem::swap(&mut self.newmark.a, &mut self.acceleration);
        let work = self.newmark.step_work(system, assembly, state);
        std::mem::swap(&mut self.newmark.a, &mut self.acceleration);
        work
    }

    fn unresolved(&self) -> f64 {
        self.newmark.unresolved
    }

    fn tolerances(&self, max_iterations: u32) -> Tolerances {
        if self.sharp {
            Tolerances { energy: 1e-20, increment: 1e-8, max_iterations }
        } else {
            self.newmark.tolerances(max_iterations)
        }
    }
}
