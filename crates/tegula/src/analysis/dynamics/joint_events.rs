//! Friction and stops of joints in time steps: active set within a step, event-driven between steps.
//!
//! Each step is solved for a set of modes: a [relative coordinate](crate::constraint::coordinate_law) moves with a given sign of its
//! velocity, or it is held. A held coordinate whose multiplier leaves its limits moves, and the step is solved again. A step in which a
//! sliding coordinate comes to rest, or reaches a stop, is repeated with other lengths, by the Illinois method, until it ends there; the
//! coordinate is held from then on, or an impact changes the velocities. Where friction reaches its limit within a step, the
//! [break-away](super::break_away) is located too. F. Pfeiffer, Ch. Glocker, *Multibody dynamics with unilateral
//! contacts* (1996); V. Acary, B. Brogliato, *Numerical methods for nonsmooth dynamical systems* (2008), Ch. 8 (event-driven schemes).

use super::Integrator;
use super::joint_modes::{CONTACT, moving, stands_beyond, stop_at};
use super::tracked_coordinate::{EVENTS, Event, Holding, RESTING, SIDES, SPEED, Tracked};
use super::{stick_slip, triads};
use crate::Vec3;
use crate::analysis::State;
use crate::analysis::newton::Newton;
use crate::constraint::joints::RelativeAngle;
use crate::constraint::{CoordinateLaw, CoordinateMode, CoordinateState, Joint};
use crate::element::Nodal;
use crate::error::Result;
use crate::norm::larger;
use crate::system::{System, VectorKind};

/// Factor of this limit where another coordinate comes to rest at the same time.
const TOGETHER: f64 = 100.0;
/// Force over its limit from which on it is asked how several coordinates that friction holds share their forces.
const NEAR_LIMIT: f64 = 0.8;
/// Step over the one first tried below which the event at its end is located.
const LOCATED: f64 = 1e-12;
/// Most looks for the joints that slide, of those at rest, in one attempt at a step: the limits follow the reactions.
const MOST_ROUNDS: u32 = 8;
/// Most repeats of a step for one event.
const MOST_REPEATS: u32 = 90;

/// Outcome of the look at a solved step.
pub(super) enum Review {
    /// The modes fit the end of the step.
    Fits,
    /// Another mode has to be tried.
    Changed,
    /// The step is repeated with this length, as it has to end at an event.
    Repeat(f64),
    /// No mode fits.
    Contradiction(String),
}

/// Search for the end of a step at its first event: the bracket of the Illinois method.
struct Search {
    /// Length first tried.
    whole: f64,
    /// Lengths without and with an event that has passed.
    ends: [f64; 2],
    /// Factors of the values at the ends.
    weights: [f64; 2],
    /// End that the last trial has replaced.
    last: usize,
    repeats: u32,
}

/// Relative coordinates with friction or stops in a time step.
pub(super) struct JointEvents {
    coordinates: Vec<Tracked>,
    /// Velocities at the end of the step that is tried, which keep the joints closed.
    velocities: Vec<Nodal>,
    /// Coordinates that friction holds, and the numbers of their constraints.
    held: Vec<usize>,
    rows: Vec<usize>,
    /// State of the coordinates at the end of the step that is tried.
    pub trial: Vec<CoordinateState>,
    search: Option<Search>,
    /// Times that coordinates at rest have been released in this step.
    rounds: u32,
    /// Start of the step of the search.
    time: f64,
}

/// Joint and law of a coordinate.
fn law(system: &System, joint: usize) -> Option<(usize, &Joint, &CoordinateLaw)> {
    let joint = &system.joints[joint];
    joint.law_row().map(|(row, law)| (row, joint, law))
}

impl JointEvents {
    pub fn new(system: &System) -> Self {
        let with_law = |joint: usize| {
            law(system, joint)?;
            let (events, bracket) = ([Event::NONE; EVENTS], [[0.0; EVENTS]; 2]);
            Some(Tracked {
                joint,
                rate: 0.0,
                turns: false,
                changed: false,
                at_rest: false,
                shares: false,
                limit: f64::NAN,
                force: 0.0,
                free_rate: 0.0,
                left: 0.0,
                reached: None,
                events,
                bracket,
                break_away: None,
            })
        };
        let coordinates: Vec<_> = (0..system.joints.len()).filter_map(with_law).collect();
        let velocities = vec![[0.0; 3]; system.vectors()];
        let [held, rows] = [(); 2].map(|()| Vec::with_capacity(coordinates.len()));
        Self {
            coordinates,
            velocities,
            held,
            rows,
            trial: Vec::new(),
            search: None,
            rounds: 0,
            time: f64::NAN,
        }
    }

