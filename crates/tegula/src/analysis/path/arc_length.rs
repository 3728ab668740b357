//! Steps of a path by the arc-length method.
//!
//! A step goes along the direction of the path by a length s, and Newton's method corrects on the plane across it at this distance. The
//! tangent at the equilibrium found gives the next direction and the derivative of the load factor, and its negative eigenvalues tell
//! critical points. A step whose two directions and chord do not fit one smooth curve is halved: it may have gone over to another path.
//! The length follows from the distance between the predicted and the corrected point, half the curvature of the path times s².
//!
//! Steps end at limit points, at load factors that are wanted, and at the end of the path. There is nothing but the state between two
//! steps, so that a run can be resumed anywhere.

mod flutter;
mod inside_step;
mod limits;
mod opposite;
mod step_length;
mod switching;
mod without_potential;

use super::critical_points::Found;
use super::series::Series;
use super::start::{away_from_critical_point, forward, hold_mechanisms, in_equilibrium};
use super::state::{
    ArcStart, CriticalKind, CriticalPoint, ExpansionPoint, PathState, ended_early, not_continued,
};
use super::{SeriesSteps, branch, first_state};
use crate::analysis::bending_watch::BendingWatch;
use crate::analysis::modal::{GrowingMotion, KnownModes};
use crate::analysis::newton::{LoadResponse, NOTHING_MOVES, Newton, PathTangent, Plane, Tolerances};
use crate::analysis::potential::{Place, have_potential};
use crate::analysis::solver::TangentSolver as _;
use crate::analysis::statics::{self, StaticEquation, equilibrium_step, reactions};
use crate::analysis::stepper::Reached;
use crate::analysis::unstable_modes::UnstableModes;
use crate::analysis::{Balance, Observer, State, Statistics, Stepper, Watched, equilibrium};
use crate::element::Nodal;
use crate::model::PathAnalysis;
use crate::norm::larger;
use crate::system::{CirculatoryStiffness, System, inverted_element};
use crate::{Error, Result};
use inside_step::{Explained, Known};
use limits::EigenvalueCount;

/// Convergence of an equilibrium: energy of the last increment over the strain energy, its norm over that of the displacement, and the
/// most iterations.
const TOLERANCES: Tolerances = Tolerances { energy: 1e-18, increment: 1e-6, max_iterations: 20 };
/// Part of the load factor at the end that the first step is expected to reach, and its largest length.
const FIRST: f64 = 0.1;
const FIRST_LENGTH: f64 = 0.05;
/// Least cosine of the angle between the directions at both ends.
const TURN: f64 = 0.7;
/// Halvings of a step after which the path is given up.
const MOST_HALVINGS: u32 = 24;
/// Length of the first step on a crossing path over the distance at which it is looked for first.
const ON_BRANCH: f64 = 10.0;
/// Displacement under the load at the end of the path, by the tangent at its start, that is round-off.
const MOTIONLESS: f64 = 1e-13;
/// Critical points in succession at one load factor, after which a path does not get away from there.
const IN_PLACE: usize = 3;
/// Difference of load factors of critical points over them below which they are one.
const SAME_PLACE: f64 = 1e-6;
/// Distance of two load factors, over the size of the larger, below which they are one.
const SAME_LOAD: f64 = 1e-12;

/// A path of arc-length steps between two of its points.
pub struct ArcLengthSteps<'a> {
    newton: Newton,
    response: LoadResponse,
    system: &'a System,
    options: PathAnalysis,
    /// The last equilibrium.
    state: State,
    /// Equation of the next equilibrium.
    equation: StaticEquation,
    balance: Balance,
    statistics: Statistics,
    /// Factorisations of the power series before.
    earlier: u64,
    /// Path parameter at which the next step ends at the latest.
    limit: f64,
    /// Reactions at the last equilibrium; empty where no motion is prescribed.
    reactions: Vec<Nodal>,
    force: Vec<Nodal>,
    /// Unstable modes of the last equilibrium, where they are known.
    unstable: Option<UnstableModes>,
    /// Modes of an equilibrium before, under loads without a potential.
    modes: Option<KnownModes>,
    /// Whether it is told that equilibria are watched for flutter.
    watches: bool,
    /// Whether it is told that the modes of the equilibria are not found.
    unknown: bool,
    bending: BendingWatch,
}

/// End of a step, an equilibrium on the path.
#[derive(Clone)]
struct End {
    /// Distance from the start of the step.
    a: f64,
    equation: StaticEquation,
    tangent: PathTangent,
    negative: usize,
    iterations: u32,
}

