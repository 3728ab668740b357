//! Elastic-plastic material with the yield condition of von Mises.

use nalgebra::{Matrix2, Matrix3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::isotropic::elastic_plane_stress;
use super::{Law, MaterialKeys, PlaneStressPlasticity, Plasticity, check_poisson};
use crate::checker::Checker;

/// Elastic-plastic material.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Plastic {
    /// Young's modulus E [force/area], above 0.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub young: f64,
    /// Poisson's ratio ν, above −1 and below 0.5.
    #[schemars(extend("exclusiveMinimum" = -1, "exclusiveMaximum" = 0.5))]
    pub poisson: f64,
    /// Yield stress y₀ [force/area], above 0.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub yield_stress: f64,
    /// Linear isotropic hardening modulus H: slope of the yield stress over the plastic strain [force/area].
    #[serde(default)]
    #[schemars(range(min = 0.0))]
    pub hardening: f64,
    /// Stress y∞ at which hardening saturates [force/area]; no saturation unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub saturation: Option<f64>,
    /// Rate δ of saturation: y = y₀ + H p + (y∞ − y₀)(1 − exp(−δ p)).
    #[serde(default)]
    #[schemars(range(min = 0.0))]
    pub saturation_rate: f64,
    /// Kinematic hardening modulus H_k [force/area].
    #[serde(default)]
    #[schemars(range(min = 0.0))]
    pub kinematic: f64,
    /// Density ρ [mass/volume]; needed by transient and modal analysis and by gravity.
    #[serde(default)]
    #[schemars(range(min = 0.0))]
    pub density: f64,
    /// Thermal expansion α [1/temperature].
    #[serde(default, skip_serializing_if = "crate::checker::is_zero")]
    pub expansion: f64,
}

impl Plastic {
    fn law(&self) -> Plasticity {
        Plasticity {
            young: self.young,
            poisson: self.poisson,
            yield_stress: self.yield_stress,
            hardening: self.hardening,
            saturation: self.saturation.unwrap_or(self.yield_stress),
            rate: self.saturation_rate,
            kinematic: self.kinematic,
        }
    }
}

impl MaterialKeys for Plastic {
    fn kind(&self) -> &'static str {
        "plastic"
    }

    fn density(&self) -> f64 {
        self.density
    }

    fn expansion(&self) -> [f64; 3] {
        [self.expansion; 3]
    }

    fn yields(&self) -> bool {
        true
    }

    fn law_3d(&self) -> Law {
        Law::Plastic(self.law())
    }

    fn law_plane_stress(&self) -> Option<Law> {
        Some(Law::PlaneStressPlastic(PlaneStressPlasticity(self.law())))
    }

    fn plane_stress(&self) -> Option<(Matrix3<f64>, Matrix2<f64>, f64)> {
        Some(elastic_plane_stress(self.young, self.poisson))
    }

    fn check(&self, key: &str, c: &mut Checker) {
        c.positive(&format!("{key}.young"), "Young's modulus", self.young);
        check_poisson(key, c, self.poisson);
        c.positive(&format!("{key}.yield_stress"), "the yield stress", self.yield_stress);
        for (name, v) in [
            ("hardening", self.hardening),
            ("saturation_rate", self.saturation_rate),
            ("kinematic", self.kinematic),
        ] {
            c.not_negative(&format!("{key}.{name}"), &format!("`{name}`"), v);
        }
        if self.saturation.is_some_and(|s| s.is_nan() || s < self.yield_stress) {
            c.add(
                format!("{key}.saturation"),
                "the saturation stress is below the yield stress: softening has no unique solution",
                "give a stress of at least `yield_stress`",
            );
        }
    }

    fn example() -> Self {
        Self {
            young: 2e5,
            poisson: 0.3,
            yield_stress: 250.0,
            hardening: 1000.0,
            saturation: Some(400.0),
            saturation_rate: 30.0,
            kinematic: 2000.0,
            density: 1.0,
            expansion: 0.0,
        }
    }

    fn example_strain(&self) -> f64 {
        0.01
    }
}
