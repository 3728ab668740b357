//! The model as plain data, read from a model file or built in code.
//!
//! Every type here is both the Rust interface and the model-file format: the
//! keys of the TOML file are the field names, the JSON Schema is derived from
//! the same types, and the documentation of a key is its doc comment.

mod analysis;
mod arrays_mesh;
mod beam;
pub(crate) mod body;
mod buckling;
mod bushing;
mod condition;
mod curve_joint;
mod cut;
mod distribution;
mod element_kind;
mod foundation;
mod gear_joint;
mod imperfection;
pub mod joint;
pub mod loads;
mod mesh_set;
mod mesh_source;
mod path;
mod prescribed_strain;
mod response;
mod scheme;
mod second_side;
pub mod section;
mod sensor;
mod spring;
mod still;
pub mod supports;
pub mod surface;
mod tie;
mod units;

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

pub use crate::material::{
    Isotropic, Material, MooneyRivlin, NeoHookean, NeoHookeanForm, Orthotropic, Plastic, Strengths,
};
pub use analysis::*;
pub use arrays_mesh::*;
pub use beam::{Beam, BeamSection, BoxSection, CircularSection, RectangularSection, SectionConstants};
pub use body::*;
pub use buckling::{BucklingAnalysis, FactorSigns};
pub use bushing::Bushing;
pub use condition::*;
pub use curve_joint::CurveJoint;
pub use cut::Cut;
pub use distribution::{Distribution, FieldName};
pub use element_kind::ElementKind;
pub(crate) use element_kind::element_types;
pub use foundation::{AreaFoundation, Foundation, FoundationOn};
pub use gear_joint::GearJoint;
pub use imperfection::{
    FileImperfection, Imperfection, ModeImperfection, NodeDisplacement, RandomImperfection, WaveImperfection,
};
pub(crate) use joint::joints;
pub use joint::{
    AxisJoint, CoordinateJoint, DRIVE, DirectorJoint, DistanceJoint, DrivenAngleJoint, DrivenLengthJoint,
    Joint, JointDrive, JointFriction, JointKeys, JointStops, PointJoint, RackJoint, ScrewJoint, TwoAxesJoint,
};
pub use loads::{Load, LoadStiffness, NodalLoad};
pub use mesh_set::{
    BoundarySet, BoxSet, CombinedSet, CylinderSet, FormulaSet, MeshSet, NormalSet, PlaneSet, SphereSet,
};
pub use mesh_source::*;
pub use path::{AllBranches, Branches, PathAnalysis, PathEnd, PathMethod};
pub use prescribed_strain::*;
pub use response::{FrequencyResponse, ResponseInput, Spacing};
pub(crate) use scheme::schemes;
pub use scheme::*;
pub use second_side::SecondSide;
pub use section::{Layup, LayupPly, Section, StackedPly};
pub use sensor::{
    AngleSensor, DistanceSensor, PointSensor, ReactionSensor, Sensor, StrainSensor, VolumeSensor,
};
pub use spring::{SpringDamper, TorsionSpring};
pub use still::{PICTURES, PIXELS, Still};
pub use supports::Condition;
pub use surface::TriangulatedSurface;
pub use tie::Tie;
pub use units::Units;

