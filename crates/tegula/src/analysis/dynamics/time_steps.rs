//! Time steps of an implicit scheme, with step control and cut-backs.

use super::amplitude_check::AmplitudeCheck;
use super::difference_energy::DifferenceEnergy;
use super::drive_rates::DriveRates;
use super::energy_watch::{EnergyWatch, keeps_energy};
use super::joint_events::{JointEvents, Review};
use super::kinematics::determined;
use super::load_watch::LoadWatch;
use super::rank_watch::RankWatch;
use super::rotation_watch::RotationWatch;
use super::step_control::StepControl;
use super::step_end::{Span, StepEnds};
use super::trouble::{Trouble, advice};
use super::{Integrator, SMALLEST_STEP, balance, impact, initial_state, joint_impact, predictor, triads};
use crate::analysis::bending_watch::BendingWatch;
use crate::analysis::drilling::DrillingWatch;
use crate::analysis::newton::{Cause, Converged, Diverged, Newton, Tolerances};
use crate::analysis::statics::undefined;
use crate::analysis::stepper::Reached;
use crate::analysis::{Balance, Observer, State, Statistics, Stepper, Watched};
use crate::element::{Motion, Nodal};
use crate::model::TransientAnalysis;
use crate::system::{EvaluationPoint, OffCurve, System, inverted_element};
use crate::{Error, Result};
use tegula_sparse::Factor as _;
use tegula_sparse::norm::larger;

/// A transient analysis between two time steps.
pub(super) struct TimeSteps<'a> {
    pub system: &'a System,
    pub options: &'a TransientAnalysis,
    pub scheme: Box<dyn Integrator>,
    pub newton: Newton,
    pub tolerances: Tolerances,
    control: StepControl,
    ends: StepEnds,
    check: AmplitudeCheck,
    /// Friction and stops of joints.
    events: JointEvents,
    /// Length of the next trial of a step that ends at an event.
    event: Option<(f64, f64)>,
    /// Whether the present step is repeated with other modes of friction and stops.
    reviewing: bool,
    /// Steps one after another that have ended at an event after no more than round-off of the time.
    instants: u32,
    drilling: DrillingWatch,
    bending: BendingWatch,
    /// The last state reached.
    pub state: State,
    /// State between two sub-steps of a composed step.
    pub between: State,
    /// State at the start of the step, to which a mechanism returns that has gained energy.
    start: State,
    balance: Balance,
    pub statistics: Statistics,
    /// Velocities at the start of the last step, for the predictor.
    pub old_velocities: Vec<Nodal>,
    /// Whether the present step is repeated with new tangents, since it failed with a lagged one.
    own_tangents: bool,
    /// Whether the analysis begins at its first state.
    fresh: bool,
    /// Messages about the first state, and warnings about the start.
    messages: Vec<String>,
    warnings: Vec<String>,
    /// Watch of the velocities of driven joints.
    drive_rates: DriveRates,
    difference_energy: DifferenceEnergy,
    /// Watch of the energy of schemes that do not conserve it.
    energies: EnergyWatch,
    loads: LoadWatch,
    /// Watch of rotations in constant steps.
    rotations: RotationWatch,
    rank: RankWatch,
}

