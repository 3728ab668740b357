//! Source of the mid-surface: generators and mesh files.
//!
//! All generators map a rectangle of parameters (u, v) to the surface and name
//! the same sets: edges `u_min`, `u_max`, `v_min`, `v_max` (as node and edge
//! sets), corners `u_min_v_min`, … and the node nearest the middle, `middle`.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::ArraysMesh;

/// Neighbouring facets that meet at a larger angle (degrees) form a fold.
pub const FOLD_ANGLE_DEGREES: f64 = 20.0;

/// The registry of mesh readers: one line for each format. Calls the macro `$made` with all entries. An entry is
///
/// ```text
/// file::Format: "help of the schema",
/// ```
///
/// - `crates/tegula-io/src/mesh/file.rs` defines the type `Format`, which implements `MeshReader`;
/// - `Format` becomes the variant of [`MeshSource`](crate::model::MeshSource) that holds the keys of mesh files, and its name
///   in kebab case the word of the model file.
///
/// The variants are made from it below, the modules and the choice of the reader in the crate `tegula-io`.
#[macro_export]
macro_rules! mesh_readers {
    ($made:ident) => {
        $made! {
            gmsh::Gmsh: "A Gmsh file (`.msh`, format 2.2 or 4.1, ASCII or binary); physical groups become sets.",
            abaqus::Abaqus: "An input file of Abaqus or CalculiX (`.inp`) with shells of four nodes; node and element sets become sets.",
            nastran::Nastran: "A bulk data file of Nastran (`.bdf`, `.nas`) with shells of four nodes; properties, supports and loads have sets.",
            vtu::Vtu: "A VTU file (`.vtu`) of VTK, ParaView or meshio with quadrilaterals; integer arrays become sets, numbers fields.",
        }
    };
}

macro_rules! mesh_source {
    ($($file:ident::$format:ident: $help:literal,)*) => {
        /// The mid-surface.
        #[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
        #[serde(tag = "type", rename_all = "kebab-case")]
        pub enum MeshSource {
            /// No shells: a model of bodies and joints alone.
            #[default]
            None,
            /// A rectangle; u along `u_axis`, v along `v_axis`.
            Plate(PlateMesh),
            /// A sector of a cylinder; u is the angle, v runs along the axis.
            Cylinder(CylinderMesh),
            /// A flat ring or sector of it in the plane z = 0; u is the radius, v the angle from the x axis.
            Annulus(AnnulusMesh),
            /// A patch of a sphere about the z axis; u is the longitude from the x axis, v the latitude from the equator.
            Sphere(SphereMesh),
            /// A polyline swept along a direction; u runs along the polyline, v along the direction.
            Extrusion(ExtrusionMesh),
            /// Nodes, elements and sets in the model itself.
            Arrays(ArraysMesh),
            $(#[doc = $help] $format(MeshFile),)*
        }

        impl MeshSource {
            /// Keys of a mesh file; `None` for generators.
            pub fn file(&self) -> Option<&MeshFile> {
                match self {
                    $(Self::$format(file) => Some(file),)*
                    _ => None,
                }
            }
        }
    };
}

mesh_readers!(mesh_source);

/// Grid of elements, common to all generators.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Grid {
    /// Number of elements along u and v, at least 1 each.
    #[schemars(inner(range(min = 1)))]
    pub elements: [u32; 2],
    /// Ratio of the last to the first element's length along u and v (1: all equal).
    #[serde(default = "ones")]
    #[schemars(transform = crate::checker::positive_entries)]
    pub grading: [f64; 2],
    /// Random shift of inner nodes within the surface, as a part of the element size (0…0.4).
    #[serde(default)]
    #[schemars(range(min = 0.0, max = 0.4))]
    pub distortion: f64,
    /// Seed of the random shift; the same seed gives the same mesh.
    #[serde(default)]
    pub seed: u64,
    /// Names for further points: each becomes a node set with the node nearest to the position.
    #[serde(default)]
    #[schemars(extend("x-marker" = "point"))]
    pub points: BTreeMap<String, [f64; 3]>,
    /// Nodes that coincide without being connected (the slit of a full ring): `true` merges them, `false` keeps them apart
    /// without a warning; unless given they stay apart with a warning.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub merge_coincident: Option<bool>,
}

