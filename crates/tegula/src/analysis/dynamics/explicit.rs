//! Central differences with lumped mass, as kick–drift–kick: positions and velocities belong to the same times.
//!
//! ```text
//! v½ = v₀ + ½ Δt a₀
//! u₁ = u₀ + Δt v½
//! M a₁ = F₁ − f(u₁, v½) − α M v₁
//! v₁ = v½ + ½ Δt a₁
//! ```
//!
//! Stable below the critical step. Damping of strain rates acts with the velocity of the half step, damping of the
//! mass is implicit. T. Belytschko, W. K. Liu, B. Moran, *Nonlinear Finite Elements for Continua and Structures*
//! (2000), sect. 6.2.

use super::critical_step::CriticalStep;
use super::{SMALLEST_STEP, TransientOutcome, balance, start as initial, work};
use crate::analysis::statics::{state_kinematics, undefined};
use crate::analysis::{Observer, State, Statistics, Step};
use crate::element::{Kinematics, Motion, Nodal};
use crate::model::TransientAnalysis;
use crate::system::assembly::add_follower_loads;
use crate::system::{Assembly, System, inside_out};
use crate::{Error, Result};

/// Part of the critical step that is taken.
const SAFETY: f64 = 0.9;
/// Steps after which the critical step is estimated anew.
const INTERVAL: u64 = 200;
/// A motion is unstable whose kinetic and strain energy are this many times what it can have got. At the safety factor
/// the energy of the highest mode varies five-fold in a stable motion.
const BLOW_UP: f64 = 100.0;

/// What a step works with; nothing is allocated after it is made.
struct Explicit<'a> {
    system: &'a System,
    assembly: Assembly,
    /// Mass of each nodal vector.
    mass: Vec<f64>,
    u_old: Vec<Nodal>,
    /// Velocities of the middle of the step.
    middle: Vec<Nodal>,
    loads_old: Vec<Nodal>,
    loads: Vec<Nodal>,
    forces: Vec<Nodal>,
    supported: Vec<Nodal>,
    damped: bool,
}

impl<'a> Explicit<'a> {
    fn new(system: &'a System) -> Result<Self> {
        let n = system.vectors();
        let mut mass = vec![0.0; n];
        let mut lumped = true;
        system.pattern.for_each_mass(|i, j, m| {
            if i == j {
                mass[i] = m;
            } else {
                lumped = false;
            }
        });
        if !lumped {
            return Err(Error::model(
                "analysis.scheme",
                "the system was compiled with consistent mass",
                "compile the model with the scheme \"explicit\"",
            ));
        }
        if (0..n).any(|v| system.numbering.is_free(v) && mass[v] <= 0.0) {
            return Err(Error::Singular {
                what: "The mass matrix is singular: some coordinates have no mass.".into(),
                help: "Give every material a density, or the section a `total_mass`.".into(),
            });
        }
        let zero = vec![[0.0; 3]; n];
        Ok(Self {
            system,
            assembly: Assembly::new(system),
            mass,
            u_old: zero.clone(),
            middle: zero.clone(),
            loads_old: zero.clone(),
            loads: zero.clone(),
            forces: zero.clone(),
            supported: zero,
            damped: system.groups.iter().any(|g| g.retardation_time() != 0.0),
        })
    }

    /// Loads at a state, into `loads`.
    fn find_loads(&mut self, state: &State) {
        self.loads.fill([0.0; 3]);
        self.system.add_dead_loads(state.time, 1.0, &mut self.loads);
        let k = state_kinematics(self.system, &state.u, state.time);
        add_follower_loads(self.system, &k, state.time, 1.0, &mut self.loads);
    }

    /// Free accelerations under the forces `rest`, in their place.
    fn accelerate(&self, rest: &mut [Nodal]) {
        let numbering = &self.system.numbering;
        for (v, r) in rest.iter_mut().enumerate() {
            let mut local = numbering.to_axes(v, *r);
            for (number, x) in numbering.of(v).into_iter().zip(&mut local) {
                let free = number != crate::system::numbering::CONSTRAINED;
                *x = if free { *x / self.mass[v] } else { 0.0 };
            }
            *r = numbering.from_axes(v, local);
        }
    }

    /// Work of the reactions of a state over the change of displacement from `u_old` to `to`. Expects its loads.
    fn work_of_supports(&mut self, state: &State, to: Option<&[Nodal]>) -> f64 {
        let system = self.system;
        let motion = Motion::State { u: &state.u, velocity: Some(&state.v) };
        let k = Kinematics::new(&system.reference, motion, system.linear, state.time);
        self.assembly.forces(system, &k, &mut self.forces);
        for (v, r) in self.forces.iter_mut().enumerate() {
            for i in 0..3 {
                r[i] +=
                    self.mass[v] * (state.a[v][i] + system.mass_damping * state.v[v][i]) - self.loads[v][i];
            }
        }
        system.numbering.supported_part(&self.forces, &mut self.supported);
        work(&self.supported, &self.u_old, to.unwrap_or(&state.u))
    }

