//! Solvers of the linear systems of Newton's method.

use crate::bddc::{Bddc, BddcError, Options, StoppingCriterion};
use crate::element::Nodal;
use crate::system::assembly::{TangentCoefficients, curvature};
use crate::system::{Assembly, EvaluationPoint, System};
use crate::{Error, Result};

/// Error of a linear solution in the energy norm, over its own norm or the square root of the energy scale of the
/// increments, that does not affect Newton's method.
const TOLERANCE: f64 = 1e-10;
/// Largest relative error of a correction.
const SHARE: f64 = 1e-3;
/// Largest number of iterations for a linear system.
const MOST_ITERATIONS: usize = 500;

/// Linearisation point of a tangent and its coefficients.
pub struct Linearization<'a> {
    /// The compiled model.
    pub system: &'a System,
    /// Evaluation point of the tangent.
    pub point: &'a EvaluationPoint<'a>,
    /// Tangent coefficients.
    pub parts: &'a TangentCoefficients,
    /// Whether the geometric stiffness uses the extrapolated stress.
    pub extrapolated: bool,
    /// Increment whose product with the tangent is added to the forces.
    pub prescribed: Option<&'a [Nodal]>,
}

/// Linear solver of Newton's method.
pub trait TangentSolver: Send {
    /// Begins a step.
    fn begin_step(&mut self) {}
    /// Sets the energy scale, to which increments are compared.
    fn note_energy(&mut self, _scale: f64) {}
    /// Assembles the internal forces and the element part of the tangent, like [`Assembly::forces_and_tangent`].
    fn assemble(&mut self, assembly: &mut Assembly, at: &Linearization, out: &mut [Nodal]);
    /// Adds the curvature of the unit sphere of inextensible directors to the tangent, like
    /// [`Assembly::add_curvature`].
    fn add_curvature(&mut self, assembly: &mut Assembly, at: &Linearization, rest: &[Nodal]);
    /// Prepares solves with the assembled tangent, whose memory it may use up. Returns the number of negative pivots,
    /// or `None` if the tangent must be assembled once more.
    ///
    /// # Errors
    /// There is no solution, or this solver cannot find it; the text gives the reason.
    fn prepare(&mut self, assembly: &mut Assembly) -> std::result::Result<Option<usize>, String>;
    /// Solves in place.
    ///
    /// # Errors
    /// No solution of the required accuracy was found; the text gives the reason.
    fn solve_tangent(&mut self, x: &mut [f64]) -> std::result::Result<(), String>;
    /// Solves in place with many right sides, columns one after another.
    ///
    /// # Errors
    /// No solution of the required accuracy was found; the text gives the reason.
    fn solve_tangents(&mut self, x: &mut [f64], count: usize) -> std::result::Result<(), String> {
        x.chunks_mut((x.len() / count.max(1)).max(1)).try_for_each(|x| self.solve_tangent(x))
    }
    /// Releases the memory of the factor: no more solves follow.
    fn release(&mut self) {}
    /// Cost of preparing a tangent and the Schur complement of the constraints, in iterations with a lagged tangent, by the numbers of
    /// unknowns and constraints; 0: no tangent is ever reused.
    fn price(&self, _sizes: [usize; 2]) -> f64 {
        0.0
    }
    /// Number of tangents prepared so far.
    fn tangents(&self) -> usize;
    /// Iterations of all solves so far; 0 for a direct solver.
    fn linear_iterations(&self) -> u64 {
        0
    }
}

/// Reason of a tangent without inverse.
pub(super) const SINGULAR: &str = "the tangent is singular";

/// Conjugate gradients preconditioned by BDDC over the subdomains of the mesh.
pub struct Iterative {
    bddc: Bddc,
    tangents: usize,
    iterations: u64,
    /// Energy scale, to which increments are compared; 0 before the first iteration of a step.
    energy: f64,
}

impl Iterative {
    /// Partitions the mesh of a system into subdomains.
    ///
    /// # Errors
    /// There is not enough memory.
    pub fn new(system: &System) -> Result<Self> {
        let bddc = system.bddc(&Options::default()).map_err(|e| Error::Singular {
            what: format!(
                "The mesh of {} unknowns cannot be partitioned into subdomains: {e}.",
                system.unknowns()
            ),
            help: "Use a coarser mesh or a machine with more memory.".into(),
        })?;
        Ok(Self { bddc, tangents: 0, iterations: 0, energy: 0.0 })
    }
}

impl TangentSolver for Iterative {
    fn begin_step(&mut self) {
        self.energy = 0.0;
    }

    fn note_energy(&mut self, scale: f64) {
        self.energy = scale;
    }

    fn assemble(&mut self, assembly: &mut Assembly, at: &Linearization, out: &mut [Nodal]) {
        self.bddc.begin();
        let (bddc, mut term) = (&mut self.bddc, 0);
        let how = (at.extrapolated, at.prescribed);
        assembly.forces_and_blocks(at.system, at.point, at.parts, how, out, |blocks| {
            bddc.put(term, blocks);
            term += 1;
        });
    }

    fn add_curvature(&mut self, assembly: &mut Assembly, at: &Linearization, rest: &[Nodal]) {
        if !at.point.linear && !assembly.frames.dofs().unit.is_empty() {
            let shift = curvature(at.system, &assembly.frames, at.point, &at.parts.weights, rest);
            self.bddc.shift(at.system.vectors(), shift);
        }
    }

    fn prepare(&mut self, assembly: &mut Assembly) -> std::result::Result<Option<usize>, String> {
        self.tangents += 1;
        self.bddc.factor(&assembly.frames).map_err(explain)?;
        // The partially assembled matrix, of which the tangent is a restriction, has positive pivots only.
        Ok(Some(0))
    }

    fn solve_tangent(&mut self, x: &mut [f64]) -> std::result::Result<(), String> {
        let wanted = StoppingCriterion {
            relative: TOLERANCE,
            absolute: TOLERANCE * self.energy.max(0.0).sqrt(),
            share: SHARE,
            iterations: MOST_ITERATIONS,
        };
        let convergence = self.bddc.solve(x, &wanted).map_err(explain)?;
        self.iterations += convergence.iterations as u64;
        Ok(())
    }

    fn tangents(&self) -> usize {
        self.tangents
    }

    fn linear_iterations(&self) -> u64 {
        self.iterations
    }
}

fn explain(error: BddcError) -> String {
    match error {
        BddcError::Indefinite(what) => format!(
            "the tangent is not proved positive definite: {what}. The equilibrium is unstable, or supports are missing, \
             or only the partially assembled operator of the subdomains is indefinite; `linear_solver = \"direct\"` \
             decides"
        ),
        BddcError::NotConverged { iterations, residual, tolerance } => format!(
            "the linear system was not solved after {iterations} iterations of conjugate gradients (error \
             {residual:.1e}, wanted {tolerance:.1e}); take `linear_solver = \"direct\"`"
        ),
        other => other.to_string(),
    }
}
