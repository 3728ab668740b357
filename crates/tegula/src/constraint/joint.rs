//! Joints as contributions: constraint forces `Gᵀλ`, and the weight `γ GᵀG` of the augmented Lagrangian.

use std::ops::Range;
use std::sync::Arc;

use super::joints::RelativeAngle;
use super::{Attachment, CoordinateLaw, DriveValue, Quantity, Row};
use crate::Vec3;
use crate::element::power_series::{KnownOrders, PowerSeries};
use crate::element::{ElementGroup, GroupPoint, Motion, Nodal, TangentRequest, TangentWeights};
use crate::load::TimeFunction;

/// Most nodal vectors of a joint of bodies: two rigid bodies have eight, and gears contain the directors of three bodies.
pub const MOST_VECTORS: usize = 9;
/// Most nodal vectors of a [distributing coupling](super::distributing), whose constraints couple all of them with each other.
pub const MOST_COUPLED_VECTORS: usize = 1024;

/// Values at the nodal vectors of a joint or a spring.
pub(super) type Few = [Vec3; MOST_VECTORS];

/// Values at some nodal vectors; zero behind them.
pub(super) fn few(vectors: &[u32], value: impl Fn(u32) -> Vec3) -> Few {
    std::array::from_fn(|i| vectors.get(i).map_or_else(Vec3::zeros, |&v| value(v)))
}

/// A joint: constraints of one pair of bodies, nodes or the ground.
#[derive(Debug, Clone, PartialEq)]
pub struct Joint {
    /// Name of the joint in the model.
    pub name: String,
    /// Nodal vectors that the constraints contain.
    pub vectors: Vec<u32>,
    /// Whether each of the vectors belongs to the first end of the joint.
    pub of_first: Vec<bool>,
    /// Point of the joint, fixed in its second end, or in the first one where the second is the ground.
    pub point: Attachment,
    /// Right-handed axes fixed in its second end, or in the first one where the second is the ground or has no axes: the third one is the axis of the
    /// joint. `None` where neither end has axes.
    pub axes: Option<[Attachment; 3]>,
    /// Constraints.
    pub rows: Vec<Row>,
    /// Number of the first constraint among those of all joints.
    pub first: usize,
    /// Number of the joint.
    pub number: usize,
    /// Drive of the joint, if it has one.
    pub drive: Option<Drive>,
    /// Part that the joint has in the analysis step.
    pub role: Role,
    /// Whether the joint has constraints that it has not had in the step before.
    pub engages: bool,
    /// Friction and stops of its relative coordinate, whose constraint is the last one in steps in which the law acts.
    pub law: Option<Box<CoordinateLaw>>,
    /// Angle of the first side of a gear, whose turns the state counts.
    pub counted: Option<Box<RelativeAngle>>,
}

/// Part that a joint has in an analysis step.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Role {
    /// Constraints of its kind.
    #[default]
    Acting,
    /// No constraints.
    Released,
    /// Constraints of its kind, and behind them those that hold what it leaves free.
    Locked,
}

/// Prescribed motion of a joint: angle (rad) or length that changes by a multiple of the change of an amplitude.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drive {
    /// Index of the amplitude.
    pub amplitude: usize,
    /// Angle or length at amplitude 1.
    pub value: f64,
    /// Angle or length where the analysis step starts, less that of the amplitude there.
    pub offset: f64,
}

impl Drive {
    /// Value at a time with its rates.
    pub fn at(&self, amplitudes: &[TimeFunction], time: f64) -> DriveValue {
        let Some(amplitude) = amplitudes.get(self.amplitude) else {
            let value = f64::NAN;
            return DriveValue { value, rate: value, acceleration: value };
        };
        DriveValue {
            value: self.value_at(amplitudes, time),
            rate: self.value * amplitude.rate(time),
            acceleration: self.value * amplitude.acceleration(time),
        }
    }

    /// Value at a time.
    pub fn value_at(&self, amplitudes: &[TimeFunction], time: f64) -> f64 {
        amplitudes
            .get(self.amplitude)
            .map_or(f64::NAN, |amplitude| self.offset + self.value * amplitude.value(time))
    }
}

