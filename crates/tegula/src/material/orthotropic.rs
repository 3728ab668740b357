//! Orthotropic linear elastic material.

use nalgebra::{Matrix2, Matrix3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::linear::Orthotropy;
use super::{Law, MaterialKeys, Strengths};
use crate::checker::Checker;

/// Orthotropic linear elastic material; axis 1 lies along the fibres, axis 3 along the thickness.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Orthotropic {
    /// Young's moduli E1, E2, E3 [force/area], above 0.
    #[schemars(transform = crate::checker::positive_entries)]
    pub young: [f64; 3],
    /// Poisson's ratios ν12, ν13, ν23: contraction along the second axis under stress along the first.
    pub poisson: [f64; 3],
    /// Shear moduli G12, G13, G23 [force/area], above 0.
    #[schemars(transform = crate::checker::positive_entries)]
    pub shear: [f64; 3],
    /// Density ρ [mass/volume]; needed by transient and modal analysis and by gravity.
    #[serde(default)]
    #[schemars(range(min = 0.0))]
    pub density: f64,
    /// Thermal expansions α1, α2, α3 [1/temperature].
    #[serde(default)]
    pub expansion: [f64; 3],
    /// Strengths, for failure indices.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub strength: Option<Strengths>,
}

impl Orthotropic {
    /// Elastic constants.
    pub(crate) fn constants(&self) -> Orthotropy {
        Orthotropy { young: self.young, poisson: self.poisson, shear: self.shear }
    }
}

impl MaterialKeys for Orthotropic {
    fn kind(&self) -> &'static str {
        "orthotropic"
    }

    fn density(&self) -> f64 {
        self.density
    }

    fn expansion(&self) -> [f64; 3] {
        self.expansion
    }

    fn strength(&self) -> Option<Strengths> {
        self.strength
    }

    fn is_linear(&self) -> bool {
        true
    }

    fn is_isotropic(&self) -> bool {
        false
    }

    fn law_3d(&self) -> Law {
        Law::Linear(Box::new(self.constants().stiffness()))
    }

    fn plane_stress(&self) -> Option<(Matrix3<f64>, Matrix2<f64>, f64)> {
        let c = self.constants();
        Some((c.plane_stress(), c.transverse_shear(), self.young[2]))
    }

    fn check(&self, key: &str, c: &mut Checker) {
        for (name, values) in [("young", self.young), ("shear", self.shear)] {
            for (i, v) in values.into_iter().enumerate() {
                c.positive(&format!("{key}.{name}[{i}]"), "the modulus", v);
            }
        }
        c.finite(&format!("{key}.poisson"), "Poisson's ratio", &self.poisson);
        if c.issues.is_empty() && !self.constants().is_stable() {
            c.add(
                format!("{key}.poisson"),
                "the compliance is not positive definite: the constants contradict each other",
                "|ν_ij| must be below √(E_i/E_j); ν_ij belongs to stress along axis i",
            );
        }
    }

    fn example() -> Self {
        Self {
            young: [140.0, 10.0, 9.0],
            poisson: [0.3, 0.28, 0.4],
            shear: [5.0, 4.5, 3.5],
            density: 1.0,
            expansion: [0.0; 3],
            strength: None,
        }
    }
}
