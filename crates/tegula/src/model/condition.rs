//! Keys of supports, prescribed motions, loads, added masses, initial velocities.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Distribution;

/// A condition that needs nothing but a set.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct OnSet {
    /// Name of a node or edge set.
    pub on: String,
}

impl OnSet {
    /// Condition on a set.
    pub fn new(on: &str) -> Self {
        Self { on: on.into() }
    }
}

/// A plane of symmetry.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SymmetryPlane {
    /// Name of a node or edge set that lies in the plane.
    pub on: String,
    /// Normal of the plane, of any length and direction.
    #[schemars(extend("x-marker" = "direction"))]
    pub normal: [f64; 3],
}

/// Chosen components fixed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FixComponents {
    /// Name of a node or edge set.
    pub on: String,
    /// Components of position that are fixed.
    #[serde(default)]
    pub position: Vec<Axis>,
    /// Components of the director that are fixed.
    #[serde(default)]
    pub director: Vec<Axis>,
}

/// A component prescribed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PrescribeComponent {
    /// Name of a node or edge set.
    pub on: String,
    /// Which vector of the nodes.
    #[serde(default)]
    pub of: NodalVector,
    /// Which component.
    pub component: Axis,
    /// Change of the component from its reference value [length, or none for directors], times the amplitude.
    pub value: f64,
    /// Name of an amplitude; without one the value grows with the load factor in statics and holds from the start in transients.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub amplitude: Option<String>,
}

/// The vectors of a shell node.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum NodalVector {
    /// Position of the mid-surface.
    #[default]
    Position,
    /// Director (transverse gradient); at a fold the first one of the node, with which the others turn.
    Director,
    /// Gradient along the first tangent of the surface (`ancf-full` only).
    FirstGradient,
    /// Gradient along the second tangent of the surface (`ancf-full` only).
    SecondGradient,
}

/// Components of a vector.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Axis {
    /// First.
    X,
    /// Second.
    Y,
    /// Third.
    Z,
}

impl Axis {
    /// 0, 1 or 2.
    pub fn index(self) -> usize {
        self as usize
    }
}

/// A load given by a vector.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct VectorLoad {
    /// Name of the set: nodes for force and moment, edges for edge loads, quads (or `"all"`) for traction.
    pub on: String,
    /// The load as a vector `[x, y, z]` in global axes: force, moment, or either per length or area.
    pub value: [f64; 3],
    /// Factor on the value in each place: a formula in the coordinates `x`, `y` and `z` of the reference configuration, such as `"1 - z/2"`, or an array
    /// of the mesh file, such as `{ field = "p" }`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub distribution: Option<Distribution>,
    /// Name of an amplitude; without one the load grows with the load factor in statics and is constant in transients.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub amplitude: Option<String>,
}

impl VectorLoad {
    /// Load on a set, without amplitude.
    pub fn new(on: &str, value: [f64; 3]) -> Self {
        Self { on: on.into(), value, distribution: None, amplitude: None }
    }
}

/// A pressure.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PressureLoad {
    /// Name of a quad set, or `"all"`.
    #[serde(default = "all")]
    pub on: String,
    /// Pressure [force/area]; positive pushes against the director.
    pub value: f64,
    /// Factor on the value in each place: a formula in the coordinates `x`, `y` and `z` of the reference configuration, such as `"1 - z/2"`, or an array
    /// of the mesh file, such as `{ field = "p" }`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub distribution: Option<Distribution>,
    /// Name of an amplitude.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub amplitude: Option<String>,
}

/// Gravity.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GravityLoad {
    /// Acceleration of gravity [length/time²], such as `[0, 0, -9.81]`.
    pub value: [f64; 3],
    /// Name of an amplitude.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub amplitude: Option<String>,
}

/// Motion of the ground of a model that turns.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Ground {
    /// It stands still, as a bearing.
    #[default]
    Stands,
    /// It turns with the model, as a hub.
    Turns,
}

/// Centrifugal forces: the model turns about an axis at a constant angular velocity Ω, and is described in the frame that turns with it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CentrifugalLoad {
    /// Direction of the axis.
    #[schemars(extend("x-marker" = "direction"))]
    pub axis: [f64; 3],
    /// Point of the axis (length).
    #[serde(default)]
    #[schemars(extend("x-marker" = "point"))]
    pub at: [f64; 3],
    /// Angular velocity Ω [rad/time].
    pub velocity: f64,
    /// Whether supports, the ground of joints and that of springs stand still, or turn with the model. Modes about an equilibrium need a
    /// ground that turns, or one that holds the model on its axis in the same way in all directions.
    #[serde(default)]
    pub ground: Ground,
    /// Name of an amplitude, by which the forces, and so Ω², are multiplied.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub amplitude: Option<String>,
}

/// Mass in addition to that of the sections; it moves with the mid-surface.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "type", rename_all = "kebab-case")]
pub enum AddedMass {
    /// A mass at every node of a set (mass).
    Point(MassOn),
    /// A mass per length of an edge [mass/length].
    Edge(MassOn),
    /// A mass per area of a quad set [mass/area].
    Area(MassOn),
}

/// An added mass on a set.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MassOn {
    /// Name of the set.
    pub on: String,
    /// The mass, not negative.
    #[schemars(range(min = 0.0))]
    pub value: f64,
}

/// Velocity field at time 0: that of a rigid motion of the nodes of a set, of a body, of a beam or of the model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct InitialVelocity {
    /// Name of a node, edge or quad set, of a body or of a beam; `"all"` are all nodes of the mesh, `"model"` all of these and all bodies
    /// and beams.
    #[serde(default = "all")]
    pub on: String,
    /// Translation [length/time].
    #[serde(default)]
    pub velocity: [f64; 3],
    /// Rotation [1/time].
    #[serde(default)]
    pub angular_velocity: [f64; 3],
    /// Point about which it turns (length).
    #[serde(default)]
    #[schemars(extend("x-marker" = "point"))]
    pub center: [f64; 3],
}

fn all() -> String {
    "all".into()
}
