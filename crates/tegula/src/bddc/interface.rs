//! Interface Γ: the unknowns that subdomains share, and assembly over the subdomains.

use rayon::prelude::*;

use super::deluxe_scaling::Group;
use super::ranks::Distribution;
use super::subdomain::Subdomain;
use super::{BddcError, SubdomainData};
use crate::lists::Lists;

/// Interface unknowns: dual unknowns first, then primal unknowns.
pub(super) struct Interface {
    /// Free degree of freedom of each interface unknown.
    pub unknowns: Vec<u32>,
    /// Number of dual unknowns.
    dual: usize,
    /// Subdomains that share each unknown, and its positions on their interfaces.
    sources: Lists<(u32, u32)>,
    /// Interface unknowns of each subdomain.
    pub of_subdomain: Vec<Vec<u32>>,
}

impl Interface {
    /// Numbers the interface unknowns. The dual unknowns of the interface edges `groups` come first, edge by edge.
    pub fn new(subdomains: &[Subdomain], unknowns: usize, groups: &[Group]) -> Self {
        // The kind 1 is dual, 2 is primal.
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

    /// Number of interface unknowns.
    pub fn len(&self) -> usize {
        self.unknowns.len()
    }

    /// Number of dual unknowns.
    pub fn dual(&self) -> usize {
        self.dual
    }

    /// Number of primal unknowns.
    pub fn primal(&self) -> usize {
        self.len() - self.dual
    }

    /// Number of subdomains that share an interface unknown.
    pub fn subdomains(&self, unknown: u32) -> usize {
        self.sources(unknown as usize).len()
    }

    /// Subdomains that share an interface unknown, and its positions on their interfaces.
    pub fn sources(&self, unknown: usize) -> &[(u32, u32)] {
        self.sources.of(unknown)
    }

    /// Assembles the interface values `y` of the subdomains: adds them to `out` for the unknowns from `first` on.
    pub fn add(&self, data: &[SubdomainData], first: usize, out: &mut [f64]) {
        out.par_iter_mut().with_min_len(4096).enumerate().for_each(|(n, out)| {
            for &(subdomain, at) in self.sources(first + n) {
                *out += data[subdomain as usize].y[at as usize];
            }
        });
    }

    /// Weights of the subdomains at the dual unknowns (stiffness scaling), from the diagonals of their Schur
    /// complements. They add up to one.
    ///
    /// # Errors
    /// The ranks cannot communicate.
    pub fn weigh(
        &self,
        subdomains: &[Subdomain],
        data: &mut [SubdomainData],
        distribution: &mut Distribution,
    ) -> Result<(), BddcError> {
        for datum in data.iter_mut() {
            let Some(schur) = &datum.schur else { continue };
            datum.y.iter_mut().zip(schur.diagonal()).for_each(|(y, d)| *y = d);
        }
        distribution.exchange(data, |_, datum| &mut datum.y)?;
        let mut sums = vec![0.0; self.dual];
        self.add(data, 0, &mut sums);
        for ((datum, subdomain), of) in data.iter_mut().zip(subdomains).zip(&self.of_subdomain) {
            let shares = datum.y.iter().zip(of).take(subdomain.dual);
            datum.weights = shares.map(|(y, &n)| y / sums[n as usize]).collect();
        }
        Ok(())
    }
}