impl<'a> TimeSteps<'a> {
    /// Begins at `start`, or at time 0 with consistent accelerations, a state that is reported to the observer.
    ///
    /// # Errors
    /// The factor does not fit in memory, the mass is singular, an amplitude has no value at time 0, or the observer failed.
    pub fn new(
        system: &'a System,
        options: &'a TransientAnalysis,
        scheme: Box<dyn Integrator>,
        start: Option<State>,
    ) -> Result<Self> {
        let mut newton = Newton::new(system, None)?;
        let fresh = start.is_none();
        let (mut messages, mut warnings) = (Vec::new(), Vec::new());
        let mut state = match start {
            Some(state) => state,
            None => {
                if let Some(reason) = system.undefined_amplitude(0.0) {
                    return Err(undefined("time", (0.0, 0.0), reason));
                }
                let (state, found) = initial_state(system, &mut newton)?;
                (messages, warnings) = (found.events, found.warnings);
                if options.scheme.is_kinematic() {
                    determined(system, &newton, &state)?;
                }
                let constraints = newton.constraints.iter();
                warnings.extend(constraints.flat_map(|constraints| constraints.redundant(system)));
                state
            }
        };
        newton.restore(system, &state, true);
        let control = StepControl::new(options);
        let balance = balance(system, &mut newton.assembly, &state);
        let constant = options.time_step.is_some() && !options.scheme.is_kinematic();
        if fresh {
            state.next_step = control.first(system, &state);
        }
        Ok(Self {
            rank: RankWatch::new(newton.schur().filter(|_| fresh)),
            tolerances: scheme.tolerances(options.max_iterations),
            control,
            ends: StepEnds::new(system, options),
            check: AmplitudeCheck::new(system, options),
            events: JointEvents::new(system),
            event: None,
            reviewing: false,
            instants: 0,
            drilling: DrillingWatch::new(),
            bending: BendingWatch::new(),
            drive_rates: DriveRates::new(system, state.time),
            difference_energy: DifferenceEnergy::new(system),
            energies: EnergyWatch::new(system, &balance),
            loads: LoadWatch::new(system, options, &state),
            rotations: RotationWatch::new(system, constant, &state.u),
            balance,
            statistics: Statistics { steps: state.step, ..Statistics::default() },
            old_velocities: vec![[0.0; 3]; system.vectors()],
            own_tangents: false,
            between: State::default(),
            start: State::default(),
            fresh,
            messages,
            warnings,
            system,
            options,
            scheme,
            newton,
            state,
        })
    }

    /// Length and end of the next step.
    fn next_span(&mut self, observer: &mut dyn Observer) -> Result<Span> {
        let Self { system, state, check, ends, .. } = self;
        state.next_step = check.shortened(system, state.time, state.next_step, state.last_step);
        let mut span = ends.next(state.time, state.next_step, state.last_step);
        if let Some((_, dt)) = self.event.filter(|(time, dt)| *time == state.time && *dt < span.dt) {
            span = Span { dt, end: state.time + dt };
        }
        if let Some(found) = check.passed_over(system, state.time, span.dt) {
            observer.on_event(&found.event(system));
        }
        // Schemes evaluate loads inside the step, too.
        let mut start = state.time;
        let undefined_inside = self.scheme.sub_steps().iter().find_map(|part| {
            let [middle, end] = [0.5, 1.0].map(|share| start + share * part * span.dt);
            start = end;
            [middle, end].into_iter().find_map(|time| system.undefined_amplitude(time))
        });
        match undefined_inside {
            Some(reason) => Err(undefined("time", (state.time, span.end), reason)),
            None => Ok(span),
        }
    }

