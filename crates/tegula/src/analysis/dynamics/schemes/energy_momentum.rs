//! Energy–momentum scheme.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{Instant, SchemeKeys};
use crate::analysis::dynamics::Integrator;
use crate::analysis::dynamics::energy_momentum::EnergyMomentum;
use crate::system::System;

/// Energy–momentum scheme; it has no parameters.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EnergyMomentumScheme {}

impl SchemeKeys for EnergyMomentumScheme {
    const WORD: &'static str = "energy-momentum";

    fn integrator(&self, system: &System) -> Option<Box<dyn Integrator>> {
        Some(Box::new(EnergyMomentum::new(system)))
    }

    fn instant(&self) -> Instant {
        Instant::Middle
    }

    fn conserves_energy(&self) -> bool {
        true
    }
}
