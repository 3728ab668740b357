//! Rigid bodies and point masses.

use std::sync::Arc;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::surface::TriangulatedSurface;
use crate::{Mat3, Vec3};

/// A rigid body, or with `mass` alone, without `inertia`, `shape`, `attached` and `distributed`, a point mass.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RigidBody {
    /// Name of the body in joints and results.
    pub name: String,
    /// Mass centre in the reference configuration; of a body with the shape `stl` the place of the origin of the file, from which
    /// the mass centre follows (length).
    #[schemars(extend("x-marker" = "point"))]
    pub at: [f64; 3],
    /// Mass; of a body with a shape this or `density`. Kinematic analyses need none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub mass: Option<f64>,
    /// Moments of inertia J11, J22, J33 about the mass centre, along the axes of the body [mass·length²].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub inertia: Option<[f64; 3]>,
    /// Components J12, J13, J23 of the inertia tensor, `J12 = −∫ρ X1 X2 dV` [mass·length²]; 0 unless given.
    #[serde(default)]
    pub products_of_inertia: [f64; 3],
    /// Shape, from which the inertia is computed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shape: Option<BodyShape>,
    /// Density of a body with a shape [mass/length³].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub density: Option<f64>,
    /// Direction of the first axis of the body, and a second direction in the plane of the first two axes; the axes of space
    /// unless given.
    #[serde(default = "axes_of_space")]
    #[schemars(extend("x-marker" = "direction"))]
    pub axes: [[f64; 3]; 2],
    /// Node sets of the mesh whose nodes are fixed in the body, with their directors: a rigid patch of the shell. The body needs
    /// no mass of its own then.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub attached: Vec<String>,
    /// Sets of the mesh whose weighted mean motion the body follows, and to whose nodes it distributes its forces and moments: a
    /// distributing coupling (RBE3), which does not stiffen the shell. Nodes have the lengths or areas around them as weights. The body
    /// needs no mass of its own then.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub distributed: Vec<String>,
    /// Weights of the nodes of the `distributed` sets, a number for each set, in place of the lengths or areas around them. A node of several
    /// sets has the sum of their weights.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[schemars(transform = crate::checker::positive_entries)]
    pub weights: Vec<f64>,
    /// Velocity of the mass centre at the start [length/time].
    #[serde(default)]
    pub velocity: [f64; 3],
    /// Angular velocity at the start, along the axes of space [rad/time].
    #[serde(default)]
    pub angular_velocity: [f64; 3],
}

impl RigidBody {
    /// A body at rest with its axes along those of space; a point mass without moments of inertia.
    pub fn new(name: &str, at: [f64; 3], mass: f64, inertia: Option<[f64; 3]>) -> Self {
        Self {
            name: name.into(),
            at,
            mass: Some(mass),
            inertia,
            products_of_inertia: [0.0; 3],
            shape: None,
            density: None,
            axes: axes_of_space(),
            attached: Vec::new(),
            distributed: Vec::new(),
            weights: Vec::new(),
            velocity: [0.0; 3],
            angular_velocity: [0.0; 3],
        }
    }

    /// Whether it is a point mass, which has no axes.
    pub fn is_point_mass(&self) -> bool {
        self.mass.is_some() && self.inertia.is_none() && self.shape.is_none() && !self.is_on_nodes()
    }

    /// Whether nodes of the mesh are attached to it, or it follows their mean motion.
    pub fn is_on_nodes(&self) -> bool {
        !self.attached.is_empty() || !self.distributed.is_empty()
    }
}

/// Homogeneous body, by its axes 1, 2, 3.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "type", rename_all = "kebab-case")]
pub enum BodyShape {
    /// Box with sides along the axes.
    Box(BoxShape),
    /// Cylinder or, with `inner_radius`, tube about axis 1.
    Cylinder(CylinderShape),
    /// Ball.
    Sphere(SphereShape),
    /// Rod along axis 1 without inertia about it.
    Rod(RodShape),
    /// Solid within the closed surface of triangles in an STL file.
    Stl(StlShape),
}

