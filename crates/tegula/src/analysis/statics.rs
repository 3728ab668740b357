//! Static equilibrium.

mod connection;
mod continued;
mod enhanced;
pub mod equilibrium_step;
mod failure;
mod load_steps;

use super::newton::{Equation, Newton};
use super::path::{ArcLengthSteps, HandOver};
use super::solver::Iterative;
use super::{Balance, Observer, State, Statistics, Stepper, Stopped, equilibrium, stepper};
use crate::element::{Motion, Nodal, TangentWeights};
use crate::load::FollowerLoad;
use crate::model::{LinearSolver, StaticAnalysis};
use crate::system::assembly::{TangentCoefficients, add_follower_loads};
use crate::system::{Assembly, EvaluationPoint, Procedure, System, dot};
use crate::{Error, Result, Vec3};

use tegula_sparse::norm::{larger, max_norm};

use crate::system::inertia_relief::KEY as RELIEF;
pub(crate) use continued::path_options;
use load_steps::LoadSteps;
pub use load_steps::first_state;

/// Step limiter: largest rotation (rad) of the first increment of a load step. The response of the undeformed shell to
/// the whole load overshoots so far on thin shells that the way back takes longer: on the quarter cylinder of Sect. 5.2
/// with 64 × 64 elements limits of 0.3 to 0.5 take 8 tangents, 0.2 and 0.6 take 9, and 0.8 takes 13. Prescribed strains
/// bend shells without load, and full increments converge best there.
const FIRST_ROTATION: f64 = 0.4;
/// Largest number of reductions of the step limiter: a repeated step begins with a quarter of the rotation, the next
/// one with a sixteenth. Sheets that stretch long before they rotate far (L/h = 10⁵) find their equilibrium from there,
/// where no shorter step helps.
const MOST_SHORTENED: u32 = 2;
/// Largest force on a free degree of freedom over the largest internal force in an equilibrium that was computed.
const IN_EQUILIBRIUM: f64 = 1e-7;

/// Equilibrium at a load factor: `F(λ) − f_int(u) = 0`.
#[derive(Debug, Clone, Default)]
pub struct StaticEquation {
    /// Displacements.
    pub u: Vec<Nodal>,
    /// Load factor.
    pub time: f64,
    /// Smallest strain energy and displacement to which increments are compared: the largest equilibrium values of the
    /// path so far. On the way back to the unloaded state those of the iterate vanish.
    pub scales: [f64; 2],
    /// Repeated attempts at the present step: each reduces the step limiter.
    pub attempts: u32,
    /// Lagrange multipliers of joints.
    pub multipliers: Vec<f64>,
    /// Angles of sensors (rad), which continue from iterate to iterate.
    pub angles: Vec<f64>,
    /// Weight of the augmented Lagrangian of joints [force/length].
    pub penalty: f64,
}

impl Equation for StaticEquation {
    fn motion(&self) -> Motion<'_> {
        Motion::State { u: &self.u, velocity: None }
    }

    fn parts(&self) -> TangentCoefficients {
        let weights = TangentWeights { penalty: self.penalty, ..TangentWeights::STATIC };
        TangentCoefficients { weights, mass: 0.0, time: self.time }
    }

    fn external_minus_inertia(&self, system: &System, out: &mut [Nodal]) {
        out.fill([0.0; 3]);
        system.add_dead_loads(self.time, 1.0, out);
        add_follower_loads(system, &self.motion(), self.time, 1.0, out);
    }

    fn apply(&mut self, system: &System, increment: &[Nodal]) {
        add(&mut self.u, increment);
        let Self { u, angles, .. } = self;
        system.continue_angles(
            |v, part| std::array::from_fn(|i| u[v][i] - (1.0 - part) * increment[v][i]),
            angles,
        );
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

    fn energy_scale(&self, system: &System, assembly: &mut Assembly, history: &[f64]) -> f64 {
        let k = EvaluationPoint::at_rest(system, &self.u, self.time, history);
        assembly.strain_energy(system, &k).max(self.scales[0])
    }

    fn first_rotation_limit(&self, system: &System) -> Option<f64> {
        (!system.linear && system.prescribed_strains.is_empty())
            .then(|| FIRST_ROTATION / f64::from(1 << (2 * self.attempts.min(MOST_SHORTENED))))
    }

    fn displacement_scale(&self, system: &System) -> f64 {
        system.norm(&self.u).max(self.scales[1])
    }
}

