//! Driver of an explicit analysis: its step length, its reports, and when it ends.

use super::amplitude_check::AmplitudeCheck;
use super::constrained_start::Messages;
use super::critical_step::CriticalStep;
use super::energy_watch::{SuppliedEnergy, is_round_off};
use super::explicit::Explicit;
use super::explicit_start;
use super::fibre_watch::FibreWatch;
use super::load_watch::LoadWatch;
use super::rank_watch::RankWatch;
use super::step_end::StepEnds;
use super::{SMALLEST_STEP, Span};
use crate::analysis::bending_watch::BendingWatch;
use crate::analysis::drilling::DrillingWatch;
use crate::analysis::statics::undefined;
use crate::analysis::stepper::Reached;
use crate::analysis::{Balance, Observer, State, Statistics, Stepper, Watched};
use crate::model::TransientAnalysis;
use crate::system::{System, inverted_element};
use crate::{Error, Result};

/// Explicit steps from one look at the bending of beams to the next: it changes little in one of them.
const LOOKS: u64 = 64;
/// Safety factor on the bound of the critical time step: margin for its changes until it is estimated again.
const SAFETY: f64 = 0.9;
/// Largest number of steps between two estimates of the critical time step of a nonlinear model. In this time sound
/// passes about 90 elements.
const INTERVAL: u64 = 100;
/// Change of a fibre's length, over its length, after which the critical time step is estimated again. Where a sheet of
/// St. Venant–Kirchhoff material is stretched by λ, its highest frequency grows with √((3λ² − 1)/2), at λ = 1 by 1.5
/// times the strain: that leaves most of the safety margin to the changes within one step.
const CHANGE: f64 = 0.02;
/// Steps between two checks of the fibres; a check takes a few per cent of a step.
const LOOK: u64 = 2;
/// Steps between two reports. Strain energy costs about as much as a step; in ten steps near the critical one no motion
/// that the mesh resolves goes through a period.
const REPORT: u64 = 10;
/// Largest error of the energy balance over the sum of the largest kinetic or strain energy and the dissipated energy.
/// Linear motions keep the balance to round-off, resolved nonlinear ones to well below a hundredth. Damping forces lag
/// by half a step, which costs a part of what they dissipate.
const BROKEN: f64 = 0.05;
/// Ratio of the strain energy and the kinetic energy in the middle of the step to the energy supplied above which a motion is
/// unstable. At the safety factor the energy of the highest mode varies five-fold in a stable motion.
const BLOW_UP: f64 = 100.0;

/// Rotation of a body in a step (rad), and the one at which the step is chosen anew. Bodies without springs have no critical step: the
/// step is that which resolves their motion.
const ROTATION: f64 = 0.0125;
const MOST_ROTATION: f64 = 0.02;
/// Steps between two breaks of amplitudes, and in the whole analysis, where nothing else limits the step of a model with bodies.
const RESOLVED: f64 = 20.0;
const FEWEST: f64 = 500.0;
/// Interval between two breaks over the length of the analysis, down to which it is resolved by that many steps. A shorter ramp acts as a jump, at whose ends
/// steps end.
const SHORTEST_RAMP: f64 = 1e-4;
/// Damping over mass times the step: the damping of the half step lags, which the balance of energies notices.
const DAMPED: f64 = 0.1;

/// Displacement of a negligible motion in the whole analysis, over the size of the model.
const UNSEEN: f64 = 1e-9;

/// Energy-balance monitor: reference energies for those of a motion.
struct EnergyMonitor {
    /// Total energy at time 0.
    total: f64,
    supplied: SuppliedEnergy,
    /// Energy of a negligible motion: loads that begin like a Gaussian pulse grow by powers of ten in a step, and no
    /// ratio of energies means anything then.
    unseen: f64,
}

