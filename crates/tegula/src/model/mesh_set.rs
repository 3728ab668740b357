//! Sets of the mesh that the model defines by places, directions, formulas or other sets.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A named part of the mesh that conditions, loads, sections and results may use like those of the mesh. It holds nodes, elements and edges:
///
/// - the nodes in the part of space that its keys describe,
/// - the elements with their centre in it,
/// - the edges of the boundary of the mesh with both ends and, up to a fifth of its length, the middle in it.
///
/// Union, intersection and difference combine the nodes, the elements and the edges of their sets, each by themselves.
///
/// Places are those of the mesh before imperfections.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "type", rename_all = "kebab-case")]
pub enum MeshSet {
    /// Everything in a box along the axes.
    Box(BoxSet),
    /// Everything on a plane; edges inside the mesh, too.
    Plane(PlaneSet),
    /// Everything in a sphere, or between two.
    Sphere(SphereSet),
    /// Everything in a cylinder, or between two.
    Cylinder(CylinderSet),
    /// Everything where inequalities in the coordinates hold.
    Formula(FormulaSet),
    /// Elements whose normal has a direction, and their nodes.
    Normal(NormalSet),
    /// Edges of the boundary, and their nodes.
    Boundary(BoundarySet),
    /// Everything in one of several sets.
    Union(CombinedSet),
    /// Everything in all of several sets.
    Intersection(CombinedSet),
    /// Everything in the first of several sets that is in none of the others.
    Difference(CombinedSet),
}

/// A box along the axes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BoxSet {
    /// Name of the set.
    pub name: String,
    /// Range of x (length); everything unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub x: Option<[f64; 2]>,
    /// Range of y (length); everything unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub y: Option<[f64; 2]>,
    /// Range of z (length); everything unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub z: Option<[f64; 2]>,
    /// Name of a set to choose from.
    #[serde(default = "everything")]
    pub within: String,
    /// Distance up to which places outside count as inside (length); a millionth of the size of the mesh unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tolerance: Option<f64>,
}

/// A plane.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PlaneSet {
    /// Name of the set.
    pub name: String,
    /// A point of the plane (length).
    #[schemars(extend("x-marker" = "point"))]
    pub at: [f64; 3],
    /// Direction normal to it.
    #[schemars(extend("x-marker" = "direction"))]
    pub normal: [f64; 3],
    /// Name of a set to choose from.
    #[serde(default = "everything")]
    pub within: String,
    /// Distance up to which places lie on the plane (length); a millionth of the size of the mesh unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tolerance: Option<f64>,
}

/// A sphere, or the space between two.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SphereSet {
    /// Name of the set.
    pub name: String,
    /// Its centre (length).
    #[schemars(extend("x-marker" = "point"))]
    pub at: [f64; 3],
    /// Its radius (length).
    pub radius: f64,
    /// Radius of a smaller sphere around the same centre that does not belong to it (length). Places on it do.
    #[serde(default)]
    pub inner_radius: f64,
    /// Name of a set to choose from.
    #[serde(default = "everything")]
    pub within: String,
    /// Distance up to which places outside count as inside (length); a millionth of the size of the mesh unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tolerance: Option<f64>,
}

/// An endless cylinder, or the space between two.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CylinderSet {
    /// Name of the set.
    pub name: String,
    /// A point of its axis (length).
    #[schemars(extend("x-marker" = "point"))]
    pub at: [f64; 3],
    /// Direction of its axis.
    #[schemars(extend("x-marker" = "direction"))]
    pub axis: [f64; 3],
    /// Its radius (length).
    pub radius: f64,
    /// Radius of a smaller cylinder about the same axis that does not belong to it (length). Places on it do.
    #[serde(default)]
    pub inner_radius: f64,
    /// Name of a set to choose from.
    #[serde(default = "everything")]
    pub within: String,
    /// Distance up to which places outside count as inside (length); a millionth of the size of the mesh unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tolerance: Option<f64>,
}

/// Inequalities in the coordinates.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FormulaSet {
    /// Name of the set.
    pub name: String,
    /// Inequalities between formulas in `x`, `y` and `z` with `<`, `<=`, `>` and `>=`, joined by `and` and `or`, of which `and` binds first:
    /// `"0 <= x < 0.5 and sqrt(y^2 + z^2) >= 2"`.
    #[serde(rename = "where")]
    pub condition: String,
    /// Name of a set to choose from.
    #[serde(default = "everything")]
    pub within: String,
    /// Distance up to which places count as on the surface where both sides are equal (length); a millionth of the size of the mesh unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tolerance: Option<f64>,
}

/// Elements by their normal.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NormalSet {
    /// Name of the set.
    pub name: String,
    /// Direction that the normals of the elements, on the side of the director, have.
    #[schemars(extend("x-marker" = "direction"))]
    pub direction: [f64; 3],
    /// Largest angle between the normal in the centre of an element and the direction (degrees).
    pub angle: f64,
    /// Name of a set to choose from.
    #[serde(default = "everything")]
    pub within: String,
}

/// The boundary of the mesh, or one of its closed lines.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BoundarySet {
    /// Name of the set.
    pub name: String,
    /// A point (length): of the closed lines of the boundary, such as the rims of holes, the one with the node nearest to it. Without it the
    /// whole boundary.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-marker" = "point"))]
    pub near: Option<[f64; 3]>,
    /// Name of a set of elements, the boundary of which is meant.
    #[serde(default = "everything")]
    pub within: String,
}

/// Other sets.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CombinedSet {
    /// Name of the set.
    pub name: String,
    /// Names of the sets: those of the mesh, and those that stand before this one.
    #[schemars(length(min = 1))]
    pub of: Vec<String>,
}

fn everything() -> String {
    "all".into()
}

impl MeshSet {
    /// Name of the set.
    pub fn name(&self) -> &String {
        match self {
            Self::Box(keys) => &keys.name,
            Self::Plane(keys) => &keys.name,
            Self::Sphere(keys) => &keys.name,
            Self::Cylinder(keys) => &keys.name,
            Self::Formula(keys) => &keys.name,
            Self::Normal(keys) => &keys.name,
            Self::Boundary(keys) => &keys.name,
            Self::Union(keys) | Self::Intersection(keys) | Self::Difference(keys) => &keys.name,
        }
    }
}
