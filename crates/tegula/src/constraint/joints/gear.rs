//! Gears: the rotations of two bodies have a constant ratio.

use super::{Constraints, JointKind};
use crate::Vec3;
use crate::checker::Checker;
use crate::model::GearJoint;

/// Sine of the angle between axes that are parallel but for the digits of a file.
const SAME: f64 = 1e-6;

/// Gear: the angles φ₁ and φ₂ by which both ends have turned about their axes relative to the carrier satisfy `φ₁ = i φ₂`, with the ratio
/// `i = −r₂/r₁` of pitch circles that roll on each other. It has this one constraint; hinges hold the wheels in the carrier.
pub struct Gear;

impl JointKind for Gear {
    type Keys = GearJoint;

    fn check(keys: &GearJoint, key: &str, checker: &mut Checker) {
        let name = &keys.name;
        match (keys.radii, keys.ratio) {
            (None, None) => checker.add(
                key,
                format!("the gear \"{name}\" has no ratio"),
                "give `radii`, the two radii of its pitch circles, or `ratio`, the first angular velocity over the second one",
            ),
            (Some(_), Some(_)) => checker.add(
                format!("{key}.ratio"),
                format!("the gear \"{name}\" has both `radii` and `ratio`"),
                "give one of them",
            ),
            (None, Some(ratio)) => {
                let help = "the first angular velocity over the second one; a body that does not turn is held by `fixed`";
                checker.not_zero(&format!("{key}.ratio"), &format!("the ratio of the gear \"{name}\""), ratio, help);
            }
            (Some(radii), None) => {
                for (i, radius) in radii.into_iter().enumerate() {
                    let what = format!("the radius of a wheel of the gear \"{name}\"");
                    let help = "a negative radius is that of a wheel with internal teeth";
                    checker.not_zero(&format!("{key}.radii[{i}]"), &what, radius, help);
                }
                let [a, b] = keys.axes.map(|x| Vec3::from(x).normalize());
                if a.cross(&b).norm() <= SAME && a.dot(&b) < 0.0 {
                    checker.add(
                        format!("{key}.axes"),
                        format!("the axes of the gear \"{name}\" are parallel, but point in opposite directions"),
                        "turn one of them round: the signs of `radii` count for axes of the same direction",
                    );
                }
                if radii.iter().all(|radius| *radius < 0.0) {
                    checker.add(
                        format!("{key}.radii"),
                        format!("both wheels of the gear \"{name}\" have internal teeth"),
                        "give one of them a positive radius",
                    );
                }
            }
        }
        let [a, b] = &keys.between;
        if a != b && keys.between.contains(&keys.carrier) {
            checker.add(
                format!("{key}.carrier"),
                format!("the carrier of the gear \"{name}\" is \"{}\", one of its wheels", keys.carrier),
                "name the body in which the hinges of both wheels lie; it is \"ground\" unless given",
            );
        }
    }

    fn constrain(keys: &GearJoint, out: &mut Constraints) {
        let ratio = keys.ratio_of_angles();
        let size = ratio.abs().max(1.0);
        out.geared(&keys.axes.map(Vec3::from), [1.0 / size, -ratio / size]);
    }

    fn example() -> GearJoint {
        GearJoint::example()
    }
}
