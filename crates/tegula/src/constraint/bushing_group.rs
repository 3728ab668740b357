//! Bushings as contributions to forces, tangent, energy and dissipation.

use super::bushing::{Bushing, LARGEST_ROTATION, pairs};
use super::joint::{MOST_VECTORS, current, few};
use super::joints::LARGEST_TURN;
use crate::Vec3;
use crate::element::{ElementGroup, GroupPoint, Nodal, StressIncrement, TangentRequest};

/// History variables of a bushing: its rotation vector at the end of the last step.
const HISTORY: usize = 3;

/// Bushings of as many nodal vectors each.
pub struct BushingGroup {
    members: Vec<Bushing>,
    vectors: usize,
}

impl BushingGroup {
    /// Name of the groups.
    pub const NAME: &str = "bushing";

    /// Groups of all bushings, one for each number of nodal vectors.
    pub fn groups(bushings: &[Bushing]) -> Vec<Box<dyn ElementGroup>> {
        let groups = (1..=MOST_VECTORS).map(|vectors| {
            let is_member = |bushing: &&Bushing| bushing.vectors.len() == vectors;
            Self { members: bushings.iter().filter(is_member).cloned().collect(), vectors }
        });
        groups.filter(|group| !group.members.is_empty()).map(|group| Box::new(group) as _).collect()
    }

    fn committed<'a>(k: &GroupPoint<'a>, element: usize) -> &'a [f64] {
        &k.interior.history[HISTORY * element..HISTORY * (element + 1)]
    }
}

/// Adds the product of lower blocks with an increment of the nodal vectors to the forces of an element.
fn add_product(blocks: &[f64], vectors: &[u32], increment: &[Nodal], forces: &mut [f64]) {
    let mut add = |row: usize, column: usize, entry: f64| {
        forces[row] += entry * increment[vectors[column / 3] as usize][column % 3];
    };
    for (block, (a, b)) in blocks.chunks_exact(9).zip(pairs(vectors.len())) {
        for (i, &entry) in block.iter().enumerate() {
            let (row, column) = (3 * a + i / 3, 3 * b + i % 3);
            add(row, column, entry);
            if a != b {
                add(column, row, entry);
            }
        }
    }
}

