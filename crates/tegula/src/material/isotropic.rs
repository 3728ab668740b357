//! Isotropic linear elastic material.

use nalgebra::{Matrix2, Matrix3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::linear::{isotropic, isotropic_plane_stress};
use super::{Law, MaterialKeys, Strengths, check_poisson};
use crate::checker::Checker;

/// Isotropic linear elastic material.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Isotropic {
    /// Young's modulus E [force/area], above 0.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub young: f64,
    /// Poisson's ratio ν, above −1 and below 0.5.
    #[schemars(extend("exclusiveMinimum" = -1, "exclusiveMaximum" = 0.5))]
    pub poisson: f64,
    /// Density ρ [mass/volume]; needed by transient and modal analysis and by gravity.
    #[serde(default)]
    #[schemars(range(min = 0.0))]
    pub density: f64,
    /// Thermal expansion α [1/temperature].
    #[serde(default, skip_serializing_if = "crate::checker::is_zero")]
    pub expansion: f64,
    /// Strengths, for failure indices.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub strength: Option<Strengths>,
}

impl Isotropic {
    /// From Young's modulus, Poisson's ratio and density.
    pub fn new(young: f64, poisson: f64, density: f64) -> Self {
        Self { young, poisson, density, expansion: 0.0, strength: None }
    }
}

impl MaterialKeys for Isotropic {
    fn kind(&self) -> &'static str {
        "isotropic"
    }

    fn density(&self) -> f64 {
        self.density
    }

    fn expansion(&self) -> [f64; 3] {
        [self.expansion; 3]
    }

    fn strength(&self) -> Option<Strengths> {
        self.strength
    }

    fn is_linear(&self) -> bool {
        true
    }

    fn law_3d(&self) -> Law {
        Law::Linear(Box::new(isotropic(self.young, self.poisson)))
    }

    fn plane_stress(&self) -> Option<(Matrix3<f64>, Matrix2<f64>, f64)> {
        Some(elastic_plane_stress(self.young, self.poisson))
    }

    fn check(&self, key: &str, c: &mut Checker) {
        c.positive(&format!("{key}.young"), "Young's modulus", self.young);
        check_poisson(key, c, self.poisson);
    }

    fn example() -> Self {
        Self::new(7.0, 0.3, 1.0)
    }
}

/// Plane stress, transverse shear and thickness modulus of an isotropic material.
pub(super) fn elastic_plane_stress(young: f64, poisson: f64) -> (Matrix3<f64>, Matrix2<f64>, f64) {
    let g = 0.5 * young / (1.0 + poisson);
    (isotropic_plane_stress(young, poisson), Matrix2::identity() * g, young)
}
