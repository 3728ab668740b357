//! Analyses that advance step by step, and the loop that runs them to their end.

use super::{Balance, Observer, State, Statistics, Step};
use crate::{Error, Result};

/// Analysis that advances step by step: load steps of statics, time steps of a transient analysis.
///
/// [`run`] takes steps until the end. Callers that want to do something between steps, such as a controller that sets a
/// load from the state, call [`begin`](Self::begin) once and then [`advance`](Self::advance) themselves.
pub trait Stepper {
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

/// Takes all steps of an analysis; the observer gets each finished one.
///
/// # Errors
/// A step failed, or the observer asked to stop or failed itself.
pub fn run(stepper: &mut dyn Stepper, observer: &mut dyn Observer) -> Result<()> {
    if stepper.begin(observer)? {
        report(stepper, 0, observer)?;
    }
    while stepper.state().time < stepper.end() {
        let iterations = stepper.advance(observer)?;
        report(stepper, iterations, observer)?;
        if observer.interrupted() && stepper.state().time < stepper.end() {
            return Err(Error::Interrupted);
        }
    }
    Ok(())
}

/// Reports the state reached to the observer.
fn report(stepper: &dyn Stepper, iterations: u32, observer: &mut dyn Observer) -> Result<()> {
    let Reached { state, balance, statistics, end } = stepper.reached();
    observer.on_step(&Step { state, balance, statistics, iterations, end })
}
