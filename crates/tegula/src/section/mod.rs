//! Shell sections: stiffness of the stress resultants and inertia per area, integrated through the thickness.

pub mod beam;
pub mod compiled;
pub mod failure;
pub mod laminate;
pub mod ply;
pub mod quadrature;
mod shear_correction;
#[cfg(test)]
mod tests;

use nalgebra::{Matrix2, Matrix3};

use crate::model::Isotropic;
pub use compiled::CompiledSection;

/// Section stiffness per reference area: stress resultants from strains and curvatures,
///
/// ```text
/// n = A ε + B κ      membrane [force/length]
/// m = Bᵀ ε + D κ     bending  (force)
/// q = S γ            transverse shear [force/length]
/// n_zz = Z ε_zz      thickness [force/length]
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct SectionStiffness {
    /// A: membrane.
    pub membrane: Matrix3<f64>,
    /// B: coupling of membrane and bending; zero for sections symmetric about the mid-surface.
    pub coupling: Matrix3<f64>,
    /// D: bending.
    pub bending: Matrix3<f64>,
    /// S: transverse shear, correction factors included.
    pub shear: Matrix2<f64>,
    /// Z: stretch of the director.
    pub thickness: f64,
}

/// Inertia of a section per reference area.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SectionInertia {
    /// ∫ρ dz [mass/area].
    pub mass: f64,
    /// ∫ρ z dz [mass/length]; zero for sections symmetric about the mid-surface.
    pub coupling: f64,
    /// ∫ρ z² dz (mass); the director is dimensionless.
    pub rotary: f64,
}

impl SectionStiffness {
    /// Zero stiffness.
    pub fn zero() -> Self {
        Self {
            membrane: Matrix3::zeros(),
            coupling: Matrix3::zeros(),
            bending: Matrix3::zeros(),
            shear: Matrix2::zeros(),
            thickness: 0.0,
        }
    }

    /// Stiffness of a homogeneous isotropic section in plane stress (eqs. 24, 26): `A = h D_p`, `D = h³/12 D_p`,
    /// `S = h G diag(c_xz, c_yz)`, `Z = h E`.
    pub fn homogeneous(material: &Isotropic, thickness: f64, shear_correction: [f64; 2]) -> Self {
        let (e, nu, h) = (material.young, material.poisson, thickness);
        let plane_stress =
            Matrix3::new(1.0, nu, 0.0, nu, 1.0, 0.0, 0.0, 0.0, 0.5 * (1.0 - nu)) * (e / (1.0 - nu * nu));
        let g = 0.5 * e / (1.0 + nu);
        Self {
            membrane: plane_stress * h,
            coupling: Matrix3::zeros(),
            bending: plane_stress * (h * h * h / 12.0),
            shear: Matrix2::new(shear_correction[0], 0.0, 0.0, shear_correction[1]) * (g * h),
            thickness: e * h,
        }
    }
}

impl SectionInertia {
    /// Inertia times a factor.
    pub fn scaled(&self, factor: f64) -> Self {
        Self { mass: factor * self.mass, rotary: factor * self.rotary, coupling: factor * self.coupling }
    }

    /// Inertia of a homogeneous section: ρh and ρh³/12.
    pub fn homogeneous(density: f64, thickness: f64) -> Self {
        Self { mass: density * thickness, rotary: density * thickness.powi(3) / 12.0, coupling: 0.0 }
    }
}
