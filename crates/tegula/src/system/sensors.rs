//! Angles of sensors, which continue over full turns from step to step.

use super::System;
use crate::Vec3;
use crate::constraint::joint::MOST_VECTORS;
use crate::constraint::joints::{LARGEST_TURN, RelativeAngle};
use crate::element::Nodal;

impl System {
    /// Names and angles of the sensors that measure an angle, in the order of the angles of a state.
    pub fn angle_sensors(&self) -> impl Iterator<Item = (&str, &RelativeAngle)> {
        self.sensors.iter().filter_map(|sensor| Some((sensor.name.as_str(), sensor.angle()?)))
    }

    /// Angle at these displacements of the nodal vectors, continued from an earlier one.
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

    /// Continues the angles of all sensors over a motion with these displacements of the nodal vectors at its parts 0 to 1.
    ///
    /// Two bodies may turn against each other by up to a full turn, if each of them turns by less than half of one: the mean of
    /// their directors at both ends lies between them.
    pub fn continue_angles(&self, displacement: impl Fn(usize, f64) -> Nodal, angles: &mut [f64]) {
        for ((_, angle), value) in self.angle_sensors().zip(angles) {
            for part in [0.5, 1.0] {
                *value = self.continued_angle(angle, *value, |v| displacement(v, part));
            }
        }
    }

    /// Reason why a load step between these angles is too long for a sensor: the motion within it is not known, and a turn might
    /// be lost.
    pub fn sensor_turns_too_far(&self, [before, after]: [&[f64]; 2]) -> Option<String> {
        // An angle that is not a number does not pass either.
        let too_far = |(_, (before, after)): &(_, (&f64, &f64))| !((*after - *before).abs() <= LARGEST_TURN);
        let ((name, _), _) = self.angle_sensors().zip(before.iter().zip(after)).find(too_far)?;
        Some(format!(
            "the angle of the sensor \"{name}\" changes by more than {LARGEST_TURN} rad in the step"
        ))
    }
}
