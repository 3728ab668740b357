//! Nodes, elements and sets of an input file, by their numbers in it.

use std::collections::{BTreeSet, HashMap};

use tegula::Vec3;

use super::{Reader, Sets};
use crate::mesh::MeshError;
use crate::mesh::layer::Pairs;

/// Largest set whose displacements are asked for, and whose nodes are sets of their own.
pub const MOST_PRINTED: usize = 20;

/// Content of an input file that makes a mesh.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Parts {
    /// Position of each node, and the line on which it stands.
    pub nodes: HashMap<u64, (Vec3, usize)>,
    /// Elements in the order of the file.
    pub elements: Vec<Element>,
    /// Nodes at the bottom and the top of shells that are given as hexahedra. The nodes at the bottom stand for those of the middle surface.
    pub layer: Pairs,
    /// Vectors from the bottom to the top of these shells, by their nodes.
    pub through: HashMap<u64, Vec3>,
    /// Bars that stand among the elements.
    pub bars: Vec<BarElement>,
    /// Nodes of these bars.
    pub of_bars: BTreeSet<u64>,
    /// Nodes of shells.
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

/// A bar of two nodes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BarElement {
    /// Number in the file.
    pub label: u64,
    /// Numbers of its nodes.
    pub nodes: [u64; 2],
    /// Number of a node beside its axis, which orients it.
    pub beside: Option<u64>,
    /// Line on which it stands.
    pub line: usize,
}

impl Parts {
    /// Node of the middle surface that a node of a shell stands for.
    pub fn middle(&self, node: u64) -> Option<u64> {
        if self.used.contains(&node) { Some(node) } else { self.layer.below.get(&node).copied() }
    }

    /// Whether a node belongs to a shell or a bar.
    pub fn has(&self, node: u64) -> bool {
        self.middle(node).is_some() || self.of_bars.contains(&node)
    }

    /// Refuses an element with unknown nodes, or with one node in two places.
    ///
    /// # Errors
    /// The first such node.
    pub fn check_nodes(
        &self,
        reader: &Reader<'_>,
        (label, line): (u64, usize),
        nodes: &[u64],
    ) -> Result<(), MeshError> {
        if let Some(missing) = nodes.iter().find(|node| !self.nodes.contains_key(node)) {
            return Err(reader.error(
                line,
                format!("element {label} needs node {missing}, which the file does not define"),
                "check the numbers of the element, or define the node",
            ));
        }
        let repeated = nodes.iter().enumerate().find(|(i, node)| nodes.iter().take(*i).any(|n| n == *node));
        match repeated {
            None => Ok(()),
            Some((_, node)) => Err(reader.error(
                line,
                format!("element {label} has node {node} at two corners"),
                "mesh this part without collapsed elements",
            )),
        }
    }

    /// Refuses elements with unknown nodes and numbers that are given twice, and notes the nodes of elements.
    ///
    /// # Errors
    /// The first such element.
    pub fn check_elements(&mut self, reader: &Reader<'_>) -> Result<(), MeshError> {
        for Element { label, nodes, line } in &self.elements {
            self.check_nodes(reader, (*label, *line), nodes)?;
            self.used.extend(nodes);
        }
        for BarElement { label, nodes, beside, line } in &self.bars {
            let all: Vec<u64> = nodes.iter().copied().chain(*beside).collect();
            self.check_nodes(reader, (*label, *line), &all)?;
            self.of_bars.extend(nodes);
        }
        let count = self.elements.len() + self.bars.len();
        if self.labels().len() < count { Err(self.repeated_element(reader)) } else { Ok(()) }
    }

    /// Numbers of all elements.
    pub fn labels(&self) -> BTreeSet<u64> {
        self.numbered().map(|(label, _)| label).collect()
    }

    /// Numbers of all elements with their lines.
    fn numbered(&self) -> impl Iterator<Item = (u64, usize)> {
        let shells = self.elements.iter().map(|element| (element.label, element.line));
        shells.chain(self.bars.iter().map(|bar| (bar.label, bar.line)))
    }

    /// Error of an element whose number is given twice.
    fn repeated_element(&self, reader: &Reader<'_>) -> MeshError {
        let mut lines = HashMap::new();
        for (label, line) in self.numbered() {
            if let Some(earlier) = lines.insert(label, line) {
                let message = format!("element {label} is defined again; line {earlier} does so, too");
                return reader.error(line, message, "give each element once");
            }
        }
        reader.whole("an element is defined twice", "give each element once")
    }
}
