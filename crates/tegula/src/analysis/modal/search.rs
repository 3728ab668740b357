//! Lowest elastic modes of a group of parts: block Lanczos, or a dense eigensolver where nearly all of them are wanted.

use super::convergence::{Target, ritz_pairs};
use super::dense;
use super::problem::{Problem, go_on};
use crate::Result;
use crate::analysis::Observer;
use crate::norm::larger;
use tegula_sparse::lanczos::{BlockLanczos, RitzPair};

/// Basis vectors per wanted mode before the iteration gives up.
const BASIS_PER_MODE: usize = 40;
/// Number of modes computed beyond the wanted ones, to find a gap behind them.
const EXTRA: usize = 4;
/// Shift over an estimate of the lowest eigenvalue where this is negative.
const BELOW: f64 = 2.0;
/// Distance of the shift below zero, as a part of the eigenvalue of the last wanted mode.
const SHIFT: f64 = 0.05;
/// Largest number of unknowns of a group that the dense eigensolver takes.
const DENSE: usize = 1600;
/// Distance of neighbouring eigenvalues, over their value, above which there is a gap between them.
const GAP: f64 = 1e-4;

/// Search for the lowest modes of a group.
pub(super) struct Search {
    group: usize,
    /// Number of elastic modes that are wanted.
    wanted: usize,
    lanczos: Option<BlockLanczos>,
    pairs: Vec<RitzPair>,
    /// Eigenvalues λ of the pairs, ascending.
    lambdas: Vec<f64>,
}

impl Search {
    /// Search for the lowest `wanted` elastic modes of a group.
    pub fn new(problem: &Problem, group: usize, wanted: usize) -> Self {
        let wanted = wanted.min(problem.modes_of(group));
        Self { group, wanted, lanczos: None, pairs: Vec::new(), lambdas: Vec::new() }
    }

    /// Number of pairs to be found: the wanted ones and some beyond.
    fn extra(&self, problem: &Problem) -> usize {
        (self.wanted + EXTRA).min(problem.modes_of(self.group))
    }

    fn is_dense(&self, problem: &Problem) -> bool {
        let group = &problem.groups[self.group];
        // Joints take modes from the space of the group, which the dense solver does not know.
        problem.modes_of(self.group) == group.elastic()
            && 2 * self.extra(problem) >= group.elastic()
            && group.unknowns.len() <= DENSE
    }

    fn block(&self) -> usize {
        self.wanted.clamp(2, 8)
    }

    /// Estimates the eigenvalue of the last wanted mode by a few blocks, and sets the group's shift to a part of it:
    /// with a shift of that size Lanczos converges fast and the matrix stays well conditioned.
    pub fn estimate(&mut self, problem: &mut Problem, observer: &dyn Observer) -> Result<()> {
        if self.wanted == 0 || self.is_dense(problem) {
            return Ok(());
        }
        let elastic = problem.groups[self.group].elastic();
        let shift = problem.groups[self.group].shift;
        let mut operator = problem.operator(self.group, observer);
        let mut lanczos = BlockLanczos::new(&mut operator, self.block());
        while lanczos.len() < (2 * self.wanted + 8).min(elastic) && lanczos.expand(&mut operator) > 0 {}
        go_on(observer)?;
        let values = lanczos.ritz_values();
        let eigenvalue = |i: usize| values.get(i).map_or(0.0, |v| shift + 1.0 / v.0);
        let (lowest, estimate) = (eigenvalue(0), eigenvalue(self.wanted - 1));
        if estimate > 0.0 {
            // About an unstable equilibrium negative eigenvalues may be the largest ones.
            problem.groups[self.group].shift = f64::min(-SHIFT * estimate, BELOW * lowest);
        }
        Ok(())
    }

