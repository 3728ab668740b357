//! Reduction of contributions to the degrees of freedom of rigid bodies: `Pᵀ K P` with `δd_i = δθ × d_i`, and of vectors
//! attached to bodies `δr_a = δr + δθ × (r_a − r)`, `δd_a = δθ × d_a`.

use std::ops::Range;

use super::assembly::pairs;
use super::pattern::BATCH;
use super::{Attached, DofMap, LocalFrames};
use crate::element::ElementGroup;
use crate::{Mat3, Vec3};

/// Contributions of a group, or follower loads, that contain directors of rigid bodies or vectors attached to bodies. In the
/// tangent the first director of a body stands for its rotation, and the blocks of all others are transformed and added there,
/// or to those of its position. Other contributions go into the tangent as they are.
#[derive(Debug, Clone, PartialEq)]
pub struct Reduction {
    /// Reduced contributions, ascending.
    members: Vec<Member>,
}

/// One contribution: its vectors in the tangent, and how its own ones depend on them.
#[derive(Debug, Clone, PartialEq, Default)]
struct Member {
    /// Number of the contribution among those of its group, or among the follower loads.
    number: usize,
    /// Number of blocks of the contributions before it in its batch.
    first_block: usize,
    /// Nodal vectors of the tangent.
    vectors: Vec<u32>,
    /// The nodal vectors of the contribution.
    parts: Vec<Part>,
    /// Whether it is an element that moves with one body as a whole: its stiffness against the motions of the body is zero, which sums of
    /// blocks give up to round-off only.
    cancels: bool,
}

/// Nodal vector of a contribution as a function of those of the tangent.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Part {
    /// Place of the vector with which it moves: of itself, or of the position of the body.
    translation: Option<usize>,
    /// Place of the rotation of the body.
    rotation: Option<(usize, Attached)>,
}

/// Place in the tangent, and arm a of a rotation, whose factor is `P = −[a]×`; `None`: the unit matrix.
type Term = (usize, Option<Vec3>);

impl Reduction {
    /// Reduction of contributions with these nodal vectors; `None` if they contain nothing that moves with rigid bodies. `invariant`: rigid motions
    /// of all vectors of a contribution do not change its energy.
    pub fn new<'a>(
        contributions: impl Iterator<Item = &'a [u32]>,
        invariant: bool,
        dofs: &DofMap,
    ) -> Option<Self> {
        if dofs.triads.is_empty() {
            return None;
        }
        let (mut members, mut blocks) = (Vec::new(), 0);
        for (number, vectors) in contributions.enumerate() {
            if number % BATCH == 0 {
                blocks = 0;
            }
            if vectors.iter().any(|&v| dofs.is_carried(v as usize)) {
                let mut member = Member::new((number, blocks), vectors, dofs);
                member.cancels = invariant && member.is_on_one_body();
                members.push(member);
            }
            blocks += pairs(vectors.len());
        }
        (!members.is_empty()).then_some(Self { members })
    }

    /// Reduction of the elements of a group.
    pub fn of_elements(group: &dyn ElementGroup, dofs: &DofMap) -> Option<Self> {
        Self::new((0..group.len()).map(|e| group.vectors(e)), !group.acts_on_ground(), dofs)
    }

    /// Numbers of the reduced contributions, ascending.
    pub fn numbers(&self) -> impl Iterator<Item = usize> {
        self.members.iter().map(|member| member.number)
    }

    /// Whether a contribution is reduced.
    pub fn contains(&self, number: usize) -> bool {
        self.members.binary_search_by_key(&number, |member| member.number).is_ok()
    }

    /// Nodal vectors in the tangent of the reduced contributions among those of a range.
    pub fn vectors(&self, range: Range<usize>) -> impl Iterator<Item = &[u32]> {
        self.among(range).iter().map(|member| member.vectors.as_slice())
    }

    /// Number of blocks of the reduced contributions among those of a range.
    pub fn blocks(&self, range: Range<usize>) -> usize {
        self.among(range).iter().map(|member| pairs(member.vectors.len())).sum()
    }

    fn among(&self, range: Range<usize>) -> &[Member] {
        let at = |number: usize| self.members.partition_point(|member| member.number < number);
        &self.members[at(range.start)..at(range.end)]
    }

    /// Writes the lower blocks of the reduced contributions of a batch, one after another, from the `blocks` of all
    /// contributions of the batch, which begins at a multiple of [`BATCH`].
    pub fn reduce(&self, batch: Range<usize>, frames: &LocalFrames, blocks: &[f64], out: &mut [f64]) {
        let mut out = out;
        for member in self.among(batch) {
            let (at, own) = (9 * member.first_block, 9 * pairs(member.parts.len()));
            let (target, others) = std::mem::take(&mut out).split_at_mut(9 * pairs(member.vectors.len()));
            member.reduce(frames, &blocks[at..at + own], target);
            out = others;
        }
    }
}

