//! Universal joint: the points coincide, and two axes stay perpendicular.

use super::{Constraints, Held, JointKind};
use crate::checker::Checker;
use crate::model::TwoAxesJoint;
use crate::{Mat3, Vec3};

/// Cosine of the angle between two directions that are perpendicular but for round-off.
const PERPENDICULAR: f64 = 1e-9;

/// Universal joint (Cardan joint): the points coincide, and an axis of the first end stays perpendicular to one of the
/// second end. The only axis of a node of a shell is its director.
pub struct Universal;

impl JointKind for Universal {
    type Keys = TwoAxesJoint;

    fn check(keys: &TwoAxesJoint, key: &str, c: &mut Checker) {
        let [a, b] = keys.axes.map(|axis| Vec3::from(axis).normalize());
        // A model that is assembled makes them perpendicular.
        if keys.second_at.is_none() && a.dot(&b).abs() > PERPENDICULAR {
            c.add(
                format!("{key}.axes"),
                format!(
                    "the axes of the universal joint \"{}\" are not perpendicular to each other",
                    keys.name
                ),
                "give two perpendicular axes, or `second_at`, so that the model is assembled",
            );
        }
    }

    fn constrain(keys: &TwoAxesJoint, out: &mut Constraints) {
        out.coincident(keys.at);
        let [a, b] = keys.axes.map(|axis| Vec3::from(axis).normalize());
        if out.has_director() {
            out.perpendicular_to_director(&[a, b]);
        } else if keys.second_at.is_some() {
            out.product(&a, &b, 0.0);
        } else {
            out.constant_product(&a, &b);
        }
    }

    /// With the axis a of the first end, b of the second one and c = a × b, rotations about a change `b_A·c_B`, those about b `c_A·a_B`.
    fn held(keys: &TwoAxesJoint, turned: &[Mat3; 2]) -> Vec<Held> {
        let [a, b] = [0, 1].map(|i| turned[i] * Vec3::from(keys.axes[i]).normalize());
        let c = a.cross(&b).normalize();
        vec![Held::Perpendicular(b, c), Held::Perpendicular(c, a)]
    }

    fn example() -> TwoAxesJoint {
        TwoAxesJoint::example()
    }
}
