//! Bounds of the highest frequency by single elements (element eigenvalue theorem).
//!
//! Let the elements share the lumped mass, `m_v = Σ_e m_v^e`. Then no eigenvalue of `K x = ω² M x` is above the largest
//! one of a single element with its share, whatever the supports: `x·K x / x·M x` is the mean of the Rayleigh quotients
//! of the elements, weighted with their `x·M_e x`. B. Irons, G. Treharne, *A bound theorem in eigenvalues and its
//! practical applications*, Proc. 3rd Conf. Matrix Methods in Structural Mechanics, Wright–Patterson (1971). The
//! largest eigenvalue of an element is bounded in turn by `(tr A³²)^(1/32)`, `A = M_e^(−½) K_e M_e^(−½)`, which is at
//! most `q^(1/32)` too high where q eigenvalues are as large. No global matrix is assembled.

use rayon::prelude::*;

use super::System;
use super::VectorKind;
use super::assembly::{ElementBlocks, FieldStiffness, TangentCoefficients, pairs};
use super::connection_frequency::{body_of, is_connection, is_joint};
use crate::Vec3;
use crate::element::{ElementGroup, Motion, Nodal, TangentWeights};
use crate::load::FollowerLoad;
use crate::norm::larger;

/// Largest number of degrees of freedom of an element.
const LARGEST: usize = 24;
/// Number of squarings of A: the trace is that of the power 2^(SQUARINGS + 1).
const SQUARINGS: i32 = 4;
/// Part of the mass of nodal vectors and bodies that joints get: their tension is small beside the stiffness of shells and springs.
pub(super) const OF_JOINTS: f64 = 0.1;
/// Elements per task.
const CHUNK: usize = 32;

/// Shares of the elements in the mass of their nodal vectors: shells share by their own part of it; director-angle
/// constraints, which have none, get half.
#[derive(Debug)]
pub struct MassShares {
    /// Sum of the elements' own masses of each nodal vector.
    own: Vec<f64>,
    /// Number of massless elements at each nodal vector.
    massless: Vec<u32>,
    /// Number of joints at each nodal vector.
    joints: Vec<u32>,
    /// Number of follower loads at each nodal vector.
    loads: Vec<u32>,
}

impl MassShares {
    /// Mass shares for the elements and loads of a system.
    pub fn new(system: &System) -> Self {
        let n = system.vectors();
        let mut out = Self { own: vec![0.0; n], massless: vec![0; n], joints: vec![0; n], loads: vec![0; n] };
        for group in system.groups.iter().filter(|group| !is_connection(group.as_ref())) {
            for e in 0..group.len() {
                let vectors = group.vectors(e);
                let own = row_sums(&system.coordinates.kinds, vectors, group.mass(e));
                let massless = own.iter().all(|m| *m == 0.0);
                for (&v, m) in vectors.iter().zip(own) {
                    out.own[v as usize] += m;
                    out.massless[v as usize] += u32::from(massless);
                }
            }
        }
        out.count_connections(system);
        for load in system.followers.iter().filter(|load| bounds_the_step(load)) {
            load.vectors().iter().for_each(|&v| out.loads[v as usize] += 1);
        }
        out
    }

    /// Counts connections at the nodal vectors that they contain: springs and bushings, or joints. Those of a rigid body count once, at all
    /// vectors that are attached to it.
    fn count_connections(&mut self, system: &System) {
        let mut loaded = [vec![false; system.dofs().triads.len()], vec![false; system.dofs().triads.len()]];
        for group in system.groups.iter().filter(|group| is_connection(group.as_ref())) {
            let joints = is_joint(group.as_ref());
            for &v in (0..group.len()).flat_map(|e| group.vectors(e)) {
                match body_of(system, v) {
                    Some(body) => loaded[usize::from(joints)][body] = true,
                    None => self.connections(joints)[v as usize] += 1,
                }
            }
        }
        for (attached, joints) in system.dofs().attached.iter().flat_map(|a| [(a, false), (a, true)]) {
            if loaded[usize::from(joints)][attached.triad as usize] {
                self.connections(joints)[attached.vector as usize] += 1;
            }
        }
    }

    fn connections(&mut self, joints: bool) -> &mut [u32] {
        if joints { &mut self.joints } else { &mut self.massless }
    }

    /// Part of the mass of a nodal vector that is not that of joints.
    fn without_joints(&self, vector: usize) -> f64 {
        if self.joints[vector] > 0 { 1.0 - OF_JOINTS } else { 1.0 }
    }

    /// Share of one connection in the mass of a nodal vector: of a joint, or of a spring or bushing.
    pub(super) fn of_connection(&self, vector: usize, joint: bool) -> f64 {
        if joint {
            OF_JOINTS / f64::from(self.joints[vector].max(1))
        } else {
            0.5 * self.without_joints(vector) / f64::from(self.massless[vector].max(1))
        }
    }

