//! Distribution of the subdomains over the ranks of a run on several processes.
//!
//! Every rank analyses, assembles, factors and solves subdomains of its own, and has the vectors of the interface as a whole. Values of subdomains are gathered
//! before they are summed, and each rank sums them in the order of the subdomains: results are those of a single process to the last bit, for any number of ranks.

use std::ops::Range;
use std::sync::{Arc, OnceLock};

use super::subdomain::Refused;
use super::{BddcError, SubdomainData};

/// Ranks of a run on several processes, which go through it in step.
pub trait Ranks: Send + Sync {
    /// Number of this rank, from 0.
    fn rank(&self) -> usize;

    /// Number of ranks.
    fn size(&self) -> usize;

    /// Gathers parts of a vector (collective): each rank r has `values[begins[r]..begins[r + 1]]`, and all of them have the whole vector then.
    ///
    /// # Errors
    /// The ranks cannot communicate; the text gives the reason.
    fn gather(&self, values: &mut [f64], begins: &[usize]) -> Result<(), String>;
}

/// Ranks of the process.
static RANKS: OnceLock<Arc<dyn Ranks>> = OnceLock::new();

/// Shares the subdomains of all iterative solvers of this process with other ranks from now on.
///
/// # Errors
/// The process has ranks already, which are given back.
pub fn share_subdomains(ranks: Arc<dyn Ranks>) -> Result<(), Arc<dyn Ranks>> {
    RANKS.set(ranks)
}

/// Ranks of the process, with which it shares its subdomains.
pub(super) fn of_process() -> Option<Arc<dyn Ranks>> {
    RANKS.get().cloned()
}

/// Subdomains of this rank, and their exchange with other ranks.
pub(super) struct Distribution {
    ranks: Option<Arc<dyn Ranks>>,
    /// Subdomains of this rank.
    own: Range<usize>,
    /// First subdomain of each rank, and their number.
    first: Vec<usize>,
    /// Values of all subdomains, one after another, and the places of the first ones of each rank.
    values: Vec<f64>,
    begins: Vec<usize>,
}

impl Distribution {
    /// Distribution of `count` subdomains: neighbours have numbers next to each other, and all ranks as many of them.
    pub fn new(ranks: Option<Arc<dyn Ranks>>, count: usize) -> Self {
        let (rank, size) = ranks.as_ref().map_or((0, 1), |ranks| (ranks.rank(), ranks.size().max(1)));
        let first: Vec<usize> = (0..=size).map(|r| count * r / size).collect();
        let own = first[rank]..first[rank + 1];
        Self { ranks: ranks.filter(|_| size > 1), own, first, values: Vec::new(), begins: vec![0; size + 1] }
    }

    /// Subdomains of this rank.
    pub fn own(&self) -> Range<usize> {
        self.own.clone()
    }

    /// Outcome of this rank, or an error where that of another one is an error (collective).
    ///
    /// # Errors
    /// This rank or another one has an error, or the ranks cannot communicate.
    pub fn agree(&mut self, outcome: Result<(), BddcError>) -> Result<(), BddcError> {
        let Some(ranks) = &self.ranks else { return outcome };
        let begins: Vec<usize> = (0..=ranks.size()).collect();
        let mut failed = vec![0.0; ranks.size()];
        failed[ranks.rank()] = f64::from(u8::from(outcome.is_err()));
        ranks.gather(&mut failed, &begins).map_err(BddcError::Ranks)?;
        outcome?;
        match failed.iter().position(|failed| *failed != 0.0) {
            None => Ok(()),
            Some(rank) => Err(BddcError::Ranks(format!("rank {rank} has not all terms of its subdomains"))),
        }
    }

    /// Outcome of work on this rank's subdomains, the same in all ranks: that of the first subdomain of all that was refused (collective).
    ///
    /// # Errors
    /// A subdomain was refused, or the ranks cannot communicate.
    pub fn settle(&mut self, done: impl Iterator<Item = Result<(), Refused>>) -> Result<(), BddcError> {
        let count = self.first.last().copied().unwrap_or(0);
        let mut codes = vec![0.0; count];
        for (code, result) in codes[self.own.clone()].iter_mut().zip(done) {
            *code = result.err().map_or(0.0, |refused| refused.code());
        }
        self.gather(&mut codes, (0..count).map(|p| (p, 1)))?;
        codes.iter().find_map(|code| Refused::of_code(*code)).map_or(Ok(()), |refused| Err(refused.into()))
    }

    /// Gathers a part of the data of each subdomain from the rank to which it belongs (collective).
    ///
    /// # Errors
    /// The ranks cannot communicate.
    pub fn exchange(
        &mut self,
        data: &mut [SubdomainData],
        part: impl for<'a> Fn(usize, &'a mut SubdomainData) -> &'a mut [f64],
    ) -> Result<(), BddcError> {
        if self.ranks.is_none() {
            return Ok(());
        }
        let mut values = std::mem::take(&mut self.values);
        values.clear();
        for (p, datum) in data.iter_mut().enumerate() {
            values.extend_from_slice(part(p, datum));
        }
        let result =
            self.gather(&mut values, data.iter_mut().enumerate().map(|(p, datum)| (p, part(p, datum).len())));
        let mut rest = values.as_slice();
        for (p, datum) in data.iter_mut().enumerate() {
            let part = part(p, datum);
            let (own, others) = rest.split_at(part.len());
            if !self.own.contains(&p) {
                part.copy_from_slice(own);
            }
            rest = others;
        }
        self.values = values;
        result
    }

    /// Gathers values that belong to subdomains in ascending order, each with its number of values (collective).
    ///
    /// # Errors
    /// The ranks cannot communicate.
    pub fn gather(
        &mut self,
        values: &mut [f64],
        of: impl Iterator<Item = (usize, usize)>,
    ) -> Result<(), BddcError> {
        let Some(ranks) = &self.ranks else { return Ok(()) };
        self.begins.fill(0);
        let mut rank = 0;
        for (p, count) in of {
            while self.first[rank + 1] <= p {
                rank += 1;
            }
            self.begins[rank + 1] += count;
        }
        for r in 1..self.begins.len() {
            self.begins[r] += self.begins[r - 1];
        }
        ranks.gather(values, &self.begins).map_err(BddcError::Ranks)
    }
}
