//! Loads on many nodes that are evaluated together, as functions of time, positions and velocities.

use std::fmt::Debug;
use std::sync::{Arc, Mutex, PoisonError};

use crate::element::Nodal;
use crate::norm::{larger, max_norm};
use crate::{Mat3, Vec3};

/// Increment of a difference quotient over the size of the model: the square root of round-off, 2⁻²⁶.
const DIFFERENCE: f64 = 1.490_116_119_384_765_6e-8;

/// Change of the force on a node at rest over the largest change, when other nodes move, that is round-off.
const ALONE: f64 = 1e-6;

/// Error of a block of the stiffness over the largest one that is a mistake; differences have errors of about 1e-8.
const WRONG: f64 = 1e-3;
/// Increments of the differences with which a stiffness is compared, over the size of the model.
const INCREMENTS: [f64; 3] = [DIFFERENCE, 1e-5, 1e-3];
/// Increments over which differences agree with those over [`DIFFERENCE`]: those of forces of single precision are round-off, or zero below its resolution.
const LARGER_INCREMENTS: [f64; 2] = [1e-6, 1e-5];
/// Round-off of the difference of two forces, over the force.
const ROUND_OFF: f64 = 64.0 * f64::EPSILON;

/// Quantities of which the forces of a [`FieldLoad`] are functions.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Dependence {
    /// Time (load factor) alone.
    Time,
    /// Time and positions.
    Positions,
    /// Time, positions and velocities.
    Velocities,
}

/// Evaluation point of a [`FieldLoad`].
#[derive(Debug, Clone, Copy)]
pub struct LoadPoint<'a> {
    /// Time; in static analyses and on paths the load factor.
    pub time: f64,
    /// Positions of the nodes (length).
    pub positions: &'a [Vec3],
    /// Velocities of the nodes (length/time); zero in static analyses.
    pub velocities: &'a [Vec3],
    /// Size of the model (length).
    pub length: f64,
}

/// Load on the positions of many nodes as a function of time and motion, evaluated for all nodes in one call: wind on a
/// roof, a bed of springs, dampers, a controller. A caller hands it to
/// [`Compiler::add_field_load`](crate::compile::Compiler::add_field_load).
///
/// Analyses evaluate it several times in each step, and again where a step is repeated: it is a pure function of its arguments.
pub trait FieldLoad: Debug + Send + Sync {
    /// Arguments on which the forces depend.
    fn dependence(&self) -> Dependence;
    /// Writes the force on each node (force). A force that cannot be evaluated is NaN, and the step fails; an [`Observer`](crate::analysis::Observer) that is
    /// `interrupted` then ends the analysis at once.
    fn forces(&self, at: &LoadPoint, out: &mut [Nodal]);
    /// Writes the blocks `−(w ∂f_a/∂x_a + r ∂f_a/∂v_a)` of each node a [force/length] for the weights `[w, r]` of positions and velocities. A block need not be symmetric. Forces that
    /// depend on the motion of other nodes, too, converge more slowly.
    ///
    /// The blocks are differences of the forces over increments of 1.5e-8 times the size of the model: three evaluations more.
    fn stiffness(&self, at: &LoadPoint, weights: [f64; 2], out: &mut [Mat3]) {
        stiffness_by_differences(self, at, weights, out);
    }
}

/// Column `axis` of the blocks of [`FieldLoad::stiffness`] at the nodes that move, by the difference of the forces to those `before`.
fn column_by_difference<L: FieldLoad + ?Sized>(
    load: &L,
    at: &LoadPoint,
    (weights, axis, step): ([f64; 2], usize, f64),
    before: &[Nodal],
    moves: impl Fn(usize) -> bool,
) -> Vec<Vec3> {
    let moved = |values: &[Vec3], weight: f64| -> Vec<Vec3> {
        let shift = |(node, x): (usize, &Vec3)| {
            if moves(node) { x + Vec3::ith(axis, weight * step) } else { *x }
        };
        values.iter().enumerate().map(shift).collect()
    };
    let (positions, velocities) = (moved(at.positions, weights[0]), moved(at.velocities, weights[1]));
    let mut behind = vec![[0.0; 3]; before.len()];
    load.forces(&LoadPoint { positions: &positions, velocities: &velocities, ..*at }, &mut behind);
    let change = |(before, behind): (&Nodal, &Nodal)| (Vec3::from(*before) - Vec3::from(*behind)) / step;
    before.iter().zip(&behind).map(change).collect()
}

/// Blocks of [`FieldLoad::stiffness`] as differences of the forces.
pub fn stiffness_by_differences<L: FieldLoad + ?Sized>(
    load: &L,
    at: &LoadPoint,
    weights: [f64; 2],
    out: &mut [Mat3],
) {
    let mut before = vec![[0.0; 3]; at.positions.len()];
    load.forces(at, &mut before);
    for axis in 0..3 {
        let difference = (weights, axis, DIFFERENCE * at.length);
        let columns = column_by_difference(load, at, difference, &before, |_| true);
        out.iter_mut().zip(&columns).for_each(|(block, column)| block.set_column(axis, column));
    }
}

