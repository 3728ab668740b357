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
//! to a unit diagonal, is decided by Gaussian elimination with complete pivoting; where it falls, the multipliers are those
//! of minimum norm (G. Golub, C. Van Loan, *Matrix computations*, Sect. 5.5), found anew in every iteration, not from those
//! of the step before: these lead off the branch. Constraints that contradict each other cannot be satisfied, which
//! [`violation`](Constraints::violation) finds. A constraint that was left out and stays open is taken back for the rest of
//! the step.

use nalgebra::linalg::FullPivLU;
use nalgebra::{DMatrix, DVector, Dyn};

use super::solver::TangentSolver;
use crate::Vec3;
use crate::constraint::Joint;
use crate::element::{Motion, Nodal, TangentWeights};
use crate::system::dof_map::CONSTRAINED;
use crate::system::evaluation_point::current_vector;
use crate::system::{EvaluationPoint, LocalFrames, System};

/// Pivot of the scaled Schur complement over the largest one, below which constraints count as dependent; and its decrease
/// where one of these constraints stays open.
const DEPENDENT: f64 = 1e-4;
const READMITTED: f64 = 1e-3;

/// Gradient of a constraint with respect to the free degrees of freedom: numbers and values, some numbers more than once.
type Gradient = Vec<(u32, f64)>;

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
    /// Change of the multipliers in the last increment.
    change: Vec<f64>,
    /// Right side of their equations.
    right: DVector<f64>,
    /// Local frames of the factor, with the directors of bodies at the end of the motion.
    end_frames: LocalFrames,
    /// Nodal vectors and gradients of a joint.
    vectors: Vec<Vec3>,
    row: Vec<Vec3>,
}

impl Constraints {
    /// Constraints of a system; `None` if it has no joints.
    pub fn new(system: &System) -> Option<Self> {
        let m = system.constraints();
        let n = system.unknowns();
        (m > 0).then(|| Self {
            forces: vec![Vec::new(); m],
            ends: vec![Vec::new(); m],
            weights: vec![0.0; m],
            responses: vec![0.0; n * m],
            schur: Schur::new(m),
            change: vec![0.0; m],
            right: DVector::zeros(m),
            end_frames: system.frames.clone(),
            vectors: Vec::new(),
            row: Vec::new(),
        })
    }

    /// Begins a step: the rank is decided anew.
    pub fn begin_step(&mut self) {
        if self.schur.cut < DEPENDENT {
            self.schur.cut = DEPENDENT;
            self.schur.decide_rank();
        }
    }

    /// Takes constraints back that were left out as dependent, but stay open.
    pub fn readmit(&mut self) {
        self.schur.cut *= READMITTED;
        self.schur.decide_rank();
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
        self.gradients(system, (frames, k.time), acting, |this| &mut this.forces);
        self.end_gradients(system, frames, &k.motion, end_time(&k.motion, k.time));
        for joint in system.joints.iter() {
            for (i, row) in joint.multipliers().zip(&joint.rows) {
                self.weights[i] = row.weight(weights);
            }
        }
        self.responses.fill(0.0);
        for (gradient, response) in self.forces.iter().zip(self.responses.chunks_mut(n)) {
            for &(number, value) in gradient {
                response[number as usize] += value;
            }
            solver.solve_tangent(response)?;
        }
        for (i, gradient) in self.ends.iter().enumerate() {
            for (j, response) in self.responses.chunks(n).enumerate() {
                self.schur.matrix[(i, j)] = product(gradient, response);
            }
        }
        self.schur.factor();
        Ok(())
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
        let (end, time) = (end_of(system, motion), end_time(motion, time));
        for joint in system.joints.iter() {
            self.vectors.clear();
            self.vectors.extend(joint.vectors.iter().map(|&v| end(v as usize)));
            let drive = system.drive(joint, time).value;
            for (i, row) in joint.multipliers().zip(&joint.rows) {
                self.right[i] = row.value(&self.vectors, drive) + product(&self.ends[i], x);
            }
        }
        self.schur.solve(&mut self.right, multipliers, &mut self.change);
        self.subtract_responses(x);
        for (i, change) in self.change.iter_mut().enumerate() {
            *change += self.weights[i] * product(&self.forces[i], x);
        }
    }

    /// Rates of the constraints at the state of a motion: `ġ` of the nodal velocities `v`, and with accelerations `a` the
    /// second rates `g̈`.
    pub fn rates(
        &self,
        system: &System,
        (motion, time): (&Motion, f64),
        v: &[Nodal],
        a: Option<&[Nodal]>,
    ) -> Vec<f64> {
        let (end, time) = (end_of(system, motion), end_time(motion, time));
        let mut out = Vec::with_capacity(self.ends.len());
        for joint in system.joints.iter() {
            let of = |field: &[Nodal]| -> Vec<Vec3> {
                joint.vectors.iter().map(|&n| Vec3::from(field[n as usize])).collect()
            };
            let (q, rate) = (joint.vectors.iter().map(|&n| end(n as usize)).collect::<Vec<_>>(), of(v));
            let drive = system.drive(joint, time);
            for row in &joint.rows {
                let mut gradient = vec![Vec3::zeros(); q.len()];
                row.add_gradient(1.0, &q, drive.value, &mut gradient);
                let along = |field: &[Vec3]| gradient.iter().zip(field).map(|(g, x)| g.dot(x)).sum::<f64>();
                out.push(match a {
                    None => along(&rate) + row.driven_rate(&q, drive),
                    Some(a) => along(&of(a)) + row.velocity_term(&q, &rate, drive),
                });
            }
        }
        out
    }

