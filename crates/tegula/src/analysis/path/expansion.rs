//! Expansion of an equilibrium path into a power series at a point of it, with one factorisation of the tangent.
//!
//! With `û = K⁻¹F` and the residual `R₀ = λ₀F − f(v₀)` that the step before has left, which fades over the expected length a_c,
//!
//! ```text
//! order 1:  v₁ = λ₁ û + K⁻¹R₀/a_c,     ⟨v₁, v₁⟩ = 1
//! order p:  λ_p = ⟨K⁻¹f_p, v₁⟩ / ⟨û, v₁⟩,     v_p = λ_p û − K⁻¹f_p
//! range:    a = (ε |v₁| / |v_N|)^{1/(N−1)}
//! ```
//!
//! so that the path parameter is `a = ⟨v − v₀, v₁⟩`, with the scalar product of [`System::norm`]. The load factor is no part of it:
//! series whose parameter is mainly the load end before the next limit point, and where steps end would depend on the size of the loads
//! at load factor 1.
//!
//! B. Cochelin, N. Damil, M. Potier-Ferry, *Méthode asymptotique numérique*, Hermes-Lavoisier, 2007.

use super::critical_points::normalize;
use super::series::Series;
use crate::Result;
use crate::analysis::newton::apply_metric;
use crate::analysis::solver::{self, Linearization, TangentSolver as _};
use crate::element::power_series::KnownOrders;
use crate::element::{Nodal, TangentWeights};
use crate::model::PathAnalysis;
use crate::system::assembly::TangentCoefficients;
use crate::system::power_series::SeriesStresses;
use crate::system::{Assembly, EvaluationPoint, System, VectorKind, dot};
use tegula_sparse::SparseLdlt;
use tegula_sparse::gmres::noise;

/// Length of a series without a last term, as of a path that is a straight line.
const STRAIGHT: f64 = 1e3;

/// Direction of a path at a point: derivatives of displacements and load factor with respect to the path parameter.
#[derive(Debug, Clone, Copy)]
pub struct Direction<'a> {
    /// Derivative of the displacements; empty: the sign of the load factor's counts.
    pub u: &'a [Nodal],
    /// Derivative of the load factor.
    pub load: f64,
}

/// Workspace of expansions.
pub struct Expansion {
    solver: SparseLdlt,
    assembly: Assembly,
    stresses: SeriesStresses,
    /// Forces per load factor, with those of prescribed strains.
    load: Vec<Nodal>,
    /// Prescribed displacements per load factor.
    prescribed: Vec<Nodal>,
    /// Changes of the factors of prescribed strains with the load factor.
    strain_factors: Vec<f64>,
    /// Product of the tangent with the prescribed displacements per load factor, and internal forces.
    internal: Vec<Nodal>,
    field: Vec<Nodal>,
    free: Vec<f64>,
}

impl Expansion {
    /// Workspace for a system that has power series.
    ///
    /// # Errors
    /// The factor does not fit in memory.
    pub fn new(system: &System, stresses: SeriesStresses) -> Result<Self> {
        let fields = || vec![[0.0; 3]; system.vectors()];
        let (mut load, mut prescribed) = (fields(), fields());
        system.add_dead_loads(1.0, 1.0, &mut load);
        system.add_dead_loads(0.0, -1.0, &mut load);
        let mut at_rest = fields();
        system.prescribe(1.0, &mut prescribed);
        system.prescribe(0.0, &mut at_rest);
        for (x, y) in prescribed.as_flattened_mut().iter_mut().zip(at_rest.as_flattened()) {
            *x -= y;
        }
        let strain_factors = system
            .prescribed_strains
            .iter()
            .map(|field| system.factor(&field.factor, 1.0) - system.factor(&field.factor, 0.0))
            .collect();
        Ok(Self {
            solver: solver::direct(system)?,
            assembly: Assembly::new(system),
            stresses,
            load,
            prescribed,
            strain_factors,
            internal: fields(),
            field: fields(),
            free: vec![0.0; system.unknowns()],
        })
    }

