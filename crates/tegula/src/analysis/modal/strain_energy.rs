//! Eigenvalues by the Rayleigh quotient of the strain energy, without the cancellation in the assembled stiffness.
//!
//! In `φᵀ K φ` the products of stiff parts cancel where a motion strains them little, and leave round-off of the size `ε |φ|ᵀ|K||φ|` with the
//! machine precision ε. The material part `Σ δs·H δs` with the strains `δs = B φ` of the motion has the round-off `ε² |φ|ᵀ|K||φ|`, since strains
//! enter squared. The geometric part `Σ n ∂²s φ φ`, with the geometric stiffness of joints and of loads, is a sum of terms of the size of the
//! stresses n. These are known to less than ε times the stiffness and the displacements.

use super::problem::Problem;
use crate::Vec3;
use crate::constraint::{BushingGroup, SpringGroup, TorsionSpringGroup};
use crate::element::{ElementGroup, GroupPoint, Nodal, TangentRequest, TangentWeights, energy_of_blocks};
use crate::norm::larger;
use crate::system::{VectorKind, dot};

/// Round-off of an eigenvalue over the sum of its terms' sizes. The equilibrium itself is known to a similar part of its forces.
const ROUND_OFF: f64 = 1e-12;
/// Bound of the round-off in the strain energy of rigid motions: squares of the machine precision, with the margin of [`ROUND_OFF`].
const ROUND_OFF_OF_STRAIN: f64 = 1e6 * f64::EPSILON * f64::EPSILON;
/// Strain energy over the shift that stiffer modes add to a vector of the shift-inverted iteration: its eigenvalues are known to the machine
/// precision of the shift, and its vectors contain stiffer ones by the square root of less.
const ROUND_OFF_OF_SHIFT: f64 = 1e-4 * f64::EPSILON;
/// Bound of the round-off in the geometric stiffness of an equilibrium, relative to the stiffness and, below 1, to the largest displacement over the
/// size of the model. Hinged plates of 64 and 256 elements that had turned by 1 rad had 0.003 ε.
const ROUND_OFF_OF_STRESS: f64 = 0.1 * f64::EPSILON;

/// Groups whose energy is that of a length or an angle.
pub(super) const OF_SPRINGS: [&str; 3] = [SpringGroup::NAME, TorsionSpringGroup::NAME, BushingGroup::NAME];

/// Eigenvalue by the strain energy of its motion.
pub(super) struct RayleighQuotient {
    /// λ = ω².
    pub value: f64,
    /// Bound of its round-off.
    pub round_off: f64,
    /// Part of λ by the strains of the motion, without that by stresses and loads.
    pub material: f64,
    /// Bound of the round-off of this part.
    pub round_off_of_material: f64,
}

