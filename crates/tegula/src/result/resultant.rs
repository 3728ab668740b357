//! Force and moment of generalised nodal forces.

use crate::Vec3;
use crate::element::Nodal;
use crate::system::{System, VectorKind};

/// Force and moment about a point.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Resultant {
    /// Force.
    pub force: Vec3,
    /// Moment about the point of the set, [`ForceSet::about`](crate::system::ForceSet::about); for sums about the
    /// origin.
    pub moment: Vec3,
}

/// Nodal vector on which forces act (arm of their moment): the reference one in linear models.
pub(super) fn arm(system: &System, u: &[Nodal], v: usize) -> Vec3 {
    let reference = Vec3::from(system.coordinates.reference[v]);
    if system.linear { reference } else { reference + Vec3::from(u[v]) }
}

/// Adds the force on a nodal vector, and its moment about a point.
pub(super) fn add_to(
    total: &mut Resultant,
    system: &System,
    (u, v): (&[Nodal], usize),
    force: &Vec3,
    about: &Vec3,
) {
    let mut x = arm(system, u, v);
    if system.coordinates.kinds[v] == VectorKind::Position {
        total.force += force;
        x -= about;
    }
    total.moment += x.cross(force);
}

/// Force and moment about a point of generalised forces.
pub(super) fn resultant(system: &System, u: &[Nodal], forces: &[Nodal], about: &Vec3) -> Resultant {
    let mut out = Resultant::default();
    for (v, f) in forces.iter().enumerate().filter(|(_, f)| **f != [0.0; 3]) {
        add_to(&mut out, system, (u, v), &Vec3::from(*f), about);
    }
    out
}
