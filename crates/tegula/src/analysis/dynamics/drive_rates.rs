//! Velocities at the ends of steps against the rates of drives.
//!
//! Joints hold positions, not velocities. Those of a scheme that does not damp, `v₁ = 2 Δq/Δt − v₀`, alternate about the rate of a
//! drive: by about Δθ²/6 of it where a step turns a body by Δθ, and by more where the length of the steps changes.

use crate::analysis::State;
use crate::constraint::Joint;
use crate::element::{Nodal, VectorKind};
use crate::norm::larger;
use crate::system::System;
use crate::{Error, Result, Vec3};

/// Part of the largest rate of a drive by which the velocities of a step may miss it before a message says so, and before the
/// velocities are useless.
const MISSED: f64 = 0.1;
const LOST: f64 = 0.5;

/// Steps one after another in which velocities change sides of the rate of a signal, from which on they alternate; difference of their distances from it, over them, that is small.
const ALTERNATIONS: u32 = 6;
const SAME: f64 = 0.2;

/// Number of first steps that are not judged: from rest, the error is as large as the rate.
const FIRST_STEPS: u64 = 20;

/// Number of times from the start of an analysis step to where it is resumed, at which the rates of drives are looked at.
const LOOKS: u32 = 100;

/// Part of a step before its end at which rates that jump there are taken.
const BEFORE: f64 = 1e-9;

/// Time at the end of a step of this length at which the rates of drives are taken: before a kink the rate of the piece that ends there.
pub(super) fn time_of_rates(system: &System, time: f64, dt: f64) -> f64 {
    if system.has_kink(time) { time - BEFORE * dt } else { time }
}

/// Time at the end of a step of this length at which the rates and accelerations of drives are taken: also before the end of a spline.
pub(super) fn time_of_accelerations(system: &System, time: f64, dt: f64) -> f64 {
    if system.has_jump_of_acceleration(time) { time - BEFORE * dt } else { time_of_rates(system, time, dt) }
}

/// Watches the velocities of driven joints.
pub(super) struct DriveRates {
    /// Largest rate of the drive of each joint so far; 0 for a joint without one.
    largest: Vec<f64>,
    /// Largest velocity so far, over the length of the model for positions [1/time].
    speed: f64,
    /// Whether a message has said that velocities alternate.
    told: bool,
    /// Drives that follow a signal, whose rate only differences of its values tell.
    signals: Vec<SignalWatch>,
}

/// Watches the velocities of a joint whose drive follows a signal.
struct SignalWatch {
    joint: usize,
    /// Value at the end of the last step, and its time.
    last: (f64, f64),
    /// Largest rate so far, and velocity beyond the rate in the last step.
    largest: f64,
    excess: f64,
    /// Number of steps one after another in which this has changed its sign and kept its size.
    alternations: u32,
}

impl SignalWatch {
    fn new(system: &System, joint: usize, time: f64) -> Self {
        let last = (system.drive_value(&system.joints[joint], time), time);
        Self { joint, last, largest: 0.0, excess: 0.0, alternations: 0 }
    }

    /// Looks at the end of a step; true where the velocities alternate about the rate.
    fn look(&mut self, system: &System, state: &State) -> bool {
        let joint = &system.joints[self.joint];
        let (value, before) = (system.drive_value(joint, state.time), self.last);
        let rate = (value - before.0) / (state.time - before.1);
        self.last = (value, state.time);
        self.largest = larger(self.largest, rate.abs());
        let at = (state.time, rate);
        let Some(excess) = system.excess_rate(joint, [&state.u, state.velocities_of_scheme()], at) else {
            return false;
        };
        let previous = std::mem::replace(&mut self.excess, excess);
        let alternates = excess * previous < 0.0
            && (excess + previous).abs() < SAME * excess.abs()
            && excess.abs() > MISSED * self.largest;
        self.alternations = if alternates { self.alternations + 1 } else { 0 };
        self.alternations >= ALTERNATIONS
    }
}

