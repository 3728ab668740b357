//! Response of a model to small harmonic excitation, from its modes.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Load;

/// Excitation of a model in its response to small motions: loads that act together, each multiplied by the same function of time.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ResponseInput {
    /// Name of the input in the results.
    pub name: String,
    /// Loads as in `loads`, without `amplitude`: their values are the amplitudes of the excitation. They add nothing to the state about
    /// which the model vibrates.
    pub loads: Vec<Load>,
}

/// Steady-state response to harmonic excitation over a range of frequencies.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FrequencyResponse {
    /// Lowest frequency [1/time].
    #[schemars(range(min = 0.0))]
    pub from: f64,
    /// Highest frequency [1/time], not above the highest mode.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub to: f64,
    /// Number of frequencies between the two. Natural frequencies of damped modes in the range and the flanks of their peaks are added.
    #[schemars(range(min = 2, max = 100_000))]
    #[serde(default = "two_hundred")]
    pub points: u32,
    /// Spacing of these frequencies.
    #[serde(default)]
    pub spacing: Spacing,
}

/// Spacing of frequencies.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Spacing {
    /// Equal ratios between neighbours.
    #[default]
    Logarithmic,
    /// Equal distances between neighbours.
    Linear,
}

fn two_hundred() -> u32 {
    200
}
