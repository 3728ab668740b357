//! Fields of nodal vectors: scalar products, norms, sums.

use super::coordinates::Body;
use super::{System, VectorKind};
use crate::element::Nodal;
use tegula_sparse::norm::larger;

/// Displacements over the model's length and changes of directors that are round-off of them.
const ROUND_OFF: f64 = 1e-9;
/// Relative difference of components that count as equal: that of modes found by iteration.
const EQUAL: f64 = 1e-5;

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

    /// Size of forces on all nodal vectors, dual to [`norm`](Self::norm): root of the number of vectors times the sum of the squares of
    /// force times the model's length and of director force, so that `|f · u| ≤ force_norm(f) norm(u)` [force·length].
    pub fn force_norm(&self, forces: &[Nodal]) -> f64 {
        let square = |(f, kind): (&Nodal, &VectorKind)| {
            let s = dot3(*f, *f);
            if *kind == VectorKind::Position { s * self.length * self.length } else { s }
        };
        (forces.len() as f64 * forces.iter().zip(&self.coordinates.kinds).map(square).sum::<f64>()).sqrt()
    }

    /// Gives a mode the sign with which its largest component is positive: of its displacements, of the directors where nothing is
    /// displaced; of several equal ones the first in the order of the nodes.
    pub fn orient(&self, mode: &mut [Nodal]) {
        let kinds = &self.coordinates.kinds;
        let largest = |position: bool| {
            let of_kind =
                mode.iter().zip(kinds).filter(|(_, kind)| (**kind == VectorKind::Position) == position);
            of_kind.flat_map(|(v, _)| v.map(f64::abs)).fold(0.0, larger)
        };
        let sizes = [largest(false), largest(true)];
        let position = sizes[1] > ROUND_OFF * self.length * sizes[0];
        let least = (1.0 - EQUAL) * sizes[usize::from(position)];
        let mut of_kind =
            mode.iter().zip(kinds).filter(|(_, kind)| (**kind == VectorKind::Position) == position);
        let first = of_kind.find_map(|(v, _)| v.iter().copied().find(|x| x.abs() >= least));
        if first.is_some_and(|x| x < 0.0) {
            mode.as_flattened_mut().iter_mut().for_each(|x| *x = -*x);
        }
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