/// Forces that hold the first state of a static step in equilibrium beside its loads and supports: the reactions of supports
/// that it has not any more. `None` where the state is in equilibrium.
pub fn released_reactions(system: &System) -> Option<Vec<Nodal>> {
    if !system.continues() {
        return None;
    }
    let first = State { time: system.first_load_factor(), ..State::first(system) };
    let mut assembly = Assembly::for_forces(system);
    let point = first.point(system);
    let (mut out, size) = unbalanced(system, &mut assembly, &point);
    // Inertia relief balances the released reactions, too: they are what the loads alone leave.
    system.add_inertia_relief(&point.motion, point.time, 1.0, &mut out);
    let mut supported = vec![[0.0; 3]; out.len()];
    assembly.frames.constrained_part(&out, &mut supported);
    // Supports of inertia relief carry nothing.
    for support in system.supports.iter().filter(|support| support.key == RELIEF) {
        let force = &mut supported[support.vector as usize];
        *force = (Vec3::from(*force) - support.direction * support.direction.dot(&Vec3::from(*force))).into();
    }
    for (out, supported) in out.as_flattened_mut().iter_mut().zip(supported.as_flattened()) {
        *out -= supported;
    }
    system.dofs().clear_bodies(&mut out);
    // Equilibria are found up to round-off.
    (max_norm(out.as_flattened()) > IN_EQUILIBRIUM * size).then_some(out)
}

/// Internal forces of a state less its loads, and the largest of both.
fn unbalanced(system: &System, assembly: &mut Assembly, k: &EvaluationPoint) -> (Vec<Nodal>, f64) {
    let mut internal = vec![[0.0; 3]; system.vectors()];
    assembly.follow(system, k);
    assembly.forces(system, k, &mut internal);
    let external = equilibrium::external(system, k);
    let size = larger(max_norm(internal.as_flattened()), max_norm(external.as_flattened()));
    for (f, e) in internal.as_flattened_mut().iter_mut().zip(external.as_flattened()) {
        *f -= e;
    }
    (internal, size)
}

/// Adds an increment to a field.
pub fn add(field: &mut [Nodal], increment: &[Nodal]) {
    for (x, d) in field.iter_mut().zip(increment) {
        for i in 0..3 {
            x[i] += d[i];
        }
    }
}

/// Increment of the constrained degrees of freedom to their prescribed values at a time; false if it vanishes.
pub fn prescribed_increment(system: &System, time: f64, u: &[Nodal], increment: &mut [Nodal]) -> bool {
    if system.dofs().prescribed.is_empty() {
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

/// Outcome of a static analysis, at full load or at a stop condition.
#[derive(Debug, Clone, PartialEq)]
pub struct StaticOutcome {
    /// Final state.
    pub state: State,
    /// Energies of the final state.
    pub balance: Balance,
    /// Run counters.
    pub statistics: Statistics,
    /// Negative pivots of the tangent at the end: above 0 the equilibrium is unstable.
    pub negative_pivots: usize,
    /// Stop condition at which the analysis has ended; `None` at full load.
    pub stopped: Option<Stopped>,
}

/// Runs a static analysis from `start`, a state of the same analysis (from its first state where `None`), to load
/// factor 1 or a stop condition.
///
/// # Errors
/// No equilibrium was found, or only an unstable one; the error names the load factor reached and describes the state. The observer
/// does not know the column of a stop condition.
pub fn run(
    system: &System,
    options: &StaticAnalysis,
    start: Option<State>,
    observer: &mut dyn Observer,
) -> Result<StaticOutcome> {
    let mut steps = steps(system, options, start)?;
    let stopped = stepper::run(steps.as_mut(), &options.stop, observer)?;
    let (state, balance, statistics) = steps.finish();
    if options.continuation.is_some() && stopped.is_none() {
        continued::accept_end(&state, options.allow_unstable)?;
    }
    Ok(StaticOutcome { negative_pivots: state.negative_pivots, state, balance, statistics, stopped })
}

/// Load steps of a static analysis from `start`, a state of the same analysis (from its first state where `None`).
///
/// # Errors
/// There is not enough memory, or the system was compiled for another analysis.
pub fn steps<'a>(
    system: &'a System,
    options: &'a StaticAnalysis,
    start: Option<State>,
) -> Result<Box<dyn Stepper + 'a>> {
    if options.continuation.is_some() {
        system.require(&[Procedure::Path])?;
        let start = continued::on_path(start.unwrap_or_else(|| first_state(system, options)));
        return Ok(Box::new(if continued::is_behind_load_steps(&start) {
            let steps = ArcLengthSteps::new(system, &path_options(), Some(start))?;
            HandOver::ArcLength { steps: Box::new(steps), begun: None }
        } else {
            let newton = Newton::new(system, options.method)?;
            HandOver::Before(Box::new(LoadSteps::new(newton, system, options, Some(start))))
        }));
    }
    system.require(&[Procedure::Static, Procedure::IterativeStatic, Procedure::Modal])?;
    Ok(match options.linear_solver {
        LinearSolver::Direct => {
            Box::new(LoadSteps::new(Newton::new(system, options.method)?, system, options, start))
        }
        LinearSolver::Iterative => {
            let newton = Newton::with_solver(system, options.method, Iterative::new(system)?);
            Box::new(LoadSteps::new(newton, system, options, start))
        }
    })
}