impl EnergyMonitor {
    /// Error of the energy balance over the largest energy so far, and a message where the motion is unstable or the
    /// balance violated.
    fn check(
        &mut self,
        system: &System,
        balance: &Balance,
        (scheme, state): (&Explicit, &State),
    ) -> (f64, Option<String>) {
        // The forces of this step have not moved anything yet: a motion that begins with it has no velocity in its middle.
        let stored = system.kinetic_energy(scheme.middle()) + balance.strain;
        let supplied = self.supplied.up_to(balance);
        let missing = balance.total - state.swing - self.total;
        let scale = state.energy_scale.max(self.unseen);
        let mut error = if missing == 0.0 { 0.0 } else { missing.abs() / scale };
        if error > BROKEN && is_round_off(system, (state, state.last_step), missing.abs()) {
            error = 0.0;
        }
        let place = || scheme.fastest(state);
        let reason = if !stored.is_finite() || !error.is_finite() {
            Some(format!("the energy is no longer finite, first at {}", place()))
        } else if stored > BLOW_UP * supplied.max(self.unseen) {
            Some(format!(
                "numerical instability: the kinetic and strain energy {stored:.2e} is far above the {supplied:.2e} supplied by \
                 loads and initial motion; {} has the largest kinetic energy",
                place()
            ))
        } else if error > 0.0 && missing.abs() > BROKEN * (scale + state.dissipated) {
            Some(format!(
                "the energy balance is violated by {missing:.2e}, where the kinetic or strain energy has reached {:.2e}; {} \
                 has the largest kinetic energy",
                state.energy_scale,
                place()
            ))
        } else {
            None
        };
        (error, reason)
    }
}

/// An explicit analysis between two time steps.
pub(super) struct ExplicitSteps<'a> {
    system: &'a System,
    options: &'a TransientAnalysis,
    scheme: Explicit<'a>,
    critical: CriticalStep,
    fibres: FibreWatch,
    monitor: EnergyMonitor,
    drilling: DrillingWatch,
    bending: BendingWatch,
    loads: LoadWatch,
    ends: StepEnds,
    check: AmplitudeCheck,
    state: State,
    balance: Balance,
    statistics: Statistics,
    /// Whether the analysis begins at time 0 and its initial state has not been reported yet.
    fresh: bool,
    /// Whether the critical time step is known.
    found: bool,
    /// Whether the user has been warned that the given time step is above the critical one.
    warned: bool,
    /// Events and warnings of the start that have not been reported yet.
    messages: Messages,
    rank: RankWatch,
}

impl<'a> ExplicitSteps<'a> {
    /// Begins at `start`, or at time 0.
    ///
    /// # Errors
    /// An amplitude has no value at time 0, or the system was compiled for another analysis.
    pub(super) fn new(
        system: &'a System,
        options: &'a TransientAnalysis,
        start: Option<State>,
    ) -> Result<Self> {
        let mut scheme = Explicit::new(system)?;
        let fresh = start.is_none();
        if fresh && let Some(reason) = system.undefined_amplitude(0.0) {
            return Err(undefined("time", (0.0, 0.0), reason));
        }
        // A resumed run needs this, too: later energies are compared with the energy at time 0.
        let mut first = super::initial_motion(system);
        let messages = explicit_start::start(system, &mut scheme, &mut first)?;
        super::commit_jump(system, &mut scheme.assembly, &mut first);
        first.energy_scale = system.kinetic_energy(&first.v);
        let at_first = super::balance(system, &mut scheme.assembly, &first);
        let state = start.unwrap_or(first);
        scheme.begin(&state);
        let mut fibres = FibreWatch::new(system);
        if state.tangent.valid {
            fibres.take(system, &state.tangent.u);
        }
        let slow = UNSEEN * system.length / options.end_time;
        let monitor = EnergyMonitor {
            total: at_first.total,
            supplied: SuppliedEnergy::new(&at_first),
            unseen: 0.5 * system.total_mass() * slow * slow,
        };
        Ok(Self {
            messages: if fresh { messages } else { Messages::default() },
            rank: RankWatch::new(scheme.joints.as_ref().map(|joints| joints.schur())),
            critical: CriticalStep::new(system, &scheme.mass),
            fibres,
            monitor,
            drilling: DrillingWatch::new(),
            bending: BendingWatch::new(),
            loads: LoadWatch::new(system, options, &state),
            ends: StepEnds::new(system, options),
            check: AmplitudeCheck::new(system, options),
            statistics: Statistics { steps: state.step, ..Statistics::default() },
            balance: super::balance(system, &mut scheme.assembly, &state),
            fresh,
            found: false,
            warned: false,
            system,
            options,
            scheme,
            state,
        })
    }

