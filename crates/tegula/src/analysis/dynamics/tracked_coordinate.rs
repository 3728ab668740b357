//! Event functions of the relative coordinates of joints with friction or stops: rest, and the stops that are reached.

use super::break_away::BreakAway;
use super::joint_modes::{CONTACT, moving};
use crate::constraint::{CoordinateLaw, CoordinateState};
use crate::norm::larger;

/// Velocity over that at the start of the step below which a sliding coordinate has come to rest.
const AT_REST: f64 = 1e-9;
/// Distance from a stop over the size of the coordinate at which it is reached.
const REACHED: f64 = 1e-11;
/// Excess of a multiplier over its limit that is round-off.
const EXCESS: f64 = 1e-9;
/// Velocity over that of the fastest part of the model so far, below which a coordinate is at rest at the start or at a stop.
pub(super) const RESTING: f64 = 1e-10;

/// Event functions of a relative coordinate: speed along the direction of friction, distance from the lower and from the upper stop. All
/// are positive in a step that its modes fit.
pub(super) const SPEED: usize = 0;
pub(super) const EVENTS: usize = 3;

/// Stop that an event reaches: −1 the lower one, 1 the upper one, 0 for rest.
pub(super) const SIDES: [f64; EVENTS] = [0.0, -1.0, 1.0];

/// Event function at the start and at the end of a step.
#[derive(Debug, Clone, Copy)]
pub(super) struct Event {
    /// Infinite where the event cannot be located in the step.
    pub start: f64,
    pub end: f64,
    /// Size of values that count as zero.
    pub tolerance: f64,
}

impl Event {
    pub const NONE: Self = Self { start: f64::INFINITY, end: f64::INFINITY, tolerance: 0.0 };

    pub fn has_passed(&self) -> bool {
        self.end < -self.tolerance
    }
}

/// Outcome of the comparison of the force that holds a coordinate with its limits.
pub(super) enum Holding {
    /// The force is within its limits.
    Stays,
    /// The force is beyond a limit: the coordinate moves.
    Leaves,
    /// The force is beyond a limit although the coordinate has been chosen to stick.
    Contradicts,
    /// The step is repeated with this length: the search for the break-away goes on.
    BreaksAwayIn(f64),
}

/// A relative coordinate in the present step.
pub(super) struct Tracked {
    /// Index of the joint.
    pub joint: usize,
    /// Rate at the start.
    pub rate: f64,
    /// Whether the coordinate turns back at the start: it goes on against the direction in which it has come there.
    pub turns: bool,
    /// Whether the mode has been changed in this step.
    pub changed: bool,
    /// Whether it is at rest at the start, where friction alone decides about its motion.
    pub at_rest: bool,
    /// Whether it has been chosen to stick and may yet be found at its limit: of several joints on one motion, which share the force that
    /// holds it in no unique way.
    pub shares: bool,
    /// Friction at its limit at the last look, and the force that holds the coordinate.
    pub limit: f64,
    pub force: f64,
    /// Mean rate in the step without friction, beside which the round-off of a coordinate that others hold is small.
    pub free_rate: f64,
    /// Stop that the coordinate leaves at the start, −1 or 1; 0 for none.
    pub left: f64,
    /// Stop that the coordinate has reached at the end of the step, −1 or 1; 0 where it has come to rest.
    pub reached: Option<f64>,
    pub events: [Event; EVENTS],
    /// Values of the event functions at both ends of the search.
    pub bracket: [[f64; EVENTS]; 2],
    /// Search for the time at which friction reaches its limit.
    pub break_away: Option<BreakAway>,
}

impl Tracked {
    /// Rate at the end of the step that is that of rest.
    pub fn rests_below(&self, trial: &CoordinateState) -> f64 {
        RESTING * larger(trial.fastest, self.free_rate)
    }

    /// Values of the event functions of a coordinate that moves, whose velocity has a direction with friction, from the values at the
    /// start and the end of a step of length `h` and the rate at its end, which is 0 where it is below `rests`.
    pub fn find_events(
        &mut self,
        law: &CoordinateLaw,
        (direction, rests): (f64, f64),
        (values, rate): ([f64; 2], f64),
        h: f64,
    ) {
        if direction != 0.0 {
            let [start, end] = [direction * self.rate, direction * rate];
            self.events[SPEED] = match self.changed || self.at_rest {
                true => Event { start: f64::INFINITY, end, tolerance: rests },
                false => Event { start, end, tolerance: larger(AT_REST * start.abs(), rests) },
            };
        }
        for (event, (bound, side)) in self.events[1..].iter_mut().zip(law.stops.into_iter().zip([-1.0, 1.0]))
        {
            let [start, end] = values.map(|value| side * (bound - value) / law.row.size);
            // Where the coordinate leaves the stop, the mean velocity has no root at the start.
            let speed = -side * self.rate / law.row.size;
            *event = match start <= CONTACT && speed >= 0.0 {
                true if speed > 0.0 => Event { start: speed, end: end / h, tolerance: AT_REST * speed },
                true => Event { start: f64::INFINITY, end, tolerance: REACHED },
                false => Event { start, end, tolerance: REACHED },
            };
        }
    }

    /// Compares the force that holds a coordinate, at a stop or by friction (0), with its limits at the end of a step of length `h`, from its state at the
    /// start to the one that is tried. A coordinate whose force is beyond a limit moves.
    pub fn look_at_force(
        &mut self,
        law: &CoordinateLaw,
        (before, trial): (&CoordinateState, &mut CoordinateState),
        stop: f64,
        h: f64,
    ) -> Holding {
        let Self { force, limit, .. } = *self;
        let over = |acts: bool, force: f64| if acts { force - limit } else { f64::NEG_INFINITY };
        let excess = larger(over(stop <= 0.0, force), over(stop >= 0.0, -force));
        let leaves = !(excess <= EXCESS * limit);
        if leaves && self.changed && !self.shares {
            return Holding::Contradicts;
        }
        let CoordinateState { at_limit: breaks_away, excess: earlier, .. } = *before;
        // Others hold the coordinate while its friction is at the limit.
        let held_by_others = !leaves && excess >= -EXCESS * limit;
        if limit > 0.0 && !self.changed && !breaks_away && !held_by_others {
            if let Some(length) = BreakAway::look(&mut self.break_away, [h, excess], earlier, leaves) {
                return Holding::BreaksAwayIn(length);
            }
            trial.at_limit = !leaves && self.break_away.as_ref().is_some_and(|search| search.ends_at(h));
        }
        if leaves {
            (self.changed, self.shares, trial.mode) = (true, false, moving(law, force));
            return Holding::Leaves;
        }
        trial.excess = [h, excess];
        Holding::Stays
    }
}
