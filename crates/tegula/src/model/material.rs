//! Materials as the model file gives them.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A material.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "type", rename_all = "kebab-case")]
pub enum Material {
    /// Isotropic linear elastic (St. Venant–Kirchhoff).
    Isotropic(Isotropic),
    /// Orthotropic linear elastic, such as a fibre-reinforced ply.
    Orthotropic(Orthotropic),
    /// Hyperelastic, neo-Hooke; for `cm` and `solid-shell`.
    NeoHookean(NeoHookean),
    /// Hyperelastic, Mooney–Rivlin; for `cm` and `solid-shell`.
    MooneyRivlin(MooneyRivlin),
    /// Plastic with von Mises' yield condition; small strains, any rotation.
    Plastic(Plastic),
}

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
    #[serde(default, skip_serializing_if = "super::is_zero")]
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

/// Orthotropic linear elastic material; axis 1 lies along the fibres, axis 3 along the thickness.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Orthotropic {
    /// Young's moduli E1, E2, E3 [force/area], above 0.
    #[schemars(transform = super::positive_entries)]
    pub young: [f64; 3],
    /// Poisson's ratios ν12, ν13, ν23: contraction along the second axis under stress along the first.
    pub poisson: [f64; 3],
    /// Shear moduli G12, G13, G23 [force/area], above 0.
    #[schemars(transform = super::positive_entries)]
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
    #[serde(default, skip_serializing_if = "super::is_zero")]
    pub expansion: f64,
}

impl Material {
    /// Word of the model file.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Isotropic(_) => "isotropic",
            Self::Orthotropic(_) => "orthotropic",
            Self::NeoHookean(_) => "neo-hookean",
            Self::MooneyRivlin(_) => "mooney-rivlin",
            Self::Plastic(_) => "plastic",
        }
    }

    /// Density [mass/volume].
    pub fn density(&self) -> f64 {
        match self {
            Self::Isotropic(m) => m.density,
            Self::Orthotropic(m) => m.density,
            Self::NeoHookean(m) => m.density,
            Self::MooneyRivlin(m) => m.density,
            Self::Plastic(m) => m.density,
        }
    }

    /// True if stress is proportional to strain.
    pub fn is_linear(&self) -> bool {
        matches!(self, Self::Isotropic(_) | Self::Orthotropic(_))
    }

    /// True if no direction differs from another.
    pub fn is_isotropic(&self) -> bool {
        !matches!(self, Self::Orthotropic(_))
    }

    /// Thermal expansion along the axes [1/temperature].
    pub fn expansion(&self) -> [f64; 3] {
        match self {
            Self::Isotropic(m) => [m.expansion; 3],
            Self::Orthotropic(m) => m.expansion,
            Self::Plastic(m) => [m.expansion; 3],
            Self::NeoHookean(_) | Self::MooneyRivlin(_) => [0.0; 3],
        }
    }

    /// Strengths, where given.
    pub fn strength(&self) -> Option<Strengths> {
        match self {
            Self::Isotropic(m) => m.strength,
            Self::Orthotropic(m) => m.strength,
            Self::NeoHookean(_) | Self::MooneyRivlin(_) | Self::Plastic(_) => None,
        }
    }
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

/// Strengths of a ply in its own axes; all of them positive numbers.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Strengths {
    /// Tensile strength along the fibre X_t [force/area], above 0.
    pub xt: f64,
    /// Compressive strength along the fibre X_c [force/area], above 0.
    pub xc: f64,
    /// Tensile strength across the fibre Y_t [force/area], above 0.
    pub yt: f64,
    /// Compressive strength across the fibre Y_c [force/area], above 0.
    pub yc: f64,
    /// Shear strength in the plane S_12 [force/area], above 0.
    pub s12: f64,
    /// Interaction F12* = F12/√(F11 F22) of the Tsai–Wu criterion, above −1 and below 1 (−1/2 unless given).
    #[serde(default = "interaction")]
    pub tsai_wu_interaction: f64,
}

fn interaction() -> f64 {
    -0.5
}

impl Strengths {
    /// Strengths with the usual interaction F12* = −1/2.
    pub fn new(xt: f64, xc: f64, yt: f64, yc: f64, s12: f64) -> Self {
        Self { xt, xc, yt, yc, s12, tsai_wu_interaction: interaction() }
    }

    /// Invalid values: pairs of the key and the condition that it must meet.
    pub fn mistakes(&self) -> Vec<(&'static str, &'static str)> {
        let sizes = [("xt", self.xt), ("xc", self.xc), ("yt", self.yt), ("yc", self.yc), ("s12", self.s12)];
        let mut out: Vec<_> = sizes
            .iter()
            .filter(|(_, v)| !(v.is_finite() && *v > 0.0))
            .map(|(key, _)| (*key, "a strength is a number above 0, also in compression"))
            .collect();
        let interaction = self.tsai_wu_interaction;
        if interaction.is_nan() || interaction.abs() >= 1.0 {
            out.push((
                "tsai_wu_interaction",
                "it must be above -1 and below 1, or the material would be of infinite strength in some \
                 direction",
            ));
        }
        out
    }
}
