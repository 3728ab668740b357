//! Friction and stops of joints in time steps: active set within a step, event-driven between steps.
//!
//! Each step is solved for a set of modes: a [relative coordinate](crate::constraint::coordinate_law) moves with a given sign of its
//! velocity, or it is held. A held coordinate whose multiplier leaves its limits moves, and the step is solved again. A step in which a
//! sliding coordinate comes to rest, or reaches a stop, is repeated with other lengths, by the Illinois method, until it ends there; the
//! coordinate is held from then on, or an impact changes the velocities. F. Pfeiffer, Ch. Glocker, *Multibody dynamics with unilateral
//! contacts* (1996); V. Acary, B. Brogliato, *Numerical methods for nonsmooth dynamical systems* (2008), Ch. 8 (event-driven schemes).

use std::f64::consts::TAU;

use super::Integrator;
use crate::Vec3;
use crate::analysis::State;
use crate::constraint::{CoordinateLaw, CoordinateMode, CoordinateState, Joint};
use crate::element::Nodal;
use crate::norm::larger;
use crate::system::{System, VectorKind};

/// Velocity over that at the start of the step below which a sliding coordinate has come to rest.
const AT_REST: f64 = 1e-9;
/// Distance from a stop over the size of the coordinate at which it is reached; and up to which a coordinate stands there.
const REACHED: f64 = 1e-11;
const CONTACT: f64 = 1e-10;
/// Excess of a multiplier over its limit that is round-off.
const EXCESS: f64 = 1e-9;
/// Bracket of an event over the whole step below which it is located.
const LOCATED: f64 = 1e-12;
/// Most repeats of a step for one event.
const MOST_REPEATS: u32 = 90;

/// Outcome of the look at a solved step.
pub(super) enum Review {
    /// The modes fit the end of the step.
    Fits,
    /// Another mode has to be tried.
    Changed,
    /// The step has to end at an event: its length.
    Shorter(f64),
    /// No mode fits.
    Contradiction(String),
}

/// Bracket of the first event of a step: lengths without and with a violated law, and the values of the laws there.
struct Bracket {
    ends: [f64; 2],
    values: [Vec<[f64; 3]>; 2],
    weights: [f64; 2],
    last: Option<usize>,
    repeats: u32,
    whole: f64,
}

/// Relative coordinates with friction or stops in a time step.
pub(super) struct JointEvents {
    /// Indices of their joints.
    joints: Vec<usize>,
    /// State of the coordinates at the end of the step that is tried.
    pub trial: Vec<CoordinateState>,
    /// Rates at the start.
    rates: Vec<f64>,
    /// Whether the mode has been changed in this step.
    changed: Vec<bool>,
    /// Stop that a coordinate has reached at the end of the step, −1 or 1; 0 where it has come to rest.
    pub reached: Vec<Option<f64>>,
    /// Whether a coordinate has left a stop at the start of the step.
    left: Vec<bool>,
    bracket: Option<Bracket>,
    /// Start of the step of the bracket.
    time: f64,
}

/// Joint and law of a coordinate.
fn law(system: &System, joint: usize) -> Option<(usize, &Joint, &CoordinateLaw)> {
    let joint = &system.joints[joint];
    joint.law_row().map(|(row, law)| (row, joint, law))
}

impl JointEvents {
    pub fn new(system: &System) -> Self {
        let joints: Vec<usize> =
            (0..system.joints.len()).filter(|&i| system.joints[i].law_row().is_some()).collect();
        let n = joints.len();
        Self {
            joints,
            trial: Vec::new(),
            rates: vec![0.0; n],
            changed: vec![false; n],
            reached: vec![None; n],
            left: vec![false; n],
            bracket: None,
            time: f64::NAN,
        }
    }

    pub fn is_empty(&self) -> bool {
        self.joints.is_empty()
    }