    /// Finds the modes with the present factor, that of the groups' shifts. A repeated call looks for modes that were
    /// missed.
    pub fn run(&mut self, problem: &mut Problem, observer: &mut dyn Observer) -> Result<()> {
        if self.wanted == 0 {
            return Ok(());
        }
        if self.is_dense(problem) {
            self.pairs = dense::all(problem, self.group, observer)?;
        } else {
            self.iterate(problem, observer)?;
        }
        let shift = problem.groups[self.group].shift;
        self.lambdas = self.pairs.iter().map(|p| shift + 1.0 / p.value).collect();
        Ok(())
    }

    fn iterate(&mut self, problem: &mut Problem, observer: &mut dyn Observer) -> Result<()> {
        let (extra, elastic) = (self.extra(problem), problem.groups[self.group].elastic());
        let block = self.block();
        let limit = (BASIS_PER_MODE * extra + 200).min(elastic);
        let lanczos = match &mut self.lanczos {
            Some(lanczos) => {
                lanczos.add_random(&mut problem.operator(self.group, &*observer));
                lanczos
            }
            none => none.insert(BlockLanczos::new(&mut problem.operator(self.group, &*observer), block)),
        };
        let target = Target { name: "elastic mode", wanted: [self.wanted, extra], size: elastic, limit };
        let group = self.group;
        let expand = |lanczos: &mut BlockLanczos, watch: &dyn Observer| {
            lanczos.expand(&mut problem.operator(group, watch))
        };
        self.pairs = ritz_pairs(lanczos, expand, &target, observer)?;
        Ok(())
    }

    /// Place of a Sturm sequence count, and the number of eigenvalues expected below it: in a gap behind the last
    /// wanted mode, or else in front of the modes of nearly equal frequency that it belongs to. The place is the
    /// fraction `part` of the way from one side of the gap to the other.
    pub fn gap(&self, problem: &Problem, part: f64) -> (f64, usize) {
        let rigid = problem.groups[self.group].rigid.len();
        if let Some(last) = self.lambdas.last().filter(|_| self.lambdas.len() == problem.modes_of(self.group))
        {
            // All modes of the group lie below any place behind the last one.
            return (
                last + (1.0 + part) * larger(last.abs(), problem.groups[self.group].lowest),
                rigid + self.lambdas.len(),
            );
        }
        // Mechanisms have eigenvalues of the size of the round-off.
        let size = |i: usize| self.lambdas[i].abs().max(problem.groups[self.group].shift.abs());
        let is_gap = |i: &usize| self.lambdas[*i] - self.lambdas[*i - 1] > GAP * size(*i);
        let behind = (self.wanted.max(1)..self.lambdas.len()).find(is_gap);
        let before = || (1..self.wanted.min(self.lambdas.len())).rev().find(is_gap);
        match (behind.or_else(before), self.lambdas.first()) {
            (Some(i), _) => {
                let (low, high) = (self.lambdas[i - 1], self.lambdas[i]);
                (low + part * (high - low), rigid + i)
            }
            (None, Some(first)) if *first > 0.0 => (part * first, rigid),
            // A negative eigenvalue, or no elastic mode: nothing may be below the shift.
            (None, _) => (problem.groups[self.group].shift, 0),
        }
    }

    /// Wanted pairs with their λ by the shift, and its distance from the nearest other λ that was found.
    pub fn finish(self) -> impl Iterator<Item = ([f64; 2], RitzPair)> {
        let distance = |i: usize| {
            let neighbours = [i.checked_sub(1), Some(i + 1)].into_iter().flatten();
            let others = neighbours.filter_map(|j| self.lambdas.get(j));
            others.map(|other| (other - self.lambdas[i]).abs()).fold(f64::INFINITY, f64::min)
        };
        let distances: Vec<f64> = (0..self.lambdas.len()).map(distance).collect();
        let values = self.lambdas.into_iter().zip(distances).map(|(lambda, distance)| [lambda, distance]);
        values.zip(self.pairs).take(self.wanted)
    }
}
