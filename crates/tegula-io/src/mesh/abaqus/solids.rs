//! Continuum shells, `SC8R`: the middle surface of a layer of elements of eight nodes, of which the nodes 5 to 8 lie above the nodes 1 to 4.

use tegula::Vec3;

use super::cards::Reader;
use crate::mesh::MeshError;
use crate::mesh::layer::leans;
use crate::mesh::numbered::{Element, Parts};

/// An element of eight nodes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Solid {
    /// Number in the file.
    pub label: u64,
    /// Nodes 1 to 4.
    pub bottom: [u64; 4],
    /// Nodes 5 to 8.
    pub top: [u64; 4],
    /// Line on which it stands.
    pub line: usize,
}

/// Adds the middle surface of the elements to `parts`: the nodes at the bottom move to the middle of the thickness.
///
/// # Errors
/// There are other shells, beams are on nodes of the elements, or the elements are no layer with two sides.
pub fn middle(reader: &Reader<'_>, parts: &mut Parts, solids: &[Solid]) -> Result<(), MeshError> {
    let (Some(first), None) = (solids.first(), parts.elements.first()) else {
        return match (solids.first(), parts.elements.first()) {
            (Some(solid), Some(shell)) => Err(reader.error(
                solid.line,
                format!("the file has continuum shells SC8R, and shells S4 on line {}", shell.line),
                "give all shells as S4 or all as SC8R: a mesh has a thickness at all nodes or at none",
            )),
            _ => Ok(()),
        };
    };
    for Solid { label, bottom, top, line } in solids {
        parts.check_nodes(reader, (*label, *line), &[*bottom, *top].concat())?;
        for (b, t) in bottom.iter().zip(top) {
            if !parts.layer.add(*b, *t) {
                return Err(reader.error(
                    *line,
                    format!("element {label} does not continue the layer of its neighbours: its node {t} is not above its node {b} there"),
                    "give one layer of elements whose nodes 5 to 8 all lie on the same side of the nodes 1 to 4; layers of materials are those of `*SHELL SECTION, COMPOSITE`",
                ));
            }
        }
    }
    let of_layer = |node: &u64| parts.layer.above.contains_key(node) || parts.layer.below.contains_key(node);
    let joined = parts.bars.iter().find_map(|bar| Some((bar, bar.nodes.into_iter().find(of_layer)?)));
    if let Some((bar, node)) = joined {
        return Err(reader.error(
            bar.line,
            format!("the B31 {} has the node {node} of a continuum shell, whose nodes have no rotations (line {})", bar.label, first.line),
            "give the shell as S4, whose nodes carry beams",
        ));
    }
    let place = |parts: &Parts, node: u64| parts.nodes.get(&node).map_or(Vec3::zeros(), |(at, _)| *at);
    let pairs: Vec<(u64, u64)> = parts.layer.above.iter().map(|(b, t)| (*b, *t)).collect();
    for (bottom, top) in pairs {
        let (below, above) = (place(parts, bottom), place(parts, top));
        parts.through.insert(bottom, above - below);
        if let Some((position, _)) = parts.nodes.get_mut(&bottom) {
            *position = (below + above) * 0.5;
        }
    }
    for Solid { label, bottom, line, .. } in solids {
        let [a, b, c, d] = bottom.map(|node| place(parts, node));
        let normal = (c - a).cross(&(d - b));
        let through = bottom.map(|node| parts.through.get(&node).copied().unwrap_or_default());
        if through.iter().any(|t| leans(*t, normal) || t.dot(&normal) < 0.0) {
            return Err(reader.error(
                *line,
                format!("the nodes 5 to 8 of element {label} do not lie above its nodes 1 to 4, which run anticlockwise as seen from above"),
                "number the nodes so that the thickness runs from the nodes 1 to 4 to the nodes 5 to 8, less than 60° from the normal; check the coordinates",
            ));
        }
        parts.elements.push(Element { label: *label, nodes: *bottom, line: *line });
    }
    Ok(())
}
