//! Materials as the user says them.

use nalgebra::{Matrix2, Matrix3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::Issue;
use crate::material::linear::{Orthotropy, isotropic, isotropic_plane_stress};
use crate::material::{Hyperelastic, Law, NeoHookeanForm, Plasticity};
use crate::section::failure::Strengths;

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

impl Orthotropic {
    fn constants(&self) -> Orthotropy {
        Orthotropy { young: self.young, poisson: self.poisson, shear: self.shear }
    }
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

    /// The law of three-dimensional stresses.
    pub fn law_3d(&self) -> Law {
        match self {
            Self::Isotropic(m) => Law::Linear(Box::new(isotropic(m.young, m.poisson))),
            Self::Orthotropic(m) => Law::Linear(Box::new(m.constants().stiffness())),
            Self::NeoHookean(m) => Law::Hyperelastic(match m.form {
                NeoHookeanForm::Split => Hyperelastic::Split { c10: 0.5 * m.shear, c01: 0.0, bulk: m.bulk },
                NeoHookeanForm::Coupled => {
                    Hyperelastic::Coupled { mu: m.shear, lambda: m.bulk - 2.0 / 3.0 * m.shear }
                }
            }),
            Self::MooneyRivlin(m) => {
                Law::Hyperelastic(Hyperelastic::Split { c10: m.c10, c01: m.c01, bulk: m.bulk })
            }
            Self::Plastic(m) => Law::Plastic(m.law()),
        }
    }

    /// The law of plane stress for layers that are not linear; `None` where there is none.
    pub fn law_plane_stress(&self) -> Option<Law> {
        match self {
            Self::Plastic(m) => Some(Law::PlaneStressPlastic(m.law())),
            _ => None,
        }
    }

    /// Elastic plane stress in the material's axes: reduced stiffness, transverse shear diag(G13, G23), and the modulus
    /// E3 of the thickness; `None` for hyperelastic materials.
    pub fn plane_stress(&self) -> Option<(Matrix3<f64>, Matrix2<f64>, f64)> {
        let of = |e: f64, nu: f64| {
            let g = 0.5 * e / (1.0 + nu);
            (isotropic_plane_stress(e, nu), Matrix2::identity() * g, e)
        };
        match self {
            Self::Isotropic(m) => Some(of(m.young, m.poisson)),
            Self::Plastic(m) => Some(of(m.young, m.poisson)),
            Self::Orthotropic(m) => {
                let c = m.constants();
                Some((c.plane_stress(), c.transverse_shear(), m.young[2]))
            }
            Self::NeoHookean(_) | Self::MooneyRivlin(_) => None,
        }
    }

    /// Mistakes in its values.
    pub fn issues(&self, key: &str) -> Vec<Issue> {
        let mut c = super::checker::Checker::default();
        let poisson = |c: &mut super::checker::Checker, nu: f64| {
            if !(nu > -1.0 && nu < 0.5) {
                c.add(
                    format!("{key}.poisson"),
                    format!("Poisson's ratio is {nu}; it must be above -1 and below 0.5"),
                    "at 0.5 a material is incompressible and plane stress has no limit here; use 0.49 or less",
                );
            }
        };
        match self {
            Self::Isotropic(m) => {
                c.positive(&format!("{key}.young"), "Young's modulus", m.young);
                poisson(&mut c, m.poisson);
            }
            Self::Orthotropic(m) => {
                for (name, values) in [("young", m.young), ("shear", m.shear)] {
                    for (i, v) in values.into_iter().enumerate() {
                        c.positive(&format!("{key}.{name}[{i}]"), "the modulus", v);
                    }
                }
                c.finite(&format!("{key}.poisson"), "Poisson's ratio", &m.poisson);
                if c.issues.is_empty() && !m.constants().is_stable() {
                    c.add(
                        format!("{key}.poisson"),
                        "some strain would store no energy: the constants contradict each other",
                        "|ν_ij| must be below √(E_i/E_j); ν_ij belongs to stress along axis i",
                    );
                }
            }
            Self::NeoHookean(m) => {
                c.positive(&format!("{key}.shear"), "the shear modulus", m.shear);
                c.positive(&format!("{key}.bulk"), "the bulk modulus", m.bulk);
            }
            Self::MooneyRivlin(m) => {
                c.finite(&format!("{key}.c01"), "the constant", &[m.c01]);
                c.positive(&format!("{key}.c10"), "c10 + c01", m.c10 + m.c01);
                c.positive(&format!("{key}.bulk"), "the bulk modulus", m.bulk);
            }
            Self::Plastic(m) => {
                c.positive(&format!("{key}.young"), "Young's modulus", m.young);
                poisson(&mut c, m.poisson);
                c.positive(&format!("{key}.yield_stress"), "the yield stress", m.yield_stress);
                for (name, v) in [
                    ("hardening", m.hardening),
                    ("saturation_rate", m.saturation_rate),
                    ("kinematic", m.kinematic),
                ] {
                    c.not_negative(&format!("{key}.{name}"), &format!("`{name}`"), v);
                }
                if m.saturation.is_some_and(|s| s.is_nan() || s < m.yield_stress) {
                    c.add(
                        format!("{key}.saturation"),
                        "the saturation stress is below the yield stress: softening has no unique solution",
                        "give a stress of at least `yield_stress`",
                    );
                }
            }
        }
        c.not_negative(&format!("{key}.density"), "the density", self.density());
        c.finite(&format!("{key}.expansion"), "the thermal expansion", &self.expansion());
        if let Some(s) = self.strength() {
            for (name, mistake) in s.mistakes() {
                c.add(
                    format!("{key}.strength.{name}"),
                    mistake,
                    "give the strength in the units of a stress",
                );
            }
        }
        c.issues
    }
}
