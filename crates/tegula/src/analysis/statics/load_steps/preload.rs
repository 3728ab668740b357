//! Springs that are stressed in the reference configuration: their forces, which act at load factor 0, can be led to the model in steps.

use std::sync::Arc;

use super::{Failure, LoadSteps};
use crate::analysis::solver::TangentSolver;
use crate::analysis::{Observer, State, equilibrium};
use crate::element::Nodal;
use crate::system::{Assembly, System};

/// Forces that hold the reference configuration of a model against springs that are stressed there; `None` where it is in equilibrium, or where it is
/// none of a first analysis step.
pub(super) fn of(system: &System) -> Option<Arc<Vec<Nodal>>> {
    if system.linear || system.continues() || !system.has_springs() {
        return None;
    }
    let mut assembly = Assembly::for_forces(system);
    let mut forces = equilibrium::unbalanced(system, &mut assembly, &State::first(system));
    forces.as_flattened_mut().iter_mut().for_each(|force| *force = -*force);
    let size = system.force_norm(&forces);
    (size.is_finite() && size > 0.0).then(|| Arc::new(forces))
}

impl<S: TangentSolver> LoadSteps<'_, S> {
    /// Load factor at which the analysis has started.
    pub(super) fn first_load_factor(&self) -> f64 {
        if self.equation.held.is_some() { -1.0 } else { self.system.first_load_factor() }
    }

    /// Where no cut-back leads from the reference configuration of a model with stressed springs: begins anew at load factor −1, where forces hold the reference configuration that
    /// fade up to load factor 0. Cut-backs leave the springs their whole forces.
    pub(super) fn lead_preload(
        &mut self,
        (target, failure): (f64, &Failure),
        observer: &mut dyn Observer,
    ) -> bool {
        if self.state.step > 0 || self.state.time != 0.0 || self.equation.held.is_some() {
            return false;
        }
        let Some(held) = of(self.system) else { return false };
        self.before_preload =
            Some(Box::new((self.state.clone(), self.equation.clone(), target, failure.clone())));
        self.equation.held = Some(held);
        self.state.time = -1.0;
        self.state.next_step = self.largest;
        self.equation.attempts = 0;
        self.statistics.cutbacks += 1;
        observer.on_repeat(&self.statistics);
        observer.on_event(&format!(
            "no load step leads from the reference configuration: {}; springs that are stressed in the reference configuration are led to their forces from load factor -1 to 0",
            failure.reason
        ));
        self.newton.restore(self.system, &self.state, false);
        true
    }

    /// Where springs could not be led to their forces either: goes back to the reference configuration, and gives the load factor and the failure of the
    /// first step there.
    pub(super) fn back_to_reference(&mut self) -> Option<(f64, Failure)> {
        if self.state.time >= 0.0 {
            return None;
        }
        let (start, equation, target, failure) = *self.before_preload.take()?;
        (self.state, self.equation) = (start, equation);
        self.newton.restore(self.system, &self.state, false);
        Some((target, failure))
    }
}
