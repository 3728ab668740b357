//! Driven length: the displacement of the second end relative to the first one along an axis is prescribed.

use super::{Constraints, JointKind};
use crate::model::DrivenLengthJoint;

/// Driven length s(t), zero in the reference configuration: `aᴬ·(x_B − x_A) = s` with the points of both ends that coincide
/// there.
pub struct DrivenLength;

impl JointKind for DrivenLength {
    type Keys = DrivenLengthJoint;

    fn constrain(keys: &DrivenLengthJoint, out: &mut Constraints) {
        out.driven_length(&keys.axis.into(), keys.at);
    }

    fn example() -> DrivenLengthJoint {
        DrivenLengthJoint::example()
    }
}
