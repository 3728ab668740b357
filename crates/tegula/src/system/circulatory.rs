//! Circulatory stiffness: the skew part of the stiffness of follower loads.
//!
//! The symmetric part of that stiffness lies in the pattern of the tangent; the skew part acts on few nodal vectors.
//! For a pressure on a surface the skew part is a sum over its boundary, since the parts of elements cancel along
//! common edges:
//!
//! ```text
//! ½ (K_ab − K_baᵀ) = −½ p ∮ N_a N_b [dr]×
//! ```
//!
//! (K. Schweizerhof, E. Ramm, *Displacement dependent pressure loads in nonlinear finite element analyses*, Comput.
//! Struct. 18 (1984) 1099–1114). For a moment on a director it is `−(m·d) [d]×/|d|⁴`, which vanishes with the drilling
//! component; for one on a rigid body it is `−½ [m]×` of its rotation. The name is that of circulatory forces: H. Ziegler, *Principles of structural stability*, 1968.

use std::collections::BTreeMap;

use super::LocalFrames;
use super::assembly::{FieldStiffness, TangentCoefficients};
use super::dof_map::CONSTRAINED;
use super::evaluation_point::current_vector;
use super::{System, VectorKind};
use crate::element::{Motion, Nodal};
use crate::load::{FollowerLoad, LoadFactor};
use crate::{Mat3, Vec3};

/// Relative difference of the pressures of neighbours up to which they cancel along their common edge.
const CANCELLED: f64 = 1e-12;
/// Skew blocks below this part of the load's stiffness are round-off.
const ROUNDING: f64 = 1e-13;
/// As [`ROUNDING`], of stiffnesses that are differences of forces.
const ROUNDING_OF_DIFFERENCES: f64 = 1e-7;

impl System {
    /// Bound of the work `½ |m × θ| |θ|` of the skew stiffness `½ [m]×` of moments m that are constant in space, on bodies that turn by θ in a
    /// small motion from displacements `u` [force·length]. It vanishes where all bodies turn about the axes of their moments: only then
    /// these moments have a potential. `factor` multiplies the factors of the loads.
    pub fn skew_work_of_moments(
        &self,
        u: &[Nodal],
        motion: &[Nodal],
        factor: impl Fn(&LoadFactor) -> f64,
    ) -> f64 {
        let of_load = |load: &FollowerLoad| {
            let FollowerLoad::BodyMoment { directors, moment, factor: of_load } = load else { return 0.0 };
            let turn: Vec3 = directors
                .iter()
                .map(|&v| {
                    let v = v as usize;
                    let director = Vec3::from(self.coordinates.reference[v]) + Vec3::from(u[v]);
                    0.5 * director.cross(&Vec3::from(motion[v]))
                })
                .sum();
            0.5 * factor(of_load).abs() * moment.cross(&turn).norm() * turn.norm()
        };
        self.followers.iter().map(of_load).sum()
    }
}

/// An edge on the boundary of a surface under pressure.
#[derive(Debug, Clone, Copy, PartialEq)]
struct PressureEdge {
    /// Positions of the edge's ends, in the sense around the surface.
    ends: [u32; 2],
    /// Pressure at factor 1.
    pressure: f64,
    factor: LoadFactor,
}

/// Skew block of two nodal vectors; the block of `(column, row)` is minus its transpose.
#[derive(Debug, Clone, Copy)]
struct Block {
    row: u32,
    column: u32,
    values: Mat3,
}

/// Skew part of the stiffness of all follower loads, computed at a motion.
#[derive(Debug, Clone)]
pub struct CirculatoryStiffness {
    edges: Vec<PressureEdge>,
    /// Indices of the follower loads that are moments.
    moments: Vec<u32>,
    blocks: Vec<Block>,
    /// Free degrees of freedom on which the stiffness acts, ascending.
    support: Vec<u32>,
    /// Scale of each degree of freedom of `support`: 1/length of positions, 1 of directors, so that results do not
    /// depend on units.
    scales: Vec<f64>,
}

impl CirculatoryStiffness {
    /// Lists the nodal vectors concerned; no stiffness is computed yet.
    pub fn new(system: &System) -> Self {
        Self::of(system, |_| true)
    }

