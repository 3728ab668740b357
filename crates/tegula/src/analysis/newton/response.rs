//! Linear response of an equilibrium to a change of the loads, and its softest mode.

use super::{Equation, FactoredTangent, Newton, expand_free, point};
use crate::analysis::circulatory::Purpose;
use crate::analysis::solver::{Linearization, TangentSolver};
use crate::element::Nodal;
use crate::system::System;
use crate::system::assembly::add_follower_stiffness;
use tegula_sparse::gmres::noise;

/// Inverse iterations for the softest mode: its error is the ratio of the two lowest eigenvalues to this power.
const INVERSE_ITERATIONS: usize = 24;

/// Lowest eigenmode of a tangent.
#[derive(Debug, Clone, PartialEq)]
pub struct SoftestMode {
    /// Mode shape, of norm 1 ([`System::norm`]).
    pub shape: Vec<Nodal>,
    /// Cosine of the angle between this mode and the response to the loads.
    pub excited: f64,
    /// Share of this mode in the energy of the response.
    pub energy: f64,
}

impl<S: TangentSolver> Newton<S> {
    /// Norm of the linear response of the last equilibrium to the change of the loads back from `after` to `before`, two
    /// equations with its displacements. The factor of the last tangent of the iteration is reused.
    ///
    /// # Errors
    /// The linear solver failed.
    pub fn response(
        &mut self,
        system: &System,
        (before, after): (&dyn Equation, &dyn Equation),
        history: &[f64],
    ) -> Result<f64, String> {
        let moved = before.prescribed(system, &mut self.increment);
        if moved {
            // The assembly of the tangent also gives its product with a prescribed motion.
            self.linearize(system, after, history, Some(before))?;
        } else {
            before.external_minus_inertia(system, &mut self.residual);
            after.external_minus_inertia(system, &mut self.internal);
            subtract(&mut self.residual, &self.internal);
            self.change_of_forces(system, (after, before), history);
        }
        self.find_response(system, (after, before.parts().time), moved, Some(Purpose::Increment))
    }

    /// Displacements of the last response that was found.
    pub fn last_response(&self) -> &[Nodal] {
        &self.increment
    }

    /// Factors the tangent of an equilibrium and finds its linear response to a change of the loads from there to
    /// `loaded`, and its softest mode. Returns the norm of the response, the mode and the number of negative pivots.
    ///
    /// # Errors
    /// The tangent has no factor, or the linear solver failed.
    pub fn softest_mode(
        &mut self,
        system: &System,
        (equilibrium, loaded): (&dyn Equation, &dyn Equation),
        history: &[f64],
    ) -> Result<(f64, SoftestMode, usize), String> {
        let negative = self.linearize(system, equilibrium, history, Some(loaded))?;
        let moved = loaded.prescribed(system, &mut self.increment);
        if !moved {
            loaded.external_minus_inertia(system, &mut self.residual);
            equilibrium.external_minus_inertia(system, &mut self.internal);
            subtract(&mut self.residual, &self.internal);
            self.change_of_forces(system, (equilibrium, loaded), history);
        }
        let response =
            self.find_response(system, (equilibrium, loaded.parts().time), moved, Some(Purpose::Increment))?;
        let answer = self.increment.clone();
        let work: f64 =
            self.residual.as_flattened().iter().zip(answer.as_flattened()).map(|(f, u)| f * u).sum();
        // 1/λ of the mode, whose square in the metric is the number of vectors.
        let mut compliance = 0.0;
        let mut shape: Vec<Nodal> = vec![[0.0; 3]; system.vectors()];
        for (x, random) in shape.as_flattened_mut().iter_mut().zip(noise()) {
            *x = random;
        }
        for _ in 0..INVERSE_ITERATIONS {
            self.residual.copy_from_slice(&shape);
            system.apply_metric(&mut self.residual);
            let size = self.find_response(system, (equilibrium, equilibrium.parts().time), false, None)?;
            compliance = size;
            for (x, y) in shape.as_flattened_mut().iter_mut().zip(self.increment.as_flattened()) {
                *x = y / size;
            }
        }
        let mut scaled = shape.clone();
        system.apply_metric(&mut scaled);
        let product: f64 = scaled.as_flattened().iter().zip(answer.as_flattened()).map(|(a, b)| a * b).sum();
        let excited = product.abs() / (shape.len() as f64 * response.max(f64::MIN_POSITIVE));
        let stored = product * product / (compliance * shape.len() as f64);
        let energy = stored / work.abs().max(f64::MIN_POSITIVE);
        Ok((response, SoftestMode { shape, excited, energy }, negative))
    }

