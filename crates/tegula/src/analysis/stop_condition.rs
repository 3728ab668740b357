//! Stop conditions: an analysis ends where a column of its history crosses a value.
//!
//! A crossing is seen at the ends of steps. The step that leads across it is repeated from its start with other lengths until it ends
//! just behind the crossing: by the secant between the last lengths before and behind it, with the weights of the Illinois method (M.
//! Dowell, P. Jarratt, *A modified regula falsi method for computing the root of an equation*, BIT 11 (1971) 168–174), and by
//! bisection where that does not shorten the bracket.

use serde::{Deserialize, Serialize};

use super::{Observer, State, Stepper};
use crate::model::{Crossing, StopCondition};
use crate::norm::larger;
use crate::{Error, Result};

/// Distance from the value at the end, over the change of the column in the whole step.
const TOLERANCE: f64 = 1e-6;
/// Distance from the value at the end, over the change of the column in the last step, that is told.
const MISSED: f64 = 1e-2;
/// Shortest repeated step, over the whole one: at a finite rate the column has not moved by more than the tolerance.
const SHORTEST: f64 = TOLERANCE;
/// Bracket of the crossing, over the whole step, at which a column that jumps is met.
const JUMP: f64 = 1e-9;
/// Most repeats of a step: bisection alone takes 30 to a jump, and each third repeat bisects at least.
const MOST_REPEATS: u32 = 90;
/// Repeats after which a bracket that has not been halved is bisected.
const PATIENCE: u32 = 2;

/// Columns of the stop conditions at the end of the last step, with which a resumed run continues.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Watched {
    /// Values of the columns, in the order of the conditions; empty before the first step.
    pub values: Vec<f64>,
    /// Number of the condition that has been met; the analysis has ended.
    pub met: Option<usize>,
}

/// End of an analysis at a stop condition.
#[derive(Debug, Clone, PartialEq)]
pub struct Stopped {
    /// Number of the condition.
    pub condition: usize,
    /// Column of the history.
    pub column: String,
    /// Value of the condition.
    pub value: f64,
    /// Value of the column at the end.
    pub reached: f64,
    /// Time (load factor) at the end.
    pub time: f64,
}

/// Values of the columns at a position within the step that crosses a value.
#[derive(Debug, Clone)]
struct Trial {
    position: f64,
    values: Vec<f64>,
}

/// Stop conditions of an analysis that runs.
pub(super) struct StopWatch<'a> {
    conditions: &'a [StopCondition],
    /// State at the start of the present step; of no use without conditions.
    start: State,
    /// Position of that state.
    start_position: f64,
    stopped: Option<Stopped>,
}

impl<'a> StopWatch<'a> {
    /// Looks at the columns where the analysis begins, or takes those with which an earlier part of the run has ended.
    ///
    /// # Errors
    /// The observer does not know a column, or one is not a finite number.
    pub fn begin(
        conditions: &'a [StopCondition],
        stepper: &mut dyn Stepper,
        observer: &mut dyn Observer,
    ) -> Result<Self> {
        let mut watch = Self { conditions, start: State::default(), start_position: 0.0, stopped: None };
        if conditions.is_empty() {
            return Ok(watch);
        }
        let Watched { values, met } = stepper.state().watched.clone();
        if values.len() == conditions.len() {
            watch.stopped =
                met.filter(|&c| c < values.len()).map(|c| watch.stop(c, stepper.state(), &values));
            return Ok(watch);
        }
        let values = watch.measure(0, stepper, observer)?;
        for (condition, value) in conditions.iter().zip(&values) {
            if let Some(message) = already_true(condition, *value) {
                observer.on_warning(&message);
            }
        }
        stepper.watch(&Watched { values, met: None });
        Ok(watch)
    }

    /// Keeps the state at the start of a step.
    pub fn keep(&mut self, stepper: &dyn Stepper) {
        if !self.conditions.is_empty() {
            self.start.clone_from(stepper.state());
            self.start_position = stepper.position();
        }
    }

