//! Cylindrical joint: rotation about an axis and sliding along it.

use super::{Constraints, JointKind};
use crate::model::AxisJoint;

/// Cylindrical joint: the axis is common.
pub struct Cylindrical;

impl JointKind for Cylindrical {
    type Keys = AxisJoint;

    fn constrain(keys: &AxisJoint, out: &mut Constraints) {
        out.parallel(&keys.axis.into());
        out.on_line(&keys.axis.into(), keys.at);
    }

    fn example() -> AxisJoint {
        AxisJoint::example()
    }
}
