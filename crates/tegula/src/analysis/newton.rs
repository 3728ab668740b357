//! Newton's method for one step of statics or dynamics, plain or mixed.
//!
//! Mixed: the geometric part of the tangent carries stresses extrapolated from the last
//! iterate,
//!
//! ```text
//! solve  [SᵀHS + Σ 2 n_k A_k⊗I] δ = R(q)
//! then   n ← H (s(q) + S(q) δ),   q ← q + δ
//! ```
//!
//! The residual is the ordinary one, so the solution is the ordinary one; the path is much
//! shorter for thin shells (D. Magisano, L. Leonetti, G. Garcea, *Advantages of the mixed
//! format in geometrically nonlinear analysis of beams and shells using solid finite elements*,
//! Int. J. Numer. Meth. Engng 109 (2017) 1237–1262).

mod response;
mod stability;

pub use response::SoftestMode;
pub use stability::Stability;

use crate::element::{Kinematics, Motion, Nodal};
use crate::model::NewtonMethod;
use crate::system::assembly::{TangentParts, add_follower_stiffness};
use crate::system::{Assembly, Numbering, System, Turning, VectorKind, dot};
use crate::{Result, Vec3};
use tegula_sparse::SparseLdlt;

use super::chord::{self, Increment, Increments, LaggedTangent};
use super::circulatory::{CirculatoryLoads, Purpose};
use super::solver::{self, Linearization, TangentSolver};
use super::statics::state_kinematics;
use super::{Observer, State};

/// The equation of one step: `rest(q) − force · f_int(q) = 0`.
pub trait Equation {
    /// The motion at the present iterate.
    fn kinematics<'a>(&'a self, system: &'a System) -> Kinematics<'a>;
    /// Weights of the tangent.
    fn parts(&self) -> TangentParts;
    /// Loads minus inertia and everything else that is not internal force of this iterate.
    fn rest(&self, system: &System, out: &mut [Nodal]);
    /// Adds an increment of all nodal vectors.
    fn apply(&mut self, system: &System, increment: &[Nodal]);
    /// Increment that brings the supported coordinates to their prescribed values; false if there is none.
    fn prescribed(&self, system: &System, increment: &mut [Nodal]) -> bool;
    /// Largest turn (rad) of the first increment, if it is limited: an increment of all coordinates can be scaled where
    /// the step begins with an equilibrium, since that is the answer to a part of the load.
    fn first_turn(&self, _system: &System) -> Option<f64> {
        None
    }
    /// Energy to which the energy of an increment is compared.
    fn energy_scale(&self, system: &System, assembly: &mut Assembly) -> f64;
    /// Size of the displacement of the step or of the state, to which increments are compared.
    fn displacement_scale(&self, system: &System) -> f64;
    /// Energy of the error that the iteration may leave over, beside what the tolerance says, where the energy of the
    /// first increment was `first`.
    fn error_limit(&self, _first: f64) -> f64 {
        f64::INFINITY
    }
}

/// Energy of an increment over that of the model that is nothing but round-off.
const ROUND_OFF: f64 = 1e-26;

/// When an iteration is finished.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tolerances {
    /// Energy of the increment |δ·R| over the energy scale.
    pub energy: f64,
    /// Size of the increment over the displacement scale.
    pub increment: f64,
    /// Iterations at most.
    pub max_iterations: u32,
}

/// A step that converged.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Converged {
    /// Iterations.
    pub iterations: u32,
    /// Tangents taken for it.
    pub tangents: u32,
    /// Negative pivots of the last tangent.
    pub negative_pivots: usize,
    /// Most negative pivots of a tangent on the way.
    pub most_negative_pivots: usize,
    /// Size of the first increment before it was limited: the answer of the step's start to the change of the loads.
    pub first_increment: f64,
    /// The increments stopped shrinking at the rounding floor of the model.
    pub floor: bool,
}

