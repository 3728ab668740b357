//! Geometric stiffness of the stresses that loads produce linearly from a state.
//!
//! From a state u₀ with the increment u₁, the generalised stresses `n₁ = H B u₁ + n(u₀, E₁) − n(u₀, E₀)` of the displacements and of
//! the change of prescribed strains E give
//!
//! ```text
//! K_σ = Σ n₁ₖ ∂²sₖ/∂q² − Δ∂F/∂q
//! ```
//!
//! with the load stiffness of the change of follower loads (symmetric part), and of joints the second derivatives of the constraints with
//! the change of the multipliers. The forces of the increment act on inextensible directors and on rotations of rigid bodies as in the
//! tangent. All of it is linear in the increment: nothing is a difference of two tangents. The literature calls it initial stress
//! stiffness or stress stiffness (O. C. Zienkiewicz, R. L. Taylor, *The Finite Element Method*, vol. 2, on linear buckling).

use super::follower_loads::load_stiffness;
use super::{Assembly, BATCH, FieldStiffness, TangentCoefficients, pairs};
use crate::element::quadratic::multiply_blocks;
use crate::element::{Nodal, StressIncrement, TangentWeights};
use crate::load::FollowerLoad;
use crate::system::{EvaluationPoint, System, body_curvature};

/// Linear increment of a state under a change of the loads.
#[derive(Debug, Clone, Copy)]
pub struct LoadIncrement<'a> {
    /// Displacements u₁ of all nodal vectors.
    pub displacements: &'a [Nodal],
    /// Change of the multipliers of joints.
    pub multipliers: &'a [f64],
    /// Change of the external forces at the state.
    pub forces: &'a [Nodal],
    /// Times (load factors) between which the loads and prescribed strains change.
    pub times: [f64; 2],
}

impl Assembly {
    /// Sets [`stress`](Self::stress) to the change n₁ of the generalised stresses in an increment from an evaluation point.
    fn stress_increment(&mut self, system: &System, k: &EvaluationPoint, increment: &LoadIncrement) {
        let [before, after] = increment.times.map(|time| EvaluationPoint { time, ..*k });
        self.reset_stress(system, &before);
        let base = self.stress.clone();
        self.set_time(system, after.time);
        self.extrapolate(system, &after, increment.displacements, &TangentWeights::STATIC);
        self.stress.iter_mut().zip(&base).for_each(|(n, base)| *n -= base);
    }

    /// Values of the geometric stiffness K_σ of an increment from an evaluation point, whose local frames are those of this assembly.
    pub fn stress_stiffness(&mut self, system: &System, k: &EvaluationPoint, increment: &LoadIncrement) {
        self.stress_increment(system, k, increment);
        self.values.resize(system.pattern.values(), 0.0);
        self.blocks.resize(9 * super::largest_batch(system), 0.0);
        self.set_time(system, k.time);
        let mut of_change = *k;
        of_change.internal.multipliers = increment.multipliers;
        let mut batch = self.stresses_of_elements(system, &of_change, increment);
        self.stiffness_of_loads(system, k, (increment.times, &mut batch));
        self.add_curvature(system, k, &TangentWeights::GEOMETRIC, increment.forces);
        self.add_curvature_of_bodies(system, &of_change, increment);
    }

    /// Adds the stresses of the elements; returns the number of batches.
    fn stresses_of_elements(
        &mut self,
        system: &System,
        k: &EvaluationPoint,
        increment: &LoadIncrement,
    ) -> usize {
        let Self { frames, values, blocks, stress, factors, element_forces, .. } = self;
        system.pattern.begin(0.0, frames, values);
        let mut batch = 0;
        for (g, group, offsets) in system.numbered_groups() {
            let m = group.vectors_per_element();
            let k = k.of_group(system, g, factors);
            let stress = &stress[offsets.stresses.clone()];
            let of_group = StressIncrement { displacements: increment.displacements, stress };
            let forces = &mut element_forces[offsets.forces.clone()];
            for (number, forces) in forces.chunks_mut(3 * m * BATCH).enumerate() {
                let first = number * BATCH;
                let members = first..first + forces.len() / (3 * m);
                let (own, reduced) = blocks.split_at_mut(9 * pairs(m) * members.len());
                group.evaluate_stresses(&k, &of_group, first, (forces, own));
                let mut size = own.len();
                if let Some(reduction) = &system.reductions[g] {
                    let reduced = &mut reduced[..9 * reduction.blocks(members.clone())];
                    reduction.reduce(members, frames, own, reduced);
                    size += reduced.len();
                }
                system.pattern.add(batch, &blocks[..size], 0.0, frames, values);
                batch += 1;
            }
        }
        batch
    }

