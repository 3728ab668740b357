//! Spherical joint: the points coincide.

use super::{Constraints, JointKind};
use crate::model::PointJoint;

/// Spherical joint: the points coincide, rotations are free.
pub struct Spherical;

impl JointKind for Spherical {
    type Keys = PointJoint;

    fn constrain(keys: &PointJoint, out: &mut Constraints) {
        out.coincident(keys.at);
    }

    fn example() -> PointJoint {
        PointJoint::example()
    }
}