impl Joint {
    /// Present place of the joint, for given nodal vectors.
    pub fn place(&self, value: impl Fn(u32) -> Vec3) -> Vec3 {
        self.point.value(value)
    }

    /// Value of the joint's drive, of those of all joints; 0 for a joint without one.
    pub fn drive_value(&self, drives: &[f64]) -> f64 {
        // A drive whose value is not known must not look like one at rest.
        if self.drive.is_none() { 0.0 } else { drives.get(self.number).copied().unwrap_or(f64::NAN) }
    }

    /// Lets the drive begin where the joint stands at the start of an analysis step, with the nodal vectors `current`.
    pub fn start_drive(&mut self, amplitudes: &[TimeFunction], current: impl Fn(u32) -> Vec3) {
        let v: Vec<Vec3> = self.vectors.iter().map(|&v| current(v)).collect();
        let stands = self.rows.first().map_or(0.0, |row| row.driven_value(&v));
        if let Some(drive) = &mut self.drive {
            let amplitude = amplitudes.get(drive.amplitude).map_or(f64::NAN, |a| a.value(0.0));
            drive.offset = stands - drive.value * amplitude;
        }
    }

    /// Lets gears mesh where they stand at the start of an analysis step, with the nodal vectors `current` and the first angle `earlier`.
    pub fn mesh(&mut self, earlier: f64, current: impl Fn(u32) -> Vec3) {
        let v: Vec<Vec3> = self.vectors.iter().map(|&v| current(v)).collect();
        self.rows.iter_mut().for_each(|row| row.mesh(&v, earlier));
    }

    /// Constraint forces `−Gᵀλ` on the nodal vectors of the joint, with the values `v` of these and the multipliers of its constraints,
    /// from the constraint `first` on. A drive has the value at which the joint stands.
    pub fn forces_from(&self, first: usize, v: &[Vec3], multipliers: &[f64]) -> Vec<Vec3> {
        let stands = match self.drive {
            Some(_) => self.rows.first().map_or(0.0, |row| row.driven_value(v)),
            None => 0.0,
        };
        let mut out = vec![Vec3::zeros(); v.len()];
        for (row, multiplier) in self.rows.iter().zip(multipliers).skip(first) {
            row.add_gradient(-multiplier, v, stands, &mut out);
        }
        out
    }

    /// Gap of the constraints where the nodal vectors have the values `v` \[length, rad\]: distance by which points miss each other, and
    /// angle by which axes do. Drives begin where their joint stands, gears mesh there, and have none.
    pub fn gap(&self, v: &[Vec3]) -> [f64; 2] {
        let mut squares = [0.0; 2];
        for row in self.rows.iter().filter(|_| self.drive.is_none() && self.counted.is_none()) {
            let value = row.value(v, 0.0);
            match row.keeps {
                Quantity::Position => squares[0] += value * value,
                Quantity::Axes => squares[1] += value * value,
                Quantity::Distance(length) => {
                    squares[0] += ((length * length + 2.0 * value).abs().sqrt() - length).powi(2);
                }
            }
        }
        [squares[0].sqrt(), squares[1].sqrt().min(1.0).asin()]
    }

    /// Adds nodal vectors that the constraints of an analysis step contain, and those of the joint's kind may not.
    pub fn add_vectors(&mut self, vectors: &[u32], of_first: bool) {
        for &vector in vectors.iter().filter(|v| !self.vectors.contains(v)).collect::<Vec<_>>() {
            self.vectors.push(vector);
            self.of_first.push(of_first);
        }
    }

    /// Result of an evaluation with the values of the joint's nodal vectors and as many zeros for a gradient; both lie on the
    /// stack, as time steps allocate nothing.
    pub fn with_vectors<R>(
        &self,
        value: impl Fn(usize) -> Vec3,
        evaluate: impl FnOnce(&[Vec3], &mut [Vec3]) -> R,
    ) -> R {
        if self.vectors.len() <= MOST_VECTORS {
            self.with_arrays::<MOST_VECTORS, R>(value, evaluate)
        } else {
            self.with_many_vectors(value, evaluate)
        }
    }