/// Node whose block of [`FieldLoad::stiffness`] for these weights is not the derivative of its force by its own motion, by differences to both sides and
/// over increments of several sizes: at a kink of the force one side counts, and forces of single precision need large increments.
///
/// All nodes move together; where the blocks do not agree, which the motion of other nodes may cause, the node with the largest error moves alone.
pub fn node_of_wrong_stiffness<L: FieldLoad + ?Sized>(
    load: &L,
    at: &LoadPoint,
    weights: [f64; 2],
) -> Option<usize> {
    GivenStiffness::of(load, at, weights).wrong_node(&INCREMENTS)
}

/// Stiffness of a load that is not the derivative of its forces.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum WrongStiffness {
    /// A function of the caller gives it.
    OfFunction,
    /// It is that of differences, which are round-off.
    OfDifferences,
}

/// Blocks that a load has given, and its forces at the same place.
struct GivenStiffness<'a, L: ?Sized> {
    load: &'a L,
    at: &'a LoadPoint<'a>,
    weights: [f64; 2],
    blocks: Vec<Mat3>,
    before: Vec<Nodal>,
}

impl<'a, L: FieldLoad + ?Sized> GivenStiffness<'a, L> {
    fn of(load: &'a L, at: &'a LoadPoint<'a>, weights: [f64; 2]) -> Self {
        let n = at.positions.len();
        let (mut blocks, mut before) = (vec![Mat3::zeros(); n], vec![[0.0; 3]; n]);
        load.stiffness(at, weights, &mut blocks);
        load.forces(at, &mut before);
        Self { load, at, weights, blocks, before }
    }

    /// Whether the blocks are those of [`stiffness_by_differences`].
    fn is_of_differences(&self) -> bool {
        let mut differences = vec![Mat3::zeros(); self.blocks.len()];
        stiffness_by_differences(self.load, self.at, self.weights, &mut differences);
        differences == self.blocks
    }

    /// Node whose block agrees with the differences over none of the increments.
    fn wrong_node(&self, increments: &[f64]) -> Option<usize> {
        let mut found = None;
        for increment in increments.iter().map(|increment| increment * self.at.length) {
            let (together, tolerance) = self.errors(increment, |_| true);
            let worst = (0..together.len()).max_by(|a, b| together[*a].total_cmp(&together[*b]))?;
            if together[worst] <= tolerance {
                return None;
            }
            let (alone, tolerance) = self.errors(increment, |node| node == worst);
            if alone[worst] <= tolerance {
                return None;
            }
            found.get_or_insert(worst);
        }
        found
    }

    /// Largest error of the columns of each node that moves, by the nearest one of the differences to both sides and their mean, and the error that is none.
    fn errors(&self, step: f64, moves: impl Fn(usize) -> bool) -> (Vec<f64>, f64) {
        let n = self.before.len();
        let (mut errors, mut size) = (vec![0.0; n], 0.0);
        for axis in 0..3 {
            let [above, below] = [step, -step].map(|step| {
                column_by_difference(self.load, self.at, (self.weights, axis, step), &self.before, &moves)
            });
            for node in (0..n).filter(|node| moves(*node)) {
                let column = self.blocks[node].column(axis);
                let differences = [above[node], below[node], 0.5 * (above[node] + below[node])];
                let nearest = differences.map(|d| (column - d).norm()).into_iter().fold(f64::NAN, f64::min);
                errors[node] = larger(errors[node], nearest);
                size = larger(size, larger(column.norm(), above[node].norm()));
            }
        }
        let noise = ROUND_OFF * max_norm(self.before.as_flattened().iter().copied()) / step;
        (errors, WRONG * size + noise)
    }
}

/// [`FieldLoad`] on nodal vectors, with the values of its last evaluation.
#[derive(Debug)]
pub struct LoadOnNodes {
    vectors: Vec<u32>,
    load: Arc<dyn FieldLoad>,
    last: Mutex<Last>,
}

/// Evaluation point of the last evaluation, and what was found there.
#[derive(Debug, Clone, Default)]
struct Last {
    time: f64,
    motion: [Vec<Vec3>; 2],
    forces: Vec<Nodal>,
    stiffness: Option<([f64; 2], Vec<Mat3>)>,
}

impl LoadOnNodes {
    /// Load on the positions of nodes or bodies, by their nodal vectors.
    pub fn new(vectors: Vec<u32>, load: Arc<dyn FieldLoad>) -> Self {
        Self { vectors, load, last: Mutex::default() }
    }