/// A whole model: mesh, materials, sections, conditions, loads, analysis, output.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(title = "tegula model")]
pub struct Model {
    /// One line that describes the model; it appears in results and pictures.
    #[serde(default)]
    pub title: String,
    /// Analysis to run; a model has this or `steps`.
    #[serde(default = "no_analysis")]
    pub analysis: Analysis,
    /// Analyses that follow one another, each from the state at the end of the one before: preload, then modes, then motion.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub steps: Vec<AnalysisStep>,
    /// The mid-surface: a generator or a mesh file; none in models of bodies alone.
    #[serde(default)]
    pub mesh: MeshSource,
    /// Sets of nodes, elements and edges in addition to those of the mesh.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub sets: Vec<MeshSet>,
    /// Materials by name.
    #[serde(default)]
    pub materials: BTreeMap<String, Material>,
    /// Which elements, material and thickness the parts of the mesh have.
    #[serde(default)]
    pub sections: Vec<Section>,
    /// Rigid bodies and point masses.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub bodies: Vec<RigidBody>,
    /// Beams.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub beams: Vec<Beam>,
    /// Joints between bodies, nodes and the ground.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub joints: Vec<Joint>,
    /// Springs with dampers.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub springs: Vec<SpringDamper>,
    /// Supports and prescribed motions.
    #[serde(default)]
    pub conditions: Vec<Condition>,
    /// Loads.
    #[serde(default)]
    pub loads: Vec<Load>,
    /// Torsion springs with dampers.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub torsion_springs: Vec<TorsionSpring>,
    /// Bushings: stiffness and damping of all six relative motions of two bodies.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub bushings: Vec<Bushing>,
    /// Ties of meshes whose nodes do not match.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub ties: Vec<Tie>,
    /// Elastic foundations.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub foundations: Vec<Foundation>,
    /// Sensors: quantities of the motion that are recorded.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub sensors: Vec<Sensor>,
    /// Masses in addition to those of the sections.
    #[serde(default)]
    pub masses: Vec<AddedMass>,
    /// Velocities at the start of a transient analysis.
    #[serde(default)]
    pub initial_velocities: Vec<InitialVelocity>,
    /// Rayleigh damping of the whole model.
    #[serde(default)]
    pub damping: Damping,
    /// Strains without stress (heat, growth), and stresses without strain.
    #[serde(default)]
    pub prescribed_strains: Vec<PrescribedStrain>,
    /// Deviations of the reference geometry of the mesh from the nominal one.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub imperfections: Vec<Imperfection>,
    /// Functions of time by name, used by loads and prescribed motions.
    #[serde(default)]
    pub amplitudes: BTreeMap<String, Amplitude>,
    /// Results to write.
    #[serde(default)]
    pub output: Output,
}

impl Model {
    /// A model of one isotropic material and section on a mesh, without supports and loads.
    pub fn new(mesh: MeshSource, analysis: Analysis, material: Isotropic, thickness: f64) -> Self {
        Self {
            title: String::new(),
            analysis,
            steps: Vec::new(),
            mesh,
            sets: Vec::new(),
            materials: BTreeMap::from([("m".to_string(), Material::Isotropic(material))]),
            sections: vec![Section::new("m", thickness)],
            bodies: Vec::new(),
            beams: Vec::new(),
            joints: Vec::new(),
            springs: Vec::new(),
            torsion_springs: Vec::new(),
            bushings: Vec::new(),
            ties: Vec::new(),
            foundations: Vec::new(),
            sensors: Vec::new(),
            conditions: Vec::new(),
            loads: Vec::new(),
            masses: Vec::new(),
            initial_velocities: Vec::new(),
            damping: Damping::default(),
            prescribed_strains: Vec::new(),
            imperfections: Vec::new(),
            amplitudes: BTreeMap::new(),
            output: Output::default(),
        }
    }
}

impl Model {
    /// Whether the model has bodies, beams, joints, ties or springs, which not all schemes of time integration move.
    pub fn is_mechanism(&self) -> bool {
        let none = self.bodies.is_empty() && self.beams.is_empty() && self.joints.is_empty();
        !(none && self.ties.is_empty()) || self.has_springs()
    }

    /// Whether the model has springs between bodies, nodes and the ground.
    pub fn has_springs(&self) -> bool {
        !(self.springs.is_empty() && self.torsion_springs.is_empty() && self.bushings.is_empty())
    }

    /// Whether springs may exert forces in the reference configuration.
    pub fn has_preloaded_springs(&self) -> bool {
        self.springs.iter().any(|spring| spring.length.is_some() || spring.force.is_some())
            || self.torsion_springs.iter().any(|spring| spring.free_angle != 0.0 || spring.moment.is_some())
            || self.bushings.iter().any(|bushing| bushing.free != [0.0; 6])
    }

    /// A model of bodies and joints alone.
    pub fn of_bodies(analysis: Analysis, bodies: Vec<RigidBody>, joints: Vec<Joint>) -> Self {
        let unused = Isotropic::new(1.0, 0.0, 1.0);
        let model = Self::new(MeshSource::None, analysis, unused, 1.0);
        Self { materials: BTreeMap::new(), sections: Vec::new(), bodies, joints, ..model }
    }
}

