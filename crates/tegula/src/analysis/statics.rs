//! Static equilibrium: load steps with cut-back.

use super::newton::{Diverged, Equation, Newton, Tolerances};
use super::solver::{Iterative, TangentSolver};
use super::{Balance, Observer, State, Statistics, Step};
use crate::element::{Kinematics, Motion, Nodal, TangentWeights};
use crate::model::{LinearSolver, StaticAnalysis};
use crate::system::assembly::{TangentParts, add_follower_loads};
use crate::system::{Assembly, System, dot, inside_out};
use crate::{Error, Result};

/// Energy of the last increment over the strain energy: small enough that reactions balance the loads to 1e-12,
/// also where loads that follow the motion make convergence linear.
const ENERGY_TOLERANCE: f64 = 1e-18;
/// Last increment over the displacement.
const INCREMENT_TOLERANCE: f64 = 1e-6;

/// Largest turn (rad) of the first increment of a load step. The answer of the undeformed shell to the whole load leads
/// thin shells so far astray that the way back takes longer: on the quarter cylinder of Sect. 5.2 with 64 × 64 elements
/// limits of 0.3 to 0.5 take 8 tangents, 0.2 and 0.6 take 9, and 0.8 takes 13. Prescribed strains bend shells without
/// load, and full increments find the way best.
const FIRST_TURN: f64 = 0.4;

/// Equilibrium at a load factor: `F(λ) − f_int(u) = 0`.
pub struct StaticEquation {
    /// Displacements.
    pub u: Vec<Nodal>,
    /// Load factor.
    pub time: f64,
}

impl Equation for StaticEquation {
    fn kinematics<'a>(&'a self, system: &'a System) -> Kinematics<'a> {
        state_kinematics(system, &self.u, self.time)
    }

    fn parts(&self) -> TangentParts {
        TangentParts {
            weights: TangentWeights { stress: 1.0, direction: 1.0, force: 1.0, rate: 0.0 },
            mass: 0.0,
            time: self.time,
        }
    }

    fn rest(&self, system: &System, out: &mut [Nodal]) {
        out.fill([0.0; 3]);
        system.add_dead_loads(self.time, 1.0, out);
        add_follower_loads(system, &self.kinematics(system), self.time, 1.0, out);
    }

    fn apply(&mut self, _system: &System, increment: &[Nodal]) {
        add(&mut self.u, increment);
    }

    fn prescribed(&self, system: &System, increment: &mut [Nodal]) -> bool {
        prescribed_increment(system, self.time, &self.u, increment)
    }

    fn energy_scale(&self, system: &System, assembly: &mut Assembly) -> f64 {
        assembly.strain_energy(system, &self.u, self.time)
    }

    fn first_turn(&self, system: &System) -> Option<f64> {
        (!system.linear && system.prescribed_strains.is_empty()).then_some(FIRST_TURN)
    }

    fn displacement_scale(&self, system: &System) -> f64 {
        system.norm(&self.u)
    }
}

/// A state without rates.
pub fn state_kinematics<'a>(system: &'a System, u: &'a [Nodal], time: f64) -> Kinematics<'a> {
    Kinematics::new(&system.reference, Motion::State { u, velocity: None }, system.linear, time)
}

/// Adds an increment to a field.
pub fn add(field: &mut [Nodal], increment: &[Nodal]) {
    for (x, d) in field.iter_mut().zip(increment) {
        for i in 0..3 {
            x[i] += d[i];
        }
    }
}

/// Increment of the supported coordinates to their prescribed values at a time; false if it vanishes.
pub fn prescribed_increment(system: &System, time: f64, u: &[Nodal], increment: &mut [Nodal]) -> bool {
    if system.numbering.prescribed.is_empty() {
        return false;
    }
    increment.copy_from_slice(u);
    system.prescribe(time, increment);
    let mut any = false;
    for (d, u) in increment.iter_mut().zip(u) {
        for i in 0..3 {
            d[i] -= u[i];
            any |= d[i].abs() > 1e-15 * u[i].abs();
        }
    }
    any
}

/// Equilibrium under the full loads.
#[derive(Debug, Clone, PartialEq)]
pub struct StaticOutcome {
    /// Final state.
    pub state: State,
    /// Its energies.
    pub balance: Balance,
    /// Counts.
    pub statistics: Statistics,
    /// Negative pivots of the tangent at the end: above 0 the equilibrium is unstable.
    pub negative_pivots: usize,
}

