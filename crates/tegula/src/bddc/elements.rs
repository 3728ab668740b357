//! Terms of the tangent for BDDC, which partitions the mesh into subdomains.

use std::sync::Arc;

use super::ranks::{self, Ranks};
use super::{Bddc, BddcError, Options, Quads, Terms};
use crate::Vec3;
use crate::lists::Lists;
use crate::system::{System, VectorKind};

impl System {
    /// BDDC solver that partitions the mesh of this system into subdomains, shared with the ranks of [`share_subdomains`](super::share_subdomains). Its terms are the elements of all groups,
    /// then the follower loads.
    ///
    /// # Errors
    /// There is not enough memory.
    pub fn bddc(&self, options: &Options) -> Result<Bddc, BddcError> {
        self.bddc_on_ranks(options, ranks::of_process())
    }

    /// BDDC solver like [`Self::bddc`], of whose subdomains each of these ranks has some.
    ///
    /// # Errors
    /// There is not enough memory.
    pub fn bddc_on_ranks(&self, options: &Options, ranks: Option<Arc<dyn Ranks>>) -> Result<Bddc, BddcError> {
        let coordinates = &self.coordinates;
        let positions: Vec<Vec3> = coordinates
            .position_of
            .iter()
            .map(|&p| coordinates.reference.get(p as usize).map_or_else(Vec3::zeros, |r| Vec3::from(*r)))
            .collect();
        let mut quads = vec![[0; 4]; self.shells.len()];
        let mut shell_of: Vec<Vec<u32>> = self.groups.iter().map(|g| vec![u32::MAX; g.len()]).collect();
        for (s, (shell, quad)) in self.shells.iter().zip(&mut quads).enumerate() {
            for group in shell.groups.clone() {
                shell_of[group][shell.member] = s as u32;
            }
            let Some(group) = self.groups.get(shell.groups.start) else { continue };
            let corners = group.vectors(shell.member).iter().map(|&v| v as usize);
            let corners = corners.filter(|&v| coordinates.kinds[v] == VectorKind::Position);
            quad.iter_mut().zip(corners).for_each(|(n, v)| *n = coordinates.nodes[v]);
        }
        let around = quads.iter().enumerate().flat_map(|(q, quad)| quad.iter().map(move |&n| (n, q as u32)));
        let quads_of = Lists::by_key(positions.len(), around);
        // Terms other than shells go to the shell that holds most of their vectors.
        let home = |vectors: &[u32]| {
            let around = |v: &u32| quads_of.of(coordinates.nodes[*v as usize] as usize).iter().copied();
            let held = |q: u32| {
                let holds = |s: usize, v: u32| {
                    let shell = &self.shells[s];
                    shell.groups.clone().any(|g| self.groups[g].vectors(shell.member).contains(&v))
                };
                vectors.iter().filter(|&&v| holds(q as usize, v)).count()
            };
            vectors.iter().flat_map(around).max_by_key(|&q| (held(q), std::cmp::Reverse(q))).unwrap_or(0)
        };
        let mut terms = Terms::default();
        for (group, shells) in self.groups.iter().zip(&shell_of) {
            for (e, &shell) in shells.iter().enumerate() {
                let vectors = group.vectors(e);
                if shell == u32::MAX {
                    terms.push_tie(vectors, home(vectors));
                } else {
                    terms.push(vectors, shell);
                }
            }
        }
        for load in &self.followers {
            terms.push_tie(load.vectors(), home(load.vectors()));
        }
        let quads = Quads { nodes: &quads, positions: &positions };
        Bddc::new(quads, &terms, &coordinates.nodes, &self.frames, (options, ranks))
    }
}
