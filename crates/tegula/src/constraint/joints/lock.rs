//! Locked joints: constraints that hold the motions which a joint leaves free, where its two sides stand.
//!
//! Constraints of axes are best conditioned where the axes are perpendicular. They are therefore made as those of a joint are, with
//! the place in which the sides stand against each other instead of the reference configuration: as seen from the ground, or from the
//! first side where none of both is the ground. Seen so, sides that do not move against each other have the same constraints again,
//! wherever the two of them are, and a multiplier keeps its meaning from one analysis step to the next.

use super::{Constraints, End, SecondPlace, held};
use crate::constraint::{Joint, Row};
use crate::element::geometry::tangents;
use crate::model;
use crate::{Mat3, Vec3};

/// Constraint that holds a motion, in directions of a joint whose sides stand as they are.
#[derive(Debug, Clone, PartialEq)]
pub enum Held {
    /// An axis of the first end and one of the second end stay perpendicular.
    Perpendicular(Vec3, Vec3),
    /// The points of both ends that coincide stay in a plane across this direction, which is fixed in the first end.
    InPlane(Vec3),
}

impl Held {
    /// Constraint that holds the rotation about an axis.
    pub fn rotation_about(axis: &Vec3) -> Self {
        let [e1, e2] = tangents(&axis.normalize());
        Self::Perpendicular(e2, e1)
    }
}

/// Rigid motion `x = R X + t`.
#[derive(Debug, Clone, Copy)]
struct Motion {
    rotation: Mat3,
    shift: Vec3,
}

impl Motion {
    fn none() -> Self {
        Self { rotation: Mat3::identity(), shift: Vec3::zeros() }
    }

    /// Motion of an end from the reference to the configuration of the `current` nodal vectors; a point moves without rotation.
    fn of(end: &End, current: &impl Fn(u32) -> Vec3) -> Self {
        match end {
            End::Ground => Self::none(),
            End::Body { vectors: (centre, directors), reference: (place, axes), .. } => {
                let rotation = Mat3::from_columns(&directors.map(current)) * axes.transpose();
                Self { rotation, shift: current(*centre) - rotation * place }
            }
            End::Point { .. } | End::Interior { .. } => Self::none(),
        }
    }

    fn place(&self, x: &Vec3) -> Vec3 {
        self.rotation * x + self.shift
    }

    /// The motion as a body with another motion sees it.
    fn seen_from(&self, other: &Self) -> Self {
        let back = other.rotation.transpose();
        Self { rotation: back * self.rotation, shift: back * (self.shift - other.shift) }
    }
}

/// End in the place to which a motion has brought it, as if that were its reference.
fn moved(end: &End, motion: &Motion) -> End {
    match end {
        End::Body { vectors, reference: (place, axes), inertia } => End::Body {
            vectors: *vectors,
            reference: (motion.place(place), motion.rotation * axes),
            inertia: *inertia,
        },
        // The director of a node is no axis that is fixed in a body which has moved.
        End::Point { vector, mass, .. } => End::Point { vector: *vector, mass: *mass, directors: Vec::new() },
        End::Interior { .. } | End::Ground => end.clone(),
    }
}

/// Constraints that hold both ends of a joint where the `current` nodal vectors have them, behind those of its kind; the joint contains
/// all nodal vectors of its ends. `None` where an end has no axes.
pub fn lock(
    keys: &model::Joint,
    ends: &[End; 2],
    (joint, length): (&Joint, f64),
    current: impl Fn(u32) -> Vec3,
) -> Option<Vec<Row>> {
    let mut motions = [0, 1].map(|i| Motion::of(&ends[i], &current));
    if !ends.contains(&End::Ground) {
        motions = [Motion::none(), motions[1].seen_from(&motions[0])];
    }
    let at = keys.common().points().first().map_or_else(Vec3::zeros, |(_, x)| Vec3::from(*x));
    let at = motions[0].place(&at);
    let mut out = Constraints {
        ends: [0, 1].map(|i| moved(&ends[i], &motions[i])),
        // The sides meet where they stand.
        second: SecondPlace::same(),
        vectors: joint.vectors.clone(),
        rows: Vec::new(),
        length,
        lack: None,
        carrier: End::Ground,
        counted: None,
    };
    for constraint in held(keys, &motions.map(|motion| motion.rotation)) {
        match constraint {
            Held::Perpendicular(a, b) => out.constant_product(&a, &b),
            Held::InPlane(normal) => out.in_plane(&normal, at.into()),
        }
    }
    (out.lack.is_none() && out.vectors.len() == joint.vectors.len()).then_some(out.rows)
}
