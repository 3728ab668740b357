//! Cylindrical joint: rotation about an axis and sliding along it.

use super::{Constraints, Held, JointKind};
use crate::model::AxisJoint;
use crate::{Mat3, Vec3};

/// Cylindrical joint: the axis is common.
pub struct Cylindrical;

impl JointKind for Cylindrical {
    type Keys = AxisJoint;

    fn constrain(keys: &AxisJoint, out: &mut Constraints) {
        out.parallel(&keys.axis.into());
        out.on_line(&keys.axis.into(), keys.at);
    }

    fn held(keys: &AxisJoint, turned: &[Mat3; 2]) -> Vec<Held> {
        let axis = turned[0] * Vec3::from(keys.axis).normalize();
        vec![Held::rotation_about(&axis), Held::InPlane(axis)]
    }

    fn example() -> AxisJoint {
        AxisJoint::example()
    }
}
