//! Buffers and routines that sum element contributions: internal forces, tangent, energies.

mod field_loads;
mod follower_loads;
mod stress_stiffness;

use std::ops::Range;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::body_curvature::{self, BodyCurvature};
use super::evaluation_point::{EvaluationPoint, current_vector};
use super::pattern::BATCH;
use super::{GroupOffsets, LocalFrames, Reduction, System, VectorKind};
use crate::Vec3;
use crate::element::{ElementGroup, Motion, Nodal, TangentRequest, TangentWeights};
use crate::lists::Lists;
use crate::load::FollowerLoad;
use crate::norm::larger;
pub use field_loads::FieldStiffness;
pub(super) use follower_loads::add_applied_follower_loads;
use follower_loads::load_stiffness;
pub use follower_loads::{add_follower_loads, add_follower_stiffness};
pub use stress_stiffness::LoadIncrement;

/// Tangent coefficients: weights of the element parts, factor of the mass, and time of the follower loads.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct TangentCoefficients {
    /// Weights of the element parts.
    pub weights: TangentWeights,
    /// Factor of the mass matrix.
    pub mass: f64,
    /// Time at which follower loads act.
    pub time: f64,
}

/// Lower tangent blocks of a batch of elements of a group.
#[derive(Clone, Copy)]
pub struct ElementBlocks<'a> {
    /// Element group of the batch.
    pub group: &'a dyn ElementGroup,
    /// First element of the batch.
    pub first: usize,
    /// Lower blocks of the elements, one element after another.
    pub blocks: &'a [f64],
}

/// Number of batches from which on a model releases the batch buffer when the tangent is summed: the factorisation
/// needs memory then, and reallocation is cheap for such models.
const MANY_BATCHES: usize = 8;

/// Assembly buffers for one analysis; nothing is allocated after they are made, except for models of many batches.
pub struct Assembly {
    /// Element forces, all groups one after another.
    pub(super) element_forces: Vec<f64>,
    /// Tangent blocks of a batch of elements or follower loads, behind them those that are reduced to the degrees of freedom of
    /// rigid bodies.
    blocks: Vec<f64>,
    /// Curvature of the rotations of rigid bodies.
    curvature: BodyCurvature,
    /// Extrapolated stress, conjugate to the sampled strains, all groups.
    pub stress: Vec<f64>,
    /// Values of the tangent's lower triangle.
    pub values: Vec<f64>,
    /// Energies per element, all groups.
    energies: Vec<f64>,
    /// Enhanced parameters and internal variables at the end of the present step, all groups.
    new_history: Vec<f64>,
    /// Factors of the fields of prescribed strain.
    pub(super) factors: Vec<f64>,
    /// Constrained degrees of freedom, and local frames of inextensible directors at their present values.
    pub frames: LocalFrames,
    /// Places in `element_forces` (in units of nodal vectors) of the contributions to each nodal vector.
    force_sources: Lists<u32>,
}

impl Assembly {
    /// Buffers for a system.
    pub fn new(system: &System) -> Self {
        let mut out = Self::for_forces(system);
        out.blocks = vec![0.0; 9 * largest_batch(system)];
        out.values = vec![0.0; system.pattern.values()];
        out
    }

    /// Buffers for forces and energies; those of a tangent are made on demand.
    pub fn for_forces(system: &System) -> Self {
        let connectivity =
            system.groups.iter().flat_map(|group| (0..group.len()).flat_map(|e| group.vectors(e)));
        let sources = connectivity.zip(0..).map(|(&v, source): (_, u32)| (v, source));
        let [elements, forces, stresses, history] = system.offsets.last().map_or([0; 4], |last| {
            [&last.elements, &last.forces, &last.stresses, &last.history].map(|range| range.end)
        });
        Self {
            element_forces: vec![0.0; forces],
            blocks: Vec::new(),
            curvature: BodyCurvature::new(system),
            stress: vec![0.0; stresses],
            values: Vec::new(),
            energies: vec![0.0; elements],
            new_history: vec![0.0; history],
            factors: vec![0.0; system.prescribed_strains.len() + system.joints.len()],
            frames: system.frames.clone(),
            force_sources: Lists::by_key(system.vectors(), sources),
        }
    }

