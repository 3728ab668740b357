//! Kinds of joints: the constraints that each of them imposes.
//!
//! A joint is one file of this folder and one line in the registry in `crates/tegula/src/model/joint.rs`. Its constraints
//! are sums of a few basic ones: coincident points, perpendicular axes, a point in a plane, a distance. The table of these
//! is in J. García de Jalón, E. Bayo, *Kinematic and dynamic simulation of multibody systems* (1994), Ch. 4. The motions that
//! a joint leaves free are [held](lock) by further ones where an analysis step locks it.

mod coordinate;
mod directors;
mod lock;
mod sides;

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use nalgebra::Quaternion;

use super::joint::MOST_VECTORS;
use super::{Attachment, Drive, Joint, Quantity, Role, Row, Spline};
use crate::checker::Checker;
use crate::model::{self, joints};
use crate::norm::larger;
use crate::{Mat3, Vec3};
pub(crate) use coordinate::{Coordinate, check_law};
pub use directors::Lack;
use lock::Held;
pub use lock::lock;
pub(crate) use sides::{NO_GAP, SecondPlace};

/// Largest change of a relative angle in a step (rad); a longer step is cut back. Near π the turn would be lost.
pub const LARGEST_TURN: f64 = 2.5;

/// Square of the cosine of half the tilt of two rotations, less than a full turn apart, between which the twist changes by the smaller way if that is
/// [short enough](LARGEST_TURN) for a step: where `cos a` of half its change a is −cos(π − 1.25) or less, the product of the quaternions
/// would be `ρ cos a + (1 − ρ) < 0`.
const LITTLE_TILT: f64 = 0.8;

/// Distance of the origin from a line between two points (q₀, q₃) of unit quaternions that counts as none: the sine and the cosine of the twist, which have the
/// size of its square there, are round-off.
const NO_DISTANCE: f64 = 1e-6;

/// One of the two sides of a joint: a body, a node or the ground.
#[derive(Debug, Clone, PartialEq)]
pub enum End {
    /// The ground.
    Ground,
    /// A rigid body with its mass centre at the reference, mass and radius of gyration.
    Body {
        /// Nodal vectors of the mass centre and the directors.
        vectors: (u32, [u32; 3]),
        /// Mass centre and directors (columns) at the reference.
        reference: (Vec3, crate::Mat3),
        /// Mass and tr E.
        inertia: [f64; 2],
    },
    /// A point mass, or a node: it has no axes, but a node of a shell has directors.
    Point {
        /// Nodal vector of the position.
        vector: u32,
        /// Mass; 0 for nodes.
        mass: f64,
        /// Nodal vectors of the directors, with their values at the reference.
        directors: Vec<(u32, Vec3)>,
    },
    /// A point inside a shell element: it has no axes.
    Interior {
        /// Nodal vectors of the element with their weights.
        terms: Vec<(u32, f64)>,
    },
}

impl End {
    /// Point of the end at a place of the reference configuration.
    pub fn point(&self, at: &Vec3) -> Attachment {
        match self {
            Self::Ground => Attachment::ground(*at),
            Self::Body { vectors: (centre, directors), reference: (place, axes), .. } => {
                Attachment::point(*centre, *directors, &(axes.transpose() * (at - place)))
            }
            Self::Point { vector, .. } => Attachment::vector(*vector),
            Self::Interior { terms } => Attachment { terms: terms.clone(), constant: Vec3::zeros() },
        }
    }

    /// Axis of the end along a direction of the reference configuration; `None` for points.
    pub(super) fn axis(&self, along: &Vec3) -> Option<Attachment> {
        match self {
            Self::Ground => Some(Attachment::ground(*along)),
            Self::Body { vectors: (_, directors), reference: (_, axes), .. } => {
                Some(Attachment::axis(*directors, &(axes.transpose() * along)))
            }
            Self::Point { .. } | Self::Interior { .. } => None,
        }
    }

    /// Nodal vectors.
    pub fn vectors(&self) -> Vec<u32> {
        match self {
            Self::Ground => Vec::new(),
            Self::Body { vectors: (centre, directors), .. } => [&[*centre][..], directors].concat(),
            Self::Point { vector, directors, .. } => {
                std::iter::once(*vector).chain(directors.iter().map(|d| d.0)).collect()
            }
            Self::Interior { terms } => terms.iter().map(|term| term.0).collect(),
        }
    }

