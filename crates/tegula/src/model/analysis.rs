//! Analyses of the model file: static, modal, buckling, transient.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{
    BucklingAnalysis, Condition, FrequencyResponse, InitialVelocity, Load, PathAnalysis, PrescribedStrain,
    ResponseInput, Scheme,
};

/// Analysis to run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "type", rename_all = "kebab-case")]
pub enum Analysis {
    /// Equilibrium under loads that grow from 0 to their full value.
    Static(StaticAnalysis),
    /// Equilibria along a path through limit points, under loads that grow and fall.
    Path(PathAnalysis),
    /// Natural frequencies and mode shapes.
    Modal(ModalAnalysis),
    /// Load factors of linear buckling and buckling modes.
    Buckling(BucklingAnalysis),
    /// Motion in time.
    Transient(TransientAnalysis),
}

/// One analysis of several that follow one another.
///
/// It starts at the state in which the step before has ended. Conditions, loads and prescribed strains of the whole model act in
/// every step, those of a step in this one only. A load that two steps in a row list with the same values continues. In a
/// static step new loads grow from 0, and loads that only the step before had fall to 0; in a transient step new loads
/// act from the start, and old ones are gone at once. Fixed components stay where they are at the start of the step. Joints of the
/// model act in every step, but for those that a step releases; those that it locks do not move in it.
/// A buckling step keeps all loads of the step before as they are; its own loads are those that the load factors multiply.
/// Each step has its own load factor from 0 to 1, or its own time from 0.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AnalysisStep {
    /// Name of the step, and of its folder among the results.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub name: String,
    /// Analysis of the step. A modal one vibrates about the state of the step before, under its supports and loads.
    pub analysis: Analysis,
    /// Supports and prescribed motions of this step, beside those of the whole model.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub conditions: Vec<Condition>,
    /// Loads of this step, beside those of the whole model.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub loads: Vec<Load>,
    /// Prescribed strains of this step, beside those of the whole model.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub prescribed_strains: Vec<PrescribedStrain>,
    /// Velocities that a transient step adds to those of its first state.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub initial_velocities: Vec<InitialVelocity>,
    /// Names of joints that do not act in this step: latches that open, bolts that are gone, drives that are switched off. In a static
    /// step their forces fall to 0 with the load factor, in a transient step they are gone at once. A joint acts again in a later step
    /// that does not release it, and its sides must meet there.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub released: Vec<String>,
    /// Names of joints whose two sides do not move against each other in this step: they stay as they are at its start. A joint that
    /// moves there stops at once, in a plastic impact, whose loss of kinetic energy counts as dissipated. The types `revolute`,
    /// `universal`, `spherical`, `cylindrical`, `screw`, `prismatic` and `planar` can be locked.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub locked: Vec<String>,
    /// Times (load factors) at which a step ends and a field file is written, like `output.at`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub at: Vec<f64>,
}

impl AnalysisStep {
    /// A step with the conditions and loads of the whole model.
    pub fn new(name: &str, analysis: Analysis) -> Self {
        Self {
            name: name.into(),
            analysis,
            conditions: Vec::new(),
            loads: Vec::new(),
            prescribed_strains: Vec::new(),
            initial_velocities: Vec::new(),
            released: Vec::new(),
            locked: Vec::new(),
            at: Vec::new(),
        }
    }
}

/// Static equilibrium.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StaticAnalysis {
    /// Small displacements: one solve with the tangent of the reference configuration.
    #[serde(default)]
    pub linear: bool,
    /// Iteration to equilibrium; unless given `mixed`, where a section yields `displacement`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub method: Option<NewtonMethod>,
    /// Load steps to begin with; a step that does not converge is cut back by itself.
    #[schemars(range(min = 1))]
    #[serde(default = "one")]
    pub load_steps: u32,
    /// Iterations after which a load step is cut back.
    #[schemars(range(min = 1))]
    #[serde(default = "thirty")]
    pub max_iterations: u32,
    /// Cut-backs after which the analysis ends.
    #[serde(default = "twelve")]
    pub max_cutbacks: u32,
    /// Accept an equilibrium at which the structure would buckle (tangent with negative pivots).
    #[serde(default)]
    pub allow_unstable: bool,
    /// Balance the loads of a model that supports do not hold by the inertia forces of its rigid acceleration.
    #[serde(default)]
    pub inertia_relief: bool,
    /// Solver of the linear systems.
    #[serde(default)]
    pub linear_solver: LinearSolver,
    /// Conditions at which the analysis ends before load factor 1.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub stop: Vec<StopCondition>,
    /// How the analysis continues behind a critical point, at which load steps end; left out: it ends there with an error.
    #[serde(default, rename = "continue", skip_serializing_if = "Option::is_none")]
    pub continuation: Option<Continuation>,
}

/// How a static analysis continues behind a critical point.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Continuation {
    /// Along the equilibrium path, whose load factor falls behind a limit point, by the arc-length method until load factor 1.
    Path,
}

