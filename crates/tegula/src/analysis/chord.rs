//! When the factor of an earlier tangent serves on.
//!
//! Newton's method with the tangent of an earlier iterate, the chord method, contracts errors by a constant factor θ
//! instead of squaring them, but an iteration costs forces and a solve instead of a factorisation. Two rules decide:
//!
//! - **Within a step** the contraction is measured from the energies `e = δ·R` of the increments. The error after an
//!   increment δ is θ|δ|, so with an old factor `1 + ln(θ|δ|/tolerance)/ln(1/θ)` further iterations are needed. A new
//!   tangent is taken if that is more than it costs, or if increments do not halve. An increment that shows this is not
//!   made: the equations of large time steps have several solutions, and an old factor may lead to one that has nothing
//!   to do with the motion. If the factor is that of an earlier step, the step begins anew with tangents of its own.
//! - **From step to step** the tangent at the start of an earlier step stays until a step takes more iterations than
//!   the average one since then, the price of the factor included: the average would rise from there on. Where steps
//!   need tangents of their own all the same, none is kept for some steps, twice as many each time.
//!
//! Prices are counted in operations, not on a clock, so that results repeat. C. T. Kelley, *Iterative Methods for
//! Linear and Nonlinear Equations*, SIAM 1995, Sect. 5.4.

use crate::element::Nodal;

/// Newton's method leaves next to nothing of an error; an old factor leaves a part of it, which must be this much below
/// the tolerance of energy: a thousandth in the norm of energy in statics.
const REST: f64 = 1e-6;
/// The same in time steps, where the error of the integration is far above: a tenth.
const REST_IN_TIME: f64 = 1e-2;

/// Operations of the dense kernels in the time that an iteration with an old factor takes for one entry of it, where the
/// factor stays in the processor's cache. A solution takes 11 and 13 of them on the quarter cylinders of 16² and 32²
/// elements (last number of the example `factor_times`); the rest is for forces and vectors.
const OPERATIONS_IN_CACHE: f64 = 17.0;
/// The same for larger factors, which a solution waits for: 39, 64 and 71 on 64², 128² and 256².
const OPERATIONS_BEYOND: f64 = 50.0;
/// Entries of the largest factor that stays in the cache: between the 0.9 million of 32² and the 4.8 million of 64².
const ENTRIES_IN_CACHE: usize = 2_000_000;
/// Assembly of a tangent in iterations with an old factor.
const ASSEMBLY_PRICE: f64 = 1.5;
/// Increments that shrink less than this ask for a new tangent.
const SLOWEST: f64 = 0.5;
/// The first increment with an old factor is made if it is at most this part of the one before, which the tangent itself
/// found. A larger one is the mark of a tangent that has changed much.
const MOST_AFTER_FRESH: f64 = 0.1;
/// Energy of the increments since a tangent, over the model's energy, below which its pivots tell the stability of an
/// equilibrium: three thousandths in the norm of energy.
const SAME_EQUILIBRIUM: f64 = 1e-5;

/// What an old factor may leave over of the tolerance of energy, in time steps or in statics.
pub fn rest(in_time: bool) -> f64 {
    if in_time { REST_IN_TIME } else { REST }
}

/// Price of a tangent and its factor, in iterations with an old factor: from the operations of a factorisation and the
/// entries of the factor.
pub fn price(operations: f64, entries: usize) -> f64 {
    let per_entry = if entries > ENTRIES_IN_CACHE { OPERATIONS_BEYOND } else { OPERATIONS_IN_CACHE };
    ASSEMBLY_PRICE + operations / (per_entry * entries.max(1) as f64)
}

/// The tangent whose factor serves several time steps, as the state it was taken at, and what it has served for.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct LaggedTangent {
    /// Whether there is one.
    pub valid: bool,
    /// Time of the state.
    pub time: f64,
    /// Length of the step it was taken for.
    pub dt: f64,
    /// Displacements of the state.
    pub u: Vec<Nodal>,
    /// Velocities, where the model is damped by its strain rates.
    pub v: Vec<Nodal>,
    /// Enhanced parameters and internal variables.
    pub history: Vec<f64>,
    /// Steps since then.
    pub steps: u32,
    /// Iterations since then.
    pub iterations: u32,
    /// Those of the last step.
    pub last: u32,
    /// Steps that are still made with tangents of their own.
    pub pause: u32,
    /// Such steps after the next failure.
    pub next_pause: u32,
}

/// Longest pause of a lagged tangent (steps).
const LONGEST_PAUSE: u32 = 16;

