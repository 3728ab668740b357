//! Backward differentiation formula of second order (BDF2), also for motions with constraints.
//!
//! With the mean rates of the step and those of the step before
//!
//! ```text
//! V₁ = (u₁ − u₀)/Δt,   A₁ = (v₁ − v₀)/Δt,   ω = Δt/Δt₀
//! v₁ = c V₁ − w V₀,    a₁ = c A₁ − w A₀,     c = (1 + 2ω)/(1 + ω),  w = ω/(1 + ω)
//! M a₁ + C v₁ + f₁ + G₁ᵀλ₁ = c F̄₁ − w F̄₀,    g(u₁) = 0
//! ```
//!
//! **Loads.** F̄₁ and F̄₀ are the means of the loads in the step and in the one before, by the trapezoidal rule. The right side differs from
//! F₁ by terms of second order, and a free mass keeps the impulse of the loads exactly, `M A₁ = F̄₁`, however the lengths of the steps change: with F₁
//! a short pulse between long steps would leave a third too much.
//!
//! **Start.** Without joints and bodies the first step, and one that is much longer than the step before, is a backward Euler step (c = 1,
//! w = 0). With constraints, which the directors of bodies have, too, the accelerations of such a step would be of order zero, half of the centripetal ones in a steady rotation; and a step
//! that is much shorter than the one before would divide the error of the velocities across the constraints by its length. In these cases,
//! and behind a jump of the velocities, the formula starts anew from the projected velocities, with a fictitious step of the same length
//! before: `V₀ = v₀ − ½ Δt a₀`, `A₀ = a₀`, and with the loads that have given a₀, so that no impulse is lost.
//!
//! Motions that the step does not resolve vanish (L-stability); with automatic steps of any length a structure settles in its equilibrium. For
//! constraints K. E. Brenan, S. L. Campbell, L. R. Petzold, *Numerical solution of initial-value problems in differential-algebraic
//! equations* (1996), Sect. 3.2; variable steps E. Hairer, S. P. Nørsett, G. Wanner, *Solving ordinary differential equations I* (1993),
//! Sect. III.5, where the formula is stable for ω < 1 + √2.
//!
//! **Rates.** Velocities are differences of positions, which satisfy the constraints; across the constraints they are of second order, and
//! no error adds up. The velocities of the state are their projections; the scheme continues with its own, because those make the
//! multipliers of second order.

use super::drive_rates::time_of_rates;
use super::newmark::{Newmark, forwards_to_newmark};
use super::{Integrator, Span, StepWork, project_rates, triads};
use crate::analysis::State;
use crate::analysis::newton::{Equation, Newton, Tolerances};
use crate::element::{Motion, Nodal};
use crate::system::assembly::TangentCoefficients;
use crate::system::{Assembly, System};

/// Largest ratio of a step to the one before with which the formula continues; it is below 1 + √2. With joints or bodies also the smallest.
/// Steps are cut to halves and grow to twice their length: round-off of their ratio must not decide.
const LARGEST_RATIO: f64 = 2.0 + 1e-6;
const SMALLEST_RATIO: f64 = 1.0 / LARGEST_RATIO;

/// BDF2 integrator.
pub struct Bdf2 {
    /// The step, with β = 1/c² and γ = 1/c: increments δ of the positions change the velocities by c δ/Δt and the accelerations by c² δ/Δt².
    newmark: Newmark,
    /// Weights c and w of the mean rates.
    weights: [f64; 2],
    /// Length of the step over that of the one before; `None` for backward Euler steps.
    ratio: Option<f64>,
    /// Velocities at the start of the step, and those at its end on the constraints.
    velocities: Vec<Nodal>,
    projected: Vec<Nodal>,
    /// Mean rates and mean loads of the step before.
    rates_before: [Vec<Nodal>; 2],
    loads_before: Vec<Nodal>,
    /// Local error of the nodal vectors, and scratch space.
    error: Vec<Nodal>,
    scratch: Vec<Nodal>,
    /// Whether there are joints or bodies, which need sharp convergence and another start.
    constrained: bool,
}

