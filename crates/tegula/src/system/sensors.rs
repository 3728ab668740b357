//! Angles of sensors and of gears, which continue over full turns from step to step.

use super::System;
use crate::Vec3;
use crate::constraint::Joint;
use crate::constraint::joint::MOST_VECTORS;
use crate::constraint::joints::{LARGEST_TURN, RelativeAngle};
use crate::element::Nodal;

impl System {
    /// Names and angles of the sensors that measure an angle, in the order of the angles of a state.
    pub fn angle_sensors(&self) -> impl Iterator<Item = (&str, &RelativeAngle)> {
        self.sensors.iter().filter_map(|sensor| Some((sensor.name.as_str(), sensor.angle()?)))
    }

    /// Gears and the angles whose turns the state counts; these stand behind the angles of the sensors in a state.
    pub fn counted_angles(&self) -> impl Iterator<Item = (&Joint, &RelativeAngle)> {
        self.joints.iter().filter_map(|joint| Some((joint, joint.counted.as_deref()?)))
    }

    /// All angles that a state counts, each with what has it.
    fn angles(&self) -> impl Iterator<Item = (&'static str, &str, &RelativeAngle)> {
        let sensors = self.angle_sensors().map(|(name, angle)| ("sensor", name, angle));
        let gears = self.counted_angles().map(|(joint, angle)| ("gear", joint.name.as_str(), angle));
        sensors.chain(gears)
    }

    /// Number of the angles of a state that belong to sensors; those of gears stand behind them.
    pub fn number_of_angle_sensors(&self) -> usize {
        self.angle_sensors().count()
    }

    /// Number of the angles of a state.
    pub fn number_of_angles(&self) -> usize {
        self.angles().count()
    }

    /// Angle at these displacements of the nodal vectors that is nearest to an earlier one.
    pub fn continued_angle(
        &self,
        angle: &RelativeAngle,
        earlier: f64,
        displacement: impl Fn(usize) -> Nodal,
    ) -> f64 {
        let mut vectors = [Vec3::zeros(); MOST_VECTORS];
        for (out, &v) in vectors.iter_mut().zip(&angle.vectors) {
            *out = Vec3::from(self.coordinates.reference[v as usize]) + Vec3::from(displacement(v as usize));
        }
        RelativeAngle::continued(earlier, angle.forms(&vectors))
    }

    /// Continues an angle over a motion with these displacements of the nodal vectors at its parts 0 to 1.
    ///
    /// Two bodies may turn against each other by up to a full turn, if each of them turns by less than half of one: the mean of
    /// their directors at both ends lies between them.
    fn over_motion(
        &self,
        angle: &RelativeAngle,
        earlier: f64,
        displacement: &impl Fn(usize, f64) -> Nodal,
    ) -> f64 {
        let at = |v: usize, part: f64| {
            Vec3::from(self.coordinates.reference[v]) + Vec3::from(displacement(v, part))
        };
        let [start, middle, end] = [0.0, 0.5, 1.0].map(|part| angle.rotation(|v| at(v as usize, part)));
        let change = start.twist_to(middle) + middle.twist_to(end);
        self.continued_angle(angle, earlier + change, |v| displacement(v, 1.0))
    }

    /// Continues the angles of all sensors and gears over a motion with these displacements of the nodal vectors at its parts 0 to 1.
    pub fn continue_angles(&self, displacement: impl Fn(usize, f64) -> Nodal, angles: &mut [f64]) {
        for ((_, _, angle), value) in self.angles().zip(angles) {
            *value = self.over_motion(angle, *value, &displacement);
        }
    }

    /// Reason why a load step between these angles is too long for a sensor or a gear: the motion within it is not known, and a turn might
    /// be lost.
    pub fn angle_turns_too_far(&self, [before, after]: [&[f64]; 2]) -> Option<String> {
        // An angle that is not a number does not pass either.
        let too_far = |(_, (before, after)): &(_, (&f64, &f64))| !((*after - *before).abs() <= LARGEST_TURN);
        let ((what, name, _), _) = self.angles().zip(before.iter().zip(after)).find(too_far)?;
        Some(Self::too_far(what, name))
    }

    /// Reason why a time step from these angles with these displacements at its parts 0 to 1 is too long for a gear, whose constraint
    /// knows its first angle up to half a turn.
    pub fn gear_turns_too_far(
        &self,
        displacement: impl Fn(usize, f64) -> Nodal,
        before: &[f64],
    ) -> Option<String> {
        let too_far = |((_, _, angle), before): &((&str, &str, &RelativeAngle), &f64)| {
            let change = self.over_motion(angle, **before, &displacement) - **before;
            !(change.abs() <= LARGEST_TURN)
        };
        let gears = self.angles().zip(before).skip(self.angle_sensors().count());
        let ((what, name, _), _) = gears.into_iter().find(too_far)?;
        Some(Self::too_far(what, name))
    }

    fn too_far(what: &str, name: &str) -> String {
        format!("the angle of the {what} \"{name}\" changes by more than {LARGEST_TURN} rad in the step")
    }
}
