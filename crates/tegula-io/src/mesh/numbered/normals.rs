//! Targets of supports and loads, and the directions of the normals there.

use std::collections::HashMap;

use tegula::Vec3;

use super::Parts;

/// Components of a unit normal below this count as 0.
const ALIGNED: f64 = 1e-6;

/// Nodes of elements under one name.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Target {
    /// Name of the set in the model file.
    pub name: String,
    /// Nodes that belong to elements.
    pub nodes: Vec<u64>,
}

/// Axes along which, and axes across which, all normals of a part of the mesh lie.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Directions {
    /// Whether the normals are parallel to x, y, z.
    pub along: [bool; 3],
    /// Whether the normals are perpendicular to x, y, z.
    pub across: [bool; 3],
}

impl Directions {
    const ANY: Self = Self { along: [true; 3], across: [true; 3] };

    fn and(self, other: Self) -> Self {
        let both = |a: [bool; 3], b: [bool; 3]| [a[0] && b[0], a[1] && b[1], a[2] && b[2]];
        Self { along: both(self.along, other.along), across: both(self.across, other.across) }
    }

    fn of(normal: Vec3) -> Self {
        let n = normal.map(f64::abs);
        let small = [n.x < ALIGNED, n.y < ALIGNED, n.z < ALIGNED];
        Self { along: [small[1] && small[2], small[0] && small[2], small[0] && small[1]], across: small }
    }
}

/// Directions of the normals of the elements at each node.
#[derive(Debug)]
pub struct Normals(HashMap<u64, Directions>);

impl Normals {
    /// Normals of the elements of a mesh.
    pub fn new(parts: &Parts) -> Self {
        let mut of = HashMap::with_capacity(parts.used.len());
        for element in &parts.elements {
            let [Some(a), Some(b), Some(c), Some(d)] =
                element.nodes.map(|node| parts.nodes.get(&node).map(|(position, _)| *position))
            else {
                continue;
            };
            let Some(normal) = (c - a).cross(&(d - b)).try_normalize(0.0) else { continue };
            let directions = Directions::of(normal);
            for node in element.nodes {
                let at = of.entry(node).or_insert(Directions::ANY);
                *at = at.and(directions);
            }
        }
        Self(of)
    }

    /// Directions that the normals at all of these nodes have in common.
    pub fn common(&self, nodes: &[u64]) -> Directions {
        nodes.iter().filter_map(|node| self.0.get(node)).fold(Directions::ANY, |all, one| all.and(*one))
    }
}