    /// Number of factorisations so far.
    pub fn factorizations(&self) -> u64 {
        self.solver.tangents() as u64
    }

    /// Buffers of the assembly.
    pub fn assembly(&mut self) -> &mut Assembly {
        &mut self.assembly
    }

    /// Factors the tangent at a point of the path; returns the number of its negative pivots.
    ///
    /// # Errors
    /// The tangent is singular, or the forces are not finite; the text gives the reason.
    pub fn factor(&mut self, system: &System, u: &[Nodal], load: f64) -> std::result::Result<usize, String> {
        let k = EvaluationPoint::at_rest(system, u, load, &[]);
        let parts = TangentCoefficients { weights: TangentWeights::STATIC, mass: 0.0, time: load };
        let moves = !system.dofs().prescribed.is_empty();
        let prescribed = moves.then_some(self.prescribed.as_slice());
        let at = Linearization { system, point: &k, parts: &parts, extrapolated: false, prescribed };
        loop {
            self.solver.assemble(&mut self.assembly, &at, &mut self.internal);
            if !self.internal.as_flattened().iter().all(|f| f.is_finite()) {
                return Err("the forces are no longer finite".into());
            }
            if let Some(done) = self.solver.prepare(&mut self.assembly).transpose() {
                return done;
            }
        }
    }

    /// Residual `λF − f` of a point in the free degrees of freedom, and the norm of the larger of both forces.
    pub fn residual(&mut self, system: &System, u: &[Nodal], load: f64, out: &mut [f64]) -> f64 {
        let k = EvaluationPoint::at_rest(system, u, load, &[]);
        self.assembly.forces(system, &k, &mut self.field);
        let mut external = vec![[0.0; 3]; self.field.len()];
        system.add_dead_loads(load, 1.0, &mut external);
        let size = dot(&self.field, &self.field).sqrt().max(dot(&external, &external).sqrt());
        for (e, f) in external.as_flattened_mut().iter_mut().zip(self.field.as_flattened()) {
            *e -= f;
        }
        self.assembly.frames.reduce(&external, out);
        size
    }

    /// Force per load factor at a point, without the part of prescribed displacements: `−∂R/∂λ` at fixed displacements.
    pub fn load_at(&mut self, system: &System, u: &[Nodal], load: f64, out: &mut [Nodal]) {
        out.copy_from_slice(&self.load);
        if self.strain_factors.iter().all(|factor| *factor == 0.0) {
            return;
        }
        for (at, sign) in [(load, 1.0), (load + 1.0, -1.0)] {
            let k = EvaluationPoint::at_rest(system, u, at, &[]);
            self.assembly.forces(system, &k, &mut self.field);
            for (x, f) in out.as_flattened_mut().iter_mut().zip(self.field.as_flattened()) {
                *x += sign * f;
            }
        }
    }

    /// Prescribed displacements per load factor.
    pub fn prescribed(&self) -> &[Nodal] {
        &self.prescribed
    }

    /// Eigenvalue next to zero of the factored tangent in the metric of [`System::norm`], and its eigenvector of unit norm, by inverse
    /// iteration from a fixed start.
    ///
    /// # Errors
    /// The linear solver failed.
    pub fn eigenvalue_next_to_zero(
        &mut self,
        system: &System,
        iterations: usize,
    ) -> std::result::Result<(f64, Vec<Nodal>), String> {
        self.free.iter_mut().zip(noise()).for_each(|(x, start)| *x = start);
        let mut mode = vec![[0.0; 3]; system.vectors()];
        self.assembly.frames.expand(&self.free, &mut mode);
        normalize(system, &mut mode);
        let mut eigenvalue = f64::NAN;
        for _ in 0..iterations {
            let before = mode.clone();
            apply_metric(system, &mut mode);
            self.assembly.frames.reduce(&mode, &mut self.free);
            self.solver.solve_tangent(&mut self.free)?;
            self.assembly.frames.expand(&self.free, &mut mode);
            eigenvalue = 1.0 / product(system, &before, &mode);
            normalize(system, &mut mode);
        }
        Ok((eigenvalue, mode))
    }

