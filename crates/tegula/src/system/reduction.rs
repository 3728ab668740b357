//! Reduction of contributions to the degrees of freedom of rigid bodies: `Pᵀ K P` with `δd_i = δθ × d_i`.

use super::assembly::pairs;
use super::{DofMap, LocalFrames};
use crate::Mat3;
use crate::element::ElementGroup;

/// Contributions of a group that contain directors of rigid bodies. In the tangent the first director of a body stands for
/// its rotation, and the blocks of all three are transformed and added there.
#[derive(Debug, Clone, PartialEq)]
pub struct Reduction {
    members: Vec<Member>,
}

/// One contribution: its vectors in the tangent, and how its own ones depend on them.
#[derive(Debug, Clone, PartialEq, Default)]
struct Member {
    /// Nodal vectors of the tangent.
    vectors: Vec<u32>,
    /// For each nodal vector of the contribution its place in `vectors`, and body and number of a director.
    parts: Vec<(usize, Option<(usize, usize)>)>,
}

impl Reduction {
    /// Reduction of a group; `None` if it contains no directors of rigid bodies.
    pub fn new(group: &dyn ElementGroup, dofs: &DofMap) -> Option<Self> {
        if dofs.triads.is_empty() {
            return None;
        }
        let members: Vec<Member> = (0..group.len()).map(|e| Member::new(group.vectors(e), dofs)).collect();
        let found = members.iter().flat_map(|member| &member.parts).any(|(_, director)| director.is_some());
        found.then_some(Self { members })
    }

    /// Nodal vectors of a contribution in the tangent.
    pub fn vectors(&self, member: usize) -> &[u32] {
        &self.members[member].vectors
    }

    /// Number of reduced blocks of contributions.
    pub fn blocks(&self, members: std::ops::Range<usize>) -> usize {
        self.members[members].iter().map(|member| pairs(member.vectors.len())).sum()
    }

    /// Writes the reduced lower blocks of contributions from `first` on, one after another.
    pub fn reduce(&self, first: usize, frames: &LocalFrames, blocks: &[f64], out: &mut [f64]) {
        let (mut blocks, mut out) = (blocks, out);
        for member in &self.members[first..] {
            let (own, reduced) = (9 * pairs(member.parts.len()), 9 * pairs(member.vectors.len()));
            if blocks.len() < own {
                break;
            }
            let (block, rest) = blocks.split_at(own);
            let (target, others) = std::mem::take(&mut out).split_at_mut(reduced);
            member.reduce(frames, block, target);
            (blocks, out) = (rest, others);
        }
    }
}

impl Member {
    fn new(vectors: &[u32], dofs: &DofMap) -> Self {
        let mut out = Self::default();
        for &v in vectors {
            let place = |(body, triad): (usize, &[u32; 3])| Some((body, triad.iter().position(|d| *d == v)?));
            let director = dofs.triads.iter().enumerate().find_map(place);
            let vector = director.map_or(v, |(body, _)| dofs.triads[body][0]);
            let at = out.vectors.iter().position(|w| *w == vector).unwrap_or_else(|| {
                out.vectors.push(vector);
                out.vectors.len() - 1
            });
            out.parts.push((at, director));
        }
        out
    }

    fn reduce(&self, frames: &LocalFrames, blocks: &[f64], out: &mut [f64]) {
        out.fill(0.0);
        let transform = |director: Option<(usize, usize)>| -> Option<Mat3> {
            let (body, i) = director?;
            // δd = δθ × d = −[d]× δθ
            Some(-frames.triad(body).column(i).into_owned().cross_matrix())
        };
        let mut pair = 0;
        for (a, &(i, director_a)) in self.parts.iter().enumerate() {
            let p = transform(director_a);
            for (b, &(j, director_b)) in self.parts[..=a].iter().enumerate() {
                let mut k = Mat3::from_row_slice(&blocks[9 * pair..9 * pair + 9]);
                pair += 1;
                if let Some(p) = p {
                    k = p.transpose() * k;
                }
                if let Some(q) = transform(director_b) {
                    k *= q;
                }
                if i < j {
                    k = k.transpose();
                } else if i == j && a != b {
                    k += k.transpose();
                }
                let (row, column) = (i.max(j), i.min(j));
                let at = 9 * (row * (row + 1) / 2 + column);
                for (entry, x) in out[at..at + 9].iter_mut().enumerate() {
                    *x += k[(entry / 3, entry % 3)];
                }
            }
        }
    }
}