    /// Sum of the elements' own masses of a nodal vector.
    pub fn own(&self, vector: usize) -> f64 {
        self.own[vector]
    }

    /// Share of an element in the masses `mass` of its nodal vectors.
    fn of(&self, system: &System, group: &dyn ElementGroup, element: usize, mass: &[f64]) -> [f64; 8] {
        let vectors = group.vectors(element);
        let mut out = row_sums(&system.coordinates.kinds, vectors, group.mass(element));
        let massless = out.iter().all(|m| *m == 0.0);
        for (m, &v) in out.iter_mut().zip(vectors) {
            let v = v as usize;
            let part = match (massless, self.massless[v]) {
                (true, ties) => 0.5 / f64::from(ties),
                (false, 0) => *m / self.own[v],
                (false, _) => 0.5 * *m / self.own[v],
            };
            *m = part * self.without_joints(v) * mass[v];
        }
        out
    }
}

/// An element's own mass of each of its (up to eight) nodal vectors: the row sums of its consistent mass over vectors of
/// the same kind.
pub fn row_sums(kinds: &[VectorKind], vectors: &[u32], mass: &[f64]) -> [f64; 8] {
    let mut out = [0.0; 8];
    let mut pair = 0;
    for (a, &va) in vectors.iter().enumerate() {
        for (b, &vb) in vectors[..=a].iter().enumerate() {
            let m = mass.get(pair).copied().unwrap_or(0.0);
            pair += 1;
            if kinds[va as usize] == kinds[vb as usize] {
                out[a] += m;
                if a != b {
                    out[b] += m;
                }
            }
        }
    }
    out
}

/// Bound of the largest eigenvalue of each element of a batch; only degrees of freedom of the kinds that `wanted`
/// selects count.
pub fn of_elements(
    system: &System,
    shares: &MassShares,
    mass: &[f64],
    ElementBlocks { group, first, blocks }: ElementBlocks,
    wanted: impl Fn(VectorKind) -> bool + Sync,
) -> Vec<f64> {
    let size = 9 * pairs(group.vectors_per_element());
    let mut out = vec![0.0; blocks.len() / size];
    out.par_chunks_mut(CHUNK).zip(blocks.par_chunks(CHUNK * size)).enumerate().for_each(
        |(chunk, (out, blocks))| {
            let arch = pulp::Arch::new();
            arch.dispatch(
                #[inline(always)]
                || {
                    let mut square = Square::<LARGEST>::new();
                    for (i, (out, blocks)) in out.iter_mut().zip(blocks.chunks_exact(size)).enumerate() {
                        let element = first + chunk * CHUNK + i;
                        let mass = shares.of(system, group, element, mass);
                        let vectors = group.vectors(element);
                        square.fill(blocks, &mass[..vectors.len()], |a| {
                            wanted(system.coordinates.kinds[vectors[a] as usize])
                        });
                        *out = square.bound(0.0);
                    }
                },
            );
        },
    );
    out
}

/// Bound of the largest eigenvalue of any element of a batch.
pub fn of_part(
    system: &System,
    shares: &MassShares,
    mass: &[f64],
    ElementBlocks { group, first, blocks }: ElementBlocks,
) -> f64 {
    let size = 9 * pairs(group.vectors_per_element());
    blocks
        .par_chunks(CHUNK * size)
        .enumerate()
        .map(|(chunk, blocks)| {
            let arch = pulp::Arch::new();
            arch.dispatch(
                #[inline(always)]
                || {
                    let (mut square, mut highest) = (Square::<LARGEST>::new(), 0.0_f64);
                    for (i, blocks) in blocks.chunks_exact(size).enumerate() {
                        let element = first + chunk * CHUNK + i;
                        let mass = shares.of(system, group, element, mass);
                        square.fill(blocks, &mass[..group.vectors_per_element()], |_| true);
                        highest = larger(highest, square.bound(highest));
                    }
                    highest
                },
            )
        })
        .reduce(|| 0.0, larger)
}

/// Whether the stiffness of a follower load may raise a frequency: a moment that is constant in space has no symmetric stiffness against
/// rotations of its body.
fn bounds_the_step(load: &FollowerLoad) -> bool {
    !matches!(load, FollowerLoad::BodyMoment { .. })
}

