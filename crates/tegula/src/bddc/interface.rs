//! The unknowns that pieces share, and sums over the pieces.

use rayon::prelude::*;

use super::SubdomainData;
use super::deluxe_scaling::Group;
use super::subdomain::Subdomain;
use crate::lists::Lists;

/// Unknowns of the borders: dual ones first, then those of corners.
pub(super) struct Interface {
    /// Free coordinate of each.
    pub unknowns: Vec<u32>,
    /// How many are dual.
    dual: usize,
    /// Pieces that hold each, and its places in their borders.
    sources: Lists<(u32, u32)>,
    /// For each piece, the unknowns of its border.
    pub of_subdomain: Vec<Vec<u32>>,
}

impl Interface {
    /// The dual unknowns of `groups` come first, group by group.
    pub fn new(subdomains: &[Subdomain], unknowns: usize, groups: &[Group]) -> Self {
        // 1: dual, 2: corner.
        let mut kind = vec![0_u8; unknowns];
        for subdomain in subdomains {
            for (k, &u) in subdomain.unknowns[subdomain.inner..].iter().enumerate() {
                kind[u as usize] = if k < subdomain.dual { 1 } else { 2 };
            }
        }
        let of_kind =
            |wanted: u8| kind.iter().enumerate().filter(move |(_, k)| **k == wanted).map(|(u, _)| u as u32);
        let mut list: Vec<u32> = groups.iter().flat_map(|g| &g.unknowns).copied().collect();
        let mut grouped = vec![false; unknowns];
        list.iter().for_each(|&u| grouped[u as usize] = true);
        list.extend(of_kind(1).filter(|&u| !grouped[u as usize]));
        let dual = list.len();
        list.extend(of_kind(2));
        let mut number = vec![u32::MAX; unknowns];
        for (n, &u) in list.iter().enumerate() {
            number[u as usize] = n as u32;
        }
        let of_subdomain: Vec<Vec<u32>> = subdomains
            .iter()
            .map(|p| p.unknowns[p.inner..].iter().map(|&u| number[u as usize]).collect())
            .collect();
        let places = of_subdomain
            .iter()
            .enumerate()
            .flat_map(|(p, of)| of.iter().enumerate().map(move |(k, &n)| (n, (p as u32, k as u32))));
        let sources = Lists::by_key(list.len(), places);
        Self { unknowns: list, dual, sources, of_subdomain }
    }

    /// Unknowns of the borders.
    pub fn len(&self) -> usize {
        self.unknowns.len()
    }

    /// Those that are not at corners.
    pub fn dual(&self) -> usize {
        self.dual
    }

    /// Those at corners.
    pub fn primal(&self) -> usize {
        self.len() - self.dual
    }

    /// How many pieces share an unknown.
    pub fn subdomains(&self, unknown: u32) -> usize {
        self.sources(unknown as usize).len()
    }

    /// Pieces that hold an unknown, and its places in their borders.
    pub fn sources(&self, unknown: usize) -> &[(u32, u32)] {
        self.sources.of(unknown)
    }

    /// Adds what the pieces hold in `y` for the unknowns from `first` on.
    pub fn add(&self, data: &[SubdomainData], first: usize, out: &mut [f64]) {
        out.par_iter_mut().with_min_len(4096).enumerate().for_each(|(n, out)| {
            for &(subdomain, at) in self.sources(first + n) {
                *out += data[subdomain as usize].y[at as usize];
            }
        });
    }

    /// Finds the shares of the pieces in the dual unknowns, by the diagonals of their matrices. They add up to one.
    pub fn weigh(&self, subdomains: &[Subdomain], data: &mut [SubdomainData]) {
        for datum in data.iter_mut() {
            let Some(factored) = &datum.factored else { continue };
            datum.y.iter_mut().zip(factored.schur.diagonal()).for_each(|(y, d)| *y = d);
        }
        let mut sums = vec![0.0; self.dual];
        self.add(data, 0, &mut sums);
        for ((datum, subdomain), of) in data.iter_mut().zip(subdomains).zip(&self.of_subdomain) {
            let shares = datum.y.iter().zip(of).take(subdomain.dual);
            datum.weights = shares.map(|(y, &n)| y / sums[n as usize]).collect();
        }
    }
}
