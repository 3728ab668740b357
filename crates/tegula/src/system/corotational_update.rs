//! Co-rotational update of the lagged tangent: rotations of the nodes between two states.
//!
//! A shell that moves without much deformation keeps its tangent but for the rotation of its parts: `K ≈ R K₀ Rᵀ`, with
//! a rotation for each node. The rotation of a node is the one nearest (polar decomposition) to the change of its
//! vectors and of the edges to its neighbours, `Σ (x_j − x_i) ⊗ (X_j − X_i)/|X_j − X_i|² + Σ d ⊗ D`.

use nalgebra::Rotation3;
use rayon::prelude::*;

use super::dof_map::CONSTRAINED;
use super::{System, VectorKind};
use crate::element::Nodal;
use crate::lists::Lists;
use crate::{Mat3, Vec3};

/// Rotation (rad) below which the iteration for a nearest rotation ends: the tangent that it rotates is approximate.
const ACCURACY: f64 = 1e-7;
/// Largest number of iterations for a rotation.
const ITERATIONS: usize = 30;

/// Co-rotational update of the lagged tangent: rotations of the nodes, and the vectors that define them.
pub struct CorotationalUpdate {
    /// Nodal vectors by node: positions of the neighbours, and directors of the node itself.
    partners: Lists<u32>,
    /// Rotation of each node.
    rotations: Vec<Mat3>,
    /// Flags of the vectors that are free to rotate.
    free: Vec<bool>,
}

impl CorotationalUpdate {
    /// Identity rotations for the nodes of a system.
    pub fn new(system: &System) -> Self {
        let mut pairs: Vec<(u32, u32)> = Vec::new();
        for group in system.groups.iter() {
            for e in 0..group.len() {
                let vectors = group.vectors(e);
                let positions = || {
                    vectors.iter().filter(|&&v| system.coordinates.kinds[v as usize] == VectorKind::Position)
                };
                for &i in positions() {
                    pairs.extend(
                        positions().filter(|&&j| j != i).map(|&j| (system.coordinates.nodes[i as usize], j)),
                    );
                }
            }
        }
        let own = (0..system.vectors()).filter(|&v| system.coordinates.kinds[v] != VectorKind::Position);
        pairs.extend(own.map(|v| (system.coordinates.nodes[v], v as u32)));
        pairs.sort_unstable();
        pairs.dedup();
        let nodes = system.coordinates.position_of.len();
        // An inextensible director is free to rotate, though it has but two free degrees of freedom.
        let mut free: Vec<bool> =
            (0..system.vectors()).map(|v| system.frames.of(v).iter().all(|&n| n != CONSTRAINED)).collect();
        for unit in &system.dofs().unit {
            free[unit.vector as usize] = unit.fixed.is_none();
        }
        let rotations = vec![Mat3::identity(); nodes];
        Self { partners: Lists::by_key(nodes, pairs.into_iter()), rotations, free }
    }

    /// Finds the rotations between two states with displacements `from` and `to`.
    pub fn find(&mut self, system: &System, from: &[Nodal], to: &[Nodal]) {
        let Self { partners, rotations, .. } = self;
        let at = |u: &[Nodal], v: u32| {
            let v = v as usize;
            Vec3::from(system.coordinates.reference[v]) + Vec3::from(u[v])
        };
        rotations.par_iter_mut().with_min_len(64).enumerate().for_each(|(node, rotation)| {
            let own = system.coordinates.position_of[node];
            let mut change = Mat3::zeros();
            for &p in partners.of(node) {
                let (mut old, mut new) = (at(from, p), at(to, p));
                if system.coordinates.kinds[p as usize] == VectorKind::Position {
                    old -= at(from, own);
                    new -= at(to, own);
                }
                let length = old.norm_squared();
                if length > 0.0 {
                    change += new * (old / length).transpose();
                }
            }
            *rotation = nearest_rotation(&change);
        });
    }

    /// Rotates a field: `R x`, or `Rᵀ x` if `transposed`.
    pub fn turn(&self, system: &System, transposed: bool, field: &mut [Nodal]) {
        for (v, value) in field.iter_mut().enumerate() {
            if self.free[v] {
                let r = &self.rotations[system.coordinates.nodes[v] as usize];
                let x = Vec3::from(*value);
                *value = if transposed { r.tr_mul(&x) } else { r * x }.into();
            }
        }
    }
}

/// Rotation nearest to a matrix (polar decomposition), iterated from the identity.
fn nearest_rotation(m: &Mat3) -> Mat3 {
    Rotation3::from_matrix_eps(m, ACCURACY, ITERATIONS, Rotation3::identity()).into_inner()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_rotation_of_a_stretched_rotation_is_the_rotation() {
        let q = *Rotation3::new(Vec3::new(0.7, -1.1, 0.4)).matrix();
        let stretch = Mat3::new(1.3, 0.1, 0.0, 0.1, 0.8, -0.05, 0.0, -0.05, 1.1);
        assert!((nearest_rotation(&(q * stretch)) - q).norm() < 10.0 * ACCURACY);
        assert_eq!(nearest_rotation(&Mat3::zeros()), Mat3::identity());
    }
}