    /// Series at a point of the path whose tangent is factored: it goes on along `before`. A residual fades over the length
    /// `expected`.
    ///
    /// # Errors
    /// The coefficients are not finite; the text gives the reason.
    pub fn series(
        &mut self,
        system: &System,
        (u, load): (&[Nodal], f64),
        (before, expected): (Direction, f64),
        options: &PathAnalysis,
    ) -> std::result::Result<Series, String> {
        let (mut first, unit) = self.newton_directions(system, u, load)?;
        if product(system, &unit, &unit) == 0.0 {
            return Err(
                "no load, prescribed displacement or prescribed strain changes with the load factor".into()
            );
        }
        // At the start of a path nothing is left from a step before.
        let share = if expected > 0.0 { 1.0 / expected } else { 0.0 };
        first.as_flattened_mut().iter_mut().for_each(|x| *x *= share);
        // Next to a bifurcation the response to the residual is large along the path, where it is a change of the load factor.
        let along = if before.u.is_empty() { 0.0 } else { product(system, before.u, &unit) };
        let change = if along == 0.0 { 0.0 } else { -product(system, before.u, &first) / along };
        add_multiple(&mut first, change, &unit);
        let rest = first_order(system, &unit, &first, before)
            .ok_or_else(|| "the residual of the step before is too large".to_owned())?;
        add_multiple(&mut first, rest, &unit);
        let load_rate = rest + change;
        let denominator = product(system, &unit, &first);
        let mut series = Series {
            u: u.to_vec(),
            coefficients: vec![first],
            loads: vec![load, load_rate],
            range: STRAIGHT,
        };
        let highest = options.order as usize;
        for _ in 2..=highest {
            let factors: Vec<f64> = self.strain_factors.iter().map(|f| f * last(&series.loads)).collect();
            let known = KnownOrders {
                reference: &system.coordinates.reference,
                u,
                coefficients: &series.coefficients,
                strain_factors: &factors,
                highest,
            };
            self.assembly.forces_of_order(system, &known, &mut self.stresses, &mut self.field);
            self.assembly.frames.reduce(&self.field, &mut self.free);
            self.solver.solve_tangent(&mut self.free)?;
            let mut next = vec![[0.0; 3]; u.len()];
            self.assembly.frames.expand(&self.free, &mut next);
            let load = product(system, &next, &series.coefficients[0]) / denominator;
            next.as_flattened_mut().iter_mut().for_each(|x| *x = -*x);
            add_multiple(&mut next, load, &unit);
            series.loads.push(load);
            series.coefficients.push(next);
        }
        series.range = range(system, &series, options.tolerance)
            .ok_or_else(|| "the coefficients of the power series are not finite".to_owned())?;
        Ok(series)
    }

    /// Error of the displacements of a point whose tangent is factored, across the direction of the path: norm of the Newton increment
    /// `K⁻¹R + δλ û` without part along the direction.
    ///
    /// # Errors
    /// The linear solver failed.
    pub fn error_across(
        &mut self,
        system: &System,
        (u, load): (&[Nodal], f64),
        direction: &[Nodal],
    ) -> std::result::Result<f64, String> {
        let (mut increment, unit) = self.newton_directions(system, u, load)?;
        let along = product(system, direction, &unit);
        if along != 0.0 {
            let change = -product(system, direction, &increment) / along;
            add_multiple(&mut increment, change, &unit);
        }
        Ok(system.norm(&increment))
    }

