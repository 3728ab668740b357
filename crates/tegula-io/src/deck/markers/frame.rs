//! Frame: a point with three orthonormal axes.

use tegula::{Mat3, Vec3};

/// Cosine of the angle between parallel directions falls short of 1 by at most this; bodies have the same limit.
const SAME: f64 = 1e-9;

/// A point, and three orthonormal axes that are right-handed.
#[derive(Debug, Clone, Copy)]
pub(super) struct Frame {
    origin: Vec3,
    /// Axes as columns.
    axes: Mat3,
}

/// Reason why two directions make no axes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Defect {
    /// The direction of this number has length 0.
    Zero(usize),
    /// The directions are parallel.
    Parallel,
}

impl Frame {
    /// Origin and axes of space.
    pub const SPACE: Self = Self {
        origin: Vec3::new(0.0, 0.0, 0.0),
        axes: Mat3::new(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0),
    };

    /// Frame at a point: its first axis along the first direction `a`, its third one along `a × b` with the second direction `b`, its
    /// second one `e3 × e1`, as those of a body.
    pub fn new(origin: [f64; 3], directions: Option<[[f64; 3]; 2]>) -> Result<Self, Defect> {
        let origin = Vec3::from(origin);
        let Some([first, second]) = directions else { return Ok(Self { origin, ..Self::SPACE }) };
        let first = unit(first).ok_or(Defect::Zero(0))?;
        let second = unit(second).ok_or(Defect::Zero(1))?;
        if !(first.dot(&second).abs() <= 1.0 - SAME) {
            return Err(Defect::Parallel);
        }
        let third = first.cross(&second).normalize();
        Ok(Self { origin, axes: Mat3::from_columns(&[first, third.cross(&first), third]) })
    }

    /// Frame in space of one that is given in this frame.
    pub fn carry(&self, inner: &Self) -> Self {
        Self { origin: self.origin + self.axes * inner.origin, axes: self.axes * inner.axes }
    }

    /// Point of the frame (length).
    pub fn origin(&self) -> [f64; 3] {
        self.origin.into()
    }

    /// Axis 0, 1 or 2, or its opposite.
    pub fn axis(&self, i: usize, opposite: bool) -> [f64; 3] {
        // A sum with 0, so that no component is a negative zero.
        let sign = if opposite { -1.0 } else { 1.0 };
        std::array::from_fn(|k| sign * self.axes[(k, i)] + 0.0)
    }

    /// Whether all numbers are finite.
    pub fn is_finite(&self) -> bool {
        self.origin.iter().chain(self.axes.iter()).all(|x| x.is_finite())
    }
}

/// Unit vector along a direction of any size; none if it is zero.
fn unit(direction: [f64; 3]) -> Option<Vec3> {
    let direction = Vec3::from(direction);
    let size = direction.amax();
    if size == 0.0 { None } else { Some((direction / size).normalize()) }
}