    /// Condition that has been met.
    pub fn stopped(&self) -> Option<&Stopped> {
        self.stopped.as_ref()
    }

    /// Condition that has been met.
    pub fn into_stopped(self) -> Option<Stopped> {
        self.stopped
    }

    /// Looks at the end of a step. Where a condition has been met, the step is repeated until it ends at the crossing; returns the
    /// iterations of the step that remains.
    ///
    /// # Errors
    /// A column is not a finite number, or the observer asks to stop.
    pub fn look(
        &mut self,
        iterations: u32,
        stepper: &mut dyn Stepper,
        observer: &mut dyn Observer,
    ) -> Result<u32> {
        if self.conditions.is_empty() {
            return Ok(iterations);
        }
        let values = self.measure(iterations, stepper, observer)?;
        if self.crossed(&values).next().is_none() {
            stepper.watch(&Watched { values, met: None });
            return Ok(iterations);
        }
        let whole = Trial { position: stepper.position(), values };
        let (iterations, end, repeats) = self.locate(whole, iterations, stepper, observer)?;
        let met = self.crossed(&end.values).next();
        let Some(met) = met else {
            // By round-off the last repetition has not crossed the value: the analysis continues.
            stepper.release();
            stepper.watch(&Watched { values: end.values, met: None });
            return Ok(iterations);
        };
        let stopped = self.stop(met, stepper.state(), &end.values);
        observer.on_event(&format!(
            "{:.9e}: the analysis ends here, as `{}` has crossed {}: it is {:.9e} ({repeats} repeats of the last step)",
            stopped.time, stopped.column, stopped.value, stopped.reached
        ));
        let change = (stopped.reached - self.start.watched.values[met]).abs();
        if (stopped.reached - stopped.value).abs() > MISSED * change {
            observer.on_warning(&format!(
                "{:.9e}: the analysis ends here, where `{}` is {:.9e}: it has passed {} within a step that cannot end there, as it jumps or preloads \
                 of springs are ramped",
                stopped.time, stopped.column, stopped.reached, stopped.value
            ));
        }
        stepper.watch(&Watched { values: end.values, met: Some(met) });
        self.stopped = Some(stopped);
        Ok(iterations)
    }

    /// Warns of conditions none of which has been met.
    pub fn warn_if_never_met(&self, observer: &mut dyn Observer) {
        if self.conditions.is_empty() || self.stopped.is_some() {
            return;
        }
        let list: Vec<String> = self.conditions.iter().map(described).collect();
        observer.on_warning(&format!(
            "the analysis has reached its end, and no stop condition was met: {}",
            list.join("; ")
        ));
    }

    fn stop(&self, condition: usize, state: &State, values: &[f64]) -> Stopped {
        let StopCondition { column, value, .. } = &self.conditions[condition];
        let (reached, time) = (values[condition], state.time);
        Stopped { condition, column: column.clone(), value: *value, reached, time }
    }

    /// Values of the columns in the state reached.
    fn measure(
        &self,
        iterations: u32,
        stepper: &dyn Stepper,
        observer: &mut dyn Observer,
    ) -> Result<Vec<f64>> {
        let step = stepper.reached().step(iterations);
        let value = |(i, condition): (usize, &StopCondition)| {
            let column = &condition.column;
            match observer.column(column, &step) {
                Some(value) if value.is_finite() => Ok(value),
                Some(value) => Err(Error::NotConverged {
                    at: format!("{:.6e}", step.state.time),
                    reason: format!("the column `{column}` of a stop condition is {value}"),
                    help: "Results up to the step before are complete. Give the condition a column that has a value at all times."
                        .into(),
                }),
                None => Err(Error::model(
                    format!("analysis.stop[{i}].column"),
                    format!("the history has no column `{column}`"),
                    "name a column of the history",
                )),
            }
        };
        self.conditions.iter().enumerate().map(value).collect()
    }