    /// Names of the joints with redundant constraints at the last tangent, and how many each has.
    pub fn redundant(&self, system: &System) -> Vec<(String, usize)> {
        let dependent = self.schur.dependent();
        let count = |joint: &Joint| dependent.iter().filter(|row| joint.multipliers().contains(*row)).count();
        let named = system.joints.iter().map(|joint| (joint.name.clone(), count(joint)));
        named.filter(|(_, count)| *count > 0).collect()
    }

    /// Changes rates `x` of the free degrees of freedom so that the constraints' rates, which are `rest` without x, vanish:
    /// `G₁ x = −rest`, with the least change in the norm of the tangent that was [taken](Self::take). Returns the
    /// multipliers of the change.
    pub fn project(&mut self, rest: &[f64], x: &mut [f64]) -> &[f64] {
        for (i, gradient) in self.ends.iter().enumerate() {
            self.right[i] = rest[i] + product(gradient, x);
        }
        self.schur.solve(&mut self.right, &[], &mut self.change);
        self.subtract_responses(x);
        for (i, change) in self.change.iter_mut().enumerate() {
            *change += self.weights[i] * product(&self.forces[i], x);
        }
        &self.change
    }

    /// Changes a field of nodal vectors, like a difference of accelerations, so that it has no part across the constraints at the
    /// end of a motion: `G₁ x = 0`, with the least change in the norm of the last tangent.
    pub fn take_tangential_part(
        &mut self,
        system: &System,
        (motion, time): (&Motion, f64),
        field: &mut [Nodal],
    ) {
        let mut change = vec![[0.0; 3]; field.len()];
        let without = self.rates(system, (motion, time), &change, None);
        let mut rates = self.rates(system, (motion, time), field, None);
        rates.iter_mut().zip(without).for_each(|(rate, own)| *rate -= own);
        let mut free = vec![0.0; system.unknowns()];
        self.project(&rates, &mut free);
        self.end_frames.expand(&free, &mut change);
        for (x, change) in field.as_flattened_mut().iter_mut().zip(change.as_flattened()) {
            *x += change;
        }
    }

    fn subtract_responses(&self, x: &mut [f64]) {
        for (change, response) in self.change.iter().zip(self.responses.chunks(x.len())) {
            x.iter_mut().zip(response).for_each(|(x, z)| *x -= change * z);
        }
    }

    /// Change of the multipliers in the last increment.
    pub fn change(&self) -> &[f64] {
        &self.change
    }

    /// Gradients at the end of a motion, with respect to rotations of the bodies there.
    fn end_gradients(&mut self, system: &System, frames: &LocalFrames, motion: &Motion, time: f64) {
        let end = end_of(system, motion);
        let mut end_frames = std::mem::take(&mut self.end_frames);
        // Degrees of freedom of nodes count in the frames of the factor.
        end_frames.copy_from(frames);
        end_frames.follow_bodies(&end);
        self.gradients(system, (&end_frames, time), end, |this| &mut this.ends);
        self.end_frames = end_frames;
    }

    fn gradients(
        &mut self,
        system: &System,
        (frames, time): (&LocalFrames, f64),
        value: impl Fn(usize) -> Vec3,
        out: impl Fn(&mut Self) -> &mut Vec<Gradient>,
    ) {
        for joint in system.joints.iter() {
            self.vectors.clear();
            self.vectors.extend(joint.vectors.iter().map(|&v| value(v as usize)));
            let drive = system.drive(joint, time).value;
            for (i, row) in joint.multipliers().zip(&joint.rows) {
                self.row.clear();
                self.row.resize(joint.vectors.len(), Vec3::zeros());
                row.add_gradient(1.0, &self.vectors, drive, &mut self.row);
                let mut gradient = std::mem::take(&mut out(self)[i]);
                gradient.clear();
                for (&v, g) in joint.vectors.iter().zip(&self.row) {
                    frames.reduce_one(v as usize, g, |number, x| gradient.push((number, x)));
                }
                out(self)[i] = gradient;
            }
        }
    }

