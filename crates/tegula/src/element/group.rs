//! Interface of a group of elements of one type and section: forces, tangent, mass, energy, history variables,
//! Kelvin–Voigt damping.

use serde::{Deserialize, Serialize};

use super::power_series::PowerSeries;
use crate::{Mat3, Vec3};

/// Components of a nodal vector, as stored in fields.
pub type Nodal = [f64; 3];

/// Motion at which elements are evaluated, as displacements of all nodal vectors from the reference configuration.
#[derive(Debug, Clone, Copy)]
pub enum Motion<'a> {
    /// A state: stress of the strain `s(u)`, with the strain rate `B(u) v` where Kelvin–Voigt damping acts.
    State {
        /// Displacements.
        u: &'a [Nodal],
        /// Velocities, needed where a group has a retardation time.
        velocity: Option<&'a [Nodal]>,
    },
    /// A step of the energy–momentum scheme: the stress of the mean strain `½(s_n + s_{n+1})` acts in the mid-step
    /// configuration `½(u_n + u_{n+1})`.
    Step {
        /// Displacements at the start of the step.
        old: &'a [Nodal],
        /// Displacements at its end.
        new: &'a [Nodal],
        /// Length of the step.
        dt: f64,
    },
}

/// Weights of the parts of a tangent `material · BᵀHB + geometric · Σ 2n A⊗I`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct TangentWeights {
    /// Weight of the stress increment, dn/dδ = `stress` · H B; the material part is `force` times as much.
    pub stress: f64,
    /// Change of the base vectors (of the configuration in which the stress acts) per change of the displacement; the
    /// geometric part is `force` times as much.
    pub direction: f64,
    /// Factor of the internal force in the residual.
    pub force: f64,
    /// Velocity change per displacement change, for Kelvin–Voigt damping.
    pub rate: f64,
    /// Weight of the augmented Lagrangian `γ GᵀG` of constraints, per inertia [1/time²].
    pub augmentation: f64,
    /// Weight of the augmented Lagrangian in statics [force/length].
    pub penalty: f64,
    /// Weight of the geometric stiffness `Σ λ ∂²g/∂q²` of constraints. It decides about the stability of equilibria; in singular
    /// positions, where the multipliers jump, it would lead astray.
    pub multiplier: f64,
}

impl TangentWeights {
    /// Weights of the material part alone.
    pub const MATERIAL: Self = Self { direction: 0.0, multiplier: 0.0, ..Self::STATIC };

    /// Weights of the geometric stiffness alone.
    pub const GEOMETRIC: Self = Self { stress: 0.0, ..Self::STATIC };

    /// Weights of the static tangent: stress, current configuration and follower loads of one state, no rates.
    pub const STATIC: Self = Self {
        stress: 1.0,
        direction: 1.0,
        force: 1.0,
        rate: 0.0,
        augmentation: 0.0,
        penalty: 0.0,
        multiplier: 1.0,
    };
}

/// Evaluation point of a group of elements: motion, history variables and factors of the prescribed strains.
#[derive(Debug, Clone, Copy)]
pub struct GroupPoint<'a> {
    /// Nodal vectors of the reference configuration.
    pub reference: &'a [Nodal],
    /// Motion: a state or a step.
    pub motion: Motion<'a>,
    /// Geometrically linear analysis: strains linear in the displacement.
    pub linear: bool,
    /// History variables and factors of the prescribed strains.
    pub interior: InternalVariables<'a>,
    /// Flags of the inextensible directors among the nodal vectors; empty: none.
    pub inextensible: &'a [bool],
    /// Lagrange multipliers of all constraints.
    pub multipliers: &'a [f64],
    /// Time (load factor) at which forces act; not before 0.
    pub time: f64,
    /// Value of the drive of each joint at the time at which forces act; 0 for joints without one.
    pub drives: &'a [f64],
    /// Part of the forces that springs and bushings have in the reference configuration which acts: 1 but in load steps before load factor 0.
    pub preload: f64,
}

/// History (internal) variables and factors of the prescribed strains: they determine the stress besides the
/// deformation.
#[derive(Debug, Clone, Copy)]
pub struct InternalVariables<'a> {
    /// Committed history variables (end of the last step) of the group, element by element: enhanced parameters and
    /// internal variables.
    pub history: &'a [f64],
    /// Factor of each prescribed strain field of the model; empty: there are none.
    pub factors: &'a [f64],
}

/// Batch alignment: the first element of a batch is a multiple of this.
pub const ALIGNMENT: usize = super::lanes::BATCH;