    /// Modes of a state from its velocities: coordinates at rest are held where there is friction or a stop.
    pub fn start(system: &System, state: &mut State) {
        let old = std::mem::take(&mut state.coordinates);
        let speed = |(v, kind): (&Nodal, &VectorKind)| {
            let speed = Vec3::from(*v).norm();
            if *kind == VectorKind::Position { speed / system.length } else { speed }
        };
        let scale = state.v.iter().zip(&system.coordinates.kinds).map(speed).fold(0.0, larger);
        for joint in system.joints.iter() {
            let Some((_, law)) = joint.law_row() else { continue };
            let now = system.coordinate(joint, law, &state.u);
            let before = old.iter().find(|c| c.joint == joint.number).map_or(now, |c| c.value);
            let value = if law.is_angle { before + wrapped(now - before) } else { now };
            let rate = system.coordinate_rate(joint, law, [&state.u, &state.v]);
            let at_rest = !(rate.abs() > 1e-10 * scale * law.row.size);
            let stop = stop_at(law, value);
            let mode = if at_rest && (law.has_friction() || stop != 0.0) {
                CoordinateMode::Held { at: value, stop }
            } else {
                moving(law, rate)
            };
            state.coordinates.push(CoordinateState { joint: joint.number, value, mode });
        }
    }

    /// Whether a coordinate returns to the stop that it has left at the start of the step.
    pub fn returns(&self) -> bool {
        self.reached
            .iter()
            .zip(&self.left)
            .any(|(reached, left)| reached.is_some_and(|side| side != 0.0) && *left)
    }

    /// Begins an attempt at a step from a state.
    pub fn begin(&mut self, system: &System, state: &State) {
        self.trial.clone_from(&state.coordinates);
        self.changed.fill(false);
        self.reached.fill(None);
        for (k, left) in self.left.iter_mut().enumerate() {
            let at_stop =
                law(system, self.joints[k]).map(|(_, _, law)| stop_at(law, state.coordinates[k].value));
            *left = at_stop.is_some_and(|side| side != 0.0);
        }
        for (rate, &j) in self.rates.iter_mut().zip(&self.joints) {
            if let Some((_, joint, law)) = law(system, j) {
                *rate = system.coordinate_rate(joint, law, [&state.u, &state.v]);
            }
        }
        if self.time != state.time {
            (self.time, self.bracket) = (state.time, None);
        }
    }