    /// Evaluation with the large arrays of a coupling, apart from that of all other joints.
    #[inline(never)]
    fn with_many_vectors<R>(
        &self,
        value: impl Fn(usize) -> Vec3,
        evaluate: impl FnOnce(&[Vec3], &mut [Vec3]) -> R,
    ) -> R {
        self.with_arrays::<MOST_COUPLED_VECTORS, R>(value, evaluate)
    }

    fn with_arrays<const N: usize, R>(
        &self,
        value: impl Fn(usize) -> Vec3,
        evaluate: impl FnOnce(&[Vec3], &mut [Vec3]) -> R,
    ) -> R {
        let n = self.vectors.len();
        let (mut vectors, mut gradient) = ([Vec3::zeros(); N], [Vec3::zeros(); N]);
        vectors.iter_mut().zip(&self.vectors).for_each(|(x, &v)| *x = value(v as usize));
        evaluate(&vectors[..n], &mut gradient[..n])
    }

    /// Constraints without that of the joint's relative coordinate, which its force law decides on.
    pub fn constraints(&self) -> &[Row] {
        &self.rows[..self.rows.len() - usize::from(self.law_row().is_some())]
    }

    /// Law of the relative coordinate, where the joint has one in the analysis step, with the number of its constraint among those of all
    /// joints.
    pub fn law_row(&self) -> Option<(usize, &CoordinateLaw)> {
        let law = self.law.as_deref().filter(|law| law.acts)?;
        Some((self.multipliers().end.checked_sub(1)?, law))
    }

    /// Numbers of the joint's constraints among those of all joints.
    pub fn multipliers(&self) -> Range<usize> {
        self.first..self.first + self.rows.len()
    }
}

/// Joints of as many nodal vectors each. Their forces act in the configuration of the motion: in the middle of a step for
/// the energy–momentum scheme, where constraints that do not depend on time do no work, because
/// `G(q_mid)(q₁ − q₀) = g₁ − g₀` holds exactly for quadratic g, and for angles with their discrete gradient.
pub struct JointGroup {
    joints: Arc<Vec<Joint>>,
    members: Vec<usize>,
    vectors: usize,
}

impl JointGroup {
    /// Name of groups of joints.
    pub const NAME: &'static str = "joint";

    /// Groups of all joints, one for each number of nodal vectors.
    pub fn groups(joints: &Arc<Vec<Joint>>) -> Vec<Box<dyn ElementGroup>> {
        let mut sizes: Vec<usize> = joints.iter().map(|joint| joint.vectors.len()).collect();
        sizes.sort_unstable();
        sizes.dedup();
        let of_size = |size: usize| -> Box<dyn ElementGroup> {
            let members = (0..joints.len()).filter(|&j| joints[j].vectors.len() == size).collect();
            Box::new(Self { joints: Arc::clone(joints), members, vectors: size })
        };
        sizes.into_iter().map(of_size).collect()
    }
}

/// Adds `weight · g gᵀ` to the lower blocks of a joint, for the gradient g of a constraint.
fn augment(gradient: &[Vec3], weight: f64, blocks: &mut [f64]) {
    let mut blocks = blocks.chunks_exact_mut(9);
    for (a, g) in gradient.iter().enumerate() {
        for h in &gradient[..=a] {
            let Some(block) = blocks.next() else { return };
            for (i, x) in block.iter_mut().enumerate() {
                *x += weight * g[i / 3] * h[i % 3];
            }
        }
    }
}

/// Nodal vector in the configuration in which the forces of a motion act.
pub(super) fn current(k: &GroupPoint, vector: u32) -> Vec3 {
    let v = vector as usize;
    let x = Vec3::from(k.reference[v]);
    match k.motion {
        Motion::State { u, .. } => x + Vec3::from(u[v]),
        Motion::Step { old, new, .. } => x + (Vec3::from(old[v]) + Vec3::from(new[v])) * 0.5,
    }
}

/// Half of the motion of a nodal vector, from the configuration in which its forces act to the end; zero for a state.
pub fn half_motion(motion: &Motion, vector: usize) -> Vec3 {
    match motion {
        Motion::State { .. } => Vec3::zeros(),
        Motion::Step { old, new, .. } => (Vec3::from(new[vector]) - Vec3::from(old[vector])) * 0.5,
    }
}

