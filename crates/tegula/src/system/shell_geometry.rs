//! Geometry of shells in the reference configuration and at displacements.

use super::evaluation_point::current_vector;
use super::{Shell, System};
use crate::Vec3;
use crate::element::{Motion, Nodal, ShellGeometry};

impl System {
    /// Reference geometry of a shell.
    pub fn geometry(&self, shell: &Shell) -> ShellGeometry {
        self.geometry_of(shell, |v| Vec3::from(self.coordinates.reference[v]))
    }

    /// Geometry of a shell on which stresses act: at displacements, or in the reference configuration in a linear analysis.
    pub fn current_geometry(&self, shell: &Shell, u: &[Nodal]) -> ShellGeometry {
        self.geometry_of(shell, |v| current_vector(self, &Motion::State { u, velocity: None }, v))
    }

    fn geometry_of(&self, shell: &Shell, vector: impl Fn(usize) -> Vec3) -> ShellGeometry {
        let vectors = self.groups[shell.groups.start].vectors(shell.member);
        let at = |a: usize| vector(vectors[a] as usize);
        ShellGeometry::new(std::array::from_fn(at), std::array::from_fn(|a| at(4 + a)))
    }
}