/// Contributions of one kind to forces, tangent, mass and energy, evaluated together: the elements of one type and section,
/// director-angle constraints, joints, springs. What a kind does not have (strains, mass, history variables) it leaves to
/// the default.
pub trait ElementGroup: Send + Sync {
    /// Name of the element type.
    fn name(&self) -> &'static str;
    /// Number of elements.
    fn len(&self) -> usize;
    /// True if there are none.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }
    /// Connectivity: nodal vectors of an element.
    fn vectors(&self, element: usize) -> &[u32];
    /// Whether forces may have a resultant, which the ground takes.
    fn acts_on_ground(&self) -> bool {
        false
    }
    /// Whether an element resists rigid motions of its nodal vectors: the ground holds it.
    fn is_grounded(&self, element: usize) -> bool {
        let _ = element;
        false
    }
    /// Whether forces depend on the time by themselves: springs with a formula in the time, which supply energy.
    fn has_actuators(&self) -> bool {
        false
    }
    /// Number of nodal vectors per element.
    fn vectors_per_element(&self) -> usize;
    /// Number of generalised stresses per element, work-conjugate to its strains.
    fn stresses_per_element(&self) -> usize {
        0
    }
    /// Power series of the forces along a path of equilibria; `None` where strains are not quadratic or the material is not linear.
    fn power_series(&self) -> Option<&dyn PowerSeries> {
        None
    }
    /// Mass matrix of an element: one scalar per pair of nodal vectors, lower triangle by rows.
    fn mass(&self, element: usize) -> &[f64] {
        let _ = element;
        &[]
    }
    /// Retardation time τ of Kelvin–Voigt damping.
    fn retardation_time(&self) -> f64 {
        0.0
    }
    /// Whether forces depend on velocities.
    fn has_rate_damping(&self) -> bool {
        self.retardation_time() != 0.0
    }
    /// Internal forces of a batch of elements: from `first` on (a multiple of [`ALIGNMENT`]) as many as `forces` has
    /// room for, one block of `3 · vectors_per_element` each. With `tangent` also the lower-triangle blocks of the
    /// tangent, whose geometric part takes [`TangentRequest::stress`] (the stress of the motion where `None`); an
    /// increment [`TangentRequest::prescribed`] adds `tangent · increment` to the force.
    fn evaluate(&self, k: &GroupPoint, first: usize, forces: &mut [f64], tangent: Option<TangentRequest>);
    /// Forces `B·n₁` and geometric stiffness `Σ n₁ₖ ∂²sₖ/∂q²` of the stresses n₁ that an increment produces linearly, in the configuration
    /// of the motion, for a batch of elements as in [`evaluate`](Self::evaluate). The multipliers of the evaluation point are those of the
    /// increment. Forces of groups with generalised stresses are left open: they are `K q` with the blocks K.
    fn evaluate_stresses(
        &self,
        k: &GroupPoint,
        increment: &StressIncrement,
        first: usize,
        (forces, blocks): (&mut [f64], &mut [f64]),
    ) {
        let weights = TangentWeights::GEOMETRIC;
        let request = TangentRequest { weights, stress: Some(increment.stress), prescribed: None, blocks };
        self.evaluate(k, first, forces, Some(request));
    }
    /// Forces `Bᵀ n` of generalised stresses n of an element, those of the motion where `None`, in the configuration of the motion. `false`, and
    /// nothing written, where they follow from the geometric stiffness only.
    fn forces_of_stresses(
        &self,
        k: &GroupPoint,
        element: usize,
        stresses: Option<&[f64]>,
        forces: &mut [f64],
    ) -> bool {
        let _ = (k, element, stresses, forces);
        false
    }
    /// Generalised stresses, work-conjugate to the strains in which the group works (sampled strains or quadratic
    /// forms).
    fn stresses(&self, k: &GroupPoint, stresses: &mut [f64]) {
        let _ = (k, stresses);
    }
    /// Generalised stresses extrapolated along an increment: `n ← n(motion) + weight · H B δ`.
    fn extrapolate(
        &self,
        k: &GroupPoint,
        increment: &[Nodal],
        weights: &TangentWeights,
        stresses: &mut [f64],
    ) {
        let _ = (k, increment, weights, stresses);
    }
    /// Reason why an element has no finite forces or tangent in a motion, as a sentence without a full stop; `None` where they are finite or
    /// the cause lies elsewhere.
    fn reason_without_forces(&self, k: &GroupPoint, element: usize) -> Option<String> {
        let _ = (k, element);
        None
    }
    /// An element whose force does not grow with the elongation in a state, as a sentence without a full stop; `None` where there is none.
    fn falling_force(&self, k: &GroupPoint) -> Option<String> {
        let _ = k;
        None
    }
    /// A pole of the force law of an element between the ends of a motion, which starts at a time, as a sentence without a full stop; `None`
    /// where there is none.
    fn pole_in_step(&self, k: &GroupPoint, start: f64) -> Option<String> {
        let _ = (k, start);
        None
    }
    /// Stored energy of each element (at the end of a step); `½ sᵀHs` for linear materials.
    fn energies(&self, k: &GroupPoint, energies: &mut [f64]) {
        let _ = k;
        energies.fill(0.0);
    }
    /// Energies ½ δs·H δs of the elements in a small motion δ about a state, with its strains δs = B δ: the material part of ½ δ·K δ. Groups of
    /// strains compute these strains, since the products of stiff blocks cancel where a motion strains little.
    fn material_energies(&self, k: &GroupPoint, motion: &[Nodal], energies: &mut [f64]) {
        let n = self.vectors_per_element();
        let size = 9 * n * (n + 1) / 2;
        let (mut forces, mut blocks) = (vec![0.0; 3 * n * self.len()], vec![0.0; size * self.len()]);
        let weights = TangentWeights::MATERIAL;
        let request = TangentRequest { weights, stress: None, prescribed: None, blocks: &mut blocks };
        self.evaluate(k, 0, &mut forces, Some(request));
        for (element, energy) in energies.iter_mut().enumerate() {
            let vectors = self.vectors(element);
            let value = |a: usize| Vec3::from(motion[vectors[a] as usize]);
            *energy = energy_of_blocks(&blocks[element * size..(element + 1) * size], value, n);
        }
    }
    /// Gradients, by the nodal vectors of an element, of strains that each have a stiffness of their own: they prevent rigid motions, also where the
    /// forces of much stiffer strains hide theirs in round-off. None where forces alone tell.
    fn resisted_strains(&self, element: usize, k: &GroupPoint) -> Vec<Vec<Vec3>> {
        let _ = (element, k);
        Vec::new()
    }
    /// Sampled strains of one element (at the end of a step).
    fn sampled_strains(&self, element: usize, k: &GroupPoint) -> Vec<f64> {
        let _ = (element, k);
        Vec::new()
    }
    /// Rates `B(q) v` of the sampled strains of one element, at a state `q` with the velocity `v`.
    fn strain_rates(&self, element: usize, k: &GroupPoint) -> Vec<f64> {
        let _ = (element, k);
        Vec::new()
    }
    /// Number of history variables per element: enhanced parameters and internal variables.
    fn history_per_element(&self) -> usize {
        0
    }
    /// Computes the history variables at the end of a step; returns the energy that the materials dissipate in it.
    fn update_history(&self, k: &GroupPoint, history: &mut [f64]) -> f64 {
        let _ = (k, history);
        0.0
    }
    /// Power τ ṡᵀHṡ that Kelvin–Voigt damping dissipates in each element.
    fn dissipation(&self, k: &GroupPoint, power: &mut [f64]) {
        let _ = k;
        power.fill(0.0);
    }
    /// Work that actuators do on the model in a step.
    fn work_of_actuators(&self, k: &GroupPoint) -> f64 {
        let _ = k;
        0.0
    }
}

