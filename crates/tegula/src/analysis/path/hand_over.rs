//! Steps that the arc-length method takes over where they lead no further: power series, and the load steps of statics.

use super::state::not_continued;
use super::{ArcLengthSteps, SeriesSteps};
use crate::analysis::stepper::Reached;
use crate::analysis::{Balance, Observer, State, Statistics, Stepper, Watched};
use crate::{Error, Result};

/// Steps that the arc-length method may take over.
pub(in crate::analysis) trait BeforeArcLength<'a>: Stepper {
    /// Takes a step, or gives the arc-length steps that lead on from where none can be taken.
    ///
    /// # Errors
    /// No step can be taken, and the arc-length method does not lead on either.
    fn advance_or_hand_over(&mut self, observer: &mut dyn Observer) -> Result<Advance<'a>>;
}

/// Outcome of a step that the arc-length method may take over.
pub(in crate::analysis) enum Advance<'a> {
    /// A step was taken with this number of iterations.
    Taken(u32),
    /// Arc-length steps lead on. Where their first one is not found either, the error is this one, if there is one.
    HandedOver(Box<ArcLengthSteps<'a>>, Option<Error>),
}

/// Steps up to where they lead no further, and arc-length steps from there.
pub(in crate::analysis) enum HandOver<'a, S> {
    Before(Box<S>),
    ArcLength {
        steps: Box<ArcLengthSteps<'a>>,
        /// State from which the arc-length steps began behind others: the state before does not tell their direction.
        begun: Option<Box<State>>,
    },
}

impl<'a, S: BeforeArcLength<'a>> HandOver<'a, S> {
    fn steps(&self) -> &dyn Stepper {
        match self {
            Self::Before(steps) => steps.as_ref(),
            Self::ArcLength { steps, .. } => steps.as_ref(),
        }
    }

    fn steps_mut(&mut self) -> &mut dyn Stepper {
        match self {
            Self::Before(steps) => steps.as_mut(),
            Self::ArcLength { steps, .. } => steps.as_mut(),
        }
    }
}

impl<'a, S: BeforeArcLength<'a>> Stepper for HandOver<'a, S> {
    fn reached(&self) -> Reached<'_> {
        self.steps().reached()
    }

    fn finish(self: Box<Self>) -> (State, Balance, Statistics) {
        match *self {
            Self::Before(steps) => steps.finish(),
            Self::ArcLength { steps, .. } => steps.finish(),
        }
    }

    fn begin(&mut self, observer: &mut dyn Observer) -> Result<bool> {
        self.steps_mut().begin(observer)
    }

    fn advance(&mut self, observer: &mut dyn Observer) -> Result<u32> {
        let Self::Before(before) = self else { return self.steps_mut().advance(observer) };
        let (steps, otherwise) = match before.advance_or_hand_over(observer)? {
            Advance::Taken(iterations) => return Ok(iterations),
            Advance::HandedOver(steps, otherwise) => (steps, otherwise),
        };
        let begun = Some(Box::new(steps.state().clone()));
        *self = Self::ArcLength { steps, begun };
        match (self.steps_mut().advance(observer), otherwise) {
            (Err(Error::NotConverged { .. }), Some(error)) => Err(error),
            (outcome, _) => outcome,
        }
    }

    fn repeat(&mut self, start: &State, end: f64) {
        match self {
            Self::ArcLength { steps, begun: Some(begun) } if has_no_direction(start) => {
                steps.repeat(begun, end)
            }
            _ => self.steps_mut().repeat(start, end),
        }
    }

    fn release(&mut self) {
        self.steps_mut().release();
    }

    fn watch(&mut self, watched: &Watched) {
        self.steps_mut().watch(watched);
    }
}

fn has_no_direction(state: &State) -> bool {
    state.path.as_ref().is_some_and(|path| path.arc.is_none())
}

impl<'a> BeforeArcLength<'a> for SeriesSteps<'a> {
    fn advance_or_hand_over(&mut self, observer: &mut dyn Observer) -> Result<Advance<'a>> {
        let Err(reason) = self.provide_piece() else { return Ok(Advance::Taken(self.advance(observer)?)) };
        let (system, options, state, statistics, limit) = self.parts();
        let failed = not_continued(system, state, &reason);
        // A path that neither method begins has the reason of the first one.
        let (steps, otherwise) = match self.end_of_series() {
            Some(end) => (ArcLengthSteps::behind(self, end), None),
            None if self.has_none_at_start() => {
                let steps = ArcLengthSteps::behind_steps(system, options, (state, statistics, limit));
                (steps, Some(failed.clone()))
            }
            None => return Err(failed),
        };
        let Ok(steps) = steps else { return Err(failed) };
        observer.on_event(&format!(
            "power series lead no further than load factor {:.6} ({reason}); the arc-length method takes over there",
            self.state().time
        ));
        Ok(Advance::HandedOver(Box::new(steps), otherwise))
    }
}
