//! Elastic foundations.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Elastic foundation of E. Winkler: springs without mass between a set and its places in the reference configuration.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "type", rename_all = "kebab-case")]
pub enum Foundation {
    /// A spring at every node of a set [force/length].
    Point(FoundationOn),
    /// Springs per length of an edge [force/length²].
    Edge(FoundationOn),
    /// Springs per area of a quad set [force/length³].
    Area(AreaFoundation),
}

/// An elastic foundation of nodes or edges.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FoundationOn {
    /// Name of the set.
    pub on: String,
    /// Stiffness along the axes of space, not negative.
    pub stiffness: [f64; 3],
    /// Retardation time τ of its damping: forces `k (u + τ u̇)`.
    #[serde(default)]
    #[schemars(range(min = 0.0))]
    pub retardation_time: f64,
}

/// An elastic foundation of a surface.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AreaFoundation {
    /// Name of the quad set, or `"all"`.
    #[serde(default = "super::all")]
    pub on: String,
    /// Stiffness along the axes of space, not negative.
    #[serde(default)]
    pub stiffness: [f64; 3],
    /// Stiffness along the normals of the reference surface, in addition to `stiffness`.
    #[serde(default)]
    #[schemars(range(min = 0.0))]
    pub normal: f64,
    /// Retardation time τ of its damping: forces `k (u + τ u̇)`.
    #[serde(default)]
    #[schemars(range(min = 0.0))]
    pub retardation_time: f64,
}

impl Foundation {
    /// Name of the set.
    pub fn on(&self) -> &str {
        match self {
            Self::Point(f) | Self::Edge(f) => &f.on,
            Self::Area(f) => &f.on,
        }
    }

    /// Stiffness along the axes of space, and along the normals.
    pub fn stiffness(&self) -> ([f64; 3], f64) {
        match self {
            Self::Point(f) | Self::Edge(f) => (f.stiffness, 0.0),
            Self::Area(f) => (f.stiffness, f.normal),
        }
    }

    /// Retardation time of its damping.
    pub fn retardation_time(&self) -> f64 {
        match self {
            Self::Point(f) | Self::Edge(f) => f.retardation_time,
            Self::Area(f) => f.retardation_time,
        }
    }
}
