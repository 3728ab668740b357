//! Input files of Abaqus and CalculiX (`.inp`): the mesh.
//!
//! | in the file | becomes |
//! |---|---|
//! | `*ELEMENT`, `TYPE=S4` or `S4R` | quads |
//! | `*NSET`, `NSET=` of `*NODE` | a node set |
//! | `*ELSET`, `ELSET=` of `*ELEMENT` | a quad set |
//! | a node or an element that a support or a load names by its number | a set called by this number |
//!
//! Nodes are ordered by their numbers, quads as in the file; nodes of no quad are dropped, also from sets. The mesh keeps the numbers of the
//! file as labels. Cards of the model are skipped here: [`crate::abaqus`] reads them.

pub mod cards;
pub mod parts;
pub mod sets;

use std::collections::{BTreeSet, HashMap};
use std::path::Path;

use tegula::Mesh;
use tegula::mesh::Labels;
use tegula::mesh::sets::RENAME_ALL;

use self::cards::Reader;
use self::parts::Parts;
use super::{MeshError, MeshReader};

/// Format of Abaqus and CalculiX.
pub struct Abaqus;

impl MeshReader for Abaqus {
    const SUFFIX: &'static str = ".inp";

    fn parse(path: &Path, bytes: &[u8], scale: f64) -> Result<Mesh, MeshError> {
        let reader = Reader::new(path);
        if !(scale.is_finite() && scale > 0.0) {
            return Err(reader.whole(
                format!("the factor on the coordinates is {scale}"),
                "give a scale above 0, such as 0.001 for a mesh drawn in millimetres",
            ));
        }
        let text = cards::text(bytes);
        let parts = parts::parts(&reader, &reader.cards(&text)?)?;
        mesh(&reader, &parts, scale)
    }

    fn example() -> &'static [u8] {
        b"*HEADING\nTwo shells\n** nodes\n*Node, nset=all nodes\n1, 0., 0.\n2, 1., 0., 0.\n3, 2., 0.\n11, 0., 1.\n12, 1., 1.\n13, 2., 1., 0.\n\
          *ELEMENT, TYPE=S4R,\nELSET=plate\n1, 1, 2, 12, 11\n2, 2, 3, 13, 12\n\
          *NSET, NSET=left, GENERATE\n1, 11, 10\n*NSET, NSET=ends\nleft, 3, 13\n*BOUNDARY\n12, 3\n"
    }
}

/// Quads on the nodes that elements use, with the sets.
fn mesh(reader: &Reader<'_>, parts: &Parts, scale: f64) -> Result<Mesh, MeshError> {
    if parts.elements.is_empty() {
        return Err(reader.whole(
            "the file has no shells",
            "give the middle surface as elements of the type S4 with *ELEMENT",
        ));
    }
    if u32::try_from(parts.used.len().max(parts.elements.len())).is_err() {
        return Err(reader.whole("the mesh has more than 4294967295 nodes or quads", "make a coarser mesh"));
    }
    let labels = Labels {
        file: reader.file_name(),
        nodes: parts.used.iter().copied().collect(),
        quads: parts.elements.iter().map(|element| element.label).collect(),
    };
    let nodes: HashMap<u64, u32> = parts.used.iter().copied().zip(0..).collect();
    let quads: HashMap<u64, u32> = labels.quads.iter().copied().zip(0..).collect();
    let mut mesh = Mesh::default();
    for (position, line) in parts.used.iter().filter_map(|label| parts.nodes.get(label)) {
        let scaled = position * scale;
        if !scaled.iter().all(|x| x.is_finite()) {
            return Err(reader.error(
                *line,
                "a coordinate is not finite in the unit of the model",
                "check the coordinates and the scale of the mesh",
            ));
        }
        mesh.positions.push(scaled);
    }
    for element in &parts.elements {
        if let [Some(&a), Some(&b), Some(&c), Some(&d)] = element.nodes.map(|node| nodes.get(&node)) {
            mesh.quads.push([a, b, c, d]);
        }
    }
    let members = |of: &BTreeSet<u64>, known: &HashMap<u64, u32>| -> Vec<u32> {
        of.iter().filter_map(|label| known.get(label)).copied().collect()
    };
    let sets = |named: &sets::Sets, singles: &BTreeSet<u64>, known: &HashMap<u64, u32>| {
        let single =
            singles.iter().map(|label| (label.to_string(), members(&BTreeSet::from([*label]), known)));
        let named = named.iter().map(|(name, of)| (name.to_owned(), members(of, known)));
        single.chain(named).filter(|(_, set)| !set.is_empty()).collect()
    };
    mesh.node_sets = sets(&parts.node_sets, &parts.single_nodes, &nodes);
    mesh.quad_sets = sets(&parts.element_sets, &parts.single_elements, &quads);
    if let Some((_, message)) = mesh.partial_all() {
        return Err(reader.whole(message, RENAME_ALL));
    }
    mesh.labels = Some(labels);
    Ok(mesh)
}

#[cfg(test)]
mod tests;
