//! Linear responses of an equilibrium: to a change of the loads, and its softest mode.

use super::{Equation, Held, Newton, expand_free};
use crate::analysis::circulatory::Purpose;
use crate::analysis::solver::{Linearization, TangentSolver};
use crate::element::Nodal;
use crate::linear::gmres::{Gmres, noise};
use crate::system::assembly::add_follower_stiffness;
use crate::system::{System, VectorKind};

/// Inverse iterations for the softest mode: its error is the ratio of the two lowest eigenvalues to this power.
const INVERSE_ITERATIONS: usize = 24;

/// Arnoldi steps after which Ritz values are looked at.
const EIGENVALUE_STEPS: usize = 10;
/// A real negative Ritz value is an eigenvalue if it changes by no more than this share from look to look: those of an
/// unfinished process come and go.
const SETTLED: f64 = 1e-3;
/// Looks in a row without a real negative Ritz value after which there is no such eigenvalue.
const LOOKS_WITHOUT: usize = 2;
/// Imaginary part over the real one below which an eigenvalue counts as real, and its size over the largest one from which on
/// it is more than noise.
const REAL: f64 = 1e-3;
const NOISE: f64 = 1e-6;
/// Largest number of Krylov vectors, and of their entries (160 MB).
const MOST_VECTORS: usize = 80;
const MOST_ENTRIES: usize = 20_000_000;

/// Eigenvalues of an unsymmetric tangent next to zero.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct NextToZero {
    /// One is real and negative: that of a motion which goes away without vibrating.
    pub real_negative: bool,
    /// Complex pairs.
    pub pairs: usize,
}

/// Lowest mode of a tangent.
#[derive(Debug, Clone, PartialEq)]
pub struct SoftestMode {
    /// Shape; its size ([`System::norm`]) is 1.
    pub shape: Vec<Nodal>,
    /// Cosine of the angle between this mode and the response to the loads.
    pub excited: f64,
    /// Share of this mode in the energy of the response.
    pub energy: f64,
}

impl<S: TangentSolver> Newton<S> {
    /// Size of the response of the equilibrium found last to the change of the loads from `before` to `after`, two
    /// equations with its displacements. Its factor serves, that of the last tangent of the iteration.
    ///
    /// # Errors
    /// The linear solver failed.
    pub fn response(
        &mut self,
        system: &System,
        before: &dyn Equation,
        after: &dyn Equation,
    ) -> Result<f64, String> {
        let moved = before.prescribed(system, &mut self.increment);
        if moved {
            // The product of the tangent with a prescribed motion comes with its assembly.
            self.linearize(system, after, Some(before))?;
        } else {
            after.rest(system, &mut self.residual);
            before.rest(system, &mut self.internal);
            subtract(&mut self.residual, &self.internal);
            self.change_of_forces(system, before, after);
        }
        self.find_response(system, moved, true)
    }

    /// Takes the tangent of an equilibrium and finds its response to a change of the loads from there to `before`, and
    /// its softest mode. Returns the size of the response, the mode and the number of negative pivots.
    ///
    /// # Errors
    /// There is no factor, or the linear solver failed.
    pub fn softest_mode(
        &mut self,
        system: &System,
        equilibrium: &dyn Equation,
        loaded: &dyn Equation,
    ) -> Result<(f64, SoftestMode, usize), String> {
        let negative = self.linearize(system, equilibrium, Some(loaded))?;
        let moved = loaded.prescribed(system, &mut self.increment);
        if !moved {
            loaded.rest(system, &mut self.residual);
            equilibrium.rest(system, &mut self.internal);
            subtract(&mut self.residual, &self.internal);
            self.change_of_forces(system, equilibrium, loaded);
        }
        let response = self.find_response(system, moved, true)?;
        let answer = self.increment.clone();
        let work: f64 =
            self.residual.as_flattened().iter().zip(answer.as_flattened()).map(|(f, u)| f * u).sum();
        // 1/λ of the mode, whose metric is the number of vectors.
        let mut compliance = 0.0;
        let mut shape: Vec<Nodal> = vec![[0.0; 3]; system.vectors()];
        for (x, random) in shape.as_flattened_mut().iter_mut().zip(noise()) {
            *x = random;
        }
        for _ in 0..INVERSE_ITERATIONS {
            self.residual.copy_from_slice(&shape);
            apply_metric(system, &mut self.residual);
            let size = self.find_response(system, false, false)?;
            compliance = size;
            for (x, y) in shape.as_flattened_mut().iter_mut().zip(self.increment.as_flattened()) {
                *x = y / size;
            }
        }
        let mut scaled = shape.clone();
        apply_metric(system, &mut scaled);
        let product: f64 = scaled.as_flattened().iter().zip(answer.as_flattened()).map(|(a, b)| a * b).sum();
        let excited = product.abs() / (shape.len() as f64 * response.max(f64::MIN_POSITIVE));
        let stored = product * product / (compliance * shape.len() as f64);
        let energy = stored / work.abs().max(f64::MIN_POSITIVE);
        Ok((response, SoftestMode { shape, excited, energy }, negative))
    }