/// Result of a step.
struct Outcome {
    end: End,
    /// Negative eigenvalues at the start of the step.
    negative: usize,
    critical: Vec<Found>,
    /// Unstable modes at the end, where they are known.
    unstable: Option<UnstableModes>,
    /// Motion about the end that grows, if one does, where it was looked for.
    growing: Option<Option<GrowingMotion>>,
    /// Length of the next step.
    length: f64,
}

impl<'a> ArcLengthSteps<'a> {
    /// Path from `start`, a state of the same analysis, or from its first state.
    ///
    /// # Errors
    /// There is not enough memory.
    pub fn new(system: &'a System, options: &PathAnalysis, start: Option<State>) -> Result<Self> {
        let mut newton = Newton::new(system, None)?;
        let mut state = start.filter(|state| state.path.is_some()).unwrap_or_else(|| first_state(system));
        newton.restore(system, &state, true);
        if let Some(constraints) = &mut newton.constraints {
            constraints.pass_critical_points();
        }
        if state.step == 0 && system.continues() {
            state.energy_scale = statics::energies(system, &mut newton.assembly, &state).strain;
            state.displacement_scale = system.norm(&state.u);
        }
        let moves = !system.dofs().prescribed.is_empty();
        Ok(Self {
            reactions: if moves { reactions(system, &mut newton.assembly, &state) } else { Vec::new() },
            balance: statics::energies(system, &mut newton.assembly, &state),
            statistics: Statistics { steps: state.step, ..Statistics::default() },
            equation: StaticEquation {
                penalty: equilibrium::penalty(system, &mut newton.assembly, &state),
                ..StaticEquation::default()
            },
            response: LoadResponse::new(system),
            force: vec![[0.0; 3]; system.vectors()],
            unstable: None,
            modes: None,
            watches: false,
            unknown: false,
            bending: BendingWatch::new(),
            earlier: 0,
            limit: f64::INFINITY,
            newton,
            options: options.clone(),
            system,
            state,
        })
    }

    /// Number of negative eigenvalues of the tangent at the first state of a path, which an analysis step before may have left unstable; 0 where the
    /// tangent has no factor, where the path does not begin.
    ///
    /// # Errors
    /// There is not enough memory.
    pub fn negative_eigenvalues(system: &'a System, state: &State) -> Result<usize> {
        let mut steps = Self::new(system, &PathAnalysis::default(), Some(state.clone()))?;
        steps.go_back();
        let Self { newton, equation, .. } = &mut steps;
        Ok(newton.negative_pivots(system, equation, &state.history).unwrap_or(0))
    }

    /// Path behind other steps, from their last state.
    ///
    /// # Errors
    /// There is not enough memory.
    pub fn behind_steps(
        system: &'a System,
        options: &PathAnalysis,
        (state, statistics, limit): (&State, &Statistics, f64),
    ) -> Result<Self> {
        let steps = Self::new(system, options, Some(state.clone()))?;
        Ok(Self { statistics: *statistics, earlier: statistics.factorizations, limit, ..steps })
    }

    /// Path behind the last piece of power series that lead no further, from the point where the next one was begun.
    ///
    /// # Errors
    /// There is not enough memory, or the tangent has no factor.
    pub fn behind(series: &SeriesSteps<'a>, end: &ExpansionPoint) -> Result<Self> {
        let (system, options, state, statistics, limit) = series.parts();
        let state = State { u: end.u.clone(), time: end.load, ..state.clone() };
        let mut steps = Self::new(system, options, Some(state))?;
        steps.go_back();
        let Self { newton, state, equation, response, .. } = &mut steps;
        let at = (&mut *equation, state.history.as_slice());
        let (tangent, negative) = newton
            .path_tangent(system, at, Some(&end.direction), response)
            .map_err(|reason| not_continued(system, state, &reason))?;
        if let Some(path) = &mut state.path {
            let is_on_branch = end.expected == 0.0;
            let length =
                if is_on_branch { ON_BRANCH * branch::FIRST } else { end.expected.min(FIRST_LENGTH) };
            if is_on_branch {
                state.negative_pivots = negative;
            }
            path.arc = Some(ArcStart { tangent, length });
            path.expansion.clone_from(end);
        }
        steps.statistics = *statistics;
        (steps.earlier, steps.limit) = (statistics.factorizations, limit);
        Ok(steps)
    }

    fn path(&self) -> Option<&PathState> {
        self.state.path.as_deref()
    }