    /// Solves for the end of a step and accepts it, unless it has to be repeated. A step that failed with a lagged tangent
    /// is repeated with new tangents, any other one with a shorter length.
    fn attempt(&mut self, span: Span, observer: &mut dyn Observer) -> Result<Attempt> {
        if let Some(drive) = self.system.drive_turns_too_far(self.state.time, span.end) {
            self.state.next_step = 0.5 * span.dt;
            return Ok(Attempt::TooLong(Trouble::Inaccurate, format!("{drive} in the step")));
        }
        if self.scheme.sub_steps().len() > 1 {
            return self.attempt_composed(span, observer);
        }
        if !self.events.is_empty() && !self.reviewing {
            self.events.begin(self.system, &self.state);
        }
        self.reviewing = false;
        let Self { system, scheme, newton, state, statistics, events, .. } = self;
        if let Some(constraints) = newton.constraints.as_mut().filter(|_| !events.is_empty()) {
            constraints.set_modes(&events.trial);
        }
        newton.count_turns(system, state);
        scheme.begin(system, &mut newton.assembly, state, span);
        if !self.own_tangents {
            newton.prepare(system, (&scheme.parts(), scheme.displacements()), span.dt, state);
        }
        let result = newton.solve(system, scheme.as_mut(), &state.history, &self.tolerances, observer);
        statistics.factorizations = newton.solver.factorizations() as u64;
        statistics.linear_iterations = newton.linear_iterations();
        statistics.iterations += u64::from(match &result {
            Ok(converged) => converged.iterations,
            Err(diverged) => diverged.iterations,
        });
        match result {
            Ok(_) if scheme.improves_start(system, newton, state) => {
                newton.restore(system, state, true);
                Ok(Attempt::Repeated)
            }
            Ok(converged) => {
                self.own_tangents = false;
                if !self.events.is_empty() {
                    let solution = (self.scheme.as_ref(), &mut self.newton);
                    match self.events.review(self.system, &self.state, solution, span.dt) {
                        Review::Fits => {}
                        Review::Changed => {
                            self.reviewing = true;
                            self.newton.restore(self.system, &self.state, true);
                            return Ok(Attempt::Repeated);
                        }
                        Review::Repeat(dt) => {
                            self.event = Some((self.state.time, dt));
                            self.newton.restore(self.system, &self.state, true);
                            return Ok(Attempt::Repeated);
                        }
                        Review::Contradiction(reason) => {
                            self.state.next_step = 0.5 * span.dt;
                            return Ok(Attempt::TooLong(Trouble::Inaccurate, reason));
                        }
                    }
                }
                self.judge(span, converged, observer)
            }
            Err(_) if observer.interrupted() => Err(Error::Interrupted),
            Err(Diverged { reason, began_with_old_factor: true, .. }) => {
                self.repeat_with_own_tangents(span, &reason, observer);
                Ok(Attempt::Repeated)
            }
            Err(_) if self.events.release() => {
                self.reviewing = true;
                self.newton.restore(self.system, &self.state, true);
                Ok(Attempt::Repeated)
            }
            Err(Diverged { reason, cause, .. }) => {
                self.own_tangents = false;
                self.state.next_step = 0.5 * span.dt;
                let kinematic = self.options.scheme.is_kinematic();
                let reason = if kinematic { NO_POSITION.into() } else { reason };
                Ok(Attempt::TooLong(Trouble::Iteration(cause), reason))
            }
        }
    }

    fn repeat_with_own_tangents(&mut self, span: Span, reason: &str, observer: &mut dyn Observer) {
        observer.on_repeat(&self.statistics);
        observer.on_event(&format!(
            "time {:.6e}: a step of {:.3e} is repeated with new tangents: {reason}",
            self.state.time, span.dt
        ));
        self.newton.forget(&mut self.state);
        self.newton.restore(self.system, &self.state, true);
        self.own_tangents = true;
    }

    /// Accepts a converged step whose local error is small enough and whose elements are not inverted.
    fn judge(&mut self, span: Span, converged: Converged, observer: &mut dyn Observer) -> Result<Attempt> {
        if let Some((trouble, reason)) =
            trouble(self.system, &self.state, span.dt, self.scheme.displacements())
        {
            self.state.next_step = 0.5 * span.dt;
            return Ok(Attempt::TooLong(trouble, reason));
        }
        let step = (self.scheme.displacements(), span);
        if let Some(reason) = spring_without_force(self.system, &self.newton, &self.state, step) {
            self.state.next_step = 0.5 * span.dt;
            return Ok(Attempt::TooLong(Trouble::Iteration(Cause::Flight), reason));
        }
        let error = self.scheme.local_error(self.system, &mut self.newton, &self.state);
        if let Some(reason) = self.scheme.interruption(self.system, &mut self.newton, &self.state)? {
            self.newton.restore(self.system, &self.state, true);
            self.state.next_step = 0.5 * span.dt;
            return Ok(Attempt::TooLong(Trouble::Inaccurate, reason));
        }
        let error = larger(error, self.system.error_of_drives(self.state.time, span.end));
        if self.control.accepts(error) {
            if self.may_return() {
                self.start.copy_from(&self.state);
            }
            let Self { system, scheme, newton, state, old_velocities, .. } = self;
            finish(system, (scheme.as_mut(), newton), (old_velocities, state), span);
            return self.accept(span, error, &converged, observer);
        }
        let next = self.control.next(span.dt, span.dt, error, converged.tangents);
        self.state.next_step = next.min(0.5 * span.dt);
        let reason = format!("its error {error:.1e} is above the tolerance {:.1e}", self.options.tolerance);
        Ok(Attempt::TooLong(Trouble::Inaccurate, reason))
    }

