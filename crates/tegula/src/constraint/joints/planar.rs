//! Planar joint: motion in a plane.

use super::{Constraints, JointKind};
use crate::Vec3;
use crate::model::AxisJoint;

/// Planar joint: the point of the second end moves in the plane across the axis of the first end, and the axis stays
/// parallel.
pub struct Planar;

impl JointKind for Planar {
    type Keys = AxisJoint;

    fn constrain(keys: &AxisJoint, out: &mut Constraints) {
        out.parallel(&keys.axis.into());
        out.in_plane(&Vec3::from(keys.axis).normalize(), keys.at);
    }

    fn example() -> AxisJoint {
        AxisJoint::example()
    }
}
