//! Frames and tensor transformations of the reference configuration. Equation numbers are those of the paper cited in
//! [`super::ems`].

use nalgebra::{Matrix2, Matrix3, SMatrix};

use crate::section::SectionInertia;
use crate::{Mat3, Vec3};

/// Reference geometry of an element: nodal positions and directors.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ShellGeometry {
    /// Nodal positions.
    pub positions: [Vec3; 4],
    /// Nodal directors.
    pub directors: [Vec3; 4],
    /// Unit tangents of the surface at the nodes, for elements whose nodes have them.
    pub tangents: [[Vec3; 2]; 4],
}

impl ShellGeometry {
    /// Ratio of element length to thickness below which an element is short: its transverse shear has a part linear in
    /// z. In longer elements this part would change bending by a tenth of a per cent against first-order shear
    /// deformation theory, in composite plates of L/h = 10.
    pub const SHORT: f64 = 0.25;

    /// Length over the thickness below which elements of rubber have that part. Without it they lose stability in simple
    /// compression at a stretch of 0.56 where they are six times as long as thick, which shorter ones reach with it.
    pub const SHORT_RUBBER: f64 = 6.0;

    /// Fraction of the stiffness of the transverse shear linear in z that short elements use. One third keeps
    /// cantilevers of L = 5 h stable up to fibre strains of 0.39; one tenth loses stability at 0.3. In-plane bending of
    /// beams as thick as they are deep makes the thickness vary, too, and there the full stiffness would be too stiff
    /// by 0.75 % (0.24 % for a third) on elements of h/8.
    pub const SHORT_SHARE: f64 = 1.0 / 3.0;

    /// Geometry from positions and directors; the tangents follow from the directors.
    pub fn new(positions: [Vec3; 4], directors: [Vec3; 4]) -> Self {
        Self { positions, directors, tangents: directors.map(|d| tangents(&d)) }
    }

    /// Mean of the nodal positions.
    pub fn centre(&self) -> Vec3 {
        self.positions.iter().sum::<Vec3>() / 4.0
    }

    /// True if one of the two lines between the midpoints of opposite edges is shorter than `length`.
    pub fn is_shorter_than(&self, length: f64) -> bool {
        let [a, b, c, d] = self.positions;
        0.5 * (b + c - a - d).norm() < length || 0.5 * (c + d - a - b).norm() < length
    }

    /// Covariant base vectors at the height z, as columns: ∂(r + z d)/∂(ξ, η, z).
    pub fn base(&self, xi: f64, eta: f64, z: f64) -> Mat3 {
        let mut base = covariant_base(&self.positions, &self.directors, xi, eta);
        if z != 0.0 {
            let d_xi = combine(shape_xi(eta), &self.directors) * z;
            let d_eta = combine(shape_eta(xi), &self.directors) * z;
            base.set_column(0, &(base.column(0) + d_xi));
            base.set_column(1, &(base.column(1) + d_eta));
        }
        base
    }
}

/// Two unit tangents of a surface with the director `d`: the projection of the coordinate axis most nearly
/// perpendicular to `d` (x before y before z), and `d × t₁`.
pub fn tangents(d: &Vec3) -> [Vec3; 2] {
    let mut axis = Vec3::x();
    for e in [Vec3::y(), Vec3::z()] {
        // The margin keeps round-off from deciding between equals.
        if d.dot(&e).abs() < d.dot(&axis).abs() - 1e-6 * d.norm() {
            axis = e;
        }
    }
    let t = (axis - d * (d.dot(&axis) / d.norm_squared())).normalize();
    [t, d.cross(&t).normalize()]
}

/// Natural coordinates of the four nodes.
pub const NODES: [[f64; 2]; 4] = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];

/// 1/√3, abscissa of the two-point Gauss rule.
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

/// Coefficients, node by node, of the derivatives ∂/∂ξ and ∂/∂η of a nodal quantity at a point: differences along the
/// edges, interpolated across the element like the assumed natural transverse shear.
pub fn stretch_gradient(xi: f64, eta: f64) -> [[f64; 2]; 4] {
    NODES.map(|[x, y]| [0.25 * x * (1.0 + y * eta), 0.25 * y * (1.0 + x * xi)])
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

/// Coefficient of the covariant component `(k, l)` in the physical component `(i, j)`.
fn entry(inverse: impl Fn(usize, usize) -> f64, (i, j): (usize, usize), (k, l): (usize, usize)) -> f64 {
    let tensor = if k == l {
        inverse(k, i) * inverse(k, j)
    } else {
        0.5 * (inverse(k, i) * inverse(l, j) + inverse(l, i) * inverse(k, j))
    };
    if i == j { tensor } else { 2.0 * tensor }
}

/// Consistent mass ∫N_aN_b dA₀ times the inertia of the section: one scalar per pair of the positions 1–4 and directors
/// 1–4, lower triangle by rows.
pub fn shell_mass(g: &ShellGeometry, inertia: &SectionInertia) -> Vec<f64> {
    let mut nn = [[0.0; 4]; 4];
    for [xi, eta] in GAUSS_POINTS {
        let area = area_measure(&g.base(xi, eta, 0.0));
        let n = shape(xi, eta);
        for a in 0..4 {
            for b in 0..4 {
                nn[a][b] += n[a] * n[b] * area;
            }
        }
    }
    let mut out = Vec::with_capacity(36);
    for a in 0..8 {
        for b in 0..=a {
            let m = match (a < 4, b < 4) {
                (true, true) => inertia.mass,
                (false, false) => inertia.rotary,
                _ => inertia.coupling,
            };
            out.push(m * nn[a % 4][b % 4]);
        }
    }
    out
}

/// Integral ∫N_a dA₀ of each node's shape function.
pub fn nodal_areas(positions: &[Vec3; 4]) -> [f64; 4] {
    let mut out = [0.0; 4];
    let directors = [Vec3::z(); 4];
    for [xi, eta] in GAUSS_POINTS {
        let area = area_measure(&covariant_base(positions, &directors, xi, eta));
        for (out, n) in out.iter_mut().zip(shape(xi, eta)) {
            *out += n * area;
        }
    }
    out
}
