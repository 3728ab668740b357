//! Volume integrals of a solid from its surface.
//!
//! A closed surface is the sum of the tetrahedra between the origin and its triangles, with the sign of their orientation. A
//! tetrahedron with the corners 0, a, b, c has the volume V = a·(b×c)/6 and, with s = a + b + c,
//!
//! ```text
//! ∫ x dV = V/4 s,    ∫ x xᵀ dV = V/20 (s sᵀ + a aᵀ + b bᵀ + c cᵀ).
//! ```
//!
//! F. Tonon, *Explicit exact formulas for the 3-D tetrahedron inertia tensor in terms of its vertex coordinates*, Journal of
//! Mathematics and Statistics 1 (2004) 8–11; B. Mirtich, *Fast and accurate computation of polyhedral mass properties*, Journal of
//! Graphics Tools 1 (1996) 31–50, finds the same integrals by the divergence theorem.

use crate::{Mat3, Vec3};

/// Integrals of a solid over its volume.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct VolumeIntegrals {
    /// Volume (length³); below 0 where the surface is oriented inwards.
    pub(super) volume: f64,
    /// First moments ∫x dV (length⁴).
    pub(super) first: Vec3,
    /// Second moments ∫x xᵀ dV (length⁵).
    pub(super) second: Mat3,
    /// Area of the surface (length²).
    pub(super) area: f64,
}

impl VolumeIntegrals {
    /// Integrals of the solid within triangles, about the origin of the points.
    pub(super) fn of<'a>(points: &[Vec3], triangles: impl Iterator<Item = &'a [u32; 3]>) -> Self {
        let mut out = Self::default();
        for triangle in triangles {
            let [a, b, c] = triangle.map(|corner| points[corner as usize]);
            let volume = a.dot(&b.cross(&c)) / 6.0;
            let s = a + b + c;
            let squares = [s, a, b, c].map(|x| x * x.transpose()).iter().sum::<Mat3>();
            out.volume += volume;
            out.first += s * (0.25 * volume);
            out.second += squares * (0.05 * volume);
            out.area += 0.5 * (b - a).cross(&(c - a)).norm();
        }
        out
    }

    /// Centre of the volume (length).
    pub(super) fn centre(&self) -> Vec3 {
        self.first / self.volume
    }
}
