//! Linear systems with the unsymmetric tangent of follower loads.
//!
//! The tangent is `K + N`: K is symmetric and has a solver, N is the skew [`CirculatoryStiffness`] of the loads. In models
//! with joints `K⁻¹` stands for the solution on their constraints. With `x = K⁻¹ R` the increment δ satisfies
//!
//! ```text
//! (I + K⁻¹ N) δ = x
//! ```
//!
//! N acts on few degrees of freedom (those of loaded edges). GMRES solves for these alone, `(I + P K⁻¹ N) δ_P = P x`,
//! with one solve with K and no product with K in each iteration; then `δ = x − K⁻¹ N δ_P`. The number of iterations is
//! that of the motions which N couples noticeably, whatever the mesh.
//!
//! Where K has negative pivots, N may compensate them: the eigenvalues of `K + N` next to zero decide on stability by
//! divergence ([`super::newton`]). Let N grow from zero to its full value, `K + s N` with s from 0 to 1: a real
//! eigenvalue crosses zero where this matrix is singular, and then 1/s is an eigenvalue of `−K⁻¹ N`. Few eigenvalues
//! are above 1.

use crate::element::Motion;
use crate::norm::larger;
use crate::system::assembly::TangentCoefficients;
use crate::system::{CirculatoryStiffness, LocalFrames, Procedure, System};
use tegula_sparse::gmres::{Gmres, noise, norm, project_out};

/// Relative residual above which a solution is refused.
const REFUSED: f64 = 1e-2;
/// Largest number of GMRES iterations.
const MOST_ITERATIONS: usize = 200;
/// Largest number of Krylov vectors, and of their entries (160 MB).
const MOST_VECTORS: usize = 80;
const MOST_ENTRIES: usize = 20_000_000;

/// Arnoldi steps between two checks of the eigenvalues of `−K⁻¹ N`; least of those that are checked; their change from check to check over
/// their distance from 1 at which they are accepted; a distance from 1 that is round-off; and their imaginary part over the real one below
/// which they count as real.
const EIGENVALUE_STEPS: usize = 5;
const LOOKED_AT: f64 = 0.5;
const SETTLED: f64 = 1e-3;
const ROUND_OFF: f64 = 1e-9;
const REAL: f64 = 1e-6;
/// Fraction of a vector orthogonal to others below which it counts as linearly dependent on them.
const DEPENDENT: f64 = 1e-3;

/// Purpose of a solution, which decides on its accuracy.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Purpose {
    /// Increment with the tangent of its iterate (full Newton).
    Increment,
    /// Direction or increment on an equilibrium path, next to whose critical points the tangent is nearly singular.
    Path,
    /// Increment with a lagged tangent, or in a time step.
    Contraction,
    /// Vector of the Arnoldi process.
    Eigenvalues,
}

impl Purpose {
    /// Tolerance on the residual over the right side.
    fn tolerance(self) -> f64 {
        match self {
            // Newton's method keeps its quadratic convergence.
            Self::Increment => 1e-6,
            Self::Path => 1e-12,
            // A lagged tangent contracts errors no better; and in time steps masses make N weak: six runs of 100 steps
            // of a strip under follower loads took 3788 Newton iterations with N to 1e-6, and 3795 without N at all.
            Self::Contraction => 1e-2,
            // The error must be smaller than the accepted change of eigenvalues between two checks.
            Self::Eigenvalues => 1e-4,
        }
    }
}

/// Solver for the symmetric tangent plus the skew circulatory stiffness of follower loads.
pub(super) struct CirculatoryLoads {
    operator: Operator,
    gmres: Gmres,
    /// Right side, solution and residual in the degrees of freedom on which the loads act.
    right: Vec<f64>,
    solution: Vec<f64>,
    residual: Vec<f64>,
    /// Norm of `K⁻¹ N x` over that of x, as found last in the present step; infinite before.
    strength: f64,
}

/// Solution with the symmetric tangent K, on the constraints of joints at rest: replaces a right side by it.
pub(super) type Solve<'a> = dyn FnMut(&mut [f64]) -> Result<(), String> + 'a;

/// Operator `K⁻¹ N` with its buffers of all free degrees of freedom.
struct Operator {
    stiffness: CirculatoryStiffness,
    values: Vec<f64>,
    product: Vec<f64>,
    /// Whether N stands for its transpose −N.
    transposed: bool,
    /// Number of solves with K so far.
    solutions: u64,
}

