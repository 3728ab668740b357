//! Fixed joint: no relative motion.

use super::{Constraints, JointKind};
use crate::Vec3;
use crate::model::PointJoint;

/// Fixed joint: the points coincide, and the axes d1, d2, d3 of both ends, parallel to those of space at the reference, stay
/// parallel: `d1_A·d2_B = d2_A·d3_B = d3_A·d1_B = 0`.
pub struct Fixed;

impl JointKind for Fixed {
    type Keys = PointJoint;

    fn constrain(keys: &PointJoint, out: &mut Constraints) {
        out.coincident(keys.at);
        for (a, b) in [(Vec3::x(), Vec3::y()), (Vec3::y(), Vec3::z()), (Vec3::z(), Vec3::x())] {
            out.constant_product(&a, &b);
            // The products vanish, too, where the axes are exchanged in turn, by a third of a turn about their diagonal.
            out.not_opposite(&a);
        }
    }

    fn example() -> PointJoint {
        PointJoint::example()
    }
}