    /// Accepts the state at the end of a step.
    pub(super) fn accept(
        &mut self,
        span: Span,
        error: f64,
        converged: &Converged,
        observer: &mut dyn Observer,
    ) -> Result<Attempt> {
        let Self {
            system,
            scheme,
            newton,
            state,
            statistics,
            control,
            drilling,
            bending,
            events,
            old_velocities,
            rank,
            ..
        } = self;
        rank.look(system, newton, state, observer)?;
        if !events.is_empty() {
            // A flight much shorter than a step is the end of an infinite number of impacts.
            let plastic = events.returns() && span.dt < SHORT_FLIGHT * state.next_step;
            state.coordinates.clone_from(&events.trial);
            let instant = events.has_event() && span.dt <= INSTANT * span.end;
            self.instants = if instant { self.instants + 1 } else { 0 };
            if self.instants > MOST_INSTANTS {
                return Err(no_mode(events.joints(system), state.time));
            }
            if events.has_event() {
                let found = joint_impact::pass(system, newton, (old_velocities, state), (events, plastic))?;
                found.iter().for_each(|message| observer.on_event(message));
            }
        }
        state.work += impact::pass_jumps(system, newton, self.options.scheme, state)?;
        state.step += 1;
        state.next_step = control.next(span.dt, state.next_step, error, converged.tangents);
        if state.next_step > MOST_GROWTH * span.dt {
            impact::leave_short_step(system, newton, state)?;
        }
        state.tangent.record_use(converged.iterations, converged.tangents);
        commit(system, newton, state);
        let before = std::mem::replace(&mut self.balance, balance(system, &mut newton.assembly, state));
        let last = span.end >= self.options.end_time;
        if !system.joints.is_empty() {
            let conserves = self.options.scheme.conserves_energy();
            let scale = scheme.energy_scale(system, &mut newton.assembly, &state.history);
            let scale = larger(scale, state.energy_scale);
            let trouble = keeps_energy(system, (span, state), [&before, &self.balance], (scale, conserves));
            if let Err(reason) = trouble {
                return self.return_to_start(span, before, reason);
            }
            let rates = self.drive_rates.look(system, state, conserves)?;
            let energy = self.difference_energy.look(system, state, self.balance.kinetic, last);
            if let Some(warning) = self.drive_rates.look_at_signals(system, state) {
                observer.on_warning(&format!("time {:.6e}: {warning}", state.time));
            }
            for message in rates.into_iter().chain(energy) {
                observer.on_event(&format!("time {:.6e}: {message}", state.time));
            }
        }
        state.energy_scale = state.energy_scale.max(self.balance.kinetic).max(self.balance.strain);
        statistics.steps = state.step;
        let at = (state.u.as_slice(), state.time);
        drilling.look(system, at, observer, || format!("time {:.6e}", state.time));
        bending.look(system, at.0, observer, || format!("time {:.6e}", state.time));
        if !self.options.scheme.conserves_energy() && !self.options.scheme.is_kinematic() {
            let energies = (&self.balance, state.energy_scale, scheme.unresolved());
            self.energies.look(system, energies, (state.step, span, last), observer);
        }
        self.rotations.look(system, at, scheme.sub_steps(), observer);
        self.loads.look(system, (state, last), observer);
        Ok(Attempt::Accepted(converged.iterations))
    }

    /// Whether a step that gains energy is taken back: with a scheme that conserves energy the joints are the reason, whatever the step.
    fn may_return(&self) -> bool {
        !self.system.joints.is_empty() && !self.options.scheme.conserves_energy()
    }

    /// Takes back an accepted step that gains energy.
    ///
    /// # Errors
    /// The scheme conserves energy.
    fn return_to_start(&mut self, span: Span, before: Balance, reason: String) -> Result<Attempt> {
        if !self.may_return() {
            return Err(Error::NotConverged {
                at: format!("time {:.6e}", span.end),
                reason,
                help: "Results up to the step before are complete. Change the position of joints that lie in one line or plane, or take a \
                       smaller step."
                    .into(),
            });
        }
        self.state.copy_from(&self.start);
        self.state.next_step = 0.5 * span.dt;
        self.balance = before;
        self.statistics.steps = self.state.step;
        self.events.restart();
        self.event = None;
        Ok(Attempt::TooLong(Trouble::GainsEnergy, reason))
    }