    /// Mass, and inertia of rotation.
    fn inertia(&self) -> [f64; 2] {
        match self {
            Self::Ground => [0.0; 2],
            Self::Body { inertia, .. } => *inertia,
            Self::Point { mass, .. } => [*mass, 0.0],
            Self::Interior { .. } => [0.0; 2],
        }
    }
}

/// Sine `½ (e₂ᴬ·e₁ᴮ − e₁ᴬ·e₂ᴮ)` and cosine `½ (e₁ᴬ·e₁ᴮ + e₂ᴬ·e₂ᴮ)` of the angle by which the second end has turned about an axis relative to the first one; `None`
/// where an end has no axes. The directions of the second end are those at its place of the joint.
///
/// With the quaternion (q₀, **q**) of the relative rotation they are `2 q₀ q·e₃` and `q₀² − (q·e₃)²`: the angle `2 atan(q·e₃/q₀)` is the twist about the axis e₃, which a
/// swing follows that tilts the axis on the shortest way (P. Dobrowolski, *Swing-twist decomposition in Clifford algebra*, 2015, arXiv:1506.05481). It does not depend
/// on the directions e₁ and e₂ across the axis. Where the axis stays common, both products are the same.
fn forms_of_angle(
    ([a, b], place): (&[End; 2], &SecondPlace),
    axis: &Vec3,
    vectors: &mut Vec<u32>,
) -> Option<[Row; 2]> {
    let [e1, e2] = crate::element::geometry::tangents(&axis.normalize());
    let fixed = [a.axis(&e1)?, a.axis(&e2)?];
    let turned = [b.axis(&place.direction(&e1))?, b.axis(&place.direction(&e2))?];
    let (mut sine, mut cosine) = (Row::default(), Row::default());
    sine.add_product(vectors, 0.5, &fixed[1], &turned[0]);
    sine.add_product(vectors, -0.5, &fixed[0], &turned[1]);
    cosine.add_product(vectors, 0.5, &fixed[0], &turned[0]);
    cosine.add_product(vectors, 0.5, &fixed[1], &turned[1]);
    Some([sine, cosine])
}

/// Angle of one end relative to another about an axis, right-handed and zero in the reference configuration.
#[derive(Debug, Clone, PartialEq)]
pub struct RelativeAngle {
    /// Nodal vectors of the forms.
    pub vectors: Vec<u32>,
    /// Sine of the angle.
    pub sine: Row,
    /// Cosine of the angle.
    pub cosine: Row,
    /// Directions e₁ and e₂ across the axis on both ends.
    across: [[Attachment; 2]; 2],
    /// Whether one of the ends is the ground.
    pub grounded: bool,
}

impl RelativeAngle {
    /// Angle of the second end relative to the first one; `None` where an end has no axes.
    pub fn new(ends: &[End; 2], axis: &Vec3) -> Option<Self> {
        let mut vectors = Vec::new();
        let [sine, cosine] = forms_of_angle((ends, &SecondPlace::same()), axis, &mut vectors)?;
        let [e1, e2] = crate::element::geometry::tangents(&axis.normalize());
        let across = [[ends[0].axis(&e1)?, ends[0].axis(&e2)?], [ends[1].axis(&e1)?, ends[1].axis(&e2)?]];
        Some(Self { vectors, sine, cosine, across, grounded: ends.contains(&End::Ground) })
    }

    /// Rotation of the second end relative to the first one, for these values of the nodal vectors.
    pub fn rotation(&self, vector: impl Fn(u32) -> Vec3) -> RelativeRotation {
        let frame = |[e1, e2]: &[Attachment; 2]| {
            let first = e1.value(&vector).normalize();
            let second = e2.value(&vector);
            let second = (second - first * first.dot(&second)).normalize();
            Mat3::from_columns(&[first, second, first.cross(&second)])
        };
        let relative = frame(&self.across[0]).transpose() * frame(&self.across[1]);
        let rotation = nalgebra::Rotation3::from_matrix_unchecked(relative);
        RelativeRotation(*nalgebra::UnitQuaternion::from_rotation_matrix(&rotation))
    }

