//! Modes of the relative coordinates of joints with friction and stops: that of a coordinate that moves, and the stop at which it stands.

use crate::constraint::{CoordinateLaw, CoordinateMode, Joint};
use crate::error::Error;

/// Distance from a stop over the size of the coordinate up to which a coordinate stands there.
pub(super) const CONTACT: f64 = 1e-10;

/// Mode of a coordinate that moves with a rate.
pub(super) fn moving(law: &CoordinateLaw, rate: f64) -> CoordinateMode {
    CoordinateMode::Moving(if law.has_friction() { rate.signum() } else { 0.0 })
}

/// Stop at which a coordinate stands: −1, 1, or 0 for none.
pub(super) fn stop_at(law: &CoordinateLaw, value: f64) -> f64 {
    let near = |bound: f64| (value - bound).abs() <= CONTACT * law.row.size;
    if near(law.stops[0]) {
        -1.0
    } else if near(law.stops[1]) {
        1.0
    } else {
        0.0
    }
}

/// Error of a joint that stands beyond a stop at the start.
pub(super) fn stands_beyond(joint: &Joint, law: &CoordinateLaw, value: f64) -> Error {
    let shown = |x: f64| if law.is_angle { x.to_degrees() } else { x };
    let bound = |x: f64| if x.is_finite() { shown(x).to_string() } else { "none".to_owned() };
    let [lower, upper] = law.stops.map(bound);
    Error::model(
        "joints",
        format!(
            "the joint \"{}\" stands at {} at the start, which is not between its stops {lower} and {upper}",
            joint.name,
            shown(value)
        ),
        "give `stops` that contain the displacement (angle) of the joint where it begins to act",
    )
}
