//! Solution of the linear systems of Newton's method: with the symmetric tangent, on the constraints of joints, and with the
//! circulatory part of follower loads.

use super::{Constraints, Newton};
use crate::analysis::circulatory::{CirculatoryLoads, Purpose};
use crate::analysis::solver::TangentSolver;
use crate::system::LocalFrames;

/// Parts of a linear system `(K + N) x + Gᵀ Δλ = R` on constraints `G x = −g`.
pub(super) struct LinearSystem<'a, S> {
    /// Solver with the symmetric tangent K.
    pub solver: &'a mut S,
    /// Circulatory part N of follower loads, where there is some.
    pub circulatory: Option<&'a mut CirculatoryLoads>,
    /// Constraints of joints, where there are some.
    pub constraints: Option<&'a mut Constraints>,
    pub frames: &'a LocalFrames,
}

impl<S: TangentSolver> LinearSystem<'_, S> {
    /// Solves for `x` with a right side R, as exact as its purpose needs; without one N is neglected. `constrain` changes `K⁻¹ R` to the
    /// solution on the constraints, whose multipliers are then those of x.
    ///
    /// # Errors
    /// The linear solver failed; the text gives the reason.
    pub fn solve(
        mut self,
        right: &[f64],
        x: &mut [f64],
        purpose: Option<Purpose>,
        mut constrain: impl FnMut(&mut Constraints, &mut [f64]),
    ) -> Result<(), String> {
        x.copy_from_slice(right);
        self.solver.solve_tangent(x)?;
        if let Some(constraints) = &mut self.constraints {
            constrain(constraints, x);
        }
        let (Some(loads), Some(purpose)) = (self.circulatory.take(), purpose) else { return Ok(()) };
        let frames = self.frames;
        let changed = loads.correct(&mut |x| self.solve_at_rest(x), frames, x, purpose)?;
        if let Some(constraints) = self.constraints.filter(|_| changed) {
            loads.take_remainder(frames, right, x);
            self.solver.solve_tangent(x)?;
            constrain(constraints, x);
        }
        Ok(())
    }

    /// Replaces a right side by the solution with K on constraints at rest, `G x = 0`.
    pub fn solve_at_rest(&mut self, x: &mut [f64]) -> Result<(), String> {
        self.solver.solve_tangent(x)?;
        if let Some(constraints) = &mut self.constraints {
            constraints.constrain(x);
        }
        Ok(())
    }
}

impl<S: TangentSolver> Newton<S> {
    /// Solves for the `solution` of the right side with the tangent factored last: [`LinearSystem::solve`].
    ///
    /// # Errors
    /// The linear solver failed; the text gives the reason.
    pub(super) fn solve_for_right_side(
        &mut self,
        purpose: Option<Purpose>,
        constrain: impl FnMut(&mut Constraints, &mut [f64]),
    ) -> Result<(), String> {
        let (right, mut x) = (std::mem::take(&mut self.right_side), std::mem::take(&mut self.solution));
        let solved = self.linear_system().solve(&right, &mut x, purpose, constrain);
        (self.right_side, self.solution) = (right, x);
        solved
    }

    /// Linear system of the tangent factored last.
    pub(super) fn linear_system(&mut self) -> LinearSystem<'_, S> {
        let Self { solver, circulatory, constraints, frames, .. } = self;
        LinearSystem { solver, circulatory: circulatory.as_mut(), constraints: constraints.as_mut(), frames }
    }
}
