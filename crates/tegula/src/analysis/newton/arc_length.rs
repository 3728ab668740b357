//! Newton's method with the load factor as an unknown: the equilibrium on a plane across the path (arc-length method).
//!
//! With the residual `R(u, λ)`, its derivative `F = ∂R/∂λ` and the tangent K, an increment from an iterate is
//!
//! ```text
//! δ = K⁻¹R + δλ û,   û = K⁻¹F,   ⟨u + δ − u₀, n⟩ = s
//! ```
//!
//! with the scalar product of [`System::norm`], the start u₀ of the step and the normal n of the plane, the direction of the path there.
//! û is also the direction of the path at the equilibrium found. Prescribed displacements and drives of joints that follow λ are part of
//! û; the multipliers of joints have a part of both solutions.
//!
//! E. Riks, *An incremental approach to the solution of snapping and buckling problems*, Int. J. Solids Structures 15 (1979) 529–551;
//! E. Ramm, *Strategies for tracing the nonlinear response near limit points*, in: Nonlinear Finite Element Analysis in Structural
//! Mechanics, Springer, 1981, 63–89.

use super::convergence::{CLOSED, OPEN};
use super::iteration::{FLIGHT, Failed, SPUN, Size, retract, spun_body};
use super::{Cause, Diverged, Equation, FactoredTangent, Newton, Tolerances, expand_free, largest, point};
use crate::analysis::Observer;
use crate::analysis::circulatory::Purpose;
use crate::analysis::constraints::Rates;
use crate::analysis::solver::{Linearization, TangentSolver};
use crate::analysis::statics::StaticEquation;
use crate::element::Nodal;
use crate::load::LoadParameter;
use crate::model::NewtonMethod;
use crate::norm::larger;
use crate::system::assembly::add_follower_stiffness;
use crate::system::{System, add_multiple, dot};
use serde::{Deserialize, Serialize};

/// Difference of load factors with which loads are derived; it is exact for loads in proportion to the load factor.
const LOAD_DIFFERENCE: f64 = 1e-4;
/// Difference of load factors over [`LOAD_DIFFERENCE`] that is the round-off of the sum of steps.
const SAME_LOAD: f64 = 1e-6;
/// Increment over the displacements that is round-off.
const ROUND_OFF: f64 = 1e-10;
/// Increment over the displacements that may be round-off next to a critical point, where the tangent is nearly singular.
const SINGULAR_ROUND_OFF: f64 = 1e-3;
/// Bounds of an increment over the one before that does not decrease, nor leads away. The energies of both must be small: the second one is that
/// of the residual behind the first.
const STAGNATES: [f64; 2] = [0.9, 2.0];
/// Number of iterations of small increments, of an energy over that of the load below this one, and part of the first of these increments above which
/// the last one shows round-off: next to a critical point increments go up and down, as the tangent amplifies the round-off of the forces.
const MANY: u32 = 8;
const ENERGY_OF_ROUND_OFF: f64 = 1e-12;
const REMAINS: f64 = 0.1;

/// Reason of a path on which nothing moves.
pub const NOTHING_MOVES: &str = "nothing moves with the load factor: no load, prescribed displacement, drive or prescribed strain changes with it, \
                              or the loads hold the model where it is; a small imperfection or side load shows where it becomes unstable, and \
                              linear buckling (or, under follower loads, modes of states at several loads) tells the load factor";

/// Plane across a path on which an equilibrium is looked for.
#[derive(Debug, Clone, Copy)]
pub struct Plane<'a> {
    /// Displacements from which the distance counts.
    pub origin: &'a [Nodal],
    /// Direction of unit norm.
    pub normal: &'a [Nodal],
    /// Distance from the origin.
    pub distance: f64,
}

