//! Springs with dampers between two points.
//!
//! The energy of a spring is a function of the squared distance of its ends, V(L²). The energy–momentum scheme takes its
//! discrete gradient (O. Gonzalez, *Time integration and discrete Hamiltonian systems*, J. Nonlinear Sci. 6 (1996) 449–467):
//! with the lengths L₀ and L₁ at the ends of a step and the vector x between the points in its middle the force
//!
//! ```text
//! F = [k (L₀ + L₁ − 2 l) + 2 d (L₁ − L₀)/Δt] / (L₀ + L₁) · x
//! ```
//!
//! does the work V₁ − V₀ + d (L₁ − L₀)²/Δt exactly. With the mean force F̄ of another [law](SpringLaw) over the step the force is
//! `2 F̄/(L₀ + L₁) · x`, of which this is the linear case.
//!
//! A spring [across an axis](Across) has the distance of a point from a line in the place of the length.

use super::joint::current;
use super::spring_across::Across;
use super::{Attachment, SpringLaw};
use crate::element::power_series::PowerSeries;
use crate::element::{
    ElementGroup, GroupPoint, Motion, Nodal, StressIncrement, TangentRequest, TangentWeights,
};
use crate::load::Partials;
use crate::{Mat3, Vec3};

/// Spring with a damper between two points.
#[derive(Debug, Clone, PartialEq)]
pub struct Spring {
    /// Nodal vectors of both points.
    vectors: Vec<u32>,
    measure: Measure,
    /// Whether one of the points is in the ground.
    grounded: bool,
    law: SpringLaw,
}

/// Meaning of the length of a spring.
#[derive(Debug, Clone, PartialEq)]
enum Measure {
    /// Distance of two points: weights of the nodal vectors in the vector between them, and its constant part.
    Points(Vec<f64>, Vec3),
    /// Distance of a point from a line.
    Across(Box<Across>),
}

/// Motion of a spring.
struct Stretch {
    /// Lengths at both ends of the motion.
    lengths: [f64; 2],
    /// Rate of the length.
    rate: f64,
    /// Vector whose size is the length, where the force acts: that between the points, or the components across the axis.
    x: Vec3,
}

impl Spring {
    /// Spring across an axis: its length is the distance of a point from the line that the axis is.
    pub fn across(across: Across, grounded: bool, law: SpringLaw) -> Self {
        let vectors = across.vectors.clone();
        Self { vectors, measure: Measure::Across(Box::new(across)), grounded, law }
    }

    /// Spring between two points of bodies, nodes or the ground, with this force law in its length.
    pub fn new([a, b]: [&Attachment; 2], law: SpringLaw) -> Self {
        let (mut vectors, mut weights): (Vec<u32>, Vec<f64>) = (Vec::new(), Vec::new());
        for (terms, sign) in [(&a.terms, 1.0), (&b.terms, -1.0)] {
            for &(v, w) in terms {
                match vectors.iter().position(|&x| x == v) {
                    Some(i) => weights[i] += sign * w,
                    None => {
                        vectors.push(v);
                        weights.push(sign * w);
                    }
                }
            }
        }
        let grounded = a.terms.is_empty() || b.terms.is_empty();
        Self { vectors, measure: Measure::Points(weights, a.constant - b.constant), grounded, law }
    }

    /// Vector between the points, or across the axis, for given nodal vectors.
    fn between(&self, value: impl Fn(usize) -> Vec3) -> Vec3 {
        match &self.measure {
            Measure::Points(weights, constant) => self.sum(weights, *constant, value),
            Measure::Across(across) => across.value(&across.few(value)),
        }
    }

    /// Sum of the weighted nodal vectors, which begins with `first`.
    fn sum(&self, weights: &[f64], first: Vec3, value: impl Fn(usize) -> Vec3) -> Vec3 {
        self.vectors.iter().zip(weights).fold(first, |x, (&v, w)| x + value(v as usize) * *w)
    }

    /// The spring with another force law.
    pub fn with_law(self, law: SpringLaw) -> Self {
        Self { law, ..self }
    }

