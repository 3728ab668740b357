//! Newton's method for one step of statics or dynamics, displacement-based or mixed.
//!
//! Mixed: the geometric part of the tangent carries stresses extrapolated from the last
//! iterate,
//!
//! ```text
//! solve  [BᵀHB + Σ 2 n_k A_k⊗I] δ = R(q)
//! then   n ← H (s(q) + B(q) δ),   q ← q + δ
//! ```
//!
//! The residual is the ordinary one, so the solution is the ordinary one; the path is much
//! shorter for thin shells (D. Magisano, L. Leonetti, G. Garcea, *Advantages of the mixed
//! format in geometrically nonlinear analysis of beams and shells using solid finite elements*,
//! Int. J. Numer. Meth. Engng 109 (2017) 1237–1262).

mod arc_length;
mod convergence;
mod iteration;
mod linear_solution;
mod response;
mod stability;

pub use arc_length::{LoadResponse, NOTHING_MOVES, PathTangent, Plane};
pub(super) use iteration::retract;
pub use response::SoftestMode;
pub use stability::{Stability, TangentPart};

use crate::Result;
use crate::element::{Motion, Nodal};
use crate::model::NewtonMethod;
use crate::norm::max_norm;
use crate::system::assembly::TangentCoefficients;
use crate::system::{
    Assembly, Coordinates, CorotationalUpdate, EvaluationPoint, Internal, LocalFrames, System, VectorKind,
    dot,
};

use super::circulatory::CirculatoryLoads;
use super::constraints::{Constraints, Schur};
use super::direct::Direct;
use super::lagged_tangent::{Increments, LaggedTangent};
use super::solver::{Linearization, TangentSolver};
use super::{Observer, State};

/// Equation of one step: `f_ext(q) − f_inertia(q) − force · f_int(q) = 0`, with the weight `force` of the internal forces.
pub trait Equation {
    /// Motion at the present iterate.
    fn motion(&self) -> Motion<'_>;
    /// Tangent coefficients, and the time at which loads and prescribed strains act.
    fn parts(&self) -> TangentCoefficients;
    /// External minus inertia forces: all forces but the internal forces of this iterate.
    fn external_minus_inertia(&self, system: &System, out: &mut [Nodal]);
    /// Adds an increment to all nodal vectors.
    fn apply(&mut self, system: &System, increment: &[Nodal]);
    /// Lagrange multipliers of the constraints at the present iterate.
    fn multipliers(&self) -> &[f64] {
        &[]
    }
    /// Adds a change to the Lagrange multipliers.
    fn change_multipliers(&mut self, _change: &[f64]) {}
    /// Increment that brings the constrained degrees of freedom to their prescribed values; false if there is none.
    fn prescribed(&self, system: &System, increment: &mut [Nodal]) -> bool;
    /// Step limiter: largest rotation (rad) of the first increment, if it is limited. The increment of all degrees of
    /// freedom can be scaled where the step begins with an equilibrium, since it is then the response to a part of the
    /// load.
    fn first_rotation_limit(&self, _system: &System) -> Option<f64> {
        None
    }
    /// Energy scale, to which the energy of an increment is compared.
    fn energy_scale(&self, system: &System, assembly: &mut Assembly, history: &[f64]) -> f64;
    /// Displacement scale: norm of the displacement of the step or of the state, to which increments are compared.
    fn displacement_scale(&self, system: &System) -> f64;
    /// Bound on the energy of the iteration error, in addition to the tolerance, where the energy of the first
    /// increment is `first`.
    fn error_limit(&self, _first: f64) -> f64 {
        f64::INFINITY
    }
}

/// Energy of an increment over that of the model that is pure round-off.
const ROUND_OFF: f64 = 1e-26;

/// Convergence criteria of an iteration.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tolerances {
    /// Energy of the increment |δ·R| over the energy scale.
    pub energy: f64,
    /// Norm of the increment over the displacement scale.
    pub increment: f64,
    /// Largest number of iterations.
    pub max_iterations: u32,
}

/// Outcome of a step that converged.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Converged {
    /// Number of iterations.
    pub iterations: u32,
    /// Number of tangents factored in the step.
    pub tangents: u32,
    /// Negative pivots of the last tangent.
    pub negative_pivots: usize,
    /// Largest number of negative pivots of a tangent of the iteration.
    pub most_negative_pivots: usize,
    /// Norm of the first increment before the step limiter: the response of the step's start to the change of the
    /// loads.
    pub first_increment: f64,
    /// Whether the increments stagnated at round-off of the model.
    pub floor: bool,
}

