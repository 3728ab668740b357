//! Steps of a path whose method is not given: power series as far as they lead, then the arc-length method.

use super::state::not_continued;
use super::{ArcLengthSteps, SeriesSteps};
use crate::analysis::stepper::Reached;
use crate::analysis::{Balance, Observer, State, Statistics, Stepper, Watched};
use crate::{Error, Result};

/// A path of power series, and of arc-length steps from where they lead no further.
pub(super) enum AutomaticSteps<'a> {
    Series(Box<SeriesSteps<'a>>),
    ArcLength {
        steps: Box<ArcLengthSteps<'a>>,
        /// State from which the steps began behind power series: the state before, which has no direction, does not tell it.
        begun: Option<Box<State>>,
    },
}

impl<'a> AutomaticSteps<'a> {
    fn steps(&self) -> &dyn Stepper {
        match self {
            Self::Series(steps) => steps.as_ref(),
            Self::ArcLength { steps, .. } => steps.as_ref(),
        }
    }

    fn steps_mut(&mut self) -> &mut (dyn Stepper + 'a) {
        match self {
            Self::Series(steps) => steps.as_mut(),
            Self::ArcLength { steps, .. } => steps.as_mut(),
        }
    }
}

impl Stepper for AutomaticSteps<'_> {
    fn reached(&self) -> Reached<'_> {
        self.steps().reached()
    }

    fn finish(self: Box<Self>) -> (State, Balance, Statistics) {
        match *self {
            Self::Series(steps) => steps.finish(),
            Self::ArcLength { steps, .. } => steps.finish(),
        }
    }

    fn begin(&mut self, observer: &mut dyn Observer) -> Result<bool> {
        self.steps_mut().begin(observer)
    }

    fn advance(&mut self, observer: &mut dyn Observer) -> Result<u32> {
        if let Self::Series(series) = self
            && let Err(reason) = series.provide_piece()
        {
            let failed = not_continued(series.state(), &reason);
            let from_start = series.end_of_series().is_none();
            let Some(steps) = going_on(series) else { return Err(failed) };
            observer.on_event(&format!(
                "power series lead no further than load factor {:.6} ({reason}); the arc-length method goes on from there",
                series.state().time
            ));
            let begun = Some(Box::new(steps.state().clone()));
            *self = Self::ArcLength { steps: Box::new(steps), begun };
            let outcome = self.steps_mut().advance(observer);
            // A path that neither method begins has the reason of the first one.
            return if from_start && matches!(outcome, Err(Error::NotConverged { .. })) {
                Err(failed)
            } else {
                outcome
            };
        }
        self.steps_mut().advance(observer)
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

/// Arc-length steps from where series lead no further: behind the last one, or from the start of the path.
fn going_on<'a>(series: &SeriesSteps<'a>) -> Option<ArcLengthSteps<'a>> {
    let (system, options, state, statistics, limit) = series.parts();
    match series.end_of_series() {
        Some(end) => ArcLengthSteps::behind(series, end).ok(),
        None if series.has_none_at_start() => {
            ArcLengthSteps::behind_steps(system, options, (state, statistics, limit)).ok()
        }
        None => None,
    }
}

fn has_no_direction(state: &State) -> bool {
    state.path.as_ref().is_some_and(|path| path.arc.is_none())
}