/// Cause of an iteration that did not converge.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Cause {
    /// The observer has asked to stop.
    Interrupted,
    /// The material law or the enhanced strains of an element could not be evaluated.
    Material,
    /// Forces or increments are not finite, or the increments carry the model far away.
    Flight,
    /// The tangent is singular, or the linear solver failed.
    Tangent,
    /// Increments found with the factor of an earlier tangent do not shrink.
    OldTangent,
    /// The energy of the increments has stopped shrinking above the rounding floor.
    Stagnation,
    /// The iterations allowed did not suffice.
    Iterations,
}

/// A step that did not converge.
#[derive(Debug, Clone, PartialEq)]
pub struct Diverged {
    /// Iterations spent.
    pub iterations: u32,
    /// Most negative pivots of a tangent on the way.
    pub most_negative_pivots: usize,
    /// Cause, for advice.
    pub cause: Cause,
    /// Cause and place, for people.
    pub reason: String,
    /// It began with the factor of an earlier tangent: with its own it may converge.
    pub began_with_old_factor: bool,
}

/// Solver and buffers, made once for an analysis.
pub struct Newton<S = SparseLdlt> {
    /// Element buffers and tangent.
    pub assembly: Assembly,
    /// Linear solver.
    pub solver: S,
    method: NewtonMethod,
    internal: Vec<Nodal>,
    residual: Vec<Nodal>,
    increment: Vec<Nodal>,
    right_side: Vec<f64>,
    solution: Vec<f64>,
    /// Memory of the materials, while a tangent of another state is taken.
    history: Vec<f64>,
    increments: Increments,
    held: Held,
    /// Axes of the vectors where the tangent was taken.
    axes: Numbering,
    /// How far the nodes have turned since then; made when it is first needed.
    turning: Option<Turning>,
    /// Price of a tangent and its factor, in iterations with an old one.
    price: f64,
    /// Skew stiffness of loads that follow the motion, where there is some.
    circulatory: Option<CirculatoryLoads>,
    /// Iterations of the present step.
    iterations: u32,
    /// Most negative pivots of a tangent of the present step.
    most_negative_pivots: usize,
}

/// Which tangent the factor at hand belongs to.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Held {
    /// None that could serve again.
    Nothing,
    /// That of a linear model with these parts.
    Linear(TangentParts),
    /// The [`LaggedTangent`] of the state.
    Lagged,
    /// An iterate of the present step.
    Iterate,
}

impl Newton {
    /// Analyses the pattern for the direct solver and makes the buffers. Without a method it takes the one that suits
    /// the materials.
    ///
    /// # Errors
    /// The factor does not fit in memory, or the system was compiled without a pattern of the tangent.
    pub fn new(system: &System, method: Option<NewtonMethod>) -> Result<Self> {
        Ok(Self::with_solver(system, method, solver::direct(system)?))
    }
}

impl<S: TangentSolver> Newton<S> {
    /// The same with another linear solver.
    pub fn with_solver(system: &System, method: Option<NewtonMethod>, solver: S) -> Self {
        let n = system.vectors();
        let price = solver.price();
        let assembly = Assembly::new(system);
        Self {
            history: assembly.history.clone(),
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
            right_side: vec![0.0; system.unknowns()],
            solution: vec![0.0; system.unknowns()],
            increments: Increments::default(),
            held: Held::Nothing,
            axes: system.numbering.clone(),
            turning: None,
            price,
            circulatory: CirculatoryLoads::new(system),
            iterations: 0,
            most_negative_pivots: 0,
        }
    }

    /// Iterations of the linear solver, and solutions for the circulatory part of follower loads, so far.
    pub fn linear_iterations(&self) -> u64 {
        self.solver.linear_iterations() + self.circulatory.as_ref().map_or(0, CirculatoryLoads::solutions)
    }

