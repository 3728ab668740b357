//! Fields of nodal vectors: scalar products, norms, sums.

use super::coordinates::Body;
use super::{System, VectorKind};
use crate::element::Nodal;
use tegula_sparse::norm::larger;

impl System {
    /// Scalar product of two changes of all nodal vectors: mean over them of the products of displacements over the square of the
    /// model's length, and of the products of changes of directors.
    pub fn inner_product(&self, a: &[Nodal], b: &[Nodal]) -> f64 {
        let mut sum = 0.0;
        for (kind, (a, b)) in self.coordinates.kinds.iter().zip(a.iter().zip(b)) {
            let s = dot3(*a, *b);
            sum += if *kind == VectorKind::Position { s / (self.length * self.length) } else { s };
        }
        sum / a.len().max(1) as f64
    }

    /// Size of a change of all nodal vectors: root mean square over nodes of displacement over the
    /// model's length and change of director.
    pub fn norm(&self, field: &[Nodal]) -> f64 {
        self.inner_product(field, field).sqrt()
    }

    /// Multiplies displacements by the weights of [`norm`](Self::norm), but for the mean.
    pub fn apply_metric(&self, field: &mut [Nodal]) {
        for (x, kind) in field.iter_mut().zip(&self.coordinates.kinds) {
            if *kind == VectorKind::Position {
                *x = x.map(|x| x / (self.length * self.length));
            }
        }
    }

    /// Root mean square of the positions' part of a field over the model's length; where it is larger, that of a rigid body alone:
    /// its position over the model's length and its rotation (rad).
    pub fn position_rms(&self, field: impl Fn(usize) -> Nodal) -> f64 {
        let (mut sum, mut count) = (0.0, 0);
        for &p in self.coordinates.position_of.iter().filter(|&&p| p != u32::MAX) {
            let v = field(p as usize);
            sum += dot3(v, v);
            count += 3;
        }
        let nodes = (sum / f64::from(count.max(1))).sqrt() / self.length;
        let of_body = |body: &Body| {
            let square = |v: u32| dot3(field(v as usize), field(v as usize));
            let turn = body.directors.map_or(0.0, |d| 0.5 * d.map(square).iter().sum::<f64>());
            (square(body.centre) / (self.length * self.length) + turn).sqrt()
        };
        self.coordinates.bodies.iter().map(of_body).fold(nodes, larger)
    }
}

/// Scalar product of two nodal vectors.
pub fn dot3(a: Nodal, b: Nodal) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Scalar product of two fields.
pub fn dot(a: &[Nodal], b: &[Nodal]) -> f64 {
    a.iter().zip(b).map(|(a, b)| dot3(*a, *b)).sum()
}

/// Adds a multiple of a field to another one.
pub fn add_multiple(to: &mut [Nodal], factor: f64, what: &[Nodal]) {
    for (x, y) in to.as_flattened_mut().iter_mut().zip(what.as_flattened()) {
        *x += factor * y;
    }
}
