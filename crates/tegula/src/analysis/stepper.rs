//! Analyses that advance step by step, and the loop that runs them to their end.

use super::stop_condition::{StopWatch, Stopped, Watched};
use super::{Balance, Observer, State, Statistics, Step};
use crate::model::StopCondition;
use crate::{Error, Result};

/// Analysis that advances step by step: load steps of statics, time steps of a transient analysis.
///
/// [`run`] takes steps until the end. Callers that want to do something between steps, such as a controller that sets a
/// load from the state, call [`begin`](Self::begin) once and then [`advance`](Self::advance) themselves; they decide themselves
/// when to stop, as stop conditions are those of [`run`].
pub trait Stepper: Send {
    /// Last state reached, with its energies and the run counters.
    fn reached(&self) -> Reached<'_>;
    /// Last state reached.
    fn state(&self) -> &State {
        self.reached().state
    }
    /// Energies and momenta of the last state reached.
    fn balance(&self) -> &Balance {
        self.reached().balance
    }
    /// Time (load factor) at which the analysis ends.
    fn end(&self) -> f64 {
        self.reached().end
    }
    /// Whether the analysis has come to its end: of a path its state tells, of others the time (load factor).
    fn is_finished(&self) -> bool {
        self.state().path.as_ref().map_or_else(|| self.state().time >= self.end(), |path| path.finished)
    }
    /// Place of the state among those of the analysis, which grows from step to step: the time (load factor), or the parameter of a
    /// path.
    fn position(&self) -> f64 {
        self.state().path.as_ref().map_or(self.state().time, |path| path.position)
    }
    /// Ends the analysis; returns the last state reached, its energies and the run counters.
    fn finish(self: Box<Self>) -> (State, Balance, Statistics);
    /// Prepares the first step. Returns whether the first state is to be reported to the observer: that of a new transient
    /// analysis is.
    ///
    /// # Errors
    /// The first step cannot be prepared.
    fn begin(&mut self, observer: &mut dyn Observer) -> Result<bool>;
    /// Takes a step, repeated smaller where it fails, and returns its number of iterations. An explicit scheme takes a
    /// number of steps, up to the next check of its energy balance.
    ///
    /// # Errors
    /// No step could be taken, and the state is still that of the last finished step; or the observer asks to stop.
    fn advance(&mut self, observer: &mut dyn Observer) -> Result<u32>;
    /// Goes back to a state of the same analysis, that at the start of the last step: the next step ends at the
    /// [`position`](Self::position) `end` at the latest.
    fn repeat(&mut self, start: &State, end: f64);
    /// Removes the limit of a [repeated](Self::repeat) step.
    fn release(&mut self);
    /// Stores the columns of stop conditions in the state.
    fn watch(&mut self, watched: &Watched);
}

/// State that a stepper has reached.
#[derive(Debug, Clone, Copy)]
pub struct Reached<'a> {
    /// Last state.
    pub state: &'a State,
    /// Energies and momenta of this state.
    pub balance: &'a Balance,
    /// Run counters so far.
    pub statistics: &'a Statistics,
    /// Time (load factor) at which the analysis ends.
    pub end: f64,
}

impl<'a> Reached<'a> {
    /// Step that has ended at this state.
    pub fn step(&self, iterations: u32) -> Step<'a> {
        let Self { state, balance, statistics, end } = *self;
        Step { state, balance, statistics, iterations, end }
    }
}

/// Takes all steps of an analysis up to its end or to the first stop condition that is met, which is returned; the observer gets each
/// finished step.
///
/// # Errors
/// A step failed, the observer asked to stop or failed itself, or it does not know the column of a stop condition.
pub fn run(
    stepper: &mut dyn Stepper,
    conditions: &[StopCondition],
    observer: &mut dyn Observer,
) -> Result<Option<Stopped>> {
    let fresh = stepper.begin(observer)?;
    let mut watch = StopWatch::begin(conditions, stepper, observer)?;
    if fresh {
        observer.on_step(&stepper.reached().step(0))?;
    }
    while !stepper.is_finished() && watch.stopped().is_none() {
        watch.keep(stepper);
        let iterations = stepper.advance(observer)?;
        let iterations = watch.look(iterations, stepper, observer)?;
        observer.on_step(&stepper.reached().step(iterations))?;
        let done = stepper.is_finished() || watch.stopped().is_some();
        if observer.interrupted() && !done {
            return Err(Error::Interrupted);
        }
    }
    watch.warn_if_never_met(observer);
    Ok(watch.into_stopped())
}
