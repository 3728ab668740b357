//! Prismatic joint: sliding along an axis without rotation.

use super::{Constraints, Coordinate, Held, JointKind, check_law};
use crate::checker::Checker;
use crate::element::geometry::tangents;
use crate::model::CoordinateJoint;
use crate::{Mat3, Vec3};

/// Prismatic joint: the axis is common, and there is no rotation about it.
pub struct Prismatic;

impl JointKind for Prismatic {
    type Keys = CoordinateJoint;

    fn check(keys: &CoordinateJoint, key: &str, checker: &mut Checker) {
        check_law(keys, false, key, checker);
    }

    fn constrain(keys: &CoordinateJoint, out: &mut Constraints) {
        let axis = Vec3::from(keys.axis);
        out.parallel(&axis);
        out.on_line(&axis, keys.at);
        let [n1, n2] = tangents(&axis.normalize());
        out.constant_product(&n1, &n2);
    }

    fn held(keys: &CoordinateJoint, turned: &[Mat3; 2]) -> Vec<Held> {
        vec![Held::InPlane(turned[0] * Vec3::from(keys.axis).normalize())]
    }

    fn coordinate(keys: &CoordinateJoint) -> Option<Coordinate> {
        Some(Coordinate { is_angle: false, axis: keys.axis, at: keys.at, normals: 2..4 })
    }

    fn example() -> CoordinateJoint {
        CoordinateJoint::example()
    }
}
