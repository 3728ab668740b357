//! Frames and tensor transformations of the reference configuration.

use nalgebra::{Matrix2, Matrix3, SMatrix};

use crate::{Mat3, Vec3};

/// Natural coordinates of the four nodes.
pub const NODES: [[f64; 2]; 4] = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];

/// 1/√3, the Gauss point of order 2.
pub const GAUSS: f64 = 0.577_350_269_189_625_8;

/// The 2×2 Gauss points (ξ, η), weights 1; ξ runs fastest.
pub const GAUSS_POINTS: [[f64; 2]; 4] = [[-GAUSS, -GAUSS], [GAUSS, -GAUSS], [-GAUSS, GAUSS], [GAUSS, GAUSS]];

/// Bilinear shape functions N_a.
pub fn shape(xi: f64, eta: f64) -> [f64; 4] {
    NODES.map(|[x, y]| 0.25 * (1.0 + x * xi) * (1.0 + y * eta))
}

/// ∂N_a/∂ξ, which does not depend on ξ.
pub fn shape_xi(eta: f64) -> [f64; 4] {
    NODES.map(|[x, y]| 0.25 * x * (1.0 + y * eta))
}

/// ∂N_a/∂η, which does not depend on η.
pub fn shape_eta(xi: f64) -> [f64; 4] {
    NODES.map(|[x, y]| 0.25 * y * (1.0 + x * xi))
}

fn combine(weights: [f64; 4], vectors: &[Vec3]) -> Vec3 {
    weights.iter().zip(vectors).map(|(w, v)| *v * *w).sum()
}

/// Covariant base vectors G1, G2, G3 at a point of the mid-surface (eq. 10).
pub fn covariant_base(positions: &[Vec3; 4], directors: &[Vec3; 4], xi: f64, eta: f64) -> Mat3 {
    Mat3::from_columns(&[
        combine(shape_xi(eta), positions),
        combine(shape_eta(xi), positions),
        combine(shape(xi, eta), directors),
    ])
}

/// |G1 × G2|: reference area per dξ dη.
pub fn area_measure(base: &Mat3) -> f64 {
    base.column(0).cross(&base.column(1)).norm()
}

/// Cross-section frame A = [i j k] (eqs. 17–19): k along G3, j from G2, i = j × k.
///
/// `None` where G3 vanishes or G2 is parallel to it: the element is invalid.
pub fn cross_section_frame(base: &Mat3) -> Option<Mat3> {
    let (g2, g3): (Vec3, Vec3) = (base.column(1).into(), base.column(2).into());
    let k = g3.try_normalize(0.0).filter(|k| k.iter().all(|c| c.is_finite()))?;
    let along = g2 - k * g2.dot(&k);
    if along.norm() <= 1e-8 * g2.norm() {
        return None;
    }
    let j = along.normalize();
    Some(Mat3::from_columns(&[j.cross(&k), j, k]))
}

/// T⁻ᵀ (eq. 15) of a base B = AᵀJ: physical from covariant strains in the order
/// xx, yy, xy, zz, xz, yz with engineering shear strains, from the tensor rule
/// `E = B⁻ᵀ Ẽ B⁻¹` (eq. 13).
pub fn strain_transformation(b_inverse: &Matrix3<f64>) -> SMatrix<f64, 6, 6> {
    const PAIRS: [(usize, usize); 6] = [(0, 0), (1, 1), (0, 1), (2, 2), (0, 2), (1, 2)];
    SMatrix::from_fn(|row, column| entry(|k, i| b_inverse[(k, i)], PAIRS[row], PAIRS[column]))
}

/// The in-plane 3×3 block of [`strain_transformation`] for a 2×2 base C (eqs. 20, 30):
/// order xx, yy, xy (engineering).
pub fn in_plane_transformation(c_inverse: &Matrix2<f64>) -> SMatrix<f64, 3, 3> {
    const PAIRS: [(usize, usize); 3] = [(0, 0), (1, 1), (0, 1)];
    SMatrix::from_fn(|row, column| entry(|k, i| c_inverse[(k, i)], PAIRS[row], PAIRS[column]))
}

/// Share of the covariant component `(k, l)` in the physical component `(i, j)`.
fn entry(inverse: impl Fn(usize, usize) -> f64, (i, j): (usize, usize), (k, l): (usize, usize)) -> f64 {
    let tensor = if k == l {
        inverse(k, i) * inverse(k, j)
    } else {
        0.5 * (inverse(k, i) * inverse(l, j) + inverse(l, i) * inverse(k, j))
    };
    if i == j { tensor } else { 2.0 * tensor }
}
