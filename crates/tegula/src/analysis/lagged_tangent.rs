//! Modified Newton with lagged tangent: reuse policy for the factor of an earlier tangent.
//!
//! Modified Newton (the chord method), with the tangent of an earlier iterate, contracts errors by a constant factor θ
//! instead of squaring them, but an iteration costs forces and a solve instead of a factorisation. Two rules decide on
//! reuse:
//!
//! - **Within a step** the contraction is measured from the energies `e = δ·R` of the increments. The error after an
//!   increment δ is θ|δ|, so with a lagged tangent `1 + ln(θ|δ|/tolerance)/ln(1/θ)` further iterations are needed. A
//!   new tangent is factored if they cost more than it does, or if increments do not halve. An increment that shows
//!   this is discarded: the equations of large time steps have several solutions, and a lagged tangent may lead to one
//!   that has nothing to do with the motion. If the factor is that of an earlier step, the step restarts with new
//!   tangents.
//! - **From step to step** the tangent at the start of an earlier step is reused until a step takes more iterations
//!   than the average step since then, the cost of the factor included: the average would rise from there on. If a step
//!   needs new tangents all the same, reuse pauses for some steps, twice as many each time.
//!
//! Costs are counted in operations, not on a clock, so that results repeat. C. T. Kelley, *Iterative Methods for Linear
//! and Nonlinear Equations*, SIAM 1995, Sect. 5.4.

use serde::{Deserialize, Serialize};

use crate::element::Nodal;
use crate::system::assembly::TangentCoefficients;

/// Factor on the energy tolerance when the last increment came from a lagged tangent, in statics: Newton squares the
/// remaining error, modified Newton multiplies it by the contraction θ, so the estimate θ²·energy must be this much
/// smaller: a thousandth in the energy norm.
const REST: f64 = 1e-6;
/// Factor on the energy tolerance after a lagged tangent, in time steps, where the error of the integration is far
/// larger: a tenth in the energy norm.
const REST_IN_TIME: f64 = 1e-2;

/// Cost of an iteration with a lagged tangent for each entry of the factor, in operations of the dense kernels, where
/// the factor stays in the processor's cache. A solve takes 11 and 13 of them on the quarter cylinders of 16² and 32²
/// elements (last number of the example `factor_times`); forces and vectors take the remainder.
const OPERATIONS_IN_CACHE: f64 = 17.0;
/// Cost of such an iteration for each entry of a larger factor, where memory bounds the solve: the solve takes 39, 64
/// and 71 operations on 64², 128² and 256² elements.
const OPERATIONS_BEYOND: f64 = 50.0;
/// Entries of the largest factor that stays in the cache: between the 0.9 million of 32² elements and the 4.8 million
/// of 64².
const ENTRIES_IN_CACHE: usize = 2_000_000;
/// Cost of a solve for each entry of the factor, where there are many right sides.
const OPERATIONS_OF_MANY: f64 = 4.0;
/// Cost of the constraints in an iteration for each entry of their dense matrices, in operations of the factorisation of small ones.
const OPERATIONS_OF_CONSTRAINTS: f64 = 12.0;
/// Cost of assembling a tangent, in iterations with a lagged tangent.
const ASSEMBLY_PRICE: f64 = 1.5;
/// Largest contraction of increments with which a lagged tangent is kept; slower convergence asks for a new tangent.
const SLOWEST: f64 = 0.5;
/// Largest ratio of the first increment with a lagged tangent to the one before, which the tangent of its own iterate
/// gave. A larger increment shows that the tangent has changed much, and is discarded.
const MOST_AFTER_FRESH: f64 = 0.1;
/// Energy of the increments since a tangent, over the model's energy, below which its negative pivots decide on the
/// stability of an equilibrium: three thousandths in the energy norm.
const SAME_EQUILIBRIUM: f64 = 1e-5;

/// Factor on the energy tolerance with a lagged tangent, in time steps or in statics.
pub fn rest(in_time: bool) -> f64 {
    if in_time { REST_IN_TIME } else { REST }
}

/// Cost of a tangent and its factor, in iterations with a lagged tangent: from the operations of a factorisation, the entries of the
/// factor, and the numbers of unknowns and of constraints, whose Schur complement takes a solve each and a factorisation of its own.
pub fn cost(operations: f64, entries: usize, [unknowns, constraints]: [usize; 2]) -> f64 {
    let per_entry = if entries > ENTRIES_IN_CACHE { OPERATIONS_BEYOND } else { OPERATIONS_IN_CACHE };
    let (entries, n, m) = (entries.max(1) as f64, unknowns as f64, constraints as f64);
    let schur_complement = OPERATIONS_OF_MANY * m * entries + 2.0 / 3.0 * m.powi(3);
    let iteration = per_entry * entries + OPERATIONS_OF_CONSTRAINTS * m * (2.0 * m + n);
    ASSEMBLY_PRICE + (operations + schur_complement) / iteration
}

