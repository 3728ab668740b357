//! Readers of mesh files of other programs, which give a [`tegula::Mesh`], and of the surfaces of rigid bodies.

pub mod layer;
pub mod node_table;
pub mod numbered;
pub mod stl;

use std::fmt;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use tegula::model::MeshSource;
use tegula::{Issue, Mesh, mesh_readers};

/// Format of mesh files.
pub trait MeshReader {
    /// Usual end of the names of such files, such as `.msh`.
    const SUFFIX: &'static str;
    /// Mesh of the bytes of a file, all coordinates multiplied by `scale`; `path` only appears in errors.
    ///
    /// # Errors
    /// The bytes are not a mesh of four-node quadrilaterals in this format, or are damaged; counts in them are never trusted.
    fn parse(path: &Path, bytes: &[u8], scale: f64) -> Result<Mesh, MeshError>;
    /// Small file of this format with quads and a named set, on which the contract of all readers is tested.
    fn example() -> &'static [u8];
}

/// Declares the files of the readers and chooses among them, by the registry in `crates/tegula/src/model/mesh_source.rs`.
macro_rules! readers {
    ($($file:ident::$format:ident: $help:literal,)*) => {
        $(pub mod $file;)*

        /// Reads the mesh file of a model, which lies at `path`; `None` for generators.
        ///
        /// # Errors
        /// The file cannot be read, or is no mesh of four-node quadrilaterals.
        pub fn read(source: &MeshSource, path: &Path) -> Option<Result<FileMesh, MeshError>> {
            let scale = source.file()?.scale;
            match source {
                $(MeshSource::$format(_) => Some(parsed::<$file::$format>(path, scale)),)*
                _ => None,
            }
        }

        /// Name, example and parser of every format: the contract of all readers is tested on them.
        pub fn readers() -> Vec<(&'static str, &'static [u8], Parser)> {
            vec![$((
                stringify!($file),
                <$file::$format as MeshReader>::example(),
                <$file::$format as MeshReader>::parse as Parser,
            )),*]
        }
    };
}
mesh_readers!(readers);

/// Parser of a format: path for errors, bytes, factor on all coordinates.
pub type Parser = fn(&Path, &[u8], f64) -> Result<Mesh, MeshError>;

/// Mesh of a file, and the bytes from which it was read.
pub struct FileMesh {
    /// The mesh.
    pub mesh: Mesh,
    /// Bytes of the file, for its fingerprint.
    pub bytes: Vec<u8>,
}

fn parsed<R: MeshReader>(path: &Path, scale: f64) -> Result<FileMesh, MeshError> {
    let bytes = load(path, ("mesh file", R::SUFFIX))?;
    Ok(FileMesh { mesh: R::parse(path, &bytes, scale)?, bytes })
}

/// Bytes of the file at `path`, a `kind` of file such as "mesh file" whose name should end with `suffix`. Devices and pipes are
/// refused: they may have no end.
pub fn load(path: &Path, (kind, suffix): (&str, &str)) -> Result<Vec<u8>, MeshError> {
    let give = format!("give the path of a {suffix} file");
    let refused = |message: String, help: &str| MeshError {
        file: path.to_owned(),
        at: At::File,
        message,
        help: help.to_owned(),
    };
    let failed = |error: std::io::Error| match error.kind() {
        ErrorKind::NotFound => {
            refused(format!("there is no such {kind}"), "check the path; it is relative to the model file")
        }
        _ => refused(format!("the {kind} cannot be read: {error}"), "check the file and its permissions"),
    };
    let found = std::fs::metadata(path).map_err(failed)?.file_type();
    if found.is_dir() {
        return Err(refused(format!("this is a directory, not a {kind}"), &give));
    }
    if !found.is_file() {
        return Err(refused(format!("this is a device or a pipe, not a {kind}"), &give));
    }
    std::fs::read(path).map_err(failed)
}

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
        self.issue_at("mesh.file")
    }

    /// The error as an issue of the model file, at the key that names the file.
    pub fn issue_at(&self, key: impl Into<String>) -> Issue {
        Issue::new(
            key.into(),
            format!("{}{}: {}", self.file.display(), self.at, self.message),
            self.help.clone(),
        )
    }
}
