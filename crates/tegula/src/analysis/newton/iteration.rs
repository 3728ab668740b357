//! Newton iteration of one step: residual, tangent, and increment with step limiter.

use super::{Cause, Converged, Equation, FactoredTangent, Newton, Tolerances, expand_free, largest, point};
use crate::analysis::Observer;
use crate::analysis::circulatory::Purpose;
use crate::analysis::solver::{Linearization, SINGULAR, TangentSolver};
use crate::element::{Motion, Nodal};
use crate::model::NewtonMethod;
use crate::system::assembly::{TangentCoefficients, add_follower_stiffness};
use crate::system::{EvaluationPoint, LocalFrames, System, VectorKind, dot};
use crate::{Mat3, Vec3};

/// Largest increment over the size of the model; beyond it the iteration diverges.
pub(super) const FLIGHT: f64 = 1e4;

/// Rotation of a body in an increment (rad), beyond which the iteration diverges.
pub(super) const SPUN: f64 = 3.0;

/// Failure of a step: its cause, and the message with its place.
pub(super) type Failed = (Cause, String);

/// Bookkeeping of the iterations of a step.
pub(super) struct Progress {
    /// Number of tangents.
    pub(super) tangents: u32,
    /// Negative pivots of the last tangent.
    pub(super) negative_pivots: usize,
    /// Energy, over that of the model, of the increment that the last new tangent gave.
    pub(super) tangent_energy: f64,
    /// Number of tangents that were asked for behind convergence, to judge the stability.
    pub(super) asked: u32,
    /// Norm of the first increment, before the step limiter.
    pub(super) first_increment: f64,
    /// Whether the stress of the iterate is extrapolated from the last increment (mixed form).
    pub(super) extrapolated: bool,
    /// Limit of the error's energy, from the estimate of a time step's error.
    pub(super) limit: f64,
}

/// Multiple of the mass, relative to the largest ratio of stiffness to mass, that is added to the tangent of an unloaded model that is
/// free to move.
const HANGING: f64 = 1e-8;

/// Setting of one iteration.
#[derive(Clone, Copy)]
pub(super) struct Setting {
    /// Number of the iteration, from 1.
    pub(super) number: u32,
    pub(super) coefficients: TangentCoefficients,
    /// Mixed form: the stress of the tangent is extrapolated.
    pub(super) mixed: bool,
    /// Whether the increment holds changes of prescribed values.
    pub(super) prescribed: bool,
    /// Whether the present factor gives the increment (modified Newton).
    pub(super) reuse: bool,
}

/// Increment of an iteration by its energy and norm.
#[derive(Clone, Copy)]
pub(super) struct Size {
    pub(super) energy: f64,
    pub(super) norm: f64,
    /// Energy scale of the equation.
    pub(super) scale: f64,
}

impl<S: TangentSolver> Newton<S> {
    /// Newton's method: `K δ = R`, `u ← u ⊕ δ` until energy and norm of δ are small.
    pub(super) fn iterate(
        &mut self,
        system: &System,
        equation: &mut dyn Equation,
        history: &[f64],
        tolerances: &Tolerances,
        observer: &mut dyn Observer,
    ) -> Result<Converged, Failed> {
        self.begin_step();
        let mut progress = Progress {
            tangents: 0,
            negative_pivots: 0,
            tangent_energy: f64::INFINITY,
            asked: 0,
            first_increment: 0.0,
            extrapolated: true,
            limit: f64::INFINITY,
        };
        for number in 1..=tolerances.max_iterations {
            self.iterations = number;
            if observer.interrupted() {
                return Err((Cause::Interrupted, "interrupted".into()));
            }
            let setting = self.setting(system, equation, number, tolerances);
            if setting.mixed && !setting.reuse && !progress.extrapolated {
                self.assembly.reset_stress(system, &point(system, equation, history));
            }
            let prepared = self.residual_and_tangent(system, equation, history, &setting);
            self.reduce_residual(system, equation, history, &setting)?;
            if !setting.reuse {
                progress.tangents += 1;
                progress.negative_pivots = prepared.map_err(|reason| {
                    // A force law may have a value where it has no slope.
                    let without =
                        self.assembly.reason_without_forces(system, &point(system, equation, history));
                    without.map_or((Cause::Tangent, reason), |reason| (Cause::Flight, reason))
                })?;
                self.take_constraints(system, equation, history)?;
                let moving = setting.coefficients.mass != 0.0;
                if let Some(constraints) =
                    self.constraints.as_ref().filter(|_| progress.negative_pivots > 0 && !moving)
                {
                    progress.negative_pivots =
                        progress.negative_pivots.saturating_sub(constraints.negative_eigenvalues());
                }
                self.most_negative_pivots = self.most_negative_pivots.max(progress.negative_pivots);
                self.factored = if system.linear {
                    FactoredTangent::Linear(setting.coefficients)
                } else {
                    FactoredTangent::Iterate
                };
            }
            let energy = self.find_increment(system, equation, &setting)?;
            if self.misleads(system, equation, &setting, tolerances, energy)? {
                self.factored = FactoredTangent::Nothing;
                continue;
            }
            if number == 1 {
                progress.first_increment = system.norm(&self.increment);
                self.first_response.copy_from_slice(&self.increment);
            }
            let norm = self.update(system, equation, history, &setting)?;
            progress.extrapolated = setting.mixed && !setting.reuse;
            let size =
                Size { energy, norm, scale: equation.energy_scale(system, &mut self.assembly, history) };
            if let Some(done) =
                self.converged(system, equation, (&setting, tolerances), size, &mut progress, observer)?
            {
                return Ok(done);
            }
        }
        if let Some(open) = self.open_joint(system, equation) {
            return Err((Cause::Constraints, open));
        }
        let place = largest(system, &self.assembly.frames, &self.residual);
        let reason = format!("not converged after {} iterations; {place}", tolerances.max_iterations);
        Err((Cause::Iterations, reason))
    }