/// Lagged tangent, reused in several time steps: the state at which it is computed, and counters of its use.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct LaggedTangent {
    /// Whether there is a lagged tangent.
    pub valid: bool,
    /// Time of the state at which the tangent is computed.
    pub time: f64,
    /// Length of the step for which the tangent is computed.
    pub dt: f64,
    /// Coefficients of the tangent, which in schemes of several steps depend on the lengths of earlier ones, too.
    pub coefficients: Option<TangentCoefficients>,
    /// Displacements at which the tangent is computed.
    pub u: Vec<Nodal>,
    /// Velocities at which the tangent is computed, where the model has strain-rate damping.
    pub v: Vec<Nodal>,
    /// Enhanced parameters and internal variables at which the tangent is computed.
    pub history: Vec<f64>,
    /// Steps since the tangent was computed.
    pub steps: u32,
    /// Iterations since the tangent was computed.
    pub iterations: u32,
    /// Iterations of the last step.
    pub last: u32,
    /// Steps left in the pause of reuse, each of which factors new tangents.
    pub pause: u32,
    /// Length of the pause after the next failure (steps).
    pub next_pause: u32,
}

/// Longest pause in the reuse of a lagged tangent (steps).
const LONGEST_PAUSE: u32 = 16;

impl LaggedTangent {
    /// Whether the lagged tangent is reused in a step of length `dt`, if a new one costs `price` iterations.
    pub fn is_reusable(&self, dt: f64, price: f64) -> bool {
        let average = (price + f64::from(self.iterations)) / f64::from(self.steps.max(1));
        self.valid && self.dt == dt && (self.steps == 0 || f64::from(self.last) <= average)
    }

    /// Gives up the lagged tangent: every step factors new tangents during a pause.
    pub fn fail(&mut self) {
        self.valid = false;
        self.pause = self.next_pause.max(1);
        self.next_pause = (2 * self.pause).min(LONGEST_PAUSE);
    }

    /// Counts a finished step, which factored this number of new `tangents`.
    pub fn record_use(&mut self, iterations: u32, tangents: u32) {
        if self.pause > 0 {
            self.pause -= 1;
        } else if tangents > 0 && self.valid {
            self.fail();
        } else {
            self.next_pause = 1;
        }
        self.steps += 1;
        self.iterations += iterations;
        self.last = iterations;
    }
}

/// Increment of an iteration.
#[derive(Debug, Clone, Copy)]
pub struct Increment {
    /// Energy of the increment over that of the model.
    pub energy: f64,
    /// Norm of the increment over the displacement scale.
    pub size: f64,
    /// Ratio of the increment to the largest one allowed at the end, in the energy norm or in that of displacement.
    pub excess: f64,
    /// Whether the tangent of the increment's own iterate gave it (full Newton).
    pub fresh: bool,
    /// Energy and norm of the increment, not scaled.
    pub absolute: [f64; 2],
}

/// Increments of the present step.
#[derive(Debug)]
pub struct Increments {
    list: Vec<Increment>,
}

impl Default for Increments {
    /// Empty list with memory for some increments.
    fn default() -> Self {
        Self { list: Vec::with_capacity(64) }
    }
}

impl Increments {
    /// Begins a step.
    pub fn clear(&mut self) {
        self.list.clear();
    }

    /// Adds an increment.
    pub fn push(&mut self, increment: Increment) {
        self.list.push(increment);
    }

    /// Ratio of the last two increments: the contraction of the errors, if the factor stays; infinite before there are
    /// two.
    pub fn contraction(&self) -> f64 {
        let [.., before, last] = self.list.as_slice() else { return f64::INFINITY };
        let ratio = (last.energy / before.energy).sqrt().max(last.size / before.size);
        // An error that a new tangent has made small decreases more slowly from there on.
        if last.fresh { 2.0 * ratio } else { ratio }
    }

    /// Whether an increment of this energy and size, found with a lagged tangent, is too large beside the one before to
    /// be accepted.
    pub fn too_large(&self, energy: f64, size: f64) -> bool {
        let Some(last) = self.list.last() else { return false };
        let most = if last.fresh { MOST_AFTER_FRESH } else { SLOWEST };
        // NaN counts as too large.
        !(energy <= most * most * last.absolute[0] && size <= most * last.absolute[1])
    }

    /// Stagnation test. `Some(false)`: the energies of the last three increments are all above half the smallest one
    /// before; `Some(true)`: those of the last twelve are; `None`: no stagnation.
    pub fn stagnation(&self) -> Option<bool> {
        let stuck = |k: usize| {
            let Some(first) = self.list.len().checked_sub(k).filter(|first| *first > 0) else { return false };
            let least = |part: &[Increment]| part.iter().map(|i| i.energy).fold(f64::INFINITY, f64::min);
            least(&self.list[first..]) > 0.5 * least(&self.list[..first])
        };
        if stuck(12) { Some(true) } else { stuck(3).then_some(false) }
    }

