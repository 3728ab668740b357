//! Laminates: stiffness and inertia of a stack of layers.
//!
//! Fibres at the height z along the director strain by ε − z κ, so with the reduced stiffness Q̄ of each layer
//!
//! ```text
//! A = ∫Q̄ dz,   B = −∫Q̄ z dz,   D = ∫Q̄ z² dz      n = A ε + B κ,   m = Bᵀ ε + D κ
//! ```
//!
//! R. M. Jones, *Mechanics of Composite Materials*, 2nd ed., Taylor & Francis 1999, Ch. 4 (with his κ = −ours).

use nalgebra::{Matrix2, Matrix3, Matrix6, SMatrix};

use super::compiled::{Layer, plane_turn};
use super::quadrature::gauss;
use super::{SectionInertia, SectionStiffness};

/// A stack of layers in the axes of its 0° direction.
#[derive(Debug, Clone)]
pub struct Laminate {
    layers: Vec<LayerStiffness>,
    /// Transverse shear stiffness in the axes of the 0° direction.
    shear: Matrix2<f64>,
    /// ∫E3 dz.
    thickness: f64,
}

/// Elastic stiffness of a layer in the axes of the laminate.
#[derive(Debug, Clone)]
struct LayerStiffness {
    heights: [f64; 2],
    moments: [f64; 3],
    plane: Matrix3<f64>,
    shear: Matrix2<f64>,
}

/// Rotation of in-plane vectors: components along axes at `angle` from components in the axes it is counted from.
pub fn vector_turn(angle: f64) -> Matrix2<f64> {
    let (s, c) = angle.sin_cos();
    Matrix2::new(c, s, -s, c)
}

impl Laminate {
    /// From layers; `factors` replaces the layup's own transverse shear correction by c_xz, c_yz.
    ///
    /// `None` where a layer has no plane stress or the stack no inverse.
    pub fn new(layers: &[Layer], factors: Option<[f64; 2]>) -> Option<Self> {
        let mut thickness = 0.0;
        let mut list = Vec::new();
        for layer in layers {
            let (plane, shear, modulus) = layer.material.plane_stress()?;
            let (t, r) = (plane_turn(layer.angle), vector_turn(layer.angle));
            let moments = layer.moments();
            thickness += modulus * moments[0];
            list.push(LayerStiffness {
                heights: [layer.bottom, layer.top],
                moments,
                plane: t.transpose() * plane * t,
                shear: r.transpose() * shear * r,
            });
        }
        let mut out = Self { layers: list, shear: Matrix2::zeros(), thickness };
        out.shear = match factors {
            Some(factors) => {
                let whole: Matrix2<f64> = out.layers.iter().map(|l| l.shear * l.moments[0]).sum();
                let root = Matrix2::from_diagonal(&nalgebra::Vector2::from(factors.map(f64::sqrt)));
                root * whole * root
            }
            None => out.equilibrium_shear()?,
        };
        Some(out)
    }

    /// Membrane, coupling and bending stiffness in the axes of the 0° direction.
    fn plane(&self) -> [Matrix3<f64>; 3] {
        let sum = |k: usize| self.layers.iter().map(|l| l.plane * l.moments[k]).sum::<Matrix3<f64>>();
        [sum(0), -sum(1), sum(2)]
    }

    /// Transverse shear stiffness by equilibrium in cylindrical bending about both axes.
    ///
    /// A gradient of the moment m_xx (m_yy) alone changes the in-plane stresses by Q̄ (ε′ − z κ′); equilibrium along
    /// x and y gives the transverse shear stresses τ(z) = F(z) q, and their energy the compliance
    /// `S⁻¹ = ∫ Fᵀ G⁻¹ F dz`. For one layer this is 5/6 G h. K. Rohwer, *Improved transverse shear stiffness for
    /// layered finite elements*, DFVLR-FB 88-32, 1988.
    fn equilibrium_shear(&self) -> Option<Matrix2<f64>> {
        let [a, b, d] = self.plane();
        let mut whole = Matrix6::zeros();
        whole.fixed_view_mut::<3, 3>(0, 0).copy_from(&a);
        whole.fixed_view_mut::<3, 3>(0, 3).copy_from(&b);
        whole.fixed_view_mut::<3, 3>(3, 0).copy_from(&b.transpose());
        whole.fixed_view_mut::<3, 3>(3, 3).copy_from(&d);
        let compliance = inverse(&whole)?;
        // Columns: m_xx and m_yy grow by one per length; a shear force of −1 goes with that.
        let change: SMatrix<f64, 6, 2> =
            SMatrix::from_columns(&[compliance.column(3).into_owned(), compliance.column(4).into_owned()]);
        let (strain, curvature) =
            (change.fixed_rows::<3>(0).into_owned(), change.fixed_rows::<3>(3).into_owned());
        // ∫σ′ dz from the lower side of a layer to z, rows of equilibrium along x and y.
        let partial = |l: &LayerStiffness, z: f64| {
            let [z0, _] = l.heights;
            let stress = l.plane * (strain * (z - z0) - curvature * (0.5 * (z * z - z0 * z0)));
            // Along x: σ_xx,x of the first column, σ_xy,y of the second; along y: σ_xy,x and σ_yy,y.
            Matrix2::new(stress[(0, 0)], stress[(2, 1)], stress[(2, 0)], stress[(1, 1)])
        };
        let mut below = Matrix2::zeros();
        let mut energy = Matrix2::zeros();
        for l in &self.layers {
            let [bottom, top] = l.heights;
            let flexible = l.shear.try_inverse()?;
            for (x, w) in gauss(3) {
                let z = 0.5 * (bottom + top) + 0.5 * (top - bottom) * x;
                let f = below + partial(l, z);
                energy += f.transpose() * flexible * f * (0.5 * (top - bottom) * w);
            }
            below += partial(l, top);
        }
        energy.try_inverse().map(|s| (s + s.transpose()) * 0.5)
    }

    /// Stiffness in axes from which the 0° direction is turned by an angle.
    pub fn at(&self, turn: f64) -> SectionStiffness {
        let (t, r) = (plane_turn(turn), vector_turn(turn));
        let [a, b, d] = self.plane().map(|m| t.transpose() * m * t);
        SectionStiffness {
            membrane: a,
            coupling: b,
            bending: d,
            shear: r.transpose() * self.shear * r,
            thickness: self.thickness,
        }
    }
}

/// Inverse of a matrix whose blocks have different units.
fn inverse(m: &Matrix6<f64>) -> Option<Matrix6<f64>> {
    let scale = Matrix6::from_diagonal(&m.diagonal().map(|d| 1.0 / d.abs().sqrt()));
    let unit = (scale * m * scale).try_inverse()?;
    Some(scale * unit * scale)
}

/// Inertia of layers: ∫ρ, ∫ρ z², ∫ρ z.
pub fn inertia(layers: &[Layer]) -> SectionInertia {
    let mut out = SectionInertia { mass: 0.0, rotary: 0.0, coupling: 0.0 };
    for layer in layers {
        let [z0, z1, z2] = layer.moments().map(|m| m * layer.material.density());
        out.mass += z0;
        out.coupling += z1;
        out.rotary += z2;
    }
    out
}
