//! Constant distance of two points.

use super::{Constraints, JointKind};
use crate::model::DistanceJoint;

/// Constant distance of two points, as of the ends of a rod without mass.
pub struct Distance;

impl JointKind for Distance {
    type Keys = DistanceJoint;

    fn constrain(keys: &DistanceJoint, out: &mut Constraints) {
        out.distance(keys.points);
    }

    fn example() -> DistanceJoint {
        DistanceJoint::example()
    }
}
