//! Backward differentiation formula of second order.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::SchemeKeys;
use crate::analysis::dynamics::Integrator;
use crate::analysis::dynamics::bdf2::Bdf2;
use crate::system::System;

/// Backward differentiation formula of second order: strong numerical damping, for motions that settle in an equilibrium, also with
/// bodies and joints.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Bdf2Scheme {}

impl SchemeKeys for Bdf2Scheme {
    const WORD: &'static str = "bdf2";

    fn integrator(&self, system: &System) -> Option<Box<dyn Integrator>> {
        Some(Box::new(Bdf2::new(system)))
    }

    fn moves_bodies(&self) -> bool {
        true
    }
}