    pub fn is_empty(&self) -> bool {
        self.coordinates.is_empty()
    }

    /// Modes of a state from its velocities: coordinates at rest are held where there is friction or a stop.
    ///
    /// # Errors
    /// A joint stands beyond a stop.
    pub fn start(system: &System, state: &mut State) -> Result<()> {
        let old = std::mem::take(&mut state.coordinates);
        let scale = speed(system, &state.v);
        for joint in system.joints.iter() {
            let Some((_, law)) = joint.law_row() else { continue };
            let now = system.coordinate(joint, law, &state.u);
            let earlier = old.iter().find(|c| c.joint == joint.number);
            let before = earlier.map_or(now, |c| c.value);
            let fastest = larger(earlier.map_or(0.0, |c| c.fastest), scale * law.row.size);
            let value = if law.is_angle { RelativeAngle::nearest(before, now) } else { now };
            let rate = system.coordinate_rate(joint, law, [&state.u, &state.v]);
            let beyond =
                [law.stops[0] - value, value - law.stops[1]].into_iter().fold(f64::NEG_INFINITY, larger);
            if !(beyond <= CONTACT * law.row.size) {
                return Err(stands_beyond(joint, law, value));
            }
            let at_rest = !(rate.abs() > RESTING * fastest);
            let stop = stop_at(law, value);
            let mode = if at_rest && (law.has_friction() || stop != 0.0) {
                CoordinateMode::Held { at: value, stop }
            } else {
                moving(law, rate)
            };
            let joint = joint.number;
            let (at_limit, excess) = (false, [0.0; 2]);
            state.coordinates.push(CoordinateState { joint, value, mode, fastest, at_limit, excess });
        }
        Ok(())
    }

    /// Stop that a coordinate has reached at the end of the step, −1 or 1; 0 where it has come to rest.
    pub fn reached(&self, coordinate: usize) -> Option<f64> {
        self.coordinates[coordinate].reached
    }

    /// Rate of a coordinate at the start of the step.
    pub fn rate_before(&self, coordinate: usize) -> f64 {
        self.coordinates[coordinate].rate
    }

    /// Lets the coordinates that are at rest at the start move without friction: from this solution of the step follows
    /// [which of them slide](Self::choose). Returns whether there are any.
    pub fn release(&mut self) -> bool {
        let Self { coordinates, trial, rounds, .. } = self;
        let at_rest = || coordinates.iter().map(|c| c.at_rest);
        if *rounds >= MOST_ROUNDS || !at_rest().any(|at_rest| at_rest) {
            return false;
        }
        *rounds += 1;
        for (now, _) in trial.iter_mut().zip(at_rest()).filter(|(_, at_rest)| *at_rest) {
            now.mode = CoordinateMode::Moving(0.0);
        }
        true
    }

    /// Finds the modes of coordinates that were at rest at the start from the solution of a step in which they are
    /// [released](Self::release).
    fn choose(
        &mut self,
        system: &System,
        state: &State,
        (scheme, newton): (&dyn Integrator, &mut Newton),
        h: f64,
    ) {
        let (u, multipliers) = (scheme.displacements(), scheme.multipliers());
        let middle = middle(system, state, u);
        let [mut displacements, mut limits] = [Vec::new(), Vec::new()];
        let [mut rows, mut chosen] = [Vec::new(), Vec::new()];
        for (k, c) in self.coordinates.iter_mut().enumerate().filter(|(_, c)| c.at_rest) {
            let Some((row, joint, law)) = law(system, c.joint) else { continue };
            let before = state.coordinates[k].value;
            let now = system.coordinate(joint, law, u);
            let value = if law.is_angle { RelativeAngle::nearest(before, now) } else { now };
            if c.limit.is_nan() {
                c.limit = law.limit(joint, multipliers, &middle).sticking;
            }
            c.free_rate = (value - before).abs() / h;
            displacements.push(value - before);
            limits.push(c.limit);
            rows.push(row);
            chosen.push(k);
        }
        let Some(constraints) = &mut newton.constraints else { return };
        let directions = stick_slip::directions(&displacements, &constraints.compliance(&rows), &limits);
        for (k, direction) in chosen.into_iter().zip(directions) {
            let at = state.coordinates[k].value;
            (self.coordinates[k].changed, self.coordinates[k].shares) = (true, direction == 0.0);
            self.trial[k].mode = match direction {
                0.0 => CoordinateMode::Held { at, stop: 0.0 },
                _ => CoordinateMode::Moving(direction),
            };
        }
    }

