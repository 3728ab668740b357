//! Ply of a laminate, and transformation of its stiffness to rotated axes.
//!
//! Components are those of the plane, (xx, yy, xy) with the engineering shear `γ_xy = 2ε_xy`, and the
//! transverse shears (xz, yz). Ply axes are 1 (fibre), 2 (across the fibre) and 3 (director); angles are
//! counted about the director, from x towards y.

use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};

use super::laminate::LaminateError;

/// Ply: a homogeneous orthotropic sheet.
#[derive(Debug, Clone, PartialEq)]
pub struct Ply {
    /// Thickness t (length).
    pub thickness: f64,
    /// Angle θ from the laminate's 0° direction to axis 1 of the ply, about the director (rad).
    pub angle: f64,
    /// Q: reduced stiffness of plane stress in ply axes (11, 22, 12) [force/area].
    pub plane_stress: Matrix3<f64>,
    /// diag(G13, G23): transverse shear moduli in ply axes [force/area].
    pub shear: Matrix2<f64>,
    /// Modulus E3 of the thickness stretch [force/area].
    pub thickness_modulus: f64,
    /// Density ρ [mass/volume].
    pub density: f64,
}

impl Ply {
    /// Q̄: transformed reduced stiffness in axes from which the ply is rotated by `angle` + `turn`.
    pub(super) fn plane_stress_at(&self, turn: f64) -> Matrix3<f64> {
        turned_plane_stress(&self.plane_stress, self.angle + turn)
    }

    /// Validates the ply: an error for sizes that are not positive and for a stiffness that is not symmetric and
    /// positive definite.
    pub(super) fn check(&self, ply: usize) -> Result<(), LaminateError> {
        let wrong = |what: &'static str| Err(LaminateError::Ply { ply, what });
        if !(self.thickness.is_finite() && self.thickness > 0.0) {
            return wrong("its thickness must be a number above 0");
        }
        if !self.angle.is_finite() {
            return wrong("its angle must be a number");
        }
        let rounding = 1e-12;
        let q = &self.plane_stress;
        if !q.iter().all(|v| v.is_finite())
            || (q - q.transpose()).norm() > rounding * q.norm()
            || q.cholesky().is_none()
        {
            return wrong(
                "its plane-stress stiffness is not symmetric and positive definite; \
                 check that nu12² is below E1/E2",
            );
        }
        let g = &self.shear;
        if !g.iter().all(|v| v.is_finite())
            || (g - g.transpose()).norm() > rounding * g.norm()
            || g.cholesky().is_none()
        {
            return wrong("its transverse shear moduli G13 and G23 must be above 0");
        }
        if !(self.thickness_modulus.is_finite() && self.thickness_modulus > 0.0) {
            return wrong("its modulus through the thickness must be above 0");
        }
        if !(self.density.is_finite() && self.density >= 0.0) {
            return wrong("its density must not be below 0");
        }
        Ok(())
    }
}

/// Reduced stiffness of plane stress of an orthotropic material in its own axes [force/area]:
///
/// ```text
/// Q11 = E1/(1 − ν12 ν21)   Q22 = E2/(1 − ν12 ν21)   Q12 = ν12 Q22   Q66 = G12,   ν21 = ν12 E2/E1
/// ```
///
/// Source: Jones, Mechanics of Composite Materials, 2nd ed. 1999, section 2.4. It is positive definite
/// for E1, E2, G12 > 0 and ν12² < E1/E2.
pub fn orthotropic_plane_stress(young_1: f64, young_2: f64, poisson_12: f64, shear_12: f64) -> Matrix3<f64> {
    let poisson_21 = poisson_12 * young_2 / young_1;
    let d = 1.0 - poisson_12 * poisson_21;
    let coupling = poisson_12 * young_2 / d;
    Matrix3::new(young_1 / d, coupling, 0.0, coupling, young_2 / d, 0.0, 0.0, 0.0, shear_12)
}

/// T(θ): transformation of the in-plane strains (xx, yy, xy) to axes rotated by θ from x towards y.
///
/// ```text
///     ⎡  c²    s²    cs   ⎤
/// T = ⎢  s²    c²   −cs   ⎥     c = cos θ, s = sin θ; ε' = T ε, σ = Tᵀ σ'
///     ⎣ −2cs   2cs  c²−s² ⎦
/// ```
pub fn strain_turn(angle: f64) -> Matrix3<f64> {
    let (s, c) = angle.sin_cos();
    Matrix3::new(c * c, s * s, c * s, s * s, c * c, -c * s, -2.0 * c * s, 2.0 * c * s, c * c - s * s)
}

/// R(θ): transformation of the transverse shears (xz, yz) to axes rotated by θ: `γ' = R γ`, `τ = Rᵀ τ'`.
pub fn shear_turn(angle: f64) -> Matrix2<f64> {
    let (s, c) = angle.sin_cos();
    Matrix2::new(c, s, -s, c)
}

/// Q̄ = Tᵀ Q T: stiffness `q`, given in axes rotated by `angle`, transformed to the axes they are rotated from. It
/// holds for A, B and D too.
pub fn turned_plane_stress(q: &Matrix3<f64>, angle: f64) -> Matrix3<f64> {
    let t = strain_turn(angle);
    let turned = t.transpose() * q * t;
    // Round-off leaves the last digit unsymmetric.
    (turned + turned.transpose()) * 0.5
}

/// Rᵀ S R: transverse shear stiffness `s`, given in axes rotated by `angle`, transformed to the axes they are rotated
/// from.
pub fn turned_shear(s: &Matrix2<f64>, angle: f64) -> Matrix2<f64> {
    let r = shear_turn(angle);
    let turned = r.transpose() * s * r;
    (turned + turned.transpose()) * 0.5
}

/// Angle from x of a frame to the projection of `direction` on its plane, about the director (rad).
///
/// `x` and `y` are the unit vectors of the plane. `None` if the direction is normal to the plane up to 1e-6 of its
/// length and defines no angle.
pub fn angle_in_plane(direction: &Vector3<f64>, x: &Vector3<f64>, y: &Vector3<f64>) -> Option<f64> {
    let inplane = Vector2::new(direction.dot(x), direction.dot(y));
    (inplane.norm() > 1e-6 * direction.norm()).then(|| inplane.y.atan2(inplane.x))
}
