//! Elements, sections and materials: contracts, patch tests, invariance, stiffness and stress recovery.
//!
//! One binary of many modules: each binary of its own would be compiled and linked with the whole library.
#![allow(clippy::unwrap_used)]

#[path = "../common/mod.rs"]
mod common;

mod congruence;
mod convergence;
mod curved_heat;
mod element_contract;
mod family_materials;
mod folds;
mod free_edges;
mod geometry;
mod harness;
mod kernel;
mod material;
mod material_keys;
mod membrane;
mod offset;
mod patch;
mod plies;
mod totals;
mod units;