/// Membrane parts of the bilinear elements.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, Hash, Default, PartialOrd, Ord, Serialize, Deserialize, JsonSchema,
)]
#[serde(rename_all = "kebab-case")]
pub enum Membrane {
    /// Four enhanced assumed strains (the paper's). Stretched elements lose stability in bending.
    Eas,
    /// `eas` with a limited geometric stiffness of the hourglass motion in elements longer than twice their width.
    #[default]
    StableEas,
    /// Membrane strains of MITC4+ with four enhanced strains: `eas` on flat elements, no membrane locking of warped ones.
    #[serde(rename = "mitc4+")]
    Mitc4Plus,
    /// Assumed in-plane shear without parameters, for rubber in tension.
    AssumedShear,
    /// Strains of the displacements alone; too stiff in in-plane bending.
    Displacement,
}

impl Membrane {
    /// Every membrane part.
    pub const ALL: [Self; 5] =
        [Self::Eas, Self::StableEas, Self::Mitc4Plus, Self::AssumedShear, Self::Displacement];

    /// Name in model files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Eas => "eas",
            Self::StableEas => "stable-eas",
            Self::Mitc4Plus => "mitc4+",
            Self::AssumedShear => "assumed-shear",
            Self::Displacement => "displacement",
        }
    }

    /// Number of enhanced parameters.
    pub fn parameters(self) -> usize {
        match self {
            Self::Eas | Self::StableEas | Self::Mitc4Plus => 4,
            Self::AssumedShear | Self::Displacement => 0,
        }
    }
}

/// Rayleigh damping of the whole model.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Damping {
    /// Rayleigh factor of the mass matrix [1/time]: force −α M v.
    #[serde(default)]
    #[schemars(range(min = 0.0))]
    pub mass: f64,
    /// Rayleigh factor of the stiffness (time). It acts on strain rates, so rigid motion is
    /// not damped; for small motions it is −β K v. Added to `retardation_time` of each section.
    #[serde(default)]
    #[schemars(range(min = 0.0))]
    pub stiffness: f64,
}

/// A function of time (of the load factor 0…1 in statics).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "type", rename_all = "kebab-case")]
pub enum Amplitude {
    /// One value at all times.
    Constant(ConstantAmplitude),
    /// From 0 at `start` linearly to 1 at `end`, constant before and after.
    Ramp(RampAmplitude),
    /// Straight lines between given points, constant before and after.
    Table(TableAmplitude),
    /// Smooth curve (cubic spline) through given points.
    Spline(SplineAmplitude),
    /// A formula in `t`.
    Expression(ExpressionAmplitude),
}

/// One value at all times.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ConstantAmplitude {
    /// The value.
    pub value: f64,
}

/// From 0 at `start` linearly to 1 at `end`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RampAmplitude {
    /// Time at which the ramp leaves 0.
    #[serde(default)]
    pub start: f64,
    /// Time at which the ramp reaches 1.
    pub end: f64,
}

/// Straight lines between given points.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TableAmplitude {
    /// Times, ascending.
    pub times: Vec<f64>,
    /// Values at those times.
    pub values: Vec<f64>,
}

/// Cubic spline: a curve through given points whose second derivative is continuous.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SplineAmplitude {
    /// Times, ascending.
    pub times: Vec<f64>,
    /// Values at those times.
    pub values: Vec<f64>,
    /// Rates at the first and the last time, with which the curve continues straight before and after.
    #[serde(default)]
    pub rates: [f64; 2],
}

/// A formula in `t`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ExpressionAmplitude {
    /// Formula such as `"sin(2*PI*t)"`; operators `+ - * / ^`, functions `sin cos tan exp ln sqrt tanh …`, constants `PI`, `E`.
    pub expression: String,
}

