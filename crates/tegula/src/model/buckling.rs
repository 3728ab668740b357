//! Linear buckling analysis of the model file.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Linear buckling: factors λ of the loads at which the structure, linearised about its base state, becomes unstable.
///
/// `(K + λ K_σ) φ = 0` with the tangent stiffness K at the base state and the geometric stiffness K_σ of the stresses that the loads
/// produce linearly. The base state is the reference configuration; among `steps` it is the end of the step before, whose loads are kept
/// as they are, and λ multiplies the loads of the buckling step alone.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BucklingAnalysis {
    /// Number of load factors wanted, the lowest in magnitude.
    #[schemars(range(min = 1))]
    #[serde(default = "five")]
    pub factors: u32,
    /// Signs of the load factors wanted.
    #[serde(default)]
    pub signs: FactorSigns,
}

/// Signs of the load factors of a buckling analysis.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum FactorSigns {
    /// Positive factors: the loads act in their own direction.
    #[default]
    Positive,
    /// Factors of both signs: a negative one belongs to loads that are reversed.
    Both,
}

impl BucklingAnalysis {
    /// The lowest positive factors.
    pub fn new(factors: u32) -> Self {
        Self { factors, signs: FactorSigns::Positive }
    }
}

impl Default for BucklingAnalysis {
    fn default() -> Self {
        Self::new(five())
    }
}

fn five() -> u32 {
    5
}