    /// Values of sine and cosine with the nodal vectors v.
    pub fn forms(&self, v: &[Vec3]) -> [f64; 2] {
        [self.sine.form(v), self.cosine.form(v)]
    }

    /// Angle with these values of sine and cosine that is nearest to an earlier one.
    pub fn continued(earlier: f64, [sine, cosine]: [f64; 2]) -> f64 {
        Self::nearest(earlier, sine.atan2(cosine))
    }

    /// Angle with the nodal vectors v of a motion from a state with an earlier angle and rotation.
    pub fn after(&self, earlier: (f64, RelativeRotation), v: &[Vec3]) -> f64 {
        let (angle, rotation) = earlier;
        let [sine, cosine] = self.forms(v);
        let tilts = [rotation.square_of_twist_part(), sine.hypot(cosine)];
        let change = if tilts.iter().all(|square| *square >= LITTLE_TILT) {
            0.0
        } else {
            let place = |vector: u32| self.vectors.iter().position(|v| *v == vector);
            rotation.twist_to(self.rotation(|vector| place(vector).map_or_else(Vec3::zeros, |i| v[i])))
        };
        Self::continued(angle + change, [sine, cosine])
    }

    /// Angle that differs from this one by full turns and is nearest to an earlier one.
    pub fn nearest(earlier: f64, angle: f64) -> f64 {
        let change = angle - earlier;
        earlier + change - TAU * ((change + PI) / TAU).floor()
    }

    /// Rate of the angle with the nodal vectors v and their rates.
    pub fn rate(&self, v: &[Vec3], rates: &[Vec3]) -> f64 {
        let [g, h] = self.forms(v);
        let square = g * g + h * h;
        let mut gradient = [Vec3::zeros(); MOST_VECTORS];
        self.sine.add_gradient(h / square, v, 0.0, &mut gradient);
        self.cosine.add_gradient(-g / square, v, 0.0, &mut gradient);
        gradient.iter().zip(rates).map(|(w, rate)| w.dot(rate)).sum()
    }
}

/// Rotation of one end relative to another: a quaternion `q₀ + i q₁ + j q₂ + k q₃` whose third axis is that of a [relative angle](RelativeAngle).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RelativeRotation(Quaternion<f64>);

impl RelativeRotation {
    /// Numbers that hold a rotation: `q₀ − 1, q₁, q₂, q₃`, zeros in the reference configuration.
    pub const SIZE: usize = 4;

    /// The rotation that these numbers hold.
    pub fn read([w, i, j, k]: [f64; Self::SIZE]) -> Self {
        Self(Quaternion::new(w + 1.0, i, j, k))
    }

    /// Numbers that hold the rotation.
    pub fn numbers(self) -> [f64; Self::SIZE] {
        [self.0.w - 1.0, self.0.i, self.0.j, self.0.k]
    }

    /// Square `q₀² + q₃²` of the cosine of half the tilt.
    fn square_of_twist_part(&self) -> f64 {
        self.0.w * self.0.w + self.0.k * self.0.k
    }

    /// Change of the twist `2 atan(q₃/q₀)` in a motion that ends with another rotation, between −2π and 2π.
    ///
    /// A rotation at constant angular velocity moves the point (q₀, q₃) along half of an ellipse or less while it turns by less than a full turn: the chord between
    /// its ends, with signs of the quaternions that make their distance the smaller one, tells on which side of the origin it passes, and the twist is
    /// twice the angle that it is seen under from there. The twist so changes by nearly a full turn in a short time where the tilt passes by half a
    /// turn at a small distance. It has no value where the tilt is half a turn; motions through that point go on without a turn.
    pub fn twist_to(self, end: Self) -> f64 {
        let (p, mut q) = (self.0, end.0);
        if p.dot(&q) < 0.0 {
            q = -q;
        }
        let (cross, dot) = (p.w * q.k - p.k * q.w, p.w * q.w + p.k * q.k);
        let passes_through = dot < 0.0 && cross.abs() <= NO_DISTANCE * (q.w - p.w).hypot(q.k - p.k);
        2.0 * if passes_through { (-cross).atan2(-dot) } else { cross.atan2(dot) }
    }
}