    /// Sees to it that a factor is at hand for a time step of length `dt` from a state: that of an earlier step, or a
    /// new one at the state. Linear models and prescribed motions, which need a tangent anyway, are left alone.
    ///
    /// A resumed run finds the earlier tangent again from what the state tells of it, so that it goes on as if it had
    /// not been stopped.
    pub fn prepare(
        &mut self,
        system: &System,
        (parts, predicted): (&TangentParts, &[Nodal]),
        dt: f64,
        state: &mut State,
    ) {
        if system.linear || !system.numbering.prescribed.is_empty() || state.tangent.pause > 0 {
            state.tangent.valid = false;
            return;
        }
        let serves = state.tangent.serves(dt, self.price)
            && (self.held == Held::Lagged || self.take_tangent(system, parts, &state.tangent));
        if !serves {
            self.renew(system, parts, dt, state);
        }
        let turning = self.turning.get_or_insert_with(|| Turning::new(system));
        turning.find(system, &state.tangent.u, predicted);
    }

    /// Takes the tangent at a state for this step and later ones.
    fn renew(&mut self, system: &System, parts: &TangentParts, dt: f64, state: &mut State) {
        let State { u, v, history, tangent, time, .. } = state;
        tangent.u.clone_from(u);
        if system.has_rate_damping() {
            tangent.v.clone_from(v);
        }
        tangent.history.clone_from(history);
        (tangent.time, tangent.dt) = (*time, dt);
        (tangent.steps, tangent.iterations, tangent.last) = (0, 0, 0);
        tangent.valid = self.take_tangent(system, parts, tangent);
    }

    /// Factors the tangent at a state; false if it has no factor.
    fn take_tangent(&mut self, system: &System, parts: &TangentParts, at: &LaggedTangent) -> bool {
        let velocity = (!at.v.is_empty()).then_some(at.v.as_slice());
        let motion = Motion::State { u: &at.u, velocity };
        let k = Kinematics::new(&system.reference, motion, system.linear, at.time);
        let parts = TangentParts { time: at.time, ..*parts };
        self.held = Held::Nothing;
        self.assembly.follow(system, &k);
        self.axes.copy_axes(&self.assembly.numbering);
        self.history.copy_from_slice(&self.assembly.history);
        self.assembly.history.copy_from_slice(&at.history);
        let Self { solver, assembly, internal, .. } = self;
        let at = Linearization { system, motion: &k, parts: &parts, extrapolated: false, prescribed: None };
        let prepared = loop {
            solver.assemble(assembly, &at, internal);
            if let Some(done) = solver.prepare(assembly).transpose() {
                break done;
            }
        };
        self.assembly.history.copy_from_slice(&self.history);
        if let Some(loads) = &mut self.circulatory {
            loads.take(system, &k, &parts);
        }
        if prepared.is_ok() {
            self.held = Held::Lagged;
        }
        self.held == Held::Lagged
    }

    /// Begins anew at a state: memory of its materials, and the stresses that the first tangent takes. A state that is no
    /// equilibrium, as the first of an analysis may be, takes none.
    pub fn restore(&mut self, system: &System, state: &State, equilibrium: bool) {
        self.assembly.history.copy_from_slice(&state.history);
        if equilibrium {
            self.assembly.reset_stress(system, &state_kinematics(system, &state.u, state.time));
        } else {
            self.assembly.stress.fill(0.0);
        }
    }

    /// Form of the iteration.
    pub fn method(&self) -> NewtonMethod {
        self.method
    }

    /// Changes the form of the iteration from the next step on.
    pub fn set_method(&mut self, method: NewtonMethod) {
        self.method = method;
    }

    /// Gives up the factor at hand, which has failed.
    pub fn forget(&mut self, state: &mut State) {
        self.held = Held::Nothing;
        state.tangent.fail();
    }

    /// Iterates an equation to convergence.
    ///
    /// # Errors
    /// It did not converge; the iterate is useless then.
    pub fn solve(
        &mut self,
        system: &System,
        equation: &mut dyn Equation,
        tolerances: &Tolerances,
        observer: &mut dyn Observer,
    ) -> std::result::Result<Converged, Diverged> {
        let began_with_old_factor = self.held == Held::Lagged;
        (self.iterations, self.most_negative_pivots) = (0, 0);
        self.iterate(system, equation, tolerances, observer).map_err(|(cause, reason)| Diverged {
            iterations: self.iterations,
            most_negative_pivots: self.most_negative_pivots,
            cause,
            reason,
            began_with_old_factor,
        })
    }

