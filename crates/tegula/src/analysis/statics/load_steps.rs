//! Load steps of a static analysis, with cut-backs.

mod along_path;
mod judgement;
mod preload;

use super::continued::on_path;
use super::failure::{CriticalPoint, Failure, Kind, name};
use super::{StaticEquation, energies, equilibrium_step, reactions, undefined};
use crate::analysis::bending_watch::BendingWatch;
use crate::analysis::drilling::DrillingWatch;
use crate::analysis::mobility;
use crate::analysis::newton::{Cause, Converged, Newton, Tolerances};
use crate::analysis::solver::TangentSolver;
use crate::analysis::stepper::Reached;
use crate::analysis::stops::Stops;
use crate::analysis::{Balance, Observer, State, Statistics, Stepper, Watched, equilibrium};
use crate::element::Nodal;
use crate::model::{NewtonMethod, StaticAnalysis};
use crate::norm::larger;
use crate::system::{EvaluationPoint, System};
use crate::{Error, Result};

/// Displacement of a step over the size of the model that is round-off of directors, as where loads have not begun yet.
const ROUND_OFF: f64 = 1e-14;

/// Energy of the last increment over the strain energy: small enough that reactions balance the loads to 1e-12, also
/// where follower loads make convergence linear.
const ENERGY_TOLERANCE: f64 = 1e-18;
/// Norm of the last increment over that of the displacement.
const INCREMENT_TOLERANCE: f64 = 1e-6;
/// Number of halvings of a load step after which its length is round-off of the load factor.
const MOST_CUTBACKS: i32 = 40;

/// Cut-backs of a step after which an analysis that goes on along the path does so where there is evidence of a critical point.
const BEFORE_PATH: u32 = 3;

/// State of a static analysis before its first step: where the analysis step before has ended, or the reference
/// configuration.
pub fn first_state(system: &System, options: &StaticAnalysis) -> State {
    let state = State {
        time: system.first_load_factor(),
        next_step: 1.0 / f64::from(options.load_steps.max(1)),
        ..State::first(system)
    };
    if options.continuation.is_some() { on_path(state) } else { state }
}

/// Static analysis between two load steps.
pub(super) struct LoadSteps<'a, S> {
    newton: Newton<S>,
    system: &'a System,
    options: &'a StaticAnalysis,
    tolerances: Tolerances,
    /// Form of Newton's method that suits the materials, or that the user chose.
    default_form: NewtonMethod,
    /// First and longest step.
    largest: f64,
    /// Load factors at which steps end whatever their length.
    stops: Stops,
    /// Smallest step over the distance between two stops, or over a load step; a run with shorter steps gives up.
    smallest_part: f64,
    /// Load factor at which the next step ends at the latest.
    limit: f64,
    /// The last equilibrium.
    state: State,
    /// Equation of the next equilibrium.
    equation: StaticEquation,
    balance: Balance,
    statistics: Statistics,
    external: Vec<Nodal>,
    /// Reactions at the last equilibrium; empty where no motion is prescribed.
    reactions: Vec<Nodal>,
    drilling: DrillingWatch,
    bending: BendingWatch,
    /// Tangents factored along equilibrium paths that are no results.
    factorizations_on_paths: u64,
    /// Load factor at the next limit point of the path, where it is known; no load step passes it.
    limit_on_path: Option<f64>,
    /// Whether an equilibrium path may lead on from where the last step has failed.
    goes_on: bool,
    /// First step from a stressed reference configuration, where the preload of its springs is ramped.
    first_step: Option<Box<preload::FirstStep>>,
    /// Whether the first step from a stressed reference configuration is taken as it is found.
    without_ramp: bool,
    /// Scratch space for the forces in the snap-through test of a step.
    buffers: [Vec<Nodal>; 2],
}