    pub(super) fn begin_step(&mut self) {
        self.increments.clear();
        self.solver.begin_step();
        if let Some(loads) = &mut self.circulatory {
            loads.begin_step();
        }
        if let Some(constraints) = &mut self.constraints {
            constraints.begin_step();
        }
        if self.factored == FactoredTangent::Iterate {
            self.factored = FactoredTangent::Nothing;
        }
    }

    /// Setting of an iteration; changes of prescribed values are written into the increment.
    fn setting(
        &mut self,
        system: &System,
        equation: &dyn Equation,
        number: u32,
        tolerances: &Tolerances,
    ) -> Setting {
        let prescribed = equation.prescribed(system, &mut self.increment);
        let coefficients = equation.parts();
        let left = tolerances.max_iterations - number;
        // Stability is judged with the forces of joints in the last tangent.
        let judged = coefficients.mass == 0.0 && self.constraints.is_some();
        let reuse = !prescribed
            && !judged
            && match self.factored {
                FactoredTangent::Nothing => false,
                FactoredTangent::Linear(c) => {
                    (c.weights, c.mass) == (coefficients.weights, coefficients.mass)
                }
                FactoredTangent::Lagged | FactoredTangent::Iterate => {
                    self.increments.old_factor_serves(coefficients.mass != 0.0, self.price, left)
                }
            };
        let mixed = self.method == NewtonMethod::Mixed && !system.linear;
        Setting { number, coefficients, mixed, prescribed, reuse }
    }

    /// Residual `external − inertia − internal` of the iterate and, where no factor is reused, the factored tangent, whose
    /// number of negative pivots is returned, or why the factorisation failed.
    fn residual_and_tangent(
        &mut self,
        system: &System,
        equation: &dyn Equation,
        history: &[f64],
        setting: &Setting,
    ) -> Result<usize, String> {
        equation.external_minus_inertia(system, &mut self.residual);
        let k = point(system, equation, history);
        self.assembly.follow(system, &k);
        let prepared = if setting.reuse {
            self.assembly.forces(system, &k, &mut self.internal);
            Ok(0)
        } else {
            self.factor(system, &k, setting)
        };
        if setting.prescribed {
            add_follower_stiffness(
                system,
                &k.motion,
                &setting.coefficients,
                &self.increment,
                &mut self.residual,
            );
        }
        for (r, f) in self.residual.iter_mut().zip(&self.internal) {
            for i in 0..3 {
                r[i] -= setting.coefficients.weights.force * f[i];
            }
        }
        prepared
    }

    /// Internal forces and factored tangent of an iterate.
    fn factor(&mut self, system: &System, k: &EvaluationPoint, setting: &Setting) -> Result<usize, String> {
        let Self { solver, assembly, internal, circulatory, .. } = self;
        let parts = &setting.coefficients;
        if let Some(loads) = circulatory {
            loads.take(system, &k.motion, parts);
        }
        let prescribed = setting.prescribed.then_some(self.increment.as_slice());
        let at = Linearization { system, point: k, parts, extrapolated: setting.mixed, prescribed };
        self.factored = FactoredTangent::Nothing;
        // Without load nothing holds a body that hangs on a hinge; the forces of the next iterate will.
        let hangs =
            setting.number == 1 && parts.mass == 0.0 && !k.linear && !system.coordinates.bodies.is_empty();
        let mut shifted = false;
        loop {
            solver.assemble(assembly, &at, internal);
            solver.add_curvature(assembly, &at, &self.residual);
            if system.has_body_curvature(&parts.weights) {
                let rest = (setting.mixed, self.residual.as_slice());
                assembly.add_body_curvature(system, k, &parts.weights, rest);
            }
            // Non-finite forces are reported later, with a better message than that of a failed factorisation.
            if !internal.iter().flatten().all(|f| f.is_finite()) {
                return Ok(0);
            }
            if shifted {
                assembly.add_mass_shift(system, HANGING);
            }
            match solver.prepare(assembly).transpose() {
                Some(Err(reason)) if hangs && !shifted && reason == SINGULAR => shifted = true,
                Some(done) => return done,
                None => {}
            }
        }
    }

