//! Screw: rotation about an axis, and sliding along it in proportion.

use std::f64::consts::TAU;

use super::{Constraints, Held, JointKind};
use crate::checker::Checker;
use crate::model::ScrewJoint;
use crate::{Mat3, Vec3};

/// Screw: a cylindrical joint in which the point of the second end moves along the axis by `p φ/2π`, for the angle φ by which that end
/// has turned relative to the first one.
pub struct Screw;

impl JointKind for Screw {
    type Keys = ScrewJoint;

    fn check(keys: &ScrewJoint, key: &str, checker: &mut Checker) {
        let what = format!("the pitch of the screw \"{}\"", keys.name);
        let help = "a joint that turns without sliding is `revolute`";
        checker.not_zero(&format!("{key}.pitch"), &what, keys.pitch, help);
    }

    fn constrain(keys: &ScrewJoint, out: &mut Constraints) {
        out.parallel(&keys.axis.into());
        out.on_line(&keys.axis.into(), keys.at);
        out.rolling(&keys.axis.into(), &keys.axis.into(), keys.at, keys.pitch / TAU);
    }

    fn held(keys: &ScrewJoint, turned: &[Mat3; 2]) -> Vec<Held> {
        vec![Held::rotation_about(&(turned[0] * Vec3::from(keys.axis)))]
    }

    fn example() -> ScrewJoint {
        ScrewJoint::example()
    }
}