impl Bdf2 {
    /// Integrator of a system.
    pub fn new(system: &System) -> Self {
        let zero = vec![[0.0; 3]; system.vectors()];
        Self {
            newmark: Newmark::new(system, 1.0, 1.0, 0.0),
            weights: [1.0, 0.0],
            ratio: None,
            velocities: zero.clone(),
            projected: zero.clone(),
            rates_before: [zero.clone(), zero.clone()],
            loads_before: zero.clone(),
            error: zero.clone(),
            scratch: zero,
            constrained: system.constraints() > 0 || !system.dofs().triads.is_empty(),
        }
    }

    /// Rates and loads of a fictitious step before, of the same length, from velocities and accelerations at the start.
    fn start_anew(&mut self, state: &State, dt: f64) {
        let Self { newmark, velocities, rates_before: [mean_v, mean_a], loads_before, .. } = self;
        velocities.copy_from_slice(&state.v);
        mean_a.copy_from_slice(&state.a);
        for (mean, (v, a)) in mean_v.iter_mut().zip(state.v.iter().zip(&state.a)) {
            *mean = std::array::from_fn(|i| v[i] - 0.5 * dt * a[i]);
        }
        let of_accelerations =
            if state.scheme_loads.is_empty() { &newmark.loads_old } else { &state.scheme_loads };
        loads_before.copy_from_slice(of_accelerations);
    }

    /// Velocities and accelerations that belong to the displacements.
    fn rates(&mut self, system: &System, state: &State) {
        let Self { newmark, weights: [c, w], velocities, rates_before: [mean_v, mean_a], .. } = self;
        for n in 0..velocities.len() {
            for i in 0..3 {
                let moved = newmark.u[n][i] - state.u[n][i];
                let v = *c * (moved / newmark.dt) - *w * mean_v[n][i];
                newmark.v[n][i] = v;
                newmark.a[n][i] = *c * ((v - velocities[n][i]) / newmark.dt) - *w * mean_a[n][i];
            }
        }
        // Prescribed motions are known exactly, with their rates.
        system.prescribe_velocity_before(newmark.time, &mut newmark.v);
        system.prescribe_acceleration_before(newmark.time, &mut newmark.a);
    }
}

impl Equation for Bdf2 {
    forwards_to_newmark!();

    fn parts(&self) -> TangentCoefficients {
        let mut parts = self.newmark.parts();
        parts.weights.augmentation = 1.0 / (self.newmark.beta * self.newmark.dt * self.newmark.dt);
        parts
    }

    fn external_minus_inertia(&self, system: &System, out: &mut [Nodal]) {
        let [c, w] = self.weights;
        let before = |n: usize| self.loads_before[n].map(|x| w * x);
        self.newmark.weighted_external_minus_inertia(system, (c, before), out);
    }

    fn apply(&mut self, system: &System, increment: &[Nodal]) {
        self.newmark.apply(system, increment);
    }
}

impl Integrator for Bdf2 {
    fn begin(&mut self, system: &System, _assembly: &mut Assembly, state: &State, span: Span) {
        let ratio = span.dt / state.last_step;
        let known = !state.mean_rates[0].is_empty() && !state.mean_loads.is_empty();
        let constrained = self.constrained;
        let continues = known && ratio <= LARGEST_RATIO && (!constrained || ratio >= SMALLEST_RATIO);
        self.ratio = match (continues, constrained) {
            (true, _) => Some(ratio),
            (false, true) => Some(1.0),
            (false, false) => None,
        };
        self.weights = self.ratio.map_or([1.0, 0.0], |w| [(1.0 + 2.0 * w) / (1.0 + w), w / (1.0 + w)]);
        let c = self.weights[0];
        (self.newmark.beta, self.newmark.gamma) = (1.0 / (c * c), 1.0 / c);
        self.newmark.a_old.copy_from_slice(&state.a);
        self.velocities.copy_from_slice(state.velocities_of_scheme());
        if continues {
            let before = self.rates_before.iter_mut().zip(&state.mean_rates);
            before.for_each(|(to, from)| to.copy_from_slice(from));
            self.loads_before.copy_from_slice(&state.mean_loads);
        }
        self.newmark.start(system, state, span);
        if constrained && !continues {
            self.start_anew(state, span.dt);
        }
        self.rates(system, state);
    }