    /// Distance of the points, or of the second one from the axis, for given nodal vectors.
    pub fn length(&self, value: impl Fn(usize) -> Vec3) -> f64 {
        self.between(value).norm()
    }

    /// Change of the vector between the points, or across the axis, where nodal vectors have these values and changes.
    fn change(&self, value: impl Fn(usize) -> Vec3, change: impl Fn(usize) -> Vec3) -> Vec3 {
        match &self.measure {
            // Small changes must not be rounded to the size of the places.
            Measure::Points(weights, _) => self.sum(weights, Vec3::zeros(), change),
            Measure::Across(across) => across.change(&across.few(value), &across.few(change)),
        }
    }

    /// Whether the points pass each other between two configurations, where a force acts between coinciding points: it turns round.
    pub fn turns_round(
        &self,
        before: impl Fn(usize) -> Vec3,
        after: impl Fn(usize) -> Vec3,
        time: f64,
    ) -> bool {
        let pulls = self.law.force([0.0; 2], 0.0, time).value != 0.0;
        pulls && self.between(before).dot(&self.between(after)) < 0.0
    }

    fn motion(&self, k: &GroupPoint) -> Stretch {
        let at = |u: &[Nodal], v: usize| Vec3::from(k.reference[v]) + Vec3::from(u[v]);
        match k.motion {
            Motion::State { u, velocity } => {
                let x = self.between(|v| at(u, v));
                let length = x.norm();
                let rate = velocity.map_or(0.0, |v| {
                    let speed = self.change(|n| at(u, n), |n| Vec3::from(v[n]));
                    if length > 0.0 { speed.dot(&x) / length } else { 0.0 }
                });
                Stretch { lengths: [length; 2], rate, x }
            }
            Motion::Step { old, new, dt } => {
                let [before, after] = [old, new].map(|u| self.between(|v| at(u, v)));
                let lengths = [before.norm(), after.norm()];
                Stretch { lengths, rate: (lengths[1] - lengths[0]) / dt, x: (before + after) * 0.5 }
            }
        }
    }

    /// Length, and force that draws the points together, for given nodal vectors and their rates at a time.
    pub fn length_and_force(
        &self,
        value: impl Fn(usize) -> Vec3,
        rate: impl Fn(usize) -> Vec3,
        time: f64,
    ) -> [f64; 2] {
        let x = self.between(&value);
        let length = x.norm();
        let speed = self.change(value, rate);
        let lengthening = if length > 0.0 { speed.dot(&x) / length } else { 0.0 };
        [length, self.law.force([length; 2], lengthening, time).value]
    }

    /// Length, and force that draws the points together at the mean rate of a step of this length, which ends at a time. The force has
    /// the length at the end; nodal vectors have these values at the start and at the end of the step.
    pub fn length_and_force_of_step(
        &self,
        [start, end]: [&dyn Fn(usize) -> Vec3; 2],
        dt: f64,
        time: f64,
    ) -> [f64; 2] {
        let [before, length] = [start, end].map(|value| self.length(value));
        [length, self.law.force([length; 2], (length - before) / dt, time).value]
    }

    /// Weights of the nodal vectors in the vector between the points, and stiffness and free length of a linear spring; `None` of springs across an axis or
    /// with another law.
    pub(super) fn linear(&self) -> Option<(&[f64], [f64; 2])> {
        match &self.measure {
            Measure::Points(weights, _) => Some((weights, self.law.linear_constants()?)),
            Measure::Across(_) => None,
        }
    }

    /// Vector between the points for given displacements.
    pub(super) fn at(&self, reference: &[Nodal], u: &[Nodal]) -> Vec3 {
        self.between(|v| Vec3::from(reference[v]) + Vec3::from(u[v]))
    }

    /// Vector between the points at an evaluation point.
    pub(super) fn now(&self, k: &GroupPoint) -> Vec3 {
        self.between(|v| current(k, v as u32))
    }

    /// Change of the vector between the points with a field of all nodal vectors.
    pub(super) fn change_of_points(&self, weights: &[f64], field: &[Nodal]) -> Vec3 {
        self.sum(weights, Vec3::zeros(), |v| Vec3::from(field[v]))
    }