    /// Number of negative pivots of the tangent at an iterate; assembles and factors this tangent.
    ///
    /// # Errors
    /// The linear solver failed.
    pub fn negative_pivots(
        &mut self,
        system: &System,
        equation: &dyn Equation,
        history: &[f64],
    ) -> Result<usize, String> {
        self.linearize(system, equation, history, None)
    }

    /// Assembles and factors the tangent at an iterate. The residual becomes that of the loads and prescribed motions
    /// of `loaded`; without it prescribed motions are zero. Returns the number of negative pivots.
    fn linearize(
        &mut self,
        system: &System,
        equation: &dyn Equation,
        history: &[f64],
        loaded: Option<&dyn Equation>,
    ) -> Result<usize, String> {
        let moved = loaded.is_some_and(|l| l.prescribed(system, &mut self.increment));
        let (k, parts) = (point(system, equation, history), equation.parts());
        equation.external_minus_inertia(system, &mut self.residual);
        self.assembly.follow(system, &k);
        self.factored = FactoredTangent::Nothing;
        let Self { solver, assembly, internal, circulatory, .. } = self;
        if let Some(loads) = circulatory {
            loads.take(system, &k.motion, &parts);
        }
        let prescribed = moved.then_some(self.increment.as_slice());
        let at = Linearization { system, point: &k, parts: &parts, extrapolated: false, prescribed };
        let mut negative = loop {
            solver.assemble(assembly, &at, internal);
            solver.add_curvature(assembly, &at, &self.residual);
            if let Some(done) = solver.prepare(assembly).transpose() {
                break done?;
            }
        };
        self.frames.copy_from(&self.assembly.frames);
        if let Some(constraints) = &mut self.constraints {
            constraints.take(system, (&k, &parts.weights), &self.assembly.frames, &mut self.solver)?;
            negative = negative.saturating_sub(constraints.negative_eigenvalues());
        }
        if let Some(loaded) = loaded.filter(|_| moved) {
            loaded.external_minus_inertia(system, &mut self.residual);
            add_follower_stiffness(system, &k.motion, &parts, &self.increment, &mut self.residual);
            subtract(&mut self.residual, &self.internal);
            self.change_of_forces(system, (equation, loaded), history);
        }
        Ok(negative)
    }

    /// Adds the change of the internal forces f due to prescribed strains, actuators and the ramp of preloaded springs, between two equations with equal
    /// displacements, to the residual: f(`first`) − f(`second`).
    fn change_of_forces(
        &mut self,
        system: &System,
        (first, second): (&dyn Equation, &dyn Equation),
        history: &[f64],
    ) {
        let ramps =
            [first, second].iter().any(|equation| system.part_of_preload(equation.parts().time) != 1.0);
        if system.prescribed_strains.is_empty() && !system.has_actuators() && !(ramps && system.has_springs())
        {
            return;
        }
        for (equation, sign) in [(first, 1.0), (second, -1.0)] {
            self.assembly.forces(system, &point(system, equation, history), &mut self.internal);
            for (r, f) in self.residual.as_flattened_mut().iter_mut().zip(self.internal.as_flattened()) {
                *r += sign * f;
            }
        }
    }

    /// Solves for the residual on the constraints of joints, whose drives move from an equilibrium to their places at a
    /// `time`, and with the unsymmetric tangent where it has a `purpose`; prescribed degrees of freedom keep their increment if they
    /// have `moved`, else they are at rest. Returns the norm of the increment.
    pub(super) fn find_response(
        &mut self,
        system: &System,
        (equilibrium, time): (&dyn Equation, f64),
        moved: bool,
        purpose: Option<Purpose>,
    ) -> Result<f64, String> {
        self.frames.reduce(&self.residual, &mut self.right_side);
        self.solve_for_right_side(purpose, |constraints, x| {
            let at = (&equilibrium.motion(), time);
            constraints.correct(system, at, equilibrium.multipliers(), x);
        })?;
        expand_free(&self.frames, &self.solution, moved, &mut self.increment);
        Ok(system.norm(&self.increment))
    }
}

fn subtract(from: &mut [Nodal], what: &[Nodal]) {
    for (x, y) in from.as_flattened_mut().iter_mut().zip(what.as_flattened()) {
        *x -= y;
    }
}