    /// One step of length `dt` to the time `end`.
    fn step(&mut self, state: &mut State, dt: f64, end: f64) {
        let system = self.system;
        let moved = !system.numbering.prescribed.is_empty();
        self.u_old.copy_from_slice(&state.u);
        self.find_loads(state);
        std::mem::swap(&mut self.loads, &mut self.loads_old);
        for v in 0..self.mass.len() {
            for i in 0..3 {
                self.middle[v][i] = state.v[v][i] + 0.5 * dt * state.a[v][i];
            }
        }
        let mut target = std::mem::take(&mut self.middle);
        let mut of_supports = 0.0;
        if moved {
            // Reactions do work over the prescribed displacement of the step.
            self.loads.copy_from_slice(&self.loads_old);
            let mut next = std::mem::take(&mut self.loads_old);
            next.copy_from_slice(&state.u);
            system.prescribe(end, &mut next);
            of_supports += 0.5 * self.work_of_supports(state, Some(&next));
            for v in 0..next.len() {
                let mut local = system.numbering.to_axes(v, target[v]);
                let change = std::array::from_fn(|i| (next[v][i] - self.u_old[v][i]) / dt);
                let change = system.numbering.to_axes(v, change);
                for (c, number) in system.numbering.of(v).into_iter().enumerate() {
                    if number == crate::system::numbering::CONSTRAINED {
                        local[c] = change[c];
                    }
                }
                target[v] = system.numbering.from_axes(v, local);
            }
            self.loads_old = next;
            self.loads_old.copy_from_slice(&self.loads);
        }
        for v in 0..self.mass.len() {
            for i in 0..3 {
                state.u[v][i] += dt * target[v][i];
            }
        }
        system.prescribe(end, &mut state.u);
        state.time = end;
        let velocity = self.damped.then_some(target.as_slice());
        let motion = Motion::State { u: &state.u, velocity };
        let k = Kinematics::new(&system.reference, motion, system.linear, end);
        let mut rest = std::mem::take(&mut self.forces);
        self.assembly.forces(system, &k, &mut rest);
        self.find_loads(state);
        for (r, f) in rest.iter_mut().zip(&self.loads) {
            for i in 0..3 {
                r[i] = f[i] - r[i];
            }
        }
        self.accelerate(&mut rest);
        let damping = 1.0 + 0.5 * dt * system.mass_damping;
        for v in 0..self.mass.len() {
            for i in 0..3 {
                state.v[v][i] = (target[v][i] + 0.5 * dt * rest[v][i]) / damping;
                state.a[v][i] = rest[v][i] - system.mass_damping * state.v[v][i];
            }
        }
        // Supported coordinates have no acceleration but a prescribed one.
        if system.mass_damping != 0.0 || moved {
            system.numbering.supported_part(&state.a, &mut self.supported);
            for (a, s) in state.a.iter_mut().zip(&self.supported) {
                for i in 0..3 {
                    a[i] -= s[i];
                }
            }
            system.prescribe_velocity(end, &mut state.v);
            system.prescribe_acceleration(end, &mut state.a);
        }
        self.forces = rest;
        if moved {
            of_supports += 0.5 * self.work_of_supports(state, None);
        }
        let of_loads =
            0.5 * (work(&self.loads_old, &self.u_old, &state.u) + work(&self.loads, &self.u_old, &state.u));
        let gravity =
            system.constant_gravity_potential(&self.u_old) - system.constant_gravity_potential(&state.u);
        let strains = self.assembly.prescribed_strain_work(system, (&self.u_old, end - dt), (&state.u, end));
        state.work += of_loads - gravity + of_supports + strains;
        if self.damped || system.mass_damping != 0.0 {
            let motion = Motion::Step { old: &self.u_old, new: &state.u, dt };
            let k = Kinematics::new(&system.reference, motion, system.linear, end);
            state.dissipated += dt
                * (self.assembly.dissipated_power(system, &k)
                    + 2.0 * system.mass_damping * system.kinetic_energy(&target));
        }
        self.middle = target;
        let k = state_kinematics(system, &state.u, end);
        state.dissipated += self.assembly.commit(system, &k);
        state.history.copy_from_slice(&self.assembly.history);
    }
}

