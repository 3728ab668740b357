//! Static analysis that goes on along the equilibrium path from the critical point at which load steps end.
//!
//! Whether it is a limit point need not be known: behind a bifurcation the path is unstable, so that its end is refused.

use super::load_steps::LoadSteps;
use crate::analysis::path::{ArcLengthSteps, CriticalKind, PathState};
use crate::analysis::stepper::Reached;
use crate::analysis::{Balance, Observer, State, Statistics, Stepper, Watched};
use crate::model::{PathAnalysis, PathMethod};
use crate::system::System;
use crate::{Error, Result};
use tegula_sparse::SparseLdlt;

/// Load steps, and arc-length steps from where they have ended at a critical point.
pub(super) struct ContinuedSteps<'a> {
    system: &'a System,
    steps: Steps<'a>,
}

enum Steps<'a> {
    Load(Box<LoadSteps<'a, SparseLdlt>>),
    ArcLength(Box<ArcLengthSteps<'a>>),
}

/// Options of the path behind the limit point.
pub fn path_options() -> PathAnalysis {
    PathAnalysis { method: Some(PathMethod::ArcLength), ..PathAnalysis::default() }
}

/// First state of a static analysis that may go on along a path: the load factor is the path parameter of load steps.
pub(super) fn on_path(state: State) -> State {
    State { path: Some(Box::new(PathState { position: state.time, ..PathState::default() })), ..state }
}

impl<'a> ContinuedSteps<'a> {
    /// Static analysis from `start`, a state of the same analysis.
    ///
    /// # Errors
    /// There is not enough memory.
    pub fn new(
        system: &'a System,
        load_steps: impl FnOnce(State) -> Result<LoadSteps<'a, SparseLdlt>>,
        start: State,
    ) -> Result<Self> {
        let start = if start.path.is_none() { on_path(start) } else { start };
        let behind_limit = start.path.as_ref().is_some_and(|path| path.arc.is_some());
        let steps = if behind_limit {
            Steps::ArcLength(Box::new(ArcLengthSteps::new(system, &path_options(), Some(start))?))
        } else {
            Steps::Load(Box::new(load_steps(start)?))
        };
        Ok(Self { system, steps })
    }

    fn steps(&self) -> &dyn Stepper {
        match &self.steps {
            Steps::Load(steps) => steps.as_ref(),
            Steps::ArcLength(steps) => steps.as_ref(),
        }
    }

    fn steps_mut(&mut self) -> &mut (dyn Stepper + 'a) {
        match &mut self.steps {
            Steps::Load(steps) => steps.as_mut(),
            Steps::ArcLength(steps) => steps.as_mut(),
        }
    }
}

impl Stepper for ContinuedSteps<'_> {
    fn reached(&self) -> Reached<'_> {
        self.steps().reached()
    }

    fn finish(self: Box<Self>) -> (State, Balance, Statistics) {
        match self.steps {
            Steps::Load(steps) => steps.finish(),
            Steps::ArcLength(steps) => steps.finish(),
        }
    }

    fn begin(&mut self, observer: &mut dyn Observer) -> Result<bool> {
        self.steps_mut().begin(observer)
    }

    fn advance(&mut self, observer: &mut dyn Observer) -> Result<u32> {
        if let Steps::Load(steps) = &mut self.steps {
            match steps.advance(observer) {
                Err(Error::NotConverged { reason, .. }) if steps.path_leads_on() => {
                    observer.on_event(&format!(
                        "load steps lead no further than load factor {:.6} ({reason}); the analysis goes on along the equilibrium path",
                        steps.state().time
                    ));
                    let path = ArcLengthSteps::behind_steps(self.system, &path_options(), steps.parts())?;
                    self.steps = Steps::ArcLength(Box::new(path));
                }
                outcome => return outcome,
            }
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

/// Refuses the end of a path that is no stable equilibrium under the full loads.
pub(super) fn accept_end(state: &State, allow_unstable: bool) -> Result<()> {
    let failed = |reason: String, help: &str| Error::NotConverged {
        at: format!("load factor {:.6}", state.time),
        reason,
        help: format!("Results up to this load factor are complete. {help}"),
    };
    if state.time != 1.0 {
        return Err(failed(
            "the path behind the critical point has ended before it has come to load factor 1".into(),
            "An analysis of `type = \"path\"` takes more steps (`max_steps`), and ends at a smaller `end_load`.",
        ));
    }
    if state.negative_pivots > 0 && !allow_unstable {
        let critical = state.path.iter().flat_map(|path| &path.critical);
        let bifurcation = critical.into_iter().find(|point| point.kind == CriticalKind::Bifurcation);
        let passed = bifurcation
            .map(|point| format!(" It has passed a bifurcation at load factor {:.6}.", point.load))
            .unwrap_or_default();
        return Err(failed(
            format!(
                "the path comes to load factor 1 in an unstable equilibrium with {} negative eigenvalue(s).{passed}",
                state.negative_pivots
            ),
            "`allow_unstable = true` accepts it. An analysis of `type = \"path\"` follows it beyond load factor 1 with a larger `end_load`, and crossing \
             paths at bifurcations with `switch_at` and `branches`; a small imperfection leads to them, too.",
        ));
    }
    Ok(())
}
