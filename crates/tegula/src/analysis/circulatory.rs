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
//! divergence ([`super::newton`]).

use super::solver::TangentSolver;
use crate::element::Kinematics;
use crate::linear::gmres::Gmres;
use crate::system::assembly::TangentParts;
use crate::system::{CirculatoryStiffness, Numbering, System};

/// Residual of a solution with the tangent of its iterate, over the increment: Newton's method keeps its speed.
const TOLERANCE: f64 = 1e-6;
/// Residual where an old tangent contracts errors no better, and in time steps, where masses make N weak: six runs of 100
/// steps of a strip under follower loads took 3788 Newton iterations with N to 1e-6, and 3795 without N at all.
const LOOSE_TOLERANCE: f64 = 1e-2;
/// A solution with a larger residual is refused.
const REFUSED: f64 = 1e-2;
/// Iterations at most.
const MOST_ITERATIONS: usize = 200;
/// Largest number of Krylov vectors, and of their entries (160 MB).
const MOST_VECTORS: usize = 80;
const MOST_ENTRIES: usize = 20_000_000;

/// Stability of an equilibrium by divergence, from negative pivots and circulatory loads.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stability {
    /// The tangent has no negative eigenvalue, nor has its symmetric part.
    Stable,
    /// The tangent has a negative eigenvalue: so many negative pivots of the symmetric part show it.
    Unstable(usize),
    /// The symmetric part has so many negative pivots, but the tangent has no real negative eigenvalue: circulatory loads
    /// balance them, or turn pairs of them into vibrations.
    Undecided(usize),
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

    /// Turns `x = K⁻¹ R` into the solution of `(K + N) δ = R`; `loose` if little accuracy is of use, as with the tangent of
    /// another iterate.
    ///
    /// # Errors
    /// The linear solver failed, or the iteration did not converge; why, for people.
    pub fn correct<S: TangentSolver>(
        &mut self,
        solver: &mut S,
        axes: &Numbering,
        x: &mut [f64],
        loose: bool,
    ) -> Result<(), String> {
        let tolerance = if loose { LOOSE_TOLERANCE } else { TOLERANCE };
        if self.operator.stiffness.is_zero() || (loose && self.strength <= tolerance) {
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
}

fn norm(x: &[f64]) -> f64 {
    x.iter().map(|x| x * x).sum::<f64>().sqrt()
}