    fn displacements(&self) -> &[Nodal] {
        self.newmark.displacements()
    }

    /// Finds the velocities of the state, which satisfy the constraints.
    fn close_rates(&mut self, system: &System, newton: &mut Newton) {
        let Self { newmark, projected, .. } = self;
        projected.copy_from_slice(&newmark.v);
        triads::project_velocities(system, &newmark.u, projected);
        if let Some(constraints) = &mut newton.constraints {
            let time = time_of_rates(system, newmark.time, newmark.dt);
            constraints.project_velocities(system, (&newmark.u, time), projected);
        }
    }

    fn finish(&mut self, system: &System, state: &mut State) {
        let Self { newmark, weights: [c, w], velocities, projected, loads_before, scratch, .. } = self;
        let [mean_v, mean_a] = &mut state.mean_rates;
        for (mean, end, start) in [(mean_v, &newmark.u, &state.u), (mean_a, &newmark.v, velocities)] {
            mean.resize(end.len(), [0.0; 3]);
            for ((mean, end), start) in mean.iter_mut().zip(end).zip(start) {
                *mean = std::array::from_fn(|i| (end[i] - start[i]) / newmark.dt);
            }
        }
        state.mean_loads.resize(scratch.len(), [0.0; 3]);
        newmark.mean_loads(system, &mut state.mean_loads);
        state.scheme_loads.resize(loads_before.len(), [0.0; 3]);
        for (loads, (mean, before)) in
            state.scheme_loads.iter_mut().zip(state.mean_loads.iter().zip(loads_before))
        {
            *loads = std::array::from_fn(|i| *c * mean[i] - *w * before[i]);
        }
        scratch.fill([0.0; 3]);
        project_rates(system, &newmark.u, projected, scratch);
        state.u.copy_from_slice(&newmark.u);
        state.v.copy_from_slice(projected);
        state.a.copy_from_slice(&newmark.a);
        state.scheme_v.clone_from(&newmark.v);
        state.multipliers.copy_from_slice(&newmark.multipliers);
    }

    /// Leading term of the error of position that a step adds, `(1 + ω)/(6 ω) Δt² (a₁ − a₀)`, and `½ Δt² a₁` for backward Euler. Its part
    /// across the constraints is left out: positions satisfy them.
    fn local_error(&mut self, system: &System, newton: &mut Newton, _state: &State) -> f64 {
        let Self { newmark, error, scratch, ratio, .. } = self;
        let Newmark { dt, a, a_old, .. } = &*newmark;
        let [end, start] = ratio.map_or([0.5, 0.0], |w| [(1.0 + w) / (6.0 * w); 2]);
        for ((error, new), old) in error.iter_mut().zip(a).zip(a_old) {
            *error = std::array::from_fn(|i| dt * dt * (end * new[i] - start * old[i]));
        }
        newmark.tangential_error(system, newton, (error, scratch))
    }

    fn step_work(&mut self, system: &System, assembly: &mut Assembly, state: &State) -> StepWork {
        if self.newmark.is_damped() {
            let between = self.newmark.power_of_rates(system, assembly, state, [0.0, 1.0, -1.0]);
            self.newmark.unresolved += self.newmark.dt * between;
        }
        self.newmark.work_by_mean_rates(system, assembly, state)
    }

    fn unresolved(&self) -> f64 {
        self.newmark.unresolved
    }

    fn tolerances(&self, max_iterations: u32) -> Tolerances {
        if self.constrained {
            Tolerances { energy: 1e-20, increment: 1e-8, max_iterations }
        } else {
            self.newmark.tolerances(max_iterations)
        }
    }
}