    /// Repeats a step with a shorter one, or gives up.
    fn cut_back(
        &mut self,
        span: Span,
        trouble: Trouble,
        failure: String,
        observer: &mut dyn Observer,
    ) -> Result<()> {
        let Self { system, options, state, statistics, .. } = self;
        let smallest = if trouble == Trouble::LeavesCurve { LEAVING } else { SMALLEST_STEP };
        if state.next_step < smallest * options.end_time {
            observer.on_repeat(statistics);
            let of_energy = self.energies.advice().filter(|_| !options.scheme.conserves_energy());
            return Err(Error::NotConverged {
                at: format!("time {:.6e}", state.time + span.dt),
                reason: failure,
                help: format!(
                    "The last finished step ended at time {:.6e}; results up to there are complete. {}",
                    state.time,
                    of_energy.unwrap_or_else(|| advice(system, options, trouble))
                ),
            });
        }
        statistics.cutbacks += 1;
        observer.on_repeat(statistics);
        observer.on_event(&format!(
            "time {:.6e}: cut-back from a step of {:.3e} to {:.3e}: {failure}",
            state.time, span.dt, state.next_step
        ));
        self.newton.restore(system, state, true);
        Ok(())
    }
}

impl Stepper for TimeSteps<'_> {
    fn reached(&self) -> Reached<'_> {
        let Self { state, balance, statistics, .. } = self;
        Reached { state, balance, statistics, end: self.options.end_time }
    }

    fn finish(self: Box<Self>) -> (State, Balance, Statistics) {
        (self.state, self.balance, self.statistics)
    }

    fn begin(&mut self, observer: &mut dyn Observer) -> Result<bool> {
        self.messages.drain(..).for_each(|message| observer.on_event(&message));
        self.warnings.drain(..).for_each(|message| observer.on_warning(&message));
        Ok(std::mem::take(&mut self.fresh))
    }

    fn advance(&mut self, observer: &mut dyn Observer) -> Result<u32> {
        loop {
            let span = self.next_span(observer)?;
            match self.attempt(span, observer)? {
                Attempt::Accepted(iterations) => return Ok(iterations),
                Attempt::Repeated => {}
                Attempt::TooLong(trouble, reason) => self.cut_back(span, trouble, reason, observer)?,
            }
        }
    }

    fn repeat(&mut self, start: &State, end: f64) {
        let Self { system, state, newton, .. } = self;
        state.copy_from(start);
        newton.reset();
        newton.restore(system, state, true);
        self.balance = balance(system, &mut newton.assembly, state);
        self.statistics.steps = state.step;
        self.rotations.restart(&self.state.u);
        self.events.restart();
        self.loads = LoadWatch::new(system, self.options, &self.state);
        (self.event, self.reviewing, self.own_tangents) = (None, false, false);
        self.ends.limit(end);
    }

    fn release(&mut self) {
        self.ends.limit(f64::INFINITY);
    }

    fn watch(&mut self, watched: &Watched) {
        self.state.watched.clone_from(watched);
    }
}

/// Reason why the end `new` of a step of length `dt` from a state cannot be accepted, whatever its error.
pub(super) fn trouble(system: &System, state: &State, dt: f64, new: &[Nodal]) -> Option<(Trouble, String)> {
    if let Some(inverted) = inverted_element(system, new) {
        return Some((Trouble::Inverted, inverted));
    }
    let moved =
        |v: usize, part: f64| std::array::from_fn(|i| state.u[v][i] + part * (new[v][i] - state.u[v][i]));
    if let Some(reason) = system.gear_turns_too_far(moved, &state.angles) {
        return Some((Trouble::Inaccurate, reason));
    }
    match system.off_curve(&state.u, new) {
        Some(OffCurve::TooFar(reason)) => return Some((Trouble::Inaccurate, reason)),
        Some(OffCurve::PastEnd(reason)) => return Some((Trouble::LeavesCurve, reason)),
        None => {}
    }
    let body = triads::turned_too_far(system, (state, dt), new)?;
    let reason = format!("body \"{body}\" turns by more than {} rad in the step", triads::MOST_ROTATION);
    Some((Trouble::Inaccurate, reason))
}

