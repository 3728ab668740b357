//! Preload of springs that are stressed in the reference configuration: it can be ramped from load factor −1 to 0 before the first load step
//! ([`System::part_of_preload`]).

use super::{Failure, Kind, LoadSteps, StaticEquation};
use crate::analysis::newton::Converged;
use crate::analysis::solver::TangentSolver;
use crate::analysis::{Observer, State, equilibrium};
use crate::system::{Assembly, System};

/// First step of an analysis from the reference configuration, to which it goes back where the preload of its springs cannot be ramped.
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
        if self.first_step.is_some() || self.state.time < first { -1.0 } else { first }
    }

    /// Begins the ramp of the preload at load factor −1, where the reference configuration is in equilibrium, after a first step that has failed: cut-backs of
    /// the loads leave the springs their whole forces.
    pub(super) fn begins_ramp(
        &mut self,
        (target, failure): (f64, &Failure),
        observer: &mut dyn Observer,
    ) -> bool {
        let at_reference = self.state.step == 0 && self.state.time == 0.0;
        if !at_reference || self.first_step.is_some() || !is_stressed(self.system) {
            return false;
        }
        let (state, equation, failure) = (self.state.clone(), self.equation.clone(), failure.clone());
        let reason = failure.reason.clone();
        self.first_step = Some(Box::new(FirstStep { state, equation, target, failure, converged: false }));
        self.state.time = -1.0;
        self.state.next_step = self.largest;
        self.equation.attempts = 0;
        self.statistics.cutbacks += 1;
        observer.on_repeat(&self.statistics);
        observer.on_event(&format!(
            "the preload of the springs that are stressed in the reference configuration is ramped from load factor -1 to 0: {reason}"
        ));
        self.newton.restore(self.system, &self.state, false);
        true
    }

    /// Begins the ramp where the first step from a stressed reference configuration has met negative pivots: there is no path of equilibria from
    /// there that tells to which of several equilibria the springs lead.
    pub(super) fn leaves_stressed_reference(
        &mut self,
        target: f64,
        converged: &Converged,
        observer: &mut dyn Observer,
    ) -> bool {
        let Some(failure) = self.meets_negative_pivots(converged).filter(|_| self.state.step == 0) else {
            return false;
        };
        let ramps = self.begins_ramp((target, &failure), observer);
        self.first_step.iter_mut().for_each(|first| first.converged |= ramps);
        ramps
    }

    /// Failure of a step that has met negative pivots in the ramp or from a stressed reference configuration: along stable equilibria it meets none.
    pub(super) fn meets_negative_pivots(&self, converged: &Converged) -> Option<Failure> {
        let pivots = converged.most_negative_pivots;
        if pivots == 0 || self.accepts_unstable() || self.without_ramp {
            return None;
        }
        let reason = format!(
            "the iteration has met {pivots} negative pivot(s) of the tangent while the preload of springs is ramped"
        );
        Some(Failure::new(Kind::Unstable, reason, pivots))
    }

    /// Whether the preload of springs is being ramped, alone or with loads that do not begin at 0.
    pub(super) fn ramps_preload(&self) -> bool {
        self.system.part_of_preload(self.state.time) != 1.0 && is_stressed(self.system)
    }

    /// Whether the preload is being ramped without loads. An analysis that was interrupted in the ramp goes on there.
    pub(super) fn ramps_preload_alone(&self) -> bool {
        self.state.time < self.system.first_load_factor()
    }

    /// Whether the next load step begins in the ramp, which belongs to the first one: forces of springs are those of their whole preload in results.
    pub(super) fn is_within_first_step(&self) -> bool {
        self.state.time < 0.0 && (self.ramps_preload_alone() || self.ramps_preload())
    }

    /// Goes back to the first step from a stressed reference configuration where it had found an equilibrium and the preload could not be ramped, as that of
    /// springs which hold a body by their tension alone; it is taken then.
    pub(super) fn takes_first_step(&mut self, observer: &mut dyn Observer) -> bool {
        if !self.first_step.as_ref().is_some_and(|first| first.converged)
            || self.back_to_reference().is_none()
        {
            return false;
        }
        self.without_ramp = true;
        self.state.next_step = self.largest;
        observer.on_warning(
            "springs are stressed in the reference configuration, and no path of stable equilibria leads from there to the one that was found: there may be \
             others; begin nearer to it, or let a damped motion find it",
        );
        true
    }

    /// Goes back to the reference configuration where the first step of the ramp has failed; gives the load factor and the failure of the
    /// first step there.
    pub(super) fn back_to_reference(&mut self) -> Option<(f64, Failure)> {
        if self.state.time != -1.0 {
            return None;
        }
        let first = *self.first_step.take()?;
        (self.state, self.equation) = (first.state, first.equation);
        self.newton.restore(self.system, &self.state, false);
        Some((first.target, first.failure))
    }
}