impl<'a, S: TangentSolver> LoadSteps<'a, S> {
    /// Starts from `start`, or from the reference configuration where there is none.
    pub fn new(
        mut newton: Newton<S>,
        system: &'a System,
        options: &'a StaticAnalysis,
        start: Option<State>,
    ) -> Self {
        let largest = 1.0 / f64::from(options.load_steps.max(1));
        let mut state = start.unwrap_or_else(|| first_state(system, options));
        newton.restore(system, &state, is_loaded(system, &state));
        if state.step == 0 && system.continues() {
            // On the way back to the unloaded state those of the iterates vanish.
            state.energy_scale = energies(system, &mut newton.assembly, &state).strain;
            state.displacement_scale = system.norm(&state.u);
        }
        // The tangent of a linear model is the same in smaller steps: they cannot help.
        let cutbacks = if system.linear { 0 } else { options.max_cutbacks as i32 };
        let moved = !system.dofs().prescribed.is_empty();
        Self {
            tolerances: Tolerances {
                energy: ENERGY_TOLERANCE,
                increment: INCREMENT_TOLERANCE,
                max_iterations: options.max_iterations,
            },
            default_form: newton.method(),
            largest,
            stops: Stops::of(system, 1.0, Vec::new()),
            limit: f64::INFINITY,
            smallest_part: 0.5_f64.powi(cutbacks.min(MOST_CUTBACKS)),
            equation: StaticEquation {
                u: state.u.clone(),
                time: state.time,
                scales: [0.0; 2],
                attempts: 0,
                multipliers: state.multipliers.clone(),
                angles: state.angles.clone(),
                penalty: equilibrium::penalty(system, &mut newton.assembly, &state),
            },
            balance: Balance::default(),
            statistics: Statistics { steps: state.step, ..Statistics::default() },
            external: vec![[0.0; 3]; system.vectors()],
            reactions: if moved { reactions(system, &mut newton.assembly, &state) } else { Vec::new() },
            drilling: DrillingWatch::new(),
            bending: BendingWatch::new(),
            factorizations_on_paths: 0,
            limit_on_path: None,
            goes_on: false,
            first_step: None,
            without_ramp: false,
            buffers: std::array::from_fn(|_| vec![[0.0; 3]; system.vectors()]),
            newton,
            system,
            options,
            state,
        }
    }

    /// Whether an equilibrium path may lead on from where the last step has failed: at a critical point.
    pub fn path_leads_on(&self) -> bool {
        self.goes_on
    }

    /// System, state, run counters, and the load factor at which the next step ends at the latest.
    pub fn parts(&self) -> (&'a System, &State, &Statistics, f64) {
        (self.system, &self.state, &self.statistics, self.limit)
    }

    /// Whether unstable equilibria end load steps: where the analysis goes on along the path, they end at the first one.
    fn accepts_unstable(&self) -> bool {
        self.options.allow_unstable && self.options.continuation.is_none()
    }

    /// Load factor at the end of the next step.
    fn target(&self) -> f64 {
        let end = self.stops.load_step_end(self.state.time, self.state.next_step, self.options.load_steps);
        end.min(self.limit)
    }

    /// Iterates to the equilibrium at a load factor; the inner error gives the reason why none is accepted.
    ///
    /// Where one form of Newton's method does not converge, the other is tried before a cut-back.
    fn attempt(
        &mut self,
        target: f64,
        observer: &mut dyn Observer,
    ) -> Result<std::result::Result<Converged, Failure>> {
        if let Some(limit) = self.limit_on_path.filter(|limit| target > *limit) {
            return Ok(Err(Failure::of_limit(limit)));
        }
        let form = self.form(self.state.other_form);
        self.newton.set_method(form);
        let failure = match self.iterate(target, observer)? {
            Ok(converged) => return Ok(self.judge(target, converged, observer)),
            Err(failure) => failure,
        };
        if self.options.method.is_some() || self.system.linear || !failure.depends_on_the_form() {
            return Ok(Err(failure));
        }
        let other = self.form(!self.state.other_form);
        observer.on_event(&format!(
            "load factor {target:.6}: {} did not converge ({}); trying {}",
            name(form),
            failure.reason,
            name(other)
        ));
        self.newton.restore(self.system, &self.state, is_loaded(self.system, &self.state));
        self.newton.set_method(other);
        Ok(match self.iterate(target, observer)? {
            Ok(converged) => {
                let judged = self.judge(target, converged, observer);
                self.state.other_form ^= judged.is_ok();
                judged
            }
            Err(second) => Err(Failure {
                negative_pivots: failure.negative_pivots.max(second.negative_pivots),
                reason: format!("{}; {} did not converge either", failure.reason, name(other)),
                ..failure
            }),
        })
    }

    /// Form of Newton's method that suits the materials, or the other one.
    fn form(&self, other: bool) -> NewtonMethod {
        match self.default_form {
            NewtonMethod::Mixed if other => NewtonMethod::Displacement,
            NewtonMethod::Displacement if other => NewtonMethod::Mixed,
            form => form,
        }
    }

