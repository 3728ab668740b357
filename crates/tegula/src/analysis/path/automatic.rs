//! Steps of a path whose method is not given: power series as far as they lead, then the arc-length method.

use super::state::not_continued;
use super::{ArcLengthSteps, SeriesSteps};
use crate::Result;
use crate::analysis::stepper::Reached;
use crate::analysis::{Balance, Observer, State, Statistics, Stepper, Watched};

/// A path of power series, and of arc-length steps from where they lead no further.
pub(super) enum AutomaticSteps<'a> {
    Series(Box<SeriesSteps<'a>>),
    ArcLength(Box<ArcLengthSteps<'a>>),
}

impl<'a> AutomaticSteps<'a> {
    fn steps(&self) -> &dyn Stepper {
        match self {
            Self::Series(steps) => steps.as_ref(),
            Self::ArcLength(steps) => steps.as_ref(),
        }
    }

    fn steps_mut(&mut self) -> &mut (dyn Stepper + 'a) {
        match self {
            Self::Series(steps) => steps.as_mut(),
            Self::ArcLength(steps) => steps.as_mut(),
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
            Self::ArcLength(steps) => steps.finish(),
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
            let Some(end) = series.end_of_series() else { return Err(failed) };
            let Ok(steps) = ArcLengthSteps::behind(series, end) else { return Err(failed) };
            observer.on_event(&format!(
                "power series lead no further than load factor {:.6} ({reason}); the arc-length method goes on from there",
                series.state().time
            ));
            *self = Self::ArcLength(Box::new(steps));
        }
        self.steps_mut().advance(observer)
    }

    fn repeat(&mut self, start: &State, end: f64) {
        self.steps_mut().repeat(start, end);
    }

    fn release(&mut self) {
        self.steps_mut().release();
    }

    fn watch(&mut self, watched: &Watched) {
        self.steps_mut().watch(watched);
    }
}
