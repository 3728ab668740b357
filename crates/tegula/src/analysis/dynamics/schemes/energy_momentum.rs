//! Energy–momentum scheme.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{Instant, SchemeKeys};
use crate::analysis::dynamics::Integrator;
use crate::analysis::dynamics::energy_momentum::EnergyMomentum;
use crate::checker::Checker;
use crate::load::ForceFormula;
use crate::model::{Amplitude, Bushing, Condition, Model, TransientAnalysis};
use crate::system::System;

/// Energy–momentum scheme.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EnergyMomentumScheme {
    /// Order of accuracy: 2, or 4 by steps that are composed of five of second order. Order 4 needs a constant `time_step`, and a
    /// model without damping: one of the five goes back in time.
    #[serde(default = "second")]
    #[schemars(range(min = 2, max = 4))]
    pub order: u32,
}

impl Default for EnergyMomentumScheme {
    fn default() -> Self {
        Self { order: second() }
    }
}

impl EnergyMomentumScheme {
    fn is_composed(self) -> bool {
        self.order > 2
    }
}

impl SchemeKeys for EnergyMomentumScheme {
    const WORD: &'static str = "energy-momentum";

    fn check(&self, key: &str, c: &mut Checker) {
        if ![2, 4].contains(&self.order) {
            c.add(
                format!("{key}.order"),
                format!("the order is {}", self.order),
                "give 2, or 4 for precise motions without damping",
            );
        }
    }

    fn check_model(&self, key: &str, model: &Model, options: &TransientAnalysis, c: &mut Checker) {
        if !self.is_composed() {
            return;
        }
        let mut refuse = |message: String, help: &str| c.add(format!("{key}.order"), message, help);
        if options.time_step.is_none() {
            refuse(
                "steps of order 4 have a constant length".into(),
                "give `analysis.time_step`, or use `order = 2`",
            );
        }
        let damped = |what: &str| {
            format!("steps of order 4 go back in time on the way, where {what} would supply energy")
        };
        let damping = &model.damping;
        if damping.mass != 0.0 || damping.stiffness != 0.0 {
            refuse(damped("`damping`"), "use `order = 2`, or drop the damping");
        }
        if let Some(i) = model.sections.iter().position(|s| s.retardation_time != 0.0) {
            refuse(damped(&format!("the retardation time of sections[{i}]")), "use `order = 2`, or drop it");
        }
        if let Some(beam) = model.beams.iter().find(|beam| beam.retardation_time != 0.0) {
            let what = format!("the retardation time of beam \"{}\"", beam.name);
            refuse(damped(&what), "use `order = 2`, or drop it");
        }
        let has_damper = |bushing: &&Bushing| bushing.damping() != nalgebra::Matrix6::zeros();
        if let Some(bushing) = model.bushings.iter().find(has_damper) {
            refuse(
                damped(&format!("the damper of \"{}\"", bushing.name)),
                "use `order = 2`, or drop its damping",
            );
        }
        if let Some(i) = model.foundations.iter().position(|f| f.retardation_time() != 0.0) {
            refuse(
                damped(&format!("the retardation time of foundations[{i}]")),
                "use `order = 2`, or drop it",
            );
        }
        if let Some(name) = model.amplitudes.keys().find(|name| moves_with_kinks(model, name)) {
            let message = format!(
                "a motion follows the amplitude \"{name}\", whose kinks steps of order 4 do not pass"
            );
            refuse(message, "give the motion a formula or a spline, or use `order = 2`");
        }
        if let Some(name) = spring_with_damper(model) {
            refuse(damped(&format!("the damper of \"{name}\"")), "use `order = 2`, or drop its damping");
        }
    }

    fn integrator(&self, system: &System) -> Option<Box<dyn Integrator>> {
        Some(Box::new(EnergyMomentum::new(system, self.is_composed())))
    }

    fn instant(&self, _system: &System) -> Instant {
        // Composed steps find accelerations and multipliers of their end.
        if self.is_composed() { Instant::End } else { Instant::Middle }
    }

    fn conserves_energy(&self) -> bool {
        true
    }

    fn moves_bodies(&self) -> bool {
        true
    }
}

/// Name of the first spring or torsion spring whose force depends on its rate.
fn spring_with_damper(model: &Model) -> Option<&String> {
    // Invalid formulas are refused elsewhere.
    let acts = |damping: f64, formula: Option<&String>| {
        damping != 0.0
            || formula.is_some_and(|text| ForceFormula::read(text).is_ok_and(|law| law.depends_on_rate()))
    };
    let springs = model.springs.iter().map(|s| (&s.name, acts(s.damping, s.force.as_ref())));
    let torsion = model.torsion_springs.iter().map(|s| (&s.name, acts(s.damping, s.moment.as_ref())));
    springs.chain(torsion).find_map(|(name, acts)| acts.then_some(name))
}

/// Whether a prescribed motion or a drive follows an amplitude with kinks.
fn moves_with_kinks(model: &Model, name: &str) -> bool {
    let driven = model.joints.iter().any(|joint| joint.common().drive().is_some_and(|d| d.amplitude == name));
    let follows = |condition: &Condition| {
        condition.motion().is_some_and(|motion| motion.amplitude.as_deref() == Some(name))
    };
    matches!(model.amplitudes.get(name), Some(Amplitude::Table(_) | Amplitude::Ramp(_)))
        && (driven || model.conditions.iter().any(follows))
}

fn second() -> u32 {
    2
}