    /// Whether an event ends the step.
    pub fn has_event(&self) -> bool {
        self.coordinates.iter().any(|c| c.reached.is_some())
    }

    /// Names of the joints with an event at the end of the step.
    pub fn joints(&self, system: &System) -> String {
        let with_event = self.coordinates.iter().filter(|c| c.reached.is_some());
        with_event.map(|c| format!("\"{}\"", system.joints[c.joint].name)).collect::<Vec<_>>().join(", ")
    }

    /// Whether a coordinate returns to the stop that it has left at the start of the step.
    pub fn returns(&self) -> bool {
        self.coordinates.iter().any(|c| c.left != 0.0 && c.reached == Some(c.left))
    }

    /// Forgets the search for an event.
    pub fn restart(&mut self) {
        (self.time, self.search) = (f64::NAN, None);
    }

    /// Begins an attempt at a step from a state.
    pub fn begin(&mut self, system: &System, state: &State) {
        self.trial.clone_from(&state.coordinates);
        self.rounds = 0;
        let scale = speed(system, &state.v);
        let begins = self.time != state.time;
        for (c, now) in self.coordinates.iter_mut().zip(&mut self.trial) {
            let Some((_, joint, law)) = law(system, c.joint) else { continue };
            (c.changed, c.reached) = (false, None);
            (now.at_limit, now.excess) = (false, [0.0; 2]);
            now.fastest = larger(now.fastest, scale * law.row.size);
            c.rate = system.coordinate_rate(joint, law, [&state.u, &state.v]);
            let stop = stop_at(law, now.value);
            if stop != 0.0 && c.rate.abs() <= RESTING * now.fastest {
                // A coordinate that round-off moves rests at its stop.
                (c.rate, now.mode) = (0.0, CoordinateMode::Held { at: now.value, stop });
            }
            c.left = if stop * c.rate < 0.0 { stop } else { 0.0 };
            c.turns = matches!(now.mode, CoordinateMode::Moving(direction) if direction * c.rate < 0.0);
            // Where several come to rest at nearly the same time, the last ones have no velocity left that a shorter step could take.
            let hardly_moves = law.has_friction() && c.rate.abs() <= RESTING * now.fastest;
            c.at_rest = match now.mode {
                CoordinateMode::Moving(_) => c.turns || hardly_moves,
                CoordinateMode::Held { stop, .. } => stop == 0.0,
            };
            (c.shares, c.limit, c.free_rate) = (false, f64::NAN, 0.0);
            c.break_away = c.break_away.take().filter(|_| !begins);
        }
        if begins {
            (self.time, self.search) = (state.time, None);
        }
    }

    /// Looks at the end of a solved step of length `h` from a state.
    pub fn review(
        &mut self,
        system: &System,
        state: &State,
        (scheme, newton): (&dyn Integrator, &mut Newton),
        h: f64,
    ) -> Review {
        let released =
            |(c, now): (&Tracked, &CoordinateState)| c.at_rest && now.mode == CoordinateMode::Moving(0.0);
        if self.coordinates.iter().zip(&self.trial).any(released) {
            self.choose(system, state, (scheme, newton), h);
            return Review::Changed;
        }
        let (u, multipliers) = (scheme.displacements(), scheme.multipliers());
        // Velocities of schemes that conserve energy keep bodies rigid and joints closed up to the error of the step only.
        let mut velocities = std::mem::take(&mut self.velocities);
        velocities.clone_from_slice(scheme.velocities());
        triads::project_velocities(system, u, &mut velocities);
        if let Some(constraints) = &mut newton.constraints {
            // The tangent is that of an earlier iterate: the second projection closes what the first has left.
            for _ in 0..2 {
                constraints.project_velocities(system, (u, state.time + h), &mut velocities);
            }
        }
        self.find_forces(system, state, (u, multipliers), newton);
        let outcome = self.look(system, state, (u, &velocities), h);
        self.velocities = velocities;
        match outcome {
            Review::Contradiction(_) if self.release() => Review::Changed,
            outcome => outcome,
        }
    }