    /// Force at lengths and a rate, with the part of the force in the reference configuration that acts.
    fn force(&self, k: &GroupPoint, lengths: [f64; 2], rate: f64) -> Partials {
        let mut force = self.law.force(lengths, rate, k.time);
        if let Some((_, missing)) = self.missing_preload(k) {
            force.value -= missing;
        }
        force
    }

    /// Length in the reference configuration and the part of the force there that does not act yet; `None` where all of it acts.
    fn missing_preload(&self, k: &GroupPoint) -> Option<(f64, f64)> {
        (k.preload != 1.0).then(|| {
            let start = self.length(|v| Vec3::from(k.reference[v]));
            (start, (1.0 - k.preload) * self.law.force([start; 2], 0.0, k.time).value)
        })
    }

    /// Writes the forces on the nodal vectors that do the work of a force on the vector between the points, or across the axis.
    fn write_forces(&self, k: &GroupPoint, force: &Vec3, out: &mut [f64]) {
        match &self.measure {
            Measure::Points(weights, _) => {
                for (out, w) in out.chunks_mut(3).zip(weights) {
                    out.copy_from_slice((force * *w).as_slice());
                }
            }
            Measure::Across(across) => {
                let forces = across.forces(&across.few(|v| current(k, v as u32)), force);
                for (out, f) in out.chunks_mut(3).zip(&forces) {
                    out.copy_from_slice(f.as_slice());
                }
            }
        }
    }

    /// Writes the lower blocks of a stiffness against changes of the vector between the points, or across the axis; a `force` on it bends them.
    fn write_blocks(&self, k: &GroupPoint, (stiffness, force): (&Mat3, &Vec3), blocks: &mut [f64]) {
        let weights = match &self.measure {
            Measure::Points(weights, _) => weights,
            Measure::Across(across) => {
                return across.write_blocks(
                    &across.few(|v| current(k, v as u32)),
                    (stiffness, force),
                    blocks,
                );
            }
        };
        let mut blocks = blocks.chunks_mut(9);
        for (a, w) in weights.iter().enumerate() {
            for other in &weights[..=a] {
                let Some(out) = blocks.next() else { return };
                out.iter_mut().enumerate().for_each(|(i, out)| *out = stiffness[(i / 3, i % 3)] * w * other);
            }
        }
    }

    /// Force `force` per vector between the points; where they coincide, its limit.
    fn intensity(&self, [before, after]: [f64; 2], force: &Partials) -> f64 {
        let sum = before + after;
        if sum > 0.0 {
            2.0 * force.value / sum
        } else if force.value == 0.0 && (self.law.free() == 0.0 || force.by_position == 0.0) {
            force.by_position
        } else {
            f64::NAN
        }
    }
}

/// Springs of as many nodal vectors each.
pub struct SpringGroup {
    members: Vec<Spring>,
    vectors: usize,
}

impl SpringGroup {
    /// Name of the groups.
    pub const NAME: &str = "spring";

    /// Groups of all springs, one for each number of nodal vectors.
    pub fn groups(springs: &[Spring]) -> Vec<Box<dyn ElementGroup>> {
        let mut sizes: Vec<usize> = springs.iter().map(|spring| spring.vectors.len()).collect();
        sizes.sort_unstable();
        sizes.dedup();
        let of_size = |size: usize| -> Box<dyn ElementGroup> {
            let members = springs.iter().filter(|spring| spring.vectors.len() == size).cloned().collect();
            Box::new(Self { members, vectors: size })
        };
        sizes.into_iter().filter(|size| *size > 0).map(of_size).collect()
    }

    /// The springs of the group.
    pub(super) fn springs(&self) -> impl Iterator<Item = &Spring> {
        self.members.iter()
    }
}