/// Runs a static analysis from `start` (the reference configuration where `None`) to load factor 1.
///
/// # Errors
/// No equilibrium was found, or only an unstable one; the error says where the model stood.
pub fn run(
    system: &System,
    options: &StaticAnalysis,
    start: Option<State>,
    observer: &mut dyn Observer,
) -> Result<StaticOutcome> {
    match options.linear_solver {
        LinearSolver::Direct => steps(Newton::new(system, options.method)?, system, options, start, observer),
        LinearSolver::Iterative => {
            let newton = Newton::with_solver(system, options.method, Iterative::new(system)?);
            steps(newton, system, options, start, observer)
        }
    }
}

fn steps<S: TangentSolver>(
    mut newton: Newton<S>,
    system: &System,
    options: &StaticAnalysis,
    start: Option<State>,
    observer: &mut dyn Observer,
) -> Result<StaticOutcome> {
    let n = system.vectors();
    let mut state = start.unwrap_or_else(|| State {
        next_step: 1.0 / f64::from(options.load_steps.max(1)),
        ..State::at_rest(system)
    });
    newton.restore(system, &state, state.step > 0);
    let tolerances = Tolerances {
        energy: ENERGY_TOLERANCE,
        increment: INCREMENT_TOLERANCE,
        max_iterations: options.max_iterations,
    };
    let largest = 1.0 / f64::from(options.load_steps.max(1));
    // The tangent of a linear model is the same in smaller steps: they cannot help.
    let cutbacks = if system.linear { 0 } else { options.max_cutbacks as i32 };
    let smallest = largest * 0.5_f64.powi(cutbacks);
    let mut statistics = Statistics { steps: state.step, ..Statistics::default() };
    let mut balance = Balance::default();
    let mut negative_pivots = 0;
    let mut external = vec![[0.0; 3]; n];
    while state.time < 1.0 {
        // A last sliver of a step would only repeat the one before.
        let target =
            if state.time + 1.0001 * state.next_step >= 1.0 { 1.0 } else { state.time + state.next_step };
        if let Some(reason) = system.undefined_amplitude(target) {
            return Err(undefined("load factor", (state.time, target), reason));
        }
        let mut equation = StaticEquation { u: state.u.clone(), time: target };
        let result = newton.solve(system, &mut equation, &tolerances, observer);
        statistics.factorizations = newton.solver.tangents() as u64;
        statistics.linear_iterations = newton.solver.linear_iterations();
        let inverted = result.is_ok().then(|| inside_out(system, &equation.u)).flatten();
        let failure = match result {
            Ok(c) if inverted.is_some() => {
                statistics.iterations += u64::from(c.iterations);
                format!("the equilibrium found is not a real one: {}", inverted.unwrap_or_default())
            }
            Ok(c) if c.negative_pivots > 0 && !options.allow_unstable && system.followers.is_empty() => {
                statistics.iterations += u64::from(c.iterations);
                format!(
                    "the equilibrium found is unstable ({} negative pivot(s) of the tangent): the structure would buckle",
                    c.negative_pivots
                )
            }
            Ok(c) => {
                statistics.iterations += u64::from(c.iterations);
                if c.negative_pivots > 0 && !system.followers.is_empty() {
                    // Moments and pressures need not have a potential: the symmetric part decides nothing.
                    observer.on_event(&format!(
                        "load factor {target}: {} negative pivot(s); with loads that follow the motion this need not mean instability",
                        c.negative_pivots
                    ));
                }
                if c.floor {
                    observer.on_event(&format!(
                        "load factor {target}: increments stopped shrinking at the rounding floor of the model; accepted"
                    ));
                }
                negative_pivots = c.negative_pivots;
                state.work +=
                    follower_work(system, (&state.u, state.time), (&equation.u, target), &mut external);
                state.next_step = largest.min(2.0 * (target - state.time));
                state.u.copy_from_slice(&equation.u);
                // Twenty steps of 0.05 end at 1, and at round numbers on the way.
                state.time = if target == 1.0 { 1.0 } else { round_multiple(target, largest) };
                state.step += 1;
                let k = state_kinematics(system, &state.u, state.time);
                state.dissipated += newton.assembly.commit(system, &k);
                state.history.copy_from_slice(&newton.assembly.history);
                newton.assembly.reset_stress(system, &k);
                statistics.steps = state.step;
                if state.time >= 1.0 {
                    // What is written at the end needs memory, too.
                    newton.solver.release();
                }
                balance = energies(system, &mut newton.assembly, &state);
                observer.on_step(&Step {
                    state: &state,
                    balance: &balance,
                    statistics: &statistics,
                    iterations: c.iterations,
                    end: 1.0,
                })?;
                if observer.interrupted() && state.time < 1.0 {
                    return Err(Error::Interrupted);
                }
                continue;
            }
            Err(Diverged { iterations, reason, .. }) => {
                statistics.iterations += u64::from(iterations);
                if observer.interrupted() {
                    return Err(Error::Interrupted);
                }
                reason
            }
        };
        let step = 0.5 * (target - state.time);
        if step < smallest {
            observer.on_repeat(&statistics);
            return Err(Error::NotConverged {
                at: format!("load factor {target:.6}"),
                reason: failure,
                help: format!(
                    "The last equilibrium was at load factor {:.6}. Look at supports, units and load directions there; \
                     a limit point needs displacement control (`prescribe`).",
                    state.time
                ),
            });
        }
        statistics.cutbacks += 1;
        observer.on_repeat(&statistics);
        observer.on_event(&format!("load factor {target:.6} not reached: {failure}; the step is halved"));
        newton.restore(system, &state, state.step > 0);
        state.next_step = step;
    }
    Ok(StaticOutcome { state, balance, statistics, negative_pivots })
}

