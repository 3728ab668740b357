//! Meshes of input files whose nodes and elements have numbers: what the formats have in common.

pub mod bars;
pub mod normals;
pub mod parts;
pub mod reader;
pub mod sets;

use std::collections::{BTreeSet, HashMap};

use tegula::mesh::Labels;
use tegula::mesh::sets::RENAME_ALL;
use tegula::{Mesh, Vec3};

pub use self::parts::{BarElement, Element, MOST_PRINTED, Parts};
pub use self::reader::{Reader, shown, text};
pub use self::sets::Sets;
use super::MeshError;

/// Quads on the nodes that elements use, with the sets; all coordinates are multiplied by `scale`.
///
/// # Errors
/// There are no elements, or the scale or a coordinate cannot be used.
pub fn mesh(reader: &Reader<'_>, parts: &Parts, scale: f64) -> Result<Mesh, MeshError> {
    if !(scale.is_finite() && scale > 0.0) {
        return Err(reader.whole(
            format!("the factor on the coordinates is {scale}"),
            "give a scale above 0, such as 0.001 for a mesh drawn in millimetres",
        ));
    }
    if parts.elements.is_empty() {
        return Err(reader.whole("the file has no shells", "give the middle surface as shells of four nodes"));
    }
    if u32::try_from(parts.used.len().max(parts.elements.len())).is_err() {
        return Err(reader.whole("the mesh has more than 4294967295 nodes or quads", "make a coarser mesh"));
    }
    let labels = Labels {
        file: reader.file_name(),
        nodes: parts.used.iter().copied().collect(),
        quads: parts.elements.iter().map(|element| element.label).collect(),
    };
    let mut nodes: HashMap<u64, u32> = parts.used.iter().copied().zip(0..).collect();
    for (top, bottom) in &parts.layer.below {
        if let Some(&middle) = nodes.get(bottom) {
            nodes.insert(*top, middle);
        }
    }
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
    if !parts.through.is_empty() {
        let through: Vec<Vec3> =
            parts.used.iter().filter_map(|node| parts.through.get(node)).map(|t| t * scale).collect();
        mesh.thickness = Some(through.iter().map(|t| t.norm()).collect());
        mesh.normals =
            Some(mesh.quads.iter().map(|quad| quad.map(|n| through[n as usize].normalize())).collect());
    }
    let members = |of: &BTreeSet<u64>, known: &HashMap<u64, u32>| -> Vec<u32> {
        let distinct: BTreeSet<u32> = of.iter().filter_map(|label| known.get(label)).copied().collect();
        distinct.into_iter().collect()
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