    /// What the eigenvalues next to zero of the tangent of the equilibrium found last, with the circulatory part of follower
    /// loads, say about its stability. Arnoldi's process on `(K + N)⁻¹ D`, D the metric of [`System::norm`].
    ///
    /// # Errors
    /// The linear solver failed.
    pub(super) fn eigenvalues_next_to_zero(&mut self, system: &System) -> Result<NextToZero, String> {
        let size = system.unknowns();
        let mut arnoldi = Gmres::new(size, (MOST_ENTRIES / size.max(1)).clamp(20, MOST_VECTORS));
        let start: Vec<f64> = noise().take(size).collect();
        let (mut last, mut without): (Vec<f64>, usize) = (Vec::new(), 0);
        let mut found = NextToZero { real_negative: false, pairs: 0 };
        let mut looked = |values: &[[f64; 2]], exact: bool| {
            let (now, pairs) = sorted_out(values);
            let settled = |a: &f64| exact || last.iter().any(|b| (a - b).abs() <= SETTLED * a.abs());
            found = NextToZero { real_negative: now.iter().any(settled), pairs };
            without = if now.is_empty() { without + 1 } else { 0 };
            last = now;
            found.real_negative || without == LOOKS_WITHOUT
        };
        let Self { solver, axes, circulatory, increment, .. } = self;
        arnoldi.ritz_values(&start, EIGENVALUE_STEPS, &mut looked, |v, out| {
            expand_free(axes, v, false, increment);
            apply_metric(system, increment);
            axes.reduce(increment, out);
            solver.solve_tangent(out)?;
            match circulatory {
                Some(loads) => loads.correct(solver, axes, out, Purpose::Eigenvalues),
                None => Ok(()),
            }
        })?;
        Ok(found)
    }

    /// Assembles and factors the tangent at an iterate. The residual becomes that of the loads and prescribed motions of
    /// `loaded`, in whose place prescribed motions are zero without it. Returns the number of negative pivots.
    fn linearize(
        &mut self,
        system: &System,
        equation: &dyn Equation,
        loaded: Option<&dyn Equation>,
    ) -> Result<usize, String> {
        let moved = loaded.is_some_and(|l| l.prescribed(system, &mut self.increment));
        let (k, parts) = (equation.kinematics(system), equation.parts());
        equation.rest(system, &mut self.residual);
        self.assembly.follow(system, &k);
        self.held = Held::Nothing;
        let Self { solver, assembly, internal, circulatory, .. } = self;
        if let Some(loads) = circulatory {
            loads.take(system, &k, &parts);
        }
        let prescribed = moved.then_some(self.increment.as_slice());
        let at = Linearization { system, motion: &k, parts: &parts, extrapolated: false, prescribed };
        let negative = loop {
            solver.assemble(assembly, &at, internal);
            solver.add_curvature(assembly, &at, &self.residual);
            if let Some(done) = solver.prepare(assembly).transpose() {
                break done?;
            }
        };
        self.axes.copy_axes(&self.assembly.numbering);
        if let Some(loaded) = loaded.filter(|_| moved) {
            loaded.rest(system, &mut self.residual);
            add_follower_stiffness(system, &k, &parts, &self.increment, &mut self.residual);
            subtract(&mut self.residual, &self.internal);
        }
        Ok(negative)
    }

    /// Adds what prescribed strains change of the internal forces f between two equations of the same displacements to
    /// the residual: f(`first`) − f(`second`).
    fn change_of_forces(&mut self, system: &System, first: &dyn Equation, second: &dyn Equation) {
        if system.prescribed_strains.is_empty() {
            return;
        }
        for (equation, sign) in [(first, 1.0), (second, -1.0)] {
            self.assembly.forces(system, &equation.kinematics(system), &mut self.internal);
            for (r, f) in self.residual.as_flattened_mut().iter_mut().zip(self.internal.as_flattened()) {
                *r += sign * f;
            }
        }
    }

    /// Solves for the residual, with the unsymmetric tangent if it is `whole`; prescribed coordinates keep their increment
    /// if they have `moved`, else they are at rest. Returns the size of the increment.
    fn find_response(&mut self, system: &System, moved: bool, whole: bool) -> Result<f64, String> {
        self.axes.reduce(&self.residual, &mut self.solution);
        self.solver.solve_tangent(&mut self.solution)?;
        if let Some(loads) = self.circulatory.as_mut().filter(|_| whole) {
            loads.correct(&mut self.solver, &self.axes, &mut self.solution, Purpose::Increment)?;
        }
        expand_free(&self.axes, &self.solution, moved, &mut self.increment);
        Ok(system.norm(&self.increment))
    }
}

/// Real negative ones of eigenvalues by size, and the number of complex pairs.
fn sorted_out(values: &[[f64; 2]]) -> (Vec<f64>, usize) {
    let largest = values.iter().map(|[re, im]| re.hypot(*im)).fold(0.0, f64::max);
    let counts = |[re, im]: &&[f64; 2]| re.hypot(*im) > NOISE * largest;
    let (real, complex): (Vec<&[f64; 2]>, Vec<_>) =
        values.iter().filter(counts).partition(|[re, im]| im.abs() <= REAL * re.abs());
    let mut negative: Vec<f64> = real.into_iter().map(|[re, _]| *re).filter(|re| *re < 0.0).collect();
    negative.sort_by(f64::total_cmp);
    (negative, complex.len() / 2)
}

/// Multiplies displacements by the weights of [`System::norm`].
fn apply_metric(system: &System, field: &mut [Nodal]) {
    for (x, kind) in field.iter_mut().zip(&system.kinds) {
        if *kind == VectorKind::Position {
            *x = x.map(|x| x / (system.length * system.length));
        }
    }
}

fn subtract(from: &mut [Nodal], what: &[Nodal]) {
    for (x, y) in from.as_flattened_mut().iter_mut().zip(what.as_flattened()) {
        *x -= y;
    }
}
