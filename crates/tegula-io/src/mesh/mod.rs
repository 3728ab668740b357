//! Readers of mesh files of other programs, which give a [`tegula::Mesh`].

pub mod gmsh;

use std::fmt;
use std::path::PathBuf;

use tegula::Issue;

/// Where in a mesh file an error sits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum At {
    /// The file as a whole.
    File,
    /// A line of a text file, counted from 1.
    Line(usize),
    /// An offset in a binary file, counted from 0.
    Byte(usize),
}

impl fmt::Display for At {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File => Ok(()),
            Self::Line(line) => write!(f, ":{line}"),
            Self::Byte(byte) => write!(f, ": byte {byte}"),
        }
    }
}

/// A mesh file that cannot be used: where, why, and what to do about it.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{}{at}: {message}\n  help: {help}", file.display())]
pub struct MeshError {
    /// The mesh file.
    pub file: PathBuf,
    /// Place in it.
    pub at: At,
    /// Mistake, in one sentence.
    pub message: String,
    /// Remedy.
    pub help: String,
}

impl MeshError {
    /// The error as an issue of the model file, at the key that names the mesh file.
    pub fn issue(&self) -> Issue {
        Issue::new(
            "mesh.file",
            format!("{}{}: {}", self.file.display(), self.at, self.message),
            self.help.clone(),
        )
    }
}