impl Operator {
    /// `product = N x`.
    fn multiply(&mut self, frames: &LocalFrames, x: &[f64]) {
        self.stiffness.product(frames, x, &mut self.product);
        if self.transposed {
            self.product.iter_mut().for_each(|x| *x = -*x);
        }
    }

    /// `product = K⁻¹ N x`.
    fn apply(&mut self, solve: &mut Solve, frames: &LocalFrames, x: &[f64]) -> Result<(), String> {
        self.multiply(frames, x);
        self.solutions += 1;
        solve(&mut self.product)
    }

    /// `product = K⁻¹ N x` for x in the degrees of freedom on which the loads act.
    fn apply_to_part(&mut self, solve: &mut Solve, frames: &LocalFrames, part: &[f64]) -> Result<(), String> {
        let mut values = std::mem::take(&mut self.values);
        self.stiffness.scatter(part, &mut values);
        let result = self.apply(solve, frames, &values);
        self.values = values;
        result
    }
}

impl CirculatoryLoads {
    /// Solver for the follower loads of a system; `None` where their stiffness has no skew part.
    pub fn new(system: &System) -> Option<Self> {
        if system.linear || system.followers.is_empty() {
            return None;
        }
        // Time steps leave the skew part of moments on bodies out: it changes their iterations alone.
        let stiffness = match system.procedure {
            Procedure::Transient | Procedure::Explicit => {
                CirculatoryStiffness::without_moments_on_bodies(system)
            }
            _ => CirculatoryStiffness::new(system),
        };
        let (size, all) = (stiffness.support().len(), system.unknowns());
        if size == 0 {
            return None;
        }
        let vectors = (MOST_ENTRIES / size).clamp(10, MOST_VECTORS);
        Some(Self {
            operator: Operator {
                stiffness,
                values: vec![0.0; all],
                product: vec![0.0; all],
                transposed: false,
                solutions: 0,
            },
            gmres: Gmres::new(size, vectors),
            right: vec![0.0; size],
            solution: vec![0.0; size],
            residual: vec![0.0; size],
            strength: f64::INFINITY,
        })
    }

    /// Whether the follower loads have no skew stiffness at the present tangent.
    pub fn is_zero(&self) -> bool {
        self.operator.stiffness.is_zero()
    }

    /// Computes the circulatory stiffness that belongs to a tangent.
    pub fn take(&mut self, system: &System, motion: &Motion, parts: &TangentCoefficients) {
        self.operator.stiffness.take(system, motion, parts);
    }

    /// Lets the transpose of the tangent, `K − N`, stand for it, or no longer.
    pub fn transpose(&mut self, transposed: bool) {
        self.operator.transposed = transposed;
    }

    /// Replaces x by `R − N x` with a right side R.
    pub fn take_remainder(&mut self, frames: &LocalFrames, right: &[f64], x: &mut [f64]) {
        self.operator.multiply(frames, x);
        let parts = right.iter().zip(&self.operator.product);
        x.iter_mut().zip(parts).for_each(|(x, (right, product))| *x = right - product);
    }

    /// Begins a step: the strength of the loads has to be found again.
    pub fn begin_step(&mut self) {
        self.strength = f64::INFINITY;
    }

    /// Number of solves with the symmetric tangent so far, for the follower loads alone.
    pub fn solutions(&self) -> u64 {
        self.operator.solutions
    }

