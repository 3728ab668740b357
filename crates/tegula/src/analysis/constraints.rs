//! Constraints of joints in Newton's method: Lagrange multipliers from the Schur complement of the tangent.
//!
//! With the tangent K, constraint forces `Gᵀλ` that act in the configuration of the motion (gradients G), and constraints
//! `g = 0` at its end (gradients G₁), an increment δ and new multipliers satisfy
//!
//! ```text
//! [ K   Gᵀ ] [ δ  ]   [ R  ]
//! [ G₁  0  ] [ Δλ ] = [ −g ],      S Δλ = G₁ K⁻¹ R + g,   S = G₁ K⁻¹ Gᵀ.
//! ```
//!
//! K contains `Gᵀ γ G` (augmented Lagrangian), so that parts without mass of their own, like a rod that turns about its
//! axis, have a tangent. It does not change the solution: the multipliers of the augmented equations differ by `γ G δ`,
//! which is added.
//!
//! **Rank.** Constraints may be redundant, always or in a singular position, where their rank falls. The rank of S, scaled
//! to a unit diagonal, is decided by [Gaussian elimination with complete pivoting](complete_pivoting); where it falls, the
//! multipliers are those of minimum norm, found anew in every iteration, not from those of the step before: these lead off the
//! branch. Constraints that contradict each other cannot be satisfied, which [`violation`](Constraints::violation) finds. A
//! constraint that was left out and stays open is taken back for the rest of the step.
//!
//! **Critical points.** S is singular, too, where the tangent of the constrained motion is: with `S y = 0` the field `K⁻¹Gᵀy` satisfies the
//! constraints, and nothing balances it. It vanishes where the constraints y depend on each other, and is the mode of a critical point
//! where they do not. Equilibrium paths [tell both apart](Constraints::pass_critical_points).

mod complete_pivoting;
mod compliance;
mod gradients;
mod laws;
mod schur;

use super::State;
use super::solver::TangentSolver;
use crate::Vec3;
use crate::constraint::joint::half_motion;
use crate::constraint::{CoordinateState, Joint, Row};
use crate::element::{Motion, Nodal, TangentWeights};
use crate::system::evaluation_point::current_vector;
use crate::system::{EvaluationPoint, LocalFrames, System};
pub(super) use gradients::{gradients, gradients_at, gradients_of, joint_rates};
use laws::Laws;
pub(super) use schur::Schur;

/// Eigenvalue of the scaled Schur complement over the largest one that is round-off of a dependent constraint.
const ROUNDING: f64 = 1e-10;

/// Square of the size of a common response over that of the single ones, over its energy over theirs, above which it is a mode. Where
/// constraints nearly depend on each other both are small.
const MODE: f64 = 10.0;
/// Share of drives in constraints that depend on each other, above which the mechanism cannot follow them.
const DRIVEN: f64 = 1e-3;
/// Size of a sum of gradients over the sum of their sizes, above which the constraints are independent. Redundant joints may be placed so inaccurately, as
/// by an angle of this size.
const INDEPENDENT: f64 = 1e-2;

/// Number of products with a gradient that are summed together.
const LANES: usize = 4;

/// Gradient of a constraint with respect to the free degrees of freedom: numbers and values.
pub type Gradient = Vec<(u32, f64)>;

