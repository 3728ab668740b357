//! Imperfections of the reference geometry.

use std::sync::Arc;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Deviation of the reference geometry of the mesh from the nominal one, free of stress. Several of them add up.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "type", rename_all = "kebab-case")]
pub enum Imperfection {
    /// Shape of a buckling mode of the nominal structure under the loads of the (first) analysis.
    Mode(ModeImperfection),
    /// Smooth random deviation along the normals.
    Random(RandomImperfection),
    /// Plane wave along the normals.
    Wave(WaveImperfection),
    /// Displacements of nodes from a file.
    File(FileImperfection),
}

/// Imperfection in the shape of a buckling mode.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ModeImperfection {
    /// Number of the mode in ascending order of the positive load factors, counted from 1.
    #[schemars(range(min = 1))]
    #[serde(default = "first")]
    pub mode: u32,
    /// Largest displacement of a node (length); its sign chooses the side.
    pub amplitude: f64,
}

/// Random imperfection.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RandomImperfection {
    /// Largest displacement of a node along the normal (length).
    pub amplitude: f64,
    /// Correlation length ℓ (length): at the distance r the deviations have the correlation exp(−r²/2ℓ²).
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub correlation_length: f64,
    /// Seed; the same seed gives the same deviations.
    #[serde(default)]
    pub seed: u64,
}

/// Plane wave a·cos(2π x·d/ℓ + φ) along the normals at the nodes x.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WaveImperfection {
    /// Amplitude a (length); its sign chooses the side.
    pub amplitude: f64,
    /// Direction d in which the wave changes; of any length but zero.
    #[schemars(extend("x-marker" = "direction"))]
    pub direction: [f64; 3],
    /// Wavelength ℓ (length).
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub wavelength: f64,
    /// Phase φ at the origin (degrees).
    #[serde(default)]
    pub phase: f64,
}

/// Displacements of nodes, as they were measured or computed elsewhere.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FileImperfection {
    /// Path of a table, relative to the model file: lines with the number of a node and its displacement, separated by commas, below an
    /// optional line `node,x,y,z`. Nodes that are not in it stay where they are.
    pub file: String,
    /// Factor on all displacements.
    #[serde(default = "one")]
    pub factor: f64,
    /// The table. The library opens no files: the caller reads it.
    #[serde(skip)]
    pub displacements: Option<Arc<Vec<NodeDisplacement>>>,
}

/// Displacement of a node.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NodeDisplacement {
    /// Number of the node in the mesh file; nodes of generated meshes are counted from 0.
    pub node: u64,
    /// Displacement (length).
    pub displacement: [f64; 3],
}

fn first() -> u32 {
    1
}

fn one() -> f64 {
    1.0
}
