//! Loads: amplitudes, constant nodal forces, follower loads.

pub mod amplitude;
mod breaks;
mod centrifugal;
pub mod factor;
pub mod follower;
mod formula;
mod own;
mod signal;
mod spline;

pub use crate::model::NodalLoad;
pub use amplitude::TimeFunction;
pub use centrifugal::CentrifugalLoad;
pub use factor::{LoadFactor, LoadParameter};
pub use follower::FollowerLoad;
pub use formula::{ForceFormula, Formula, Partials, PlaceCondition, PlaceFormula};
pub use own::OwnLoad;
pub use signal::Signal;
pub use spline::Spline;
