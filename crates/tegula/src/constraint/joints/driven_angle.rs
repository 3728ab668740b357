//! Driven angle: the rotation of the second end relative to the first one about an axis is prescribed.

use super::{Constraints, JointKind};
use crate::model::DrivenAngleJoint;

/// Driven angle θ(t), right-handed about the axis, zero in the reference configuration: with the axes e₁, e₂ across it
/// `(e₂ᴬ·e₁ᴮ − e₁ᴬ·e₂ᴮ) cos θ − (e₁ᴬ·e₁ᴮ + e₂ᴬ·e₂ᴮ) sin θ = 0`.
pub struct DrivenAngle;

impl JointKind for DrivenAngle {
    type Keys = DrivenAngleJoint;

    fn constrain(keys: &DrivenAngleJoint, out: &mut Constraints) {
        out.driven_angle(&keys.axis.into());
    }

    fn example() -> DrivenAngleJoint {
        DrivenAngleJoint::example()
    }
}
