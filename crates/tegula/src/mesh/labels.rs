//! Numbers of nodes and elements in the user's mesh file.
//!
//! Inside, nodes and quads are counted from 0. A mesh file has numbers of its own, with gaps and in any order; messages
//! use these.

use super::Mesh;
use crate::Issue;

/// Numbers of a mesh file.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Labels {
    /// Name of the mesh file; empty where the nodes stand in the model.
    pub file: String,
    /// Number of each node in the file.
    pub nodes: Vec<u64>,
    /// Number of each quad in the file.
    pub quads: Vec<u64>,
}

impl Labels {
    /// Number of a node in the file; the internal one where the file has none.
    pub fn node(&self, node: usize) -> u64 {
        self.nodes.get(node).copied().unwrap_or(node as u64)
    }

    /// Number of a quad in the file; the internal one where the file has none.
    pub fn quad(&self, quad: usize) -> u64 {
        self.quads.get(quad).copied().unwrap_or(quad as u64)
    }
}

impl Mesh {
    /// Number of a node in messages: that of the mesh file, or the internal one, counted from 0.
    pub fn node_label(&self, node: u32) -> u64 {
        self.labels.as_ref().map_or(u64::from(node), |labels| labels.node(node as usize))
    }

    /// Number of a quad in messages: that of the mesh file, or the internal one, counted from 0.
    pub fn quad_label(&self, quad: usize) -> u64 {
        self.labels.as_ref().map_or(quad as u64, |labels| labels.quad(quad))
    }

    /// Makes issues of the mesh as a whole name the file that it was read from, and moves them to the key of the file.
    pub(crate) fn name_file(&self, issues: &mut [Issue]) {
        let Some(labels) = self.labels.as_ref().filter(|labels| !labels.file.is_empty()) else { return };
        for issue in issues.iter_mut().filter(|issue| issue.place.key == "mesh") {
            issue.place.key = "mesh.file".into();
            issue.message = format!("{}: {}", labels.file, issue.message);
        }
    }
}