/// Constraints of a joint in the making.
pub struct Constraints {
    ends: [End; 2],
    /// Place of the joint on the second end.
    second: SecondPlace,
    /// Body in which the hinges of gears lie.
    carrier: End,
    vectors: Vec<u32>,
    rows: Vec<Row>,
    /// Size of the model (length).
    length: f64,
    /// First thing that a constraint wanted of an end that does not have it.
    lack: Option<Lack>,
    /// Angle whose turns the state counts.
    counted: Option<Box<RelativeAngle>>,
}

impl Constraints {
    /// Mass, and inertia of rotation, that the constraints act on.
    fn inertia(&self, of_rotation: bool) -> f64 {
        self.ends.iter().map(|end| end.inertia()[usize::from(of_rotation)]).fold(0.0, larger)
    }

    /// Notes what an end lacks.
    fn lacks(&mut self, lack: Lack) {
        self.lack.get_or_insert(lack);
    }

    fn push(&mut self, mut row: Row, size: f64, inertia: f64) {
        (row.size, row.inertia, row.measure) = (size, inertia, (self.length / size).powi(2));
        self.rows.push(row);
    }

    /// The points of both ends at a place of the reference configuration coincide: three constraints.
    pub(super) fn coincident(&mut self, at: [f64; 3]) {
        let [a, b] = self.points(&at.into());
        for e in [Vec3::x(), Vec3::y(), Vec3::z()] {
            let row = Row::coincident(&mut self.vectors, &a, &b, &e);
            self.push(row, self.length, self.inertia(false));
        }
    }

    /// The product of an axis of the first end and an axis of the second one keeps its value where the sides meet.
    pub(super) fn constant_product(&mut self, a: &Vec3, b: &Vec3) {
        self.product(a, b, a.dot(b));
        self.not_opposite(a);
    }

    /// The product of an axis of the first end and an axis of the second one has a value.
    pub(super) fn product(&mut self, a: &Vec3, b: &Vec3, value: f64) {
        let axes = (self.ends[0].axis(a), self.second_axis(b));
        let (Some(first), Some(second)) = axes else {
            return self.lacks(Lack::Axis);
        };
        let mut row = Row::default();
        row.add_product(&mut self.vectors, 1.0, &first, &second);
        row.add_constant(-value);
        row.keeps = Quantity::Axes;
        self.push(row, 1.0, self.inertia(true));
    }

    /// The point of the second end at a place of the reference configuration stays in a plane of the first end.
    pub(super) fn in_plane(&mut self, normal: &Vec3, at: [f64; 3]) {
        let [a, b] = self.points(&at.into());
        let Some(n) = self.ends[0].axis(normal) else {
            return self.lacks(Lack::Axis);
        };
        let mut row = Row::default();
        row.add_product(&mut self.vectors, 1.0, &n, &b);
        row.add_product(&mut self.vectors, -1.0, &n, &a);
        self.push(row, self.length, self.inertia(false));
    }

    /// The distance of a point of each end is constant: `½ (|x_A − x_B|² − L²) = 0`.
    pub(super) fn distance(&mut self, points: [[f64; 3]; 2]) {
        let [a, b] = [0, 1].map(|i| self.ends[i].point(&points[i].into()));
        let length = (Vec3::from(points[0]) - Vec3::from(points[1])).norm();
        let mut row = Row::default();
        for (factor, x, y) in [(0.5, &a, &a), (0.5, &b, &b), (-1.0, &a, &b)] {
            row.add_product(&mut self.vectors, factor, x, y);
        }
        row.add_constant(-0.5 * length * length);
        row.keeps = Quantity::Distance(length);
        self.push(row, length * self.length, self.inertia(false) / (length * length));
    }

    /// The second end has turned by the drive's angle relative to the first one about a common axis.
    pub(super) fn driven_angle(&mut self, axis: &Vec3) {
        let Some([mut sine, cosine]) = forms_of_angle((&self.ends, &self.second), axis, &mut self.vectors)
        else {
            return self.lacks(Lack::Axis);
        };
        sine.drive_angle(cosine);
        sine.keeps = Quantity::Axes;
        self.push(sine, 1.0, self.inertia(true));
    }

