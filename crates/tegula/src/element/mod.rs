//! Elements: sampled strains that are quadratic forms of nodal vectors.

pub mod beam;
pub mod bilinear;
mod bilinear_kernel;
mod bilinear_series;
mod chunks;
mod collected_law;
pub mod curved_strain;
pub mod director_angle;
mod enhanced_newton;
pub mod forms;
pub mod generalized_law;
pub mod geometry;
pub mod group;
mod lanes;
pub mod membrane;
pub mod points;
pub mod power_series;
pub mod quadratic;
mod quadratic_series;
pub mod registry;
pub mod scalar;
mod section_points;
pub mod shell;
pub mod strains;
pub mod transform;

use crate::model::element_types;

/// Declares the files of the element types.
macro_rules! modules {
    ($($file:ident::$type:ident as $kind:ident: $help:literal,)*) => {
        $(pub mod $file;)*
    };
}
element_types!(modules);

pub use geometry::ShellGeometry;
pub use group::{
    ElementGroup, GroupPoint, InternalVariables, Motion, Nodal, StressIncrement, TangentRequest,
    TangentWeights, energy_of_blocks, forces_of_blocks,
};
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
