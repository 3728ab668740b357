//! Hinge: positions fixed along a straight edge, rotation about it free.

use super::{AXES, Constraints, SupportKind, SupportedNode};
use crate::Vec3;
use crate::checker::Checker;
use crate::model::OnSet;

/// Hinge: positions fixed along a straight edge, rotation about it free.
pub(super) struct Hinge;

impl SupportKind for Hinge {
    type Keys = OnSet;

    fn check_nodes(keys: &OnSet, key: &str, nodes: &[Vec3], extent: f64, c: &mut Checker) {
        let (a, name) = (nodes[0], &keys.on);
        let far = nodes.iter().max_by(|p, q| (*p - a).norm().total_cmp(&(*q - a).norm()));
        let axis = far.map_or(Vec3::zeros(), |x| x - a);
        if axis.norm() <= 1e-9 * extent {
            c.add(
                key,
                format!("set \"{name}\" is a single point: a hinge needs an edge"),
                "use type = \"spherical\", or a set with more nodes",
            );
            return;
        }
        let axis = axis.normalize();
        let off = nodes.iter().map(|x| (x - a).cross(&axis).norm()).fold(0.0, crate::norm::larger);
        if off > 1e-3 * extent {
            c.add(
                key,
                format!("the nodes of \"{name}\" are not collinear: a hinge would block the rotation"),
                "use a straight edge, or type = \"clamp\"",
            );
        }
    }

    fn constrain(_: &OnSet, node: &SupportedNode, out: &mut Constraints) {
        AXES.into_iter().for_each(|axis| out.fix(node.position, axis));
    }

    fn example() -> OnSet {
        OnSet::new("u_min")
    }
}