    /// As [`new`](Self::new), but moments on rigid bodies and nodes of beams are left out. In linear analyses the
    /// [work](System::skew_work_of_moments) of their skew stiffness in each mode tells whether it matters.
    pub fn without_moments_on_bodies(system: &System) -> Self {
        Self::of(system, |load| !matches!(load, FollowerLoad::BodyMoment { .. }))
    }

    fn of(system: &System, takes: impl Fn(&FollowerLoad) -> bool) -> Self {
        let edges = boundary(&system.followers);
        let is_moment = |load: &FollowerLoad| !matches!(load, FollowerLoad::Pressure { .. }) && takes(load);
        let moments: Vec<u32> =
            (0u32..).zip(&system.followers).filter(|(_, l)| is_moment(l)).map(|(n, _)| n).collect();
        let of_moment = |&n: &u32| system.followers[n as usize].vectors().iter().copied();
        let mut vectors: Vec<u32> =
            edges.iter().flat_map(|e| e.ends).chain(moments.iter().flat_map(of_moment)).collect();
        vectors.sort_unstable();
        vectors.dedup();
        let mut coordinates = Vec::new();
        for v in vectors {
            let moved: Vec<u32> = match system.dofs().carried(v as usize) {
                None => vec![v],
                Some(attached) => {
                    let rotation = system.dofs().triads[attached.triad as usize][0];
                    attached.centre.into_iter().chain([rotation]).collect()
                }
            };
            for v in moved.into_iter().map(|v| v as usize) {
                let scale = if system.coordinates.kinds[v] == VectorKind::Position {
                    1.0 / system.length
                } else {
                    1.0
                };
                let free = system.frames.of(v).into_iter().filter(|&n| n != CONSTRAINED);
                coordinates.extend(free.map(|n| (n, scale)));
            }
        }
        coordinates.sort_by_key(|(n, _)| *n);
        coordinates.dedup_by_key(|(n, _)| *n);
        let (support, scales) = coordinates.into_iter().unzip();
        let pairs = |&n: &u32| {
            let n = system.followers[n as usize].vectors().len();
            n * (n + 1) / 2
        };
        let most = 3 * edges.len() + moments.iter().map(pairs).sum::<usize>();
        Self { edges, moments, blocks: Vec::with_capacity(most), support, scales }
    }

    /// Computes the stiffness at a motion, with the coefficients of a tangent.
    pub fn take(&mut self, system: &System, motion: &Motion, parts: &TangentCoefficients) {
        self.blocks.clear();
        if system.linear {
            return;
        }
        let direction = parts.weights.force * parts.weights.direction;
        for edge in &self.edges {
            let p = direction * edge.pressure * system.factor(&edge.factor, parts.time);
            let [a, b] = edge.ends;
            let along =
                current_vector(system, motion, b as usize) - current_vector(system, motion, a as usize);
            // ∮ N_a N_b along an edge: a third of it and a sixth.
            let values = along.cross_matrix() * (-p / 6.0);
            if p != 0.0 {
                self.blocks.push(Block { row: a, column: a, values });
                self.blocks.push(Block { row: b, column: b, values });
                self.blocks.push(Block { row: a, column: b, values: values * 0.5 });
            }
        }
        let fields = FieldStiffness::of(system, motion, parts);
        for &n in &self.moments {
            let load = &system.followers[n as usize];
            if let Some(block) = fields.block(system, n as usize) {
                let (row, values) = (load.vectors()[0], (block - block.transpose()) * 0.5);
                if !(values.amax() <= ROUNDING_OF_DIFFERENCES * block.amax()) {
                    self.blocks.push(Block { row, column: row, values });
                }
                continue;
            }
            let factor = direction * system.factor(load.factor(), parts.time);
            let vectors = load.vectors();
            let mut x = [Vec3::zeros(); 4];
            for (x, &v) in x.iter_mut().zip(vectors) {
                *x = current_vector(system, motion, v as usize);
            }
            let stiffness = load.derivative(&x[..vectors.len()]);
            let largest = stiffness.iter().flatten().map(|b| b.amax()).fold(0.0, crate::norm::larger);
            for (a, &row) in vectors.iter().enumerate() {
                for (b, &column) in vectors[..=a].iter().enumerate() {
                    let values = (stiffness[a][b] - stiffness[b][a].transpose()) * (0.5 * factor);
                    // NaN is kept: the solver reports it.
                    if !(values.amax() <= ROUNDING * factor.abs() * largest) {
                        self.blocks.push(Block { row, column, values });
                    }
                }
            }
        }
    }

