//! Lowest load factors of one sign: shift by inertia, block Lanczos, Sturm sequence count.

use super::problem::{Operator, Problem};
use crate::analysis::Observer;
use crate::analysis::modal::{Target, go_on, ritz_pairs};
use crate::norm::larger;
use crate::{Error, Result};
use tegula_sparse::lanczos::BlockLanczos;

/// Basis vectors per wanted mode before the iteration gives up, and further ones.
const BASIS: [usize; 2] = [40, 200];
/// Number of modes computed beyond the wanted ones, to find a gap behind them.
const EXTRA: usize = 4;
/// Distance of neighbouring factors, over their value, above which there is a gap between them.
const GAP: f64 = 1e-4;
/// First shift over the estimate of the lowest factor.
const SHIFT: f64 = 0.9;
/// Factor by which a shift that is too large is reduced.
const CLOSER: f64 = 0.7;
/// Largest number of shifts that are tried.
const ATTEMPTS: usize = 60;
/// Largest factor over the lowest one that is looked for.
pub(super) const REACH: f64 = 1e6;
/// Eigenvalue 1/λ over the largest one of the other sign below which an estimate is round-off.
const RESOLVED: f64 = 1e-6;
/// Number of rounds in which missed modes are searched for.
const ROUNDS: usize = 5;
/// Places in a gap, as fractions of its width, where factors are counted until a factorisation succeeds.
const PLACES: [f64; 4] = [0.5, 0.35, 0.65, 0.2];

/// Mode in the free degrees of freedom.
pub(super) struct Mode {
    pub factor: f64,
    pub vector: Vec<f64>,
    pub residual: f64,
}

/// Modes in ascending order of the magnitudes of their factors.
pub(super) struct Found {
    pub modes: Vec<Mode>,
    pub sturm_checked: bool,
}

/// Estimates of the largest and of the smallest (most negative) eigenvalue 1/λ, with the factor of K.
///
/// # Errors
/// The loads produce no stress, or the observer has asked to stop.
pub(super) fn extremes(problem: &mut Problem, wanted: usize, observer: &dyn Observer) -> Result<[f64; 2]> {
    let (block, most) = (block(wanted), (2 * wanted + 8).max(20).min(problem.size()));
    let mut operator = Operator { problem, shifted: false, watch: observer };
    let mut lanczos = BlockLanczos::new(&mut operator, block);
    while lanczos.expand(&mut operator) > 0 && lanczos.len() < most {}
    go_on(observer)?;
    let values = lanczos.ritz_values();
    let ends = [values.first(), values.last()].map(|value| value.map_or(0.0, |v| v.0));
    if larger(ends[0].abs(), ends[1].abs()) > 0.0 {
        return Ok(ends);
    }
    Err(without_stress())
}

/// Refusal of loads without stress.
pub(super) fn without_stress() -> Error {
    Error::Singular {
        what: "The loads produce no stress under which the structure could buckle.".into(),
        help: "Check that the loads act on parts that supports and joints do not hold.".into(),
    }
}

fn block(wanted: usize) -> usize {
    wanted.clamp(2, 8)
}

/// Search for the lowest factors of one sign.
pub(super) struct Search {
    /// 1 for positive factors, −1 for negative ones.
    sign: f64,
    wanted: usize,
}

impl Search {
    /// Search for the `wanted` factors of a sign that are lowest in magnitude.
    pub fn new(sign: f64, wanted: usize) -> Self {
        Self { sign, wanted }
    }

    /// Finds the modes, none where there is no factor of the sign.
    ///
    /// # Errors
    /// The iteration does not find them, the Sturm count disagrees, or the observer has asked to stop.
    pub fn run(
        mut self,
        problem: &mut Problem,
        extremes: [f64; 2],
        observer: &mut dyn Observer,
    ) -> Result<Found> {
        let none = Found { modes: Vec::new(), sturm_checked: true };
        let Some((lowest, total)) = self.reach(problem, extremes) else { return Ok(none) };
        self.wanted = self.wanted.min(total);
        let shift = self.shift(problem, lowest)?;
        let mut lanczos: Option<BlockLanczos> = None;
        for _ in 0..ROUNDS {
            let modes = self.iterate(problem, (shift, total), &mut lanczos, observer)?;
            go_on(&*observer)?;
            let Some((counted, found)) = self.count(problem, &modes, total) else {
                observer.on_event(
                    "the Sturm count could not be made: no factorisation succeeded in a gap between the load factors",
                );
                return Ok(self.finish(modes, false));
            };
            if counted == found {
                return Ok(self.finish(modes, true));
            }
            if counted < found {
                return Err(miscounted(counted, found));
            }
            observer.on_event(&format!("{} load factor(s) were missed; searching again", counted - found));
            if problem.factor(shift).is_none() {
                return Err(Error::Outside("the shifted matrix changed between two factorisations".into()));
            }
        }
        Err(Error::NotConverged {
            at: "the Sturm count".into(),
            reason: format!("load factors are missing after {ROUNDS} searches"),
            help: "Ask for a few load factors more or less, so that the last one lies in a clear gap.".into(),
        })
    }