    /// Reuse policy within a step: whether the present factor gives the next increment, with `left` further iterations
    /// allowed. In time steps the second increment always reuses the factor of the first, since a step changes little.
    /// Static steps change much, so there only the last increments reuse a factor.
    pub fn old_factor_serves(&self, in_time: bool, price: f64, left: u32) -> bool {
        if price == 0.0 {
            return false;
        }
        let Some(last) = self.list.last().filter(|_| self.list.len() > 1) else { return in_time };
        if !in_time {
            let since = self.list.iter().rposition(|i| i.fresh).unwrap_or(0);
            let moved: f64 = self.list[since..].iter().map(|i| i.energy).sum();
            if moved.is_nan() || moved > SAME_EQUILIBRIUM {
                return false;
            }
        }
        let contraction = self.contraction();
        if contraction.is_nan() || contraction > SLOWEST {
            return false;
        }
        let error = contraction * last.excess;
        let needed = 1.0 + (error.max(1.0).ln() / -contraction.max(f64::MIN_POSITIVE).ln()).ceil();
        needed <= price && needed <= f64::from(left)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn increments(list: &[(f64, bool)]) -> Increments {
        let mut out = Increments::default();
        list.iter().for_each(|&(e, fresh)| {
            let size = e.sqrt();
            out.push(Increment { energy: e, size, excess: size / 1e-6, fresh, absolute: [e, size] });
        });
        out
    }

    #[test]
    fn an_old_factor_serves_while_its_iterations_cost_less_than_a_new_one() {
        // Contraction 0.1: an error of 1e-4 is below 1e-6 after three further iterations.
        let steps = increments(&[(1e-4, false), (1e-6, false)]);
        assert!((steps.contraction() - 0.1).abs() < 1e-12);
        assert!(steps.old_factor_serves(true, 4.0, 20));
        assert!(!steps.old_factor_serves(true, 2.9, 20));
        assert!(!steps.old_factor_serves(true, 4.0, 2));
    }

    #[test]
    fn slow_or_growing_increments_ask_for_a_new_tangent() {
        for last in [0.3e-4, 1e-4, 1e-2, f64::NAN, f64::INFINITY] {
            assert!(
                !increments(&[(1e-4, false), (last, false)]).old_factor_serves(true, 1e9, 1000),
                "{last}"
            );
        }
    }

    #[test]
    fn increments_with_an_old_factor_are_made_only_if_they_shrink() {
        let fresh = increments(&[(1.0, true)]);
        assert!(
            !fresh.too_large(0.0099, 0.099) && fresh.too_large(0.0099, 0.11) && fresh.too_large(0.011, 0.09)
        );
        let old = increments(&[(1.0, true), (0.01, false)]);
        assert!(!old.too_large(0.0024, 0.049) && old.too_large(0.0026, 0.04) && old.too_large(0.001, 0.051));
        assert!(old.too_large(f64::NAN, 0.01));
        assert!(!increments(&[]).too_large(1e9, 1e9), "the first one has none to be compared with");
    }

    #[test]
    fn in_statics_only_the_last_increments_are_made_with_an_old_factor() {
        assert!(!increments(&[(1e-2, true)]).old_factor_serves(false, 1e9, 20));
        assert!(!increments(&[(1.0, true), (1e-4, true)]).old_factor_serves(false, 1e9, 20));
        assert!(increments(&[(1e-2, true), (1e-7, true)]).old_factor_serves(false, 20.0, 20));
    }

    #[test]
    fn a_tangent_stays_until_a_step_costs_more_than_the_average() {
        let mut tangent = LaggedTangent { valid: true, dt: 0.1, ..LaggedTangent::default() };
        assert!(tangent.is_reusable(0.1, 10.0) && !tangent.is_reusable(0.2, 10.0));
        for iterations in [3, 3, 4, 4, 5] {
            tangent.record_use(iterations, 0);
            assert!(tangent.is_reusable(0.1, 10.0), "{tangent:?}");
        }
        // (10 + 19 + 6) / 6 = 5.8
        tangent.record_use(6, 0);
        assert!(!tangent.is_reusable(0.1, 10.0));
    }

    #[test]
    fn where_it_does_not_serve_it_is_tried_less_and_less_often() {
        let mut tangent = LaggedTangent::default();
        let mut pauses = Vec::new();
        for _ in 0..7 {
            tangent.valid = true;
            tangent.record_use(5, 1);
            assert!(!tangent.valid);
            pauses.push(tangent.pause);
            (0..tangent.pause).for_each(|_| tangent.record_use(3, 2));
            assert_eq!(tangent.pause, 0);
        }
        assert_eq!(pauses, [1, 2, 4, 8, 16, 16, 16]);
        tangent.valid = true;
        tangent.record_use(4, 0);
        tangent.record_use(5, 1);
        assert_eq!(tangent.pause, 1);
    }
}
