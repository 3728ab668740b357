//! Hilber–Hughes–Taylor α method.
//!
//! Systems of bodies and joints take it as the generalised-α method with α_m = 0, whose equations of motion hold at the end of the step
//! together with the constraints.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{Instant, SchemeKeys};
use crate::analysis::dynamics::Integrator;
use crate::analysis::dynamics::generalized_alpha::GeneralizedAlpha;
use crate::analysis::dynamics::newmark::Newmark;
use crate::checker::Checker;
use crate::system::System;

/// Hilber–Hughes–Taylor.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HhtScheme {
    /// α between −1/3 (most damping) and 0 (none).
    #[serde(default = "hht_alpha")]
    #[schemars(extend("minimum" = -1.0 / 3.0, "maximum" = 0))]
    pub alpha: f64,
}

impl Default for HhtScheme {
    fn default() -> Self {
        Self { alpha: hht_alpha() }
    }
}

impl SchemeKeys for HhtScheme {
    const WORD: &'static str = "hht";

    fn check(&self, key: &str, c: &mut Checker) {
        if !(-1.0 / 3.0..=0.0).contains(&self.alpha) {
            c.add(
                format!("{key}.alpha"),
                format!("α is {}; it must lie in -1/3…0", self.alpha),
                "use -0.05 for light damping",
            );
        }
    }

    fn integrator(&self, system: &System) -> Option<Box<dyn Integrator>> {
        let a = self.alpha;
        if system.is_mechanism() {
            return Some(Box::new(GeneralizedAlpha::hht(system, a)));
        }
        Some(Box::new(Newmark::new(system, 0.25 * (1.0 - a) * (1.0 - a), 0.5 - a, -a)))
    }

    fn instant(&self, system: &System) -> Instant {
        if system.is_mechanism() { Instant::End } else { Instant::Between(-self.alpha) }
    }

    fn moves_bodies(&self) -> bool {
        true
    }
}

fn hht_alpha() -> f64 {
    -0.05
}
