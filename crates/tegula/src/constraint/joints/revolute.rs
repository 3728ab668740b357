//! Revolute joint: rotation about an axis.

use super::{Constraints, Held, JointKind};
use crate::model::AxisJoint;
use crate::{Mat3, Vec3};

/// Revolute joint: the points coincide, and the axis is common.
pub struct Revolute;

impl JointKind for Revolute {
    type Keys = AxisJoint;

    fn constrain(keys: &AxisJoint, out: &mut Constraints) {
        out.coincident(keys.at);
        out.parallel(&keys.axis.into());
    }

    fn held(keys: &AxisJoint, turned: &[Mat3; 2]) -> Vec<Held> {
        vec![Held::rotation_about(&(turned[0] * Vec3::from(keys.axis)))]
    }

    fn example() -> AxisJoint {
        AxisJoint::example()
    }
}
