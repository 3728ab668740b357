//! Load steps along the equilibrium path, where Newton's method at constant load leaves doubt which equilibrium belongs to it.
//!
//! Next to a bifurcation a model with an imperfection has several stable equilibria under the same loads, and its path turns sharply. The
//! arc-length method follows it with steps as short as its curvature asks for, and ends where the load step ends.

use super::LoadSteps;
use crate::Result;
use crate::analysis::newton::{Cause, Converged};
use crate::analysis::path::{ArcLengthSteps, CriticalKind};
use crate::analysis::solver::TangentSolver;
use crate::analysis::statics::continued::{on_path, path_options};
use crate::analysis::statics::failure::{Failure, Kind};
use crate::analysis::{Observer, State, Statistics, Step, Stepper as _};
use crate::model::PathAnalysis;

/// Most arc-length steps for a load step, and tangents after which none of them is repeated any more.
const MOST_STEPS: u32 = 100;
const MOST_TANGENTS: u64 = 500;

/// Observer of a path that is no result: it can be interrupted, and ends where it takes too much work.
struct Unseen<'a> {
    observer: &'a dyn Observer,
    is_tired: bool,
}

impl Observer for Unseen<'_> {
    fn on_step(&mut self, _: &Step) -> Result<()> {
        Ok(())
    }

    fn on_repeat(&mut self, statistics: &Statistics) {
        self.is_tired |= statistics.factorizations > MOST_TANGENTS;
    }

    fn interrupted(&self) -> bool {
        self.is_tired || self.observer.interrupted()
    }
}

impl<S: TangentSolver> LoadSteps<'_, S> {
    /// Equilibrium at a load factor to which the path leads from the last one, as the equation; the inner error tells why there is none
    /// that is stable. `None` where the path could not be followed.
    pub(super) fn along_path(
        &mut self,
        target: f64,
        observer: &mut dyn Observer,
    ) -> Option<std::result::Result<Converged, Failure>> {
        let Self { system, state, .. } = self;
        if system.linear || !system.without_internal_variables() || state.time < 0.0 {
            return None;
        }
        let options = PathAnalysis { end_load: target, max_steps: MOST_STEPS, ..path_options() };
        let begun = (&on_path(state.clone()), &Statistics::default(), f64::INFINITY);
        let mut steps = ArcLengthSteps::behind_steps(system, &options, begun).ok()?;
        let mut limit = None;
        let mut unseen = Unseen { observer: &*observer, is_tired: false };
        let reached = loop {
            if let Err(error) = steps.advance(&mut unseen) {
                let tired = format!("it takes more than {MOST_TANGENTS} factorisations");
                break Err(if unseen.is_tired { tired } else { error.to_string() });
            }
            let Some(path) = &steps.reached().state.path else { break Err("it has no direction".into()) };
            limit = path.critical.iter().find(|p| p.kind == CriticalKind::Limit).map(|p| p.load);
            if limit.is_some() || path.finished {
                let ended = steps.reached().state.time == target;
                break if ended { Ok(()) } else { Err(format!("it has not ended after {MOST_STEPS} steps")) };
            }
        };
        let (end, _, counts) = Box::new(steps).finish();
        self.statistics.iterations += counts.iterations;
        self.factorizations_on_paths += counts.factorizations;
        if let Some(limit) = limit {
            self.limit_on_path = Some(limit);
            return Some(Err(Failure::of_limit(limit)));
        }
        if let Err(reason) = reached {
            observer.on_event(&format!(
                "load factor {target:.6}: the iteration has met unstable equilibria, and the equilibrium path from the last one could not be \
                 followed: {reason}"
            ));
            return None;
        }
        Some(self.at_end_of_path(&end, counts.steps - self.state.step, observer))
    }

    /// Equilibrium at the end of a step that is not cut back any more, along the path where this leads there.
    pub(super) fn at_sharp_turn(
        &mut self,
        target: f64,
        failure: Failure,
        observer: &mut dyn Observer,
    ) -> std::result::Result<Converged, Failure> {
        let leaps = match failure.kind {
            Kind::Unstable | Kind::Leap => true,
            Kind::Iteration(cause) => cause != Cause::Material && failure.negative_pivots > 0,
            _ => false,
        };
        if !leaps || self.accepts_unstable() || self.options.continuation.is_some() {
            return Err(failure);
        }
        // The iteration at the end of the path has another first increment than the load step.
        let first_increment = self.system.norm(&self.newton.first_response);
        match self.along_path(target, observer) {
            Some(Ok(converged)) => Ok(Converged { first_increment, ..converged }),
            _ => Err(failure),
        }
    }

    /// Takes the end of a path as the equation, iterated as load steps are.
    fn at_end_of_path(
        &mut self,
        end: &State,
        steps: u64,
        observer: &mut dyn Observer,
    ) -> std::result::Result<Converged, Failure> {
        let Self { newton, system, state, equation, tolerances, statistics, .. } = self;
        newton.restore(system, end, true);
        equation.u.copy_from_slice(&end.u);
        equation.multipliers.copy_from_slice(&end.multipliers);
        equation.angles.copy_from_slice(&end.angles);
        equation.time = end.time;
        let converged = newton.solve(system, equation, &state.history, tolerances, observer)?;
        statistics.iterations += u64::from(converged.iterations);
        if converged.negative_pivots > 0 {
            let reason = format!(
                "the equilibrium path from the last equilibrium comes to an unstable one ({} negative pivot(s) of the tangent): the structure \
                 would buckle",
                converged.negative_pivots
            );
            return Err(Failure::new(Kind::Unstable, reason, converged.negative_pivots));
        }
        observer.on_event(&format!(
            "load factor {:.6}: the iteration has met unstable equilibria, and the path turns sharply or comes near to another one; {steps} \
             arc-length steps lead to its equilibrium",
            end.time
        ));
        Ok(converged)
    }
}