impl Grid {
    /// A uniform grid of `u` by `v` elements.
    pub fn uniform(u: u32, v: u32) -> Self {
        Self {
            elements: [u, v],
            grading: ones(),
            distortion: 0.0,
            seed: 0,
            points: BTreeMap::new(),
            merge_coincident: None,
        }
    }
}

/// A rectangle.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PlateMesh {
    /// Corner u = v = 0 (length).
    #[serde(default)]
    #[schemars(extend("x-marker" = "point"))]
    pub origin: [f64; 3],
    /// Direction of u.
    #[serde(default = "x_axis")]
    #[schemars(extend("x-marker" = "direction"))]
    pub u_axis: [f64; 3],
    /// Direction of v, not parallel to u; the director is u × v.
    #[serde(default = "y_axis")]
    #[schemars(extend("x-marker" = "direction"))]
    pub v_axis: [f64; 3],
    /// Lengths along u and v (length).
    #[schemars(transform = crate::checker::positive_entries)]
    pub size: [f64; 2],
    /// Elements, grading, distortion, points.
    pub grid: Grid,
}

impl PlateMesh {
    /// Rectangle in the plane z = 0 with a corner at the origin, sides along x and y, and equal elements.
    pub fn new(size: [f64; 2], elements: [u32; 2]) -> Self {
        Self {
            origin: [0.0; 3],
            u_axis: x_axis(),
            v_axis: y_axis(),
            size,
            grid: Grid::uniform(elements[0], elements[1]),
        }
    }
}

/// A sector of a cylinder.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CylinderMesh {
    /// Point on the axis from which v is counted (length).
    #[serde(default)]
    #[schemars(extend("x-marker" = "point"))]
    pub center: [f64; 3],
    /// Direction of the axis and of v.
    #[serde(default = "y_axis")]
    #[schemars(extend("x-marker" = "direction"))]
    pub axis: [f64; 3],
    /// Radial direction of the angle 0; the part along the axis is ignored.
    #[serde(default = "z_axis")]
    #[schemars(extend("x-marker" = "direction"))]
    pub start: [f64; 3],
    /// Radius (length).
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub radius: f64,
    /// First and last angle (degrees), right-handed about the axis.
    pub angles: [f64; 2],
    /// Length along the axis (length).
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub length: f64,
    /// Elements, grading, distortion, points.
    pub grid: Grid,
}

/// A flat ring.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AnnulusMesh {
    /// Centre (length).
    #[serde(default)]
    #[schemars(extend("x-marker" = "point"))]
    pub center: [f64; 3],
    /// Inner and outer radius (length).
    #[schemars(transform = crate::checker::positive_entries)]
    pub radii: [f64; 2],
    /// First and last angle (degrees); a full turn leaves a slit.
    #[serde(default = "full_turn")]
    pub angles: [f64; 2],
    /// Elements, grading, distortion, points.
    pub grid: Grid,
}

/// A patch of a sphere.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SphereMesh {
    /// Centre (length).
    #[serde(default)]
    #[schemars(extend("x-marker" = "point"))]
    pub center: [f64; 3],
    /// Radius (length).
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub radius: f64,
    /// First and last longitude (degrees).
    #[serde(default = "quarter_turn")]
    pub longitudes: [f64; 2],
    /// First and last latitude (degrees), within −90…90 but not at a pole.
    pub latitudes: [f64; 2],
    /// Elements, grading, distortion, points.
    pub grid: Grid,
}