impl Member {
    fn new((number, first_block): (usize, usize), vectors: &[u32], dofs: &DofMap) -> Self {
        let mut out = Self { number, first_block, ..Self::default() };
        for &v in vectors {
            let part = match dofs.carried(v as usize) {
                Some(attached) => Part {
                    translation: attached.centre.map(|centre| out.place(centre)),
                    rotation: Some((out.place(dofs.triads[attached.triad as usize][0]), attached)),
                },
                None => Part { translation: Some(out.place(v)), rotation: None },
            };
            out.parts.push(part);
        }
        out
    }

    /// Whether all vectors move with the same body.
    fn is_on_one_body(&self) -> bool {
        let bodies = || self.parts.iter().map(|part| part.rotation.map(|(_, attached)| attached.triad));
        bodies().all(|body| body.is_some() && Some(body) == bodies().next())
    }

    /// Place of a nodal vector in the tangent.
    fn place(&mut self, vector: u32) -> usize {
        self.vectors.iter().position(|w| *w == vector).unwrap_or_else(|| {
            self.vectors.push(vector);
            self.vectors.len() - 1
        })
    }

    fn reduce(&self, frames: &LocalFrames, blocks: &[f64], out: &mut [f64]) {
        out.fill(0.0);
        if self.cancels {
            return;
        }
        for (a, part_a) in self.parts.iter().enumerate() {
            let terms = part_a.terms(frames);
            for (b, part_b) in self.parts[..=a].iter().enumerate() {
                let pair = pairs(a) + b;
                let k = Mat3::from_row_slice(&blocks[9 * pair..9 * pair + 9]);
                for &(i, arm) in terms.iter().flatten() {
                    // Pᵀ K = [a]× K
                    let row = arm.map_or(k, |arm| across(&arm, &k));
                    for (j, arm) in part_b.terms(frames).into_iter().flatten() {
                        // Of a vector with itself both orders of two terms are met.
                        if a != b || i >= j {
                            // K P = ([a]× Kᵀ)ᵀ
                            let product = arm.map_or(row, |arm| across(&arm, &row.transpose()).transpose());
                            add(product, (i, j), a != b, out);
                        }
                    }
                }
            }
        }
    }
}

impl Part {
    fn terms(&self, frames: &LocalFrames) -> [Option<Term>; 2] {
        // δd = δθ × d = −[d]× δθ
        let rotation = self.rotation.map(|(place, attached)| (place, Some(frames.arm(&attached))));
        [self.translation.map(|place| (place, None)), rotation]
    }
}

/// Product `[a]× K`: the columns of K across a vector.
fn across(a: &Vec3, k: &Mat3) -> Mat3 {
    Mat3::from_columns(&[0, 1, 2].map(|j| a.cross(&k.column(j))))
}

/// Adds a block at its place in a lower triangle; of a pair of different vectors the block in the upper triangle belongs to it.
fn add(mut k: Mat3, (i, j): (usize, usize), pair: bool, out: &mut [f64]) {
    if i < j {
        k = k.transpose();
    } else if i == j && pair {
        k += k.transpose();
    }
    let at = 9 * (pairs(i.max(j)) + i.min(j));
    for (entry, x) in out[at..at + 9].iter_mut().enumerate() {
        *x += k[(entry / 3, entry % 3)];
    }
}
