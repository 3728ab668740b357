//! Clamped director: a shell node is fixed but for its drilling rotation.

use super::{Constraints, JointKind};
use crate::model::PointJoint;

/// Clamped director: the points coincide, and the director of the node stays parallel to an axis of the other end. The rotation about
/// the director, which is no rotation of the node, stays free.
pub struct ClampedDirector;

impl JointKind for ClampedDirector {
    type Keys = PointJoint;

    fn constrain(keys: &PointJoint, out: &mut Constraints) {
        out.coincident(keys.at);
        out.aligned_director();
    }

    fn example() -> PointJoint {
        PointJoint::example_at_node()
    }
}
