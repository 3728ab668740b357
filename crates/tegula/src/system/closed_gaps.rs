//! Gaps that were closed and bodies that have moved where a model was assembled at its start.

use super::System;

/// Gaps of joints that were closed at the start, and the bodies that have moved for it.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ClosedGaps {
    /// Joints whose sides did not meet in the reference configuration.
    pub joints: Vec<ClosedGap>,
    /// Bodies that are no longer in the reference configuration.
    pub bodies: Vec<MovedBody>,
}

/// Gap of a joint before it was closed.
#[derive(Debug, Clone, PartialEq)]
pub struct ClosedGap {
    /// Name of the joint.
    pub name: String,
    /// Distance by which the points of both sides missed each other (length).
    pub distance: f64,
    /// Angle by which the axes of both sides missed each other (rad).
    pub angle: f64,
}

/// Motion of a body from the reference configuration to the start.
#[derive(Debug, Clone, PartialEq)]
pub struct MovedBody {
    /// Name of the body.
    pub name: String,
    /// Displacement of its mass centre (length).
    pub displacement: [f64; 3],
    /// Rotation vector: the axis times the angle (rad), at most half a turn; zero for point masses.
    pub rotation: [f64; 3],
}

impl ClosedGaps {
    /// Messages about each joint and each body, in whole sentences.
    pub fn messages(&self) -> Vec<String> {
        let of_joint = |gap: &ClosedGap| {
            format!(
                "assembled: the sides of the joint \"{}\" missed each other by the distance {:.6e} and the angle {:.6} degrees",
                gap.name,
                gap.distance,
                gap.angle.to_degrees()
            )
        };
        let size = |x: &[f64; 3]| x.iter().map(|x| x * x).sum::<f64>().sqrt();
        let of_body = |body: &MovedBody| {
            format!(
                "assembled: the body \"{}\" has moved by {:.6e} and turned by {:.6} degrees from the reference configuration",
                body.name,
                size(&body.displacement),
                size(&body.rotation).to_degrees()
            )
        };
        self.joints.iter().map(of_joint).chain(self.bodies.iter().map(of_body)).collect()
    }
}

impl System {
    /// Whether the analysis step begins where another one has ended, and not in the reference configuration or where the model is assembled,
    /// which need not be equilibria.
    pub fn continues(&self) -> bool {
        self.start.is_some() && self.closed_gaps.is_none()
    }
}
