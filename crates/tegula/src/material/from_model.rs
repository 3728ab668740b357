//! Laws of the materials of the model.

use nalgebra::{Matrix2, Matrix3};

use super::linear::{Orthotropy, isotropic, isotropic_plane_stress};
use super::{Hyperelastic, Law, Plasticity};
use crate::model::{Material, NeoHookeanForm, Orthotropic, Plastic};

impl Orthotropic {
    /// Elastic constants.
    pub(crate) fn constants(&self) -> Orthotropy {
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
}