/// Cause of an iteration that did not converge.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Cause {
    /// The observer has asked to stop.
    Interrupted,
    /// The material law or the enhanced strains of an element could not be evaluated.
    Material,
    /// Forces or increments are not finite, or an increment moves the model far away.
    Flight,
    /// The tangent is singular, or the linear solver failed.
    Tangent,
    /// Increments found with a lagged tangent do not decrease fast enough.
    OldTangent,
    /// The energy of the increments stagnates above round-off.
    Stagnation,
    /// Constraints of joints contradict each other.
    Constraints,
    /// The allowed iterations do not suffice.
    Iterations,
}

/// Outcome of a step that did not converge.
#[derive(Debug, Clone, PartialEq)]
pub struct Diverged {
    /// Number of iterations spent.
    pub iterations: u32,
    /// Largest number of negative pivots of a tangent of the iteration.
    pub most_negative_pivots: usize,
    /// Cause, on which advice depends.
    pub cause: Cause,
    /// Message with cause and place.
    pub reason: String,
    /// Whether the step began with a lagged tangent: with new tangents it may converge.
    pub began_with_old_factor: bool,
}

/// Newton solver with its buffers, made once for an analysis.
pub struct Newton<S = Direct> {
    /// Element buffers and tangent.
    pub assembly: Assembly,
    /// Linear solver.
    pub solver: S,
    method: NewtonMethod,
    internal: Vec<Nodal>,
    residual: Vec<Nodal>,
    increment: Vec<Nodal>,
    /// First increment of the last iteration, before the step limiter: the response of the step's start to the change of the loads.
    pub first_response: Vec<Nodal>,
    right_side: Vec<f64>,
    solution: Vec<f64>,
    increments: Increments,
    factored: FactoredTangent,
    /// Local frames of the vectors where the tangent was computed.
    frames: LocalFrames,
    /// Co-rotational update of the lagged tangent: rotations of the nodes since then; made when first needed.
    corotational: Option<CorotationalUpdate>,
    /// Cost of a tangent and its factor, in iterations with a lagged tangent.
    price: f64,
    /// Circulatory (skew) stiffness of follower loads, where there is some.
    circulatory: Option<CirculatoryLoads>,
    /// Constraints of joints, where there are some.
    pub(super) constraints: Option<Constraints>,
    /// Round-off of the positions over the model's length, which grows with the distance of the model from the origin.
    round_off: f64,
    /// Iterations of the present step.
    iterations: u32,
    /// Largest number of negative pivots of a tangent of the present step.
    most_negative_pivots: usize,
}

/// Tangent that is factored: the one that the present factor belongs to.
#[derive(Debug, Clone, Copy, PartialEq)]
enum FactoredTangent {
    /// No tangent that could be reused.
    Nothing,
    /// Tangent of a linear model with these coefficients.
    Linear(TangentCoefficients),
    /// The [`LaggedTangent`] of the state.
    Lagged,
    /// Tangent of an iterate of the present step.
    Iterate,
}

impl Newton {
    /// Analyses the pattern for the direct solver and makes the buffers. `None` selects the form of Newton's method
    /// that suits the materials.
    ///
    /// # Errors
    /// The factor does not fit in memory, or the system was compiled without a sparsity pattern of the tangent.
    pub fn new(system: &System, method: Option<NewtonMethod>) -> Result<Self> {
        Ok(Self::with_solver(system, method, Direct::new(system)?))
    }
}

/// Round-off of a position over its distance from the origin: that of the sums behind a constraint.
const ROUND_OFF_OF_POSITIONS: f64 = 4.0 * f64::EPSILON;

/// Round-off of the positions over the model's length.
fn round_off_of_positions(system: &System) -> f64 {
    let Coordinates { reference, kinds, .. } = &*system.coordinates;
    let positions = reference.iter().zip(kinds).filter(|(_, kind)| **kind == VectorKind::Position);
    ROUND_OFF_OF_POSITIONS * max_norm(positions.flat_map(|(x, _)| x.iter().copied())) / system.length
}