    /// Numbers of the conditions that the step has met which ends with these values.
    fn crossed<'b>(&'b self, values: &'b [f64]) -> impl Iterator<Item = usize> + 'b {
        let before = &self.start.watched.values;
        let met = |&c: &usize| direction(&self.conditions[c], before[c], values[c]).is_some();
        (0..self.conditions.len()).filter(met)
    }

    /// Repeats the step that leads across a value with other lengths, until it ends just behind the first crossing. Returns the
    /// iterations of the step that remains, its end, and the number of repeats.
    fn locate(
        &self,
        whole: Trial,
        iterations: u32,
        stepper: &mut dyn Stepper,
        observer: &mut dyn Observer,
    ) -> Result<(u32, Trial, u32)> {
        let mut bracket = Bracket::new(self, whole);
        // Whether the stepper stands at the end behind the crossing.
        let (mut last, mut repeats, mut stands) = (iterations, 0, true);
        while repeats < MOST_REPEATS && !bracket.is_met(self) {
            stepper.repeat(&self.start, bracket.next(self));
            repeats += 1;
            last = match stepper.advance(observer) {
                Ok(iterations) => iterations,
                Err(error @ (Error::Interrupted | Error::Outside(_))) => return Err(error),
                // The longer step behind the crossing has succeeded.
                Err(error) => {
                    observer.on_event(&format!("the crossing is not located more closely: {error}"));
                    stands = false;
                    break;
                }
            };
            let values = self.measure(last, stepper, observer)?;
            stands = self.crossed(&values).next().is_some();
            bracket.take(self, Trial { position: stepper.position(), values });
        }
        if !stands {
            let end = bracket.high.position;
            let (ends, is_whole) = ([end, f64::INFINITY], end == bracket.whole.position);
            let ends = if is_whole { &ends[..] } else { &ends[..1] };
            (last, bracket.high.values) = self.repeat_up_to(ends, stepper, observer)?;
            repeats += 1;
        }
        Ok((last, bracket.high, repeats))
    }

    /// Repeats the step that leads across a value with limits of its end, until one leads across it again: a path goes over to another one at a bifurcation,
    /// and for this has to pass the place at which the step ends. Returns the iterations of the step, and the columns at its end.
    fn repeat_up_to(
        &self,
        limits: &[f64],
        stepper: &mut dyn Stepper,
        observer: &mut dyn Observer,
    ) -> Result<(u32, Vec<f64>)> {
        let mut outcome = Ok((0, Vec::new()));
        for limit in limits {
            stepper.repeat(&self.start, *limit);
            outcome = match stepper.advance(observer) {
                Ok(iterations) => Ok((iterations, self.measure(iterations, stepper, observer)?)),
                Err(error @ (Error::Interrupted | Error::Outside(_))) => return Err(error),
                Err(error) => Err(error),
            };
            if outcome.as_ref().is_ok_and(|(_, values)| self.crossed(values).next().is_some()) {
                break;
            }
        }
        outcome
    }
}

/// Ends of the step before and behind the first crossing.
struct Bracket {
    /// Start of the step.
    start: f64,
    /// End of the whole step.
    whole: Trial,
    low: Trial,
    high: Trial,
    /// Weights of the differences at both ends.
    weights: [f64; 2],
    /// Whether the last trial has become the end behind the crossing.
    was_high: Option<bool>,
    /// Length of the bracket that is to be halved, and number of trials since.
    to_halve: (f64, u32),
}

impl Bracket {
    fn new(watch: &StopWatch, whole: Trial) -> Self {
        let start = watch.start_position;
        let low = Trial { position: start, values: watch.start.watched.values.clone() };
        let to_halve = (whole.position - start, 0);
        Self { start, high: whole.clone(), whole, low, weights: [1.0; 2], was_high: None, to_halve }
    }

    fn length(&self) -> f64 {
        self.high.position - self.low.position
    }

    /// Distance that a column may have from its value at the end.
    fn tolerance(&self, watch: &StopWatch, c: usize) -> f64 {
        TOLERANCE * (self.whole.values[c] - watch.start.watched.values[c]).abs()
    }