    /// Iterates with the present form of Newton's method.
    fn iterate(
        &mut self,
        target: f64,
        observer: &mut dyn Observer,
    ) -> Result<std::result::Result<Converged, Failure>> {
        let Self { newton, system, state, equation, .. } = self;
        equation.u.copy_from_slice(&state.u);
        equation.multipliers.copy_from_slice(&state.multipliers);
        equation.angles.copy_from_slice(&state.angles);
        equation.time = target;
        equation.scales = [state.energy_scale, state.displacement_scale];
        newton.count_turns(system, state);
        match newton.solve(system, equation, &state.history, &self.tolerances, observer) {
            Ok(converged) => {
                self.statistics.iterations += u64::from(converged.iterations);
                Ok(Ok(converged))
            }
            Err(diverged) => {
                self.statistics.iterations += u64::from(diverged.iterations);
                if observer.interrupted() { Err(Error::Interrupted) } else { Ok(Err(diverged.into())) }
            }
        }
    }

    /// Accepts the equilibrium as the state at the end of the step.
    fn accept(&mut self, target: f64, converged: &Converged, observer: &mut dyn Observer) {
        let Self { newton, system, state, equation, external, .. } = self;
        if state.step == 0 {
            let redundant = newton.constraints.iter().flat_map(|constraints| constraints.redundant(system));
            redundant.for_each(|message| observer.on_warning(&message));
        }
        state.negative_pivots = converged.negative_pivots;
        state.compliance = converged.first_increment / (target - state.time);
        // The length of a step that a stop has shortened is no measure for the next one.
        state.next_step = self.largest.min(state.next_step.max(2.0 * (target - state.time)));
        equilibrium_step::take(
            system,
            &mut newton.assembly,
            (state, equation),
            (external, &mut self.reactions),
        );
        newton.assembly.reset_stress(system, &state.point(system));
        equation.attempts = 0;
        self.statistics.steps = state.step;
        if let Some(path) = &mut state.path {
            path.position = state.time;
            path.loads = [path.loads[0].min(state.time), larger(path.loads[1], state.time)];
            path.finished = state.time >= 1.0;
        }
        if state.time >= 1.0 {
            // Writing the final results needs memory, too.
            newton.solver.release();
        }
        self.balance = energies(system, &mut newton.assembly, state);
        state.energy_scale = state.energy_scale.max(self.balance.strain);
        state.displacement_scale = state.displacement_scale.max(system.norm(&state.u));
        let at = (state.u.as_slice(), state.time);
        self.drilling.look(system, at, observer, || format!("load factor {target}"));
        self.bending.look(system, at.0, observer, || format!("load factor {target}"));
    }

    /// Whether a step is not cut back any more.
    fn has_shortest_length(&self, target: f64) -> bool {
        let (last, next) = self.stops.bracket(self.state.time, self.options.load_steps);
        0.5 * (target - self.state.time) < (next - last) * self.smallest_part
    }

    /// Cuts a step that failed back to half its length, or gives up.
    fn cut_back(&mut self, target: f64, failure: Failure, observer: &mut dyn Observer) -> Result<()> {
        let step = 0.5 * (target - self.state.time);
        // A path begins in equilibrium only.
        if self.options.continuation.is_some() && self.begins_ramp((target, &failure), observer) {
            return Ok(());
        }
        if self.has_shortest_length(target) {
            if self.begins_ramp((target, &failure), observer) || self.takes_first_step(observer) {
                return Ok(());
            }
            observer.on_repeat(&self.statistics);
            return Err(self.give_up(target, &failure));
        }
        let may_go_on = self.options.continuation.is_some()
            && !self.ramps_preload()
            && self.equation.attempts >= BEFORE_PATH;
        if may_go_on && self.critical_point(target, &failure).is_some() {
            return Err(self.give_up(target, &failure));
        }
        self.statistics.cutbacks += 1;
        self.equation.attempts += 1;
        observer.on_repeat(&self.statistics);
        observer.on_event(&format!(
            "load factor {target:.6} not reached: {}; cut-back to half the step",
            failure.reason
        ));
        self.newton.restore(self.system, &self.state, is_loaded(self.system, &self.state));
        self.state.next_step = step;
        Ok(())
    }