    /// Adds the change of the load stiffness between two times.
    fn stiffness_of_loads(
        &mut self,
        system: &System,
        k: &EvaluationPoint,
        (times, batch): ([f64; 2], &mut usize),
    ) {
        let Self { frames, values, blocks, .. } = self;
        let change = |load: &FollowerLoad| {
            let [before, after] = times.map(|time| system.factor(load.factor(), time));
            after - before
        };
        // Buckling analyses have no field loads.
        let fields = FieldStiffness::default();
        for first in (0..system.followers.len()).step_by(BATCH) {
            let size = load_stiffness(system, &k.motion, (first, &change), &fields, frames, blocks);
            system.pattern.add(*batch, &blocks[..size], 0.0, frames, values);
            *batch += 1;
        }
        for (time, sign) in times.into_iter().zip([-1.0, 1.0]) {
            let weights = TangentWeights { force: sign, ..TangentWeights::GEOMETRIC };
            let parts = TangentCoefficients { weights, mass: 0.0, time };
            system.add_centrifugal_tangent(&parts, frames, values);
        }
    }

    /// Adds the curvature of the rotations of rigid bodies under the forces of the increment.
    fn add_curvature_of_bodies(&mut self, system: &System, k: &EvaluationPoint, increment: &LoadIncrement) {
        if system.dofs().triads.is_empty() {
            return;
        }
        let weights = TangentWeights::GEOMETRIC;
        let Self { curvature, frames, values, stress, factors, element_forces, .. } = self;
        curvature.begin(frames, &weights, increment.forces);
        for (g, group, reduction) in body_curvature::elastic(system) {
            let stress = &stress[system.offsets[g].stresses.clone()];
            let current = |v: u32| super::current_vector(system, &k.motion, v as usize);
            let k = k.of_group(system, g, factors);
            curvature.subtract((group, reduction), (&k, &weights, Some(stress)), frames, current);
        }
        for (g, group, reduction) in body_curvature::connections(system) {
            let forces = &element_forces[system.offsets[g].forces.clone()];
            curvature.subtract_known_forces((group, reduction), forces, frames);
        }
        curvature.add(system, frames, values);
    }

    /// Adds `factor` times the product of the element tangents of a state with a field of all nodal vectors, constrained ones included.
    /// The augmented Lagrangian of joints is left out.
    pub fn add_tangent_product(
        &mut self,
        system: &System,
        k: &EvaluationPoint,
        field: &[Nodal],
        factor: f64,
        out: &mut [Nodal],
    ) {
        let parts = TangentCoefficients { weights: TangentWeights::STATIC, mass: 0.0, time: k.time };
        let mut forces = Vec::new();
        self.for_each_element(system, k, &parts, |elements| {
            let m = elements.group.vectors_per_element();
            forces.resize(3 * m, 0.0);
            for (number, blocks) in (elements.first..).zip(elements.blocks.chunks_exact(9 * pairs(m))) {
                let vectors = elements.group.vectors(number);
                let values: Vec<Nodal> = vectors.iter().map(|&v| field[v as usize]).collect();
                if values.iter().all(|value| *value == [0.0; 3]) {
                    continue;
                }
                forces.fill(0.0);
                multiply_blocks(blocks, &values, factor, &mut forces);
                for (&v, force) in vectors.iter().zip(forces.chunks_exact(3)) {
                    (0..3).for_each(|i| out[v as usize][i] += force[i]);
                }
            }
        });
    }
}
