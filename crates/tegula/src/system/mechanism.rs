//! Systems of bodies, beams, joints and springs.

use super::System;

impl System {
    /// Number of constraints, and of their Lagrange multipliers.
    pub fn constraints(&self) -> usize {
        self.joints.last().map_or(0, |last| last.multipliers().end)
    }

    /// Whether the system has springs, torsion springs or bushings.
    pub fn has_springs(&self) -> bool {
        !(self.springs.is_empty() && self.torsion_springs.is_empty() && self.bushings.is_empty())
    }

    /// Whether the system has bodies, beams, joints, ties, springs or bushings.
    pub fn is_mechanism(&self) -> bool {
        self.has_springs() || !self.coordinates.bodies.is_empty() || self.constraints() > 0
    }
}
