//! Systems of bodies, beams, joints and springs.

use super::{Procedure, System};
use crate::load::LoadParameter;

impl System {
    /// Number of constraints, and of their Lagrange multipliers.
    pub fn constraints(&self) -> usize {
        self.joints.last().map_or(0, |last| last.multipliers().end)
    }

    /// Whether the system has springs, torsion springs or bushings.
    pub fn has_springs(&self) -> bool {
        !(self.springs.is_empty() && self.torsion_springs.is_empty() && self.bushings.is_empty())
    }

    /// Part of the forces in the reference configuration that springs and bushings have: it grows to 1 in load steps from load factor −1 to 0.
    pub fn part_of_preload(&self, time: f64) -> f64 {
        // Buckling analyses look at loads of both signs.
        let is_buckling = self.procedure == Procedure::Buckling;
        let grows =
            time < 0.0 && self.parameter() == LoadParameter::LoadFactor && !is_buckling && !self.continues();
        if grows { 1.0 + time } else { 1.0 }
    }

    /// Whether the system has bodies, beams, joints, ties, springs or bushings.
    pub fn is_mechanism(&self) -> bool {
        self.has_springs() || !self.coordinates.bodies.is_empty() || self.constraints() > 0
    }
}
