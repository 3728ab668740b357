//! Inertia relief: inertia forces of a rigid acceleration that balance the loads of a model without supports.
//!
//! With the rigid motions R (translations, rotations about a point, restricted to those that the supports leave) the
//! acceleration of a free model under the loads F follows from
//!
//! ```text
//! Rᵀ M R a = Rᵀ F,
//! ```
//!
//! and the loads `F − M R a` have no resultant: the model deforms under them as it does in flight, at rest in the accelerated frame.
//! The angular velocity is zero. R belongs to the configuration at hand, so that force and moment vanish in the deformed one, too
//! (MSC Nastran Reference Guide, sect. *Inertia relief*, for the linear form).

use super::evaluation_point::current_vector;
use super::{System, VectorKind};
use crate::Vec3;
use crate::element::{Motion, Nodal};

/// Key of the analysis that asks for inertia relief, and of the supports that it adds.
pub const KEY: &str = "analysis.inertia_relief";

/// Rigid motions along which inertia forces balance the loads.
#[derive(Debug, Clone, PartialEq)]
pub struct InertiaRelief {
    /// Rigid motions that the supports leave, each of translation and rotation, orthonormal.
    pub motions: Vec<[Vec3; 2]>,
    /// Point about which rotations turn the model.
    pub about: Vec3,
    /// Index of the inertia forces among the loads of the model.
    pub load_set: usize,
}

/// Rigid acceleration of a model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RigidAcceleration {
    /// Acceleration of the centre of mass [length/time²].
    pub linear: Vec3,
    /// Angular acceleration [rad/time²].
    pub angular: Vec3,
    /// Centre of mass.
    pub centre: Vec3,
}

impl InertiaRelief {
    /// Field of a rigid motion over the nodal vectors of a configuration.
    fn field(&self, system: &System, motion: &Motion, [shift, turn]: &[Vec3; 2]) -> Vec<Nodal> {
        let of = |v: usize| -> Nodal {
            let x = current_vector(system, motion, v);
            match system.coordinates.kinds[v] {
                VectorKind::Position => (shift + turn.cross(&(x - self.about))).into(),
                _ => turn.cross(&x).into(),
            }
        };
        (0..system.vectors()).map(of).collect()
    }

    /// Mass matrix RᵀM R of the rigid motions in a configuration with these fields.
    fn mass(system: &System, fields: &[Vec<Nodal>]) -> nalgebra::DMatrix<f64> {
        let mut mass = nalgebra::DMatrix::zeros(fields.len(), fields.len());
        let mut product = vec![[0.0; 3]; system.vectors()];
        for (j, field) in fields.iter().enumerate() {
            product.fill([0.0; 3]);
            system.pattern.add_mass_product(1.0, field, &mut product);
            for (i, other) in fields.iter().enumerate() {
                mass[(i, j)] = super::dot(other, &product);
            }
        }
        mass
    }

    /// Mass matrix of the rigid motions where the step starts, whose rotations are over the size of the model.
    pub fn masses(&self, system: &System) -> nalgebra::DMatrix<f64> {
        let start = system.start.as_ref().map(|start| start.u.clone());
        let u = start.unwrap_or_else(|| vec![[0.0; 3]; system.vectors()]);
        let motion = Motion::State { u: &u, velocity: None };
        let fields: Vec<_> = self.motions.iter().map(|rigid| self.field(system, &motion, rigid)).collect();
        Self::mass(system, &fields)
    }

    /// Rigid acceleration under loads, as translation and rotation about [`about`](Self::about).
    fn acceleration(&self, system: &System, motion: &Motion, loads: &[Nodal]) -> [Vec3; 2] {
        let fields: Vec<_> = self.motions.iter().map(|rigid| self.field(system, motion, rigid)).collect();
        let mass = Self::mass(system, &fields);
        let resultant = nalgebra::DVector::from_fn(fields.len(), |i, _| super::dot(&fields[i], loads));
        // A model without mass along one of its motions has been refused.
        let shares = mass.cholesky().map_or(resultant.clone() * f64::NAN, |factor| factor.solve(&resultant));
        let mut out = [Vec3::zeros(); 2];
        for (share, rigid) in shares.iter().zip(&self.motions) {
            (0..2).for_each(|i| out[i] += rigid[i] * *share);
        }
        out
    }
}

impl System {
    /// Adds the inertia forces that balance all loads at a motion, times `factor`; none without inertia relief.
    pub fn add_inertia_relief(&self, motion: &Motion, time: f64, factor: f64, out: &mut [Nodal]) {
        let Some(relief) = &self.inertia_relief else { return };
        let acceleration = relief.acceleration(self, motion, &self.applied_loads(motion, time));
        self.pattern.add_mass_product(-factor, &relief.field(self, motion, &acceleration), out);
    }

    /// Acceleration with which a model with inertia relief moves under its loads in a configuration; `None` for other models.
    pub fn relief_acceleration(&self, u: &[Nodal], time: f64) -> Option<RigidAcceleration> {
        let relief = self.inertia_relief.as_ref()?;
        let motion = Motion::State { u, velocity: None };
        let [shift, angular] = relief.acceleration(self, &motion, &self.applied_loads(&motion, time));
        // The mass matrix acts on the three components of nodal vectors alike: eᵀM q over eᵀM e, with e = 1 for positions.
        let ones = relief.field(self, &motion, &[Vec3::repeat(1.0), Vec3::zeros()]);
        let mut masses = vec![[0.0; 3]; self.vectors()];
        self.pattern.add_mass_product(1.0, &ones, &mut masses);
        let (mut total, mut centre) = (0.0, Vec3::zeros());
        for (v, mass) in masses.iter().enumerate() {
            total += mass[0] * ones[v][0];
            centre += current_vector(self, &motion, v) * mass[0];
        }
        let centre = centre / total;
        Some(RigidAcceleration { linear: shift + angular.cross(&(centre - relief.about)), angular, centre })
    }

    /// Loads of the model at a motion, without inertia forces.
    fn applied_loads(&self, motion: &Motion, time: f64) -> Vec<Nodal> {
        let mut loads = vec![[0.0; 3]; self.vectors()];
        self.add_dead_loads(time, 1.0, &mut loads);
        super::assembly::add_applied_follower_loads(self, motion, time, 1.0, &mut loads);
        loads
    }
}