impl DriveRates {
    /// Watch from a time on.
    pub fn new(system: &System, time: f64) -> Self {
        let largest = |joint| {
            let at = |part: u32| time * f64::from(part) / f64::from(LOOKS);
            (0..=LOOKS).map(|part| system.drive(joint, at(part)).rate.abs()).fold(0.0, larger)
        };
        let largest: Vec<f64> = system.joints.iter().map(largest).collect();
        // What the drives have made of it so far, at least.
        let speed = |(joint, rate): (&Joint, &f64)| {
            let turns = joint.rows.first().is_some_and(|row| row.is_driven_angle());
            if turns { *rate } else { rate / system.length }
        };
        let speed = system.joints.iter().zip(&largest).map(speed).fold(0.0, larger);
        let follows = |joint: &Joint| joint.drive.is_some_and(|drive| system.is_signal(drive.amplitude));
        let signals = (0..system.joints.len()).filter(|i| follows(&system.joints[*i]));
        let signals = signals.map(|i| SignalWatch::new(system, i, time)).collect();
        Self { largest, speed, told: false, signals }
    }

    /// Looks at the end of a step. Returns a message about the first joint whose velocities miss the rate of its drive.
    ///
    /// # Errors
    /// They miss it by half of its largest rate.
    pub fn look(&mut self, system: &System, state: &State, conserves: bool) -> Result<Option<String>> {
        for (joint, largest) in system.joints.iter().zip(&mut self.largest) {
            *largest = larger(*largest, system.drive(joint, state.time).rate.abs());
        }
        if self.largest.iter().all(|rate| *rate == 0.0) {
            return Ok(None);
        }
        let speed = |(v, kind): (&Nodal, &VectorKind)| {
            let speed = Vec3::from(*v).norm();
            if *kind == VectorKind::Position { speed / system.length } else { speed }
        };
        self.speed = state.v.iter().zip(&system.coordinates.kinds).map(speed).fold(self.speed, larger);
        if state.step <= FIRST_STEPS {
            return Ok(None);
        }
        let missed = |(joint, largest): (&Joint, &f64)| {
            let missed = system.missed_rate(joint, [&state.u, &state.v], state.time)? / largest;
            (*largest > 0.0 && missed > MISSED).then(|| (missed, joint.name.clone()))
        };
        let other = if conserves { ", or the scheme \"generalized-alpha\"" } else { "" };
        let Some((missed, name)) = system.joints.iter().zip(&self.largest).find_map(missed) else {
            return Ok(self
                .opened(system, state)
                .map(|message| format!("{message}; take shorter steps{other}")));
        };
        let reason = format!(
            "the velocities miss the rate of the drive \"{name}\" by {:.0} % of its largest one: the steps are long for the motion, and \
             velocities and reactions alternate about their mean",
            100.0 * missed
        );
        if missed <= LOST {
            let told = std::mem::replace(&mut self.told, true);
            return Ok((!told).then(|| format!("{reason}; take shorter steps{other}")));
        }
        Err(Error::NotConverged {
            at: format!("time {:.6e}", state.time),
            reason,
            help: format!("Results up to the step before are complete. Take shorter steps{other}."),
        })
    }

    /// Looks at drives that follow signals, at the end of a step. Returns a warning about the first one about whose rate velocities alternate.
    pub fn look_at_signals(&mut self, system: &System, state: &State) -> Option<String> {
        let mut alternating = None;
        for watch in &mut self.signals {
            if watch.look(system, state) {
                alternating = alternating.or(Some(watch.joint));
            }
        }
        let first = alternating?;
        // One warning is enough.
        self.signals.clear();
        Some(format!(
            "the velocities alternate about the rate of the drive \"{}\": its signal has changed its rate at once, and the velocities, the kinetic energy, the \
             work and the reactions are wrong from then on; let the rate of the signal change over several steps",
            system.joints[first].name
        ))
    }

    /// Message about velocities that would open a joint: a drive that stops at once leaves them alternating.
    fn opened(&mut self, system: &System, state: &State) -> Option<String> {
        let rate = |joint: &Joint| system.opening_rate(joint, [&state.u, &state.v], state.time);
        let worst = |joint: &&Joint| rate(joint) > MISSED * self.speed;
        let name = &system.joints.iter().find(worst).filter(|_| !self.told)?.name;
        self.told = true;
        Some(format!(
            "the velocities do not keep the joint \"{name}\" closed: a drive has changed its rate at once, and velocities and reactions \
             alternate about their mean"
        ))
    }
}
