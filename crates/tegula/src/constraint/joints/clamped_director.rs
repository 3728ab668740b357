//! Clamped director: a shell node is fixed but for its drilling rotation.

use super::{Constraints, JointKind};
use crate::checker::Checker;
use crate::model::PointJoint;

/// Clamped director: the points coincide, and the director of the node stays parallel to an axis of the other end. The rotation about
/// the director, which is no rotation of the node, stays free.
pub struct ClampedDirector;

impl JointKind for ClampedDirector {
    type Keys = PointJoint;

    fn check(keys: &PointJoint, key: &str, c: &mut Checker) {
        if keys.second_at.is_some() {
            c.add(
                format!("{key}.second_at"),
                format!("the joint \"{}\" clamps the director of a shell node where it is, and cannot be assembled", keys.name),
                "leave `second_at` out: the body and the node meet in the reference configuration",
            );
        }
    }

    fn constrain(keys: &PointJoint, out: &mut Constraints) {
        out.coincident(keys.at);
        out.aligned_director();
    }

    fn example() -> PointJoint {
        PointJoint::example_at_node()
    }
}