/// Direction of a path at one of its points.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct PathTangent {
    /// Derivative of the displacements, of unit norm ([`System::norm`]).
    pub direction: Vec<Nodal>,
    /// Derivative of the multipliers of joints.
    pub multipliers: Vec<f64>,
    /// Derivative of the load factor.
    pub load: f64,
    /// Work of the loads per load factor on the direction, less that of the multipliers on the drives of joints: its product with the
    /// derivative of the load factor has the sign of the eigenvalue that vanishes at a limit point (from `K t + Gᵀ c = F dλ` and
    /// `G t = −ġ dλ` with the eigenvector φ of K on `G φ = 0`, the direction t where dλ = 0: `φᵀK φ = dλ (φᵀF − ġᵀc)`).
    pub work: f64,
    /// Sign of the determinant of the tangent in models whose follower loads may have no potential, 1 or −1: it changes where a real
    /// eigenvalue passes through zero. It is 0 in other models, whose negative eigenvalues are counted, and where it is not found.
    #[serde(default)]
    pub determinant_sign: i8,
    /// Number of real eigenvalues of the tangent that pass through zero while its circulatory part grows from zero; `None` in other models, at critical
    /// points, and where it is not found.
    #[serde(default)]
    pub crossings: Option<usize>,
}

impl PathTangent {
    /// Tangent between those at two places of a path, at a part of the way; the sign of the determinant is that of the second one.
    pub fn between(system: &System, [first, last]: [&Self; 2], part: f64) -> Self {
        let mix = |a: f64, b: f64| a + part * (b - a);
        let mut direction = first.direction.clone();
        for (x, y) in direction.as_flattened_mut().iter_mut().zip(last.direction.as_flattened()) {
            *x = mix(*x, *y);
        }
        let size = system.norm(&direction);
        direction.as_flattened_mut().iter_mut().for_each(|x| *x /= size);
        let multipliers = first.multipliers.iter().zip(&last.multipliers).map(|(x, y)| mix(*x, *y) / size);
        Self {
            direction,
            multipliers: multipliers.collect(),
            load: mix(first.load, last.load) / size,
            work: mix(first.work, last.work) / size,
            determinant_sign: last.determinant_sign,
            crossings: last.crossings,
        }
    }

    /// Turns the direction round.
    pub fn reverse(&mut self) {
        self.direction.as_flattened_mut().iter_mut().for_each(|x| *x = -*x);
        self.multipliers.iter_mut().for_each(|x| *x = -*x);
        (self.load, self.work) = (-self.load, -self.work);
    }
}

/// Response of an equilibrium to a change of the load factor, with its buffers.
#[derive(Debug, Clone, Default)]
pub struct LoadResponse {
    /// Forces per load factor.
    force: Vec<Nodal>,
    /// Prescribed displacements per load factor.
    prescribed: Vec<Nodal>,
    /// Change û of the displacements per load factor.
    field: Vec<Nodal>,
    free: Vec<f64>,
    /// Change of the multipliers per load factor.
    multipliers: Vec<f64>,
    /// Work of the loads on û.
    work: f64,
}

impl LoadResponse {
    /// Buffers for a system.
    pub fn new(system: &System) -> Self {
        let fields = || vec![[0.0; 3]; system.vectors()];
        Self {
            force: fields(),
            prescribed: fields(),
            field: fields(),
            free: vec![0.0; system.unknowns()],
            multipliers: vec![0.0; system.constraints()],
            work: 0.0,
        }
    }

    /// Size of the forces per load factor ([`System::force_norm`]).
    pub fn size_of_loads(&self, system: &System) -> f64 {
        system.force_norm(&self.force)
    }

    /// Work of the forces per load factor on a motion.
    pub fn work_on(&self, motion: &[Nodal]) -> f64 {
        dot(&self.force, motion)
    }
}

impl<S: TangentSolver> Newton<S> {
    /// Moves an equation along a direction of the path by a length. The stress of the next tangent is extrapolated.
    pub fn predict(
        &mut self,
        system: &System,
        (equation, history): (&mut StaticEquation, &[f64]),
        tangent: &PathTangent,
        length: f64,
    ) {
        let k = point(system, equation, history);
        self.assembly.follow(system, &k);
        self.assembly.reset_stress(system, &k);
        self.increment.fill([0.0; 3]);
        add_multiple(&mut self.increment, length, &tangent.direction);
        let k = point(system, equation, history);
        self.assembly.extrapolate(system, &k, &self.increment, &equation.parts().weights);
        self.move_by_increment(system, equation, (length, tangent.load), &tangent.multipliers);
    }

