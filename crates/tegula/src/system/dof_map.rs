//! Degree-of-freedom map: supports of the nodal vectors, and the numbers of their free degrees of freedom.

use super::Attached;
#[cfg(doc)]
use crate::load::LoadFactor;
use crate::load::{LoadParameter, TimeFunction};
use crate::{Mat3, Vec3};

/// Relative distance of two displacements that differ by round-off only.
const SAME: f64 = 1e-9;

/// Mark of a constrained degree of freedom.
pub const CONSTRAINED: u32 = u32::MAX;

/// Degree-of-freedom map: constrained degrees of freedom, and numbers of the free ones. It does not change during an
/// analysis step.
///
/// Each nodal vector has three degrees of freedom along the axes of its frame ([`LocalFrames`](super::LocalFrames)).
/// Constrained degrees of freedom are eliminated; the free ones are numbered consecutively.
#[derive(Debug, Clone, Default)]
pub struct DofMap {
    /// Number of the free degree of freedom `3 v + c`, or [`CONSTRAINED`].
    pub(super) free: Vec<u32>,
    /// Prescribed degrees of freedom.
    pub prescribed: Vec<Prescribed>,
    /// Number of free degrees of freedom.
    pub unknowns: usize,
    /// Inextensible directors: their local frames rotate with them, the last axis along the vector.
    pub unit: Vec<UnitVector>,
    /// Directors of rigid bodies, ascending: three orthonormal nodal vectors which share the degrees of freedom of a
    /// rotation, `δd_i = δθ × d_i`. The map numbers these in place of those of the first director.
    pub triads: Vec<[u32; 3]>,
    /// Nodal vectors attached to rigid bodies, ascending: they have no degrees of freedom of their own.
    pub attached: Vec<Attached>,
}

/// Prescribed degree of freedom: its displacement follows a value times an amplitude, or stays where it is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Prescribed {
    /// Degree of freedom `3 v + c`, along the local axis c of the nodal vector v.
    pub dof: u32,
    /// Displacement at amplitude 1.
    pub value: f64,
    /// Index of the amplitude.
    pub amplitude: Option<usize>,
    /// Displacement at the start of the analysis step.
    pub start: f64,
    /// Whether the degree of freedom is fixed: it stays at `start`.
    pub held: bool,
}

impl Prescribed {
    /// Nodal vector and component.
    pub fn place(&self) -> (usize, usize) {
        (self.dof as usize / 3, self.dof as usize % 3)
    }

    /// Displacement at a time or load factor; see [`LoadFactor::value`] for load factors below 0.
    pub fn displacement(&self, amplitudes: &[TimeFunction], parameter: LoadParameter, at: f64) -> f64 {
        let Self { value, amplitude, start, held, .. } = *self;
        match (amplitude, parameter) {
            _ if held => start,
            (Some(i), LoadParameter::LoadFactor) if at < 0.0 => {
                start + (1.0 + at) * (value * amplitudes[i].value(0.0) - start)
            }
            (Some(i), _) => value * amplitudes[i].value(at),
            (None, LoadParameter::LoadFactor) => start + f64::max(at, 0.0) * (value - start),
            (None, LoadParameter::PathFactor) => start + at * (value - start),
            (None, LoadParameter::Time) => value,
        }
    }

    /// Whether an amplitude begins elsewhere than the degree of freedom is at the start of the step.
    pub fn jumps(&self, amplitudes: &[TimeFunction]) -> bool {
        let Some(amplitude) = self.amplitude.and_then(|i| amplitudes.get(i)) else { return false };
        let first = self.value * amplitude.value(0.0);
        (first - self.start).abs() > SAME * f64::max(first.abs(), self.start.abs())
    }
}

/// Inextensible director: a nodal vector of constant length.
#[derive(Debug, Clone, PartialEq)]
pub struct UnitVector {
    /// Nodal vector.
    pub vector: u32,
    /// Direction along which the director is supported, if there is one.
    pub fixed: Option<Vec3>,
    /// Component along `fixed` to which the director is constrained; `None`: that of the reference.
    pub held: Option<f64>,
}

impl UnitVector {
    /// Local frame of the director at its present value `d`: two axes along which it may change (one, if it is
    /// supported), and the remaining ones.
    pub(super) fn axes(&self, d: &Vec3) -> Mat3 {
        let d = d.normalize();
        match self.fixed {
            None => {
                let [a, b] = crate::element::geometry::tangents(&d);
                Mat3::from_columns(&[a, b, d])
            }
            Some(fixed) => {
                let free = fixed.cross(&d).normalize();
                Mat3::from_columns(&[free, fixed, free.cross(&fixed)])
            }
        }
    }

    /// Projection onto the constraint: unit vector nearest to `d` (with the supported component of `reference`).
    pub fn project(&self, d: Vec3, reference: &Vec3) -> Vec3 {
        let Some(a) = self.fixed else { return d.normalize() };
        let along = self.held.unwrap_or_else(|| a.dot(reference));
        let across = d - a * a.dot(&d);
        a * along + across.normalize() * (1.0 - along * along).max(0.0).sqrt()
    }
}

impl DofMap {
    /// Numbers of the three degrees of freedom of a vector.
    pub fn of(&self, vector: usize) -> [u32; 3] {
        [self.free[3 * vector], self.free[3 * vector + 1], self.free[3 * vector + 2]]
    }

    /// True if a vector is a director of a rigid body.
    #[inline]
    pub fn in_triad(&self, vector: usize) -> bool {
        self.triad_of(vector).is_some()
    }

    /// Rigid body that a vector is a director of, by the number of its directors.
    #[inline]
    pub fn triad_of(&self, vector: usize) -> Option<usize> {
        let after = self.triads.partition_point(|triad| triad[0] as usize <= vector);
        let triad = after.checked_sub(1)?;
        self.triads[triad].contains(&(vector as u32)).then_some(triad)
    }

    /// True if a vector has at least one free degree of freedom.
    pub fn is_free(&self, vector: usize) -> bool {
        self.of(vector).iter().any(|&n| n != CONSTRAINED)
    }
}
