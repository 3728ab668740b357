//! Nodal vectors of a mesh.

use std::collections::BTreeMap;

use crate::Vec3;
use crate::element::geometry::tangents;
use crate::element::{Nodal, VectorKind};
use crate::mesh::Mesh;
use crate::mesh::directors::Directors;

/// Nodal vectors of a mesh: position of each node, then its directors, node by node.
pub(super) struct Vectors {
    pub(super) reference: Vec<Nodal>,
    pub(super) kinds: Vec<VectorKind>,
    pub(super) nodes: Vec<u32>,
    pub(super) position_of: Vec<u32>,
    pub(super) director_of: Vec<u32>,
    /// Nodal vector of each director.
    pub(super) of_director: Vec<u32>,
    /// First of the two gradient vectors beside each director, where an element has them.
    pub(super) gradient_of: Vec<u32>,
}

impl Vectors {
    pub(super) fn new(mesh: &Mesh, directors: &Directors, with_gradients: &[bool]) -> Self {
        let nodes = mesh.positions.len();
        let mut of_node: Vec<Vec<u32>> = vec![Vec::new(); nodes];
        for (d, &node) in directors.node.iter().enumerate() {
            of_node[node as usize].push(d as u32);
        }
        let mut out = Self {
            reference: Vec::new(),
            kinds: Vec::new(),
            nodes: Vec::new(),
            position_of: vec![u32::MAX; nodes],
            director_of: vec![u32::MAX; nodes],
            of_director: vec![u32::MAX; directors.values.len()],
            gradient_of: vec![u32::MAX; directors.values.len()],
        };
        for (node, list) in of_node.iter().enumerate().filter(|(_, l)| !l.is_empty()) {
            out.position_of[node] = out.push(mesh.positions[node], VectorKind::Position, node);
            for (i, &d) in list.iter().enumerate() {
                let v = out.push(directors.values[d as usize], VectorKind::Director, node);
                out.of_director[d as usize] = v;
                if with_gradients[d as usize] {
                    let [t1, t2] = tangents(&directors.values[d as usize]);
                    out.gradient_of[d as usize] = out.push(t1, VectorKind::Gradient, node);
                    out.push(t2, VectorKind::Gradient, node);
                }
                if i == 0 {
                    out.director_of[node] = v;
                }
            }
        }
        out
    }

    fn push(&mut self, value: Vec3, kind: VectorKind, node: usize) -> u32 {
        self.reference.push(value.into());
        self.kinds.push(kind);
        self.nodes.push(node as u32);
        (self.reference.len() - 1) as u32
    }

    /// Vectors of a kind of each node.
    pub(super) fn by_node(&self, wanted: VectorKind) -> BTreeMap<u32, Vec<u32>> {
        let mut out: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        for (v, (kind, node)) in self.kinds.iter().zip(&self.nodes).enumerate() {
            if *kind == wanted {
                out.entry(*node).or_default().push(v as u32);
            }
        }
        out
    }
}
