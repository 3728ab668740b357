//! Bulk data files of Nastran (`.bdf`, `.nas`): the mesh.
//!
//! | in the file | becomes |
//! |---|---|
//! | `GRID` | nodes |
//! | `CQUAD4` | quads |
//! | the elements of a property | a quad set, such as `property 3` |
//! | nodes of supports and loads that the case control selects, or of `RBE2`, `RBE3` and `CBAR` | node sets |
//!
//! Nodes are ordered by their numbers, quads as in the file; nodes of no quad are dropped. The mesh keeps the numbers of the file as labels.
//! Cards of the model are skipped here: [`crate::nastran`] reads them.

pub mod angles;
pub mod bars;
pub mod bulk;
pub mod cards;
pub mod file;
pub mod interpolation;
pub mod loads;
pub mod numbers;
pub mod rigid;
pub mod supports;

use std::path::Path;

use tegula::Mesh;

use super::numbered::Reader;
use super::{MeshError, MeshReader, numbered};

/// Format of Nastran.
pub struct Nastran;

impl MeshReader for Nastran {
    const SUFFIX: &'static str = ".bdf";

    fn parse(path: &Path, bytes: &[u8], scale: f64) -> Result<Mesh, MeshError> {
        let reader = Reader::new(path);
        let text = file::text(bytes);
        let file = file::file(&reader, &text)?;
        let bulk = bulk::bulk(&reader, &file)?;
        numbered::mesh(&reader, &bulk.parts, scale)
    }

    fn example() -> &'static [u8] {
        b"SOL 101\nCEND\nSPC = 1\nBEGIN BULK\n$ Two shells\nGRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nGRID*                  3                              2.              0.\n\
          *                     0.\nGRID    11              0.      1.      0.\nGRID    12              1.      1.      0.\n\
          GRID    13              2.      1.\nCQUAD4  1       7       1       2       12      11\nCQUAD4,2,7,2,3,13,12\n\
          SPC1,1,123456,1,11\nENDDATA\n"
    }
}

#[cfg(test)]
mod tests;
