//! Analyses: statics, stability, modes, time integration, linear solvers, loads and reactions.
//!
//! One binary of many modules: each binary of its own would be compiled and linked with the whole library.
#![allow(clippy::unwrap_used)]

#[path = "../common/mod.rs"]
mod common;

mod assembly;
mod bdf2;
mod beams;
mod buckling;
mod buckling_machines;
mod buckling_materials;
mod bushing_elements;
mod bushings;
mod clearance;
mod composition;
mod contracts;
mod couplings;
mod critical_points;
mod curves;
mod cuts;
mod drives;
mod dynamics;
mod equilibrium;
mod explicit;
mod explicit_joints;
mod explicit_models;
mod family_dynamics;
mod follower;
mod foundations;
mod frequency_response;
mod friction_in_mechanisms;
mod gears;
mod generalized_alpha;
mod guided_axes;
mod imperfections;
mod inertia_relief;
mod inner_points;
mod integrators;
mod iterative_statics;
mod joint_friction;
mod joint_reactions;
mod joint_snaps;
mod joint_stops;
mod kinematics;
mod lagged_tangent;
mod linear_solvers;
mod load_paths;
mod loads_in_time;
mod long_rotations;
mod modes;
mod modes_with_joints;
mod multibody;
mod nonlinear_materials;
mod outlines;
mod patch_refusals;
mod patches;
mod paths;
mod racks;
mod reactions;
mod screws;
mod sensors;
mod sheet_to_membrane;
mod shell_joints;
mod spinning;
mod spring_formulas;
mod statics;
mod step_joint_lists;
mod step_joint_modes;
mod step_joints;
mod steps;
mod steps_with_bodies;
mod surfaces;
mod ties;
mod torsion_springs;
