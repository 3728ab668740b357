//! Rack and pinion: a wheel that rolls along a straight line without slip.

use super::{Constraints, JointKind};
use crate::Vec3;
use crate::checker::Checker;
use crate::model::RackJoint;

/// Largest cosine between the rack and the axis of the pinion.
const SQUARE: f64 = 1e-6;

/// Rack and pinion: the centre of the pinion moves along the rack by `r φ`, for the angle φ by which the pinion has turned relative to the
/// rack. It has this one constraint; hinges and guides keep the distance of the centre and the direction of the axis.
pub struct RackAndPinion;

impl JointKind for RackAndPinion {
    type Keys = RackJoint;

    fn check(keys: &RackJoint, key: &str, checker: &mut Checker) {
        let what = format!("the radius of the pinion \"{}\"", keys.name);
        let help = "a negative radius is that of a pinion on the other side of the rack";
        checker.not_zero(&format!("{key}.radius"), &what, keys.radius, help);
        let [axis, direction] = [keys.axis, keys.direction].map(|x| Vec3::from(x).normalize());
        let cosine = axis.dot(&direction).abs();
        // Directions without length have a message of their own.
        if cosine > SQUARE {
            checker.add(
                format!("{key}.direction"),
                format!(
                    "the rack of \"{}\" is not perpendicular to the axis of the pinion: the angle is {:.4}°",
                    keys.name,
                    cosine.acos().to_degrees()
                ),
                "give a `direction` perpendicular to `axis`",
            );
        }
    }

    fn constrain(keys: &RackJoint, out: &mut Constraints) {
        out.rolling(&keys.direction.into(), &keys.axis.into(), keys.at, keys.radius);
    }

    fn example() -> RackJoint {
        RackJoint::example()
    }
}
