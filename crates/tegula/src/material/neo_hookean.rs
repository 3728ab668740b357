//! Neo-Hookean material.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{Hyperelastic, Law, MaterialKeys};
use crate::checker::Checker;

/// Neo-Hookean material.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NeoHookean {
    /// Shear modulus μ [force/area], above 0.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub shear: f64,
    /// Bulk modulus κ [force/area], above 0; a thousand times μ is nearly incompressible.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub bulk: f64,
    /// Density ρ [mass/volume]; needed by transient and modal analysis and by gravity.
    #[serde(default)]
    #[schemars(range(min = 0.0))]
    pub density: f64,
    /// Which energy.
    #[serde(default)]
    pub form: NeoHookeanForm,
}

/// Which neo-Hookean energy.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum NeoHookeanForm {
    /// `μ/2 (J^(−2/3) I1 − 3) + κ/2 (J − 1)²`: shape and volume apart.
    #[default]
    Split,
    /// `μ/2 (I1 − 3) − μ ln J + λ/2 (ln J)²` with λ = κ − 2μ/3.
    Coupled,
}

impl MaterialKeys for NeoHookean {
    fn kind(&self) -> &'static str {
        "neo-hookean"
    }

    fn density(&self) -> f64 {
        self.density
    }

    fn law_3d(&self) -> Law {
        Law::Hyperelastic(match self.form {
            NeoHookeanForm::Split => Hyperelastic::Split { c10: 0.5 * self.shear, c01: 0.0, bulk: self.bulk },
            NeoHookeanForm::Coupled => {
                Hyperelastic::Coupled { mu: self.shear, lambda: self.bulk - 2.0 / 3.0 * self.shear }
            }
        })
    }

    fn check(&self, key: &str, c: &mut Checker) {
        c.positive(&format!("{key}.shear"), "the shear modulus", self.shear);
        c.positive(&format!("{key}.bulk"), "the bulk modulus", self.bulk);
    }

    fn example() -> Self {
        Self { shear: 0.8, bulk: 3.0, density: 1.0, form: NeoHookeanForm::Split }
    }
}