/// Bound of the largest eigenvalue that the symmetric part of the stiffness of follower loads adds.
pub fn of_followers(system: &System, shares: &MassShares, mass: &[f64], u: &[Nodal], time: f64) -> f64 {
    if system.linear {
        return 0.0;
    }
    let mut square = Square::<LARGEST>::new();
    let mut highest = 0.0_f64;
    let parts = TangentCoefficients { weights: TangentWeights::STATIC, mass: 0.0, time };
    let fields = FieldStiffness::of(system, &Motion::State { u, velocity: None }, &parts);
    for (number, load) in system.followers.iter().enumerate().filter(|(_, load)| bounds_the_step(load)) {
        let n = load.vectors().len();
        let (mut x, mut part, mut blocks) = ([Vec3::zeros(); 4], [0.0; 4], [0.0; 90]);
        for (a, &v) in load.vectors().iter().enumerate() {
            let v = v as usize;
            x[a] = Vec3::from(system.coordinates.reference[v]) + Vec3::from(u[v]);
            part[a] = mass[v] / f64::from(shares.loads[v].max(1));
        }
        // The stiffness gains −∂f/∂x.
        match fields.block(system, number) {
            Some(block) => {
                blocks[..9].copy_from_slice(((block + block.transpose()) * 0.5).as_slice());
            }
            None => {
                load.stiffness(&x[..n], &mut blocks[..9 * pairs(n)]);
                let factor = system.factor(load.factor(), time);
                blocks.iter_mut().for_each(|k| *k *= factor);
            }
        }
        // Positions and directors of bodies have their masses in the bodies' inertia.
        square.fill(&blocks[..9 * pairs(n)], &part[..n], |a| part[a] > 0.0);
        highest = larger(highest, square.bound(highest));
    }
    highest
}

/// Symmetric matrix of one element, with space for its square.
pub(super) struct Square<const N: usize> {
    pub(super) a: [[f64; N]; N],
    squared: [[f64; N]; N],
    pub(super) size: usize,
}

impl<const N: usize> Square<N> {
    pub(super) fn new() -> Self {
        Self { a: [[0.0; N]; N], squared: [[0.0; N]; N], size: 0 }
    }

    /// Sets `M^(−½) K M^(−½)` of the vectors that `wanted` selects.
    #[inline(always)]
    fn fill(&mut self, blocks: &[f64], mass: &[f64], wanted: impl Fn(usize) -> bool) {
        let m = mass.len();
        self.size = 3 * m;
        let mut inverse = [0.0; 8];
        for (a, inverse) in inverse[..m].iter_mut().enumerate() {
            *inverse = if wanted(a) { 1.0 / mass[a].sqrt() } else { 0.0 };
        }
        let mut block = blocks.chunks_exact(9);
        for a in 0..m {
            for b in 0..=a {
                let Some(k) = block.next() else { return };
                let factor = inverse[a] * inverse[b];
                for i in 0..3 {
                    for j in 0..3 {
                        let value = factor * k[3 * i + j];
                        self.a[3 * a + i][3 * b + j] = value;
                        self.a[3 * b + j][3 * a + i] = value;
                    }
                }
            }
        }
    }

    /// Bound of the largest eigenvalue; it need not be tight where it is not above `enough`.
    #[inline(always)]
    pub(super) fn bound(&mut self, enough: f64) -> f64 {
        let n = self.size;
        let mut bound = 1.0;
        for squaring in 0..=SQUARINGS {
            let norm = self.norm();
            bound *= norm.powf(0.5_f64.powi(squaring));
            if !(norm > 0.0 && norm.is_finite()) || bound <= enough || squaring == SQUARINGS {
                break;
            }
            // Scaled to norm 1, so that powers neither over- nor underflow.
            let scale = 1.0 / norm;
            for row in &mut self.a[..n] {
                row.iter_mut().for_each(|x| *x *= scale);
            }
            for (out, left) in self.squared.iter_mut().zip(&self.a[..n]) {
                let mut sum = [0.0; N];
                for (factor, row) in left.iter().zip(&self.a[..n]) {
                    for (s, x) in sum.iter_mut().zip(row) {
                        *s += factor * x;
                    }
                }
                *out = sum;
            }
            std::mem::swap(&mut self.a, &mut self.squared);
        }
        bound
    }

    /// Frobenius norm; columns beyond the size are zero.
    #[inline(always)]
    fn norm(&self) -> f64 {
        let mut sum = [0.0; N];
        for row in &self.a[..self.size] {
            for (s, x) in sum.iter_mut().zip(row) {
                *s += x * x;
            }
        }
        sum.iter().sum::<f64>().sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// −1, 2, −1 has the eigenvalues 2 − 2 cos(kπ/(n+1)); the bound is above the largest one, by (Σ (λ/λ₁)³²)^(1/32).
    #[test]
    fn the_largest_eigenvalue_of_a_chain() {
        let mut square = Square::<LARGEST>::new();
        square.size = 9;
        for i in 0..9 {
            square.a[i][i] = 2.0;
            if i > 0 {
                (square.a[i][i - 1], square.a[i - 1][i]) = (-1.0, -1.0);
            }
        }
        let values = (1..10).map(|k| 2.0 - 2.0 * (f64::from(k) * std::f64::consts::PI / 10.0).cos());
        let exact = values.map(|x| x.powi(32)).sum::<f64>().powf(1.0 / 32.0);
        let bound = square.bound(0.0);
        assert!((bound / exact - 1.0).abs() < 1e-12, "{bound} {exact}");
    }
}
