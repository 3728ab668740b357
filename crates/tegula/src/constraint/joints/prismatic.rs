//! Prismatic joint: sliding along an axis without rotation.

use super::{Constraints, Held, JointKind};
use crate::element::geometry::tangents;
use crate::model::AxisJoint;
use crate::{Mat3, Vec3};

/// Prismatic joint: the axis is common, and there is no rotation about it.
pub struct Prismatic;

impl JointKind for Prismatic {
    type Keys = AxisJoint;

    fn constrain(keys: &AxisJoint, out: &mut Constraints) {
        let axis = Vec3::from(keys.axis);
        out.parallel(&axis);
        out.on_line(&axis, keys.at);
        let [n1, n2] = tangents(&axis.normalize());
        out.constant_product(&n1, &n2);
    }

    fn held(keys: &AxisJoint, turned: &[Mat3; 2]) -> Vec<Held> {
        vec![Held::InPlane(turned[0] * Vec3::from(keys.axis).normalize())]
    }

    fn example() -> AxisJoint {
        AxisJoint::example()
    }
}
