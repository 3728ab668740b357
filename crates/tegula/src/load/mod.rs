//! Loads: functions of time, constant nodal forces, forces that follow the motion.

pub mod amplitude;
pub mod follower;
mod formula;

pub use amplitude::TimeFunction;
pub use follower::FollowerLoad;
