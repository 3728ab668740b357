//! Constitutive laws at a material point: stress and tangent as pure functions of strain and history variables.
//!
//! Strains are Green–Lagrange strains, stresses second Piola–Kirchhoff stresses, in an orthonormal frame of the
//! reference configuration; components are ordered xx, yy, xy, zz, xz, yz with engineering shear strains. The caller
//! passes history variables in and receives the updated ones; nothing is stored here.

mod from_model;
pub mod hyperelastic;
pub mod linear;
pub mod plane_stress;
pub mod plasticity;

use std::fmt::Debug;
use std::sync::Arc;

use nalgebra::{Matrix3, Matrix6, Vector6};

pub use crate::model::NeoHookeanForm;
pub use hyperelastic::Hyperelastic;
pub use plasticity::Plasticity;

/// Strain xx, yy, 2xy, zz, 2xz, 2yz.
pub type Strain = Vector6<f64>;
/// Stress xx, yy, xy, zz, xz, yz [force/area].
pub type Stress = Vector6<f64>;

/// Tensor indices (row, column) of the six components.
pub(crate) const PAIRS: [(usize, usize); 6] = [(0, 0), (1, 1), (0, 1), (2, 2), (0, 2), (1, 2)];

/// Response of a material: stress, tangent and energies.
#[derive(Debug, Clone, PartialEq)]
pub struct Response {
    /// Second Piola–Kirchhoff stress S.
    pub stress: Stress,
    /// Consistent tangent ∂S/∂E, symmetric.
    pub tangent: Matrix6<f64>,
    /// Stored energy per reference volume.
    pub energy: f64,
    /// Energy dissipated per reference volume since the committed state.
    pub dissipation: f64,
}

/// Law of a caller: stress, tangent and energy of a three-dimensional strain as a pure function of strain and history
/// variables. It takes the place of the law of a material of the model
/// ([`Compiler::with_laws`](crate::compile::Compiler::with_laws)).
pub trait MaterialLaw: Debug + Send + Sync {
    /// Number of internal (history) variables, at most 16; all are 0 at the start.
    fn history(&self) -> usize {
        0
    }
    /// Stress, consistent (symmetric) tangent and energies for a strain; `updated` receives the internal variables that
    /// belong to it. `None` where the law cannot be evaluated: the step is then cut back. A zero strain without history
    /// has no stress.
    fn respond(&self, strain: &Strain, committed: &[f64], updated: &mut [f64]) -> Option<Response>;
}

/// Shared law of a caller; two are equal if they are the same object.
#[derive(Debug, Clone)]
pub struct OwnLaw(pub Arc<dyn MaterialLaw>);

impl PartialEq for OwnLaw {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

/// Material law.
#[derive(Debug, Clone, PartialEq)]
pub enum Law {
    /// Linear elastic (St. Venant–Kirchhoff): `S = C E`.
    Linear(Box<Matrix6<f64>>),
    /// Isotropic hyperelastic.
    Hyperelastic(Hyperelastic),
    /// Von Mises (J2) plasticity.
    Plastic(Plasticity),
    /// Von Mises plasticity under plane stress: only xx, yy and xy yield; zz and transverse shear are linear and
    /// uncoupled.
    PlaneStressPlastic(Plasticity),
    /// Law of a caller.
    Own(OwnLaw),
}

impl Law {
    /// Number of internal (history) variables.
    pub fn history(&self) -> usize {
        match self {
            Self::Linear(_) | Self::Hyperelastic(_) => 0,
            Self::Plastic(_) | Self::PlaneStressPlastic(_) => plasticity::HISTORY,
            Self::Own(law) => law.0.history(),
        }
    }

    /// True for `S = C E`.
    pub fn is_linear(&self) -> bool {
        matches!(self, Self::Linear(_))
    }

    /// Stress, tangent and energies for a strain; `updated` receives the internal variables that belong to it. `None`
    /// where the law cannot be evaluated: `C = 1 + 2E` is not positive definite, or the return mapping does not
    /// converge.
    pub fn respond(&self, strain: &Strain, committed: &[f64], updated: &mut [f64]) -> Option<Response> {
        match self {
            Self::Linear(c) => {
                let stress = **c * strain;
                let energy = 0.5 * stress.dot(strain);
                Some(Response { stress, tangent: **c, energy, dissipation: 0.0 })
            }
            Self::Hyperelastic(law) => law.respond(strain),
            Self::Plastic(law) => law.respond(strain, committed, updated),
            Self::PlaneStressPlastic(law) => plane_stress::respond(law, strain, committed, updated),
            Self::Own(law) => law.0.respond(strain, committed, updated),
        }
    }

    /// Equivalent plastic strain among the internal variables, for laws that have one.
    pub fn plastic_strain(&self, history: &[f64]) -> Option<f64> {
        match self {
            Self::Linear(_) | Self::Hyperelastic(_) | Self::Own(_) => None,
            Self::Plastic(_) | Self::PlaneStressPlastic(_) => history.get(plasticity::EQUIVALENT).copied(),
        }
    }
}

/// Symmetric tensor from stress-like components (no factor 2 on shears).
pub(crate) fn tensor(v: &Vector6<f64>) -> Matrix3<f64> {
    Matrix3::new(v[0], v[2], v[4], v[2], v[1], v[5], v[4], v[5], v[3])
}

/// Stress-like components of a symmetric tensor.
pub(crate) fn components(m: &Matrix3<f64>) -> Vector6<f64> {
    Vector6::from_fn(|i, _| m[PAIRS[i]])
}
