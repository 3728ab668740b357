//! Linear systems with the unsymmetric tangent of loads that follow the motion.
//!
//! The tangent is `K + N`: K is symmetric and solved with ([`TangentSolver`]), N is the skew
//! [`CirculatoryStiffness`] of the loads. With `x = K⁻¹ R` the increment δ satisfies
//!
//! ```text
//! (I + K⁻¹ N) δ = x
//! ```
//!
//! N acts on few coordinates (those of loaded edges). GMRES solves for these alone, `(I + P K⁻¹ N) δ_P = P x`, with one
//! solution of K and no product with K for each iteration; then `δ = x − K⁻¹ N δ_P`. The number of iterations is that of
//! the motions which N couples noticeably, whatever the mesh.
//!
//! Where K has negative pivots, N may balance them: the eigenvalues of `K + N` next to zero decide on stability by
//! divergence ([`super::newton`]). Let N grow from nothing to its whole, `K + s N` with s from 0 to 1: a
//! real eigenvalue crosses zero where this is singular, and then 1/s is an eigenvalue of `−K⁻¹ N`. Those above 1 are few.

use super::solver::TangentSolver;
use crate::element::Kinematics;
use crate::system::assembly::TangentParts;
use crate::system::{CirculatoryStiffness, Numbering, System};
use tegula_sparse::gmres::{Gmres, noise, norm, project_out};

/// A solution with a larger residual is refused.
const REFUSED: f64 = 1e-2;
/// Iterations at most.
const MOST_ITERATIONS: usize = 200;
/// Largest number of Krylov vectors, and of their entries (160 MB).
const MOST_VECTORS: usize = 80;
const MOST_ENTRIES: usize = 20_000_000;

/// Arnoldi steps after which eigenvalues of `−K⁻¹ N` are looked at; their change from look to look at which they are accepted;
/// and their imaginary part over the real one below which they count as real.
const EIGENVALUE_STEPS: usize = 5;
const SETTLED: f64 = 1e-3;
const REAL: f64 = 1e-6;
/// Part of a vector across others below which it depends on them.
const DEPENDENT: f64 = 1e-3;

/// What a solution is for, which decides on its accuracy.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Purpose {
    /// An increment with the tangent of its iterate.
    Increment,
    /// An increment with the tangent of another iterate, or in a time step.
    Contraction,
    /// A vector of the Arnoldi process.
    Eigenvalues,
}

impl Purpose {
    /// Residual over the right side.
    fn tolerance(self) -> f64 {
        match self {
            // Newton's method keeps its speed.
            Self::Increment => 1e-6,
            // An old tangent contracts errors no better; and in time steps masses make N weak: six runs of 100 steps of a
            // strip under follower loads took 3788 Newton iterations with N to 1e-6, and 3795 without N at all.
            Self::Contraction => 1e-2,
            // Less than what eigenvalues may change between two looks at them.
            Self::Eigenvalues => 1e-4,
        }
    }
}

/// Solutions with the skew stiffness of follower loads beside the symmetric tangent.
pub(super) struct CirculatoryLoads {
    operator: Operator,
    gmres: Gmres,
    /// Coordinates on which the loads act: right side, solution, residual.
    right: Vec<f64>,
    solution: Vec<f64>,
    residual: Vec<f64>,
    /// Size of `K⁻¹ N x` over that of x, found last in the present step; infinite before.
    strength: f64,
}

/// `K⁻¹ N` with its buffers of all free coordinates.
struct Operator {
    stiffness: CirculatoryStiffness,
    values: Vec<f64>,
    product: Vec<f64>,
    /// Solutions so far.
    solutions: u64,
}

impl Operator {
    /// `product = K⁻¹ N x`.
    fn apply<S: TangentSolver>(&mut self, solver: &mut S, axes: &Numbering, x: &[f64]) -> Result<(), String> {
        self.stiffness.product(axes, x, &mut self.product);
        self.solutions += 1;
        solver.solve_tangent(&mut self.product)
    }

    /// `product = K⁻¹ N x` of coordinates on which the loads act.
    fn apply_to_part<S: TangentSolver>(
        &mut self,
        solver: &mut S,
        axes: &Numbering,
        part: &[f64],
    ) -> Result<(), String> {
        let mut values = std::mem::take(&mut self.values);
        self.stiffness.scatter(part, &mut values);
        let result = self.apply(solver, axes, &values);
        self.values = values;
        result
    }
}

impl CirculatoryLoads {
    /// For the loads of a system; `None` where their stiffness has no skew part.
    pub fn new(system: &System) -> Option<Self> {
        if system.linear || system.followers.is_empty() {
            return None;
        }
        let stiffness = CirculatoryStiffness::new(system);
        let (size, all) = (stiffness.support().len(), system.unknowns());
        if size == 0 {
            return None;
        }
        let vectors = (MOST_ENTRIES / size).clamp(10, MOST_VECTORS);
        Some(Self {
            operator: Operator { stiffness, values: vec![0.0; all], product: vec![0.0; all], solutions: 0 },
            gmres: Gmres::new(size, vectors),
            right: vec![0.0; size],
            solution: vec![0.0; size],
            residual: vec![0.0; size],
            strength: f64::INFINITY,
        })
    }

