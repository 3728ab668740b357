//! Equilibrium paths.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::StopCondition;

/// Equilibrium path under loads that grow and fall with the load factor, through limit points.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PathAnalysis {
    /// Load factor at which the path ends when it gets there; a negative one starts the path with falling loads.
    #[serde(default = "full_load")]
    pub end_load: f64,
    /// Method that follows the path; left out: power series where the model has some, else the arc-length method, and the run says why.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub method: Option<PathMethod>,
    /// Steps, expansions into power series or arc-length steps, after which the path ends.
    #[schemars(range(min = 1))]
    #[serde(default = "two_hundred")]
    pub max_steps: u32,
    /// Highest order of the power series.
    #[schemars(range(min = 5, max = 60))]
    #[serde(default = "twenty")]
    pub order: u32,
    /// Truncation error of the power series at the end of a step, over the displacement of the step.
    #[serde(default = "tolerance")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub tolerance: f64,
    /// Points of the path that each expansion reports, its end included; an arc-length step reports its end.
    #[schemars(range(min = 1))]
    #[serde(default = "ten")]
    pub points: u32,
    /// Numbers of the bifurcations, counted from 1 along the path, at which it goes over to the crossing path, on the side of the critical
    /// mode; a negative number: on the other side.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub switch_at: Vec<i32>,
    /// Bifurcations whose crossing paths are followed behind this one, on both sides: a number, the first ones, or `"all"`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub branches: Option<Branches>,
    /// Kind of critical point at the first of which the path ends.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub end_at: Option<PathEnd>,
    /// Conditions at which the path ends.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub stop: Vec<StopCondition>,
}

/// Bifurcations of a path whose crossing paths are followed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum Branches {
    /// The first ones, this many.
    First(u32),
    /// All of them.
    All(AllBranches),
}

/// All bifurcations of a path.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum AllBranches {
    /// All of them.
    All,
}

impl Branches {
    /// Number of those among `bifurcations` whose crossing paths are followed.
    pub fn among(self, bifurcations: usize) -> usize {
        match self {
            Self::First(number) => bifurcations.min(number as usize),
            Self::All(AllBranches::All) => bifurcations,
        }
    }
}

/// Kind of critical point at which a path ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum PathEnd {
    /// Limit point.
    LimitPoint,
    /// Bifurcation.
    Bifurcation,
    /// Onset of flutter under follower loads without a potential.
    Flutter,
    /// Limit point, bifurcation or onset of flutter.
    CriticalPoint,
}

/// Method that follows a path.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum PathMethod {
    /// Power series (asymptotic numerical method): one factorisation a step, for linear materials, joints of quadratic constraints, and loads
    /// of constant direction in proportion to the load factor.
    Series,
    /// Arc-length method: Newton's method on planes across the path, for all models.
    ArcLength,
}

impl Default for PathAnalysis {
    fn default() -> Self {
        Self {
            end_load: full_load(),
            method: None,
            max_steps: two_hundred(),
            order: twenty(),
            tolerance: tolerance(),
            points: ten(),
            switch_at: Vec::new(),
            branches: None,
            end_at: None,
            stop: Vec::new(),
        }
    }
}

fn full_load() -> f64 {
    1.0
}
fn two_hundred() -> u32 {
    200
}
fn twenty() -> u32 {
    20
}
fn tolerance() -> f64 {
    1e-9
}
fn ten() -> u32 {
    10
}