    /// Nodal vectors on which the load acts.
    pub fn vectors(&self) -> &[u32] {
        &self.vectors
    }

    /// Arguments on which the forces depend.
    pub fn dependence(&self) -> Dependence {
        self.load.dependence()
    }

    /// Forgets the last evaluation.
    pub fn forget(&self) {
        self.put(Last::default());
    }

    /// Forces on the nodal vectors.
    pub fn forces(&self, time: f64, motion: [Vec<Vec3>; 2], length: f64) -> Vec<Nodal> {
        self.at(time, motion, length).forces
    }

    /// Blocks of [`FieldLoad::stiffness`].
    pub fn stiffness(&self, time: f64, motion: [Vec<Vec3>; 2], length: f64, weights: [f64; 2]) -> Vec<Mat3> {
        let zero = vec![Mat3::zeros(); self.vectors.len()];
        if self.dependence() == Dependence::Time {
            return zero;
        }
        let mut last = self.at(time, motion, length);
        if let Some((_, known)) = last.stiffness.take_if(|(of, _)| *of == weights) {
            return known;
        }
        let [positions, velocities] = &last.motion;
        let at = LoadPoint { time, positions, velocities, length };
        let mut found = zero;
        self.load.stiffness(&at, weights, &mut found);
        self.put(Last { stiffness: Some((weights, found.clone())), ..last });
        found
    }

    /// Whether forces depend on the positions of other nodes than their own, which the blocks of [`FieldLoad::stiffness`] leave out.
    ///
    /// Half of the nodes move at a time, as the bits of their numbers say: any two nodes differ in one of them.
    pub fn couples_nodes(&self, time: f64, motion: [Vec<Vec3>; 2], length: f64) -> bool {
        let n = self.vectors.len();
        if self.dependence() == Dependence::Time || n < 2 {
            return false;
        }
        let Last { motion: [positions, velocities], forces: before, .. } = self.at(time, motion, length);
        let bits = usize::BITS - (n - 1).leading_zeros();
        let changes = (0..bits).flat_map(|bit| [(bit, 0), (bit, 1)]).map(|(bit, moving)| {
            let moves = |node: usize| node >> bit & 1 == moving;
            let shift = |(node, x): (usize, &Vec3)| {
                if moves(node) { x + Vec3::repeat(DIFFERENCE * length) } else { *x }
            };
            let moved: Vec<Vec3> = positions.iter().enumerate().map(shift).collect();
            let mut behind = vec![[0.0; 3]; n];
            let at = LoadPoint { time, positions: &moved, velocities: &velocities, length };
            self.load.forces(&at, &mut behind);
            let mut largest = [0.0; 2];
            for (node, (a, b)) in before.iter().zip(&behind).enumerate() {
                let change = (Vec3::from(*b) - Vec3::from(*a)).norm();
                let of = &mut largest[usize::from(moves(node))];
                *of = larger(*of, change);
            }
            largest
        });
        let [at_rest, moved] =
            changes.fold([0.0; 2], |all, found| [larger(all[0], found[0]), larger(all[1], found[1])]);
        at_rest > ALONE * larger(at_rest, moved)
    }

    /// Whether the blocks of [`FieldLoad::stiffness`] are other than the derivatives of the forces by the positions, and where they come from.
    pub fn wrong_stiffness(&self, time: f64, motion: [Vec<Vec3>; 2], length: f64) -> Option<WrongStiffness> {
        if self.dependence() == Dependence::Time {
            return None;
        }
        let [positions, velocities] = &motion;
        let at = LoadPoint { time, positions, velocities, length };
        let given = GivenStiffness::of(self.load.as_ref(), &at, [1.0, 0.0]);
        if !given.is_of_differences() {
            return given.wrong_node(&INCREMENTS).map(|_| WrongStiffness::OfFunction);
        }
        let differ = LARGER_INCREMENTS.iter().any(|increment| given.wrong_node(&[*increment]).is_some());
        differ.then_some(WrongStiffness::OfDifferences)
    }

    /// Last evaluation, or a new one where it was elsewhere.
    fn at(&self, time: f64, motion: [Vec<Vec3>; 2], length: f64) -> Last {
        // The lock is not held while the load is evaluated, which may take other locks.
        let last = self.last.lock().unwrap_or_else(PoisonError::into_inner).clone();
        if !last.forces.is_empty() && last.time == time && last.motion == motion {
            return last;
        }
        let mut forces = vec![[0.0; 3]; self.vectors.len()];
        let [positions, velocities] = &motion;
        self.load.forces(&LoadPoint { time, positions, velocities, length }, &mut forces);
        let found = Last { time, motion, forces, stiffness: None };
        self.put(found.clone());
        found
    }

    fn put(&self, last: Last) {
        *self.last.lock().unwrap_or_else(PoisonError::into_inner) = last;
    }
}