    /// Sets the factors of the prescribed strains and the values of the drives.
    pub(super) fn set_time(&mut self, system: &System, time: f64) {
        self.factors.iter_mut().zip(system.factors(time)).for_each(|(x, factor)| *x = factor);
    }

    /// Rotates the local frames of inextensible directors and rigid bodies to the configuration on which the forces of a motion act.
    pub fn follow(&mut self, system: &System, k: &EvaluationPoint) {
        if self.frames.rotate_with_motion() && !k.linear {
            self.frames.follow(|v| current_vector(system, &k.motion, v));
        }
    }

    /// Internal forces of a motion.
    pub fn forces(&mut self, system: &System, k: &EvaluationPoint, out: &mut [Nodal]) {
        self.set_time(system, k.time);
        for (g, group, offsets) in system.numbered_groups() {
            let k = k.of_group(system, g, &self.factors);
            group.evaluate(&k, 0, &mut self.element_forces[offsets.forces.clone()], None);
        }
        self.gather_forces(out);
    }

    /// Internal forces and the values of the tangent. With `extrapolated` the geometric stiffness uses
    /// [`stress`](Self::stress). A `prescribed` increment adds tangent times increment to the forces.
    pub fn forces_and_tangent(
        &mut self,
        system: &System,
        k: &EvaluationPoint,
        parts: &TangentCoefficients,
        extrapolated: bool,
        prescribed: Option<&[Nodal]>,
        out: &mut [Nodal],
    ) {
        self.values.resize(system.pattern.values(), 0.0);
        self.blocks.resize(9 * largest_batch(system), 0.0);
        // A single task of the thread pool: from outside, each of the many small ones would wait to be scheduled.
        let work = || {
            system.pattern.begin(parts.mass, &self.frames, &mut self.values);
            let mut batch = 0;
            self.batches(system, k, parts, (extrapolated, prescribed), |_, blocks, (frames, values)| {
                system.pattern.add(batch, blocks, parts.mass, frames, values);
                batch += 1;
            });
            system.pattern.add_body_inertia(parts.mass, &self.frames, &mut self.values);
            if !k.linear {
                system.add_centrifugal_tangent(parts, &self.frames, &mut self.values);
            }
            self.gather_forces(out);
        };
        rayon::join(work, || ());
        if self.energies.len() > MANY_BATCHES * BATCH {
            self.blocks = Vec::new();
        }
    }

    /// Internal forces of a motion; the tangent is not summed but handed over, the lower blocks of one element or
    /// follower load after the other. Otherwise like [`forces_and_tangent`](Self::forces_and_tangent).
    pub fn forces_and_blocks(
        &mut self,
        system: &System,
        k: &EvaluationPoint,
        parts: &TangentCoefficients,
        (extrapolated, prescribed): (bool, Option<&[Nodal]>),
        out: &mut [Nodal],
        mut take: impl FnMut(&[f64]) + Send,
    ) {
        self.blocks.resize(9 * largest_batch(system), 0.0);
        let work =
            || {
                let mut first = 0;
                self.batches(system, k, parts, (extrapolated, prescribed), |elements, blocks, _| {
                    match elements {
                        Some((group, members)) => {
                            let size = 9 * pairs(group.vectors_per_element());
                            blocks[..size * members.len()].chunks(size).for_each(&mut take)
                        }
                        None => {
                            let loads = system.followers[first..].iter().take(BATCH);
                            let mut at = 0;
                            for load in loads {
                                let n = 9 * pairs(load.vectors().len());
                                take(&blocks[at..at + n]);
                                at += n;
                            }
                            first += BATCH;
                        }
                    }
                });
                self.gather_forces(out);
            };
        rayon::join(work, || ());
    }