    fn iterate(
        &mut self,
        system: &System,
        equation: &mut dyn Equation,
        tolerances: &Tolerances,
        observer: &mut dyn Observer,
    ) -> std::result::Result<Converged, (Cause, String)> {
        let tangent_failed = |reason: String| (Cause::Tangent, reason);
        let mixed = self.method == NewtonMethod::Mixed && !system.linear;
        self.increments.clear();
        self.solver.begin_step();
        if let Some(loads) = &mut self.circulatory {
            loads.begin_step();
        }
        if self.held == Held::Iterate {
            self.held = Held::Nothing;
        }
        let (mut tangents, mut negative_pivots, mut first_increment) = (0, 0, 0.0);
        let mut extrapolated = true;
        let mut limit = f64::INFINITY;
        for iteration in 1..=tolerances.max_iterations {
            self.iterations = iteration;
            if observer.interrupted() {
                return Err((Cause::Interrupted, "interrupted".into()));
            }
            let has_prescribed = equation.prescribed(system, &mut self.increment);
            let parts = equation.parts();
            let left = tolerances.max_iterations - iteration;
            let reuse = !has_prescribed
                && match self.held {
                    Held::Nothing => false,
                    Held::Linear(p) => (p.weights, p.mass) == (parts.weights, parts.mass),
                    Held::Lagged | Held::Iterate => {
                        self.increments.old_factor_serves(parts.mass != 0.0, self.price, left)
                    }
                };
            if mixed && !reuse && !extrapolated {
                self.assembly.reset_stress(system, &equation.kinematics(system));
            }
            equation.rest(system, &mut self.residual);
            let mut prepared = Ok(0);
            {
                let k = equation.kinematics(system);
                self.assembly.follow(system, &k);
                let Self { solver, assembly, internal, circulatory, .. } = self;
                if reuse {
                    assembly.forces(system, &k, internal);
                } else {
                    if let Some(loads) = circulatory {
                        loads.take(system, &k, &parts);
                    }
                    let prescribed = has_prescribed.then_some(self.increment.as_slice());
                    let at =
                        Linearization { system, motion: &k, parts: &parts, extrapolated: mixed, prescribed };
                    self.held = Held::Nothing;
                    prepared = loop {
                        solver.assemble(assembly, &at, internal);
                        solver.add_curvature(assembly, &at, &self.residual);
                        // Without finite forces there is more to be told than that there is no factor.
                        if !internal.iter().flatten().all(|f| f.is_finite()) {
                            break Ok(0);
                        }
                        if let Some(done) = solver.prepare(assembly).transpose() {
                            break done;
                        }
                    };
                }
            }
            if has_prescribed {
                let k = equation.kinematics(system);
                add_follower_stiffness(system, &k, &parts, &self.increment, &mut self.residual);
            }
            for (r, f) in self.residual.iter_mut().zip(&self.internal) {
                for i in 0..3 {
                    r[i] -= parts.weights.force * f[i];
                }
            }
            let turning = self.turning.as_ref().filter(|_| reuse && self.held == Held::Lagged);
            if reuse {
                // What holds a vector to its length must not be taken for a force by the axes of another state.
                self.assembly.numbering.free_part(&mut self.residual);
            } else {
                self.axes.copy_axes(&self.assembly.numbering);
            }
            if let Some(turning) = turning {
                turning.turn(system, true, &mut self.residual);
            }
            self.axes.reduce(&self.residual, &mut self.right_side);
            if !self.right_side.iter().all(|r| r.is_finite()) {
                return Err(match self.assembly.without_answer(system) {
                    Some(element) => (
                        Cause::Material,
                        format!(
                            "{element}: the material law could not be evaluated (det F ≤ 0), or the iteration of its \
                             enhanced strains (`eas`) did not converge"
                        ),
                    ),
                    None => (Cause::Flight, "the forces are no longer finite".into()),
                });
            }
            if !reuse {
                tangents += 1;
                negative_pivots = prepared.map_err(tangent_failed)?;
                self.most_negative_pivots = self.most_negative_pivots.max(negative_pivots);
                self.held = if system.linear { Held::Linear(parts) } else { Held::Iterate };
            }
            self.solution.copy_from_slice(&self.right_side);
            self.solver.solve_tangent(&mut self.solution).map_err(tangent_failed)?;
            if let Some(loads) = &mut self.circulatory {
                let old = reuse || parts.mass != 0.0;
                let purpose = if old { Purpose::Contraction } else { Purpose::Increment };
                loads
                    .correct(&mut self.solver, &self.axes, &mut self.solution, purpose)
                    .map_err(tangent_failed)?;
            }
            let energy = self.solution.iter().zip(&self.right_side).map(|(a, b)| a * b).sum::<f64>().abs();
            expand_free(&self.axes, &self.solution, has_prescribed, &mut self.increment);
            if let Some(turning) = turning {
                turning.turn(system, false, &mut self.increment);
            }
            if !energy.is_finite() {
                return Err((Cause::Flight, "the increment is not finite".into()));
            }
            // Where large steps have several solutions, an old factor must not lead to another one.
            if reuse && !system.linear {
                let size = system.norm(&self.increment);
                let matters = size > tolerances.increment * equation.displacement_scale(system);
                if matters && self.increments.too_large(energy, size) {
                    if self.held == Held::Lagged {
                        let reason = "with an old tangent the increments do not shrink";
                        return Err((Cause::OldTangent, reason.into()));
                    }
                    self.held = Held::Nothing;
                    continue;
                }
            }
            if iteration == 1 {
                first_increment = system.norm(&self.increment);
            }
            // Under loads that turn with the shell, or turn it, later increments go as far astray.
            if (iteration == 1 || !system.followers.is_empty())
                && let Some(turn) = equation.first_turn(system)
            {
                shorten(system, turn, &mut self.increment);
            }
            extrapolated = mixed && !reuse;
            if extrapolated {
                let k = equation.kinematics(system);
                self.assembly.extrapolate(system, &k, &self.increment, &parts.weights);
            }
            if !system.linear {
                retract(system, &self.assembly.numbering, &equation.kinematics(system), &mut self.increment);
            }
            equation.apply(system, &self.increment);
            let size = system.norm(&self.increment);
            if size > 1e4 {
                let place = largest(system, &self.assembly.numbering, &self.residual);
                let reason =
                    format!("an increment moved the model by {size:.1e} times its own size; {place}");
                return Err((Cause::Flight, reason));
            }
            let energy_scale = equation.energy_scale(system, &mut self.assembly);
            self.solver.note_energy(energy_scale);
            let size_scale = equation.displacement_scale(system);
            let relative = energy / energy_scale.max(f64::MIN_POSITIVE);
            observer.on_iteration(iteration, relative, size / size_scale.max(f64::MIN_POSITIVE));
            let rest = if reuse && !system.linear { chord::rest(parts.mass != 0.0) } else { 1.0 };
            if iteration == 1 && !system.linear {
                limit = equation.error_limit(energy);
            }
            let limit = limit.max(ROUND_OFF * energy_scale);
            let excess = (relative / (rest * tolerances.energy))
                .max(energy / limit)
                .sqrt()
                .max(size / (size_scale * tolerances.increment));
            self.increments.push(Increment {
                energy: relative,
                size: size / size_scale,
                excess,
                fresh: !reuse,
                absolute: [energy, size],
            });
            // The error behind an increment is the contraction times it.
            let error = self.increments.contraction().powi(2).min(1.0) * energy;
            let left = if rest < 1.0 { error } else { energy };
            let converged = energy <= tolerances.energy * energy_scale
                && size <= tolerances.increment * size_scale
                && left <= rest * tolerances.energy * energy_scale
                && error <= limit;
            let done = Converged {
                iterations: iteration,
                tangents,
                negative_pivots,
                most_negative_pivots: self.most_negative_pivots,
                first_increment,
                floor: false,
            };
            if converged || (energy == 0.0 && size == 0.0) {
                return Ok(done);
            }
            if let Some(floor) = self.increments.stagnation() {
                // Near a rigid motion there is next to no energy to compare with: increments that are
                // nothing but rounding are enough then.
                // So are increments without any energy beside that of stresses that support each other: there the
                // displacement is nothing itself.
                let rounding = size <= 1e-10 * size_scale || relative <= ROUND_OFF;
                if rounding || (relative <= 1e-9 && size <= 1e-5 * size_scale) {
                    return Ok(Converged { floor: true, ..done });
                }
                if floor {
                    let place = largest(system, &self.assembly.numbering, &self.residual);
                    let energy = format!("energy of the increment {relative:.1e} of the model's");
                    return Err((Cause::Stagnation, format!("the iteration stagnates ({energy}); {place}")));
                }
            }
        }
        let place = largest(system, &self.assembly.numbering, &self.residual);
        let reason = format!("not converged after {} iterations; {place}", tolerances.max_iterations);
        Err((Cause::Iterations, reason))
    }
}

