//! Imperfections of the reference geometry.

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

fn first() -> u32 {
    1
}
