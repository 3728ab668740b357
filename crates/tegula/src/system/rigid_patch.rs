//! Rigid patches: nodal vectors of a mesh that are fixed in a rigid body.
//!
//! With the position r and the directors d₁ d₂ d₃ of the body, a position and a director, or a gradient vector, of a node
//! that is attached to it are
//!
//! ```text
//! r_a = r + X_i d_i,   d_a = Y_i d_i,
//! ```
//!
//! with constant coordinates X and Y along the axes of the body. They have no degrees of freedom of their own: displacements,
//! velocities and accelerations of attached vectors are the same linear function of those of the body, for rotations of any
//! size. Virtual displacements are `δr_a = δr + δθ × (r_a − r)` and `δd_a = δθ × d_a`.

use crate::Vec3;
use crate::element::Nodal;

/// A nodal vector that is fixed in a rigid body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Attached {
    /// Nodal vector.
    pub vector: u32,
    /// Rigid body, by the number of its directors among [`triads`](super::DofMap::triads).
    pub triad: u32,
    /// Position of the body, if the vector is a position: it moves with it.
    pub centre: Option<u32>,
    /// Coordinates along the directors of the body: of a position from the mass centre \[length\].
    pub coordinates: Vec3,
}

impl Attached {
    /// Value in a field of which the body has these directors.
    fn value(&self, directors: &[u32; 3], field: &[Nodal]) -> Nodal {
        let mut out = self.centre.map_or([0.0; 3], |centre| field[centre as usize]);
        for (d, x) in directors.iter().zip(self.coordinates.iter()) {
            (0..3).for_each(|i| out[i] += x * field[*d as usize][i]);
        }
        out
    }

    /// Nodal vectors of the body with the factors of their sum.
    pub(super) fn parts(&self, directors: &[u32; 3]) -> [Option<(u32, f64)>; 4] {
        let [x, y, z] = self.coordinates.into();
        let [a, b, c] = *directors;
        [self.centre.map(|centre| (centre, 1.0)), Some((a, x)), Some((b, y)), Some((c, z))]
    }
}

impl super::DofMap {
    /// Attachment of a nodal vector to a rigid body.
    #[inline]
    pub fn attachment(&self, vector: usize) -> Option<&Attached> {
        let at = self.attached.binary_search_by_key(&(vector as u32), |attached| attached.vector).ok()?;
        Some(&self.attached[at])
    }

    /// How a rigid body moves a nodal vector that is fixed in it: one that is attached to it, or one of its own directors, which
    /// has a unit vector as coordinates.
    #[inline]
    pub fn carried(&self, vector: usize) -> Option<Attached> {
        let director = || {
            let triad = self.triad_of(vector)?;
            let place = self.triads[triad].iter().position(|d| *d as usize == vector)?;
            let coordinates = Vec3::ith(place, 1.0);
            Some(Attached { vector: vector as u32, triad: triad as u32, centre: None, coordinates })
        };
        self.attachment(vector).copied().or_else(director)
    }

    /// Whether a rigid body moves a vector: one of its directors, or a vector attached to it.
    #[inline]
    pub fn is_carried(&self, vector: usize) -> bool {
        self.in_triad(vector) || self.attachment(vector).is_some()
    }

    /// Clears the forces on rigid bodies and on the vectors attached to them: they are in balance as a whole, not one by one.
    pub fn clear_bodies(&self, field: &mut [Nodal]) {
        let centres = self.attached.iter().filter_map(|attached| attached.centre);
        let carried = self.attached.iter().map(|attached| attached.vector).chain(centres);
        for v in carried.chain(self.triads.as_flattened().iter().copied()) {
            field[v as usize] = [0.0; 3];
        }
    }

    /// Sets the vectors attached to rigid bodies in a field of displacements, velocities, accelerations or increments from
    /// those of the bodies.
    pub fn carry(&self, field: &mut [Nodal]) {
        for attached in &self.attached {
            field[attached.vector as usize] = attached.value(&self.triads[attached.triad as usize], field);
        }
    }
}
