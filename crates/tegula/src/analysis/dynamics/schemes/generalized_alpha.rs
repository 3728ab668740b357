//! Generalised-α method.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::SchemeKeys;
use crate::analysis::dynamics::Integrator;
use crate::analysis::dynamics::generalized_alpha::GeneralizedAlpha;
use crate::checker::Checker;
use crate::system::System;

/// Generalised-α method (Chung–Hulbert; Arnold–Brüls for joints).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GeneralizedAlphaScheme {
    /// Spectral radius ρ at high frequencies: 0 damps motions that the step does not resolve at once, 1 (trapezoidal rule) not at all.
    #[serde(default = "recommended")]
    #[schemars(range(min = 0.0, max = 1.0))]
    pub spectral_radius: f64,
}

impl Default for GeneralizedAlphaScheme {
    fn default() -> Self {
        Self { spectral_radius: recommended() }
    }
}

impl SchemeKeys for GeneralizedAlphaScheme {
    const WORD: &'static str = "generalized-alpha";

    fn check(&self, key: &str, c: &mut Checker) {
        if !(0.0..=1.0).contains(&self.spectral_radius) {
            c.add(
                format!("{key}.spectral_radius"),
                format!("ρ is {}; it must lie in 0…1", self.spectral_radius),
                "use 0.8 for light damping",
            );
        }
    }

    fn integrator(&self, system: &System) -> Option<Box<dyn Integrator>> {
        Some(Box::new(GeneralizedAlpha::new(system, self.spectral_radius)))
    }

    fn moves_bodies(&self) -> bool {
        true
    }
}

fn recommended() -> f64 {
    0.8
}
