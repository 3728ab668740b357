//! Clamp: positions, directors and gradients fixed.

use super::{AXES, Constraints, SupportKind, SupportedNode};
use crate::model::OnSet;

/// Clamp: positions, directors and gradients fixed.
pub(super) struct Clamp;

impl SupportKind for Clamp {
    type Keys = OnSet;

    fn constrain(_: &OnSet, node: &SupportedNode, out: &mut Constraints) {
        for axis in AXES {
            out.fix(node.position, axis);
            out.fix(node.directors, axis);
            out.fix(node.gradients, axis);
        }
    }

    fn example() -> OnSet {
        OnSet::new("u_min")
    }
}
