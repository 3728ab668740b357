//! Constant distance of two points.

use super::{Constraints, JointKind};
use crate::checker::Checker;
use crate::model::DistanceJoint;

/// Constant distance of two points, as of the ends of a rod without mass.
pub struct Distance;

impl JointKind for Distance {
    type Keys = DistanceJoint;

    fn check(keys: &DistanceJoint, key: &str, c: &mut Checker) {
        if keys.points[0] == keys.points[1] {
            c.add(
                format!("{key}.points"),
                format!(
                    "the points of the joint \"{}\" coincide: their distance has no direction",
                    keys.name
                ),
                "give two different points, or take type = \"spherical\"",
            );
        }
    }

    fn constrain(keys: &DistanceJoint, out: &mut Constraints) {
        out.distance(keys.points);
    }

    fn example() -> DistanceJoint {
        DistanceJoint::example()
    }
}
