//! Director alignment: the director of a shell node stays parallel to an axis of the other side.

use super::{Constraints, JointKind};
use crate::model::DirectorJoint;

/// Director alignment: the director d of a node stays parallel to the axis a that is fixed in the other end and coincides with it at the
/// reference: `d·e₁ = d·e₂ = 0` with the axes e₁, e₂ across a, and `d·a > 0`. The node moves, and the director changes its length, as
/// without the joint.
pub struct DirectorAlignment;

impl JointKind for DirectorAlignment {
    type Keys = DirectorJoint;

    fn constrain(_keys: &DirectorJoint, out: &mut Constraints) {
        out.aligned_director();
    }

    fn example() -> DirectorJoint {
        DirectorJoint::example()
    }
}