    /// Whether the loads have no skew part at the tangent at hand.
    pub fn is_zero(&self) -> bool {
        self.operator.stiffness.is_zero()
    }

    /// Takes the stiffness that belongs to a tangent.
    pub fn take(&mut self, system: &System, k: &Kinematics, parts: &TangentParts) {
        self.operator.stiffness.take(system, k, parts);
    }

    /// A new step begins: how strong the loads are is to be found anew.
    pub fn begin_step(&mut self) {
        self.strength = f64::INFINITY;
    }

    /// Solutions of the symmetric tangent so far, for the loads alone.
    pub fn solutions(&self) -> u64 {
        self.operator.solutions
    }

    /// Turns `x = K⁻¹ R` into the solution of `(K + N) δ = R`, as exact as its purpose needs.
    ///
    /// # Errors
    /// The linear solver failed, or the iteration did not converge; why, for people.
    pub fn correct<S: TangentSolver>(
        &mut self,
        solver: &mut S,
        axes: &Numbering,
        x: &mut [f64],
        purpose: Purpose,
    ) -> Result<(), String> {
        let tolerance = purpose.tolerance();
        if self.operator.stiffness.is_zero()
            || (purpose == Purpose::Contraction && self.strength <= tolerance)
        {
            return Ok(());
        }
        let Self { operator, gmres, right, solution, residual, strength } = self;
        operator.apply(solver, axes, x)?;
        operator.stiffness.gather(x, right);
        operator.stiffness.gather(&operator.product, residual);
        let size = norm(right);
        *strength = if size > 0.0 { norm(residual) / size } else { 0.0 };
        // A step of δ = x − K⁻¹ N δ leaves the square of the strength.
        if !(*strength * *strength <= tolerance) {
            solution.copy_from_slice(right);
            residual.iter_mut().for_each(|r| *r = -*r);
            let outcome =
                gmres.solve(right, (solution, residual), (tolerance, MOST_ITERATIONS), |v, out| {
                    operator.apply_to_part(solver, axes, v)?;
                    operator.stiffness.gather(&operator.product, out);
                    out.iter_mut().zip(v).for_each(|(out, v)| *out += v);
                    Ok::<(), String>(())
                })?;
            if !(outcome.residual <= REFUSED) {
                return Err(format!(
                    "the linear system with the unsymmetric stiffness of loads that follow the motion was not solved \
                     after {} iterations of GMRES (residual {:.1e})",
                    outcome.applications, outcome.residual
                ));
            }
            operator.apply_to_part(solver, axes, solution)?;
        }
        x.iter_mut().zip(&operator.product).for_each(|(x, z)| *x -= z);
        Ok(())
    }

    /// Number of real eigenvalues that cross zero while N grows from nothing to its whole: that of the real eigenvalues of
    /// `−K⁻¹ N` above 1, multiple ones counted as often. `None` where they are not found with the vectors at hand.
    ///
    /// The Arnoldi process finds a multiple eigenvalue once. So it is repeated without the eigenvectors that are known
    /// (deflation; Y. Saad, *Numerical methods for large eigenvalue problems*, 2011, Sect. 4.2) until it finds nothing new.
    ///
    /// # Errors
    /// The linear solver failed.
    pub fn zero_crossings<S: TangentSolver>(
        &mut self,
        solver: &mut S,
        axes: &Numbering,
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
                let now = above_one(values);
                let same = |last: &Vec<f64>| {
                    last.len() == now.len()
                        && last.iter().zip(&now).all(|(a, b)| (a - b).abs() <= SETTLED * a)
                };
                settled = exact || last.as_ref().is_some_and(same);
                last = Some(now);
                settled
            };
            let values = gmres.ritz_values(right, EIGENVALUE_STEPS, &mut looked, |v, out| {
                operator.apply_to_part(solver, axes, v)?;
                operator.stiffness.gather(&operator.product, out);
                project_out(&known, out);
                Ok::<(), String>(())
            })?;
            if !settled {
                return Ok(None);
            }
            let count = known.len();
            for value in above_one(&values) {
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

/// Real eigenvalues of `−K⁻¹ N` above 1 from those of `K⁻¹ N`, ascending.
fn above_one(values: &[[f64; 2]]) -> Vec<f64> {
    let above = |[re, im]: &[f64; 2]| (-re > 1.0 && im.abs() <= REAL * re.abs()).then_some(-re);
    let mut found: Vec<f64> = values.iter().filter_map(above).collect();
    found.sort_by(f64::total_cmp);
    found
}