/// Integrates the motion explicitly from `start` (rest or the initial velocities where `None`).
///
/// # Errors
/// The motion became unstable, elements turned inside out, or the user interrupted.
pub fn run(
    system: &System,
    options: &TransientAnalysis,
    start: Option<State>,
    observer: &mut dyn Observer,
) -> Result<TransientOutcome> {
    let mut scheme = Explicit::new(system)?;
    let fresh = start.is_none();
    if fresh && let Some(reason) = system.undefined_amplitude(0.0) {
        return Err(undefined("time", (0.0, 0.0), reason));
    }
    // Also where a run is resumed: the energy at the start is what later energies are held against.
    let (mut first, mut rest) = initial(system, &mut scheme.assembly);
    scheme.accelerate(&mut rest);
    for (a, r) in first.a.iter_mut().zip(&rest) {
        for i in 0..3 {
            a[i] += r[i];
        }
    }
    first.energy_scale = system.kinetic_energy(&first.v);
    let at_start = balance(system, &mut scheme.assembly, &first);
    let mut given = at_start.kinetic + at_start.strain + at_start.potential.abs();
    let mut state = start.unwrap_or(first);
    scheme.assembly.history.copy_from_slice(&state.history);
    let mut critical = CriticalStep::new(system, &scheme.mass);
    let mut statistics = Statistics { steps: state.step, ..Statistics::default() };
    let mut balance = self::balance(system, &mut scheme.assembly, &state);
    let mut estimated = false;
    while fresh && !estimated || state.time < options.end_time {
        if !estimated || (!system.linear && state.step.is_multiple_of(INTERVAL)) {
            let step = critical.estimate(system, &mut scheme.assembly, &state);
            statistics.critical_step = step;
            // A resumed run keeps the step it had, until the next estimate is due.
            if fresh || estimated || state.step.is_multiple_of(INTERVAL) {
                let largest = options.max_step.unwrap_or(options.end_time);
                state.next_step = options.time_step.unwrap_or((SAFETY * step).min(largest));
            }
            if let Some(wanted) = options.time_step.filter(|&wanted| wanted > step && !estimated) {
                observer.on_event(&format!(
                    "the step {wanted:.3e} is above the critical step of about {step:.3e}"
                ));
            }
            if !state.next_step.is_finite() || state.next_step < SMALLEST_STEP * options.end_time {
                return Err(unstable(
                    &state,
                    &statistics,
                    "the critical step is no longer a useful one".into(),
                ));
            }
            if fresh && !estimated {
                let (state, balance, statistics) = (&state, &balance, &statistics);
                observer.on_step(&Step {
                    state,
                    balance,
                    statistics,
                    iterations: 0,
                    end: options.end_time,
                })?;
            }
            estimated = true;
        }
        let left = options.end_time - state.time;
        let last = left <= 1.000_001 * state.next_step;
        let dt = if last { left } else { state.next_step };
        let end = if last { options.end_time } else { state.time + dt };
        if let Some(reason) = system.undefined_amplitude(end) {
            return Err(undefined("time", (state.time, end), reason));
        }
        scheme.step(&mut state, dt, end);
        state.last_step = dt;
        state.step += 1;
        statistics.steps = state.step;
        balance = self::balance(system, &mut scheme.assembly, &state);
        let stored = balance.kinetic + balance.strain;
        given = given.max(at_start.kinetic + at_start.strain + balance.work.abs() + balance.potential.abs());
        if !stored.is_finite() || stored > BLOW_UP * given {
            let reason = match scheme.assembly.without_answer(system) {
                Some(element) => format!("the forces of {element} are no numbers"),
                None => format!(
                    "the motion is unstable: its energy {stored:.2e} is far above the {given:.2e} that loads and \
                     initial motion have given"
                ),
            };
            return Err(unstable(&state, &statistics, reason));
        }
        if (state.step.is_multiple_of(INTERVAL) || last)
            && let Some(reason) = inside_out(system, &state.u)
        {
            return Err(unstable(&state, &statistics, reason));
        }
        state.energy_scale = state.energy_scale.max(balance.kinetic).max(balance.strain);
        let step = Step {
            state: &state,
            balance: &balance,
            statistics: &statistics,
            iterations: 0,
            end: options.end_time,
        };
        observer.on_step(&step)?;
        if observer.interrupted() && state.time < options.end_time {
            return Err(Error::Interrupted);
        }
    }
    Ok(TransientOutcome { state, balance, statistics })
}

/// The end of a motion that cannot go on.
fn unstable(state: &State, statistics: &Statistics, reason: String) -> Error {
    Error::NotConverged {
        at: format!("time {:.6e}", state.time),
        reason,
        help: format!(
            "The last step was {:.3e}, the critical step is about {:.3e}. Drop `time_step`, or give one or a \
             `max_step` below {:.3e}; else look at loads, initial velocities and units.",
            state.last_step,
            statistics.critical_step,
            SAFETY
                * statistics.critical_step.min(if state.last_step > 0.0 {
                    state.last_step
                } else {
                    f64::MAX
                })
        ),
    }
}
