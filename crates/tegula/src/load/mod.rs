//! Loads: amplitudes, constant nodal forces, follower loads.

pub mod amplitude;
mod breaks;
mod centrifugal;
mod edge_couple;
pub mod factor;
mod field;
pub mod follower;
mod formula;
mod own;
mod signal;
mod spline;
mod turning_with_node;

pub use crate::model::NodalLoad;
pub use amplitude::TimeFunction;
pub use centrifugal::CentrifugalLoad;
pub use factor::{LoadFactor, LoadParameter};
pub use field::{
    Dependence, FieldLoad, LoadOnNodes, LoadPoint, WrongStiffness, node_of_wrong_stiffness,
    stiffness_by_differences,
};
pub use follower::FollowerLoad;
pub use formula::{ForceFormula, Formula, Partials, PlaceCondition, PlaceFormula};
pub use own::OwnLoad;
pub use signal::Signal;
pub use spline::Spline;
pub use turning_with_node::{ForceOnBody, ForceOnShell, MomentOnBody, MomentOnShell, SurfaceTriad};
