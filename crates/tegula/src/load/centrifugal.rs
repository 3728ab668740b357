//! Centrifugal forces in a frame that turns with the model.
//!
//! With the generator A of the rotation, `A x = Ω n × x` for directors and `A x = Ω n × (x − x₀)` for positions, a relative equilibrium
//! satisfies `f(q) + M A² q = F`: the masses act with
//!
//! ```text
//! −M A² q = Ω² M P (q − q₀),   P = 1 − n nᵀ,
//! ```
//!
//! q₀ = x₀ for positions and 0 for directors, whose part is the centrifugal moment of the section.

use super::LoadFactor;
use crate::{Mat3, Vec3};

/// Rotation about a fixed axis at a constant angular velocity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CentrifugalLoad {
    /// Direction n of the axis, of length 1.
    pub axis: Vec3,
    /// Point x₀ of the axis (length).
    pub at: Vec3,
    /// Angular velocity Ω at factor 1 [rad/time].
    pub velocity: f64,
    /// Whether supports and the ground turn with the model.
    pub with_ground: bool,
    /// Factor of the forces over the analysis step.
    pub factor: LoadFactor,
}

impl CentrifugalLoad {
    /// Projection `P = 1 − n nᵀ` across the axis.
    pub fn across(&self) -> Mat3 {
        Mat3::identity() - self.axis * self.axis.transpose()
    }
}