    /// Whether the end behind the crossing is near enough.
    fn is_met(&self, watch: &StopWatch) -> bool {
        let whole = self.whole.position - self.start;
        let far =
            |c: usize| (self.high.values[c] - watch.conditions[c].value).abs() > self.tolerance(watch, c);
        self.length() <= JUMP * whole
            || self.high.position - self.start <= 1.5 * SHORTEST * whole
            || !watch.crossed(&self.high.values).any(far)
    }

    /// End of the next trial: the first of the secants of all conditions that are met at the end of the bracket.
    fn next(&self, watch: &StopWatch) -> f64 {
        let (low, high) = (self.low.position, self.high.position);
        let secant = |c: usize| {
            let sign = direction(&watch.conditions[c], watch.start.watched.values[c], self.high.values[c])?;
            // Just behind the crossing.
            let aim = watch.conditions[c].value + 0.5 * sign * self.tolerance(watch, c);
            let [before, behind] = [&self.low, &self.high].map(|trial| sign * (trial.values[c] - aim));
            let [before, behind] = [self.weights[0] * before, self.weights[1] * behind];
            let share = -before / (behind - before);
            (before < 0.0 && behind > 0.0).then_some(low + share * (high - low))
        };
        let estimate = watch.crossed(&self.high.values).filter_map(secant).min_by(f64::total_cmp);
        let middle = 0.5 * (low + high);
        let end = match estimate {
            Some(time) if self.to_halve.1 < PATIENCE && time > low && time < high => time,
            _ => middle,
        };
        let shortest = self.start + SHORTEST * (self.whole.position - self.start);
        larger(end, shortest)
    }

    /// Takes the end of a trial into the bracket.
    fn take(&mut self, watch: &StopWatch, trial: Trial) {
        let is_high = watch.crossed(&trial.values).next().is_some();
        // The Illinois method: an end that stays twice loses half of its weight.
        self.weights = match (is_high, self.was_high) {
            (true, Some(true)) => [0.5 * self.weights[0], 1.0],
            (false, Some(false)) => [1.0, 0.5 * self.weights[1]],
            _ => [1.0; 2],
        };
        self.was_high = Some(is_high);
        *if is_high { &mut self.high } else { &mut self.low } = trial;
        self.to_halve = match self.to_halve {
            (length, _) if self.length() <= 0.5 * length => (self.length(), 0),
            (_, trials) if trials >= PATIENCE => (self.length(), 0),
            (length, trials) => (length, trials + 1),
        };
    }
}

/// Sign of the direction in which a condition is met between two values of its column; `None` where it is not.
fn direction(condition: &StopCondition, before: f64, after: f64) -> Option<f64> {
    let StopCondition { value, direction, .. } = condition;
    let rises = before < *value && after >= *value && *direction != Crossing::Falling;
    let falls = before > *value && after <= *value && *direction != Crossing::Rising;
    match (rises, falls) {
        (true, _) => Some(1.0),
        (_, true) => Some(-1.0),
        _ => None,
    }
}

/// Message about a condition that holds where the analysis begins.
fn already_true(condition: &StopCondition, value: f64) -> Option<String> {
    let holds = match condition.direction {
        Crossing::Rising => value >= condition.value,
        Crossing::Falling => value <= condition.value,
        Crossing::Either => value == condition.value,
    };
    holds.then(|| {
        format!(
            "the stop condition {} is true at the start, where the column is {value}: the analysis ends only where the column \
             crosses the value again",
            described(condition)
        )
    })
}

/// Condition in words.
fn described(condition: &StopCondition) -> String {
    let StopCondition { column, value, direction } = condition;
    match direction {
        Crossing::Rising => format!("`{column}` rises to {value}"),
        Crossing::Falling => format!("`{column}` falls to {value}"),
        Crossing::Either => format!("`{column}` crosses {value}"),
    }
}
