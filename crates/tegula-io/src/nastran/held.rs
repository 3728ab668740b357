//! Supports of nodes, of bodies, and of cross-sections of bars.

use crate::conversion::document::Document;
use crate::conversion::held::{self, Hold};
use crate::conversion::supports::{self, Restraint};
use crate::mesh::MeshError;
use crate::mesh::nastran::file::File;
use crate::mesh::nastran::supports::{Support, supports};
use crate::mesh::numbered::{Parts, Reader};

/// Writes supports of nodes, of the bodies of rigid elements, and of cross-sections of bars. Returns the names of the bodies and cross-sections.
///
/// # Errors
/// A support that cannot be read, or a prescribed motion of a body.
pub(super) fn write(
    out: &mut Document,
    reader: &Reader<'_>,
    file: &File<'_>,
    parts: &Parts,
) -> Result<Vec<String>, MeshError> {
    let found = supports(reader, file, parts)?;
    let (bodies, nodes): (Vec<Support>, Vec<Support>) =
        found.into_iter().partition(|support| support.body.is_some());
    let hold = |Support { target, line, card, values, body }: Support| Hold {
        name: target.name,
        at: body.unwrap_or_default(),
        line,
        card,
        values,
    };
    let holds: Vec<Hold> = bodies.into_iter().map(hold).collect();
    held::write(out, reader, &holds)?;
    let restraint =
        |Support { target, line, card, values, .. }: Support| Restraint { target, line, dofs: values, card };
    let restraints: Vec<Restraint> = nodes.into_iter().map(restraint).collect();
    supports::write(out, reader, parts, "[[conditions]]", &restraints)?;
    Ok(holds.into_iter().map(|hold| hold.name).collect())
}
