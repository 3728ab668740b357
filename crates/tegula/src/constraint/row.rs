//! One scalar constraint: a quadratic form of nodal vectors.

use super::Attachment;
use crate::Vec3;

/// Scalar constraint `g(v) = Σ C_ab v_a·v_b + Σ c_a·v_a + c₀ = 0` of the nodal vectors v of a joint, which it names by their
/// places in the joint's list.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Row {
    products: Vec<(usize, usize, f64)>,
    linear: Vec<(usize, Vec3)>,
    constant: f64,
    /// Size of the values of the constraint: the length of the model for distances, 1 for products of unit vectors.
    pub size: f64,
    /// Inertia that the constraint acts on \[mass for distances, mass · length² for products of unit vectors\]: weight of
    /// the augmented Lagrangian.
    pub inertia: f64,
}

impl Row {
    /// Constraint `(a − b)·e = 0` of two points along a fixed direction of space.
    pub fn coincident(vectors: &mut Vec<u32>, a: &Attachment, b: &Attachment, e: &Vec3) -> Self {
        let mut row = Self { constant: (a.constant - b.constant).dot(e), ..Self::default() };
        for (list, sign) in [(&a.terms, 1.0), (&b.terms, -1.0)] {
            for &(v, w) in list {
                row.linear.push((place(vectors, v), e * (sign * w)));
            }
        }
        row
    }

    /// Adds `factor · a·b`, the product of two points or axes.
    pub fn add_product(&mut self, vectors: &mut Vec<u32>, factor: f64, a: &Attachment, b: &Attachment) {
        self.constant += factor * a.constant.dot(&b.constant);
        for (list, other) in [(a, b), (b, a)] {
            for &(v, w) in &list.terms {
                self.linear.push((place(vectors, v), other.constant * (factor * w)));
            }
        }
        for &(v, w) in &a.terms {
            for &(x, y) in &b.terms {
                self.products.push((place(vectors, v), place(vectors, x), factor * w * y));
            }
        }
    }

    /// Adds a constant.
    pub fn add_constant(&mut self, value: f64) {
        self.constant += value;
    }

    /// Value g of the constraint.
    pub fn value(&self, v: &[Vec3]) -> f64 {
        let products: f64 = self.products.iter().map(|&(a, b, c)| c * v[a].dot(&v[b])).sum();
        products + self.linear.iter().map(|(a, c)| c.dot(&v[*a])).sum::<f64>() + self.constant
    }

    /// Adds `factor · ∂g/∂v` to the gradient of each nodal vector.
    pub fn add_gradient(&self, factor: f64, v: &[Vec3], out: &mut [Vec3]) {
        for &(a, b, c) in &self.products {
            out[a] += v[b] * (factor * c);
            out[b] += v[a] * (factor * c);
        }
        for (a, c) in &self.linear {
            out[*a] += c * factor;
        }
    }

    /// Part `2 Σ C_ab v̇_a·v̇_b` of the second time derivative that follows from the velocities alone.
    pub fn velocity_term(&self, rates: &[Vec3]) -> f64 {
        self.products.iter().map(|&(a, b, c)| 2.0 * c * rates[a].dot(&rates[b])).sum()
    }
}

/// Place of a nodal vector in the list of a joint, to which it is added if it is new.
fn place(vectors: &mut Vec<u32>, vector: u32) -> usize {
    vectors.iter().position(|&v| v == vector).unwrap_or_else(|| {
        vectors.push(vector);
        vectors.len() - 1
    })
}
