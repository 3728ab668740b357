//! Mooney–Rivlin material.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{Hyperelastic, Law, MaterialKeys};
use crate::checker::Checker;

/// Mooney–Rivlin material: `ψ = c10 (Ī1 − 3) + c01 (Ī2 − 3) + κ/2 (J − 1)²`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MooneyRivlin {
    /// Constant c10 [force/area].
    pub c10: f64,
    /// Constant c01 [force/area]; c10 + c01 above 0 is half the shear modulus.
    pub c01: f64,
    /// Bulk modulus κ [force/area], above 0.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub bulk: f64,
    /// Density ρ [mass/volume]; needed by transient and modal analysis and by gravity.
    #[serde(default)]
    #[schemars(range(min = 0.0))]
    pub density: f64,
}

impl MaterialKeys for MooneyRivlin {
    fn kind(&self) -> &'static str {
        "mooney-rivlin"
    }

    fn density(&self) -> f64 {
        self.density
    }

    fn law_3d(&self) -> Law {
        Law::Hyperelastic(Hyperelastic::Split { c10: self.c10, c01: self.c01, bulk: self.bulk })
    }

    fn check(&self, key: &str, c: &mut Checker) {
        c.finite(&format!("{key}.c01"), "the constant", &[self.c01]);
        c.positive(&format!("{key}.c10"), "c10 + c01", self.c10 + self.c01);
        c.positive(&format!("{key}.bulk"), "the bulk modulus", self.bulk);
    }

    fn example() -> Self {
        Self { c10: 0.4, c01: 0.15, bulk: 900.0, density: 1.0 }
    }
}
