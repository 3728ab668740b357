//! Elements: sampled strains that are quadratic forms of nodal vectors.

pub mod ancf_full;
pub mod bilinear;
mod bilinear_kernel;
pub mod cm;
pub mod director_angle;
pub mod ems;
pub mod forms;
pub mod generalized_law;
pub mod geometry;
pub mod group;
mod lanes;
pub mod membrane;
pub mod mitc4;
pub mod points;
pub mod quadratic;
pub mod registry;
pub mod scalar;
mod section_points;
pub mod shell;
pub mod solid_shell;
pub mod strains;
pub mod transform;

pub use geometry::ShellGeometry;
pub use group::{ElementGroup, GroupPoint, InternalVariables, Motion, Nodal, TangentRequest, TangentWeights};
pub use quadratic::QuadraticGroup;
pub use shell::ShellElement;

/// Kind of a nodal vector.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum VectorKind {
    /// Position of a node.
    Position,
    /// Director of a node (one of them, where sheets meet at an angle).
    Director,
    /// Gradient of the position along a tangent of the mid-surface.
    Gradient,
}
