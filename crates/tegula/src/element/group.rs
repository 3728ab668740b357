//! What the program asks of a group of elements of one type and section.

/// A nodal vector as stored in fields.
pub type Nodal = [f64; 3];

/// The motion at which elements are evaluated; displacements of all nodal vectors from the reference.
#[derive(Debug, Clone, Copy)]
pub enum Motion<'a> {
    /// A state: stress of the strain `s(u)`, with the rate `S(u) v` where damping acts.
    State {
        /// Displacements.
        u: &'a [Nodal],
        /// Velocities, needed where a group has a retardation time.
        velocity: Option<&'a [Nodal]>,
    },
    /// A step of the energy–momentum scheme: stress of `½(s_n + s_{n+1})` acting at `½(u_n + u_{n+1})`.
    Step {
        /// Displacements at the start of the step.
        old: &'a [Nodal],
        /// Displacements at its end.
        new: &'a [Nodal],
        /// Length of the step.
        dt: f64,
    },
}

/// Weights of the parts of a tangent `material · SᵀHS + geometric · Σ 2n A⊗I`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TangentWeights {
    /// dn/dδ = `stress` · H S; the material part is `force` times as much.
    pub stress: f64,
    /// Share of the change of the directions in a step.
    pub direction: f64,
    /// Factor of the internal force in the residual.
    pub force: f64,
    /// Factor of the velocity change per displacement change, for rate damping.
    pub rate: f64,
}

/// What the elements are evaluated with.
#[derive(Debug, Clone, Copy)]
pub struct Kinematics<'a> {
    /// Nodal vectors of the reference configuration.
    pub reference: &'a [Nodal],
    /// The motion.
    pub motion: Motion<'a>,
    /// Small displacements: strains linear in the displacement.
    pub linear: bool,
    /// Time (load factor) at which prescribed strains act.
    pub time: f64,
    /// What the materials remember and suffer.
    pub interior: Interior<'a>,
    /// Which nodal vectors keep their length; empty: none.
    pub unit: &'a [bool],
}

impl<'a> Kinematics<'a> {
    /// A motion; the assembly fills in what the materials remember.
    pub fn new(reference: &'a [Nodal], motion: Motion<'a>, linear: bool, time: f64) -> Self {
        Self { reference, motion, linear, time, interior: Interior::default(), unit: &[] }
    }
}

/// What acts inside of the elements besides their deformation.
#[derive(Debug, Clone, Copy, Default)]
pub struct Interior<'a> {
    /// Internal variables at the end of the last step: those of the group's elements one after another.
    pub history: &'a [f64],
    /// Factor of each field of prescribed strain of the model; empty: there are none.
    pub factors: &'a [f64],
}

/// What the number of an element from which on elements are evaluated is a multiple of.
pub const ALIGNMENT: usize = super::lanes::BATCH;

/// Elements of one type, evaluated together.
pub trait ElementGroup: Send + Sync {
    /// Name of the element type.
    fn name(&self) -> &'static str;
    /// Number of elements.
    fn len(&self) -> usize;
    /// True if there are none.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }
    /// Nodal vectors of an element.
    fn vectors(&self, element: usize) -> &[u32];
    /// Number of nodal vectors per element.
    fn vectors_per_element(&self) -> usize;
    /// Number of stress resultants per element.
    fn stresses_per_element(&self) -> usize;
    /// Scalar mass of the pairs of nodal vectors (lower triangle) of an element.
    fn mass(&self, element: usize) -> &[f64];
    /// Retardation time of rate damping.
    fn retardation_time(&self) -> f64;
    /// Internal forces of the elements from `first` on (a multiple of [`ALIGNMENT`]), one block of
    /// `3 · vectors_per_element` per element, as many as `forces` has room for; with `tangent` also the lower blocks
    /// of the tangent, whose geometric part takes the stress `stress` (of the motion where `None`).
    /// A `prescribed` increment adds `tangent · increment` to the force.
    fn evaluate(&self, k: &Kinematics, first: usize, forces: &mut [f64], tangent: Option<TangentRequest>);
    /// Stress resultants of the strains in which the group works.
    fn stresses(&self, k: &Kinematics, stresses: &mut [f64]);
    /// Stress extrapolated along an increment: `n ← n(motion) + weight · H S δ`.
    fn extrapolate(
        &self,
        k: &Kinematics,
        increment: &[Nodal],
        weights: &TangentWeights,
        stresses: &mut [f64],
    );
    /// Stored energy of each element (of the end of a step); `½ sᵀHs` for linear materials.
    fn energies(&self, k: &Kinematics, energies: &mut [f64]);
    /// Sampled strains of one element (at the end of a step).
    fn sampled_strains(&self, element: usize, k: &Kinematics) -> Vec<f64>;
    /// Rates `S(q) v` of the sampled strains of one element, at a state `q` with the velocity `v`.
    fn strain_rates(&self, element: usize, k: &Kinematics) -> Vec<f64>;
    /// Enhanced parameters and internal variables per element.
    fn history_per_element(&self) -> usize;
    /// Internal variables at the end of a step; returns the energy that the materials dissipated in it.
    fn update_history(&self, k: &Kinematics, history: &mut [f64]) -> f64;
    /// Power τ ṡᵀHṡ dissipated in each element.
    fn dissipation(&self, k: &Kinematics, power: &mut [f64]);
}

/// What a tangent is made with.
#[derive(Debug)]
pub struct TangentRequest<'a> {
    /// Weights of its parts.
    pub weights: TangentWeights,
    /// Stress of the geometric part, of all elements of the group; that of the motion where `None`.
    pub stress: Option<&'a [f64]>,
    /// Increment of prescribed coordinates, zero elsewhere.
    pub prescribed: Option<&'a [Nodal]>,
    /// Lower blocks, `9 · blocks` per element.
    pub blocks: &'a mut [f64],
}
