//! Reduction of contributions to the degrees of freedom of rigid bodies: `Pᵀ K P` with `δd_i = δθ × d_i`, and of vectors
//! attached to bodies `δr_a = δr + δθ × (r_a − r)`, `δd_a = δθ × d_a`.

use std::ops::Range;

use super::assembly::pairs;
use super::{DofMap, LocalFrames};
use crate::element::ElementGroup;
use crate::{Mat3, Vec3};

/// Contributions of a group that contain directors of rigid bodies or vectors attached to bodies. In the tangent the first
/// director of a body stands for its rotation, and the blocks of all others are transformed and added there, or to those of
/// its position. Other contributions of the group go into the tangent as they are.
#[derive(Debug, Clone, PartialEq)]
pub struct Reduction {
    /// Reduced contributions, ascending.
    members: Vec<Member>,
}

/// One contribution: its vectors in the tangent, and how its own ones depend on them.
#[derive(Debug, Clone, PartialEq, Default)]
struct Member {
    /// Number of the contribution in its group.
    number: usize,
    /// Nodal vectors of the tangent.
    vectors: Vec<u32>,
    /// The nodal vectors of the contribution.
    parts: Vec<Part>,
}

/// Nodal vector of a contribution as a function of those of the tangent.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Part {
    /// Place of the vector with which it moves: of itself, or of the position of the body.
    translation: Option<usize>,
    /// Place of the rotation of the body.
    rotation: Option<(usize, Turned)>,
}

/// Vector fixed in a rigid body.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Turned {
    /// Rigid body, by the number of its directors.
    triad: usize,
    /// Coordinates along the directors.
    coordinates: Vec3,
}

/// Place in the tangent, and factor `P = −[arm]×` of a rotation; `None`: the unit matrix.
type Term = (usize, Option<Mat3>);

impl Reduction {
    /// Reduction of a group; `None` if it contains nothing that moves with rigid bodies.
    pub fn new(group: &dyn ElementGroup, dofs: &DofMap) -> Option<Self> {
        if dofs.triads.is_empty() {
            return None;
        }
        let carried = |vectors: &[u32]| vectors.iter().any(|&v| dofs.is_carried(v as usize));
        let numbers = (0..group.len()).filter(|&e| carried(group.vectors(e)));
        let members: Vec<Member> = numbers.map(|e| Member::new(e, group.vectors(e), dofs)).collect();
        (!members.is_empty()).then_some(Self { members })
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

    /// Writes the lower blocks of the reduced contributions of a range, one after another, from the `blocks` of all
    /// contributions of the range.
    pub fn reduce(&self, range: Range<usize>, frames: &LocalFrames, blocks: &[f64], out: &mut [f64]) {
        let (mut out, first) = (out, range.start);
        for member in self.among(range) {
            let own = 9 * pairs(member.parts.len());
            let at = own * (member.number - first);
            let (target, others) = std::mem::take(&mut out).split_at_mut(9 * pairs(member.vectors.len()));
            member.reduce(frames, &blocks[at..at + own], target);
            out = others;
        }
    }
}

impl Member {
    fn new(number: usize, vectors: &[u32], dofs: &DofMap) -> Self {
        let mut out = Self { number, ..Self::default() };
        for &v in vectors {
            let part = match (director(v, dofs), dofs.attachment(v as usize)) {
                (Some(turned), _) => Part { translation: None, rotation: Some(out.turned(turned, dofs)) },
                (None, Some(attached)) => Part {
                    translation: attached.centre.map(|centre| out.place(centre)),
                    rotation: Some(out.turned(
                        Turned { triad: attached.triad as usize, coordinates: attached.coordinates },
                        dofs,
                    )),
                },
                (None, None) => Part { translation: Some(out.place(v)), rotation: None },
            };
            out.parts.push(part);
        }
        out
    }

    /// Place of a nodal vector in the tangent.
    fn place(&mut self, vector: u32) -> usize {
        self.vectors.iter().position(|w| *w == vector).unwrap_or_else(|| {
            self.vectors.push(vector);
            self.vectors.len() - 1
        })
    }

    fn turned(&mut self, turned: Turned, dofs: &DofMap) -> (usize, Turned) {
        (self.place(dofs.triads[turned.triad][0]), turned)
    }

    fn reduce(&self, frames: &LocalFrames, blocks: &[f64], out: &mut [f64]) {
        out.fill(0.0);
        for (a, part_a) in self.parts.iter().enumerate() {
            for (b, part_b) in self.parts[..=a].iter().enumerate() {
                let pair = pairs(a) + b;
                let k = Mat3::from_row_slice(&blocks[9 * pair..9 * pair + 9]);
                for (i, p) in part_a.terms(frames).into_iter().flatten() {
                    let row = p.map_or(k, |p| p.transpose() * k);
                    for (j, q) in part_b.terms(frames).into_iter().flatten() {
                        // Of a vector with itself both orders of two terms are met.
                        if a != b || i >= j {
                            add(q.map_or(row, |q| row * q), (i, j), a != b, out);
                        }
                    }
                }
            }
        }
    }
}

impl Part {
    fn terms(&self, frames: &LocalFrames) -> [Option<Term>; 2] {
        let rotation = self.rotation.map(|(place, turned)| {
            // δd = δθ × d = −[d]× δθ
            let arm = frames.triad(turned.triad) * turned.coordinates;
            (place, Some(-arm.cross_matrix()))
        });
        [self.translation.map(|place| (place, None)), rotation]
    }
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

/// Director of a rigid body.
fn director(v: u32, dofs: &DofMap) -> Option<Turned> {
    if !dofs.in_triad(v as usize) {
        return None;
    }
    let triad = dofs.triads.partition_point(|triad| triad[0] <= v) - 1;
    let number = dofs.triads[triad].iter().position(|d| *d == v)?;
    Some(Turned { triad, coordinates: Vec3::ith(number, 1.0) })
}
