//! Revolute joint: rotation about an axis.

use super::{Constraints, Held, JointKind};
use crate::model::AxisJoint;
use crate::{Mat3, Vec3};

/// Revolute joint: the points coincide, and the axis is common. At a node of a shell, whose rotation about its director d no
/// stiffness resists, the axis a of the other end is perpendicular to the director: `a·d = 0`.
pub struct Revolute;

impl JointKind for Revolute {
    type Keys = AxisJoint;

    fn constrain(keys: &AxisJoint, out: &mut Constraints) {
        out.coincident(keys.at);
        if out.has_director() {
            out.across_director(&keys.axis.into());
        } else {
            out.parallel(&keys.axis.into());
        }
    }

    fn held(keys: &AxisJoint, turned: &[Mat3; 2]) -> Vec<Held> {
        vec![Held::rotation_about(&(turned[0] * Vec3::from(keys.axis)))]
    }

    fn example() -> AxisJoint {
        AxisJoint::example()
    }
}
