//! Central differences.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::SchemeKeys;
use crate::analysis::dynamics::Integrator;
use crate::system::System;

/// Central differences with lumped mass; the step follows from the highest frequency of the model.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ExplicitScheme {
    /// Make directors heavier until they vibrate no faster than the membrane, so that the thickness does not limit the
    /// step.
    #[serde(default = "yes")]
    pub scale_director_inertia: bool,
}

impl Default for ExplicitScheme {
    fn default() -> Self {
        Self { scale_director_inertia: true }
    }
}

impl SchemeKeys for ExplicitScheme {
    const WORD: &'static str = "explicit";

    fn integrator(&self, _: &System) -> Option<Box<dyn Integrator>> {
        None
    }

    fn is_explicit(&self) -> bool {
        true
    }
}

fn yes() -> bool {
    true
}