    /// First joint with a constraint whose value at the end of a motion over its size is above a limit, as text.
    pub fn violation(
        &mut self,
        system: &System,
        (motion, time): (&Motion, f64),
        limit: f64,
    ) -> Option<String> {
        let (end, time) = (end_of(system, motion), end_time(motion, time));
        for joint in system.joints.iter() {
            self.vectors.clear();
            self.vectors.extend(joint.vectors.iter().map(|&v| end(v as usize)));
            let drive = system.drive(joint, time).value;
            if !joint.rows.iter().all(|row| row.is_on_branch(&self.vectors, drive)) {
                return Some(format!("joint \"{}\" is half a turn away from its angle", joint.name));
            }
            let worst = joint.rows.iter().map(|row| row.value(&self.vectors, drive).abs() / row.size);
            let worst = worst.reduce(crate::norm::larger)?;
            if !(worst <= limit) {
                return Some(format!("joint \"{}\" is open by {worst:.1e} of the model's size", joint.name));
            }
        }
        None
    }
}

/// Nodal vectors at the end of a motion.
fn end_of<'a>(system: &'a System, motion: &'a Motion) -> impl Fn(usize) -> Vec3 + 'a {
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

fn product(gradient: &Gradient, x: &[f64]) -> f64 {
    gradient.iter().filter(|(n, _)| *n != CONSTRAINED).map(|&(n, g)| g * x[n as usize]).sum()
}

/// Schur complement S with its factor.
struct Schur {
    matrix: DMatrix<f64>,
    /// Square roots of the diagonal: rows and columns are scaled by their inverse.
    scale: DVector<f64>,
    factor: Option<FullPivLU<f64, Dyn, Dyn>>,
    /// Pseudoinverse, where constraints depend on others.
    pseudoinverse: Option<DMatrix<f64>>,
    /// Rank of the constraints.
    rank: usize,
    /// Pivot over the largest one, below which constraints count as dependent.
    cut: f64,
}

impl Schur {
    fn new(m: usize) -> Self {
        Self {
            matrix: DMatrix::zeros(m, m),
            scale: DVector::zeros(m),
            factor: None,
            pseudoinverse: None,
            rank: m,
            cut: DEPENDENT,
        }
    }

    fn factor(&mut self) {
        let m = self.matrix.nrows();
        for i in 0..m {
            let diagonal = self.matrix[(i, i)].abs().sqrt();
            self.scale[i] = if diagonal > 0.0 { diagonal } else { 1.0 };
        }
        for i in 0..m {
            for j in 0..m {
                self.matrix[(i, j)] /= self.scale[i] * self.scale[j];
            }
        }
        self.factor = Some(self.matrix.clone().full_piv_lu());
        self.decide_rank();
    }

    fn decide_rank(&mut self) {
        let Some(factor) = &self.factor else { return };
        let u = factor.lu_internal();
        let independent = |i: &usize| u[(*i, *i)].abs() > self.cut * u[(0, 0)].abs();
        self.rank = (0..self.matrix.nrows()).filter(independent).count();
        let deficient = self.rank < self.matrix.nrows();
        self.pseudoinverse = deficient.then(|| pseudoinverse(factor, self.rank)).flatten();
    }

    /// Numbers of constraints that depend on the others.
    fn dependent(&self) -> Vec<usize> {
        let m = self.matrix.nrows();
        let mut order = DVector::from_fn(m, |i, _| i);
        if let Some(factor) = &self.factor {
            factor.p().permute_rows(&mut order);
        }
        order.iter().skip(self.rank).copied().collect()
    }

    /// Solves `S x = b`, where b becomes scratch space. Where the rank falls, `x + old` has minimum norm.
    fn solve(&self, b: &mut DVector<f64>, old: &[f64], x: &mut [f64]) {
        b.component_div_assign(&self.scale);
        let solved = match (&self.factor, &self.pseudoinverse) {
            (Some(factor), None) => factor.solve_mut(b),
            (_, Some(inverse)) => {
                let old = DVector::from_fn(b.len(), |i, _| old.get(i).map_or(0.0, |x| x * self.scale[i]));
                b.gemv(1.0, &self.matrix, &old, 1.0);
                *b = inverse * &*b - old;
                true
            }
            (None, None) => false,
        };
        if !solved {
            b.fill(f64::NAN);
        }
        b.component_div_assign(&self.scale);
        x.copy_from_slice(b.as_slice());
    }
}

/// Pseudoinverse of a matrix of this rank from its factors `P A Q = L U`, of which the columns and rows behind the rank are
/// left out: `A ≈ F G` with `F = Pᵀ L` and `G = U Qᵀ`, and `A⁺ = Gᵀ (G Gᵀ)⁻¹ (Fᵀ F)⁻¹ Fᵀ`. `None` where it is not finite.
fn pseudoinverse(factor: &FullPivLU<f64, Dyn, Dyn>, rank: usize) -> Option<DMatrix<f64>> {
    let mut left = factor.l().columns(0, rank).into_owned();
    factor.p().inv_permute_rows(&mut left);
    let mut right = factor.u().rows(0, rank).into_owned();
    factor.q().inv_permute_columns(&mut right);
    let inner = (left.tr_mul(&left)).cholesky()?.solve(&left.transpose());
    Some(right.tr_mul(&(&right * right.transpose()).cholesky()?.solve(&inner)))
}
