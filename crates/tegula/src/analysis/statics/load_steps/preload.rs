//! Springs that are stressed in the reference configuration: their forces there can be led to the model in steps, from load factor −1 to 0
//! ([`System::part_of_preload`]).

use super::{Failure, Kind, LoadSteps, StaticEquation};
use crate::analysis::newton::Converged;
use crate::analysis::solver::TangentSolver;
use crate::analysis::{Observer, State, equilibrium};
use crate::system::{Assembly, System};

/// First step of an analysis from the reference configuration, to which it goes back where its springs cannot be led to their forces.
pub(super) struct FirstStep {
    state: State,
    equation: StaticEquation,
    target: f64,
    failure: Failure,
    /// Whether it has found an equilibrium.
    converged: bool,
}

/// Whether springs are stressed in the reference configuration of a first analysis step: it is not in equilibrium.
fn is_stressed(system: &System) -> bool {
    if system.linear || system.continues() || !system.has_springs() {
        return false;
    }
    let mut assembly = Assembly::for_forces(system);
    system.force_norm(&equilibrium::unbalanced(system, &mut assembly, &State::first(system))) > 0.0
}

impl<S: TangentSolver> LoadSteps<'_, S> {
    /// Load factor at which the analysis has started.
    pub(super) fn first_load_factor(&self) -> f64 {
        let first = self.system.first_load_factor();
        if self.before_preload.is_some() || self.state.time < first { -1.0 } else { first }
    }

    /// Begins anew at load factor −1, where the springs of a stressed reference configuration have no forces, after a first step that has failed. Cut-backs leave
    /// them their whole forces.
    pub(super) fn lead_preload(
        &mut self,
        (target, failure): (f64, &Failure),
        observer: &mut dyn Observer,
    ) -> bool {
        let at_reference = self.state.step == 0 && self.state.time == 0.0;
        if !at_reference || self.before_preload.is_some() || !is_stressed(self.system) {
            return false;
        }
        let (state, equation, failure) = (self.state.clone(), self.equation.clone(), failure.clone());
        let reason = failure.reason.clone();
        self.before_preload =
            Some(Box::new(FirstStep { state, equation, target, failure, converged: false }));
        self.state.time = -1.0;
        self.state.next_step = self.largest;
        self.equation.attempts = 0;
        self.statistics.cutbacks += 1;
        observer.on_repeat(&self.statistics);
        observer.on_event(&format!(
            "the springs that are stressed in the reference configuration are led to their forces from load factor -1 to 0: {reason}"
        ));
        self.newton.restore(self.system, &self.state, false);
        true
    }

    /// Begins anew where the first step from a stressed reference configuration has met negative pivots: there is no path of equilibria from
    /// there that tells to which of several equilibria the springs lead.
    pub(super) fn leaves_stressed_reference(
        &mut self,
        target: f64,
        converged: &Converged,
        observer: &mut dyn Observer,
    ) -> bool {
        let Some(failure) = self.loses_its_way(converged).filter(|_| self.state.step == 0) else {
            return false;
        };
        let leads = self.lead_preload((target, &failure), observer);
        self.before_preload.iter_mut().for_each(|first| first.converged |= leads);
        leads
    }

    /// Failure of a step that has met negative pivots on the way from or to a stressed reference configuration: along stable equilibria it meets none.
    pub(super) fn loses_its_way(&self, converged: &Converged) -> Option<Failure> {
        let pivots = converged.most_negative_pivots;
        if pivots == 0 || self.accepts_unstable() || self.as_found {
            return None;
        }
        let reason = format!(
            "the iteration has met {pivots} negative pivot(s) of the tangent while springs are led to their forces"
        );
        Some(Failure::new(Kind::Unstable, reason, pivots))
    }

    /// Whether springs are being led to their forces.
    pub(super) fn leads_springs(&self) -> bool {
        self.state.time < 0.0 && self.before_preload.is_some()
    }

    /// Goes back to the first step from a stressed reference configuration where it had found an equilibrium and its springs could not be led to their forces,
    /// as those that hold a body by their tension alone; it is taken then.
    pub(super) fn takes_first_step(&mut self, observer: &mut dyn Observer) -> bool {
        if !self.before_preload.as_ref().is_some_and(|first| first.converged)
            || self.back_to_reference().is_none()
        {
            return false;
        }
        self.as_found = true;
        self.state.next_step = self.largest;
        observer.on_warning(
            "springs are stressed in the reference configuration, and no path of stable equilibria leads from there to the one that was found: there may be \
             others; begin nearer to it, or let a damped motion find it",
        );
        true
    }

    /// Goes back to the reference configuration where springs could not be led to their forces either; gives the load factor and the failure of the
    /// first step there.
    pub(super) fn back_to_reference(&mut self) -> Option<(f64, Failure)> {
        if self.state.time != -1.0 {
            return None;
        }
        let first = *self.before_preload.take()?;
        (self.state, self.equation) = (first.state, first.equation);
        self.newton.restore(self.system, &self.state, false);
        Some((first.target, first.failure))
    }
}
