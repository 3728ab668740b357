//! Model files and meshes in, results and plots out.

pub mod abaqus;
pub mod deck;
pub mod job;
pub mod memory;
pub mod mesh;
pub mod out;
pub mod plot;
