//! Unchecked contents of the sections of a Gmsh file.

use std::collections::BTreeMap;

use tegula::Vec3;

use super::scanner::Scanner;
use crate::mesh::MeshError;

/// Content of a Gmsh file of either format.
#[derive(Debug, Default)]
pub(super) struct Raw {
    /// Names of the physical groups by dimension and number.
    pub names: BTreeMap<(u8, u64), String>,
    /// All nodes.
    pub nodes: Vec<RawNode>,
    /// Points, lines, quadrilaterals and hexahedra.
    pub elements: Vec<RawElement>,
    /// Lists of physical groups (signed numbers) that elements refer to.
    pub groups: Vec<Vec<i64>>,
    /// Index into `groups` by dimension and number of the geometric entity (format 4.1).
    pub entities: BTreeMap<(u8, i64), usize>,
    /// Whether an element is written once for each of its physical groups (format 2.2).
    pub copies: bool,
    /// Elements that cannot be computed.
    pub refused: BTreeMap<i64, Refused>,
}

/// A node.
#[derive(Debug)]
pub(super) struct RawNode {
    pub tag: u64,
    pub position: Vec3,
    /// Place of its number in the file.
    pub at: usize,
    /// Place of its coordinates.
    pub coordinates: usize,
}

/// A point, line, quadrilateral or hexahedron: one, two, four or eight nodes.
#[derive(Debug)]
pub(super) struct RawElement {
    pub tag: u64,
    pub corners: Corners,
    /// Index into [`Raw::groups`]; none: in no physical group.
    pub groups: Option<usize>,
    /// Number of the geometric entity that it lies on.
    pub entity: i64,
    /// Place in the file.
    pub at: usize,
}

/// Numbers in front of the nodes of an element.
#[derive(Debug, Clone, Copy)]
pub(super) struct Head {
    /// Type of the element.
    pub kind: i64,
    pub tag: u64,
    /// Index into [`Raw::groups`].
    pub groups: Option<usize>,
    /// Number of the geometric entity.
    pub entity: i64,
    /// Place in the file.
    pub at: usize,
}

/// Node numbers of an element.
#[derive(Debug, Clone, Copy)]
pub(super) enum Corners {
    Point(u64),
    Line([u64; 2]),
    Quad([u64; 4]),
    Hexahedron([u64; 8]),
}

/// Elements of one type that cannot be computed.
#[derive(Debug)]
pub(super) struct Refused {
    pub shape: Shape,
    pub nodes: u32,
    pub count: usize,
    /// Number of the first of them and its place in the file.
    pub first: u64,
    pub at: usize,
}

/// Shapes of Gmsh elements.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Shape {
    Point,
    Line,
    Triangle,
    Quadrilateral,
    Solid,
}

/// Shape and number of nodes of a Gmsh element type; none for types of order above 5 and exotic ones.
pub(super) fn shape(kind: i64) -> Option<(Shape, u32)> {
    use Shape::*;
    Some(match kind {
        15 => (Point, 1),
        1 => (Line, 2),
        8 => (Line, 3),
        26 => (Line, 4),
        27 => (Line, 5),
        28 => (Line, 6),
        2 => (Triangle, 3),
        9 => (Triangle, 6),
        20 => (Triangle, 9),
        21 => (Triangle, 10),
        22 => (Triangle, 12),
        23 | 24 => (Triangle, 15),
        25 => (Triangle, 21),
        3 => (Quadrilateral, 4),
        16 => (Quadrilateral, 8),
        10 => (Quadrilateral, 9),
        36 => (Quadrilateral, 16),
        37 => (Quadrilateral, 25),
        38 => (Quadrilateral, 36),
        4 => (Solid, 4),
        7 => (Solid, 5),
        6 => (Solid, 6),
        5 => (Solid, 8),
        11 => (Solid, 10),
        19 => (Solid, 13),
        14 => (Solid, 14),
        18 => (Solid, 15),
        13 => (Solid, 18),
        17 | 29 => (Solid, 20),
        12 => (Solid, 27),
        30 => (Solid, 35),
        31 => (Solid, 56),
        92 => (Solid, 64),
        93 => (Solid, 125),
        _ => return None,
    })
}

impl Raw {
    /// A new list of physical groups; none when it is empty.
    pub fn add_groups(&mut self, groups: Vec<i64>) -> Option<usize> {
        if groups.is_empty() {
            return None;
        }
        self.groups.push(groups);
        Some(self.groups.len() - 1)
    }

    /// Reads the nodes of the element `tag` of type `kind`, each by `node`, and keeps the element.
    pub fn read_element<'a>(
        &mut self,
        scanner: &mut Scanner<'a>,
        Head { kind, tag, groups, entity, at }: Head,
        node: impl Fn(&mut Scanner<'a>) -> Result<u64, MeshError>,
    ) -> Result<(), MeshError> {
        let Some((shape, count)) = shape(kind) else {
            return Err(scanner.error(
                at,
                format!("element {tag} is of type {kind}, which is unknown here"),
                "use quadrilaterals of order 1: \"Recombine Surface {:};\" and \"Mesh.ElementOrder = 1;\" in the .geo file",
            ));
        };
        let corners = match kind {
            15 => Corners::Point(node(scanner)?),
            1 => Corners::Line([node(scanner)?, node(scanner)?]),
            3 => Corners::Quad([node(scanner)?, node(scanner)?, node(scanner)?, node(scanner)?]),
            5 => {
                let mut corners = [0; 8];
                for corner in &mut corners {
                    *corner = node(scanner)?;
                }
                Corners::Hexahedron(corners)
            }
            _ => {
                for _ in 0..count {
                    node(scanner)?;
                }
                let refused = self.refused.entry(kind).or_insert(Refused {
                    shape,
                    nodes: count,
                    count: 0,
                    first: tag,
                    at,
                });
                refused.count += 1;
                return Ok(());
            }
        };
        self.elements.push(RawElement { tag, corners, groups, entity, at });
        Ok(())
    }
}