    /// Estimate of the lowest factor, in magnitude, and the number of factors up to [`REACH`] times it; `None` where there are none.
    fn reach(&self, problem: &mut Problem, [largest, smallest]: [f64; 2]) -> Option<(f64, usize)> {
        let (own, other) = if self.sign > 0.0 { (largest, -smallest) } else { (-smallest, largest) };
        let resolved = own > RESOLVED * other;
        let lowest = 1.0 / if resolved { own } else { other };
        let places = PLACES.iter().map(|part| (0.5 + part) * REACH * lowest);
        let total = places.map(|s| problem.factor(self.sign * s)).find_map(|count| count);
        match total {
            Some(0) => None,
            // The estimate is above the lowest factor, which is therefore within reach.
            None => Some((lowest, usize::MAX)).filter(|_| resolved),
            Some(total) => Some((if resolved { lowest } else { REACH * lowest }, total)),
        }
    }

    /// Shift below the lowest factor, with which the matrix is positive definite and factored.
    fn shift(&self, problem: &mut Problem, lowest: f64) -> Result<f64> {
        let mut shift = self.sign * SHIFT * lowest;
        for _ in 0..ATTEMPTS {
            if problem.factor(shift) == Some(0) {
                return Ok(shift);
            }
            shift *= CLOSER;
        }
        Err(Error::NotConverged {
            at: "the lowest load factor".into(),
            reason: "the stiffness becomes indefinite under the smallest loads: round-off hides the factor".into(),
            help: "Check that all parts are supported, and that the stiffnesses of connected parts do not differ too much.".into(),
        })
    }

    /// Finds modes with the present factor, that of the shift. A repeated call looks for modes that were missed.
    fn iterate(
        &self,
        problem: &mut Problem,
        (shift, total): (f64, usize),
        lanczos: &mut Option<BlockLanczos>,
        observer: &mut dyn Observer,
    ) -> Result<Vec<Mode>> {
        let size = problem.size();
        let extra = (self.wanted + EXTRA).min(total).min(size);
        let limit = (BASIS[0] * extra + BASIS[1]).min(size);
        let mut operator = Operator { problem, shifted: true, watch: &*observer };
        let lanczos = match lanczos {
            Some(lanczos) => {
                lanczos.add_random(&mut operator);
                lanczos
            }
            none => none.insert(BlockLanczos::new(&mut operator, block(self.wanted))),
        };
        let target = Target { name: "load factor", wanted: [self.wanted, extra], size, limit };
        let expand = |lanczos: &mut BlockLanczos, watch: &dyn Observer| {
            lanczos.expand(&mut Operator { problem, shifted: true, watch })
        };
        let pairs = ritz_pairs(lanczos, expand, &target, observer)?;
        let beyond = shift.abs() * REACH;
        let of_pair = |pair: tegula_sparse::lanczos::RitzPair| {
            let factor = shift * pair.value / (pair.value - 1.0);
            Mode { factor, vector: pair.vector, residual: pair.residual }
        };
        // Of modes without stress ν is 1, and round-off decides about the sign of their factor.
        let is_own = |mode: &Mode| mode.factor * self.sign > 0.0 && mode.factor.abs() < beyond;
        let mut modes: Vec<Mode> = pairs.into_iter().map(of_pair).filter(is_own).collect();
        modes.sort_by(|a, b| a.factor.abs().total_cmp(&b.factor.abs()));
        Ok(modes)
    }

    /// Number of factors up to a place in a gap, by their Sturm sequence count and by those found: behind the last wanted mode, or else in
    /// front of the modes of nearly equal factors that it belongs to.
    fn count(&self, problem: &mut Problem, modes: &[Mode], total: usize) -> Option<(usize, usize)> {
        if modes.is_empty() || modes.len() == total {
            return Some((total, modes.len()));
        }
        let size = |i: usize| modes[i].factor.abs();
        let is_gap = |i: &usize| size(*i) - size(*i - 1) > GAP * size(*i);
        let behind = (self.wanted.max(1)..modes.len()).find(is_gap);
        let before = || (1..self.wanted.min(modes.len())).rev().find(is_gap);
        let (low, high, found) = match behind.or_else(before) {
            Some(i) => (size(i - 1), size(i), i),
            // All factors found are nearly equal, or there is one alone: none may be missing below it.
            None => (0.5 * size(0), size(0), 0),
        };
        PLACES.iter().find_map(|part| {
            let counted = problem.factor(self.sign * (low + part * (high - low)))?;
            Some((counted, found))
        })
    }

    fn finish(&self, mut modes: Vec<Mode>, sturm_checked: bool) -> Found {
        modes.truncate(self.wanted);
        Found { modes, sturm_checked }
    }
}

fn miscounted(counted: usize, found: usize) -> Error {
    Error::NotConverged {
        at: "the Sturm count".into(),
        reason: format!("{found} load factors were found below a gap, but the matrix has {counted}"),
        help: "Ask for a few load factors more or less, so that the last one lies in a clear gap.".into(),
    }
}
