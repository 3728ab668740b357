//! Constraints of the directors of shell nodes, and what ends lack for a joint.
//!
//! A node of a shell has no axis but its director, and no stiffness resists a rotation about it (drilling). Directors may change their
//! length, too. The constraints are therefore products of a director and another axis that vanish.

use super::{Constraints, End};
use crate::Vec3;
use crate::constraint::{Attachment, Quantity, Row};
use crate::element::geometry::tangents;

/// Sine of the largest angle between directions that are parallel, or perpendicular, but for the digits of a file.
const SAME: f64 = 1e-6;

/// Property that the ends of a joint lack for its constraints.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Lack {
    /// An axis of a point mass or a node.
    Axis,
    /// Axes of the first end, in which a curve is fixed.
    Curve,
    /// A node of a shell among both ends.
    Director,
    /// One director: sheets meet at the node, which has as many.
    OneDirector(usize),
    /// A side with axes: both are nodes.
    Body,
    /// An axis perpendicular to the director: this is the angle between them (degrees).
    Across(f64),
    /// One axis for both sides, where one is a shell node, which has no other axis than its director.
    SameAxis,
    /// Axes across its own, by which the joint's angle of rotation, on which friction and stops act, is measured.
    Triad,
    /// An axis of the node along its director: this is the angle between them (degrees).
    Along(f64),
}

impl Lack {
    /// Message and help for the joint of a name.
    pub fn told(self, name: &str) -> (String, &'static str) {
        match self {
            Self::Axis => (
                format!("joint \"{name}\" needs an axis on both sides, but a point mass or a node has none"),
                "connect rigid bodies and the ground, or take type = \"spherical\" or \"distance\"; of a node of a shell \
                 \"clamped-director\", \"director-alignment\" and \"revolute\" hold the director",
            ),
            Self::Curve => (
                format!(
                    "the first side of the joint \"{name}\", in which its curve is fixed, is a point mass or a node, which has no axes"
                ),
                "name a body or the ground first, and behind it what moves along the curve",
            ),
            Self::Director => (
                format!(
                    "joint \"{name}\" aligns the director of a shell node, but neither of its sides is one"
                ),
                "name a set of one node of a shell, or take type = \"fixed\"",
            ),
            Self::OneDirector(number) => (
                format!(
                    "joint \"{name}\" holds the director of a shell node, but sheets meet at the node, which has {number} directors"
                ),
                "attach nodes of the fold to a body, and connect the body",
            ),
            Self::Body => (
                format!(
                    "joint \"{name}\" connects the directors of two shell nodes, but an axis that moves with them needs a triad, which \
                     nodes do not have"
                ),
                "connect each of the two nodes to a body; only type = \"universal\" keeps two directors perpendicular",
            ),
            Self::Across(angle) => (
                format!(
                    "the axis of the joint \"{name}\" is not perpendicular to the director of its node: the angle between them is \
                     {angle:.6} degrees"
                ),
                "give an axis perpendicular to the director, or attach nodes to a body, which takes axes in all directions",
            ),
            Self::SameAxis => (
                format!(
                    "the joint \"{name}\" has a `second_axis`, but a shell node has no axis that is turned to another one"
                ),
                "leave `second_axis` out, or attach nodes to a body and connect the body",
            ),
            Self::Triad => (
                format!(
                    "the joint \"{name}\" has friction or stops, but a shell node has no axes by which its angle of rotation is measured"
                ),
                "attach nodes to a body and connect the body, or leave `friction` and `stops` out",
            ),
            Self::Along(angle) => (
                format!(
                    "the axis of the joint \"{name}\" at the node is not along its director: the angle between them is {angle:.6} degrees"
                ),
                "give the director as the axis of the node, or attach nodes to a body, which takes axes in all directions",
            ),
        }
    }
}

/// Angle between two lines (degrees).
fn angle(a: &Vec3, b: &Vec3) -> f64 {
    a.cross(b).norm().atan2(a.dot(b).abs()).to_degrees()
}

impl End {
    /// Whether it is a node with directors.
    fn has_director(&self) -> bool {
        matches!(self, Self::Point { directors, .. } if !directors.is_empty())
    }