    /// Finds the forces that hold coordinates, and their friction at its limit. Where friction holds several of them, the multipliers of a
    /// solution are not the only ones: the forces are then [those of Coulomb's law](stick_slip::holding_forces).
    fn find_forces(
        &mut self,
        system: &System,
        state: &State,
        (u, multipliers): (&[Nodal], &[f64]),
        newton: &Newton,
    ) {
        let middle = middle(system, state, u);
        let Self { coordinates, trial, held, rows, .. } = self;
        held.clear();
        rows.clear();
        let mut near_limit = false;
        for (k, (c, trial)) in coordinates.iter_mut().zip(&*trial).enumerate() {
            let Some((row, joint, law)) = law(system, c.joint) else { continue };
            c.limit = law.limit(joint, multipliers, &middle).sticking;
            c.force = multipliers[row];
            if c.limit > 0.0 && matches!(trial.mode, CoordinateMode::Held { stop: 0.0, .. }) {
                near_limit |= !(c.force.abs() < NEAR_LIMIT * c.limit);
                held.push(k);
                rows.push(row);
            }
        }
        let Some(constraints) = newton.constraints.as_ref().filter(|_| near_limit && held.len() > 1) else {
            return;
        };
        let compliance = constraints.compliance_of_held(rows);
        let force = |k: &usize| coordinates[*k].force;
        let displacement = |row: &[f64]| row.iter().zip(&*held).map(|(w, k)| w * force(k)).sum::<f64>();
        let displacements: Vec<f64> = compliance.chunks(held.len()).map(displacement).collect();
        let limits: Vec<f64> = held.iter().map(|k| coordinates[*k].limit).collect();
        let forces = stick_slip::holding_forces(&displacements, &compliance, &limits);
        for (k, force) in held.iter().zip(forces) {
            coordinates[*k].force = force;
        }
    }

    /// Looks at the modes and events of a solved step of length `h` from a state, which ends with these displacements and velocities.
    fn look(
        &mut self,
        system: &System,
        state: &State,
        (u, velocities): (&[Nodal], &[Nodal]),
        h: f64,
    ) -> Review {
        let mut leave = false;
        for (k, c) in self.coordinates.iter_mut().enumerate() {
            let Some((_, joint, law)) = law(system, c.joint) else { continue };
            let (before, trial) = (&state.coordinates[k], &mut self.trial[k]);
            let now = system.coordinate(joint, law, u);
            trial.value = if law.is_angle { RelativeAngle::nearest(before.value, now) } else { now };
            c.events = [Event::NONE; EVENTS];
            match trial.mode {
                CoordinateMode::Held { stop, .. } => match c.look_at_force(law, (before, trial), stop, h) {
                    Holding::Leaves => {
                        leave = true;
                        continue;
                    }
                    Holding::Contradicts => return contradiction(joint),
                    Holding::BreaksAwayIn(length) => return Review::Repeat(length),
                    Holding::Stays => {}
                },
                CoordinateMode::Moving(direction) => {
                    let rate = system.coordinate_rate(joint, law, [u, velocities]);
                    let rests = c.rests_below(trial);
                    c.find_events(law, (direction, rests), ([before.value, trial.value], rate), h);
                }
            }
            if c.events.iter().any(|event| event.has_passed() && event.start == f64::INFINITY) {
                return contradiction(joint);
            }
        }
        if leave {
            return Review::Changed;
        }
        self.find_reached(system, (u, velocities), h);
        self.search(h).map_or(Review::Fits, Review::Repeat)
    }

