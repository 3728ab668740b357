//! Elements: sampled strains that are quadratic forms of nodal vectors.

pub mod ems;
pub mod fold_tie;
pub mod geometry;
pub mod group;
pub mod scalar;
pub mod strains;

pub use group::{ElementGroup, Kinematics, Motion, Nodal, QuadraticGroup, TangentRequest, TangentWeights};