impl ElementGroup for BushingGroup {
    fn name(&self) -> &'static str {
        Self::NAME
    }

    fn len(&self) -> usize {
        self.members.len()
    }

    fn vectors(&self, element: usize) -> &[u32] {
        &self.members[element].vectors
    }

    fn acts_on_ground(&self) -> bool {
        true
    }

    fn is_grounded(&self, element: usize) -> bool {
        self.members[element].grounded
    }

    fn has_rate_damping(&self) -> bool {
        self.members.iter().any(|bushing| bushing.damping.iter().any(|x| *x != 0.0))
    }

    fn vectors_per_element(&self) -> usize {
        self.vectors
    }

    fn history_per_element(&self) -> usize {
        HISTORY
    }

    fn evaluate(
        &self,
        k: &GroupPoint,
        first: usize,
        forces: &mut [f64],
        mut tangent: Option<TangentRequest>,
    ) {
        let n = self.vectors;
        for (e, out) in forces.chunks_mut(3 * n).enumerate() {
            let bushing = &self.members[first + e];
            let deformation = bushing.deformation(k, Self::committed(k, first + e));
            let force = bushing.force(&deformation, k.preload);
            let v = few(&bushing.vectors, |v| current(k, v));
            let on_vectors = bushing.gradient(&v, &Bushing::factors(&force, &deformation));
            for (out, f) in out.chunks_exact_mut(3).zip(&on_vectors) {
                out.copy_from_slice(f.as_slice());
            }
            let Some(request) = &mut tangent else { continue };
            let weights = request.weights;
            let along = (bushing.stiffness * weights.stress + bushing.damping * weights.rate) * weights.force;
            let size = 9 * n * (n + 1) / 2;
            let blocks = &mut request.blocks[e * size..(e + 1) * size];
            let gradients = bushing.strain_gradients(&v, &deformation);
            for (out, (a, b)) in blocks.chunks_exact_mut(9).zip(pairs(n)) {
                let mut block = crate::Mat3::zeros();
                for (i, of_strain) in gradients.iter().enumerate() {
                    let stressed: Vec3 =
                        gradients.iter().zip(along.row(i).iter()).map(|(g, x)| g[b] * *x).sum();
                    block += of_strain[a] * stressed.transpose();
                }
                out.iter_mut().enumerate().for_each(|(i, out)| *out = block[(i / 3, i % 3)]);
            }
            let bent = weights.force * weights.direction;
            bushing.add_second_derivative(bent, (&force, &deformation, &v), blocks);
            if let Some(increment) = request.prescribed {
                add_product(blocks, &bushing.vectors, increment, out);
            }
        }
    }

    fn evaluate_stresses(
        &self,
        k: &GroupPoint,
        increment: &StressIncrement,
        first: usize,
        (forces, blocks): (&mut [f64], &mut [f64]),
    ) {
        let n = self.vectors;
        let of_each = forces.chunks_mut(3 * n).zip(blocks.chunks_mut(9 * n * (n + 1) / 2));
        for (e, (out, blocks)) in (first..).zip(of_each) {
            let bushing = &self.members[e];
            let deformation = bushing.deformation(k, Self::committed(k, e));
            let v = few(&bushing.vectors, |v| current(k, v));
            let displacement = |v: u32| Vec3::from(increment.displacements[v as usize]);
            let force = bushing.stiffness * bushing.strains_of(&v, &deformation, displacement);
            let on_vectors = bushing.gradient(&v, &Bushing::factors(&force, &deformation));
            for (out, f) in out.chunks_exact_mut(3).zip(&on_vectors) {
                out.copy_from_slice(f.as_slice());
            }
            blocks.fill(0.0);
            bushing.add_second_derivative(1.0, (&force, &deformation, &v), blocks);
        }
    }

    fn reason_without_forces(&self, k: &GroupPoint, element: usize) -> Option<String> {
        let bushing = &self.members[element];
        let cosine = bushing.cosine(k);
        let angle = cosine.clamp(-1.0, 1.0).acos().to_degrees();
        let broken =
            !bushing.deformation(k, Self::committed(k, element)).strains[1].iter().all(|x| x.is_finite());
        let reason = if angle > LARGEST_ROTATION {
            format!("would rotate by {angle:.0}°, beyond its range of {LARGEST_ROTATION}°")
        } else {
            format!("would rotate by more than {LARGEST_TURN} rad in the step")
        };
        (broken && cosine.is_finite()).then(|| format!("the bushing \"{}\" {reason}", bushing.name))
    }

    fn material_energies(&self, k: &GroupPoint, motion: &[Nodal], energies: &mut [f64]) {
        for (element, (bushing, energy)) in self.members.iter().zip(energies).enumerate() {
            let deformation = bushing.deformation(k, Self::committed(k, element));
            let v = few(&bushing.vectors, |v| current(k, v));
            let strain = bushing.strains_of(&v, &deformation, |v| Vec3::from(motion[v as usize]));
            *energy = 0.5 * strain.dot(&(bushing.stiffness * strain));
        }
    }

    fn resisted_strains(&self, element: usize, k: &GroupPoint) -> Vec<Vec<Vec3>> {
        let bushing = &self.members[element];
        // A full matrix resists combinations of strains.
        let diagonal = bushing.stiffness.diagonal();
        if bushing.stiffness != nalgebra::Matrix6::from_diagonal(&diagonal) {
            return Vec::new();
        }
        let v = few(&bushing.vectors, |v| current(k, v));
        let gradients = bushing.strain_gradients(&v, &bushing.deformation(k, Self::committed(k, element)));
        let resisted = gradients.iter().zip(diagonal.iter()).filter(|(_, stiffness)| **stiffness > 0.0);
        resisted.map(|(gradient, _)| gradient[..self.vectors].to_vec()).collect()
    }

    fn energies(&self, k: &GroupPoint, energies: &mut [f64]) {
        for (element, (bushing, energy)) in self.members.iter().zip(energies).enumerate() {
            *energy = bushing.energy(&bushing.deformation(k, Self::committed(k, element)), k.preload);
        }
    }

    fn update_history(&self, k: &GroupPoint, history: &mut [f64]) -> f64 {
        for (bushing, out) in self.members.iter().zip(history.chunks_exact_mut(HISTORY)) {
            out.copy_from_slice(bushing.rotation(k).as_slice());
        }
        0.0
    }

    fn dissipation(&self, k: &GroupPoint, power: &mut [f64]) {
        for (element, (bushing, power)) in self.members.iter().zip(power).enumerate() {
            let rate = bushing.deformation(k, Self::committed(k, element)).rate;
            *power = rate.dot(&(bushing.damping * rate));
        }
    }
}