impl ElementGroup for SpringGroup {
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
        self.members.iter().any(|spring| spring.law.depends_on_rate())
    }

    fn has_actuators(&self) -> bool {
        self.members.iter().any(|spring| spring.law.depends_on_time())
    }

    fn vectors_per_element(&self) -> usize {
        self.vectors
    }

    fn power_series(&self) -> Option<&dyn PowerSeries> {
        self.members.iter().all(|spring| spring.linear().is_some()).then_some(self as &dyn PowerSeries)
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
            let spring = &self.members[first + e];
            let Stretch { lengths, rate, x } = spring.motion(k);
            let spring_force = spring.force(k, lengths, rate);
            let intensity = spring.intensity(lengths, &spring_force);
            spring.write_forces(k, &(x * intensity), out);
            let Some(request) = &mut tangent else { continue };
            let TangentWeights { stress, direction, force, rate, .. } = request.weights;
            let axis = x.try_normalize(0.0).unwrap_or_else(Vec3::zeros);
            let along = axis * axis.transpose();
            let across = Mat3::identity() - along;
            let stiffness = along * (stress * spring_force.by_position + rate * spring_force.by_rate)
                + across * (direction * intensity);
            let size = 9 * n * (n + 1) / 2;
            let bent = x * (intensity * direction * force);
            let blocks = &mut request.blocks[e * size..(e + 1) * size];
            spring.write_blocks(k, (&(stiffness * force), &bent), blocks);
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
        for (spring, (out, blocks)) in self.members[first..].iter().zip(of_each) {
            let Stretch { lengths, rate, x } = spring.motion(k);
            let axis = x.try_normalize(0.0).unwrap_or_else(Vec3::zeros);
            let change = spring.change(|v| current(k, v as u32), |v| Vec3::from(increment.displacements[v]));
            let tension = spring.law.force(lengths, rate, k.time).by_position * axis.dot(&change);
            // Between coinciding points the force per length of a spring does not change.
            let (force, intensity) = if x == Vec3::zeros() {
                (change * spring.law.force(lengths, rate, k.time).by_position, 0.0)
            } else {
                (axis * tension, tension / x.norm())
            };
            spring.write_forces(k, &force, out);
            let across = Mat3::identity() - axis * axis.transpose();
            spring.write_blocks(k, (&(across * intensity), &force), blocks);
        }
    }

    fn material_energies(&self, k: &GroupPoint, motion: &[Nodal], energies: &mut [f64]) {
        for (spring, energy) in self.members.iter().zip(energies) {
            let Stretch { lengths, rate, x } = spring.motion(k);
            let axis = x.try_normalize(0.0).unwrap_or_else(Vec3::zeros);
            let change = axis.dot(&spring.change(|v| current(k, v as u32), |v| Vec3::from(motion[v])));
            *energy = 0.5 * spring.law.force(lengths, rate, k.time).by_position * change * change;
        }
    }

    fn energies(&self, k: &GroupPoint, energies: &mut [f64]) {
        for (spring, energy) in self.members.iter().zip(energies) {
            let length = spring.motion(k).lengths[1];
            let missing = spring.missing_preload(k).map_or(0.0, |(start, force)| force * (length - start));
            *energy = spring.law.energy(length) - missing;
        }
    }

    fn dissipation(&self, k: &GroupPoint, power: &mut [f64]) {
        for (spring, power) in self.members.iter().zip(power) {
            let Stretch { lengths, rate, .. } = spring.motion(k);
            *power = spring.law.dissipation(lengths, rate, k.time);
        }
    }

    fn work_of_actuators(&self, k: &GroupPoint) -> f64 {
        let of = |spring: &Spring| {
            let Stretch { lengths, rate, .. } = spring.motion(k);
            spring.law.work(lengths, rate, k.time)
        };
        self.members.iter().filter(|spring| spring.law.depends_on_time()).map(of).sum()
    }

    fn reason_without_forces(&self, k: &GroupPoint, element: usize) -> Option<String> {
        let spring = &self.members[element];
        let Stretch { lengths, rate, .. } = spring.motion(k);
        spring.law.reason_without_force(lengths, rate, k.time)
    }

    fn falling_force(&self, k: &GroupPoint) -> Option<String> {
        self.members.iter().find_map(|spring| spring.law.falls(spring.motion(k).lengths[1], k.time))
    }

    fn pole_in_step(&self, k: &GroupPoint, start: f64) -> Option<String> {
        self.members.iter().find_map(|spring| {
            let Stretch { lengths, rate, .. } = spring.motion(k);
            spring.law.pole(lengths, rate, [start, k.time])
        })
    }
}