/// Spring by a formula that has a pole within a step to given displacements, or by one in the time that has no force at its end, as
/// text: schemes take forces at few places of a step only.
pub(super) fn spring_without_force(
    system: &System,
    newton: &Newton,
    state: &State,
    (end, span): (&[Nodal], Span),
) -> Option<String> {
    let motion = Motion::Step { old: &state.u, new: end, dt: span.dt };
    let step = EvaluationPoint::new(system, motion, span.end, state.internal());
    if let Some(pole) = newton.assembly.pole_in_step(system, &step, state.time) {
        return Some(pole);
    }
    if !system.has_actuators() {
        return None;
    }
    newton
        .assembly
        .reason_without_forces(system, &EvaluationPoint::at_rest(system, end, span.end, state.internal()))
}

/// Makes the end of a solved step the state: motion, work, dissipation, and the prediction of the next step. History variables are
/// [committed](commit) later.
pub(super) fn finish(
    system: &System,
    (scheme, newton): (&mut dyn Integrator, &mut Newton),
    (old_velocities, state): (&mut [Nodal], &mut State),
    span: Span,
) {
    let (end, State { u, angles, .. }) = (scheme.displacements(), &mut *state);
    system.continue_angles(|v, part| std::array::from_fn(|i| u[v][i] + part * (end[v][i] - u[v][i])), angles);
    scheme.close_rates(system, newton);
    let step_work = scheme.step_work(system, &mut newton.assembly, state);
    let after = (scheme.displacements(), span.end);
    let strains =
        newton.assembly.prescribed_strain_work(system, &state.history, (&state.u, state.time), after);
    state.work += step_work.work + strains;
    state.dissipated += step_work.dissipated;
    old_velocities.copy_from_slice(&state.v);
    scheme.finish(system, state);
    if !system.linear {
        predictor::remember(old_velocities, span.dt, state);
    }
    (state.last_step, state.time) = (span.dt, span.end);
}

/// Commits the history variables at the end of a step, and begins the next one with the stress there.
pub(super) fn commit(system: &System, newton: &mut Newton, state: &mut State) {
    let motion = Motion::State { u: &state.u, velocity: None };
    state.dissipated += newton.assembly.commit(system, motion, state.time, &mut state.history);
    newton.assembly.reset_stress(system, &state.point(system));
}

/// Length of the last step before a point leaves its curve, over that of the analysis.
const LEAVING: f64 = 1e-5;
/// Flight between two impacts of a stop, over the time step, below which the stop stays closed.
const SHORT_FLIGHT: f64 = 1e-3;

/// Length of a step to an event over the time that is round-off of the time, and the most such steps one after another.
const INSTANT: f64 = 1e-12;
const MOST_INSTANTS: u32 = 200;

/// Error of joints whose friction and stops come to no rest and to no motion.
fn no_mode(joints: String, time: f64) -> Error {
    Error::NotConverged {
        at: format!("time {time:.6e}"),
        reason: format!(
            "the joint(s) {joints} come to rest and leave it again without any progress of the time: friction or stops of several joints \
             act on one motion, or none of their motions fits"
        ),
        help: "Results up to this time are complete. Give the friction of one motion to one joint.".into(),
    }
}

/// Growth of the step behind which the auxiliary accelerations of the generalised-α method start anew: their difference from the
/// accelerations, over the step, is large where a short step ends at a jump of a load. Automatic steps grow by less.
const MOST_GROWTH: f64 = 2.5;

/// Reason why a step of a kinematic analysis fails.
const NO_POSITION: &str = "joints and drives admit no position next to the one before";

/// Outcome of an attempt at a time step.
pub(super) enum Attempt {
    /// The end of the step is the state; number of iterations.
    Accepted(u32),
    /// The step is repeated with new tangents.
    Repeated,
    /// The step has to be cut back, for this reason.
    TooLong(Trouble, String),
}