/// No step can be taken to a time at which an amplitude has no value.
pub(super) fn undefined(what: &str, (reached, wanted): (f64, f64), reason: String) -> Error {
    Error::NotConverged {
        at: format!("{what} {wanted:.6e}"),
        reason,
        help: format!(
            "Give the amplitude a formula or table that has finite values there. The last finished step ended at \
             {what} {reached:.6e}; results up to there are complete."
        ),
    }
}

fn energies(system: &System, assembly: &mut Assembly, state: &State) -> Balance {
    let strain = assembly.strain_energy(system, &state.u, state.time);
    let mut external = vec![[0.0; 3]; state.u.len()];
    system.add_dead_loads(state.time, 1.0, &mut external);
    let potential = -dot(&external, &state.u);
    Balance {
        strain,
        potential,
        work: state.work,
        dissipated: state.dissipated,
        total: strain + potential + state.dissipated - state.work,
        ..Balance::default()
    }
}

/// Work of the loads that follow the motion over a load step, by the trapezoidal rule.
fn follower_work(
    system: &System,
    (from, start): (&[Nodal], f64),
    (to, end): (&[Nodal], f64),
    force: &mut [Nodal],
) -> f64 {
    if system.followers.is_empty() {
        return 0.0;
    }
    force.fill([0.0; 3]);
    add_follower_loads(system, &state_kinematics(system, from, start), start, 0.5, force);
    add_follower_loads(system, &state_kinematics(system, to, end), end, 0.5, force);
    dot(force, to) - dot(force, from)
}

/// Reactions of the supports: force that they exert on the supported coordinates.
pub fn reactions(system: &System, assembly: &mut Assembly, state: &State) -> Vec<Nodal> {
    let n = system.vectors();
    let (mut internal, mut external) = (vec![[0.0; 3]; n], vec![[0.0; 3]; n]);
    let k = state_kinematics(system, &state.u, state.time);
    assembly.follow(system, &k);
    assembly.forces(system, &k, &mut internal);
    system.add_dead_loads(state.time, 1.0, &mut external);
    add_follower_loads(system, &k, state.time, 1.0, &mut external);
    for (f, e) in internal.iter_mut().zip(&external) {
        for i in 0..3 {
            f[i] -= e[i];
        }
    }
    let mut out = vec![[0.0; 3]; n];
    assembly.numbering.supported_part(&internal, &mut out);
    out
}

/// A load factor without the rounding that adding steps leaves: a multiple of a 2⁻²⁰th of the largest step.
fn round_multiple(factor: f64, step: f64) -> f64 {
    const PARTS: f64 = (1u32 << 20) as f64;
    (factor / step * PARTS).round() / PARTS * step
}