    /// Newton increment `K⁻¹R` at a point whose tangent is factored, and the change û of the displacements with the load factor.
    ///
    /// # Errors
    /// The linear solver failed.
    pub fn newton_directions(
        &mut self,
        system: &System,
        u: &[Nodal],
        load: f64,
    ) -> std::result::Result<(Vec<Nodal>, Vec<Nodal>), String> {
        let unit = self.unit_response(system, u, load)?;
        let mut residual = vec![0.0; self.free.len()];
        self.residual(system, u, load, &mut residual);
        self.free.copy_from_slice(&residual);
        self.solver.solve_tangent(&mut self.free)?;
        let mut increment = vec![[0.0; 3]; u.len()];
        self.assembly.frames.expand(&self.free, &mut increment);
        Ok((increment, unit))
    }

    /// Change `û` of the displacements with the load factor along the tangent, prescribed displacements included.
    fn unit_response(
        &mut self,
        system: &System,
        u: &[Nodal],
        load: f64,
    ) -> std::result::Result<Vec<Nodal>, String> {
        let mut force = vec![[0.0; 3]; u.len()];
        self.load_at(system, u, load, &mut force);
        if !system.dofs().prescribed.is_empty() {
            // The factorisation has left f + K ū.
            let k = EvaluationPoint::at_rest(system, u, load, &[]);
            self.assembly.forces(system, &k, &mut self.field);
            let product = self.internal.as_flattened().iter().zip(self.field.as_flattened());
            for (x, (with, without)) in force.as_flattened_mut().iter_mut().zip(product) {
                *x -= with - without;
            }
        }
        self.assembly.frames.reduce(&force, &mut self.free);
        self.solver.solve_tangent(&mut self.free)?;
        self.assembly.frames.expand(&self.free, &mut force);
        add_multiple(&mut force, 1.0, &self.prescribed);
        Ok(force)
    }
}

/// Length of a series by its last term, `(ε |v₁| / |v_N|)^{1/(N−1)}`; `None` where the terms are not finite.
pub fn range(system: &System, series: &Series, tolerance: f64) -> Option<f64> {
    let [first, .., last] = series.coefficients.as_slice() else { return None };
    let [first, last] = [first, last].map(|v| system.norm(v));
    if !(first.is_finite() && last.is_finite()) {
        return None;
    }
    if first == 0.0 || last == 0.0 {
        return Some(STRAIGHT);
    }
    Some((tolerance * first / last).powf(1.0 / (series.coefficients.len() - 1) as f64).min(STRAIGHT))
}

/// First coefficient λ₁ of the load factor: of the two solutions of `|λ₁ û + ρ|² = 1` the one that goes on along the path.
fn first_order(system: &System, unit: &[Nodal], rest: &[Nodal], before: Direction) -> Option<f64> {
    let (square, mixed) = (product(system, unit, unit), product(system, unit, rest));
    let left = 1.0 - product(system, rest, rest);
    let discriminant = mixed * mixed + square * left;
    if !(left > 0.0 && discriminant.is_finite()) {
        return None;
    }
    let along = if before.u.is_empty() { before.load } else { product(system, unit, before.u) };
    let root = discriminant.sqrt();
    Some((if along < 0.0 { -root - mixed } else { root - mixed }) / square)
}

/// Scalar product of [`System::norm`].
pub fn product(system: &System, a: &[Nodal], b: &[Nodal]) -> f64 {
    let mut sum = 0.0;
    for ((a, b), kind) in a.iter().zip(b).zip(&system.coordinates.kinds) {
        let own = a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        sum += if *kind == VectorKind::Position { own / (system.length * system.length) } else { own };
    }
    sum / a.len().max(1) as f64
}

fn add_multiple(to: &mut [Nodal], factor: f64, what: &[Nodal]) {
    for (x, y) in to.as_flattened_mut().iter_mut().zip(what.as_flattened()) {
        *x += factor * y;
    }
}

fn last(values: &[f64]) -> f64 {
    values.last().copied().unwrap_or(0.0)
}