impl LaggedTangent {
    /// Whether it serves for a step of length `dt`, if a new one costs `price`.
    pub fn serves(&self, dt: f64, price: f64) -> bool {
        let average = (price + f64::from(self.iterations)) / f64::from(self.steps.max(1));
        self.valid && self.dt == dt && (self.steps == 0 || f64::from(self.last) <= average)
    }

    /// It does not serve: steps are made with tangents of their own for a while.
    pub fn fail(&mut self) {
        self.valid = false;
        self.pause = self.next_pause.max(1);
        self.next_pause = (2 * self.pause).min(LONGEST_PAUSE);
    }

    /// Counts a finished step, which took `tangents` of its own.
    pub fn served(&mut self, iterations: u32, tangents: u32) {
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

/// An increment of an iteration.
#[derive(Debug, Clone, Copy)]
pub struct Increment {
    /// Its energy over that of the model.
    pub energy: f64,
    /// Its size over the displacement.
    pub size: f64,
    /// How many times larger it is than what may be left at the end, in the norm of energy or of displacement.
    pub excess: f64,
    /// Whether it was found with the tangent of its iterate.
    pub fresh: bool,
    /// Energy and size themselves.
    pub absolute: [f64; 2],
}

/// Increments of the present step.
#[derive(Debug)]
pub struct Increments {
    list: Vec<Increment>,
}

impl Default for Increments {
    /// None yet; memory for some.
    fn default() -> Self {
        Self { list: Vec::with_capacity(64) }
    }
}

impl Increments {
    /// Begins a step.
    pub fn clear(&mut self) {
        self.list.clear();
    }

    /// Adds one.
    pub fn push(&mut self, increment: Increment) {
        self.list.push(increment);
    }

    /// Ratio of the last two increments: that of the errors, if the factor stays; infinite before there are two.
    pub fn contraction(&self) -> f64 {
        let [.., before, last] = self.list.as_slice() else { return f64::INFINITY };
        let ratio = (last.energy / before.energy).sqrt().max(last.size / before.size);
        // An error that a new tangent has made small shrinks more slowly from there on.
        if last.fresh { 2.0 * ratio } else { ratio }
    }

    /// Whether an increment of this energy and size, found with an old factor, is too large beside the one before to be
    /// made.
    pub fn too_large(&self, energy: f64, size: f64) -> bool {
        let Some(last) = self.list.last() else { return false };
        let most = if last.fresh { MOST_AFTER_FRESH } else { SLOWEST };
        // What is not a number is too large.
        !(energy <= most * most * last.absolute[0] && size <= most * last.absolute[1])
    }

    /// Some(false): the last three energies did not shrink; Some(true): nor did those of the last twelve.
    pub fn stagnation(&self) -> Option<bool> {
        let stuck = |k: usize| {
            let Some(first) = self.list.len().checked_sub(k).filter(|first| *first > 0) else { return false };
            let least = |part: &[Increment]| part.iter().map(|i| i.energy).fold(f64::INFINITY, f64::min);
            least(&self.list[first..]) > 0.5 * least(&self.list[..first])
        };
        if stuck(12) { Some(true) } else { stuck(3).then_some(false) }
    }

    /// Whether the factor at hand should serve for the next increment, with `left` further iterations allowed. In time
    /// steps the second increment is always made with the factor of the first: a step changes little. Static steps
    /// change much, so there the factor serves for the last increments only.
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
        assert!(tangent.serves(0.1, 10.0) && !tangent.serves(0.2, 10.0));
        for iterations in [3, 3, 4, 4, 5] {
            tangent.served(iterations, 0);
            assert!(tangent.serves(0.1, 10.0), "{tangent:?}");
        }
        // (10 + 19 + 6) / 6 = 5.8
        tangent.served(6, 0);
        assert!(!tangent.serves(0.1, 10.0));
    }

    #[test]
    fn where_it_does_not_serve_it_is_tried_less_and_less_often() {
        let mut tangent = LaggedTangent::default();
        let mut pauses = Vec::new();
        for _ in 0..7 {
            tangent.valid = true;
            tangent.served(5, 1);
            assert!(!tangent.valid);
            pauses.push(tangent.pause);
            (0..tangent.pause).for_each(|_| tangent.served(3, 2));
            assert_eq!(tangent.pause, 0);
        }
        assert_eq!(pauses, [1, 2, 4, 8, 16, 16, 16]);
        tangent.valid = true;
        tangent.served(4, 0);
        tangent.served(5, 1);
        assert_eq!(tangent.pause, 1);
    }
}
