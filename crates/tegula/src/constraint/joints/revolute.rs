//! Revolute joint: rotation about an axis.

use super::{Constraints, Coordinate, Held, JointKind, check_law};
use crate::checker::Checker;
use crate::model::CoordinateJoint;
use crate::{Mat3, Vec3};

/// Revolute joint: the points coincide, and the axis is common. At a node of a shell, whose rotation about its director d no
/// stiffness resists, the axis a of the other end is perpendicular to the director: `a·d = 0`.
pub struct Revolute;

impl JointKind for Revolute {
    type Keys = CoordinateJoint;

    fn check(keys: &CoordinateJoint, key: &str, checker: &mut Checker) {
        check_law(keys, true, key, checker);
    }

    fn constrain(keys: &CoordinateJoint, out: &mut Constraints) {
        out.coincident(keys.at);
        if out.has_director() {
            out.across_director(&keys.axis.into());
        } else {
            out.parallel(&keys.axis.into());
        }
    }

    fn held(keys: &CoordinateJoint, turned: &[Mat3; 2]) -> Vec<Held> {
        vec![Held::rotation_about(&(turned[0] * Vec3::from(keys.axis)))]
    }

    fn coordinate(keys: &CoordinateJoint) -> Option<Coordinate> {
        Some(Coordinate { is_angle: true, axis: keys.axis, at: keys.at, normals: 0..3 })
    }

    fn example() -> CoordinateJoint {
        CoordinateJoint::example()
    }
}