    /// Element work of [`forces_and_tangent`](Self::forces_and_tangent) alone, to measure its cost.
    pub fn element_work(
        &mut self,
        system: &System,
        k: &EvaluationPoint,
        parts: &TangentCoefficients,
        out: &mut [Nodal],
    ) {
        self.blocks.resize(9 * largest_batch(system), 0.0);
        let work = || {
            self.batches(system, k, parts, (true, None), |_, _, _| {});
            self.gather_forces(out);
        };
        rayon::join(work, || ());
    }

    /// Hands the tangent blocks of all elements to `f`, batch by batch, group by group.
    pub fn for_each_element(
        &mut self,
        system: &System,
        k: &EvaluationPoint,
        parts: &TangentCoefficients,
        mut f: impl FnMut(ElementBlocks),
    ) {
        self.blocks.resize(9 * largest_batch(system), 0.0);
        self.batches(system, k, parts, (false, None), |elements, blocks, _| {
            if let Some((group, members)) = elements {
                let own = 9 * pairs(group.vectors_per_element()) * members.len();
                f(ElementBlocks { group, first: members.start, blocks: &blocks[..own] });
            }
        });
    }

    /// Sum, over all elements, of the largest stiffness of a position (force/length): the scale of the round-off of stiffnesses that cancel.
    pub fn stiffness_of_elements(
        &mut self,
        system: &System,
        k: &EvaluationPoint,
        parts: &TangentCoefficients,
    ) -> f64 {
        let mut sum = 0.0;
        self.for_each_element(system, k, parts, |elements| {
            let n = elements.group.vectors_per_element();
            for (e, blocks) in elements.blocks.chunks(9 * pairs(n)).enumerate() {
                let vectors = elements.group.vectors(elements.first + e).iter().enumerate();
                let positions =
                    vectors.filter(|(_, v)| system.coordinates.kinds[**v as usize] == VectorKind::Position);
                // The diagonal block of the a-th vector closes the row of a + 1 blocks.
                let entries = positions.flat_map(|(a, _)| &blocks[9 * (pairs(a + 1) - 1)..][..9]);
                sum += entries.map(|x| x.abs()).fold(0.0, larger);
            }
        });
        sum
    }

    /// Evaluates the elements, then the follower loads, in the batches of the pattern, and hands group and elements of the
    /// batch (`None`: loads), the blocks, behind them the reduced ones, and the local frames and values for their sum to
    /// `take`.
    fn batches(
        &mut self,
        system: &System,
        k: &EvaluationPoint,
        parts: &TangentCoefficients,
        (extrapolated, prescribed): (bool, Option<&[Nodal]>),
        mut take: impl FnMut(Option<(&dyn ElementGroup, Range<usize>)>, &[f64], (&LocalFrames, &mut [f64])),
    ) {
        self.set_time(system, k.time);
        let Self { frames, values, blocks, .. } = self;
        for (g, group, offsets) in system.numbered_groups() {
            let m = group.vectors_per_element();
            let k = k.of_group(system, g, &self.factors);
            let stress = extrapolated.then_some(&self.stress[offsets.stresses.clone()]);
            let forces = &mut self.element_forces[offsets.forces.clone()];
            for (batch, forces) in forces.chunks_mut(3 * m * BATCH).enumerate() {
                let first = batch * BATCH;
                let members = first..first + forces.len() / (3 * m);
                let (own, reduced) = blocks.split_at_mut(9 * pairs(m) * members.len());
                let request =
                    TangentRequest { weights: parts.weights, stress, prescribed, blocks: &mut *own };
                group.evaluate(&k, first, forces, Some(request));
                let mut size = own.len();
                if let Some(reduction) = &system.reductions[g] {
                    let reduced = &mut reduced[..9 * reduction.blocks(members.clone())];
                    reduction.reduce(members.clone(), frames, own, reduced);
                    size += reduced.len();
                }
                take(Some((group, members)), &blocks[..size], (frames, values));
            }
        }
        let w = &parts.weights;
        let direction = if k.linear { 0.0 } else { w.force * w.direction };
        let factor = |load: &FollowerLoad| direction * system.factor(load.factor(), parts.time);
        let fields = FieldStiffness::of(system, &k.motion, parts);
        for first in (0..system.followers.len()).step_by(BATCH) {
            let size = load_stiffness(system, &k.motion, (first, &factor), &fields, frames, blocks);
            take(None, &blocks[..size], (frames, values));
        }
    }