/// Condition at which an analysis ends before its end: a column of the history crosses a value.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StopCondition {
    /// Name of a column of the history, such as `sensor.NAME.angle` or `body.NAME.y`.
    pub column: String,
    /// Value at which the analysis ends, in the unit of the column.
    pub value: f64,
    /// Direction in which the column crosses the value.
    #[serde(default)]
    pub direction: Crossing,
}

/// Direction in which a value is crossed.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Crossing {
    /// From below.
    Rising,
    /// From above.
    Falling,
    /// From below or from above.
    #[default]
    Either,
}

/// Solver of the linear systems.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum LinearSolver {
    /// Factors the matrix: fast while the factor fits in memory, and also for unstable equilibria.
    #[default]
    Direct,
    /// Conjugate gradients preconditioned by BDDC on subdomains: for large meshes and stable equilibria. Memory
    /// grows in proportion to the number of elements, CPU time with its power 1.08.
    Iterative,
}

impl Default for StaticAnalysis {
    fn default() -> Self {
        Self {
            linear: false,
            method: None,
            load_steps: one(),
            max_iterations: thirty(),
            max_cutbacks: twelve(),
            allow_unstable: false,
            inertia_relief: false,
            linear_solver: LinearSolver::Direct,
            stop: Vec::new(),
            continuation: None,
        }
    }
}

/// How equilibrium is iterated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum NewtonMethod {
    /// Newton with extrapolated stress resultants: few iterations and large steps on thin shells. Beyond yield the
    /// extrapolation misleads.
    Mixed,
    /// Displacement-based Newton.
    Displacement,
}

/// Natural frequencies.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ModalAnalysis {
    /// Number of modes wanted, rigid ones counted.
    #[schemars(range(min = 1))]
    pub modes: u32,
    /// Vibrate about the equilibrium under the loads instead of the reference configuration.
    #[serde(default)]
    pub prestressed: bool,
    /// Angular velocities of a model that turns, in place of that of its centrifugal load [rad/time]: the modes at each of them make a
    /// Campbell diagram, and those at the last one are the result.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub speeds: Vec<f64>,
    /// Modal damping: ratio of the damping of each mode to its critical one, beside `[damping]` and dampers. It acts in the response to
    /// `inputs`, not on the modes.
    #[schemars(range(min = 0.0))]
    #[serde(default)]
    pub damping_ratio: f64,
    /// Excitations whose small-signal response is wanted: the model is linearised to a state space, with the recorded points and the
    /// bodies as outputs.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub inputs: Vec<ResponseInput>,
    /// Steady-state response to each of the inputs, harmonic in time.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frequency_response: Option<FrequencyResponse>,
}

impl ModalAnalysis {
    /// The lowest modes about the reference configuration.
    pub fn new(modes: u32) -> Self {
        Self {
            modes,
            prestressed: false,
            speeds: Vec::new(),
            damping_ratio: 0.0,
            inputs: Vec::new(),
            frequency_response: None,
        }
    }
}

/// Motion in time.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TransientAnalysis {
    /// Time at which the analysis ends (time); it starts at 0.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub end_time: f64,
    /// Time integration scheme; in a model file without it `newmark`, but where the model has bodies, beams, joints, ties or springs
    /// `energy-momentum`, or `generalized-alpha` if a material yields.
    #[serde(default)]
    pub scheme: Scheme,
    /// Tolerance of automatic steps: RMS error of position per step over the size of the model.
    #[serde(default = "paper_tolerance")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub tolerance: f64,
    /// Constant time step (time); given, steps are not chosen automatically.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub time_step: Option<f64>,
    /// First automatic step (time); chosen from the initial acceleration unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub initial_step: Option<f64>,
    /// Largest automatic step (time).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub max_step: Option<f64>,
    /// Iterations after which a time step is repeated smaller.
    #[schemars(range(min = 1))]
    #[serde(default = "twenty")]
    pub max_iterations: u32,
    /// Small displacements: the tangent of the reference configuration throughout.
    #[serde(default)]
    pub linear: bool,
    /// Conditions at which the analysis ends before `end_time`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub stop: Vec<StopCondition>,
}

impl Analysis {
    /// Whether the analysis seeks equilibria under loads that grow with a load factor: statics and paths.
    pub fn seeks_equilibria(&self) -> bool {
        matches!(self, Self::Static(_) | Self::Path(_))
    }

    /// Conditions at which the analysis ends before its end.
    pub fn stop_conditions(&self) -> &[StopCondition] {
        match self {
            Self::Static(options) => &options.stop,
            Self::Path(options) => &options.stop,
            Self::Transient(options) => &options.stop,
            Self::Modal(_) | Self::Buckling(_) => &[],
        }
    }
}

impl TransientAnalysis {
    /// With automatic steps and the defaults of everything else.
    pub fn new(end_time: f64) -> Self {
        Self {
            end_time,
            scheme: Scheme::default(),
            tolerance: paper_tolerance(),
            time_step: None,
            initial_step: None,
            max_step: None,
            max_iterations: twenty(),
            linear: false,
            stop: Vec::new(),
        }
    }
}

fn one() -> u32 {
    1
}
fn twelve() -> u32 {
    12
}
fn twenty() -> u32 {
    20
}
fn thirty() -> u32 {
    30
}
fn paper_tolerance() -> f64 {
    1e-5
}