/// Error of a step to a time at which an amplitude is undefined.
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

/// Energies of the first state of a static analysis.
pub fn first_energies(system: &System, state: &State) -> Balance {
    energies(system, &mut Assembly::new(system), state)
}

pub(super) fn energies(system: &System, assembly: &mut Assembly, state: &State) -> Balance {
    let strain = assembly.strain_energy(system, &state.point(system));
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

/// Work of follower loads over a load step, by the trapezoidal rule.
pub(super) fn follower_work(
    system: &System,
    (from, start): (&[Nodal], f64),
    (to, end): (&[Nodal], f64),
    force: &mut [Nodal],
) -> f64 {
    if !system.has_follower_loads() {
        return 0.0;
    }
    force.fill([0.0; 3]);
    add_follower_loads(system, &Motion::State { u: from, velocity: None }, start, 0.5, force);
    add_follower_loads(system, &Motion::State { u: to, velocity: None }, end, 0.5, force);
    let of_bodies: f64 =
        system.followers.iter().map(|load| moment_work(system, load, [from, to], [start, end])).sum();
    dot(force, to) - dot(force, from) + of_bodies
}

/// Work of a moment on a body beyond the trapezoidal rule, which takes chords for arcs: with the rotation vector θ of the step it is
/// `m·θ`, which is exact about a fixed axis.
fn moment_work(system: &System, load: &FollowerLoad, u: [&[Nodal]; 2], [start, end]: [f64; 2]) -> f64 {
    let FollowerLoad::BodyMoment { directors, moment, factor } = load else { return 0.0 };
    if system.linear {
        return 0.0;
    }
    let at = |u: &[Nodal], v: u32| {
        Vec3::from(system.coordinates.reference[v as usize]) + Vec3::from(u[v as usize])
    };
    let [before, after] = u.map(|u| directors.map(|v| at(u, v)));
    let factors = [start, end].map(|time| system.factor(factor, time));
    let chord = |f: f64, at: &[Vec3; 3]| -> f64 {
        let parts = (0..3).map(|i| (moment * 0.5).cross(&at[i]).dot(&(after[i] - before[i])));
        f * parts.sum::<f64>()
    };
    // Of round-off alone the sine is round-off, too, where the arc cosine of the trace would be no number.
    let sine = (0..3).map(|i| before[i].cross(&after[i])).sum::<Vec3>() * 0.5;
    let cosine = 0.5 * ((0..3).map(|i| before[i].dot(&after[i])).sum::<f64>() - 1.0);
    let size = sine.norm();
    let arc = if size > 0.0 { sine * (size.atan2(cosine) / size) } else { sine };
    0.5 * (factors[0] + factors[1]) * moment.dot(&arc)
        - 0.5 * (chord(factors[0], &before) + chord(factors[1], &after))
}

/// Reactions of the supports: forces that they exert on the constrained degrees of freedom.
pub fn reactions(system: &System, assembly: &mut Assembly, state: &State) -> Vec<Nodal> {
    reactions_at(system, assembly, &state.point(system))
}

/// Reactions of the supports at an evaluation point.
fn reactions_at(system: &System, assembly: &mut Assembly, k: &EvaluationPoint) -> Vec<Nodal> {
    let (internal, _) = unbalanced(system, assembly, k);
    let mut out = vec![[0.0; 3]; internal.len()];
    assembly.frames.constrained_part(&internal, &mut out);
    out
}