    /// Whether the stiffness is zero at the motion where it was computed.
    pub fn is_zero(&self) -> bool {
        self.blocks.is_empty()
    }

    /// Free degrees of freedom on which the stiffness acts, ascending.
    pub fn support(&self) -> &[u32] {
        &self.support
    }

    /// Gathers the scaled values of the free degrees of freedom on which the stiffness acts.
    pub fn gather(&self, x: &[f64], out: &mut [f64]) {
        for ((out, &n), scale) in out.iter_mut().zip(&self.support).zip(&self.scales) {
            *out = scale * x[n as usize];
        }
    }

    /// Scatters scaled values to the free degrees of freedom on which the stiffness acts; the others become zero.
    pub fn scatter(&self, values: &[f64], x: &mut [f64]) {
        x.fill(0.0);
        for ((value, &n), scale) in values.iter().zip(&self.support).zip(&self.scales) {
            x[n as usize] = value / scale;
        }
    }

    /// Hands row, column and value of the entries among the free degrees of freedom along the axes of `frames` to `take`; entries
    /// of the same place add up.
    pub fn for_each_entry(&self, frames: &LocalFrames, mut take: impl FnMut(u32, u32, f64)) {
        let components = |v: u32, axis: usize| {
            let mut found = Vec::new();
            frames.reduce_one(v as usize, &Vec3::ith(axis, 1.0), |n, x| found.push((n, x)));
            found
        };
        for block in &self.blocks {
            let [rows, columns] =
                [block.row, block.column].map(|v| [0, 1, 2].map(|axis| components(v, axis)));
            for (r, c) in (0..9).map(|i| (i / 3, i % 3)) {
                for &(row, x) in &rows[r] {
                    for &(column, y) in &columns[c] {
                        let value = x * block.values[(r, c)] * y;
                        take(row, column, value);
                        if block.row != block.column {
                            take(column, row, -value);
                        }
                    }
                }
            }
        }
    }

    /// `out = N x` for free degrees of freedom along the axes of `frames`.
    pub fn product(&self, frames: &LocalFrames, x: &[f64], out: &mut [f64]) {
        out.fill(0.0);
        let read = |v: u32| frames.expand_one(v as usize, |n| x.get(n as usize).copied().unwrap_or(0.0));
        let mut add = |v: u32, value: Vec3| {
            frames.reduce_one(v as usize, &value, |n, value| out[n as usize] += value);
        };
        for block in &self.blocks {
            add(block.row, block.values * read(block.column));
            if block.row != block.column {
                add(block.column, -block.values.tr_mul(&read(block.row)));
            }
        }
    }
}

/// Loaded edges that do not cancel: on the boundary of a surface, or between different pressures.
fn boundary(loads: &[FollowerLoad]) -> Vec<PressureEdge> {
    type Key = ([u32; 2], (Option<usize>, u64, [bool; 2]));
    let mut sums: BTreeMap<Key, ([f64; 2], LoadFactor)> = BTreeMap::new();
    for load in loads {
        let FollowerLoad::Pressure { vectors, pressure, factor } = load else { continue };
        for a in 0..4 {
            let (from, to) = (vectors[a], vectors[(a + 1) % 4]);
            let signed = if from < to { *pressure } else { -pressure };
            let key = ([from.min(to), from.max(to)], factor.key());
            let ([sum, size], _) = sums.entry(key).or_insert(([0.0; 2], *factor));
            *sum += signed;
            *size += pressure.abs();
        }
    }
    let left = sums.into_iter().filter(|(_, ([sum, size], _))| sum.abs() > CANCELLED * size);
    left.map(|((ends, _), ([pressure, _], factor))| PressureEdge { ends, pressure, factor }).collect()
}
