//! A mesh whose nodes and elements stand in the model.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Nodes and elements, counted from 0 in the order in which they stand.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ArraysMesh {
    /// Position of each node (length). Nodes of no element are left out of the model.
    #[schemars(extend("x-marker" = "point"))]
    pub nodes: Vec<[f64; 3]>,
    /// Nodes of each element, counter-clockwise about its director.
    pub quads: Vec<[u32; 4]>,
    /// Named sets of nodes.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub node_sets: BTreeMap<String, Vec<u32>>,
    /// Named sets of sides of elements, each given by its two nodes.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub edge_sets: BTreeMap<String, Vec<[u32; 2]>>,
    /// Named sets of elements; "all" stands for every element.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub quad_sets: BTreeMap<String, Vec<u32>>,
    /// Names for further points: each becomes a node set with the node nearest to the position.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    #[schemars(extend("x-marker" = "point"))]
    pub points: BTreeMap<String, [f64; 3]>,
    /// Nodes that coincide without being connected, where parts were meshed apart: `true` merges them, `false` keeps them
    /// apart without a warning (a slit); unless given they stay apart with a warning.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub merge_coincident: Option<bool>,
    /// Angle (degrees), 1…180, from which on neighbouring elements form a fold and have directors of their
    /// own; 20 unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fold_angle: Option<f64>,
}
