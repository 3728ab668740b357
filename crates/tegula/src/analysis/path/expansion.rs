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

use super::series::Series;
use crate::Result;
use crate::analysis::newton::NOTHING_MOVES;
use crate::analysis::solver::{self, Linearization, TangentSolver as _};
use crate::analysis::unstable_modes::UnstableModes;
use crate::analysis::unstable_modes::normalize;
use crate::element::power_series::KnownOrders;
use crate::element::{Nodal, TangentWeights};
use crate::model::PathAnalysis;
use crate::norm::larger;
use crate::system::assembly::TangentCoefficients;
use crate::system::power_series::SeriesStresses;
use crate::system::{Assembly, EvaluationPoint, System, add_multiple};
use tegula_sparse::SparseLdlt;
use tegula_sparse::gmres::noise;

/// Length of a series without a last term, as of a path that is a straight line.
const STRAIGHT: f64 = 1e3;

/// Directions at a point whose tangent is factored.
#[derive(Debug, Clone)]
pub struct Directions {
    /// Newton increment `K⁻¹R`.
    pub increment: Vec<Nodal>,
    /// Change û of the displacements with the load factor, prescribed displacements included.
    pub unit: Vec<Nodal>,
}

impl Directions {
    /// Newton increment without its part along a direction of the path, and the change of the load factor that this part stands for.
    pub fn across(&self, system: &System, direction: &[Nodal]) -> (Vec<Nodal>, f64) {
        let Self { increment, unit } = self;
        let along = system.inner_product(direction, unit);
        let change = if along == 0.0 { 0.0 } else { -system.inner_product(direction, increment) / along };
        let mut across = increment.clone();
        add_multiple(&mut across, change, unit);
        (across, change)
    }
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

    /// Residual `λF − f` of a point in the free degrees of freedom, and its size and that of the larger of both forces
    /// ([`System::force_norm`]).
    pub fn residual(&mut self, system: &System, u: &[Nodal], load: f64, out: &mut [f64]) -> [f64; 2] {
        let k = EvaluationPoint::at_rest(system, u, load, &[]);
        self.assembly.forces(system, &k, &mut self.field);
        let mut external = vec![[0.0; 3]; self.field.len()];
        system.add_dead_loads(load, 1.0, &mut external);
        let size = larger(system.force_norm(&self.field), system.force_norm(&external));
        for (e, f) in external.as_flattened_mut().iter_mut().zip(self.field.as_flattened()) {
            *e -= f;
        }
        self.assembly.frames.reduce(&external, out);
        self.assembly.frames.expand(out, &mut external);
        [system.force_norm(&external), size]
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
            system.apply_metric(&mut mode);
            self.assembly.frames.reduce(&mode, &mut self.free);
            self.solver.solve_tangent(&mut self.free)?;
            self.assembly.frames.expand(&self.free, &mut mode);
            eigenvalue = 1.0 / system.inner_product(&before, &mode);
            normalize(system, &mut mode);
        }
        Ok((eigenvalue, mode))
    }

    /// Eigenvectors of the negative eigenvalues of the factored tangent, whose number is given; `None` where they are not found.
    pub fn unstable_modes(&mut self, system: &System, negative: usize) -> Option<UnstableModes> {
        let Self { solver, assembly, .. } = self;
        UnstableModes::of(system, &assembly.frames, negative, &mut |x| solver.solve_tangent(x))
    }

    /// Unstable modes of an earlier equilibrium at that of the factored tangent: [`UnstableModes::followed`].
    pub fn followed(
        &mut self,
        system: &System,
        modes: &UnstableModes,
        negative: usize,
    ) -> Option<UnstableModes> {
        let Self { solver, assembly, .. } = self;
        modes.followed(system, &assembly.frames, negative, &mut |x| solver.solve_tangent(x))
    }

    /// Series at a point of the path with its directions, whose tangent is factored. It goes on along the direction `before`, at the start
    /// of a path (empty) with rising loads, or falling ones. The residual fades over the length `expected`.
    ///
    /// # Errors
    /// The coefficients are not finite; the text gives the reason.
    pub fn series(
        &mut self,
        system: &System,
        (u, load, directions): (&[Nodal], f64, Directions),
        (before, expected): (&[Nodal], f64),
        options: &PathAnalysis,
    ) -> std::result::Result<Series, String> {
        // Next to a bifurcation the response to the residual is large along the path.
        let (mut first, change) = directions.across(system, before);
        let unit = directions.unit;
        if system.norm(&unit) == 0.0 {
            return Err(NOTHING_MOVES.into());
        }
        // At the start of a path nothing is left from a step before.
        let share = if expected > 0.0 { 1.0 / expected } else { 0.0 };
        first.as_flattened_mut().iter_mut().for_each(|x| *x *= share);
        let along = match before {
            [] => options.end_load,
            before => system.inner_product(&unit, before),
        };
        let rest = first_order(system, &unit, &first, along)
            .ok_or_else(|| "the residual of the step before is too large".to_owned())?;
        add_multiple(&mut first, rest, &unit);
        let load_rate = rest + share * change;
        let denominator = system.inner_product(&unit, &first);
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
            let load = system.inner_product(&next, &series.coefficients[0]) / denominator;
            next.as_flattened_mut().iter_mut().for_each(|x| *x = -*x);
            add_multiple(&mut next, load, &unit);
            if !(load.is_finite() && system.norm(&next).is_finite()) {
                // Where the range is short, high orders are beyond the largest number: the series ends before them.
                break;
            }
            series.loads.push(load);
            series.coefficients.push(next);
        }
        series.range = range(system, &series, options.tolerance)
            .ok_or_else(|| "the coefficients of the power series are not finite".to_owned())?;
        Ok(series)
    }

    /// Directions at a point whose tangent is factored.
    ///
    /// # Errors
    /// The linear solver failed.
    pub fn directions(
        &mut self,
        system: &System,
        u: &[Nodal],
        load: f64,
    ) -> std::result::Result<Directions, String> {
        let unit = self.unit_response(system, u, load)?;
        let mut residual = vec![0.0; self.free.len()];
        self.residual(system, u, load, &mut residual);
        self.free.copy_from_slice(&residual);
        self.solver.solve_tangent(&mut self.free)?;
        let mut increment = vec![[0.0; 3]; u.len()];
        self.assembly.frames.expand(&self.free, &mut increment);
        Ok(Directions { increment, unit })
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

/// First coefficient λ₁ of the load factor: of the two solutions of `|λ₁ û + ρ|² = 1` the one that goes on `along` the path, which has the
/// sign of the product of û with its direction.
fn first_order(system: &System, unit: &[Nodal], rest: &[Nodal], along: f64) -> Option<f64> {
    let (square, mixed) = (system.inner_product(unit, unit), system.inner_product(unit, rest));
    let left = 1.0 - system.inner_product(rest, rest);
    let discriminant = mixed * mixed + square * left;
    if !(left > 0.0 && discriminant.is_finite()) {
        return None;
    }
    let root = discriminant.sqrt();
    Some((if along < 0.0 { -root - mixed } else { root - mixed }) / square)
}

fn last(values: &[f64]) -> f64 {
    values.last().copied().unwrap_or(0.0)
}
