//! Distributions: factors that vary over the surface.

use std::fmt;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Factor that varies over the surface.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum Distribution {
    /// Formula in the coordinates `x`, `y` and `z` of the reference configuration.
    Formula(String),
    /// Array of the mesh file.
    Field(FieldName),
}

/// Array of the mesh file, by its name.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FieldName {
    /// Name of an array with one number for each point or cell of the mesh file; values of points are interpolated within the elements.
    pub field: String,
}

impl Distribution {
    /// Array of the mesh file with this name.
    pub fn of_field(name: &str) -> Self {
        Self::Field(FieldName { field: name.into() })
    }
}

impl From<&str> for Distribution {
    fn from(formula: &str) -> Self {
        Self::Formula(formula.into())
    }
}

impl From<String> for Distribution {
    fn from(formula: String) -> Self {
        Self::Formula(formula)
    }
}

impl fmt::Display for Distribution {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Formula(text) => f.write_str(text),
            Self::Field(name) => write!(f, "field {}", name.field),
        }
    }
}