    /// Adds the curvature of the unit sphere of inextensible directors under the forces `rest` that act on them from
    /// outside to the values of the tangent; in tangents that decide about stability under those of joints and springs in the last evaluation, too.
    pub fn add_curvature(
        &mut self,
        system: &System,
        k: &EvaluationPoint,
        weights: &TangentWeights,
        rest: &[Nodal],
    ) {
        if k.linear {
            return;
        }
        let Self { frames, values, element_forces, .. } = self;
        for (v, shift) in curvature(system, frames, k, weights, rest) {
            system.pattern.add_to_diagonal(v, shift, frames, values);
        }
        if !body_curvature::decides_stability(weights) || frames.dofs().unit.is_empty() {
            return;
        }
        // Shells contain the curvature under their own forces.
        let factor = weights.force * weights.direction;
        for (_, group, offsets) in system.numbered_groups().filter(|(_, g, _)| g.stresses_per_element() == 0)
        {
            let vectors = (0..group.len()).flat_map(|e| group.vectors(e));
            for (&v, force) in vectors.zip(element_forces[offsets.forces.clone()].chunks_exact(3)) {
                let v = v as usize;
                if system.coordinates.inextensible.get(v) == Some(&true) && frames.dofs().is_free(v) {
                    let along = current_vector(system, &k.motion, v).dot(&Vec3::from_column_slice(force));
                    system.pattern.add_to_diagonal(v, -factor * along, frames, values);
                }
            }
        }
    }

    /// Adds the curvature of the rotations of rigid bodies and of nodes of beams, under the forces `rest` from outside and those of the
    /// elements, with the extrapolated stress where the tangent has it; in tangents that decide about stability under those of joints
    /// and springs, too.
    pub fn add_body_curvature(
        &mut self,
        system: &System,
        k: &EvaluationPoint,
        weights: &TangentWeights,
        (extrapolated, rest): (bool, &[Nodal]),
    ) {
        if k.linear || system.dofs().triads.is_empty() {
            return;
        }
        let Self { curvature, frames, values, stress, factors, .. } = self;
        curvature.begin(frames, weights, rest);
        for (g, group, reduction) in body_curvature::elastic(system) {
            let stress = extrapolated.then_some(&stress[system.offsets[g].stresses.clone()]);
            let current = |v: u32| current_vector(system, &k.motion, v as usize);
            let k = k.of_group(system, g, factors);
            curvature.subtract((group, reduction), (&k, weights, stress), frames, current);
        }
        if body_curvature::decides_stability(weights) {
            for (g, group, reduction) in body_curvature::connections(system) {
                curvature.subtract_forces((group, reduction), &k.of_group(system, g, factors), frames);
            }
        }
        curvature.add(system, frames, values);
    }

    /// Force of an element on one of its nodal vectors in the last evaluation; `place` counts nodal vectors over all elements, one group
    /// after another.
    pub(super) fn element_force(&self, place: u32) -> Nodal {
        let at = 3 * place as usize;
        std::array::from_fn(|i| self.element_forces[at + i])
    }

    pub(super) fn gather_forces(&self, out: &mut [Nodal]) {
        out.par_iter_mut().with_min_len(256).enumerate().for_each(|(v, f)| {
            *f = [0.0; 3];
            for &source in self.force_sources.of(v) {
                let at = 3 * source as usize;
                for i in 0..3 {
                    f[i] += self.element_forces[at + i];
                }
            }
        });
    }