impl Problem<'_> {
    /// Sum of the sizes of the terms of `xᵀ K x`.
    fn sum_of_sizes(&self, stiffness: &[f64], x: &[f64]) -> f64 {
        let (pointers, rows) = self.pattern.columns();
        let of_column = |(j, column): (usize, &[usize])| -> f64 {
            let of = |k: usize| {
                let i = rows[k] as usize;
                // Entries below the diagonal stand for those above it, too.
                (stiffness[k] * x[i]).abs() * if i == j { 1.0 } else { 2.0 }
            };
            x[j].abs() * (column[0]..column[1]).map(of).sum::<f64>()
        };
        pointers.windows(2).enumerate().map(of_column).sum()
    }

    /// Product `xᵀ K x`.
    fn product(&self, stiffness: &[f64], x: &[f64]) -> f64 {
        let mut product = vec![0.0; x.len()];
        self.pattern.add_product(stiffness, x, &mut product);
        product.iter().zip(x).map(|(k, x)| k * x).sum()
    }

    /// Rayleigh quotient of a vector and its shape in all nodal vectors.
    pub fn rayleigh_quotient(&self, x: &[f64], shape: &[Nodal]) -> RayleighQuotient {
        let kinds = &self.system.coordinates.kinds;
        let attached = self.system.dofs().attached.iter().map(|attached| attached.vector as usize);
        let positions = attached.filter(|v| kinds[*v] == VectorKind::Position);
        let squares: f64 = positions.map(|v| dot(&shape[v..=v], &shape[v..=v])).sum();
        let shift = self.groups.iter().map(|group| group.shift.abs()).fold(0.0, larger);
        let stressed = self.sum_of_sizes(&self.stiffness, x)
            + 2.0 * self.sum_over_springs(TangentWeights::STATIC, shape, sizes_of_terms);
        // Nodes of bodies, whose displacements cancel before they enter the stiffness of the unknowns.
        let terms = stressed + self.stiffness_of_elements * squares;
        let bent = 2.0 * self.sum_over_springs(TangentWeights::GEOMETRIC, shape, sizes_of_terms);
        let (geometric, of_geometric) = if self.stress_free {
            (2.0 * self.sum_over_springs(TangentWeights::GEOMETRIC, shape, tangent_energy), bent)
        } else {
            let sizes = self.sum_of_sizes(&self.geometric_stiffness, x) + bent;
            (self.product(&self.geometric_stiffness, x), sizes)
        };
        let modal_mass = 2.0 * self.system.kinetic_energy(shape);
        let material = 2.0 * self.material_energy(shape) / modal_mass;
        let round_off_of_material =
            ROUND_OFF_OF_STRAIN * self.distance().powi(2) * terms + ROUND_OFF_OF_SHIFT * shift;
        let stress = if self.stress_free {
            0.0
        } else {
            ROUND_OFF_OF_STRESS * self.displacement().min(1.0) * stressed
        };
        RayleighQuotient {
            value: material + geometric / modal_mass,
            round_off: round_off_of_material + ROUND_OFF * of_geometric + stress,
            material,
            round_off_of_material,
        }
    }

    /// Largest distance of a place from the origin over the size of the model, at least 1: differences of places, which give directions, are known
    /// to so many times the machine precision.
    fn distance(&self) -> f64 {
        let coordinates = &self.system.coordinates;
        let positions = coordinates.reference.iter().zip(&coordinates.kinds);
        let lengths = positions.filter(|(_, kind)| **kind == VectorKind::Position);
        lengths.map(|(x, _)| Vec3::from(*x).norm() / self.system.length).fold(1.0, larger)
    }

    /// Largest displacement of the state over the size of the model, or change of a director.
    fn displacement(&self) -> f64 {
        let of_vector = |(v, u): (usize, &Nodal)| {
            let length = Vec3::from(*u).norm();
            match self.system.coordinates.kinds[v] {
                VectorKind::Position => length / self.system.length,
                _ => length,
            }
        };
        self.state.u.iter().enumerate().map(of_vector).fold(0.0, larger)
    }

    /// Energy of the strains of a small motion about the state.
    pub fn material_energy(&self, shape: &[Nodal]) -> f64 {
        let factors: Vec<f64> = self.system.factors(self.state.time).collect();
        let state = self.state.point(self.system);
        let of_group = |(number, group, _): (usize, &dyn ElementGroup, _)| {
            let mut energies = vec![0.0; group.len()];
            group.material_energies(&state.of_group(self.system, number, &factors), shape, &mut energies);
            energies.iter().sum::<f64>()
        };
        self.system.numbered_groups().map(of_group).sum()
    }

    /// Sum of a quantity of the tangents of springs, torsion springs and bushings.
    fn sum_over_springs(
        &self,
        weights: TangentWeights,
        shape: &[Nodal],
        of: impl Fn(&dyn ElementGroup, &GroupPoint, TangentWeights, &[Nodal]) -> f64,
    ) -> f64 {
        let factors: Vec<f64> = self.system.factors(self.state.time).collect();
        let state = self.state.point(self.system);
        let springs =
            self.system.numbered_groups().filter(|(_, group, _)| OF_SPRINGS.contains(&group.name()));
        springs
            .map(|(number, group, _)| {
                of(group, &state.of_group(self.system, number, &factors), weights, shape)
            })
            .sum()
    }
}

/// Energy ½ φ·K φ of a group by its tangent K.
pub(super) fn tangent_energy(
    group: &dyn ElementGroup,
    k: &GroupPoint,
    weights: TangentWeights,
    shape: &[Nodal],
) -> f64 {
    let n = group.vectors_per_element();
    sum_over_elements(group, k, weights, |vectors, blocks| {
        energy_of_blocks(blocks, |a| Vec3::from(shape[vectors[a] as usize]), n)
    })
}

/// Sizes `½ Σ ‖K_ab‖ ‖φ_a‖ ‖φ_b‖` of the terms of this energy: the directions of the nodal vectors φ_a are known to the machine precision of their lengths.
fn sizes_of_terms(group: &dyn ElementGroup, k: &GroupPoint, weights: TangentWeights, shape: &[Nodal]) -> f64 {
    let n = group.vectors_per_element();
    sum_over_elements(group, k, weights, |vectors, blocks| {
        let length = |a: usize| Vec3::from(shape[vectors[a] as usize]).norm();
        let pairs = (0..n).flat_map(|a| (0..=a).map(move |b| (a, b)));
        let size = |block: &[f64]| block.iter().map(|k| k * k).sum::<f64>().sqrt();
        let of = |((a, b), block): ((usize, usize), &[f64])| {
            size(block) * length(a) * length(b) * if a == b { 0.5 } else { 1.0 }
        };
        pairs.zip(blocks.chunks_exact(9)).map(of).sum()
    })
}

/// Sum over the elements of a group of a quantity of their nodal vectors and the lower blocks of their tangents.
fn sum_over_elements(
    group: &dyn ElementGroup,
    k: &GroupPoint,
    weights: TangentWeights,
    of: impl Fn(&[u32], &[f64]) -> f64,
) -> f64 {
    let n = group.vectors_per_element();
    let size = 9 * n * (n + 1) / 2;
    let (mut forces, mut blocks) = (vec![0.0; 3 * n * group.len()], vec![0.0; size * group.len()]);
    let request = TangentRequest { weights, stress: None, prescribed: None, blocks: &mut blocks };
    group.evaluate(k, 0, &mut forces, Some(request));
    blocks.chunks_exact(size).enumerate().map(|(element, blocks)| of(group.vectors(element), blocks)).sum()
}