    /// Iterates an equation to the equilibrium on a plane, with the load factor as an unknown, from the history variables at the start
    /// of the step. Returns the number of iterations.
    ///
    /// # Errors
    /// The iteration did not converge; the iterate is useless then.
    pub fn solve_on_plane(
        &mut self,
        system: &System,
        (equation, history): (&mut StaticEquation, &[f64]),
        (plane, response): (&Plane, &mut LoadResponse),
        tolerances: &Tolerances,
        observer: &mut dyn Observer,
    ) -> Result<u32, Diverged> {
        (self.iterations, self.most_negative_pivots) = (0, 0);
        self.iterate_on_plane(system, (equation, history), (plane, response), tolerances, observer).map_err(
            |(cause, reason)| Diverged {
                iterations: self.iterations,
                most_negative_pivots: self.most_negative_pivots,
                cause,
                reason,
                began_with_old_factor: false,
            },
        )
    }

    fn iterate_on_plane(
        &mut self,
        system: &System,
        (equation, history): (&mut StaticEquation, &[f64]),
        (plane, response): (&Plane, &mut LoadResponse),
        tolerances: &Tolerances,
        observer: &mut dyn Observer,
    ) -> Result<u32, Failed> {
        self.begin_step();
        let mixed = self.method == NewtonMethod::Mixed && !system.linear;
        let mut convergence = PlaneConvergence::default();
        for number in 1..=tolerances.max_iterations {
            self.iterations = number;
            if observer.interrupted() {
                return Err((Cause::Interrupted, "interrupted".into()));
            }
            let negative = self.linearize_with_load(system, equation, history, mixed, response)?;
            self.most_negative_pivots = self.most_negative_pivots.max(negative);
            let (change, energy) = self
                .increment_to_plane(system, equation, (plane, response))
                .map_err(|reason| (Cause::Tangent, reason))?;
            if !(energy.is_finite() && change.is_finite()) {
                return Err((Cause::Flight, "the increment is not finite".into()));
            }
            if let Some(body) = spun_body(system, &self.solution) {
                let reason =
                    format!("divergence: an increment turns body \"{body}\" by more than {SPUN} rad");
                return Err((Cause::Flight, reason));
            }
            if mixed {
                let k = point(system, equation, history);
                self.assembly.extrapolate(system, &k, &self.increment, &equation.parts().weights);
            }
            self.move_by_increment(system, equation, (change, 1.0), &response.multipliers);
            if let Some(constraints) = &self.constraints {
                equation.change_multipliers(constraints.change());
            }
            let norm = system.norm(&self.increment);
            if norm > FLIGHT && !system.linear {
                let place = largest(system, &self.assembly.frames, &self.residual);
                return Err((Cause::Flight, format!("divergence of the iteration; {place}")));
            }
            let scale = equation.displacement_scale(system);
            let energy_scale = equation.energy_scale(system, &mut self.assembly, history);
            observer.on_iteration(
                number,
                energy / energy_scale.max(f64::MIN_POSITIVE),
                norm / scale.max(f64::MIN_POSITIVE),
            );
            let small =
                convergence.is_small(number, Size { energy, norm, scale: energy_scale }, scale, tolerances);
            let rests = norm <= larger(ROUND_OFF * scale, self.round_off);
            if (small || rests)
                && self.violation(system, equation) <= larger(CLOSED, self.round_off).min(OPEN)
            {
                return Ok(number);
            }
        }
        if let Some(open) = self.open_joint(system, equation) {
            return Err((Cause::Constraints, open));
        }
        let place = largest(system, &self.assembly.frames, &self.residual);
        Err((
            Cause::Iterations,
            format!("not converged after {} iterations; {place}", tolerances.max_iterations),
        ))
    }