    /// Schur complement of the constraints of joints, with the factored tangent of the iterate.
    fn take_constraints(
        &mut self,
        system: &System,
        equation: &dyn Equation,
        history: &[f64],
    ) -> Result<(), Failed> {
        let Self { solver, assembly, constraints, .. } = self;
        let Some(constraints) = constraints else { return Ok(()) };
        let at = (&point(system, equation, history), &equation.parts().weights);
        constraints.take(system, at, &assembly.frames, solver).map_err(|reason| (Cause::Tangent, reason))
    }

    /// Right side in the free degrees of freedom, in the local frames of the factored tangent.
    fn reduce_residual(
        &mut self,
        system: &System,
        equation: &dyn Equation,
        history: &[f64],
        setting: &Setting,
    ) -> Result<(), Failed> {
        let reuse = setting.reuse;
        if reuse {
            // The constraint force of an inextensible director must not act as a force in the local frame of
            // another state.
            self.assembly.frames.free_part(&mut self.residual);
            self.frames.copy_triads(&self.assembly.frames);
        } else {
            self.frames.copy_from(&self.assembly.frames);
        }
        if let Some(rotations) = self.corotational.as_ref().filter(|_| self.turns(reuse)) {
            rotations.turn(system, true, &mut self.residual);
        }
        self.frames.reduce(&self.residual, &mut self.right_side);
        if self.right_side.iter().all(|r| r.is_finite()) {
            return Ok(());
        }
        Err(match self.assembly.without_answer(system) {
            Some(element) => (
                Cause::Material,
                format!(
                    "{element}: the material law could not be evaluated (det F ≤ 0), or the iteration of its enhanced \
                     strains (`eas`) did not converge"
                ),
            ),
            None => {
                let reason = self.assembly.reason_without_forces(system, &point(system, equation, history));
                (Cause::Flight, reason.unwrap_or_else(|| "the forces are no longer finite".into()))
            }
        })
    }

    /// Whether the factor of an earlier state is updated by the rotations of the nodes.
    fn turns(&self, reuse: bool) -> bool {
        reuse && self.factored == FactoredTangent::Lagged
    }

    /// Solves for the increment; returns the energy `|δ·R|`.
    fn find_increment(
        &mut self,
        system: &System,
        equation: &dyn Equation,
        setting: &Setting,
    ) -> Result<f64, Failed> {
        let tangent_failed = |reason: String| (Cause::Tangent, reason);
        let old = setting.reuse || setting.coefficients.mass != 0.0;
        let purpose = if old { Purpose::Contraction } else { Purpose::Increment };
        let solved = self.solve_for_right_side(Some(purpose), |constraints, x| {
            let at = (&equation.motion(), equation.parts().time);
            constraints.correct(system, at, equation.multipliers(), x);
        });
        solved.map_err(tangent_failed)?;
        if let Some(body) = spun_body(system, &self.solution) {
            return Err((
                Cause::Flight,
                format!("divergence: an increment turns body \"{body}\" by more than {SPUN} rad"),
            ));
        }
        let energy = self.solution.iter().zip(&self.right_side).map(|(a, b)| a * b).sum::<f64>().abs();
        expand_free(&self.frames, &self.solution, setting.prescribed, &mut self.increment);
        if let Some(rotations) = self.corotational.as_ref().filter(|_| self.turns(setting.reuse)) {
            rotations.turn(system, false, &mut self.increment);
        }
        if energy.is_finite() {
            Ok(energy)
        } else {
            Err((Cause::Flight, "the increment is not finite".into()))
        }
    }

    /// Whether a lagged tangent gave an increment that must not be applied: where large steps have several solutions it
    /// could lead to another one.
    fn misleads(
        &self,
        system: &System,
        equation: &dyn Equation,
        setting: &Setting,
        tolerances: &Tolerances,
        energy: f64,
    ) -> Result<bool, Failed> {
        if !setting.reuse || system.linear {
            return Ok(false);
        }
        let size = system.norm(&self.increment);
        let matters = size > tolerances.increment * equation.displacement_scale(system);
        if !(matters && self.increments.too_large(energy, size)) {
            return Ok(false);
        }
        if self.factored == FactoredTangent::Lagged {
            let reason = "with the lagged tangent the increments do not decrease fast enough";
            return Err((Cause::OldTangent, reason.into()));
        }
        Ok(true)
    }

