//! Frame of the bars of a file, with the bodies of rigid elements and the supports.

use std::collections::{BTreeMap, BTreeSet};

use super::bars;
use crate::mesh::MeshError;
use crate::mesh::nastran::file::File;
use crate::mesh::nastran::rigid::{self, Body};
use crate::mesh::nastran::supports;
use crate::mesh::numbered::bars::Bar;
use crate::mesh::numbered::bars::frame::{self, Frame};
use crate::mesh::numbered::{Parts, Reader};

/// The frame of a file.
///
/// # Errors
/// The first mistake of a bar, a rigid element or a support, or a node in which all bars are released.
pub fn frame(reader: &Reader<'_>, file: &File<'_>, parts: &Parts) -> Result<Frame, MeshError> {
    let bars = bars(reader, file, parts)?;
    if bars.is_empty() {
        return Ok(Frame::default());
    }
    let held = supports::held(reader, file, parts)?;
    let bodies = carried(reader, &bars, &rigid::bodies(reader, file, parts)?)?;
    frame::frame(reader, &bars, (&bodies, &held), parts)
}

/// Names of the bodies of rigid elements by the nodes of bars that they hold.
fn carried(reader: &Reader<'_>, bars: &[Bar], bodies: &[Body]) -> Result<BTreeMap<u64, String>, MeshError> {
    let nodes: BTreeSet<u64> = bars.iter().flat_map(|bar| bar.ends.map(|end| end.node)).collect();
    let mut out: BTreeMap<u64, String> = BTreeMap::new();
    for body in bodies {
        for node in body.held().filter(|node| nodes.contains(node)) {
            if body.translations_alone {
                return Err(body.no_rotations(reader, body.line, "a bar holds"));
            }
            if let Some(other) = out.insert(node, body.name.clone()).filter(|other| *other != body.name) {
                return Err(reader.error(
                    body.line,
                    format!("node {node} of a bar is held by {other} and by {}", body.name),
                    "join the two into one",
                ));
            }
        }
    }
    Ok(out)
}
