//! Newmark-β.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::SchemeKeys;
use crate::analysis::dynamics::Integrator;
use crate::analysis::dynamics::newmark::Newmark;
use crate::checker::Checker;
use crate::system::System;

/// Newmark-β.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NewmarkScheme {
    /// β, above 0; unconditionally stable (linear) for β ≥ γ/2 ≥ 1/4.
    #[serde(default = "quarter")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub beta: f64,
    /// γ; 1/2 is second order, above it is damped and first order.
    #[serde(default = "half")]
    #[schemars(range(min = 0.5, max = 1.0))]
    pub gamma: f64,
}

impl Default for NewmarkScheme {
    fn default() -> Self {
        Self { beta: 0.25, gamma: 0.5 }
    }
}

impl SchemeKeys for NewmarkScheme {
    const WORD: &'static str = "newmark";

    fn check(&self, key: &str, c: &mut Checker) {
        c.positive(&format!("{key}.beta"), "β", self.beta);
        if !(self.gamma >= 0.5 && self.gamma <= 1.0) {
            c.add(
                format!("{key}.gamma"),
                format!("γ is {}; it must lie in 0.5…1", self.gamma),
                "use 0.5 unless damping is wanted",
            );
        }
    }

    fn integrator(&self, system: &System) -> Option<Box<dyn Integrator>> {
        Some(Box::new(Newmark::new(system, self.beta, self.gamma, 0.0)))
    }
}

fn quarter() -> f64 {
    0.25
}
fn half() -> f64 {
    0.5
}