    /// Applies the increment: step limiter, extrapolated stress, retraction of inextensible directors. Returns its norm.
    fn update(
        &mut self,
        system: &System,
        equation: &mut dyn Equation,
        history: &[f64],
        setting: &Setting,
    ) -> Result<f64, Failed> {
        // Under follower loads that rotate with the shell, or rotate it, later increments overshoot as far.
        if (setting.number == 1 || !system.followers.is_empty())
            && let Some(turn) = equation.first_rotation_limit(system)
        {
            limit_rotation(system, turn, &mut self.increment);
        }
        if setting.mixed && !setting.reuse {
            let k = point(system, equation, history);
            self.assembly.extrapolate(system, &k, &self.increment, &setting.coefficients.weights);
        }
        if !system.linear {
            retract(system, &self.assembly.frames, &equation.motion(), &mut self.increment);
        }
        equation.apply(system, &self.increment);
        if let Some(constraints) = &self.constraints {
            equation.change_multipliers(constraints.change());
        }
        let norm = system.norm(&self.increment);
        // Linear models have no size that a displacement must not exceed.
        if norm > FLIGHT && !system.linear {
            let place = largest(system, &self.assembly.frames, &self.residual);
            let reason =
                format!("divergence: an increment moved the model by {norm:.1e} times its own size; {place}");
            return Err((Cause::Flight, reason));
        }
        Ok(norm)
    }
}

/// Step limiter: scales an increment that rotates a director by more than `turn` (rad), or moves a node by more than
/// `turn` times the model's length.
fn limit_rotation(system: &System, turn: f64, increment: &mut [Nodal]) {
    let size = |(d, kind): (&Nodal, &VectorKind)| {
        let length = if *kind == VectorKind::Position { system.length } else { 1.0 };
        dot(&[*d], &[*d]).sqrt() / length
    };
    let largest = increment.iter().zip(&system.coordinates.kinds).map(size).fold(0.0, crate::norm::larger);
    if largest > turn {
        increment.iter_mut().for_each(|d| *d = d.map(|x| x * (turn / largest)));
    }
}

/// Retraction of the increments of inextensible directors onto the unit sphere, along the great circle (exponential
/// map), and of the directors of rigid bodies onto rotations.
pub(in crate::analysis) fn retract(
    system: &System,
    frames: &LocalFrames,
    motion: &Motion,
    increment: &mut [Nodal],
) {
    let (Motion::State { u, .. } | Motion::Step { new: u, .. }) = motion;
    retract_bodies(system, frames, u, increment);
    for unit in &frames.dofs().unit {
        let v = unit.vector as usize;
        let reference = Vec3::from(system.coordinates.reference[v]);
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
        // Round-off of the length is corrected along the vector only: across it a short step would take it for a
        // motion.
        let back = unit.project(target, &reference) - target;
        increment[v] = (change + target * target.dot(&back)).into();
    }
}

/// Body that an increment of the degrees of freedom turns by more than [`SPUN`]: whole turns would look like none.
pub(super) fn spun_body<'a>(system: &'a System, increment: &[f64]) -> Option<&'a str> {
    let turns = |d: &[u32; 3]| {
        let rotation = Vec3::from(system.dofs().of(d[0] as usize).map(|number| increment[number as usize]));
        !(rotation.norm() <= SPUN)
    };
    let body = system.coordinates.bodies.iter().find(|body| body.directors.as_ref().is_some_and(turns))?;
    Some(&body.name)
}

/// Retraction of the increments of the directors of rigid bodies: from the rotation δθ that they stand for, by the
/// exponential map, to directors that are orthonormal. Attached vectors follow.
fn retract_bodies(system: &System, frames: &LocalFrames, u: &[Nodal], increment: &mut [Nodal]) {
    for (triad, arms) in frames.triads() {
        // Increments are δθ × d, with the directors d of the local frame.
        let change = Mat3::from_columns(&triad.map(|v| Vec3::from(increment[v as usize])));
        let skew = change * arms.try_inverse().unwrap_or_else(Mat3::zeros);
        let rotation = 0.5 * Vec3::new(skew.m32 - skew.m23, skew.m13 - skew.m31, skew.m21 - skew.m12);
        let angle = rotation.norm();
        let (first, second) = if angle > 1e-4 {
            (angle.sin() / angle, 2.0 * ((0.5 * angle).sin() / angle).powi(2))
        } else {
            (1.0 - angle * angle / 6.0, 0.5 - angle * angle / 24.0)
        };
        for &v in triad {
            let d = Vec3::from(system.coordinates.reference[v as usize]) + Vec3::from(u[v as usize]);
            let across = rotation.cross(&d);
            increment[v as usize] = (across * first + rotation.cross(&across) * second).into();
        }
    }
    frames.dofs().carry(increment);
}