/// A swept polyline.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ExtrusionMesh {
    /// Vertices of the polyline (length), at least two; neighbours differ.
    #[schemars(extend("x-marker" = "point"))]
    pub vertices: Vec<[f64; 3]>,
    /// Sweep (length).
    pub sweep: [f64; 3],
    /// Elements along the whole polyline (shared out by length, at least one a segment) and along the sweep; grading and distortion.
    pub grid: Grid,
}

/// A mesh file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MeshFile {
    /// Path, relative to the model file.
    pub file: String,
    /// Factor on all coordinates.
    #[serde(default = "one")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub scale: f64,
    /// Names for further points: each becomes a node set with the node nearest to the position.
    #[serde(default)]
    #[schemars(extend("x-marker" = "point"))]
    pub points: BTreeMap<String, [f64; 3]>,
    /// Nodes that coincide without being connected, where parts were meshed apart: `true` merges them, `false` keeps them
    /// apart without a warning (a slit); unless given they stay apart with a warning.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub merge_coincident: Option<bool>,
    /// Angle (degrees), 1…180, from which on neighbouring elements form a fold and have directors of their
    /// own; 20 unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fold_angle: Option<f64>,
}

impl MeshFile {
    /// The mesh of a file as it is.
    pub fn new(file: &str) -> Self {
        Self {
            file: file.into(),
            scale: one(),
            points: BTreeMap::new(),
            merge_coincident: None,
            fold_angle: None,
        }
    }
}

impl MeshSource {
    /// Grid of a generated mesh; `None` for mesh files.
    pub fn grid(&self) -> Option<&Grid> {
        match self {
            Self::Plate(m) => Some(&m.grid),
            Self::Cylinder(m) => Some(&m.grid),
            Self::Annulus(m) => Some(&m.grid),
            Self::Sphere(m) => Some(&m.grid),
            Self::Extrusion(m) => Some(&m.grid),
            _ => None,
        }
    }

    /// Grid of a generated mesh, to be changed; `None` for mesh files.
    pub fn grid_mut(&mut self) -> Option<&mut Grid> {
        match self {
            Self::Plate(m) => Some(&mut m.grid),
            Self::Cylinder(m) => Some(&mut m.grid),
            Self::Annulus(m) => Some(&mut m.grid),
            Self::Sphere(m) => Some(&mut m.grid),
            Self::Extrusion(m) => Some(&mut m.grid),
            _ => None,
        }
    }

    /// Key `merge_coincident`: whether coincident nodes are merged.
    pub fn merge_coincident(&self) -> Option<bool> {
        match (self, self.file()) {
            (Self::Arrays(arrays), _) => arrays.merge_coincident,
            (_, Some(file)) => file.merge_coincident,
            (_, None) => self.grid().and_then(|grid| grid.merge_coincident),
        }
    }

    /// Key of [`Self::merge_coincident`].
    pub fn merge_key(&self) -> &'static str {
        if self.grid().is_none() { "mesh.merge_coincident" } else { "mesh.grid.merge_coincident" }
    }

    /// Key `fold_angle`; `None` where it is not given, and for generators.
    pub fn given_fold_angle(&self) -> Option<f64> {
        match self {
            Self::Arrays(arrays) => arrays.fold_angle,
            _ => self.file().and_then(|file| file.fold_angle),
        }
    }

    /// Angle (degrees) from which on neighbouring elements form a fold.
    pub fn fold_angle(&self) -> f64 {
        self.given_fold_angle().unwrap_or(FOLD_ANGLE_DEGREES)
    }
}

fn ones() -> [f64; 2] {
    [1.0; 2]
}
fn one() -> f64 {
    1.0
}
fn x_axis() -> [f64; 3] {
    [1.0, 0.0, 0.0]
}
fn y_axis() -> [f64; 3] {
    [0.0, 1.0, 0.0]
}
fn z_axis() -> [f64; 3] {
    [0.0, 0.0, 1.0]
}
fn full_turn() -> [f64; 2] {
    [0.0, 360.0]
}
fn quarter_turn() -> [f64; 2] {
    [0.0, 90.0]
}
