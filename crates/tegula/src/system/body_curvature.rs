//! Curvature of the rotations of rigid bodies that shells are attached to, and of the nodes of beams.
//!
//! An arm a that is fixed in a body turns with it, `δa = δθ × a`. The moment `Σ a × R` of the unbalanced forces R on directors and
//! attached vectors therefore changes by `Σ (δθ × a) × R` in a rotation, and with `N = Σ a Rᵀ` the tangent gains `tr(N) I − N`.
//! Its skew part, half the unbalanced moment, is left out.
//!
//! The forces of the elements are those of the stress in the geometric stiffness `K = Σ 2 n_k A_k ⊗ I`, since forces of an iterate
//! that is no equilibrium would mislead: strains are quadratic in the nodal vectors q, so that these forces are `K q`.

use super::assembly::pairs;
use super::{LocalFrames, Reduction, System};
use crate::element::group::ALIGNMENT;
use crate::element::{ElementGroup, GroupPoint, Nodal, TangentRequest, TangentWeights};
use crate::{Mat3, Vec3};

/// Sums `N = Σ a Rᵀ` of the bodies, with buffers for a few elements.
pub(super) struct BodyCurvature {
    sums: Vec<Mat3>,
    forces: Vec<f64>,
    blocks: Vec<f64>,
}

impl BodyCurvature {
    /// Buffers for a system.
    pub fn new(system: &System) -> Self {
        // A group of one coupling of many vectors does not need room for a whole batch of them.
        let most = |size: &dyn Fn(usize) -> usize| {
            let of_group =
                |group: &dyn ElementGroup| size(group.vectors_per_element()) * group.len().min(ALIGNMENT);
            system.groups.iter().map(|group| of_group(group.as_ref())).max().unwrap_or(0)
        };
        Self {
            sums: vec![Mat3::zeros(); system.dofs().triads.len()],
            forces: vec![0.0; 3 * most(&|n| n)],
            blocks: vec![0.0; 9 * most(&pairs)],
        }
    }

    /// Begins the sums with the forces `rest` from outside.
    pub fn begin(&mut self, frames: &LocalFrames, weights: &TangentWeights, rest: &[Nodal]) {
        let force = |v: u32| Vec3::from(rest[v as usize]).transpose() * weights.direction;
        for (sum, (triad, arms)) in self.sums.iter_mut().zip(frames.triads()) {
            *sum = (0..3).map(|i| arms.column(i) * force(triad[i])).sum();
        }
        for (attached, arm) in frames.attached() {
            self.sums[attached.triad as usize] += arm * force(attached.vector);
        }
    }

    /// Subtracts the forces of the elements of a group on vectors that rigid bodies carry, with the nodal vectors `current`.
    pub fn subtract(
        &mut self,
        (group, reduction): (&dyn ElementGroup, &Reduction),
        (k, weights, stress): (&GroupPoint, &TangentWeights, Option<&[f64]>),
        frames: &LocalFrames,
        current: impl Fn(u32) -> Vec3,
    ) {
        let m = group.vectors_per_element();
        // The geometric part alone.
        let weights = TangentWeights { stress: 0.0, rate: 0.0, augmentation: 0.0, penalty: 0.0, ..*weights };
        let size = 9 * pairs(m);
        let mut evaluated = 0..0;
        let factor = weights.force * weights.direction;
        for number in reduction.numbers() {
            let forces = &mut self.forces[..3 * m];
            if group.forces_of_stresses(k, number, stress, forces) {
                forces.iter_mut().for_each(|f| *f *= factor);
                subtract(&mut self.sums, (group.vectors(number), forces), frames);
                continue;
            }
            if !evaluated.contains(&number) {
                let first = number - number % ALIGNMENT;
                evaluated = first..group.len().min(first + ALIGNMENT);
                let blocks = &mut self.blocks[..size * evaluated.len()];
                let request = TangentRequest { weights, stress, prescribed: None, blocks };
                group.evaluate(k, first, &mut self.forces[..3 * m * evaluated.len()], Some(request));
            }
            let at = size * (number - evaluated.start);
            let (blocks, vectors) = (&self.blocks[at..at + size], group.vectors(number));
            for (a, &v) in vectors.iter().enumerate() {
                let Some(attached) = frames.dofs().carried(v as usize) else { continue };
                let force: Vec3 =
                    vectors.iter().enumerate().map(|(b, &w)| block(blocks, a, b) * current(w)).sum();
                self.sums[attached.triad as usize] -= frames.arm(&attached) * force.transpose();
            }
        }
    }

