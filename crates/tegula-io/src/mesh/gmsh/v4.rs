//! Sections of format 4.1: `$Entities`, `$Nodes` and `$Elements`, in blocks by geometric entity.

use tegula::Vec3;

use super::raw::{Corners, Head, Raw, RawNode};
use super::scanner::Scanner;
use crate::mesh::MeshError;

/// Points, curves, surfaces and volumes with the physical groups they belong to.
pub(super) fn entities(scanner: &mut Scanner<'_>, raw: &mut Raw) -> Result<(), MeshError> {
    let mut counts = [0; 4];
    for count in &mut counts {
        *count = scanner.size("the number of points, curves, surfaces or volumes")?;
    }
    for (dimension, count) in (0u8..).zip(counts) {
        for _ in 0..count {
            let tag = scanner.int("the number of a geometric entity")?;
            // A point has its position, everything else its bounding box.
            for _ in 0..if dimension == 0 { 3 } else { 6 } {
                scanner.double("a coordinate of a geometric entity")?;
            }
            let mut groups = Vec::new();
            for _ in 0..scanner.size("the number of physical groups of an entity")? {
                groups.push(scanner.int("a physical group of an entity")?);
            }
            if dimension > 0 {
                for _ in 0..scanner.size("the number of boundaries of an entity")? {
                    scanner.int("a boundary of an entity")?;
                }
            }
            if let Some(list) = raw.add_groups(groups) {
                raw.entities.insert((dimension, tag), list);
            }
        }
    }
    Ok(())
}

/// Blocks of nodes: first all numbers, then all coordinates.
pub(super) fn nodes(scanner: &mut Scanner<'_>, raw: &mut Raw) -> Result<(), MeshError> {
    let Blocks { start, blocks, total } = block_count(scanner, "nodes")?;
    let mut found: u64 = 0;
    for _ in 0..blocks {
        let dimension = dimension(scanner)?;
        scanner.int("the number of a geometric entity")?;
        let parametric = scanner.int("the mark of parametric coordinates, 0 or 1")? != 0;
        let count = scanner.size("the number of nodes in a block")?;
        found = found.saturating_add(count);
        let mut tags = Vec::new();
        for _ in 0..count {
            tags.push((scanner.position(), scanner.size("the number of a node")?));
        }
        for (at, tag) in tags {
            let coordinates = scanner.position();
            let mut position = Vec3::zeros();
            for i in 0..3 {
                position[i] = scanner.double("a coordinate of a node")?;
            }
            for _ in 0..if parametric { dimension } else { 0 } {
                scanner.double("a parametric coordinate of a node")?;
            }
            raw.nodes.push(RawNode { tag, position, at, coordinates });
        }
    }
    scanner.total(start, "nodes", (total, found))
}

/// Blocks of elements of one type on one entity.
pub(super) fn elements(scanner: &mut Scanner<'_>, raw: &mut Raw) -> Result<(), MeshError> {
    let Blocks { start, blocks, total } = block_count(scanner, "elements")?;
    let mut found: u64 = 0;
    for _ in 0..blocks {
        let dimension = dimension(scanner)?;
        let entity = scanner.int("the number of a geometric entity")?;
        let kind = scanner.int("the type of the elements in a block")?;
        let count = scanner.size("the number of elements in a block")?;
        found = found.saturating_add(count);
        let groups = raw.entities.get(&(dimension, entity)).copied();
        let turned = groups
            .and_then(|list| raw.groups.get(list))
            .and_then(|list| list.first())
            .is_some_and(|&group| group < 0);
        let first = raw.elements.len();
        for _ in 0..count {
            let at = scanner.position();
            let tag = scanner.size("the number of an element")?;
            let head = Head { kind, tag, groups, entity, at };
            raw.read_element(scanner, head, |s| s.size("a node of an element"))?;
        }
        // Format 2.2 writes the elements of negative groups reversed; in format 4.1 the reader reverses them.
        if turned {
            for element in raw.elements.iter_mut().skip(first) {
                if let Corners::Quad(corners) = &mut element.corners {
                    corners.swap(1, 3);
                }
            }
        }
    }
    scanner.total(start, "elements", (total, found))
}

/// The head of a section of blocks.
struct Blocks {
    /// Place in the file.
    start: usize,
    /// Number of blocks, and of what they hold altogether.
    blocks: u64,
    total: u64,
}

/// `blocks total min-number max-number`: the last two are repeated by the blocks.
fn block_count(scanner: &mut Scanner<'_>, what: &str) -> Result<Blocks, MeshError> {
    let start = scanner.position();
    let blocks = scanner.size(&format!("the number of blocks of {what}"))?;
    let total = scanner.size(&format!("the number of {what}"))?;
    scanner.size(&format!("the smallest number of the {what}"))?;
    scanner.size(&format!("the greatest number of the {what}"))?;
    Ok(Blocks { start, blocks, total })
}

fn dimension(scanner: &mut Scanner<'_>) -> Result<u8, MeshError> {
    let at = scanner.position();
    let value = scanner.int("the dimension of a block, 0 to 3")?;
    match u8::try_from(value) {
        Ok(dimension @ 0..=3) => Ok(dimension),
        _ => Err(scanner.error(
            at,
            format!("expected the dimension of a block, 0 to 3, found \"{value}\""),
            "the file is cut off or damaged: save the mesh again in Gmsh",
        )),
    }
}
