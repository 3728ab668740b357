//! Kinematic analysis.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::SchemeKeys;
use crate::analysis::dynamics::Integrator;
use crate::analysis::dynamics::kinematics::Kinematics;
use crate::checker::Checker;
use crate::model::{Model, TransientAnalysis};
use crate::system::System;

/// Kinematic analysis: the positions of rigid bodies follow from joints and drives alone, velocities and accelerations from the rates of
/// the drives. Nothing is integrated; bodies may be without mass. Where they have masses, the drives' forces and all reactions are those of
/// the motion (inverse dynamics).
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct KinematicScheme {}

impl SchemeKeys for KinematicScheme {
    const WORD: &'static str = "kinematic";

    fn check_model(&self, key: &str, model: &Model, _options: &TransientAnalysis, c: &mut Checker) {
        let mut refuse = |place: String, message: String, help: &str| c.add(place, message, help);
        if !model.sections.is_empty() || !model.beams.is_empty() {
            refuse(
                key.into(),
                "the motion of shells and beams does not follow from joints and drives alone".into(),
                "use rigid bodies, or the scheme \"energy-momentum\"",
            );
        }
        for (i, body) in model.bodies.iter().enumerate() {
            if body.velocity != [0.0; 3] || body.angular_velocity != [0.0; 3] {
                refuse(
                    format!("bodies[{i}]"),
                    format!(
                        "body \"{}\" has a velocity at the start, but drives alone move it in a kinematic analysis",
                        body.name
                    ),
                    "leave it out",
                );
            }
        }
        if !model.initial_velocities.is_empty() {
            refuse(
                "initial_velocities".into(),
                "drives alone move the bodies of a kinematic analysis".into(),
                "leave the velocities at the start out",
            );
        }
        if !model.joints.iter().any(|joint| joint.common().drive().is_some()) {
            refuse(
                key.into(),
                "no joint is driven, so that nothing moves in a kinematic analysis".into(),
                "add a joint `driven-angle` or `driven-length`",
            );
        }
    }

    fn integrator(&self, system: &System) -> Option<Box<dyn Integrator>> {
        Some(Box::new(Kinematics::new(system)))
    }

    fn moves_bodies(&self) -> bool {
        true
    }

    fn is_kinematic(&self) -> bool {
        true
    }
}
