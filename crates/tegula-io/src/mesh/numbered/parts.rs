//! Nodes, elements and sets of an input file, by their numbers in it.

use std::collections::{BTreeSet, HashMap};

use tegula::Vec3;

use super::{Reader, Sets};
use crate::mesh::MeshError;

/// Largest set whose displacements are asked for, and whose nodes are sets of their own.
pub const MOST_PRINTED: usize = 20;

/// Content of an input file that makes a mesh.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Parts {
    /// Position of each node, and the line on which it stands.
    pub nodes: HashMap<u64, (Vec3, usize)>,
    /// Elements in the order of the file.
    pub elements: Vec<Element>,
    /// Nodes of elements.
    pub used: BTreeSet<u64>,
    /// Sets of nodes.
    pub node_sets: Sets,
    /// Sets of elements.
    pub element_sets: Sets,
    /// Nodes that cards name by their numbers, which become sets of that name.
    pub single_nodes: BTreeSet<u64>,
    /// Elements that cards name by their numbers, which become sets of that name.
    pub single_elements: BTreeSet<u64>,
}

/// A shell of four nodes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Element {
    /// Number in the file.
    pub label: u64,
    /// Numbers of its nodes.
    pub nodes: [u64; 4],
    /// Line on which it stands.
    pub line: usize,
}

impl Parts {
    /// Refuses elements with unknown nodes and numbers that are given twice, and notes the nodes of elements.
    ///
    /// # Errors
    /// The first such element.
    pub fn check_elements(&mut self, reader: &Reader<'_>) -> Result<(), MeshError> {
        for Element { label, nodes, line } in &self.elements {
            if let Some(missing) = nodes.iter().find(|node| !self.nodes.contains_key(node)) {
                return Err(reader.error(
                    *line,
                    format!("element {label} needs node {missing}, which the file does not define"),
                    "check the numbers of the element, or define the node",
                ));
            }
            for (i, node) in nodes.iter().enumerate() {
                if nodes.iter().take(i).any(|earlier| earlier == node) {
                    return Err(reader.error(
                        *line,
                        format!("element {label} has node {node} at two corners"),
                        "mesh this part without collapsed quadrilaterals",
                    ));
                }
                self.used.insert(*node);
            }
        }
        let numbers: BTreeSet<u64> = self.elements.iter().map(|element| element.label).collect();
        if numbers.len() < self.elements.len() { Err(self.repeated_element(reader)) } else { Ok(()) }
    }

    /// Error of an element whose number is given twice.
    fn repeated_element(&self, reader: &Reader<'_>) -> MeshError {
        let mut lines = HashMap::new();
        for element in &self.elements {
            if let Some(earlier) = lines.insert(element.label, element.line) {
                let message =
                    format!("element {} is defined again; line {earlier} does so, too", element.label);
                return reader.error(element.line, message, "give each element once");
            }
        }
        reader.whole("an element is defined twice", "give each element once")
    }
}
