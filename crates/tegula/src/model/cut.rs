//! Cuts: lines of the mesh at which section forces and moments are recorded.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Cut along a line of the mesh, whose resultant force and moment are the columns `cut.NAME.fx` … `mz` of the history: the nodal
/// forces of the elements of the set `of` at the nodes of the line, summed. They are the force and the moment that the rest of the model
/// exerts on these elements across the line. Supports, joints, loads and inertia at the nodes of the line belong to the rest.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Cut {
    /// Name of the cut in histories and `summary.json`.
    pub name: String,
    /// Name of a set of nodes or edges: the line of the cut.
    pub on: String,
    /// Name of a set of elements: the part on one side of the line, on which the force and the moment act.
    pub of: String,
    /// Point of space about which the moment is taken (length); the mean of the line's nodes in the current configuration unless given, in
    /// linear analyses in the reference configuration.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-marker" = "point"))]
    pub about: Option<[f64; 3]>,
}
