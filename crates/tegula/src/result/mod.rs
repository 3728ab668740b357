//! Recovery of engineering quantities from a state: resultants and stresses of shells, motion of points and bodies, reactions.

pub mod beams;
pub mod bodies;
pub mod cuts;
pub mod inside;
pub mod joints;
pub mod plies;
pub mod probe;
pub mod reactions;
pub mod recovery;
pub mod resultant;
pub mod sensors;

pub use bodies::BodyMotion;
pub use cuts::CutResultant;
pub use joints::{JointResponse, joint_drift, joint_reaction};
pub use plies::{PlyFailure, PlyResult, PlyStress, plastic_strains, recover_plies};
pub use probe::Probe;
pub use reactions::{Equilibrium, ReactionFinder};
pub use recovery::{ShellResult, recover};
pub use resultant::Resultant;
pub use sensors::{sensor_columns, sensor_values};
