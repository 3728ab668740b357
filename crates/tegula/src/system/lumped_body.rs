//! Rigid bodies in explicit steps: inertia with that of the lumped masses that are attached to them.

use super::connection_frequency::is_connection;
use super::dof_map::DofMap;
use super::element_frequency::{MassShares, row_sums};
use super::rigid_patch::Attached;
use super::{System, VectorKind};
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

    /// Indices of bodies, and the largest ratio, over all axes, of the moment of inertia with the lumped masses to the one with the consistent mass
    /// of the elements whose vectors all are attached to the body: row sums move the mass of an element to its nodes.
    pub fn raised_moments(system: &System) -> Vec<(usize, f64)> {
        if system.dofs().attached.is_empty() {
            return Vec::new();
        }
        let shares = MassShares::new(system);
        let mut mass = vec![0.0; system.vectors()];
        system.pattern.for_each_mass(|i, j, m| {
            if i == j {
                mass[i] = m;
            }
        });
        let bodies = Self::all(system, &mass);
        // Excess of the Euler tensors of the lumped masses. The masses and their first moments are those of the consistent mass.
        let mut excess = vec![Mat3::zeros(); bodies.len()];
        for group in system.groups.iter().filter(|group| !is_connection(group.as_ref())) {
            for e in 0..group.len() {
                let vectors = group.vectors(e);
                let on: Vec<Attached> =
                    vectors.iter().filter_map(|v| system.dofs().carried(*v as usize)).collect();
                let Some(first) = on.first().filter(|_| on.len() == vectors.len()) else { continue };
                if on.iter().any(|other| other.triad != first.triad) || group.mass(e).is_empty() {
                    continue;
                }
                let excess = &mut excess[first.triad as usize];
                let own = row_sums(&system.coordinates.kinds, vectors, group.mass(e));
                for (a, m) in on.iter().zip(own) {
                    let v = a.vector as usize;
                    // The inertia of directors may be raised.
                    let is_director = system.coordinates.kinds[v] == VectorKind::Director;
                    let raise = if is_director && m > 0.0 { mass[v] / shares.own(v) } else { 1.0 };
                    *excess += a.coordinates * a.coordinates.transpose() * (raise * m);
                }
                let mut masses = group.mass(e).iter();
                for (a, b) in on.iter().enumerate().flat_map(|(i, a)| on[..=i].iter().map(move |b| (a, b))) {
                    let product = a.coordinates * b.coordinates.transpose() * *masses.next().unwrap_or(&0.0);
                    *excess -= if a.vector == b.vector { product } else { product + product.transpose() };
                }
            }
        }
        let ratio = |(body, excess): (&Self, &Mat3)| {
            let inertia = body.inertia(&Mat3::identity());
            let exact = inertia - (Mat3::identity() * excess.trace() - excess);
            // Largest eigenvalue of J x = r J_exact x.
            let root = exact.cholesky()?.l();
            let inverse = root.try_inverse()?;
            Some((body.body, (inverse * inertia * inverse.transpose()).symmetric_eigenvalues().max()))
        };
        bodies.iter().zip(&excess).filter_map(ratio).collect()
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
