//! Transverse shear stiffness of a layup from the equilibrium of cylindrical bending.
//!
//! First-order theory gives every ply the same transverse shear strain. In fact the shear stress follows from
//! equilibrium of the stresses in the plane, `τ_a,z = −σ_ab,b`. Take bending that varies along x of the laminate only,
//! without membrane forces and twisting moments. Nothing changes along y, so the strains that vary are ε_xx, γ_xy,
//! κ_xx, κ_xy, and their gradients follow from
//!
//! ```text
//! n_xx,x = 0    n_xy,x = 0    M_xx,x = q_x    M_xy,x = 0          M = ∫σ z dz
//! τ_xz(z) = −∫ σ_xx,x dz     τ_yz(z) = −∫ σ_xy,x dz               from the bottom to z
//! ```
//!
//! and likewise along y. Together `τ(z) = F(z) q`. F is zero at both faces, continuous, and of integral 1;
//! it does not depend on the reference surface. The energy of these stresses is that of the section:
//!
//! ```text
//! ½ qᵀ S⁻¹ q = ½ ∫ τᵀ G⁻¹ τ dz     S⁻¹ = ∫ Fᵀ G⁻¹ F dz
//! ```
//!
//! A homogeneous section has `S = 5/6 h G` whatever its anisotropy. Cross-plies and sandwiches have the
//! factors of Whitney (J. Appl. Mech. 40 (1973) 302–304) and of Vlachoutsis (Int. J. Numer. Methods Eng. 33
//! (1992) 1537–1552). Rohwer (DFVLR-FB 88-32, 1988) differs: there M_yy,x = 0 instead of κ_yy,x = 0, which
//! changes a fraction of a percent for carbon cross-plies, and more in the small S_12 of other layups.
//!
//! S belongs to the laminate and rotates with it as a tensor. The directions of cylindrical bending are the 0° and 90°
//! directions of the laminate, as in the sources: if neither is a principal direction of bending, S depends somewhat on
//! the choice.

use nalgebra::{Matrix2, Matrix4, Vector3, Vector4};

use super::ply::{Ply, turned_shear};

/// Transverse shear stress profile F(z) through the thickness per shear force, in laminate axes.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ShearProfile {
    /// Gradients of (ε, −κ) along x per q_x, and along y per q_y.
    gradients: [[Vector3<f64>; 2]; 2],
    /// F at the bottom of every ply [1/length].
    bottoms: Vec<Matrix2<f64>>,
}

impl ShearProfile {
    /// Shear stress profile and S [force/length]; `heights` are those of the ply interfaces and faces above the
    /// laminate mid-plane. `None` if round-off spoils the elimination (stiffnesses too far apart).
    pub(super) fn new(plies: &[Ply], heights: &[f64]) -> Option<(Self, Matrix2<f64>)> {
        let gradients = [gradients(plies, heights, 0)?, gradients(plies, heights, 1)?];
        let mut profile = Self { gradients, bottoms: Vec::with_capacity(plies.len()) };
        let mut bottom = Matrix2::zeros();
        let mut flexibility = Matrix2::zeros();
        // F is quadratic in a ply; three Gauss points are exact for its square.
        let gauss = [(-0.6_f64.sqrt(), 5.0 / 18.0), (0.0, 8.0 / 18.0), (0.6_f64.sqrt(), 5.0 / 18.0)];
        for (k, p) in plies.iter().enumerate() {
            profile.bottoms.push(bottom);
            let g = turned_shear(&p.shear, p.angle).try_inverse()?;
            let (middle, half) = (0.5 * (heights[k] + heights[k + 1]), 0.5 * (heights[k + 1] - heights[k]));
            for (x, weight) in gauss {
                let f = profile.at(p, k, heights, middle + half * x);
                flexibility += f.transpose() * g * f * (weight * p.thickness);
            }
            bottom = profile.at(p, k, heights, heights[k + 1]);
        }
        let flexibility = (flexibility + flexibility.transpose()) * 0.5;
        let shear = flexibility.try_inverse()?;
        (shear.cholesky().is_some() && shear.iter().all(|v| v.is_finite())).then_some((profile, shear))
    }

    /// F(z) [1/length] in ply `k`, at the height z above the laminate mid-plane: columns q_x, q_y; rows τ_xz, τ_yz.
    pub(super) fn at(&self, ply: &Ply, k: usize, heights: &[f64], z: f64) -> Matrix2<f64> {
        let q = ply.plane_stress_at(0.0);
        let below = heights[k];
        let first = z - below;
        let second = 0.5 * first * (z + below);
        let [x, y] = self.gradients.map(|[strain, curvature]| q * (strain * first + curvature * second));
        self.bottoms[k] - Matrix2::new(x[0], y[2], x[2], y[1])
    }
}

/// Gradients of (ε, −κ) along `axis` in cylindrical bending under a unit shear force.
fn gradients(plies: &[Ply], heights: &[f64], axis: usize) -> Option<[Vector3<f64>; 2]> {
    let h = heights[plies.len()] - heights[0];
    let varying = [axis, 2];
    let mut stiffness = Matrix4::zeros();
    for (k, p) in plies.iter().enumerate() {
        let q = p.plane_stress_at(0.0);
        // Heights are divided by h, so that all entries have the same magnitude.
        let (t, z) = (p.thickness, 0.5 * (heights[k] + heights[k + 1]) / h);
        let moments = [1.0, z, z * z + (t / h) * (t / h) / 12.0];
        for a in 0..4 {
            for b in 0..4 {
                stiffness[(a, b)] += q[(varying[a % 2], varying[b % 2])] * t * moments[a / 2 + b / 2];
            }
        }
    }
    let solution = stiffness.cholesky()?.solve(&Vector4::new(0.0, 0.0, 1.0 / h, 0.0));
    let mut out = [Vector3::zeros(); 2];
    for a in 0..4 {
        out[a / 2][varying[a % 2]] = solution[a] / if a < 2 { 1.0 } else { h };
    }
    Some(out)
}