    /// Director of a node as an axis of unit length at the reference, with its value there.
    fn director(&self) -> Result<(Attachment, Vec3), Lack> {
        let Self::Point { directors, .. } = self else { return Err(Lack::Director) };
        match directors[..] {
            [(vector, value)] => {
                let length = value.norm();
                let axis = Attachment { terms: vec![(vector, 1.0 / length)], constant: Vec3::zeros() };
                Ok((axis, value / length))
            }
            [] => Err(Lack::Director),
            _ => Err(Lack::OneDirector(directors.len())),
        }
    }
}

impl Constraints {
    /// Whether one of the ends is a node with directors.
    pub(super) fn has_director(&self) -> bool {
        self.ends.iter().any(End::has_director)
    }

    /// Side of the node whose director is held; the other one has axes.
    fn side_of_director(&self) -> Result<usize, Lack> {
        match [0, 1].map(|i| self.ends[i].has_director()) {
            [true, true] => Err(Lack::Body),
            [false, false] => Err(Lack::Director),
            [first, _] => Ok(usize::from(!first)),
        }
    }

    /// Constraint that the director of a node stays perpendicular to another axis.
    fn perpendicular(&mut self, director: &Attachment, axis: &Attachment) -> Row {
        let mut row = Row::default();
        row.add_product(&mut self.vectors, 1.0, director, axis);
        row.keeps = Quantity::Axes;
        row
    }

    /// The director of a node stays parallel to the axis of the other end with which it coincides at the reference, and points the same
    /// way: two constraints.
    pub(super) fn aligned_director(&mut self) {
        self.try_aligned().unwrap_or_else(|lack| self.lacks(lack));
    }

    fn try_aligned(&mut self) -> Result<(), Lack> {
        let side = self.side_of_director()?;
        let (director, value) = self.ends[side].director()?;
        let [e1, e2] = tangents(&value);
        let axis = |e: &Vec3| self.ends[1 - side].axis(e).ok_or(Lack::Axis);
        let (along, across) = (axis(&value)?, [axis(&e1)?, axis(&e2)?]);
        for axis in &across {
            let mut row = self.perpendicular(&director, axis);
            row.keep_positive(self.perpendicular(&director, &along));
            self.push(row, 1.0, self.inertia(true));
        }
        Ok(())
    }

    /// An axis of the other end stays perpendicular to the director of a node: one constraint.
    pub(super) fn across_director(&mut self, axis: &Vec3) {
        self.try_across(axis).unwrap_or_else(|lack| self.lacks(lack));
    }

    fn try_across(&mut self, axis: &Vec3) -> Result<(), Lack> {
        let side = self.side_of_director()?;
        let (director, value) = self.ends[side].director()?;
        let axis = axis.normalize();
        let along = axis.dot(&value);
        if along.abs() > SAME {
            return Err(Lack::Across(angle(&axis, &value)));
        }
        let axis = self.ends[1 - side].axis(&(axis - value * along).normalize()).ok_or(Lack::Axis)?;
        let row = self.perpendicular(&director, &axis);
        self.push(row, 1.0, self.inertia(true));
        Ok(())
    }

    /// The axes of both ends stay perpendicular, where that of a node is its director: one constraint.
    pub(super) fn perpendicular_to_director(&mut self, axes: &[Vec3; 2]) {
        self.try_perpendicular(axes).unwrap_or_else(|lack| self.lacks(lack));
    }

    fn try_perpendicular(&mut self, axes: &[Vec3; 2]) -> Result<(), Lack> {
        for (end, axis) in self.ends.iter().zip(axes).filter(|(end, _)| end.has_director()) {
            let (_, value) = end.director()?;
            if axis.cross(&value).norm() > SAME * axis.norm() {
                return Err(Lack::Along(angle(axis, &value)));
            }
        }
        if !self.ends.iter().all(End::has_director) {
            let side = self.side_of_director()?;
            return self.try_across(&axes[1 - side]);
        }
        let [(a, _), (b, value)] = [self.ends[0].director()?, self.ends[1].director()?];
        let along = self.ends[0].director()?.1.dot(&value);
        if along.abs() > SAME {
            return Err(Lack::Across(along.acos().to_degrees()));
        }
        let row = self.perpendicular(&a, &b);
        self.push(row, 1.0, self.inertia(true));
        Ok(())
    }
}