    /// Increment `K⁻¹R + δλ û` onto a plane, with the tangent factored; the residual becomes `R + δλ F`. Returns the change δλ of the load factor
    /// and the energy of the increment.
    ///
    /// # Errors
    /// The linear solver failed; the text gives the reason.
    fn increment_to_plane(
        &mut self,
        system: &System,
        equation: &StaticEquation,
        (plane, response): (&Plane, &mut LoadResponse),
    ) -> Result<(f64, f64), String> {
        self.find_load_response(system, equation, response)?;
        self.respond_to_residual(system, equation)?;
        let left = plane.distance - distance(system, plane, &equation.u);
        let along = system.inner_product(plane.normal, &response.field);
        let change = (left - system.inner_product(plane.normal, &self.increment)) / along;
        add_multiple(&mut self.increment, change, &response.field);
        add_multiple(&mut self.residual, change, &response.force);
        Ok((change, dot(&self.increment, &self.residual).abs()))
    }

    /// Moves an equation by the increment, and its load factor and multipliers by `factor` times their rates.
    fn move_by_increment(
        &mut self,
        system: &System,
        equation: &mut StaticEquation,
        (factor, load): (f64, f64),
        multipliers: &[f64],
    ) {
        if !system.linear {
            retract(system, &self.assembly.frames, &equation.motion(), &mut self.increment);
        }
        equation.apply(system, &self.increment);
        equation.multipliers.iter_mut().zip(multipliers).for_each(|(x, rate)| *x += factor * rate);
        equation.time += factor * load;
        if !system.dofs().prescribed.is_empty() {
            system.prescribe(equation.time, &mut equation.u);
        }
    }

    /// Direction of the path at an equilibrium, in the sense in which its product with `along` is positive (without one: that of a rising
    /// load factor), and the number of negative eigenvalues of the tangent, which is factored.
    ///
    /// # Errors
    /// The tangent has no factor, or nothing changes with the load factor; the text gives the reason.
    pub fn path_tangent(
        &mut self,
        system: &System,
        (equation, history): (&mut StaticEquation, &[f64]),
        along: Option<&[Nodal]>,
        response: &mut LoadResponse,
    ) -> Result<(PathTangent, usize), String> {
        let negative = self
            .linearize_with_load(system, equation, history, false, response)
            .map_err(|(_, reason)| reason)?;
        self.find_load_response(system, equation, response)?;
        let size = system.norm(&response.field);
        if size == 0.0 {
            return Err(NOTHING_MOVES.into());
        }
        let backwards = along.is_some_and(|along| system.inner_product(along, &response.field) < 0.0);
        let scale = if backwards { -1.0 / size } else { 1.0 / size };
        let (determinant_sign, crossings) = self.determinant_sign(negative)?;
        let tangent = PathTangent {
            direction: response.field.iter().map(|x| x.map(|x| scale * x)).collect(),
            multipliers: response.multipliers.iter().map(|x| scale * x).collect(),
            load: scale,
            work: scale * response.work,
            determinant_sign,
            crossings,
        };
        Ok((tangent, negative))
    }