    /// Equation at the last equilibrium.
    fn go_back(&mut self) {
        let Self { state, equation, newton, system, .. } = self;
        equation.u.clone_from(&state.u);
        equation.multipliers.clone_from(&state.multipliers);
        equation.angles.clone_from(&state.angles);
        equation.time = state.time;
        equation.scales = [state.energy_scale, state.displacement_scale];
        newton.count_turns(system, state);
    }

    /// Direction and length of the next step.
    fn start_of_step(&mut self) -> std::result::Result<ArcStart, String> {
        if let Some(arc) = self.path().and_then(|path| path.arc.clone()) {
            return Ok(arc);
        }
        self.go_back();
        let Self { newton, system, state, equation, response, options, .. } = self;
        let at = (&mut *equation, state.history.as_slice());
        let (mut tangent, negative) = newton.path_tangent(system, at, None, response)?;
        let loads = response.size_of_loads(system) * options.end_load.abs();
        in_equilibrium(
            system,
            &mut newton.assembly,
            state,
            larger(loads, equation.penalty * system.length * system.length),
        )?;
        if (options.end_load / tangent.load).abs() <= MOTIONLESS {
            return Err(NOTHING_MOVES.into());
        }
        let backwards = match forward(system, &tangent.direction) {
            Some(forward) if state.step == 0 && options.end_load > 0.0 => !forward,
            _ => options.end_load < 0.0,
        };
        if backwards {
            tangent.reverse();
        }
        state.negative_pivots = negative;
        let length = (FIRST * options.end_load / tangent.load).abs().min(FIRST_LENGTH);
        Ok(ArcStart { tangent, length })
    }

    /// Equilibrium at the distance `a` from the last one along a direction.
    fn equilibrium_at(
        &mut self,
        tangent: &PathTangent,
        a: f64,
        observer: &mut dyn Observer,
    ) -> std::result::Result<End, String> {
        self.go_back();
        let origin = self.state.u.clone();
        let plane = Plane { origin: &origin, normal: &tangent.direction, distance: a };
        let iterations = self.correct((tangent, a), &plane, observer)?;
        self.end_at(a, tangent, iterations)
    }

    /// Moves the equation along a direction by a length, and corrects on a plane. Returns the number of iterations.
    fn correct(
        &mut self,
        (tangent, length): (&PathTangent, f64),
        plane: &Plane,
        observer: &mut dyn Observer,
    ) -> std::result::Result<u32, String> {
        let Self { newton, system, state, equation, response, statistics, .. } = self;
        let history = state.history.as_slice();
        newton.predict(system, (&mut *equation, history), tangent, length);
        let at = (&mut *equation, history);
        let solved = newton.solve_on_plane(system, at, (plane, response), &TOLERANCES, observer);
        statistics.iterations += u64::from(solved.as_ref().map_or_else(|failed| failed.iterations, |n| *n));
        solved.map_err(|failed| failed.reason)
    }

    /// End of a step at the equilibrium of the equation.
    fn end_at(&mut self, a: f64, before: &PathTangent, iterations: u32) -> std::result::Result<End, String> {
        let Self { newton, system, state, equation, response, .. } = self;
        if let Some(inverted) = inverted_element(system, &equation.u) {
            return Err(inverted);
        }
        if let Some(reason) = equilibrium_step::refusal(system, &newton.assembly, (state, equation)) {
            return Err(reason);
        }
        let at = (&mut *equation, state.history.as_slice());
        let (tangent, negative) = newton.path_tangent(system, at, Some(&before.direction), response)?;
        Ok(End { a, equation: equation.clone(), tangent, negative, iterations })
    }

