//! Rigid bodies in explicit steps: inertia with that of the lumped masses that are attached to them.

use super::System;
use super::dof_map::DofMap;
use crate::element::Nodal;
use crate::{Mat3, Vec3};

/// Moment of inertia over the largest one below which a body has none: a thin rod about its axis.
const NO_INERTIA: f64 = 1e-9;

/// Inertia of a rigid body with the lumped masses of the nodal vectors that are attached to it, about the mass centre of both.
#[derive(Debug, Clone, PartialEq)]
pub struct LumpedBody {
    /// Index of the body among those of the coordinates.
    pub body: usize,
    /// Nodal vector of the position of the body.
    pub centre: u32,
    /// Nodal vectors of the directors of the body.
    pub directors: [u32; 3],
    /// Mass.
    pub mass: f64,
    /// Coordinates of the mass centre of both from the position of the body, along its axes.
    pub offset: Vec3,
    /// Euler tensor about this mass centre, along the axes of the body.
    pub euler: Mat3,
}

impl LumpedBody {
    /// Rigid bodies of a system, in the order of their directors, where the nodal vectors have the lumped masses `mass`.
    pub fn all(system: &System, mass: &[f64]) -> Vec<Self> {
        Self::parts(system, mass, |_| 1.0, |_| 1.0)
    }

    /// Parts of rigid bodies: the parts `own` of their own inertia, by their number, and the parts `share` of the lumped masses of attached
    /// vectors.
    pub(super) fn parts(
        system: &System,
        mass: &[f64],
        own: impl Fn(usize) -> f64,
        share: impl Fn(usize) -> f64,
    ) -> Vec<Self> {
        let dofs: &DofMap = system.dofs();
        let bodies = system.coordinates.bodies.iter().enumerate();
        let mut out: Vec<Self> = bodies
            .filter_map(|(body, data)| Some((body, data, data.directors?)))
            .enumerate()
            .map(|(number, (body, data, directors))| {
                let (mass, euler) = (own(number) * data.mass, data.euler * own(number));
                Self { body, centre: data.centre, directors, mass, offset: Vec3::zeros(), euler }
            })
            .collect();
        // First the moments about the position of the body.
        for attached in &dofs.attached {
            let v = attached.vector as usize;
            let (m, x) = (share(v) * mass[v], attached.coordinates);
            let body = &mut out[attached.triad as usize];
            if attached.centre.is_some() {
                body.mass += m;
                body.offset += x * m;
            }
            body.euler += x * x.transpose() * m;
        }
        for body in &mut out {
            if body.mass > 0.0 {
                body.offset /= body.mass;
            }
            body.euler -= body.offset * body.offset.transpose() * body.mass;
        }
        out
    }

    /// Inertia tensor about the mass centre where the directors of the body are the columns of `axes`.
    pub fn inertia(&self, axes: &Mat3) -> Mat3 {
        Mat3::identity() * self.euler.trace() - axes * self.euler * axes.transpose()
    }

    /// Whether the body has a mass, and a moment of inertia about every axis.
    pub fn resists_all_motions(&self) -> bool {
        let moments = self.inertia(&Mat3::identity()).symmetric_eigenvalues();
        self.mass > 0.0 && moments.min() > NO_INERTIA * moments.max()
    }

    /// Directors of the body, as columns, at displacements `u`.
    pub fn axes(&self, system: &System, u: &[Nodal]) -> Mat3 {
        Mat3::from_columns(&self.directors.map(|v| {
            let v = v as usize;
            Vec3::from(system.coordinates.reference[v]) + Vec3::from(u[v])
        }))
    }
}