/// Linear increment of a state: displacements, and the generalised stresses that they and prescribed strains produce.
#[derive(Debug, Clone, Copy)]
pub struct StressIncrement<'a> {
    /// Displacements of all nodal vectors.
    pub displacements: &'a [Nodal],
    /// Generalised stresses of all elements of the group; empty where it has none.
    pub stress: &'a [f64],
}

/// Request for the tangent: weights, stress of the geometric part, output buffer.
#[derive(Debug)]
pub struct TangentRequest<'a> {
    /// Weights of the parts of the tangent.
    pub weights: TangentWeights,
    /// Generalised stresses of the geometric part, for all elements of the group; `None`: stress of the motion.
    pub stress: Option<&'a [f64]>,
    /// Increment of the prescribed degrees of freedom, zero elsewhere.
    pub prescribed: Option<&'a [Nodal]>,
    /// Output: 3×3 blocks of the lower triangle, `9 · blocks` values per element.
    pub blocks: &'a mut [f64],
}

/// Energy ½ δ·K δ of an element by the lower blocks of its tangent K.
pub fn energy_of_blocks(blocks: &[f64], value: impl Fn(usize) -> Vec3, n: usize) -> f64 {
    let forces = forces_of_blocks(blocks, &value, n);
    forces.iter().enumerate().map(|(a, f)| 0.5 * f.dot(&value(a))).sum()
}

/// Product of the lower blocks of an element's tangent with its nodal vectors.
pub fn forces_of_blocks(blocks: &[f64], value: impl Fn(usize) -> Vec3, n: usize) -> Vec<Vec3> {
    let mut out = vec![Vec3::zeros(); n];
    let pairs = (0..n).flat_map(|a| (0..=a).map(move |b| (a, b)));
    for ((a, b), block) in pairs.zip(blocks.chunks_exact(9)) {
        let block = Mat3::from_row_slice(block);
        out[a] += block * value(b);
        if a != b {
            out[b] += block.transpose() * value(a);
        }
    }
    out
}