    /// Step along the path of at most a length, which is the planned one but where the step has to end before.
    fn find_step(
        &mut self,
        arc: &ArcStart,
        [length, planned]: [f64; 2],
        observer: &mut dyn Observer,
    ) -> std::result::Result<Outcome, String> {
        self.find_modes_at_start(&arc.tangent);
        let mut end = self.equilibrium_at(&arc.tangent, length, observer)?;
        let (mut unstable, whole) = (self.modes_at_end(&end), end.a);
        let mut next = self.next_length(arc, &end)?;
        let loads = self.loads(arc, &end);
        let (limits, start) = self.limits(arc, (&end, &loads), observer)?;
        let simple = limits.is_empty() && start == EigenvalueCount::of(&end);
        let has_potential = simple || self.have_potential(&end.equation);
        if limits.len() > 1 {
            return Err("there may be two limit points in the step".into());
        }
        let mut known = None;
        let at = (arc, &mut known);
        let limit = self.end_before(
            at,
            (&loads, limits.first().copied()),
            (start, has_potential),
            &mut end,
            observer,
        )?;
        let mut critical = Vec::from_iter(limit);
        if end.a < length || length < planned {
            next = next.min(planned);
        }
        let negative = start.negative;
        let all = Explained { limits: &critical, start, has_potential };
        let mut found = self.other_bifurcations(&all, (arc, &mut known), &end, observer)?;
        if end.a != whole {
            unstable = self.modes_at_new_end(&end);
        }
        let opposite =
            self.opposite_bifurcations(&critical, &found, (arc, &mut known), (&end, &unstable), observer)?;
        found.extend(opposite);
        if !found.is_empty() {
            critical.extend(found);
            critical.sort_by(|p, q| p.a.total_cmp(&q.a));
            self.gets_away(&critical)?;
        }
        let (growing, onset) = self.flutter_within((arc, &mut known, negative), &end, &critical, observer);
        critical.extend(onset);
        critical.sort_by(|p, q| p.a.total_cmp(&q.a));
        let judged = end.a;
        if !critical.is_empty() {
            let known = known.get_or_insert_with(|| Known::new(self, (arc, negative), &end));
            if let Some(end) = self.go_over(arc, known, &mut critical, observer)? {
                let length = (ON_BRANCH * branch::FIRST).min(planned);
                return Ok(Outcome { end, negative, critical, unstable: None, growing: None, length });
            }
            self.end_inside(arc, known, (&mut critical, negative), &mut end, observer)?;
        }
        let stays = end.a == judged;
        let unstable = unstable.map(|(modes, _)| modes).filter(|_| stays);
        let growing = growing.filter(|_| stays);
        Ok(Outcome { end, negative, critical, unstable, growing, length: next })
    }

    /// Whether the follower loads have a potential at an equilibrium: then the tangent is symmetric.
    fn have_potential(&self, equation: &StaticEquation) -> bool {
        let Self { system, newton, .. } = self;
        let place = Place { u: &equation.u, time: equation.time, frames: &newton.assembly.frames };
        have_potential(system, &place, CirculatoryStiffness::new(system), &[])
    }

    /// Load factor over a step, by its values and derivatives at both ends.
    fn loads(&self, arc: &ArcStart, end: &End) -> Series {
        let turn = self.system.inner_product(&arc.tangent.direction, &end.tangent.direction);
        let (a, [from, to]) = (end.a, [self.state.time, end.equation.time]);
        let (first, last) = (arc.tangent.load, end.tangent.load / turn);
        let mean = (to - from) / a;
        let loads =
            vec![from, first, (3.0 * mean - 2.0 * first - last) / a, (first + last - 2.0 * mean) / (a * a)];
        Series { loads, ..Series::default() }
    }

    /// First place of a step, up to `end`, at which the load factor has a value that is wanted, and this value.
    fn wanted(&self, loads: &Series, end: f64) -> Option<(f64, f64)> {
        let from = self.state.time;
        let all = self.system.wanted_times.iter().copied().chain([self.options.end_load]);
        let other = all.filter(|load| !is_same_load(*load, from));
        let places = other.filter_map(|load| Some((loads.reaches(load, end).first().copied()?, load)));
        places.min_by(|p, q| p.0.total_cmp(&q.0))
    }

    /// Refuses a path that meets critical points at one load factor again and again: it does not get away from a bifurcation.
    fn gets_away(&self, critical: &[Found]) -> std::result::Result<(), String> {
        let Some(point) = critical.last().map(|found| &found.point) else { return Ok(()) };
        let earlier = self.path().map_or(&[][..], |path| &path.critical);
        let same = |other: &&CriticalPoint| (other.load - point.load).abs() <= SAME_PLACE * point.load.abs();
        let number =
            earlier.iter().rev().chain(critical.iter().map(|found| &found.point)).take_while(same).count();
        if number <= IN_PLACE + critical.len() {
            return Ok(());
        }
        Err(format!("the path does not get away from the critical point at load factor {:.6e}", point.load))
    }

