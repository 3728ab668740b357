//! Spherical joint: the points coincide.

use super::{Constraints, Held, JointKind};
use crate::model::PointJoint;
use crate::{Mat3, Vec3};

/// Spherical joint: the points coincide, rotations are free.
pub struct Spherical;

impl JointKind for Spherical {
    type Keys = PointJoint;

    fn constrain(keys: &PointJoint, out: &mut Constraints) {
        out.coincident(keys.at);
    }

    fn held(_keys: &PointJoint, _turned: &[Mat3; 2]) -> Vec<Held> {
        let pairs = [(Vec3::x(), Vec3::y()), (Vec3::y(), Vec3::z()), (Vec3::z(), Vec3::x())];
        pairs.map(|(a, b)| Held::Perpendicular(a, b)).into()
    }

    fn example() -> PointJoint {
        PointJoint::example()
    }
}
