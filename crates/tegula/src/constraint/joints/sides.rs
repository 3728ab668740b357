//! The two sides of a joint: where a point or an axis of the joint lies on each of them.
//!
//! The constraints of a joint are written for the place `x`, `a` of the joint on its first side. On the second side, whose point `y` and axis `b`
//! may be others in the reference configuration, the direction `e` of the joint lies along `R e` and its point `x + s` at `y + R s`, with the
//! smallest rotation R that takes a into b. With R the forms of a joint whose sides differ are those of one whose sides do not, and the sides
//! meet where all of them vanish. Angles about the axis count from the place where `R e` on the second side is along `e` on the first one.

use super::{Constraints, End};
use crate::constraint::{Attachment, Row};
use crate::element::geometry::tangents;
use crate::model::JointKeys;
use crate::{Mat3, Vec3};

/// Distance of the sides of a joint over the size of the model, and angle between them (rad), that are round-off.
pub(crate) const NO_GAP: f64 = 1e-9;

/// Keys of the axes of joints that have one in each side.
const OF_SIDES: [&str; 2] = ["axes[0]", "axes[1]"];

/// Cosine of the angle between two directions above −1, below which the rotation between them has no axis of its own.
const OPPOSITE: f64 = 1e-12;

/// Rigid motion that takes the place of a joint on its first side to that on its second one, in the reference configuration.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct SecondPlace {
    /// Smallest rotation from the axis of the first side to that of the second one.
    rotation: Mat3,
    /// Point of the first side.
    first: Vec3,
    /// Point of the second side.
    second: Vec3,
    /// Whether it matters that axes meet in the same direction: sides that do not meet in the reference configuration, or whose bodies move when
    /// the model is assembled, may come to opposite ones.
    one_way: bool,
}

impl SecondPlace {
    /// Sides that meet in the reference configuration.
    pub fn same() -> Self {
        Self { rotation: Mat3::identity(), first: Vec3::zeros(), second: Vec3::zeros(), one_way: false }
    }

    /// Place of a joint on its second side, of which it has gone this part of the way from that on the first one, in a model of this size. Sides
    /// apart by round-off meet.
    pub fn of(keys: &dyn JointKeys, part: f64, length: f64) -> Self {
        let given = keys.second_side();
        let first = keys.points().first().map_or_else(Vec3::zeros, |(_, x)| Vec3::from(*x));
        let second = given
            .at
            .map(Vec3::from)
            .filter(|second| !((second - first).norm() <= NO_GAP * length))
            .unwrap_or(first);
        let axes = keys.directions().first().map(|(_, a)| Vec3::from(*a)).zip(given.axis.map(Vec3::from));
        let rotation = axes.map_or_else(Mat3::identity, |(a, b)| rotation_between(&a, &b, part));
        Self { rotation, first, second: first + (second - first) * part, one_way: given.is_given() }
    }

    /// The place of a joint in a model that is assembled, or not.
    pub fn in_assembly(self, assembled: bool) -> Self {
        Self { one_way: self.one_way || assembled, ..self }
    }

    /// Point of the second side for one of the joint.
    fn point(&self, x: &Vec3) -> Vec3 {
        // Sides that meet have exactly the same point.
        let meet = self.second == self.first && self.rotation == Mat3::identity();
        if meet { *x } else { self.second + self.rotation * (x - self.first) }
    }

    /// Direction of the second side for one of the joint.
    pub fn direction(&self, e: &Vec3) -> Vec3 {
        self.rotation * e
    }
}

/// Part of the smallest rotation from one direction to another.
fn rotation_between(from: &Vec3, to: &Vec3, part: f64) -> Mat3 {
    let (a, b) = (from.normalize(), to.normalize());
    let across = a.cross(&b);
    let (sine, cosine) = (across.norm(), a.dot(&b));
    if sine <= NO_GAP && cosine > 0.0 {
        return Mat3::identity();
    }
    let axis = if cosine < OPPOSITE - 1.0 { tangents(&a)[0] } else { across / sine };
    nalgebra::Rotation3::from_axis_angle(&nalgebra::Unit::new_unchecked(axis), part * sine.atan2(cosine))
        .into_inner()
}

impl Constraints {
    /// Points of both ends at a place of the joint.
    pub(super) fn points(&self, at: &Vec3) -> [Attachment; 2] {
        [self.ends[0].point(at), self.ends[1].point(&self.second.point(at))]
    }

    /// Excludes that an axis is closed half a turn away, or where it lies along another one of the joint, where the last constraint holds, too.
    pub(super) fn not_opposite(&mut self, axis: &Vec3) {
        if !self.second.one_way {
            return;
        }
        let axes = self.ends[0].axis(axis).zip(self.second_axis(axis));
        if let (Some((first, second)), Some(row)) = (axes, self.rows.last_mut()) {
            let mut form = Row::default();
            form.add_product(&mut self.vectors, 1.0, &first, &second);
            // Axes along another one have the product 0.
            form.add_constant(-0.5);
            row.keep_positive(form);
        }
    }

    /// Axis of the second end along a direction of the joint; `None` for points.
    pub(super) fn second_axis(&self, along: &Vec3) -> Option<Attachment> {
        self.ends[1].axis(&self.second.direction(along))
    }
}

/// Axes of a joint with these directions, fixed in a side, or in the other one where that has no axes.
pub(super) fn axes(
    directions: &[(&str, [f64; 3])],
    (ends, side): (&[End; 2], usize),
    second: &SecondPlace,
) -> Option<[Attachment; 3]> {
    let of = |side: usize| {
        // Joints with an axis of each side have the keys `axes[0]` and `axes[1]`.
        let own = directions.iter().find(|(key, _)| *key == OF_SIDES[side]);
        let direction = own.or(directions.first());
        let base = direction.map_or([Vec3::x(), Vec3::y(), Vec3::z()], |(_, axis)| {
            let axis = Vec3::from(*axis).normalize();
            let [first, second] = tangents(&axis);
            [first, second, axis]
        });
        let fixed = base.map(|e| ends[side].axis(&if side == 1 { second.direction(&e) } else { e }));
        let [a, b, c] = fixed;
        Some([a?, b?, c?])
    };
    of(side).or_else(|| of(1 - side))
}

/// Place of the point of a joint on a side.
pub(super) fn place_on(end: &End, at: &Vec3, second: Option<&SecondPlace>) -> Attachment {
    end.point(&second.map_or(*at, |second| second.point(at)))
}