impl<S: TangentSolver> Newton<S> {
    /// Newton solver with a given linear solver. `None` selects the form of Newton's method that suits the materials.
    pub fn with_solver(system: &System, method: Option<NewtonMethod>, solver: S) -> Self {
        let n = system.vectors();
        let price = solver.price([system.unknowns(), system.constraints()]);
        let assembly = Assembly::new(system);
        Self {
            assembly,
            solver,
            method: method.unwrap_or(if system.yields() {
                // Stresses extrapolated with the tangent of one side of the yield surface mislead on the other.
                NewtonMethod::Displacement
            } else {
                NewtonMethod::Mixed
            }),
            internal: vec![[0.0; 3]; n],
            residual: vec![[0.0; 3]; n],
            increment: vec![[0.0; 3]; n],
            first_response: vec![[0.0; 3]; n],
            right_side: vec![0.0; system.unknowns()],
            solution: vec![0.0; system.unknowns()],
            increments: Increments::default(),
            factored: FactoredTangent::Nothing,
            frames: system.frames.clone(),
            corotational: None,
            price,
            circulatory: CirculatoryLoads::new(system),
            constraints: Constraints::new(system),
            round_off: round_off_of_positions(system),
            iterations: 0,
            most_negative_pivots: 0,
        }
    }

    /// Iterations of the linear solver, and solves for the circulatory part of follower loads, so far.
    pub fn linear_iterations(&self) -> u64 {
        self.solver.linear_iterations() + self.circulatory.as_ref().map_or(0, CirculatoryLoads::solutions)
    }

    /// Schur complement of the last tangent at the constraints of joints, if there are any.
    pub(super) fn schur(&self) -> Option<&Schur> {
        self.constraints.as_ref().map(Constraints::schur)
    }

    /// Takes the angles of the state from which a step starts: gears count their turns from there.
    pub fn count_turns(&mut self, system: &System, state: &State) {
        if let Some(constraints) = &mut self.constraints {
            constraints.set_angles(system, &state.angles);
        }
    }

    /// Provides a factor for a time step of length `dt` from a state: the lagged tangent of an earlier step, or a new
    /// one at the state. Linear models and prescribed motions, which need a tangent anyway, and bodies and joints are skipped.
    ///
    /// A resumed run recomputes the lagged tangent from the checkpoint data in the state, so that it continues as if it
    /// had not been stopped.
    pub fn prepare(
        &mut self,
        system: &System,
        (parts, predicted): (&TangentCoefficients, &[Nodal]),
        dt: f64,
        state: &mut State,
    ) {
        let jointed = !system.coordinates.bodies.is_empty() || !system.joints.is_empty();
        if system.linear || jointed || !system.dofs().prescribed.is_empty() || state.tangent.pause > 0 {
            state.tangent.valid = false;
            return;
        }
        let serves = state.tangent.is_reusable(dt, self.price)
            && (self.factored == FactoredTangent::Lagged || self.take_tangent(system, &state.tangent));
        if !serves {
            self.renew(system, parts, dt, state);
        }
        let corotational = self.corotational.get_or_insert_with(|| CorotationalUpdate::new(system));
        corotational.find(system, &state.tangent.u, predicted);
    }

    /// Computes the lagged tangent at a state, for this step and later ones.
    fn renew(&mut self, system: &System, parts: &TangentCoefficients, dt: f64, state: &mut State) {
        let State { u, v, history, tangent, time, .. } = state;
        tangent.u.clone_from(u);
        if system.has_rate_damping() {
            tangent.v.clone_from(v);
        }
        tangent.history.clone_from(history);
        (tangent.time, tangent.dt) = (*time, dt);
        tangent.coefficients = Some(TangentCoefficients { time: *time, ..*parts });
        (tangent.steps, tangent.iterations, tangent.last) = (0, 0, 0);
        tangent.valid = self.take_tangent(system, tangent);
    }

