//! Plane of symmetry: position and director do not move along its normal.

use super::{Constraints, SupportKeys, SupportKind, SupportedNode};
use crate::Vec3;
use crate::checker::Checker;
use crate::model::SymmetryPlane;

/// Plane of symmetry: position and director do not move along its normal.
pub(super) struct Symmetry;

impl SupportKind for Symmetry {
    type Keys = SymmetryPlane;

    fn check(keys: &SymmetryPlane, key: &str, c: &mut Checker) {
        if !Vec3::from(keys.normal).norm().is_normal() {
            c.add(
                format!("{key}.normal"),
                "the normal of the plane vanishes",
                "give a vector such as [1, 0, 0]",
            );
        }
    }

    fn check_nodes(keys: &SymmetryPlane, key: &str, nodes: &[Vec3], extent: f64, c: &mut Checker) {
        let Some(n) = Vec3::from(keys.normal).try_normalize(0.0) else { return };
        let (low, high) = nodes
            .iter()
            .map(|x| x.dot(&n))
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), d| (l.min(d), h.max(d)));
        if high - low > 1e-3 * extent {
            c.add(
                key,
                format!(
                    "the nodes of \"{}\" do not lie in one plane with the normal {:?}",
                    keys.on, keys.normal
                ),
                "check the normal, or choose the edge that lies in the plane",
            );
        }
    }

    fn constrain(keys: &SymmetryPlane, node: &SupportedNode, out: &mut Constraints) {
        let normal = Vec3::from(keys.normal).normalize();
        out.fix(node.position, normal);
        out.fix(node.directors, normal);
        for &vector in node.gradients {
            let along = Vec3::from(node.reference[vector as usize]).dot(&normal).abs();
            // The mirror image of the derivative across the plane is its opposite.
            if along < 1e-6 {
                out.fix(&[vector], normal);
            } else if along > 1.0 - 1e-6 {
                out.fix_across(&[vector], normal);
            } else {
                out.refuse((
                    "normal",
                    "the plane of symmetry lies obliquely to the gradients of ancf-full",
                    "use a plane along the coordinate axes, or another element",
                ));
            }
        }
    }

    fn example() -> SymmetryPlane {
        SymmetryPlane { on: "u_min".into(), normal: [1.0, 0.0, 0.0] }
    }
}

impl SupportKeys for SymmetryPlane {
    fn on(&self) -> &str {
        &self.on
    }
}
