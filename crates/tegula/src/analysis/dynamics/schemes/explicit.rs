//! Central differences.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::SchemeKeys;
use crate::analysis::dynamics::Integrator;
use crate::checker::Checker;
use crate::model::{Joint, Model, TransientAnalysis};
use crate::system::System;

/// Central differences with lumped mass; the step follows from the highest frequency of the model.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ExplicitScheme {
    /// Make directors heavier until they vibrate no faster than the membrane, so that the thickness does not limit the
    /// step.
    #[serde(default = "yes")]
    pub scale_director_inertia: bool,
}

impl Default for ExplicitScheme {
    fn default() -> Self {
        Self { scale_director_inertia: true }
    }
}

impl SchemeKeys for ExplicitScheme {
    const WORD: &'static str = "explicit";

    fn integrator(&self, _: &System) -> Option<Box<dyn Integrator>> {
        None
    }

    fn check_model(&self, key: &str, model: &Model, _: &TransientAnalysis, c: &mut Checker) {
        let mut refuse = |message: String, help: &str| c.add(key, message, help);
        for joint in model.joints.iter().map(Joint::common) {
            for (what, given) in
                [("friction", joint.friction().is_some()), ("stops", joint.stops().is_some())]
            {
                if given {
                    refuse(
                        format!("explicit steps do not compute the {what} of joint \"{}\"", joint.name()),
                        "use `energy-momentum`, or leave it out",
                    );
                }
            }
        }
        if let Some(beam) = model.beams.first() {
            refuse(
                format!("explicit steps do not move beams: the mass of \"{}\" is not lumped", beam.name),
                "use `energy-momentum`, `generalized-alpha` or `bdf2`, or shells in place of beams",
            );
        }
    }

    fn is_explicit(&self) -> bool {
        true
    }

    fn moves_bodies(&self) -> bool {
        true
    }
}

fn yes() -> bool {
    true
}
