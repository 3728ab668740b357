//! Laminates against closed forms, published numbers and independent computations.

mod plates;
mod recovery;
mod shear;
mod stiffness;

use nalgebra::Matrix2;

use super::laminate::Laminate;
use super::ply::{Ply, orthotropic_plane_stress};

/// Engineering constants of a transversely isotropic ply: E3 = E2.
#[derive(Clone, Copy)]
struct Constants {
    e1: f64,
    e2: f64,
    nu12: f64,
    g12: f64,
    g13: f64,
    g23: f64,
}

/// Material of the literature on cross-ply plates, moduli over E2.
const E25: Constants = Constants { e1: 25.0, e2: 1.0, nu12: 0.25, g12: 0.5, g13: 0.5, g23: 0.2 };

impl Constants {
    fn isotropic(young: f64, poisson: f64) -> Self {
        let g = 0.5 * young / (1.0 + poisson);
        Self { e1: young, e2: young, nu12: poisson, g12: g, g13: g, g23: g }
    }

    fn ply(&self, degrees: f64, thickness: f64) -> Ply {
        Ply {
            thickness,
            angle: degrees.to_radians(),
            plane_stress: orthotropic_plane_stress(self.e1, self.e2, self.nu12, self.g12),
            shear: Matrix2::new(self.g13, 0.0, 0.0, self.g23),
            thickness_modulus: self.e2,
            density: 1.0,
        }
    }

    /// Laminate of plies of equal thickness at these angles in degrees, of the total thickness `h`.
    fn laminate(&self, angles: &[f64], h: f64) -> Laminate {
        let t = h / angles.len() as f64;
        Laminate::new(angles.iter().map(|&a| self.ply(a, t)).collect()).unwrap()
    }
}

/// Layup of two materials without any symmetry.
fn arbitrary() -> Laminate {
    let other = Constants { e1: 9.0, e2: 2.0, nu12: 0.3, g12: 0.8, g13: 0.7, g23: 0.6 };
    Laminate::new(vec![E25.ply(30.0, 0.2), other.ply(-55.0, 0.35), E25.ply(80.0, 0.1), other.ply(10.0, 0.3)])
        .unwrap()
}

#[track_caller]
fn near(found: f64, expected: f64, tolerance: f64, what: &str) {
    assert!((found - expected).abs() <= tolerance, "{what}: {found} for {expected}");
}