    /// The point of the second end has moved along a direction of the first one by `ratio` times the angle by which the second end has
    /// turned about an axis relative to the first one.
    pub(super) fn rolling(&mut self, direction: &Vec3, axis: &Vec3, at: [f64; 3], ratio: f64) {
        let Some(forms) = forms_of_angle((&self.ends, &self.second), axis, &mut self.vectors) else {
            return self.lacks(Lack::Axis);
        };
        self.in_plane(&direction.normalize(), at);
        if let Some(row) = self.rows.last_mut() {
            row.turn(-ratio, forms);
        }
    }

    /// The point of the second end at a place of the reference configuration stays on a curve that is fixed in the first one: two
    /// constraints.
    pub(super) fn on_curve(&mut self, points: &[[f64; 3]], closed: bool, at: [f64; 3]) {
        let [a, b] = [0, 1].map(|i| self.ends[i].point(&at.into()));
        let at = Vec3::from(at);
        let curve = Arc::new(Spline::new(points.iter().map(|x| Vec3::from(*x) - at).collect(), closed));
        let mut coordinates =
            [Vec3::x(), Vec3::y(), Vec3::z()].map(|e| (Row::default(), self.ends[0].axis(&e)));
        for (row, axis) in &mut coordinates {
            let Some(axis) = axis else { return self.lacks(Lack::Curve) };
            row.add_product(&mut self.vectors, 1.0, axis, &b);
            row.add_product(&mut self.vectors, -1.0, axis, &a);
        }
        let coordinates = coordinates.map(|(row, _)| row);
        for normal in 0..2 {
            let mut row = Row::default();
            row.follow_curve(&curve, coordinates.clone(), normal);
            self.push(row, self.length, self.inertia(false));
        }
    }

    /// The angles by which both ends have turned about their axes relative to the carrier satisfy `c₁ φ₁ + c₂ φ₂ = 0`.
    pub(super) fn geared(&mut self, axes: &[Vec3; 2], factors: [f64; 2]) {
        let of_end = |i: usize| [self.carrier.clone(), self.ends[i].clone()];
        let mut forms =
            |i: usize| forms_of_angle((&of_end(i), &SecondPlace::same()), &axes[i], &mut self.vectors);
        let (Some(first), Some(second)) = (forms(0), forms(1)) else { return self.lacks(Lack::Axis) };
        self.counted = RelativeAngle::new(&of_end(0), &axes[0]).map(Box::new);
        let mut row = Row::default();
        row.gear(factors, [first, second]);
        row.keeps = Quantity::Axes;
        self.push(row, 1.0, self.inertia(true));
    }

    /// The point of the second end has moved by the drive's length along an axis of the first one.
    pub(super) fn driven_length(&mut self, axis: &Vec3, at: [f64; 3]) {
        let [a, b] = self.points(&at.into());
        let Some(n) = self.ends[0].axis(&axis.normalize()) else {
            return self.lacks(Lack::Axis);
        };
        let mut row = Row::default();
        row.add_product(&mut self.vectors, 1.0, &n, &b);
        row.add_product(&mut self.vectors, -1.0, &n, &a);
        row.drive_length();
        self.push(row, self.length, self.inertia(false));
    }

    /// The axis of both ends stays parallel: two constraints.
    pub(super) fn parallel(&mut self, axis: &Vec3) {
        let [e1, e2] = crate::element::geometry::tangents(&axis.normalize());
        self.constant_product(&axis.normalize(), &e1);
        self.constant_product(&axis.normalize(), &e2);
    }

    /// The point of the second end moves along a line of the first end: two constraints.
    pub(super) fn on_line(&mut self, axis: &Vec3, at: [f64; 3]) {
        for normal in crate::element::geometry::tangents(&axis.normalize()) {
            self.in_plane(&normal, at);
        }
    }
}

/// Kind of joint.
pub(crate) trait JointKind {
    /// Keys in the model file.
    type Keys;
    /// Adds the mistakes in the values that only this joint can have; `key` is the path of the joint in the model file.
    fn check(_keys: &Self::Keys, _key: &str, _checker: &mut Checker) {}
    /// Adds its constraints.
    fn constrain(keys: &Self::Keys, out: &mut Constraints);
    /// Constraints that hold the motions which it leaves free, where directions fixed in each end have `turned` from the reference
    /// configuration; none where it cannot be locked.
    fn held(_keys: &Self::Keys, _turned: &[Mat3; 2]) -> Vec<Held> {
        Vec::new()
    }
    /// Relative coordinate on which friction and stops act; `None` for joints that have none of both.
    fn coordinate(_keys: &Self::Keys) -> Option<Coordinate> {
        None
    }
    /// Keys of a joint between the bodies `a` and `b`, or `b` and a node of the strip of the tests, on which the contract of all joints
    /// is tested.
    fn example() -> Self::Keys;
}

