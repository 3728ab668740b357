//! Jumps of the velocities and accelerations of prescribed motions and drives.

use super::System;
use crate::load::TimeFunction;

impl System {
    /// Whether the velocity of a prescribed motion or a drive jumps at a time: at a kink of a table.
    pub fn has_kink(&self, time: f64) -> bool {
        self.amplitudes_of_motions().any(|amplitude| {
            matches!(amplitude, TimeFunction::Table(_)) && amplitude.rate(time) != amplitude.rate_before(time)
        })
    }

    /// Whether the acceleration of a prescribed motion or a drive jumps at a time while its velocity does not: at an end of a spline.
    pub fn has_jump_of_acceleration(&self, time: f64) -> bool {
        self.amplitudes_of_motions().any(|amplitude| match amplitude {
            TimeFunction::Spline(spline) => spline.acceleration_jumps().any(|jump| jump == time),
            _ => false,
        })
    }

    fn amplitudes_of_motions(&self) -> impl Iterator<Item = &TimeFunction> {
        let motions = self.dofs().prescribed.iter().filter_map(|p| p.amplitude);
        let drives = self.joints.iter().filter_map(|joint| joint.drive.map(|drive| drive.amplitude));
        motions.chain(drives).filter_map(|a| self.amplitudes.get(a))
    }
}
