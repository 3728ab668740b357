//! Planar joint: motion in a plane.

use super::{Constraints, Held, JointKind};
use crate::element::geometry::tangents;
use crate::model::AxisJoint;
use crate::{Mat3, Vec3};

/// Planar joint: the point of the second end moves in the plane across the axis of the first end, and the axis stays
/// parallel.
pub struct Planar;

impl JointKind for Planar {
    type Keys = AxisJoint;

    fn constrain(keys: &AxisJoint, out: &mut Constraints) {
        out.parallel(&keys.axis.into());
        out.in_plane(&Vec3::from(keys.axis).normalize(), keys.at);
    }

    fn held(keys: &AxisJoint, turned: &[Mat3; 2]) -> Vec<Held> {
        let axis = turned[0] * Vec3::from(keys.axis).normalize();
        let [e1, e2] = tangents(&axis);
        vec![Held::rotation_about(&axis), Held::InPlane(e1), Held::InPlane(e2)]
    }

    fn example() -> AxisJoint {
        AxisJoint::example()
    }
}
