//! Model files and meshes in, results and plots out.

pub mod abaqus;
mod conversion;
pub mod deck;
pub mod export;
pub mod job;
pub mod memory;
pub mod mesh;
pub mod nastran;
pub mod out;
pub mod plot;
pub mod render;
pub mod report;
pub mod watch;

#[cfg(test)]
mod solved;
