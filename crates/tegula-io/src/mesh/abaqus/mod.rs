//! Input files of Abaqus and CalculiX (`.inp`): the mesh.
//!
//! | in the file | becomes |
//! |---|---|
//! | `*ELEMENT`, `TYPE=S4` or `S4R` | quads |
//! | `*ELEMENT`, `TYPE=SC8R` | quads of the middle surface, with directors and thickness |
//! | `*ELEMENT`, `TYPE=B31` | lines of beams with the set of the nodes of shells that move with each |
//! | `*NSET`, `NSET=` of `*NODE` | a node set |
//! | `*ELSET`, `ELSET=` of `*ELEMENT` | a quad set |
//! | a node or an element that a support or a load names by its number | a set called by this number |
//!
//! Nodes are ordered by their numbers, quads as in the file; nodes of no quad are dropped, also from sets. The mesh keeps the numbers of the
//! file as labels. Cards of the model are skipped here: [`crate::abaqus`] reads them.

pub mod beams;
pub mod cards;
mod elements;
pub mod parts;
pub mod sets;
mod solids;

use std::path::Path;

use tegula::Mesh;

use self::cards::Reader;
use super::{MeshError, MeshReader, numbered};

/// Format of Abaqus and CalculiX.
pub struct Abaqus;

impl MeshReader for Abaqus {
    const SUFFIX: &'static str = ".inp";

    fn parse(path: &Path, bytes: &[u8], scale: f64) -> Result<Mesh, MeshError> {
        let reader = Reader::new(path);
        let text = cards::text(bytes);
        let parts = parts::parts(&reader, &reader.cards(&text)?)?;
        numbered::mesh(&reader, &parts, scale)
    }

    fn example() -> &'static [u8] {
        b"*HEADING\nTwo shells\n** nodes\n*Node, nset=all nodes\n1, 0., 0.\n2, 1., 0., 0.\n3, 2., 0.\n11, 0., 1.\n12, 1., 1.\n13, 2., 1., 0.\n\
          *ELEMENT, TYPE=S4R,\nELSET=plate\n1, 1, 2, 12, 11\n2, 2, 3, 13, 12\n\
          *NSET, NSET=left, GENERATE\n1, 11, 10\n*NSET, NSET=ends\nleft, 3, 13\n*BOUNDARY\n12, 3\n"
    }
}

#[cfg(test)]
mod tests;