    /// Estimates the critical time step anew where elements have changed, or after many steps. A resumed run keeps its step
    /// until the next estimate is due.
    fn renew_critical_step(&mut self, observer: &mut dyn Observer) -> Result<()> {
        let Self { system, options, scheme, critical, fibres, state, statistics, .. } = self;
        let changed = !system.linear
            && state.tangent.valid
            && state.step.is_multiple_of(LOOK)
            && !(fibres.change(system, &state.u) <= CHANGE);
        let turns = options.time_step.is_none()
            && state.step.is_multiple_of(LOOK)
            && !(scheme.rate(state) * state.next_step <= MOST_ROTATION);
        let due = self.fresh || changed || turns || !system.linear && state.step.is_multiple_of(INTERVAL);
        // The first step follows the estimate with which the analysis begins.
        if self.found && (!due || state.step == 0) {
            return Ok(());
        }
        let step = critical.below(system, &mut scheme.assembly, &scheme.mass, state);
        // Models of bodies without springs are stable in any step.
        let step = if step == f64::INFINITY { options.end_time } else { step };
        statistics.critical_step = step;
        if due {
            remember(state);
            fibres.take(system, &state.u);
            let largest = options.max_step.unwrap_or(options.end_time);
            let bodies = !system.coordinates.bodies.is_empty();
            let ramp = self.ends.shortest_gap(SHORTEST_RAMP * options.end_time);
            let gap = (ramp / RESOLVED).min(options.end_time / FEWEST);
            let resolved = (ROTATION / scheme.rate(state)).min(if bodies { gap } else { f64::INFINITY });
            let resolved = resolved.min(DAMPED / critical.damping);
            state.next_step = options.time_step.unwrap_or((SAFETY * step).min(resolved).min(largest));
        }
        if let Some(wanted) = options.time_step.filter(|&wanted| wanted > step && !self.warned) {
            self.warned = true;
            observer.on_warning(&format!(
                "time {:.6e}: the step {wanted:.3e} is above {step:.3e}, below which it is certainly stable: the motion may grow without \
                 bound, and a short run ends before that is noticed; leave out time_step",
                state.time
            ));
        }
        if step.is_nan() || !state.next_step.is_finite() || state.next_step < SMALLEST_STEP * options.end_time
        {
            return Err(self.unstable(format!(
                "the critical time step {step:.3e} is not finite, or too short to reach the end time"
            )));
        }
        (self.fresh, self.found) = (false, true);
        Ok(())
    }

    /// Takes a step and checks its result; true where the energy balance was checked.
    fn step(&mut self, observer: &mut dyn Observer) -> Result<bool> {
        let Self { system, options, state, check, .. } = self;
        let wanted = check.shortened(system, state.time, state.next_step, state.last_step);
        let Span { dt, end } = self.ends.next(state.time, wanted, state.last_step);
        if let Some(found) = check.passed_over(system, state.time, dt) {
            observer.on_event(&found.event(system));
        }
        let last = end >= options.end_time;
        if let Some(reason) = system.undefined_amplitude(end) {
            return Err(undefined("time", (state.time, end), reason));
        }
        let outcome = self.scheme.step(state, dt, end);
        self.look_at_rank(observer);
        let state = &mut self.state;
        state.last_step = dt;
        state.step += 1;
        self.statistics.steps = state.step;
        outcome.map_err(|reason| self.unstable(reason))?;
        self.loads.look(self.system, (&self.state, last), observer);
        // Loads may have taken back all of their work where the balance is checked.
        self.monitor.supplied.count_work(self.state.work);
        let step = self.state.step;
        if (last || step.is_multiple_of(INTERVAL))
            && let Some(reason) = inverted_element(self.system, &self.state.u)
        {
            return Err(self.unstable(reason));
        }
        let due = last
            || step.is_multiple_of(REPORT)
            || self.ends.is_limit(end)
            || self.system.wanted_times.contains(&end);
        if due {
            self.check_balance(observer)?;
        }
        Ok(due)
    }

