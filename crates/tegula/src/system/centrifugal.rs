//! Centrifugal forces of a model and their stiffness.

use super::assembly::TangentCoefficients;
use super::evaluation_point::current_vector;
use super::{LocalFrames, System, VectorKind};
use crate::element::{Motion, Nodal};
use crate::load::CentrifugalLoad;
use crate::norm::max_norm;

impl System {
    /// Adds `factor` times the centrifugal forces at a motion.
    pub fn add_centrifugal(&self, motion: &Motion, time: f64, factor: f64, out: &mut [Nodal]) {
        for load in &self.centrifugal {
            self.add_centrifugal_load(load, (motion, time), factor, out);
        }
    }

    /// Adds `factor` times the centrifugal forces of one load at a motion.
    pub fn add_centrifugal_load(
        &self,
        load: &CentrifugalLoad,
        (motion, time): (&Motion, f64),
        factor: f64,
        out: &mut [Nodal],
    ) {
        let size = factor * self.factor(&load.factor, time) * load.velocity.powi(2);
        let across = load.across();
        let arm = |v: usize| match self.coordinates.kinds[v] {
            VectorKind::Position => current_vector(self, motion, v) - load.at,
            _ => current_vector(self, motion, v),
        };
        let field: Vec<Nodal> = (0..self.vectors()).map(|v| (across * arm(v)).into()).collect();
        self.pattern.add_mass_product(size, &field, out);
    }

    /// Adds the change of the centrifugal forces in an increment, with the weights of a tangent.
    pub fn add_centrifugal_stiffness(
        &self,
        parts: &TangentCoefficients,
        increment: &[Nodal],
        out: &mut [Nodal],
    ) {
        for load in &self.centrifugal {
            let size = self.softening(load, parts);
            let across = load.across();
            let field: Vec<Nodal> =
                increment.iter().map(|x| (across * crate::Vec3::from(*x)).into()).collect();
            self.pattern.add_mass_product(size, &field, out);
        }
    }

    /// Adds the stiffness `−Ω² M P` of the centrifugal forces, which softens the model, to the values of a tangent.
    pub(super) fn add_centrifugal_tangent(
        &self,
        parts: &TangentCoefficients,
        frames: &LocalFrames,
        values: &mut [f64],
    ) {
        for load in &self.centrifugal {
            let size = self.softening(load, parts);
            if size != 0.0 {
                self.pattern.add_mass_along(&(load.across() * -size), frames, values);
            }
        }
    }

    /// Factor Ω² of the stiffness in a tangent.
    fn softening(&self, load: &CentrifugalLoad, parts: &TangentCoefficients) -> f64 {
        let direction = parts.weights.force * parts.weights.direction;
        direction * self.factor(&load.factor, parts.time) * load.velocity.powi(2)
    }
}

impl System {
    /// Size of the forces that act on the model at a time (force): the sum of the largest force of each dead load, and of centrifugal forces
    /// of all mass at the point that is farthest from the axis. Of forces that cancel each other about the machine precision times this size is left.
    pub fn size_of_loads(&self, time: f64) -> f64 {
        let dead = self.dead_loads.iter().map(|load| {
            self.factor(&load.factor, time).abs() * max_norm(load.force.as_flattened().iter().copied())
        });
        let farthest = max_norm(self.coordinates.reference.as_flattened().iter().copied());
        let centrifugal = self.centrifugal.iter().map(|load| {
            let arm = farthest + load.at.norm();
            self.factor(&load.factor, time).abs() * load.velocity.powi(2) * self.total_mass() * arm
        });
        dead.chain(centrifugal).sum()
    }
}