    /// Error of a step that no cut-back can save.
    fn give_up(&mut self, target: f64, failure: &Failure) -> Error {
        let earlier = self.back_to_reference();
        let (target, failure) =
            earlier.as_ref().map_or((target, failure), |(target, failure)| (*target, failure));
        // Motions that tension holds are no mechanisms.
        let free = mobility::neutral_motions(self.system, &self.state);
        if !free.is_empty() {
            return of_mechanism(&self.state, target, (&free, failure));
        }
        let rounding =
            self.negative_pivots_at_rest(failure).map(|pivots| Failure::of_rounding(self.system, pivots));
        let failure = rounding.as_ref().unwrap_or(failure);
        let singular = failure.of_singular_equilibrium(&self.state);
        let failure = singular.as_ref().unwrap_or(failure);
        let critical = self.critical_point(target, failure);
        let other = matches!(failure.kind, Kind::Unstable | Kind::Leap | Kind::Iteration(_))
            && failure.kind != Kind::Iteration(Cause::Material);
        self.goes_on = (critical.is_some() || other) && !self.ramps_preload();
        let (system, options, state) = (self.system, self.options, &self.state);
        let unknown = critical.is_none() && matches!(failure.kind, Kind::Rounding | Kind::Iteration(_));
        if let Some(spring) = [&state.u, &self.equation.u].into_iter().filter(|_| unknown).find_map(|u| {
            let at = EvaluationPoint::at_rest(system, u, target, &state.history);
            self.newton.assembly.falling_force(system, &at)
        }) {
            return of_falling_force(state, target, (&spring, failure));
        }
        Error::NotConverged {
            at: format!("load factor {target:.6}"),
            reason: failure.told(system, state, target, critical.as_ref()),
            help: format!(
                "{}The last equilibrium was at load factor {:.6}. {}",
                if target <= 0.0 && self.ramps_preload_alone() {
                    "From load factor -1 to 0 the preload of springs is ramped that are stressed in the reference configuration. "
                } else if target <= 0.0 && state.time < 0.0 {
                    "From load factor -1 to 0 the loads and prescribed values grow to those of their amplitudes at 0. "
                } else {
                    ""
                },
                state.time,
                failure.remedy(system, options, critical.as_ref())
            ),
        }
    }

    /// Refuses an equilibrium at the end of the analysis from which a mechanism may move to others freely.
    fn refuse_one_of_many(&self, target: f64) -> Result<()> {
        if target < 1.0 || self.accepts_unstable() || !mobility::is_searched(self.system) {
            return Ok(());
        }
        let StaticEquation { u, multipliers, angles, .. } = &self.equation;
        let found = State {
            u: u.clone(),
            time: target,
            multipliers: multipliers.clone(),
            angles: angles.clone(),
            ..self.state.clone()
        };
        let neutral = mobility::neutral_motions(self.system, &found);
        if neutral.is_empty() {
            return Ok(());
        }
        Err(Error::NotConverged {
            at: format!("load factor {target:.6}"),
            reason: mobility::told_neutral(&neutral),
            help: format!(
                "The last equilibrium was at load factor {:.6}. Hold the free motions by joints, drives or springs.",
                self.state.time
            ),
        })
    }

    /// Negative pivots of the tangent of the unloaded structure: without stresses it has none but for round-off. `None`
    /// where a failure is of another kind.
    fn negative_pivots_at_rest(&mut self, failure: &Failure) -> Option<usize> {
        let rest = !is_loaded(self.system, &self.state) && self.system.prescribed_strains.is_empty();
        if failure.negative_pivots == 0 || !(rest || self.system.linear) {
            return None;
        }
        if self.system.linear {
            return Some(failure.negative_pivots);
        }
        let Self { newton, system, state, equation, .. } = self;
        newton.restore(system, state, false);
        let at_rest = StaticEquation { u: state.u.clone(), time: state.time, ..equation.clone() };
        newton.negative_pivots(system, &at_rest, &state.history).ok().filter(|&n| n > 0)
    }

    /// Critical point between the last equilibrium and a load factor that was not reached, if there is evidence of one.
    fn critical_point(&mut self, target: f64, failure: &Failure) -> Option<CriticalPoint> {
        if self.system.linear || (failure.negative_pivots == 0 && failure.kind != Kind::Leap) {
            return None;
        }
        let first_load_factor = self.first_load_factor();
        let Self { newton, system, state, equation, .. } = self;
        newton.restore(system, state, is_loaded(system, state));
        let at = |time| StaticEquation { u: state.u.clone(), time, ..equation.clone() };
        let (response, mode, _) =
            newton.softest_mode(system, (&at(state.time), &at(target)), &state.history).ok()?;
        let first = State::first(system).u;
        let moved: Vec<Nodal> =
            state.u.iter().zip(&first).map(|(u, f)| std::array::from_fn(|i| u[i] - f[i])).collect();
        let mean = system.norm(&moved) / (state.time - first_load_factor);
        let softened = response / (target - state.time) / mean;
        let mut critical = CriticalPoint::of(failure, mode, softened)?;
        critical.look_at_enhanced_strains(system, state);
        Some(critical)
    }
}

