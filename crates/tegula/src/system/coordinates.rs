//! Coordinates of the model: nodal vectors with their kinds, nodes and reference values.

use crate::element::Nodal;
pub use crate::element::VectorKind;

/// Nodal vectors of a model, node by node: the position of a node, then its directors, each followed by its gradients
/// where an element has them. They do not change while the model is analysed.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Coordinates {
    /// Nodal vectors of the reference configuration.
    pub reference: Vec<Nodal>,
    /// Kind of each nodal vector.
    pub kinds: Vec<VectorKind>,
    /// Node of each nodal vector.
    pub nodes: Vec<u32>,
    /// Nodal vector of the position of each node (`u32::MAX` for nodes without elements).
    pub position_of: Vec<u32>,
    /// Nodal vector of the (first) director of each node (`u32::MAX` for nodes without elements).
    pub director_of: Vec<u32>,
    /// Flags of the inextensible directors among the nodal vectors; empty: none.
    pub inextensible: Vec<bool>,
}

impl Coordinates {
    /// Adds a nodal vector of a node; returns its index.
    pub fn push(&mut self, value: Nodal, kind: VectorKind, node: u32) -> u32 {
        self.reference.push(value);
        self.kinds.push(kind);
        self.nodes.push(node);
        (self.reference.len() - 1) as u32
    }

    /// Number of nodal vectors.
    pub fn len(&self) -> usize {
        self.reference.len()
    }

    /// Whether there are no nodal vectors.
    pub fn is_empty(&self) -> bool {
        self.reference.is_empty()
    }

    /// Reference position of the node that a nodal vector belongs to.
    pub fn place(&self, vector: usize) -> Nodal {
        self.reference[self.position_of[self.nodes[vector] as usize] as usize]
    }
}
