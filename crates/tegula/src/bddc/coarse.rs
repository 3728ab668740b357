//! Coarse problem of BDDC: the Schur complements of the subdomains, assembled at the primal unknowns.

use super::interface::Interface;
use super::subdomain::Subdomain;
use super::{BddcError, SubdomainData};
use tegula_sparse::{Factor as _, SparseLdlt, SymmetricPattern};

pub(super) struct Coarse {
    solver: Option<SparseLdlt>,
    values: Vec<f64>,
    /// Places of each subdomain's primal Schur complement (lower triangle, column by column) in the coarse matrix.
    places: Vec<Vec<u32>>,
}

impl Coarse {
    pub fn new(subdomains: &[Subdomain], interface: &Interface) -> Result<Self, BddcError> {
        let n = interface.primal();
        if n == 0 {
            return Ok(Self { solver: None, values: Vec::new(), places: vec![Vec::new(); subdomains.len()] });
        }
        let primal_of = |p: usize| {
            let dual = interface.dual() as u32;
            interface.of_subdomain[p][subdomains[p].dual..].iter().map(move |&u| u - dual)
        };
        let mut columns: Vec<Vec<u32>> = (0..n as u32).map(|j| vec![j]).collect();
        for p in 0..subdomains.len() {
            let of: Vec<u32> = primal_of(p).collect();
            for (k, &j) in of.iter().enumerate() {
                columns[j as usize].extend(&of[k + 1..]);
                columns[j as usize].sort_unstable();
                columns[j as usize].dedup();
            }
        }
        let mut pointers = vec![0];
        let mut rows: Vec<u32> = Vec::new();
        for column in &columns {
            rows.extend(column);
            pointers.push(rows.len());
        }
        let places = (0..subdomains.len())
            .map(|p| {
                let of: Vec<u32> = primal_of(p).collect();
                let mut out = Vec::with_capacity(of.len() * (of.len() + 1) / 2);
                for (k, &j) in of.iter().enumerate() {
                    let start = pointers[j as usize];
                    let column = &rows[start..pointers[j as usize + 1]];
                    out.extend(of[k..].iter().map(|&i| (start + column.partition_point(|&r| r < i)) as u32));
                }
                out
            })
            .collect();
        let values = vec![0.0; rows.len()];
        let solver = SparseLdlt::new(&SymmetricPattern::new(pointers, rows))?;
        Ok(Self { solver: Some(solver), values, places })
    }

    /// Assembles the subdomains' Schur complements at the primal unknowns, which are consumed, and factors the coarse
    /// matrix.
    pub fn factor(&mut self, data: &mut [SubdomainData]) -> Result<(), BddcError> {
        let Some(solver) = &mut self.solver else { return Ok(()) };
        self.values.fill(0.0);
        for (datum, places) in data.iter_mut().zip(&self.places) {
            for (&at, value) in places.iter().zip(std::mem::take(&mut datum.primal)) {
                self.values[at as usize] += value;
            }
        }
        if solver.factor(&self.values)?.negative > 0 {
            return Err(BddcError::Indefinite(
                "the coarse matrix of the primal unknowns is not positive definite",
            ));
        }
        Ok(())
    }

    /// Solves the coarse problem in place.
    pub fn solve(&mut self, x: &mut [f64]) {
        if let Some(solver) = &mut self.solver {
            solver.solve(x);
        }
    }
}