impl<S: TangentSolver> Stepper for LoadSteps<'_, S> {
    fn reached(&self) -> Reached<'_> {
        let Self { state, balance, statistics, .. } = self;
        Reached { state, balance, statistics, end: 1.0 }
    }

    fn finish(self: Box<Self>) -> (State, Balance, Statistics) {
        (self.state, self.balance, self.statistics)
    }

    fn begin(&mut self, _: &mut dyn Observer) -> Result<bool> {
        Ok(false)
    }

    fn advance(&mut self, observer: &mut dyn Observer) -> Result<u32> {
        let mut iterations = 0;
        loop {
            let target = self.target();
            if let Some(reason) = self.system.undefined_amplitude(target) {
                return Err(undefined("load factor", (self.state.time, target), reason));
            }
            if let Some(drive) = self.system.drive_turns_too_far(self.state.time, target) {
                let reason = format!("{drive} in the load step");
                self.cut_back(target, Failure::new(Kind::Iteration(Cause::Flight), reason, 0), observer)?;
                continue;
            }
            let outcome = self.attempt(target, observer);
            let outcome = match outcome {
                Ok(Err(failure)) if self.has_shortest_length(target) => {
                    Ok(self.at_sharp_turn(target, failure, observer))
                }
                outcome => outcome,
            };
            self.statistics.factorizations =
                self.newton.solver.tangents() as u64 + self.factorizations_on_paths;
            self.statistics.linear_iterations = self.newton.linear_iterations();
            match outcome? {
                Ok(converged) if self.leaves_stressed_reference(target, &converged, observer) => {}
                Ok(converged) => {
                    match self.meets_negative_pivots(&converged).filter(|_| self.ramps_preload()) {
                        Some(failure) => self.cut_back(target, failure, observer)?,
                        None => {
                            self.refuse_one_of_many(target)?;
                            self.accept(target, &converged, observer);
                            iterations += converged.iterations;
                            if !self.is_within_first_step() {
                                return Ok(iterations);
                            }
                        }
                    }
                }
                Err(failure) => self.cut_back(target, failure, observer)?,
            }
        }
    }

    fn repeat(&mut self, start: &State, end: f64) {
        let Self { newton, system, state, equation, .. } = self;
        state.clone_from(start);
        (self.first_step, self.limit_on_path) = (None, None);
        self.without_ramp = false;
        newton.reset();
        newton.restore(system, state, is_loaded(system, state));
        equation.attempts = 0;
        if !self.reactions.is_empty() {
            self.reactions = reactions(system, &mut newton.assembly, state);
        }
        self.balance = energies(system, &mut newton.assembly, state);
        self.statistics.steps = state.step;
        self.limit = end;
    }

    fn release(&mut self) {
        self.limit = f64::INFINITY;
    }

    fn watch(&mut self, watched: &Watched) {
        self.state.watched.clone_from(watched);
    }
}

/// Error of a mechanism whose free motions come to no stable equilibrium under its loads.
fn of_mechanism(state: &State, target: f64, (free, failure): (&[String], &Failure)) -> Error {
    Error::NotConverged {
        at: format!("load factor {target:.6}"),
        reason: format!(
            "the model is a mechanism: joints, springs and supports leave {} motion(s) free: {}. Under its loads it has found no stable \
             equilibrium: {}",
            free.len(),
            free.join("; "),
            failure.reason
        ),
        help: format!(
            "The last equilibrium was at load factor {:.6}. Hold the free motions by joints, drives or springs; or begin nearer to the \
             equilibrium, or let a transient analysis with damping find it.",
            state.time
        ),
    }
}

/// Error of a model that a spring without positive stiffness leaves without a stable equilibrium.
fn of_falling_force(state: &State, target: f64, (spring, failure): (&str, &Failure)) -> Error {
    Error::NotConverged {
        at: format!("load factor {target:.6}"),
        reason: format!("{spring}. {}", failure.reason),
        help: format!(
            "The last equilibrium was at load factor {:.6}. Look at the sign of the force, which is positive where the spring pulls its points \
             together, and at the largest load that it can hold; a transient analysis needs no stiffness.",
            state.time
        ),
    }
}

/// Whether a state has been reached by load steps, of this analysis or of one before; else it is the reference
/// configuration, which need not be an equilibrium.
fn is_loaded(system: &System, state: &State) -> bool {
    state.step > 0 || system.continues()
}