macro_rules! kinds {
    ($($file:ident::$kind:ident($keys:ident): $help:literal,)*) => {
        $(mod $file;)*

        fn constrain(joint: &model::Joint, out: &mut Constraints) {
            match joint {
                $(model::Joint::$kind(keys) => $file::$kind::constrain(keys, out),)*
            }
        }

        fn held(joint: &model::Joint, turned: &[Mat3; 2]) -> Vec<Held> {
            match joint {
                $(model::Joint::$kind(keys) => $file::$kind::held(keys, turned),)*
            }
        }

        fn coordinate(joint: &model::Joint) -> Option<Coordinate> {
            match joint {
                $(model::Joint::$kind(keys) => $file::$kind::coordinate(keys),)*
            }
        }

        impl model::Joint {
            /// Whether the joint leaves motions free that an analysis step may lock.
            pub fn can_be_locked(&self) -> bool {
                !held(self, &[Mat3::identity(); 2]).is_empty()
            }

            /// Adds the mistakes in the values that only this joint can have.
            pub(crate) fn check(&self, key: &str, checker: &mut Checker) {
                match self {
                    $(Self::$kind(keys) => $file::$kind::check(keys, key, checker),)*
                }
            }

            /// One joint of each kind between the bodies `a` and `b`, in the order of the registry: the contract of all joints
            /// is tested on them.
            pub fn examples() -> Vec<Self> {
                vec![$(Self::$kind($file::$kind::example())),*]
            }
        }
    };
}
joints!(kinds);

/// Constraints of a joint between two ends in a model of this size, which comes after the `others`, or what its ends lack. The angles of
/// gears are relative to a carrier.
pub fn joint(
    joint: &model::Joint,
    (ends, carrier): ([End; 2], End),
    length: f64,
    (others, drive): (&[Joint], Option<Drive>),
) -> Result<Joint, Lack> {
    let second = SecondPlace::of(joint.common(), 1.0, length);
    joint_at(joint, (ends, carrier, second), length, (others, drive))
}

/// Constraints of a joint as [`joint`] makes them, with this place on its second end.
pub(crate) fn joint_at(
    joint: &model::Joint,
    (ends, carrier, second): ([End; 2], End, SecondPlace),
    length: f64,
    (others, drive): (&[Joint], Option<Drive>),
) -> Result<Joint, Lack> {
    let points = joint.common().points();
    let side = usize::from(ends[1] != End::Ground);
    let at = points
        .get(side.min(points.len().saturating_sub(1)))
        .map_or_else(Vec3::zeros, |(_, x)| Vec3::from(*x));
    let point = sides::place_on(&ends[side], &at, (side == 1).then_some(&second));
    let axes = sides::axes(&joint.common().directions(), (&ends, side), &second);
    // The carrier of gears counts to the first end.
    let own = [ends[0].vectors(), carrier.vectors()].concat();
    let (vectors, rows) = (Vec::new(), Vec::new());
    let mut out = Constraints { ends, second, carrier, vectors, rows, length, lack: None, counted: None };
    if joint.common().second_side().axis.is_some() && out.has_director() {
        out.lacks(Lack::SameAxis);
    }
    constrain(joint, &mut out);
    let law = match coordinate(joint) {
        Some(of) if out.lack.is_none() => out.law(joint.common(), &of).map(Box::new),
        _ => None,
    };
    let Constraints { vectors, rows, lack, counted, .. } = out;
    let name = joint.common().name().to_owned();
    let of_first = vectors.iter().map(|v| own.contains(v)).collect();
    let (number, first) = (others.len(), others.last().map_or(0, |last| last.multipliers().end));
    if let Some(lack) = lack {
        return Err(lack);
    }
    Ok(Joint {
        name,
        vectors,
        of_first,
        point,
        axes,
        rows,
        first,
        number,
        drive,
        role: Role::Acting,
        engages: false,
        law,
        counted,
    })
}
