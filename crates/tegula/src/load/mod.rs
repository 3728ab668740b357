//! Loads: functions of time, constant nodal forces, forces that follow the motion.

pub mod amplitude;
mod breaks;
pub mod follower;
mod formula;

pub use amplitude::TimeFunction;
pub use follower::FollowerLoad;
pub use formula::Formula;