    /// Factors the tangent at a state; false if the factorisation fails.
    fn take_tangent(&mut self, system: &System, at: &LaggedTangent) -> bool {
        let Some(parts) = at.coefficients else { return false };
        let velocity = (!at.v.is_empty()).then_some(at.v.as_slice());
        let motion = Motion::State { u: &at.u, velocity };
        let k = EvaluationPoint::new(system, motion, at.time, &at.history);
        self.factored = FactoredTangent::Nothing;
        self.assembly.follow(system, &k);
        self.frames.copy_from(&self.assembly.frames);
        let Self { solver, assembly, internal, .. } = self;
        let at = Linearization { system, point: &k, parts: &parts, extrapolated: false, prescribed: None };
        let prepared = loop {
            solver.assemble(assembly, &at, internal);
            if let Some(done) = solver.prepare(assembly).transpose() {
                break done;
            }
        };
        if let Some(loads) = &mut self.circulatory {
            loads.take(system, &k.motion, &parts);
        }
        if prepared.is_ok() {
            self.factored = FactoredTangent::Lagged;
        }
        self.factored == FactoredTangent::Lagged
    }

    /// Restarts from a state: sets the extrapolated stress of the first tangent. For a state that is no equilibrium, as the
    /// first of an analysis may be, this stress is zero.
    pub fn restore(&mut self, system: &System, state: &State, equilibrium: bool) {
        if equilibrium {
            self.assembly.reset_stress(system, &state.point(system));
        } else {
            self.assembly.stress.fill(0.0);
        }
    }

    /// Forgets the present factor, so that the next step begins as that of a resumed run does.
    pub fn reset(&mut self) {
        self.factored = FactoredTangent::Nothing;
    }

    /// Form of Newton's method.
    pub fn method(&self) -> NewtonMethod {
        self.method
    }

    /// Changes the form of Newton's method from the next step on.
    pub fn set_method(&mut self, method: NewtonMethod) {
        self.method = method;
    }

    /// Discards the present factor, with which a step has failed.
    pub fn forget(&mut self, state: &mut State) {
        self.factored = FactoredTangent::Nothing;
        state.tangent.fail();
    }

    /// Iterates an equation to convergence, from the history variables at the start of the step.
    ///
    /// # Errors
    /// The iteration did not converge; the iterate is useless then.
    pub fn solve(
        &mut self,
        system: &System,
        equation: &mut dyn Equation,
        history: &[f64],
        tolerances: &Tolerances,
        observer: &mut dyn Observer,
    ) -> std::result::Result<Converged, Diverged> {
        let began_with_old_factor = self.factored == FactoredTangent::Lagged;
        (self.iterations, self.most_negative_pivots) = (0, 0);
        self.iterate(system, equation, history, tolerances, observer).map_err(|(cause, reason)| Diverged {
            iterations: self.iterations,
            most_negative_pivots: self.most_negative_pivots,
            cause,
            reason,
            began_with_old_factor,
        })
    }
}

/// Evaluation point of the present iterate of an equation.
fn point<'a>(system: &System, equation: &'a dyn Equation, history: &'a [f64]) -> EvaluationPoint<'a> {
    let internal = Internal { history, multipliers: equation.multipliers() };
    EvaluationPoint::new(system, equation.motion(), equation.parts().time, internal)
}

/// Expands the free degrees of freedom of an increment; with `keep` the prescribed ones retain their values.
fn expand_free(frames: &LocalFrames, free: &[f64], keep: bool, field: &mut [Nodal]) {
    if !keep {
        frames.expand(free, field);
        return;
    }
    for (v, value) in field.iter_mut().enumerate() {
        let mut local = frames.to_local(v, *value);
        for (number, x) in frames.of(v).into_iter().zip(&mut local) {
            if let Some(y) = free.get(number as usize) {
                *x = *y;
            }
        }
        *value = frames.to_global(v, local);
    }
    frames.expand_bodies(free, field);
}

/// Place of the largest residual, as text.
pub fn largest(system: &System, frames: &LocalFrames, residual: &[Nodal]) -> String {
    let mut free = vec![[0.0; 3]; residual.len()];
    frames.constrained_part(residual, &mut free);
    let size = |v: usize| {
        // What acts on an attached vector is in balance with the other forces on its body.
        if system.dofs().attachment(v).is_some() {
            return 0.0;
        }
        let r: Nodal = std::array::from_fn(|i| residual[v][i] - free[v][i]);
        dot(&[r], &[r])
    };
    let Some(v) = (0..residual.len()).max_by(|&a, &b| size(a).total_cmp(&size(b))) else {
        return "the model is empty".into();
    };
    let what = match system.coordinates.kinds[v] {
        VectorKind::Position => "force",
        VectorKind::Director | VectorKind::Gradient => "moment",
    };
    format!("the largest out-of-balance {what} is at {}", system.place_name(v))
}
