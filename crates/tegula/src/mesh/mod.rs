//! Quadrilateral surface meshes: nodes, cells, named sets, directors.
//!
//! | name | is |
//! |---|---|
//! | node | a point of the mid-surface |
//! | quad | four nodes, counter-clockwise about the director; natural coordinates (−1,−1), (1,−1), (1,1), (−1,1) |
//! | director | unit normal of the *true* surface at a node; one if smooth, several where sheets meet at an angle |
//! | set | a name for nodes, edges or quads, used by conditions, loads, sections and output |

mod arrays;
pub mod directors;
mod elements;
mod facet;
mod fields;
pub mod folds;
pub mod generators;
mod grid;
mod input;
mod junction;
mod labels;
pub(crate) mod middle_surface;
mod point_tree;
mod polyline;
pub mod quality;
pub mod seams;
pub mod sets;
mod surfaces;
mod topology;

use std::collections::BTreeMap;

pub(crate) use facet::show;
pub use fields::{FieldValues, Fields};
pub(crate) use grid::Random;
pub use labels::Labels;

use crate::Vec3;

/// A mesh of four-node quadrilaterals with named sets.
#[derive(Debug, Clone, Default)]
pub struct Mesh {
    /// Position of each node (length).
    pub positions: Vec<Vec3>,
    /// Nodes of each quad, counter-clockwise about the director.
    pub quads: Vec<[u32; 4]>,
    /// Exact unit normals of the true surface at the corners of each quad, where the source of the mesh knows them;
    /// otherwise they are averaged from the facets.
    pub normals: Option<Vec<[Vec3; 4]>>,
    /// Thickness at each node (length), where the file holds it because the mesh was made of solids.
    pub thickness: Option<Vec<f64>>,
    /// Named sets of nodes, without repetition.
    pub node_sets: BTreeMap<String, Vec<u32>>,
    /// Named sets of edges, each a pair of neighbouring nodes.
    pub edge_sets: BTreeMap<String, Vec<[u32; 2]>>,
    /// Named sets of quads.
    pub quad_sets: BTreeMap<String, Vec<u32>>,
    /// Numbers of nodes and quads in the file that the mesh was read from; a generated mesh has none.
    pub labels: Option<Labels>,
    /// Arrays of the file that the mesh was read from.
    pub fields: Fields,
}