    /// First shell whose last forces are not finite, as text: its material law could not be evaluated.
    pub fn without_answer(&self, system: &System) -> Option<String> {
        for (g, group, offsets) in system.numbered_groups() {
            let forces = &self.element_forces[offsets.forces.clone()];
            let elements = forces.chunks(3 * group.vectors_per_element());
            let broken = elements.enumerate().find(|(_, f)| !f.iter().all(|f| f.is_finite()));
            if let Some((element, _)) = broken {
                let shell = system.shells.iter().find(|s| s.groups.contains(&g) && s.member == element)?;
                let (label, c) = (system.quad_label(shell.quad), system.geometry(shell).centre());
                return Some(format!("element {label} at ({:.4}, {:.4}, {:.4})", c.x, c.y, c.z));
            }
        }
        None
    }

    /// Values of the mass matrix of the free degrees of freedom.
    pub fn mass_values(&self, system: &System, values: &mut [f64]) {
        system.pattern.mass_values(&self.frames, values);
    }

    /// Adds a multiple of the mass to the tangent: `part` of the largest ratio of a stiffness to its mass.
    pub fn add_mass_shift(&mut self, system: &System, part: f64) {
        let (pattern, mut mass) = (system.tangent_pattern(), vec![0.0; self.values.len()]);
        self.mass_values(system, &mut mass);
        let diagonals = pattern.diagonal(&self.values).zip(pattern.diagonal(&mass));
        let ratio = diagonals.filter(|(_, m)| *m > 0.0).map(|(k, m)| (k / m).abs()).fold(0.0, larger);
        self.values.iter_mut().zip(&mass).for_each(|(k, m)| *k += part * ratio * m);
    }

    /// Sets the extrapolated stress to that of a motion.
    pub fn reset_stress(&mut self, system: &System, k: &EvaluationPoint) {
        self.set_time(system, k.time);
        for (g, group, offsets) in system.numbered_groups() {
            let stress = &mut self.stress[offsets.stresses.clone()];
            group.stresses(&k.of_group(system, g, &self.factors), stress);
        }
    }

    /// Extrapolates the stress along an increment from a motion.
    pub fn extrapolate(
        &mut self,
        system: &System,
        k: &EvaluationPoint,
        increment: &[Nodal],
        weights: &TangentWeights,
    ) {
        for (g, group, offsets) in system.numbered_groups() {
            let stress = &mut self.stress[offsets.stresses.clone()];
            group.extrapolate(&k.of_group(system, g, &self.factors), increment, weights, stress);
        }
    }

    /// Commits the history variables at the end of a converged step, from `history` at its start: `history` becomes that
    /// at its end. Returns the energy dissipated in the step.
    pub fn commit(&mut self, system: &System, motion: Motion, time: f64, history: &mut Vec<f64>) -> f64 {
        let dissipated =
            self.find_history(system, &EvaluationPoint::new(system, motion, time, history.as_slice()));
        std::mem::swap(history, &mut self.new_history);
        dissipated
    }

    /// Computes the history variables after a step to a motion; returns the energy that would be dissipated in it.
    fn find_history(&mut self, system: &System, k: &EvaluationPoint) -> f64 {
        if self.new_history.is_empty() {
            return 0.0;
        }
        self.set_time(system, k.time);
        let mut dissipated = 0.0;
        for (g, group, offsets) in system.numbered_groups() {
            let history = &mut self.new_history[offsets.history.clone()];
            dissipated += group.update_history(&k.of_group(system, g, &self.factors), history);
        }
        dissipated
    }

