//! Deluxe scaling: averages over the interface edges of two subdomains, weighted by the Schur complements of both.
//!
//! On an interface edge, between primal nodes, the subdomains 1 and 2 have the Schur complements `S₁` and `S₂`. The
//! averaging operator `E_D` averages their values there as
//!
//! ```text
//! u = D u₁ + (1 − D) u₂,   D = (S₁ + S₂)⁻¹ S₁
//! ```
//!
//! and its transpose distributes forces between them. On regular meshes this is the arithmetic mean. Where elements are
//! distorted, the directors and positions of a thin shell must be weighted together, or the average shears.
//!
//! C. R. Dohrmann, O. B. Widlund, *A BDDC algorithm with deluxe scaling for three-dimensional H(curl) problems*,
//! Comm. Pure Appl. Math. 69 (2016) 745–770.

use std::collections::{BTreeMap, HashMap};

use nalgebra::{DMatrix, DMatrixViewMut};
use rayon::prelude::*;
use tegula_sparse::dense::{Diagonal, PartialCholesky, solve_lower_from_right};

use super::interface::Interface;
use super::primal_nodes::Sharing;
use super::ranks::Distribution;
use super::{BddcError, SubdomainData};
use crate::system::LocalFrames;
use crate::system::dof_map::CONSTRAINED;

/// Number of interface edges that one task works on.
const TOGETHER: usize = 64;

/// Unknowns of an interface edge between two subdomains.
pub(super) struct Group {
    /// Free degrees of freedom.
    pub unknowns: Vec<u32>,
    subdomains: [u32; 2],
}

/// Finds the interface edges among the unknowns that two subdomains share.
pub(super) fn groups(
    sharing: &Sharing,
    edges: &HashMap<u32, u32>,
    node_of: &[u32],
    frames: &LocalFrames,
) -> Vec<Group> {
    let mut found: BTreeMap<(u32, [u32; 2]), Vec<u32>> = BTreeMap::new();
    for (&v, subdomains) in &sharing.shared {
        let (Some(&edge), &[a, b]) = (edges.get(&node_of[v as usize]), subdomains.as_slice()) else {
            continue;
        };
        let free = frames.of(v as usize).into_iter().filter(|&n| n != CONSTRAINED);
        found.entry((edge, [a, b])).or_default().extend(free);
    }
    let groups = found.into_iter().map(|((_, subdomains), unknowns)| Group { unknowns, subdomains });
    groups.filter(|g| !g.unknowns.is_empty()).collect()
}

/// Deluxe scaling: averaging operator `E_D` on all interface edges.
pub(super) struct DeluxeScaling {
    members: Vec<Member>,
    /// First subdomain of each unknown of an interface edge.
    first: Vec<u32>,
    /// Share of the first subdomain in the force on each unknown.
    shares: Vec<f64>,
    /// Subdomains of the edges in ascending order, each with the number of the edge and the place of the subdomain there.
    sides: Vec<(u32, u32, usize)>,
}

struct Member {
    /// Start of its unknowns among those of all interface edges.
    start: usize,
    /// Subdomains of the edge; `places` are the positions of the unknowns on their interfaces.
    subdomains: [u32; 2],
    places: [Vec<u32>; 2],
    /// Starts of the Schur complements of the subdomains at its unknowns, among those of all edges.
    minors: [usize; 2],
    /// Scaling matrix `D`, by columns.
    matrix: Vec<f64>,
}

impl Member {
    fn len(&self) -> usize {
        self.places[0].len()
    }
}

impl DeluxeScaling {
    pub fn new(groups: &[Group], interface: &Interface) -> Self {
        let mut first = Vec::new();
        let mut members: Vec<Member> = groups
            .iter()
            .map(|g| {
                let start = first.len();
                first.resize(start + g.unknowns.len(), g.subdomains[0]);
                let places = g.subdomains.map(|subdomain| {
                    let place =
                        |n: usize| interface.sources(n).iter().find(|s| s.0 == subdomain).map_or(0, |s| s.1);
                    (start..first.len()).map(place).collect()
                });
                Member { start, subdomains: g.subdomains, places, minors: [0; 2], matrix: Vec::new() }
            })
            .collect();
        let shares = vec![0.0; first.len()];
        let of_edge = |(m, member): (u32, &Member)| [0, 1].map(|k| (member.subdomains[k], m, k));
        let mut sides: Vec<(u32, u32, usize)> = (0..).zip(&members).flat_map(of_edge).collect();
        sides.sort_unstable();
        let mut start = 0;
        for &(_, m, k) in &sides {
            let member = &mut members[m as usize];
            member.minors[k] = start;
            start += member.len().pow(2);
        }
        Self { members, first, shares, sides }
    }

    /// Number of unknowns of all interface edges, which are the first of the dual unknowns.
    pub fn len(&self) -> usize {
        self.first.len()
    }