impl ElementGroup for JointGroup {
    fn name(&self) -> &'static str {
        Self::NAME
    }

    fn len(&self) -> usize {
        self.members.len()
    }

    fn vectors(&self, element: usize) -> &[u32] {
        &self.joints[self.members[element]].vectors
    }

    fn acts_on_ground(&self) -> bool {
        true
    }

    fn vectors_per_element(&self) -> usize {
        self.vectors
    }

    fn power_series(&self) -> Option<&dyn PowerSeries> {
        let mut joints = self.members.iter().map(|&j| &self.joints[j]);
        joints.all(|joint| joint.rows.iter().all(Row::is_quadratic)).then_some(self)
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
            let joint = &self.joints[self.members[first + e]];
            let size = 9 * n * (n + 1) / 2;
            let blocks = tangent.as_mut().map(|t| (t.weights, &mut t.blocks[e * size..][..size]));
            joint.with_vectors(
                |v| current(k, v as u32),
                |v, gradient| joint.evaluate(k, (v, gradient), out, blocks),
            );
        }
    }
}

impl JointGroup {
    /// Writes the sums of `ν·g″ x` of the joints for multipliers ν and fields x.
    fn write_changes<'a>(
        &self,
        parts: impl Iterator<Item = (&'a [f64], &'a [Nodal])> + Clone,
        forces: &mut [f64],
    ) {
        for (out, &j) in forces.chunks_exact_mut(3 * self.vectors).zip(&self.members) {
            let joint = &self.joints[j];
            out.fill(0.0);
            for (multipliers, field) in parts.clone() {
                joint.with_vectors(
                    |v| Vec3::from(field[v]),
                    |x, sum| {
                        for (number, row) in joint.multipliers().zip(&joint.rows) {
                            row.add_change_of_gradient(multipliers[number], x, sum);
                        }
                        for (out, force) in out.chunks_exact_mut(3).zip(sum.iter()) {
                            (0..3).for_each(|i| out[i] += force[i]);
                        }
                    },
                );
            }
        }
    }
}

/// Joints of quadratic constraints; their forces `Gᵀν_p` of the order that is to be found are left out.
impl PowerSeries for JointGroup {
    fn stored_stresses(&self, _: usize) -> usize {
        0
    }

    fn forces_of_order(&self, known: &KnownOrders, _: &mut [f64], forces: &mut [f64]) {
        let multipliers = known.multipliers.iter().skip(1).map(Vec::as_slice);
        self.write_changes(multipliers.zip(known.coefficients.iter().rev().map(Vec::as_slice)), forces);
    }

    fn tangent_products(&self, k: &GroupPoint, field: &[Nodal], forces: &mut [f64]) {
        self.write_changes(std::iter::once((k.multipliers, field)), forces);
    }
}

impl Joint {
    /// Forces of the constraints on the nodal vectors v, and lower blocks of their tangent; `gradient` is scratch space.
    fn evaluate(
        &self,
        k: &GroupPoint,
        (v, gradient): (&[Vec3], &mut [Vec3]),
        out: &mut [f64],
        mut blocks: Option<(TangentWeights, &mut [f64])>,
    ) {
        if let Some((_, blocks)) = &mut blocks {
            blocks.fill(0.0);
        }
        out.fill(0.0);
        let drive = self.drive_value(k.drives);
        for (number, row) in self.multipliers().zip(&self.rows) {
            gradient.fill(Vec3::zeros());
            let half = |i: usize| half_motion(&k.motion, self.vectors[i] as usize);
            row.add_acting_gradient(1.0, (v, half), drive, gradient);
            // Forces of unknown multipliers must not look like none.
            let multiplier = k.multipliers.get(number).copied().unwrap_or(f64::NAN);
            for (out, g) in out.chunks_exact_mut(3).zip(gradient.iter()) {
                (0..3).for_each(|i| out[i] += multiplier * g[i]);
            }
            if let Some((weights, blocks)) = &mut blocks {
                let weight = row.weight(weights);
                if weight != 0.0 {
                    augment(gradient, weight, blocks);
                }
                if weights.multiplier != 0.0 {
                    row.add_second_derivative(weights.multiplier * multiplier, drive, blocks);
                    row.add_other_second_derivatives(weights.multiplier * multiplier, v, blocks);
                }
            }
        }
    }
}