/// Box with sides along the axes of the body.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BoxShape {
    /// Sides along the axes 1, 2, 3 (length).
    pub size: [f64; 3],
}

/// Cylinder or tube about axis 1 of the body.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CylinderShape {
    /// Outer radius (length).
    pub radius: f64,
    /// Inner radius (length); 0 unless given.
    #[serde(default)]
    pub inner_radius: f64,
    /// Length along axis 1.
    pub length: f64,
}

/// Ball.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SphereShape {
    /// Radius (length).
    pub radius: f64,
}

/// Thin rod along axis 1 of the body.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RodShape {
    /// Length along axis 1.
    pub length: f64,
}

/// Solid within the closed surface of an STL file, whose coordinates count along the axes of the body from its `at`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StlShape {
    /// Path of the file, relative to the model file; ASCII or binary.
    pub file: String,
    /// Factor on all coordinates of the file: 0.001 turns millimetres into metres.
    #[serde(default = "one")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub scale: f64,
    /// Surface in the units of the file. The library opens no files: the caller reads it.
    #[serde(skip)]
    pub surface: Option<Arc<TriangulatedSurface>>,
}

fn one() -> f64 {
    1.0
}

impl BodyShape {
    /// Volume (length³); 0 for rods.
    pub fn volume(&self) -> f64 {
        match self {
            Self::Box(BoxShape { size: [a, b, c] }) => a * b * c,
            Self::Cylinder(c) => {
                std::f64::consts::PI * (c.radius * c.radius - c.inner_radius * c.inner_radius) * c.length
            }
            Self::Sphere(SphereShape { radius }) => 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3),
            Self::Rod(_) => 0.0,
            Self::Stl(stl) => stl.surface.as_ref().map_or(0.0, |s| s.volume * stl.scale.powi(3)),
        }
    }

    /// Second moments ∫X Xᵀ dm of unit mass about the mass centre, along the axes 1, 2, 3 (length²).
    pub fn second_moments(&self) -> Mat3 {
        let diagonal = match self {
            Self::Box(BoxShape { size }) => size.map(|a| a * a / 12.0),
            Self::Cylinder(CylinderShape { radius, inner_radius, length }) => {
                let across = 0.25 * (radius * radius + inner_radius * inner_radius);
                [length * length / 12.0, across, across]
            }
            Self::Sphere(SphereShape { radius }) => [radius * radius / 5.0; 3],
            Self::Rod(RodShape { length }) => [length * length / 12.0, 0.0, 0.0],
            Self::Stl(stl) => {
                let surface = stl.surface.as_ref();
                return surface.map_or(Mat3::zeros(), |s| s.second_moments * (stl.scale * stl.scale));
            }
        };
        Mat3::from_diagonal(&Vec3::from(diagonal))
    }

    /// Mass centre along the axes 1, 2, 3, as seen from the place of the body (length).
    pub fn centre(&self) -> Vec3 {
        match self {
            Self::Stl(stl) => stl.surface.as_ref().map_or(Vec3::zeros(), |s| s.centre * stl.scale),
            Self::Box(_) | Self::Cylinder(_) | Self::Sphere(_) | Self::Rod(_) => Vec3::zeros(),
        }
    }

    /// Sizes of the shape, all above 0.
    pub(crate) fn sizes(&self) -> Vec<f64> {
        match self {
            Self::Box(BoxShape { size }) => size.to_vec(),
            Self::Cylinder(c) => vec![c.radius, c.length],
            Self::Sphere(SphereShape { radius }) => vec![*radius],
            Self::Rod(RodShape { length }) => vec![*length],
            Self::Stl(_) => Vec::new(),
        }
    }
}

/// First two axes of space.
pub(crate) fn axes_of_space() -> [[f64; 3]; 2] {
    [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]
}
