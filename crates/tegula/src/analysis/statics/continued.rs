//! Static analysis that the arc-length method takes over at the critical point at which load steps end.
//!
//! Whether it is a limit point need not be known: behind a bifurcation the path is unstable, so that its end is refused.

use super::load_steps::LoadSteps;
use crate::analysis::direct::Direct;
use crate::analysis::path::{Advance, ArcLengthSteps, BeforeArcLength, CriticalKind, PathState};
use crate::analysis::{Observer, State, Stepper as _};
use crate::model::{PathAnalysis, PathMethod};
use crate::{Error, Result};

/// Options of the path behind the critical point.
pub fn path_options() -> PathAnalysis {
    PathAnalysis { method: Some(PathMethod::ArcLength), ..PathAnalysis::default() }
}

/// State of a static analysis that may go on along a path: the load factor is the path parameter of load steps.
pub(super) fn on_path(state: State) -> State {
    if state.path.is_some() {
        return state;
    }
    State { path: Some(Box::new(PathState { position: state.time, ..PathState::default() })), ..state }
}

/// Whether the arc-length method has taken over before a state.
pub(super) fn is_behind_load_steps(state: &State) -> bool {
    state.path.as_ref().is_some_and(|path| path.arc.is_some())
}

impl<'a> BeforeArcLength<'a> for LoadSteps<'a, Direct> {
    fn advance_or_hand_over(&mut self, observer: &mut dyn Observer) -> Result<Advance<'a>> {
        match self.advance(observer) {
            Err(Error::NotConverged { reason, .. }) if self.path_leads_on() => {
                let (system, state, statistics, limit) = self.parts();
                observer.on_event(&format!(
                    "load steps lead no further than load factor {:.6} ({reason}); the analysis goes on along the equilibrium path",
                    state.time
                ));
                let steps =
                    ArcLengthSteps::behind_steps(system, &path_options(), (state, statistics, limit))?;
                Ok(Advance::HandedOver(Box::new(steps), None))
            }
            outcome => outcome.map(Advance::Taken),
        }
    }
}

/// Refuses the end of a path that is no stable equilibrium under the full loads. Load steps have judged their own end.
pub(super) fn accept_end(state: &State, allow_unstable: bool) -> Result<()> {
    let failed = |reason: String, help: &str| Error::NotConverged {
        at: format!("load factor {:.6}", state.time),
        reason,
        help: format!("Results up to this load factor are complete. {help}"),
    };
    if !is_behind_load_steps(state) {
        return Ok(());
    }
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