/// Rates of constraints.
#[derive(Debug, Clone, Copy)]
pub(super) enum Rates<'a> {
    /// First rates `ġ` of the nodal velocities.
    First(&'a [Nodal]),
    /// Second rates `g̈` of the nodal velocities and accelerations.
    Second(&'a [Nodal], &'a [Nodal]),
    /// Product `G x` of the gradients with a field.
    Along(&'a [Nodal]),
}

/// Constraints of the joints of a system, with the Schur complement of the last tangent.
pub(super) struct Constraints {
    /// Gradients in the configuration of the motion, where the constraint forces act.
    forces: Vec<Gradient>,
    /// Gradients at the end of the motion.
    ends: Vec<Gradient>,
    /// Weights γ of the augmented Lagrangian.
    weights: Vec<f64>,
    /// `K⁻¹ Gᵀ`, column by column.
    responses: Vec<f64>,
    schur: Schur,
    /// Friction and stops of joints.
    laws: Laws,
    /// First angles of gears at the end of the step before, joint by joint; 0 for other joints.
    counted: Vec<f64>,
    /// Change of the multipliers in the last increment.
    change: Vec<f64>,
    /// Right side of their equations.
    right: Vec<f64>,
    /// Largest violation at the last test of a step.
    violation: f64,
    /// Whether critical points are told from dependent constraints.
    critical: bool,
    /// Components and field of a projection.
    free: Vec<f64>,
    field: Vec<Nodal>,
    /// Local frames of the factor, with the directors of bodies at the end of the motion.
    end_frames: LocalFrames,
}

impl Constraints {
    /// Constraints of a system; `None` if it has no joints.
    pub fn new(system: &System) -> Option<Self> {
        let m = system.constraints();
        let n = system.unknowns();
        let angles = system.start.as_ref().map_or(&[][..], |start| &start.angles);
        let mut counted = vec![0.0; system.joints.len()];
        count_turns(system, angles, &mut counted);
        (m > 0).then(|| Self {
            forces: vec![Vec::new(); m],
            ends: vec![Vec::new(); m],
            weights: vec![0.0; m],
            responses: vec![0.0; n * m],
            schur: Schur::new(m),
            laws: Laws::new(system),
            counted,
            change: vec![0.0; m],
            right: vec![0.0; m],
            violation: f64::INFINITY,
            critical: false,
            free: vec![0.0; n],
            field: vec![[0.0; 3]; system.vectors()],
            end_frames: system.frames.clone(),
        })
    }

    /// Tells critical points of the constrained motion from dependent constraints: these are left out, those are not.
    pub fn pass_critical_points(&mut self) {
        self.critical = true;
    }

    /// Begins a step: the rank is decided anew.
    pub fn begin_step(&mut self) {
        self.violation = f64::INFINITY;
        self.schur.reset_cut();
    }

    /// Takes constraints back that were left out as dependent, but stay open.
    pub fn readmit(&mut self) {
        self.schur.readmit();
    }

    /// Takes the tangent that `solver` has factored, at an evaluation point whose local frames are `frames`.
    ///
    /// # Errors
    /// The linear solver failed.
    pub fn take<S: TangentSolver>(
        &mut self,
        system: &System,
        (k, weights): (&EvaluationPoint, &TangentWeights),
        frames: &LocalFrames,
        solver: &mut S,
    ) -> Result<(), String> {
        let n = system.unknowns();
        let acting = |v: usize| current_vector(system, &k.motion, v);
        let half = |v: usize| half_motion(&k.motion, v);
        gradients(system, (frames, k.time), (acting, half), &mut self.forces);
        self.end_gradients(system, frames, &k.motion, end_time(&k.motion, k.time));
        for joint in system.joints.iter() {
            for (i, row) in joint.multipliers().zip(&joint.rows) {
                self.weights[i] = row.weight(weights);
            }
        }
        self.responses.fill(0.0);
        for (gradient, response) in self.forces.iter().zip(self.responses.chunks_mut(n)) {
            for &(number, value) in gradient {
                response[number as usize] = value;
            }
        }
        solver.solve_tangents(&mut self.responses, self.forces.len())?;
        self.laws.couple(system, k, &mut self.responses);
        for (row, gradient) in self.schur.matrix.chunks_mut(self.forces.len()).zip(&self.ends) {
            for (entries, responses) in row.chunks_mut(LANES).zip(self.responses.chunks(LANES * n)) {
                products(gradient, responses, n, entries);
            }
        }
        self.laws.separate(&mut self.schur.matrix);
        self.schur.factor();
        if self.critical {
            self.admit_independent(system, (&k.motion, k.time));
        }
        Ok(())
    }

    /// Counts constraints as independent whose common response is a mode: its energy `yᵀ S y` is negative, or small for its size. A mode whose pivot is
    /// round-off is not told from dependent constraints.
    ///
    /// Dependent constraints of which one is driven are independent, too: where a mechanism cannot follow its drive, the load factor does not
    /// change.
    fn admit_independent(&mut self, system: &System, at: (&Motion, f64)) {
        let n = self.free.len();
        if self.schur.dependent() == 0 {
            return;
        }
        let at_rest = vec![[0.0; 3]; system.vectors()];
        let driven: Vec<bool> =
            self.rates(system, at, Rates::First(&at_rest)).iter().map(|rate| *rate != 0.0).collect();
        while let Some(pivot) = self.schur.first_null_vector(&mut self.right) {
            let [whole, of_drives] = [false, true].map(|only| self.schur.largest(&self.right, &driven, only));
            self.free.fill(0.0);
            let mut size = 0.0;
            for (y, response) in self.right.iter().zip(self.responses.chunks(n)).filter(|(y, _)| **y != 0.0) {
                self.free.iter_mut().zip(response).for_each(|(x, z)| *x += y * z);
                self.end_frames.expand(response, &mut self.field);
                size += y.abs() * system.norm(&self.field);
            }
            self.end_frames.expand(&self.free, &mut self.field);
            let relative = system.norm(&self.field) / size;
            let is_mode = relative * relative > MODE * pivot || of_drives > DRIVEN * whole;
            if !(pivot.abs() > ROUNDING && is_mode) {
                break;
            }
            self.schur.admit_next();
        }
    }

    /// Counts constraints as independent whose gradients, divided by the `scales` of the free degrees of freedom, are so: where the compliances of bodies
    /// and parts differ much, their pivots in S are small, too.
    pub fn admit_independent_gradients(&mut self, scales: &[f64]) {
        while let Some(pivot) = self.schur.first_null_vector(&mut self.right) {
            self.free.fill(0.0);
            let mut sizes = 0.0;
            for (y, gradient) in self.right.iter().zip(&self.ends).filter(|(y, _)| **y != 0.0) {
                let mut square = 0.0;
                for &(number, value) in gradient {
                    let term = y * value / scales[number as usize];
                    self.free[number as usize] += term;
                    square += term * term;
                }
                sizes += square.sqrt();
            }
            let size = self.free.iter().map(|x| x * x).sum::<f64>().sqrt();
            if !(pivot.abs() > ROUNDING && size > INDEPENDENT * sizes) {
                break;
            }
            self.schur.admit_next();
        }
    }

    /// Changes the increment `x = K⁻¹ R` to that of the constrained motion; the change of the multipliers is kept.
    /// `multipliers` are those of the iterate, `time` the one at which the forces of the motion act.
    pub fn correct(
        &mut self,
        system: &System,
        (motion, time): (&Motion, f64),
        multipliers: &[f64],
        x: &mut [f64],
    ) {
        self.laws.follow(system, motion, multipliers);
        self.laws.add_response(&self.responses, x);
        let (end, time) = (end_of(system, motion), end_time(motion, time));
        for joint in system.joints.iter() {
            let target = target(system, (&self.laws, &self.counted), joint, time);
            joint.with_vectors(&end, |v, _| {
                for (i, row) in joint.multipliers().zip(&joint.rows) {
                    self.right[i] = row.value(v, target) + product(&self.ends[i], x);
                }
            });
        }
        self.change_by_multipliers(multipliers, x);
    }

    /// Solves for the change of the multipliers and adds their response to the increment x.
    fn change_by_multipliers(&mut self, multipliers: &[f64], x: &mut [f64]) {
        self.laws.clear(&mut self.right);
        self.schur.solve(&mut self.right, multipliers, &mut self.change);
        for (change, response) in self.change.iter().zip(self.responses.chunks(x.len())) {
            x.iter_mut().zip(response).for_each(|(x, z)| *x -= change * z);
        }
        for (i, change) in self.change.iter_mut().enumerate() {
            *change += self.weights[i] * product(&self.forces[i], x);
        }
        self.laws.complete(&mut self.change);
    }

    /// Takes the modes of the relative coordinates with friction or stops; the next tangent is that of these modes.
    pub fn set_modes(&mut self, coordinates: &[CoordinateState]) {
        self.laws.set_modes(coordinates);
    }

    /// Takes the angles of a state from which a step starts: those of gears count their turns.
    pub fn set_angles(&mut self, system: &System, angles: &[f64]) {
        count_turns(system, angles, &mut self.counted);
    }

    /// Lets friction follow reactions, or not: impulses do without it.
    pub fn set_friction(&mut self, acts: bool) {
        self.laws.set_friction(acts);
    }

    /// Rates of the constraints at the end of a motion.
    pub fn rates(&mut self, system: &System, (motion, time): (&Motion, f64), rates: Rates) -> &[f64] {
        let (end, time) = (end_of(system, motion), end_time(motion, time));
        for joint in system.joints.iter() {
            let drive = self.laws.drive(system, joint, time);
            joint_rates(joint, (&end, drive), rates, &mut self.right);
        }
        self.laws.clear(&mut self.right);
        &self.right
    }

    /// Schur complement of the last tangent.
    pub fn schur(&self) -> &Schur {
        &self.schur
    }

    /// Messages about joints with constraints that are redundant at the last tangent.
    pub fn redundant<'a>(&'a self, system: &'a System) -> impl Iterator<Item = String> + 'a {
        self.schur.redundant(system)
    }

    /// Changes rates `x` of the free degrees of freedom so that the constraints' rates, which are `rest` without x, vanish:
    /// `G₁ x = −rest`, with the least change in the norm of the tangent that was [taken](Self::take). Returns the
    /// multipliers of the change.
    pub fn project(&mut self, system: &System, at: (&Motion, f64), rest: Rates, x: &mut [f64]) -> &[f64] {
        self.rates(system, at, rest);
        self.project_onto(x)
    }

    /// Changes velocities by an impact: a constraint i with the rate `ġ⁻ᵢ` of the velocities `v` has the rate `−e(i) ġ⁻ᵢ` with `v + x`.
    /// Returns the impulses.
    pub fn impact(
        &mut self,
        system: &System,
        at: (&Motion, f64),
        v: &[Nodal],
        restitution: impl Fn(usize) -> f64,
        x: &mut [f64],
    ) -> &[f64] {
        self.rates(system, at, Rates::First(v));
        for (i, rate) in self.right.iter_mut().enumerate() {
            *rate *= 1.0 + restitution(i);
        }
        x.fill(0.0);
        self.change_by_multipliers(&[], x);
        &self.change
    }

    /// Changes accelerations `x` to those of the constrained motion, as [`project`](Self::project) does, with friction of the multipliers.
    pub fn project_accelerations(
        &mut self,
        system: &System,
        at: (&Motion, f64),
        (rest, multipliers): (Rates, &[f64]),
        x: &mut [f64],
    ) -> &[f64] {
        self.laws.follow(system, at.0, multipliers);
        self.laws.add_response(&self.responses, x);
        self.project(system, at, rest, x)
    }

    /// Changes an increment `x` of the free degrees of freedom to one that keeps the constraints, `G₁ x = 0`, with the least change
    /// in the norm of the last tangent.
    pub fn constrain(&mut self, x: &mut [f64]) {
        self.right.fill(0.0);
        self.project_onto(x);
    }

    /// Changes x so that `G₁ x` vanishes together with the right side.
    fn project_onto(&mut self, x: &mut [f64]) -> &[f64] {
        for (right, gradient) in self.right.iter_mut().zip(&self.ends) {
            *right += product(gradient, x);
        }
        self.change_by_multipliers(&[], x);
        &self.change
    }

    /// Changes the solution `x = K⁻¹ b` of the last tangent, in which the constraint forces act, to that with the rates `G₁ x = −rest` of the
    /// constraints. Returns the multipliers that balance b.
    pub fn satisfy(&mut self, rest: &[f64], x: &mut [f64]) -> &[f64] {
        self.right.copy_from_slice(rest);
        self.project_onto(x)
    }

    /// A free degree of freedom of each constraint that does not follow from others at the last tangent.
    pub fn independent(&self) -> impl Iterator<Item = u32> {
        let independent = self.schur.independent().iter();
        independent.filter_map(|&row| self.ends[row].first().map(|(number, _)| *number))
    }

    /// Number of negative eigenvalues of the Schur complement. The tangent of the constrained motion, on the null space of G, has
    /// as many fewer of them than the whole tangent (inertia of the bordered matrix; E. Haynsworth, Linear Algebra Appl. 1 (1968)
    /// 73–81).
    pub fn negative_eigenvalues(&self) -> usize {
        let m = self.change.len();
        let entry = |i: usize, j: usize| 0.5 * (self.schur.matrix[i * m + j] + self.schur.matrix[j * m + i]);
        let values = nalgebra::DMatrix::from_fn(m, m, entry).symmetric_eigenvalues();
        let size = values.iter().map(|x| x.abs()).fold(0.0, crate::norm::larger);
        values.iter().filter(|x| **x < -ROUNDING * size).count()
    }

    /// Changes a field of nodal vectors, like a difference of accelerations, so that it has no part across the constraints at the
    /// end of a motion: `G₁ x = 0`, with the least change in the norm of the last tangent.
    pub fn take_tangential_part(&mut self, system: &System, at: (&Motion, f64), field: &mut [Nodal]) {
        let (mut free, mut change) = (std::mem::take(&mut self.free), std::mem::take(&mut self.field));
        free.fill(0.0);
        self.project(system, at, Rates::Along(field), &mut free);
        self.end_frames.expand(&free, &mut change);
        for (x, change) in field.as_flattened_mut().iter_mut().zip(change.as_flattened()) {
            *x += change;
        }
        (self.free, self.field) = (free, change);
    }

    /// Changes velocities at displacements `u` so that they keep the joints closed, with the least change in the norm of the last
    /// tangent, which is mostly that of the mass in short steps. Returns the multipliers of the change.
    pub fn project_velocities(
        &mut self,
        system: &System,
        (u, time): (&[Nodal], f64),
        v: &mut [Nodal],
    ) -> &[f64] {
        let motion = Motion::State { u, velocity: None };
        let (mut free, mut change) = (std::mem::take(&mut self.free), std::mem::take(&mut self.field));
        free.fill(0.0);
        self.project(system, (&motion, time), Rates::First(v), &mut free);
        self.end_frames.expand(&free, &mut change);
        for (x, change) in v.as_flattened_mut().iter_mut().zip(change.as_flattened()) {
            *x += change;
        }
        (self.free, self.field) = (free, change);
        &self.change
    }

    /// Change of the multipliers in the last increment.
    pub fn change(&self) -> &[f64] {
        &self.change
    }

    /// Gradients at the end of a motion, with respect to rotations of the bodies there.
    fn end_gradients(&mut self, system: &System, frames: &LocalFrames, motion: &Motion, time: f64) {
        let end = end_of(system, motion);
        // Degrees of freedom of nodes count in the frames of the factor.
        self.end_frames.copy_from(frames);
        self.end_frames.follow_bodies(&end);
        gradients(system, (&self.end_frames, time), (end, |_| Vec3::zeros()), &mut self.ends);
    }

    /// Largest value of a constraint at the end of a motion over its size; infinite where a drive is half a turn away from its angle.
    pub fn largest_violation(&self, system: &System, (motion, time): (&Motion, f64)) -> f64 {
        let (end, time) = (end_of(system, motion), end_time(motion, time));
        let of_joint = |joint: &Joint| of_joint(system, (&self.laws, &self.counted), joint, (&end, time));
        system.joints.iter().map(of_joint).fold(0.0, crate::norm::larger)
    }

    /// Whether constraints that a step left open by `violation` close with further iterations: they do not where it has not halved since the
    /// last test.
    pub fn closes(&mut self, violation: f64) -> bool {
        let before = std::mem::replace(&mut self.violation, violation);
        violation < 0.5 * before
    }

    /// First joint with a constraint whose value at the end of a motion over its size is above a limit, as text.
    pub fn violation(&self, system: &System, (motion, time): (&Motion, f64), limit: f64) -> Option<String> {
        let (end, time) = (end_of(system, motion), end_time(motion, time));
        system.joints.iter().find_map(|joint| {
            let worst = of_joint(system, (&self.laws, &self.counted), joint, (&end, time));
            if worst == f64::INFINITY {
                return Some(format!("joint \"{}\" is half a turn away from its angle", joint.name));
            }
            let open = || format!("joint \"{}\" is open by {worst:.1e} of the model's size", joint.name);
            (!(worst <= limit)).then(open)
        })
    }
}

/// Values of all constraints in a state, in the order of its multipliers; 0 for those of friction and stops.
pub(super) fn values_at(system: &System, state: &State) -> Vec<f64> {
    values_of(system, (&state.u, state.time), &state.angles)
}

/// Values of the constraints at displacements and a time, with the angles that a state counts.
pub(super) fn values_of(system: &System, (u, time): (&[Nodal], f64), angles: &[f64]) -> Vec<f64> {
    let (laws, mut counted) = (Laws::new(system), vec![0.0; system.joints.len()]);
    count_turns(system, angles, &mut counted);
    let mut out = vec![0.0; system.constraints()];
    let motion = Motion::State { u, velocity: None };
    for joint in system.joints.iter() {
        let target = target(system, (&laws, &counted), joint, time);
        joint.with_vectors(end_of(system, &motion), |v, _| {
            for (i, row) in joint.multipliers().zip(&joint.rows) {
                out[i] = row.value(v, target);
            }
        });
    }
    laws.clear(&mut out);
    out
}

/// First angles of gears from those of a state, joint by joint.
pub(super) fn count_turns(system: &System, angles: &[f64], out: &mut [f64]) {
    let gears = angles.get(system.angle_sensors().count()..).unwrap_or_default();
    for ((joint, _), angle) in system.counted_angles().zip(gears) {
        out[joint.number] = *angle;
    }
}

/// Value on which the constraints of a joint depend beside its nodal vectors: that of its drive, at which its relative coordinate is held,
/// or of its first angle at the end of the step before.
fn target(system: &System, (laws, counted): (&Laws, &[f64]), joint: &Joint, time: f64) -> f64 {
    match counted.get(joint.number).filter(|_| joint.counted.is_some()) {
        Some(angle) => *angle,
        None => laws.target(system, joint, time),
    }
}

/// Largest value of a constraint of a joint over its size; infinite where its drive is half a turn away from its angle. Released joints
/// have no constraints, and coordinates that move none.
fn of_joint(
    system: &System,
    (laws, counted): (&Laws, &[f64]),
    joint: &Joint,
    (end, time): (impl Fn(usize) -> Vec3, f64),
) -> f64 {
    let drive = target(system, (laws, counted), joint, time);
    joint.with_vectors(end, |v, _| {
        let value = |(i, row): (usize, &Row)| match row.is_on_branch(v, drive) {
            _ if laws.is_moving(i) => 0.0,
            true => row.value(v, drive).abs() / row.size,
            false => f64::INFINITY,
        };
        joint.multipliers().zip(&joint.rows).map(value).fold(0.0, crate::norm::larger)
    })
}

/// Nodal vectors at the end of a motion.
pub(super) fn end_of<'a>(system: &'a System, motion: &'a Motion) -> impl Fn(usize) -> Vec3 + 'a {
    let (Motion::State { u, .. } | Motion::Step { new: u, .. }) = motion;
    move |v| Vec3::from(system.coordinates.reference[v]) + Vec3::from(u[v])
}

/// Time of the end of a motion whose forces act at `time`: in the middle of a step.
fn end_time(motion: &Motion, time: f64) -> f64 {
    match motion {
        Motion::State { .. } => time,
        Motion::Step { dt, .. } => time + 0.5 * dt,
    }
}

/// Products of a gradient with some fields of n components each, one after another.
fn products(gradient: &Gradient, fields: &[f64], n: usize, out: &mut [f64]) {
    let mut sums = [0.0; LANES];
    if out.len() == LANES {
        for &(number, g) in gradient {
            (0..LANES).for_each(|lane| sums[lane] += g * fields[lane * n + number as usize]);
        }
        out.copy_from_slice(&sums);
    } else {
        out.iter_mut().zip(fields.chunks(n)).for_each(|(out, field)| *out = product(gradient, field));
    }
}

pub(super) fn product(gradient: &Gradient, x: &[f64]) -> f64 {
    gradient.iter().map(|&(n, g)| g * x[n as usize]).sum()
}