/// Shortens an increment that turns a director, or carries a node over the model's length, by more than this.
fn shorten(system: &System, turn: f64, increment: &mut [Nodal]) {
    let size = |(d, kind): (&Nodal, &VectorKind)| {
        let length = if *kind == VectorKind::Position { system.length } else { 1.0 };
        dot(&[*d], &[*d]).sqrt() / length
    };
    let largest = increment.iter().zip(&system.kinds).map(size).fold(0.0, f64::max);
    if largest > turn {
        increment.iter_mut().for_each(|d| *d = d.map(|x| x * (turn / largest)));
    }
}

/// Free coordinates of the increment; the prescribed ones stay where there are some.
fn expand_free(numbering: &Numbering, free: &[f64], keep: bool, field: &mut [Nodal]) {
    if !keep {
        numbering.expand(free, field);
        return;
    }
    for (v, value) in field.iter_mut().enumerate() {
        let mut local = numbering.to_axes(v, *value);
        for (number, x) in numbering.of(v).into_iter().zip(&mut local) {
            if let Some(y) = free.get(number as usize) {
                *x = *y;
            }
        }
        *value = numbering.from_axes(v, local);
    }
}

/// Bends increments of vectors that keep their length back to their sphere, along the great circle.
fn retract(system: &System, numbering: &Numbering, k: &Kinematics, increment: &mut [Nodal]) {
    let (Motion::State { u, .. } | Motion::Step { new: u, .. }) = k.motion;
    for unit in &numbering.unit {
        let v = unit.vector as usize;
        let reference = Vec3::from(system.reference[v]);
        let d = reference + Vec3::from(u[v]);
        let step = Vec3::from(increment[v]);
        let across = step - d * d.dot(&step);
        let angle = across.norm();
        if unit.fixed.is_some() || angle == 0.0 {
            increment[v] = (unit.project(d + across, &reference) - d).into();
            continue;
        }
        let change = across * (angle.sin() / angle) - d * (2.0 * (0.5 * angle).sin().powi(2));
        let target = d + change;
        // Round-off of the length is taken back along the vector only: across it a short step would take it for a motion.
        let back = unit.project(target, &reference) - target;
        increment[v] = (change + target * target.dot(&back)).into();
    }
}

/// Where the residual is largest, for people.
pub fn largest(system: &System, numbering: &Numbering, residual: &[Nodal]) -> String {
    let mut free = vec![[0.0; 3]; residual.len()];
    numbering.supported_part(residual, &mut free);
    let size = |v: usize| {
        let r: Nodal = std::array::from_fn(|i| residual[v][i] - free[v][i]);
        dot(&[r], &[r])
    };
    let Some(v) = (0..residual.len()).max_by(|&a, &b| size(a).total_cmp(&size(b))) else {
        return "the model is empty".into();
    };
    let node = system.nodes[v];
    let p = system.reference[system.position_of[node as usize] as usize];
    let node = system.node_label(node);
    let what = match system.kinds[v] {
        VectorKind::Position => "force",
        VectorKind::Director | VectorKind::Gradient => "moment",
    };
    format!("the largest out-of-balance {what} is at node {node}, at ({:.4}, {:.4}, {:.4})", p[0], p[1], p[2])
}