    /// Factors the tangent at an iterate. The residual becomes that of the iterate, and the force of `response` its derivative with
    /// respect to the load factor. Returns the number of negative eigenvalues of the tangent, on the constraints of joints.
    fn linearize_with_load(
        &mut self,
        system: &System,
        equation: &mut StaticEquation,
        history: &[f64],
        extrapolated: bool,
        response: &mut LoadResponse,
    ) -> Result<usize, Failed> {
        self.find_load_rate(system, equation, history, response);
        let moves = !system.dofs().prescribed.is_empty();
        equation.external_minus_inertia(system, &mut self.residual);
        let (k, parts) = (point(system, equation, history), equation.parts());
        self.assembly.follow(system, &k);
        self.assembly.forces(system, &k, &mut response.field);
        self.factored = FactoredTangent::Nothing;
        let Self { solver, assembly, internal, circulatory, residual, .. } = self;
        if let Some(loads) = circulatory {
            loads.take(system, &k.motion, &parts);
        }
        let prescribed = moves.then_some(response.prescribed.as_slice());
        let at = Linearization { system, point: &k, parts: &parts, extrapolated, prescribed };
        let mut negative = loop {
            solver.assemble(assembly, &at, internal);
            solver.add_curvature(assembly, &at, residual);
            if system.has_body_curvature(&parts.weights) {
                assembly.add_body_curvature(system, &k, &parts.weights, (extrapolated, residual));
            }
            if !internal.as_flattened().iter().all(|f| f.is_finite()) {
                let reason = assembly.without_answer(system).map_or_else(
                    || "the forces are no longer finite".to_owned(),
                    |element| {
                        format!("{element}: the material law could not be evaluated, or its enhanced strains")
                    },
                );
                return Err((Cause::Flight, reason));
            }
            if let Some(done) = solver.prepare(assembly).transpose() {
                break done.map_err(|reason| (Cause::Tangent, reason))?;
            }
        };
        if moves {
            let product = internal.as_flattened().iter().zip(response.field.as_flattened());
            for (x, (with, without)) in response.force.as_flattened_mut().iter_mut().zip(product) {
                *x -= with - without;
            }
            add_follower_stiffness(system, &k.motion, &parts, &response.prescribed, &mut response.force);
        }
        add_multiple(residual, -1.0, &response.field);
        self.frames.copy_from(&self.assembly.frames);
        if let Some(constraints) = &mut self.constraints {
            constraints
                .take(system, (&k, &parts.weights), &self.assembly.frames, &mut self.solver)
                .map_err(|reason| (Cause::Tangent, reason))?;
            negative = negative.saturating_sub(constraints.negative_eigenvalues());
        }
        Ok(negative)
    }

    /// Derivatives of the forces at fixed displacements, and of the prescribed displacements, with respect to the load factor.
    fn find_load_rate(
        &mut self,
        system: &System,
        equation: &mut StaticEquation,
        history: &[f64],
        response: &mut LoadResponse,
    ) {
        let LoadResponse { force, prescribed, field, .. } = response;
        let load = equation.time;
        force.fill([0.0; 3]);
        prescribed.fill([0.0; 3]);
        let of_elements = !system.prescribed_strains.is_empty() || system.has_actuators();
        for &(steps, weight) in differences(system, load) {
            equation.time = load + steps * LOAD_DIFFERENCE;
            let factor = weight / LOAD_DIFFERENCE;
            equation.external_minus_inertia(system, field);
            add_multiple(force, factor, field);
            if of_elements {
                self.assembly.forces(system, &point(system, equation, history), field);
                add_multiple(force, -factor, field);
            }
            if !system.dofs().prescribed.is_empty() {
                field.fill([0.0; 3]);
                system.prescribe(equation.time, field);
                add_multiple(prescribed, factor, field);
            }
        }
        equation.time = load;
    }

    /// Solves for û and the multipliers that belong to it, with the tangent factored.
    fn find_load_response(
        &mut self,
        system: &System,
        equation: &StaticEquation,
        response: &mut LoadResponse,
    ) -> Result<(), String> {
        let LoadResponse { force, prescribed, field, free, multipliers, work } = response;
        self.frames.reduce(force, &mut self.right_side);
        let at = (&equation.motion(), equation.time);
        self.solve_for_right_side(Some(Purpose::Path), |constraints, x| {
            multipliers.copy_from_slice(constraints.project(system, at, Rates::First(prescribed), x));
        })?;
        free.copy_from_slice(&self.solution);
        *work = 0.0;
        if let Some(constraints) = &mut self.constraints {
            let rates = constraints.rates(system, at, Rates::First(prescribed));
            *work -= rates.iter().zip(&*multipliers).map(|(a, b)| a * b).sum::<f64>();
        }
        *work += free.iter().zip(&self.right_side).map(|(a, b)| a * b).sum::<f64>();
        field.copy_from_slice(prescribed);
        expand_free(&self.frames, free, !system.dofs().prescribed.is_empty(), field);
        Ok(())
    }