    /// Looks at the end of a solved step of length `h` from a state.
    pub fn review(&mut self, system: &System, state: &State, scheme: &dyn Integrator, h: f64) -> Review {
        let (u, v, multipliers) = (scheme.displacements(), scheme.velocities(), scheme.multipliers());
        let middle = |n: u32| {
            let n = n as usize;
            let mean = (Vec3::from(state.u[n]) + Vec3::from(u[n])) * 0.5;
            Vec3::from(system.coordinates.reference[n]) + mean
        };
        let n = self.joints.len();
        let (mut starts, mut ends) = (vec![[f64::INFINITY; 3]; n], vec![[f64::INFINITY; 3]; n]);
        let mut limits = vec![[0.0; 3]; n];
        for k in 0..n {
            let Some((row, joint, law)) = law(system, self.joints[k]) else { continue };
            let before = state.coordinates[k].value;
            let now = system.coordinate(joint, law, u);
            let value = if law.is_angle { before + wrapped(now - before) } else { now };
            self.trial[k].value = value;
            let (rate, old) = (system.coordinate_rate(joint, law, [u, v]), self.rates[k]);
            match self.trial[k].mode {
                CoordinateMode::Held { stop, .. } => {
                    let most = law.limit(joint, multipliers, middle).sticking * (1.0 + EXCESS);
                    let multiplier = multipliers[row];
                    let leaves =
                        (stop <= 0.0 && !(multiplier <= most)) || (stop >= 0.0 && !(multiplier >= -most));
                    if leaves && self.changed[k] {
                        return Review::Contradiction(format!(
                            "no motion of the joint \"{}\" fits its friction",
                            joint.name
                        ));
                    }
                    if leaves {
                        self.changed[k] = true;
                        self.trial[k].mode = moving(law, multiplier);
                        return Review::Changed;
                    }
                }
                CoordinateMode::Moving(direction) => {
                    if direction != 0.0 {
                        (starts[k][0], ends[k][0], limits[k][0]) =
                            (direction * old, direction * rate, AT_REST * (direction * old).abs());
                        if self.changed[k] {
                            (starts[k][0], limits[k][0]) = (f64::INFINITY, 0.0);
                        }
                    }
                    for (i, (bound, side)) in law.stops.into_iter().zip([-1.0, 1.0]).enumerate() {
                        let (from, to) =
                            (side * (bound - before) / law.row.size, side * (bound - value) / law.row.size);
                        let leaving = from <= CONTACT && side * old <= 0.0;
                        let speed = -side * old / law.row.size;
                        let (a, b, tolerance) = match leaving {
                            true if speed > 0.0 => (speed, to / h, AT_REST * speed),
                            true => (f64::INFINITY, to, REACHED),
                            false => (from, to, REACHED),
                        };
                        (starts[k][i + 1], ends[k][i + 1], limits[k][i + 1]) = (a, b, tolerance);
                    }
                }
            }
        }
        let violated = |k: usize, i: usize| ends[k][i] < -limits[k][i];
        for k in 0..n {
            for i in 0..3 {
                if violated(k, i) && starts[k][i] == f64::INFINITY {
                    let name = &system.joints[self.joints[k]].name;
                    return Review::Contradiction(format!(
                        "no motion of the joint \"{name}\" fits its friction and stops"
                    ));
                }
            }
        }
        let any = (0..n).any(|k| (0..3).any(|i| violated(k, i)));
        if any || self.bracket.is_some() {
            let bracket = self.bracket.get_or_insert_with(|| Bracket {
                ends: [0.0, h],
                values: [starts, ends.clone()],
                weights: [1.0; 2],
                last: None,
                repeats: 0,
                whole: h,
            });
            let side = usize::from(any);
            bracket.weights = match bracket.last {
                Some(last) if last == side => {
                    let mut weights = bracket.weights;
                    weights[1 - side] *= 0.5;
                    weights[side] = 1.0;
                    weights
                }
                _ => [1.0; 2],
            };
            (bracket.last, bracket.ends[side]) = (Some(side), h);
            bracket.values[side].clone_from(&ends);
            bracket.repeats += 1;
            let width = bracket.ends[1] - bracket.ends[0];
            if any && width > LOCATED * bracket.whole && bracket.repeats < MOST_REPEATS {
                return Review::Shorter(bracket.next(&limits));
            }
        }
        for k in 0..n {
            let Some((_, joint, law)) = law(system, self.joints[k]) else { continue };
            let rate = system.coordinate_rate(joint, law, [u, v]);
            for (i, side) in [0.0, -1.0, 1.0].into_iter().enumerate() {
                if ends[k][i] <= limits[k][i] && (i == 0 || side * rate > 0.0 || violated(k, i)) {
                    self.reached[k] = Some(side);
                }
            }
        }
        Review::Fits
    }
}

impl Bracket {
    /// Length at the first of the secants.
    fn next(&self, limits: &[[f64; 3]]) -> f64 {
        let [low, high] = self.ends;
        let mut next = high;
        for ((a, b), limit) in self.values[0].iter().zip(&self.values[1]).zip(limits) {
            for i in (0..3).filter(|&i| b[i] < -limit[i]) {
                let (before, behind) = (self.weights[0] * a[i], self.weights[1] * b[i]);
                next = next.min(low + (high - low) * before / (before - behind));
            }
        }
        if next > low && next < high && self.repeats % 4 != 3 { next } else { 0.5 * (low + high) }
    }
}

/// Angle between −π and π.
fn wrapped(angle: f64) -> f64 {
    angle - TAU * (angle / TAU).round()
}

/// Mode of a coordinate that moves with a rate.
pub(super) fn moving(law: &CoordinateLaw, rate: f64) -> CoordinateMode {
    CoordinateMode::Moving(if law.has_friction() { rate.signum() } else { 0.0 })
}

/// Stop at which a coordinate stands: −1, 1, or 0 for none.
pub(super) fn stop_at(law: &CoordinateLaw, value: f64) -> f64 {
    let near = |bound: f64| (value - bound).abs() <= CONTACT * law.row.size;
    if near(law.stops[0]) {
        -1.0
    } else if near(law.stops[1]) {
        1.0
    } else {
        0.0
    }
}
