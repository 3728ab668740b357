//! Universal joint: the points coincide, and two axes stay perpendicular.

use super::{Constraints, JointKind};
use crate::Vec3;
use crate::model::TwoAxesJoint;

/// Universal joint (Cardan joint): the points coincide, and an axis of the first end stays perpendicular to one of the
/// second end.
pub struct Universal;

impl JointKind for Universal {
    type Keys = TwoAxesJoint;

    fn constrain(keys: &TwoAxesJoint, out: &mut Constraints) {
        out.coincident(keys.at);
        let [a, b] = keys.axes.map(|axis| Vec3::from(axis).normalize());
        out.constant_product(&a, &b);
    }

    fn example() -> TwoAxesJoint {
        TwoAxesJoint::example()
    }
}
