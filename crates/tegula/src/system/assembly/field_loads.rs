//! Loads that are evaluated for all their nodes together: their forces and their stiffness in a motion.

use super::TangentCoefficients;
use crate::element::{Motion, Nodal};
use crate::load::{FollowerLoad, LoadOnNodes};
use crate::system::System;
use crate::system::evaluation_point::current_vector;
use crate::{Mat3, Vec3};

/// Stiffness of the nodes of all field loads in a motion, by the number of the follower load; empty: there are none.
#[derive(Debug, Default)]
pub struct FieldStiffness(Vec<Mat3>);

impl FieldStiffness {
    /// Evaluates the loads with the coefficients of a tangent: blocks −∂f/∂x with the weights of the directions and rates, times the factor of the load and the weight of the forces.
    pub fn of(system: &System, motion: &Motion, parts: &TangentCoefficients) -> Self {
        let mut found = Vec::new();
        if system.linear {
            return Self(found);
        }
        for (load, factor, first) in system.field_loads() {
            let weights = [parts.weights.direction, parts.weights.rate];
            let scale = parts.weights.force * system.factor(factor, parts.time);
            let blocks =
                load.stiffness(parts.time, system.motion_of_load(motion, load), system.length, weights);
            found.resize(system.followers.len(), Mat3::zeros());
            found.iter_mut().skip(first).zip(blocks).for_each(|(out, block)| *out = block * scale);
        }
        Self(found)
    }

    /// Block of a follower load; `None`: it is no node of a field load.
    pub fn block(&self, system: &System, follower: usize) -> Option<Mat3> {
        matches!(system.followers.get(follower)?, FollowerLoad::Field { .. })
            .then(|| self.0.get(follower).copied().unwrap_or_else(Mat3::zeros))
    }
}

impl System {
    /// Loads that are evaluated for all their nodes together, with their factors and the number of their first follower load.
    pub fn field_loads(&self) -> impl Iterator<Item = (&LoadOnNodes, &crate::load::LoadFactor, usize)> {
        self.followers.iter().enumerate().filter_map(|(number, load)| match load {
            FollowerLoad::Field { load, place: 0, factor } => Some((load.as_ref(), factor, number)),
            _ => None,
        })
    }

    /// Positions and velocities of the nodes of a load.
    pub fn motion_of_load(&self, motion: &Motion, load: &LoadOnNodes) -> [Vec<Vec3>; 2] {
        let velocity = |v: usize| match motion {
            Motion::State { velocity, .. } => velocity.map_or_else(Vec3::zeros, |rates| Vec3::from(rates[v])),
            Motion::Step { old, new, dt } => (Vec3::from(new[v]) - Vec3::from(old[v])) / *dt,
        };
        let vectors = || load.vectors().iter().map(|&v| v as usize);
        [vectors().map(|v| current_vector(self, motion, v)).collect(), vectors().map(velocity).collect()]
    }

    /// Forgets the last evaluation of loads that are evaluated for all their nodes together: what they depend on besides their arguments may have changed.
    pub fn forget_field_loads(&self) {
        self.field_loads().for_each(|(load, ..)| load.forget());
    }

    /// Adds the forces of the field loads of the load sets that `takes` chooses, at a motion and a time, times `factor`.
    pub fn add_field_loads(
        &self,
        motion: &Motion,
        (time, factor): (f64, f64),
        takes: impl Fn(usize) -> bool,
        out: &mut [Nodal],
    ) {
        for (load, of_load, _) in self.field_loads().filter(|(.., n)| takes(self.load_of_follower[*n])) {
            let factor = factor * self.factor(of_load, time);
            let forces = load.forces(time, self.motion_of_load(motion, load), self.length);
            for (&v, f) in load.vectors().iter().zip(forces) {
                (0..3).for_each(|i| out[v as usize][i] += factor * f[i]);
            }
        }
    }
}
