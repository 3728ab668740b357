//! Point on a curve: a bead on a wire, a roller in a guide.

use super::{Constraints, JointKind};
use crate::Vec3;
use crate::checker::Checker;
use crate::constraint::Spline;
use crate::model::CurveJoint;
use crate::norm::larger;

/// Most points of a curve.
const MOST_POINTS: usize = 1000;
/// Distance of the point from the curve, over the length of the curve, that is round-off.
const ON_CURVE: f64 = 1e-9;

/// Point on a curve: the point of the second end moves along a smooth curve that is fixed in the first one; rotations are free.
pub struct PointOnCurve;

impl JointKind for PointOnCurve {
    type Keys = CurveJoint;

    fn check(keys: &CurveJoint, key: &str, checker: &mut Checker) {
        let (place, name, n) = (format!("{key}.points"), &keys.name, keys.points.len());
        let fewest = if keys.closed { 3 } else { 2 };
        if !(fewest..=MOST_POINTS).contains(&n) {
            let what = if keys.closed { "closed curve" } else { "curve" };
            return checker.add(
                place,
                format!("the {what} of the joint \"{name}\" has {n} points"),
                format!("give {fewest} to {MOST_POINTS} points"),
            );
        }
        if keys.points.iter().chain([&keys.at]).flatten().any(|x| !x.is_finite()) {
            return checker.finite(&place, "the point of a curve", keys.points.as_flattened());
        }
        let points: Vec<Vec3> = keys.points.iter().map(|x| Vec3::from(*x)).collect();
        let chords: Vec<f64> = (0..n).map(|i| (points[(i + 1) % n] - points[i]).norm()).collect();
        let longest = chords.iter().copied().fold(0.0, larger);
        let pieces = if keys.closed { n } else { n - 1 };
        if let Some(i) = (0..pieces).find(|&i| !(chords[i] > ON_CURVE * longest)) {
            let help = if i + 1 == n {
                "leave the last point out: a closed curve goes on to its first one"
            } else {
                "leave one of them out"
            };
            let message =
                format!("points {i} and {} of the curve of the joint \"{name}\" coincide", (i + 1) % n);
            return checker.add(place, message, help);
        }
        let curve = Spline::new(points, keys.closed);
        if let Some([a, b]) = curve.meets_itself() {
            let [a, b] = [a, b].map(|u| curve.point(u).position);
            return checker.add(
                place,
                format!(
                    "the curve of the joint \"{name}\" crosses itself, or comes nearer to itself than to its next point: near \
                     ({:.4}, {:.4}, {:.4}) and ({:.4}, {:.4}, {:.4})",
                    a.x, a.y, a.z, b.x, b.y, b.z
                ),
                "give more points there, or a curve that keeps a distance from itself",
            );
        }
        let at = Vec3::from(keys.at);
        let near = curve.nearest(&at);
        let distance = (near.position - at).norm();
        if distance > ON_CURVE * curve.length() || curve.end_passed(near.parameter).is_some() {
            let near = curve.point(near.parameter.clamp(0.0, curve.length())).position;
            checker.add(
                format!("{key}.at"),
                format!("the point of the joint \"{name}\" lies {distance:.3e} beside its curve"),
                format!("give a point of the curve; the nearest one is [{}, {}, {}]", near.x, near.y, near.z),
            );
        }
    }

    fn constrain(keys: &CurveJoint, out: &mut Constraints) {
        out.on_curve(&keys.points, keys.closed, keys.at);
    }

    fn example() -> CurveJoint {
        CurveJoint::example()
    }
}