    /// Subtracts the forces of a group of joints or springs on vectors that rigid bodies carry.
    pub fn subtract_forces(
        &mut self,
        (group, reduction): (&dyn ElementGroup, &Reduction),
        k: &GroupPoint,
        frames: &LocalFrames,
    ) {
        for number in reduction.numbers() {
            let vectors = group.vectors(number);
            let forces = &mut self.forces[..3 * vectors.len()];
            group.evaluate(k, number, forces, None);
            subtract(&mut self.sums, (vectors, forces), frames);
        }
    }

    /// Subtracts the forces of a group of joints or springs, which are known, on vectors that rigid bodies carry.
    pub fn subtract_known_forces(
        &mut self,
        (group, reduction): (&dyn ElementGroup, &Reduction),
        forces: &[f64],
        frames: &LocalFrames,
    ) {
        let size = 3 * group.vectors_per_element();
        for number in reduction.numbers() {
            let forces = &forces[size * number..size * (number + 1)];
            subtract(&mut self.sums, (group.vectors(number), forces), frames);
        }
    }

    /// Adds the curvature to the values of the tangent.
    pub fn add(&self, system: &System, frames: &LocalFrames, values: &mut [f64]) {
        for (n, (triad, _)) in self.sums.iter().zip(frames.triads()) {
            let k = Mat3::identity() * n.trace() - (n + n.transpose()) * 0.5;
            system.pattern.add_to_block(triad[0] as usize, &k, frames, values);
        }
    }
}

impl System {
    /// Whether a tangent of these weights has a curvature of the rotations of bodies: where they carry nodes of elastic elements, and
    /// in tangents that decide about stability.
    pub fn has_body_curvature(&self, weights: &TangentWeights) -> bool {
        !self.linear && (decides_stability(weights) || elastic(self).next().is_some())
    }
}

/// Whether a tangent has the geometric stiffness of joints. In the other ones the forces of joints are left out, since their
/// multipliers jump in singular positions.
pub(super) fn decides_stability(weights: &TangentWeights) -> bool {
    weights.multiplier != 0.0
}

/// Groups of elastic elements that rigid bodies carry, with their numbers and reductions.
pub(super) fn elastic(system: &System) -> impl Iterator<Item = (usize, &dyn ElementGroup, &Reduction)> {
    reduced(system).filter(|(_, group, _)| group.stresses_per_element() > 0)
}

/// Groups of joints and springs that act on rigid bodies, with their numbers and reductions.
pub(super) fn connections(system: &System) -> impl Iterator<Item = (usize, &dyn ElementGroup, &Reduction)> {
    reduced(system).filter(|(_, group, _)| group.stresses_per_element() == 0)
}

fn reduced(system: &System) -> impl Iterator<Item = (usize, &dyn ElementGroup, &Reduction)> {
    let reduced = system.groups.iter().zip(&system.reductions).enumerate();
    reduced.filter_map(|(g, (group, reduction))| Some((g, group.as_ref(), reduction.as_ref()?)))
}

/// Subtracts forces on nodal vectors from the sums of the bodies that carry these.
fn subtract(sums: &mut [Mat3], (vectors, forces): (&[u32], &[f64]), frames: &LocalFrames) {
    for (&v, force) in vectors.iter().zip(forces.chunks_exact(3)) {
        let Some(attached) = frames.dofs().carried(v as usize) else { continue };
        sums[attached.triad as usize] -= frames.arm(&attached) * Vec3::from_column_slice(force).transpose();
    }
}

/// Block of two nodal vectors in the lower blocks of an element.
fn block(blocks: &[f64], a: usize, b: usize) -> Mat3 {
    let at = 9 * (pairs(a.max(b)) + a.min(b));
    let k = Mat3::from_row_slice(&blocks[at..at + 9]);
    if a < b { k.transpose() } else { k }
}