    /// Reports where the rank of the constraints falls.
    fn look_at_rank(&mut self, observer: &mut dyn Observer) {
        let schur = self.scheme.joints.as_ref().map(|joints| joints.schur());
        self.rank.look_at_masses(self.system, schur, self.state.time, observer);
    }

    /// Checks the energy balance of the state.
    fn check_balance(&mut self, observer: &mut dyn Observer) -> Result<()> {
        let Self { system, scheme, state, balance, monitor, statistics, drilling, bending, .. } = self;
        *balance = super::balance(system, &mut scheme.assembly, state);
        state.energy_scale = state.energy_scale.max(balance.kinetic).max(balance.strain);
        let (error, broken) = monitor.check(system, balance, (scheme, state));
        statistics.energy_error = statistics.energy_error.max(error);
        if let Some(reason) = broken {
            return Err(self.unstable(reason));
        }
        let at = || format!("time {:.6e}", state.time);
        drilling.look(system, (&state.u, state.time), observer, at);
        if state.step.is_multiple_of(LOOKS) {
            bending.look(system, &state.u, observer, at);
        }
        Ok(())
    }

    fn unstable(&self, reason: String) -> Error {
        unstable(&self.state, self.options, &self.statistics, reason)
    }
}

impl Stepper for ExplicitSteps<'_> {
    fn reached(&self) -> Reached<'_> {
        let Self { state, balance, statistics, .. } = self;
        Reached { state, balance, statistics, end: self.options.end_time }
    }

    fn finish(self: Box<Self>) -> (State, Balance, Statistics) {
        (self.state, self.balance, self.statistics)
    }

    fn begin(&mut self, observer: &mut dyn Observer) -> Result<bool> {
        let fresh = self.fresh;
        let Messages { events, warnings } = std::mem::take(&mut self.messages);
        events.iter().for_each(|message| observer.on_event(message));
        warnings.iter().for_each(|message| observer.on_warning(message));
        if fresh {
            self.renew_critical_step(observer)?;
        }
        Ok(fresh)
    }

    fn advance(&mut self, observer: &mut dyn Observer) -> Result<u32> {
        loop {
            self.renew_critical_step(observer)?;
            if self.step(observer)? {
                return Ok(0);
            }
        }
    }

    fn repeat(&mut self, start: &State, end: f64) {
        let Self { system, scheme, fibres, state, .. } = self;
        state.clone_from(start);
        scheme.begin(state);
        self.loads = LoadWatch::new(system, self.options, state);
        if state.tangent.valid {
            fibres.take(system, &state.tangent.u);
        }
        self.balance = super::balance(system, &mut scheme.assembly, state);
        self.statistics.steps = state.step;
        self.ends.limit(end);
    }

    fn release(&mut self) {
        self.ends.limit(f64::INFINITY);
    }

    fn watch(&mut self, watched: &Watched) {
        self.state.watched.clone_from(watched);
    }
}

/// Stores the state at which the critical time step was estimated, for runs that are resumed.
fn remember(state: &mut State) {
    state.tangent.valid = true;
    state.tangent.time = state.time;
    state.tangent.u.clone_from(&state.u);
    state.tangent.history.clone_from(&state.history);
}

/// Error of a motion that became unstable.
fn unstable(state: &State, options: &TransientAnalysis, statistics: &Statistics, reason: String) -> Error {
    let (step, critical) = (state.last_step, statistics.critical_step);
    let safe = SAFETY * critical;
    let key = if options.time_step.is_some() { "time_step" } else { "max_step" };
    let help = match options.time_step {
        Some(wanted) if wanted > safe => format!(
            "The last step was {step:.3e}; it is certainly stable below {critical:.3e}. Leave out `time_step`, or give one \
             below {safe:.3e}, or look at loads, initial velocities and units."
        ),
        _ => format!(
            "The last step was {step:.3e}; for small vibrations it is stable below {critical:.3e}. Look at \
             loads, initial velocities and units; a run with `{key}` below {:.3e} shows whether the step is the \
             cause.",
            0.5 * step
        ),
    };
    Error::Unstable { at: format!("time {:.6e}, step {}", state.time, state.step), reason, help }
}