    /// Work of prescribed strains that change with time while the model moves from `old` to `new` (displacement and
    /// time): the gain of stored and dissipated energy beyond the work of the internal forces.
    ///
    /// Let Π(u, t) be the energy needed to deform the model to u under the prescribed strains of the time t. The
    /// internal forces at the midpoint of the step do the work Π(u₁, ½) − Π(u₀, ½). The remaining change of Π is
    /// `Π(u₁, t₁) − Π(u₁, ½) + Π(u₀, ½) − Π(u₀, t₀)`: exact for the energy–momentum scheme, of second order for the others.
    /// Where materials yield the two half steps lie on both sides of the kink between loading and unloading, and the
    /// balance is of first order.
    pub fn prescribed_strain_work(
        &mut self,
        system: &System,
        history: &[f64],
        old: (&[Nodal], f64),
        new: (&[Nodal], f64),
    ) -> f64 {
        let factors =
            |time: f64| system.prescribed_strains.iter().map(move |field| system.factor(&field.factor, time));
        let middle = 0.5 * (old.1 + new.1);
        if factors(old.1).eq(factors(middle)) && factors(middle).eq(factors(new.1)) {
            return 0.0;
        }
        let mut change = |u: &[Nodal], from: f64, to: f64| {
            let mut energy_at = |time| {
                let k = EvaluationPoint::at_rest(system, u, time, history);
                self.strain_energy(system, &k) + self.find_history(system, &k)
            };
            energy_at(to) - energy_at(from)
        };
        change(old.0, old.1, middle) + change(new.0, middle, new.1)
    }

    /// Strain energy at the end of a motion. In a geometrically linear evaluation of displacements it is ½ uᵀKu, summed
    /// from strains without cancellation.
    pub fn strain_energy(&mut self, system: &System, k: &EvaluationPoint) -> f64 {
        self.set_time(system, k.time);
        for (g, group, offsets) in system.numbered_groups() {
            let energies = &mut self.energies[offsets.elements.clone()];
            group.energies(&k.of_group(system, g, &self.factors), energies);
        }
        self.energies.iter().sum()
    }

    /// Work that actuators do on the model in a step.
    pub fn work_of_actuators(&self, system: &System, k: &EvaluationPoint) -> f64 {
        if !system.has_actuators() {
            return 0.0;
        }
        let of = |(g, group, _): (usize, &dyn ElementGroup, &GroupOffsets)| {
            group.work_of_actuators(&k.of_group(system, g, &self.factors))
        };
        system.numbered_groups().map(of).sum()
    }

    /// Power that rate damping dissipates.
    pub fn dissipated_power(&mut self, system: &System, k: &EvaluationPoint) -> f64 {
        for (g, group, offsets) in system.numbered_groups() {
            let power = &mut self.energies[offsets.elements.clone()];
            group.dissipation(&k.of_group(system, g, &self.factors), power);
        }
        self.energies.iter().sum()
    }
}

/// Curvature of the unit sphere of each inextensible director, under the forces `rest` that act on it from outside.
pub fn curvature<'a>(
    system: &'a System,
    frames: &'a LocalFrames,
    k: &'a EvaluationPoint,
    weights: &'a TangentWeights,
    rest: &'a [Nodal],
) -> impl Iterator<Item = (usize, f64)> + 'a {
    frames.dofs().unit.iter().map(|unit| {
        let v = unit.vector as usize;
        (v, weights.direction * current_vector(system, &k.motion, v).dot(&Vec3::from(rest[v])))
    })
}

/// Number of blocks in the lower triangle of `vectors` nodal vectors.
pub(super) fn pairs(vectors: usize) -> usize {
    vectors * (vectors + 1) / 2
}

/// Largest number of blocks in a batch of elements or follower loads, with the reduced ones.
fn largest_batch(system: &System) -> usize {
    let reduced = |reduction: Option<&Reduction>, first: usize| {
        reduction.map_or(0, |reduction| reduction.blocks(first..first + BATCH))
    };
    let groups = system.groups.iter().zip(&system.reductions).map(|(g, reduction)| {
        let own = g.len().min(BATCH) * pairs(g.vectors_per_element());
        let starts = (0..g.len()).step_by(BATCH);
        own + starts.map(|first| reduced(reduction.as_ref(), first)).max().unwrap_or(0)
    });
    let loads = system.followers.chunks(BATCH).enumerate().map(|(batch, loads)| {
        let own: usize = loads.iter().map(|load| pairs(load.vectors().len())).sum();
        own + reduced(system.reduction_of_followers.as_ref(), batch * BATCH)
    });
    groups.chain(loads).max().unwrap_or(0)
}