    /// Finds the coordinates that come to rest or reach a stop at the end of a solved step of length `h`, which ends with these displacements and
    /// velocities. Coordinates that only round-off has moved are held.
    fn find_reached(&mut self, system: &System, (u, velocities): (&[Nodal], &[Nodal]), h: f64) {
        for (c, trial) in self.coordinates.iter_mut().zip(&mut self.trial) {
            let Some((_, joint, law)) = law(system, c.joint) else { continue };
            let rate = system.coordinate_rate(joint, law, [u, velocities]);
            let stop = stop_at(law, trial.value);
            let rests = !trial.mode.is_held() && rate.abs() <= c.rests_below(trial);
            if c.changed && rests && (stop != 0.0 || law.has_friction()) {
                // Round-off alone has moved it, or others hold it while its friction is at the limit.
                trial.mode = CoordinateMode::Held { at: trial.value, stop };
                trial.excess = [if stop == 0.0 { h } else { 0.0 }, 0.0];
            }
            let is_there = |(i, (event, side)): &(usize, (&Event, f64))| {
                event.end <= event.tolerance && (*i == SPEED || side * rate > 0.0 || event.has_passed())
            };
            c.reached = c.events.iter().zip(SIDES).enumerate().find(is_there).map(|(_, (_, side))| side);
        }
        for (c, trial) in self.coordinates.iter_mut().zip(&self.trial) {
            // A coordinate that was to turn back has come to rest instead.
            let rests = c.turns && trial.mode.is_held();
            c.reached = c.reached.or(rests.then_some(0.0));
        }
        if self.has_event() {
            // Coordinates of one motion come to rest together.
            for c in self.coordinates.iter_mut().filter(|c| c.reached.is_none()) {
                let speed = c.events[SPEED];
                c.reached = (speed.end <= TOGETHER * speed.tolerance).then_some(0.0);
            }
        }
    }

    /// Length with which a step has to be repeated, because one of length `h` passes an event or ends before it: the first of the
    /// secants, or the middle of the bracket. `None` where it passes none, or the event has been located.
    fn search(&mut self, h: f64) -> Option<f64> {
        let passes = self.coordinates.iter().flat_map(|c| &c.events).any(Event::has_passed);
        let side = usize::from(passes);
        match &mut self.search {
            None if !passes => return None,
            None => {
                let (ends, weights) = ([0.0, h], [1.0; 2]);
                self.search = Some(Search { whole: h, ends, weights, last: side, repeats: 0 });
                self.coordinates.iter_mut().for_each(|c| c.bracket[0] = c.events.map(|event| event.start));
            }
            // The step has become shorter for another reason.
            Some(search) if !passes && h <= search.ends[0] => {
                self.search = None;
                return None;
            }
            Some(search) => {
                let repeated = search.last == side;
                search.weights[1 - side] = if repeated { 0.5 * search.weights[1 - side] } else { 1.0 };
                (search.weights[side], search.last, search.ends[side]) = (1.0, side, h);
            }
        }
        self.coordinates.iter_mut().for_each(|c| c.bracket[side] = c.events.map(|event| event.end));
        let is_there = !passes && self.has_event();
        let search = self.search.as_mut()?;
        search.repeats += 1;
        let [low, high] = search.ends;
        if is_there {
            return None;
        }
        if high - low <= LOCATED * search.whole || search.repeats >= MOST_REPEATS {
            // A step over the rest of the bracket would be one of round-off: the event is at either end.
            for c in self.coordinates.iter_mut().filter(|c| c.reached.is_none()) {
                c.reached =
                    c.bracket[1].iter().zip(SIDES).find(|(value, _)| **value < 0.0).map(|(_, side)| side);
            }
            return None;
        }
        let mut next = high;
        for c in &self.coordinates {
            let [before, behind] = [0, 1].map(|side| c.bracket[side].map(|x| search.weights[side] * x));
            for (before, behind) in before.into_iter().zip(behind).filter(|(_, behind)| *behind < 0.0) {
                next = next.min(low + (high - low) * before / (before - behind));
            }
        }
        let bisects = search.repeats % 4 == 0 || !(next > low && next < high);
        Some(if bisects { 0.5 * (low + high) } else { next })
    }
}

/// Nodal vectors in the middle of a step from a state to the displacements `u`.
fn middle<'a>(system: &'a System, state: &'a State, u: &'a [Nodal]) -> impl Fn(u32) -> Vec3 + 'a {
    move |n: u32| {
        let n = n as usize;
        let mean = (Vec3::from(state.u[n]) + Vec3::from(u[n])) * 0.5;
        Vec3::from(system.coordinates.reference[n]) + mean
    }
}

/// Largest velocity (or acceleration) of a model: of its positions over its size, and of its directors.
pub(super) fn speed(system: &System, v: &[Nodal]) -> f64 {
    let of_vector = |(v, kind): (&Nodal, &VectorKind)| {
        let speed = Vec3::from(*v).norm();
        if *kind == VectorKind::Position { speed / system.length } else { speed }
    };
    v.iter().zip(&system.coordinates.kinds).map(of_vector).fold(0.0, larger)
}

fn contradiction(joint: &Joint) -> Review {
    Review::Contradiction(format!("no motion of the joint \"{}\" fits its friction and stops", joint.name))
}