    /// Solves for the increment `K⁻¹R` at constant load factor.
    fn respond_to_residual(&mut self, system: &System, equation: &StaticEquation) -> Result<(), String> {
        self.frames.reduce(&self.residual, &mut self.right_side);
        self.solve_for_right_side(Some(Purpose::Path), |constraints, x| {
            let at = (&equation.motion(), equation.time);
            constraints.correct(system, at, equation.multipliers(), x);
        })?;
        expand_free(&self.frames, &self.solution, false, &mut self.increment);
        Ok(())
    }
}

/// Test of convergence on a plane: tolerances of energy and norm, and stagnation of the increments at round-off.
#[derive(Default)]
struct PlaneConvergence {
    /// Norm of the increment before, whose energy is small.
    before: Option<f64>,
    /// Number and norm of the first one in succession of the increments that are small and whose energy is round-off.
    since: Option<(u32, f64)>,
}

impl PlaneConvergence {
    /// Whether the increment of an iteration is small, or stagnates. The scale of displacements follows its size.
    fn is_small(
        &mut self,
        number: u32,
        Size { energy, norm, scale: energy_scale }: Size,
        scale: f64,
        tolerances: &Tolerances,
    ) -> bool {
        let without_energy = energy <= tolerances.energy * energy_scale;
        let is_tiny = norm <= SINGULAR_ROUND_OFF * scale;
        let stagnates = is_tiny
            && self
                .before
                .is_some_and(|before| norm > STAGNATES[0] * before && norm <= STAGNATES[1] * before);
        self.before = without_energy.then_some(norm);
        self.since = (is_tiny && energy <= ENERGY_OF_ROUND_OFF * energy_scale)
            .then(|| self.since.unwrap_or((number, norm)));
        let remains =
            self.since.is_some_and(|(first, at_first)| number >= first + MANY && norm > REMAINS * at_first);
        without_energy && (norm <= tolerances.increment * scale || stagnates) || remains
    }
}

/// Places of a difference quotient of second order, in steps of the difference, and their weights. Load factors of static steps do not
/// leave the range from 0 to 1, and their quotients cross no kink of an amplitude: at a kink they have the slope of growing load factors.
fn differences(system: &System, load: f64) -> &'static [(f64, f64)] {
    const CENTRAL: &[(f64, f64)] = &[(1.0, 0.5), (-1.0, -0.5)];
    const FORWARD: &[(f64, f64)] = &[(0.0, -1.5), (1.0, 2.0), (2.0, -0.5)];
    const BACKWARD: &[(f64, f64)] = &[(0.0, 1.5), (-1.0, -2.0), (-2.0, 0.5)];
    if system.parameter() != LoadParameter::LoadFactor {
        return CENTRAL;
    }
    let inside = |load: f64| (0.0..=1.0).contains(&load);
    let kinks = |first: f64, last: f64| {
        let [first, last] = [first, last].map(|steps| load + steps * LOAD_DIFFERENCE);
        system.amplitudes.iter().any(|amplitude| amplitude.has_point_between(first, last))
    };
    match [inside(load - LOAD_DIFFERENCE), inside(load + LOAD_DIFFERENCE)] {
        [false, true] => FORWARD,
        [true, false] => BACKWARD,
        _ if kinks(-SAME_LOAD, SAME_LOAD) => FORWARD,
        _ => match [kinks(-2.0, 0.0), kinks(0.0, 2.0)] {
            [true, false] => FORWARD,
            [false, true] => BACKWARD,
            _ => CENTRAL,
        },
    }
}

/// Distance of displacements from the origin along the normal of a plane.
fn distance(system: &System, plane: &Plane, u: &[Nodal]) -> f64 {
    system.inner_product(plane.normal, u) - system.inner_product(plane.normal, plane.origin)
}