/// Results that a run writes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Output {
    /// Points whose motion is recorded at every step.
    #[serde(default)]
    pub points: Vec<OutputPoint>,
    /// Cuts whose section forces and moments are recorded at every step.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub cuts: Vec<Cut>,
    /// Fields in the VTU files; all but `ply-stress` unless given.
    #[serde(default = "all_fields")]
    pub fields: Vec<Field>,
    /// Time (load factor) between two field files; 0 writes every step. Unless this or `every` is given, at most 200 files
    /// are written, evenly in time. The first and the last state are always written.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0))]
    pub interval: Option<f64>,
    /// Number of steps from one field file to the next, instead of `interval`.
    #[schemars(range(min = 1))]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub every: Option<u32>,
    /// Times (load factors) at which a step ends and a field file is written, whatever `interval` or `every` says.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub at: Vec<f64>,
    /// Field files hold the deformed mesh instead of the reference one, which *Warp By Vector* deforms.
    #[serde(default)]
    pub deformed: bool,
    /// Names of units for the labels of pictures.
    #[serde(default)]
    pub units: Units,
    /// Draw pictures (`*.png`) at the end of the run; true unless given.
    #[serde(default = "yes")]
    pub pictures: bool,
    /// Pictures whose field, view and scale are given, in addition to `pictures`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub stills: Vec<Still>,
}

impl Default for Output {
    fn default() -> Self {
        Self {
            points: Vec::new(),
            cuts: Vec::new(),
            fields: all_fields(),
            interval: None,
            every: None,
            at: Vec::new(),
            deformed: false,
            units: Units::default(),
            pictures: true,
            stills: Vec::new(),
        }
    }
}

/// A point whose motion is recorded.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct OutputPoint {
    /// Name of the point in histories, plots and `summary.json`.
    pub name: String,
    /// Name of a node set with exactly one node.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub on: Option<String>,
    /// Position in the reference configuration (length); the nearest node is taken.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-marker" = "point"))]
    pub at: Option<[f64; 3]>,
}

/// Fields of the result files.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Field {
    /// Displacement of the nodes (length).
    Displacement,
    /// Director at the nodes.
    Director,
    /// Velocity of the nodes [length/time].
    Velocity,
    /// Reactions at the nodes: force, and moment of the forces on directors.
    Reaction,
    /// Membrane resultants n_xx, n_yy, n_xy in the element's cross-section frame [force/length].
    Membrane,
    /// Bending resultants m_xx, m_yy, m_xy in the element's cross-section frame (force).
    Bending,
    /// Transverse shear resultants q_xz, q_yz in the element's cross-section frame [force/length].
    Shear,
    /// In-plane stresses at the top and bottom surface [force/area].
    SurfaceStress,
    /// Greatest von Mises stress of top, middle and bottom [force/area].
    VonMises,
    /// Strain energy per reference area [energy/area].
    EnergyDensity,
    /// Stresses σ11, σ22, τ12 at the bottom, the middle and the top of each ply, in its axes [force/area].
    PlyStress,
    /// Tsai–Wu index, reserve factor and greatest stress over strength of the worst ply, and its number from the bottom;
    /// where materials have strengths.
    Failure,
    /// Greatest equivalent plastic strain; where materials are plastic.
    PlasticStrain,
    /// Principal stresses in the plane at the top and bottom surface, the greater one first, and the angle from x to its
    /// direction [force/area, degrees].
    PrincipalStress,
    /// Means over the elements at a node, weighted by area: von Mises stress, and the stresses at the top and bottom surface
    /// in the axes of space [force/area].
    NodalMeans,
    /// Axes x, y, z of each element's cross-section frame at the reference.
    Axes,
    /// Numbers of nodes and elements as messages use them, and number of the section from 1.
    Numbers,
}

fn all_fields() -> Vec<Field> {
    use Field::*;
    vec![
        Displacement,
        Director,
        Velocity,
        Reaction,
        Membrane,
        Bending,
        Shear,
        SurfaceStress,
        VonMises,
        EnergyDensity,
        Failure,
        PlasticStrain,
        PrincipalStress,
        NodalMeans,
        Axes,
        Numbers,
    ]
}
/// Analysis of a model with steps, which is not looked at.
fn no_analysis() -> Analysis {
    Analysis::Static(StaticAnalysis::default())
}
fn all() -> String {
    "all".into()
}
fn yes() -> bool {
    true
}
