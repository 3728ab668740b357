//! Ties of non-matching meshes.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A tie: nodes follow the elements of another mesh, which need not have nodes there.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Tie {
    /// Name of the tie in messages and results.
    pub name: String,
    /// Name of a node or edge set whose nodes follow: of the two meshes that of the finer one.
    pub on: String,
    /// Name of the set of elements that they follow, in or on which they lie.
    pub to: String,
    /// Whether rotations follow, too; else the tie is a hinge.
    #[serde(default = "yes")]
    pub rotations: bool,
}

fn yes() -> bool {
    true
}
