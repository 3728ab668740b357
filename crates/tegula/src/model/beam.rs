//! Beams: their axis, cross-section and material.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A shear-deformable beam. Its nodes are rigid cross-sections: joints, loads and springs name them `beam.start`, `beam.1`,
/// `beam.2`, …, `beam.end` for a beam called `beam`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Beam {
    /// Name of the beam in results, and first part of the names of its nodes.
    pub name: String,
    /// Axis of the beam in the reference configuration: both ends of a straight beam, or all nodes of a curved one (length).
    #[schemars(extend("x-marker" = "point"))]
    pub points: Vec<[f64; 3]>,
    /// Number of elements of a straight beam.
    #[schemars(range(min = 1))]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub elements: Option<u32>,
    /// Direction of axis 1 of the cross-section at the start; it is projected across the axis of the beam. Axis 3 is the tangent
    /// from the first to the last point, axis 2 completes a right-handed base.
    #[schemars(extend("x-marker" = "direction"))]
    pub direction: [f64; 3],
    /// Rotation of the cross-section about the tangent from the start to the end (degrees), in proportion to the length.
    #[serde(default)]
    pub twist: f64,
    /// Cross-section: a shape of the `material`, or section constants.
    pub section: BeamSection,
    /// Name of an isotropic material; needed by sections of a shape.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub material: Option<String>,
    /// Names of sets of shell nodes, such as a line of the mesh, that move with the cross-sections of the beam: each with the node of the beam
    /// beside which it lies, at any distance across the axis. The beam stiffens the shell.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub attached: Vec<String>,
    /// Velocity of the first point at the start [length/time].
    #[serde(default)]
    pub velocity: [f64; 3],
    /// Angular velocity of the whole beam about its first point at the start, along the axes of space [rad/time].
    #[serde(default)]
    pub angular_velocity: [f64; 3],
    /// Retardation time τ of Kelvin–Voigt damping, `n = C (ε + τ ε̇)`.
    #[schemars(range(min = 0.0))]
    #[serde(default)]
    pub retardation_time: f64,
    /// Nodes whose motion appears in the history, counted from 0; both ends unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub history: Option<Vec<u32>>,
}

impl Beam {
    /// A straight beam at rest.
    pub fn straight(
        name: &str,
        ends: [[f64; 3]; 2],
        elements: u32,
        direction: [f64; 3],
        section: BeamSection,
    ) -> Self {
        Self {
            name: name.into(),
            points: ends.to_vec(),
            elements: Some(elements),
            direction,
            twist: 0.0,
            section,
            material: None,
            attached: Vec::new(),
            velocity: [0.0; 3],
            angular_velocity: [0.0; 3],
            retardation_time: 0.0,
            history: None,
        }
    }
}

/// Cross-section of a beam.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "type", rename_all = "kebab-case")]
pub enum BeamSection {
    /// Rectangle.
    Rectangle(RectangularSection),
    /// Circle, or ring with an inner radius.
    Circle(CircularSection),
    /// Rectangular hollow section with walls of one thickness (box).
    Box(BoxSection),
    /// Section constants.
    Constants(SectionConstants),
}

/// Rectangular cross-section.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RectangularSection {
    /// Sides along the axes 1 and 2 (length).
    pub size: [f64; 2],
}

/// Rectangular hollow section with thin walls.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BoxSection {
    /// Outer sides along the axes 1 and 2 (length).
    pub size: [f64; 2],
    /// Thickness of the walls (length).
    pub thickness: f64,
}

/// Circular cross-section.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CircularSection {
    /// Outer radius (length).
    pub radius: f64,
    /// Inner radius (length); 0 unless given.
    #[serde(default)]
    pub inner_radius: f64,
}

/// Stiffness and inertia of a cross-section about its centre, along its axes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SectionConstants {
    /// Axial stiffness EA \[force\].
    pub axial: f64,
    /// Shear stiffness kGA along the axes 1 and 2 \[force\].
    pub shear: [f64; 2],
    /// Bending stiffness EI about the axes 1 and 2 [force·length²].
    pub bending: [f64; 2],
    /// Torsional stiffness GJ [force·length²].
    pub torsion: f64,
    /// Mass per length; it may be 0 in statics.
    pub mass: f64,
    /// Moments of inertia per length about the axes 1 and 2 [mass·length]; that about the axis of the beam is their sum. They may be 0 in statics.
    pub inertia: [f64; 2],
}