    /// Makes the end of a step the state.
    fn accept(&mut self, outcome: Outcome, observer: &mut dyn Observer) {
        let Outcome { end, negative, critical, unstable, growing, length } = outcome;
        self.unstable = unstable;
        let Self { newton, system, state, equation, options, unknown, .. } = self;
        if state.step == 0 {
            let redundant = newton.constraints.iter().flat_map(|constraints| constraints.redundant(system));
            redundant.for_each(|message| observer.on_warning(&message));
        }
        let before = state.time;
        *equation = end.equation;
        equilibrium_step::take(
            system,
            &mut newton.assembly,
            (&mut *state, equation),
            (&mut self.force, &mut self.reactions),
        );
        self.balance = statics::energies(system, &mut newton.assembly, state);
        state.energy_scale = larger(state.energy_scale, self.balance.strain);
        state.displacement_scale = larger(state.displacement_scale, system.norm(&state.u));
        self.bending.look(system, &state.u, observer, || format!("load factor {}", state.time));
        state.negative_pivots = end.negative;
        self.statistics.steps = state.step;
        let is_onset = |found: &&Found| found.point.kind == CriticalKind::Flutter;
        let onset = critical.iter().find(is_onset).map(|found| found.point.load);
        let divergent = flutter::expected(state.path.as_deref(), &critical, f64::INFINITY);
        flutter::look((system, before, divergent), (state, unknown), (growing, onset), observer);
        let Some(path) = &mut state.path else { return };
        let mut negative = negative as i32;
        for Found { a, point } in critical {
            negative += point.change;
            path.expansion.bifurcations += usize::from(point.kind == CriticalKind::Bifurcation);
            let point = CriticalPoint { position: path.position + a, ..point };
            path.pass((system, options), &point, negative.max(0) as usize, observer);
        }
        path.position += end.a;
        path.expansion.number += 1;
        path.loads = [path.loads[0].min(state.time), larger(path.loads[1], state.time)];
        path.arc = Some(ArcStart { tangent: end.tangent, length });
        path.finished |= is_same_load(state.time, options.end_load);
        if !path.finished && path.expansion.number >= options.max_steps {
            path.finished = true;
            ended_early(state, options, observer);
        }
    }
}

fn is_same_load(a: f64, b: f64) -> bool {
    (a - b).abs() <= SAME_LOAD * larger(a.abs(), b.abs())
}

impl Stepper for ArcLengthSteps<'_> {
    fn reached(&self) -> Reached<'_> {
        let Self { state, balance, statistics, .. } = self;
        Reached { state, balance, statistics, end: self.options.end_load }
    }

    fn finish(self: Box<Self>) -> (State, Balance, Statistics) {
        (self.state, self.balance, self.statistics)
    }

    fn begin(&mut self, _: &mut dyn Observer) -> Result<bool> {
        Ok(false)
    }

    fn advance(&mut self, observer: &mut dyn Observer) -> Result<u32> {
        if observer.interrupted() {
            return Err(Error::Interrupted);
        }
        let before = self.statistics.iterations;
        let start = self.state.step == 0 && self.path().is_some_and(|path| path.arc.is_none());
        if start {
            flutter::look_at_start(self.system, (&mut self.state, &mut self.unknown), observer);
        }
        if let Some(direction) = away_from_critical_point(self.system, &self.options).filter(|_| start) {
            let outcome = self.step_away(direction, observer);
            let outcome = outcome.map_err(|reason| not_continued(self.system, &self.state, &reason))?;
            self.accept(outcome, observer);
            hold_mechanisms(self.system, &self.state)?;
            return Ok((self.statistics.iterations - before) as u32);
        }
        let arc = self.start_of_step().map_err(|reason| not_continued(self.system, &self.state, &reason))?;
        let mut planned = arc.length;
        for halving in 0.. {
            let length = planned.min(self.limit - self.position());
            let outcome = self.find_step(&arc, [length, planned], observer);
            self.statistics.factorizations = self.earlier + self.newton.solver.tangents() as u64;
            self.statistics.linear_iterations = self.newton.linear_iterations();
            match outcome {
                Ok(outcome) => {
                    self.accept(outcome, observer);
                    hold_mechanisms(self.system, &self.state)?;
                    break;
                }
                Err(_) if observer.interrupted() => return Err(Error::Interrupted),
                Err(reason) if halving == MOST_HALVINGS => {
                    observer.on_repeat(&self.statistics);
                    return Err(not_continued(self.system, &self.state, &reason));
                }
                Err(reason) => {
                    planned = 0.5 * length;
                    self.statistics.cutbacks += 1;
                    observer.on_repeat(&self.statistics);
                    observer.on_event(&format!(
                        "a step from load factor {:.6} is repeated with half its length: {reason}",
                        self.state.time
                    ));
                }
            }
        }
        Ok((self.statistics.iterations - before) as u32)
    }

    fn repeat(&mut self, start: &State, end: f64) {
        let Self { newton, system, state, reactions: forces, .. } = self;
        state.clone_from(start);
        self.unstable = None;
        if !forces.is_empty() {
            *forces = reactions(system, &mut newton.assembly, state);
        }
        self.balance = statics::energies(system, &mut newton.assembly, state);
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