    /// Computes the scaling matrices `D` of all interface edges.
    ///
    /// # Errors
    /// The sum of the Schur complements at an edge is not positive definite, or the ranks cannot communicate.
    pub fn weigh(
        &mut self,
        data: &[SubdomainData],
        distribution: &mut Distribution,
    ) -> Result<(), BddcError> {
        let Self { members, sides, .. } = self;
        let order = |m: u32| members[m as usize].len().pow(2);
        let mut minors = vec![0.0; sides.iter().map(|side| order(side.1)).sum()];
        let mut rest = minors.as_mut_slice();
        for &(p, m, k) in sides.iter() {
            let (minor, others) = rest.split_at_mut(order(m));
            if let Some(schur) = &data[p as usize].schur {
                schur.add_minor(&members[m as usize].places[k], minor);
            }
            rest = others;
        }
        distribution.gather(&mut minors, sides.iter().map(|&(p, m, _)| (p as usize, order(m))))?;
        let done: Vec<Option<()>> = members
            .par_iter_mut()
            .map(|member| {
                let n = member.len();
                let [mut first, mut sum] = member.minors.map(|start| minors[start..start + n * n].to_vec());
                for j in 0..n {
                    for i in j..n {
                        sum[j * n + i] += first[j * n + i];
                        first[i * n + j] = first[j * n + i];
                    }
                }
                member.matrix = quotient(&mut sum, &mut first, n)?;
                Some(())
            })
            .collect();
        if done.iter().all(Option::is_some) {
            Ok(())
        } else {
            Err(BddcError::Indefinite("an interface edge between two subdomains of the shell is unstable"))
        }
    }

    /// Distributes the forces `r` between the two subdomains of each edge: the first one takes `Dᵀ r`.
    pub fn share(&mut self, r: &[f64]) {
        each(&self.members, &mut self.shares, &|member, shares| {
            let n = member.len();
            let r = &r[member.start..member.start + n];
            for (share, column) in shares.iter_mut().zip(member.matrix.chunks_exact(n)) {
                *share = super::schur_complement::dot(column, r);
            }
        });
    }

    /// Share of a subdomain in the force on an unknown; none if the unknown is on no interface edge.
    pub fn part(&self, unknown: u32, subdomain: u32, r: &[f64]) -> Option<f64> {
        let n = unknown as usize;
        let first = *self.first.get(n)?;
        Some(if first == subdomain { self.shares[n] } else { r[n] - self.shares[n] })
    }

    /// Averages the values `y` of the subdomains on the interface edges, `D u₁ + (1 − D) u₂`.
    pub fn average(&self, data: &[SubdomainData], out: &mut [f64]) {
        each(&self.members, out, &|member, out| {
            let n = member.len();
            let [a, b] = member.subdomains.map(|p| &data[p as usize].y);
            for (out, &q) in out.iter_mut().zip(&member.places[1]) {
                *out = b[q as usize];
            }
            for (j, (&p, &q)) in member.places[0].iter().zip(&member.places[1]).enumerate() {
                let difference = a[p as usize] - b[q as usize];
                for (out, d) in out.iter_mut().zip(&member.matrix[j * n..(j + 1) * n]) {
                    *out += d * difference;
                }
            }
        });
    }
}

/// Quotient `S⁻¹ A` by columns for a positive definite matrix S, given by its lower triangle, and a symmetric matrix A.
fn quotient(s: &mut [f64], a: &mut [f64], n: usize) -> Option<Vec<f64>> {
    let mut l = DMatrixViewMut::from_slice(s, n, n);
    if !PartialCholesky::default().factor(l.as_view_mut()) {
        return None;
    }
    let mut x = DMatrixViewMut::from_slice(a, n, n);
    solve_lower_from_right(l.as_view(), Diagonal::Stored, x.as_view_mut());
    // The transpose of `S⁻¹ A = L⁻ᵀ (A L⁻ᵀ)ᵀ` is `A L⁻ᵀ L⁻¹`: in reversed order, L is the transpose of a lower triangle.
    let last = n.saturating_sub(1);
    let reversed = DMatrix::from_fn(n, n, |i, j| if i < j { 0.0 } else { l[(last - j, last - i)] });
    let mut y = DMatrix::from_fn(n, n, |i, j| x[(i, last - j)]);
    solve_lower_from_right(reversed.as_view(), Diagonal::Stored, y.as_view_mut());
    Some((0..n).flat_map(|j| (0..n).map(move |i| (i, j))).map(|(i, j)| y[(j, last - i)]).collect())
}

/// Calls `datum` for all interface edges, each with its own part of the values. Recursive halving avoids allocations
/// during the iteration.
fn each(members: &[Member], values: &mut [f64], datum: &(impl Fn(&Member, &mut [f64]) + Sync)) {
    if members.len() <= TOGETHER {
        let mut rest = values;
        for member in members {
            let (own, others) = rest.split_at_mut(member.len());
            datum(member, own);
            rest = others;
        }
        return;
    }
    let (a, b) = members.split_at(members.len() / 2);
    let (of_a, of_b) = values.split_at_mut(b[0].start - a[0].start);
    rayon::join(|| each(a, of_a, datum), || each(b, of_b, datum));
}
