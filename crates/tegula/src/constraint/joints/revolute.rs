//! Revolute joint: rotation about an axis.

use super::{Constraints, JointKind};
use crate::model::AxisJoint;

/// Revolute joint: the points coincide, and the axis is common.
pub struct Revolute;

impl JointKind for Revolute {
    type Keys = AxisJoint;

    fn constrain(keys: &AxisJoint, out: &mut Constraints) {
        out.coincident(keys.at);
        out.parallel(&keys.axis.into());
    }

    fn example() -> AxisJoint {
        AxisJoint::example()
    }
}
