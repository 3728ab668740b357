//! Jumps of the velocities and accelerations of prescribed motions and drives.

use super::System;
use crate::load::{Spline, TimeFunction};

impl System {
    /// Whether the velocity of a prescribed motion or a drive jumps at a time: at a kink of a table.
    pub fn has_kink(&self, time: f64) -> bool {
        self.amplitudes_of_motions().any(|amplitude| {
            matches!(amplitude, TimeFunction::Table(_)) && amplitude.rate(time) != amplitude.rate_before(time)
        })
    }

    /// Times at which the acceleration of a prescribed motion or a drive jumps while its velocity does not: ends of splines.
    pub fn jumps_of_acceleration(&self) -> Vec<f64> {
        self.splines_of_motions().flat_map(Spline::acceleration_jumps).collect()
    }

    /// Whether the acceleration of a prescribed motion or a drive jumps at a time while its velocity does not.
    pub fn has_jump_of_acceleration(&self, time: f64) -> bool {
        self.splines_of_motions().any(|spline| spline.acceleration_jumps().any(|jump| jump == time))
    }

    /// Whether a time function is a signal that the caller sets.
    pub fn is_signal(&self, amplitude: usize) -> bool {
        matches!(self.amplitudes.get(amplitude), Some(TimeFunction::Signal(_)))
    }

    fn splines_of_motions(&self) -> impl Iterator<Item = &Spline> {
        self.amplitudes_of_motions().filter_map(|amplitude| {
            if let TimeFunction::Spline(spline) = amplitude { Some(spline) } else { None }
        })
    }

    fn amplitudes_of_motions(&self) -> impl Iterator<Item = &TimeFunction> {
        let motions = self.dofs().prescribed.iter().filter_map(|p| p.amplitude);
        let drives = self.joints.iter().filter_map(|joint| joint.drive.map(|drive| drive.amplitude));
        motions.chain(drives).filter_map(|a| self.amplitudes.get(a))
    }
}
