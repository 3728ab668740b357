//! Points on curves in a step: they must not leave the ends of their curves, nor jump from one part of a curve to another.

use super::System;
use crate::Vec3;
use crate::element::Nodal;

/// Largest angle by which the tangent may turn on the way of a point in a step (rad): a longer step might take a short cut.
const MOST_TURNING: f64 = 0.5;

/// Reason why a step cannot be accepted for a point on a curve.
#[derive(Debug, Clone, PartialEq)]
pub enum OffCurve {
    /// The point has moved on so far that the way along the curve is not known.
    TooFar(String),
    /// The point has left an open curve at an end.
    PastEnd(String),
}

impl System {
    /// Joint whose point cannot move along its curve between the displacements `old` and `new`.
    pub fn off_curve(&self, old: &[Nodal], new: &[Nodal]) -> Option<OffCurve> {
        self.joints.iter().find_map(|joint| {
            let row = joint.rows.first().filter(|row| row.follows_curve())?;
            let place = |u: &[Nodal]| {
                let at = |v: usize| Vec3::from(self.coordinates.reference[v]) + Vec3::from(u[v]);
                joint.with_vectors(at, |v, _| row.place_on_curve(v))
            };
            let ((curve, from), (_, to)) = (place(old)?, place(new)?);
            if let Some(end) = curve.end_passed(to) {
                let end = if end == 0 { "first" } else { "last" };
                return Some(OffCurve::PastEnd(format!(
                    "the point of the joint \"{}\" leaves its curve at the {end} of the curve's points",
                    joint.name
                )));
            }
            // An angle that is not a number does not pass either.
            (!(curve.turning(from, to) <= MOST_TURNING)).then(|| {
                OffCurve::TooFar(format!(
                    "the point of the joint \"{}\" passes a part of its curve that turns by more than {MOST_TURNING} rad in the step",
                    joint.name
                ))
            })
        })
    }
}
