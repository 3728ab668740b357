//! Ball joint to the ground: positions fixed, directors free.

use super::{AXES, Constraints, SupportKind, SupportedNode};
use crate::model::OnSet;

/// Ball joint to the ground: positions fixed, directors free.
pub(super) struct Spherical;

impl SupportKind for Spherical {
    type Keys = OnSet;

    fn constrain(_: &OnSet, node: &SupportedNode, out: &mut Constraints) {
        AXES.into_iter().for_each(|axis| out.fix(node.position, axis));
    }

    fn example() -> OnSet {
        OnSet::new("u_min")
    }
}
