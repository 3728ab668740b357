//! Chosen components of position and director fixed.

use super::{AXES, Constraints, SupportKeys, SupportKind, SupportedNode};
use crate::checker::Checker;
use crate::model::{Axis, FixComponents};

/// Chosen components of position and director fixed.
pub(super) struct Fix;

impl SupportKind for Fix {
    type Keys = FixComponents;

    fn check(keys: &FixComponents, key: &str, c: &mut Checker) {
        if keys.position.is_empty() && keys.director.is_empty() {
            c.add(
                key,
                "fixes nothing",
                "list components: position = [\"x\", \"y\", \"z\"], director = [...]",
            );
        }
    }

    fn constrain(keys: &FixComponents, node: &SupportedNode, out: &mut Constraints) {
        for axis in &keys.position {
            out.fix(node.position, AXES[axis.index()]);
        }
        for axis in &keys.director {
            out.fix(node.directors, AXES[axis.index()]);
        }
    }

    fn example() -> FixComponents {
        FixComponents { on: "u_min".into(), position: vec![Axis::Z], director: vec![Axis::X] }
    }
}

impl SupportKeys for FixComponents {
    fn on(&self) -> &str {
        &self.on
    }
}