    /// Corrects `x = K⁻¹ R` to the solution of `(K + N) δ = R`, as exact as its purpose needs. Returns whether x was changed.
    ///
    /// # Errors
    /// The linear solver failed, or GMRES did not converge; the text gives the reason.
    pub fn correct(
        &mut self,
        solve: &mut Solve,
        frames: &LocalFrames,
        x: &mut [f64],
        purpose: Purpose,
    ) -> Result<bool, String> {
        let tolerance = purpose.tolerance();
        if self.operator.stiffness.is_zero()
            || (purpose == Purpose::Contraction && self.strength <= tolerance)
        {
            return Ok(false);
        }
        let Self { operator, gmres, right, solution, residual, strength } = self;
        operator.apply(solve, frames, x)?;
        operator.stiffness.gather(x, right);
        operator.stiffness.gather(&operator.product, residual);
        let size = norm(right);
        *strength = if size > 0.0 { norm(residual) / size } else { 0.0 };
        // One fixed-point step, x − K⁻¹ N x, leaves the square of the strength as relative error.
        if !(*strength * *strength <= tolerance) {
            solution.copy_from_slice(right);
            residual.iter_mut().for_each(|r| *r = -*r);
            let outcome =
                gmres.solve(right, (solution, residual), (tolerance, MOST_ITERATIONS), |v, out| {
                    operator.apply_to_part(solve, frames, v)?;
                    operator.stiffness.gather(&operator.product, out);
                    out.iter_mut().zip(v).for_each(|(out, v)| *out += v);
                    Ok::<(), String>(())
                })?;
            if !(outcome.residual <= REFUSED) {
                return Err(format!(
                    "GMRES did not converge for the unsymmetric tangent of the follower loads: residual {:.1e} after {} \
                     iterations",
                    outcome.residual, outcome.applications
                ));
            }
            operator.apply_to_part(solve, frames, solution)?;
        }
        x.iter_mut().zip(&operator.product).for_each(|(x, z)| *x -= z);
        Ok(true)
    }

    /// Number of real eigenvalues of `K + s N` that cross zero while s grows from 0 to 1: the number of real
    /// eigenvalues of `−K⁻¹ N` above 1, with multiplicity. `None` where the available Krylov vectors do not suffice to
    /// find them.
    ///
    /// The Arnoldi process finds a multiple eigenvalue once. It is therefore repeated without the eigenvectors that are
    /// known (deflation; Y. Saad, *Numerical methods for large eigenvalue problems*, 2011, Sect. 4.2) until it finds
    /// nothing new.
    ///
    /// # Errors
    /// The linear solver failed.
    pub fn zero_crossings(
        &mut self,
        solve: &mut Solve,
        frames: &LocalFrames,
    ) -> Result<Option<usize>, String> {
        let Self { operator, gmres, right, .. } = self;
        let mut random = noise();
        let mut known: Vec<Vec<f64>> = Vec::new();
        loop {
            right.iter_mut().zip(&mut random).for_each(|(x, random)| *x = random);
            let before = norm(right);
            project_out(&known, right);
            if !(norm(right) > DEPENDENT * before) {
                return Ok(Some(known.len()));
            }
            let mut last: Option<Vec<f64>> = None;
            let mut settled = false;
            let mut looked = |values: &[[f64; 2]], exact: bool| {
                let now = above(LOOKED_AT, values);
                // Next to a critical point an eigenvalue is next to 1.
                let settled_value =
                    |a: f64, b: f64| (a - b).abs() <= SETTLED * larger((a - 1.0).abs(), ROUND_OFF);
                let same = |last: &Vec<f64>| {
                    last.len() == now.len() && last.iter().zip(&now).all(|(a, b)| settled_value(*a, *b))
                };
                settled = exact || last.as_ref().is_some_and(same);
                last = Some(now);
                settled
            };
            let values = gmres.ritz_values(right, EIGENVALUE_STEPS, &mut looked, |v, out| {
                operator.apply_to_part(solve, frames, v)?;
                operator.stiffness.gather(&operator.product, out);
                project_out(&known, out);
                Ok::<(), String>(())
            })?;
            if !settled {
                return Ok(None);
            }
            let count = known.len();
            for value in above(1.0, &values) {
                let mut vector = gmres.ritz_vector(values.len(), -value);
                project_out(&known, &mut vector);
                project_out(&known, &mut vector);
                let size = norm(&vector);
                // Nearly equal values may share their vector here; the next process finds the other one.
                if size > DEPENDENT {
                    vector.iter_mut().for_each(|x| *x /= size);
                    known.push(vector);
                }
            }
            if known.len() == count {
                return Ok(Some(count));
            }
        }
    }
}

/// Real eigenvalues of `−K⁻¹ N` above a value from those of `K⁻¹ N`, ascending.
fn above(least: f64, values: &[[f64; 2]]) -> Vec<f64> {
    let above = |[re, im]: &[f64; 2]| (-re > least && im.abs() <= REAL * re.abs()).then_some(-re);
    let mut found: Vec<f64> = values.iter().filter_map(above).collect();
    found.sort_by(f64::total_cmp);
    found
}
