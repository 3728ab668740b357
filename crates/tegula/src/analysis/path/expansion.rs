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

use super::directors::DirectorSeries;
use super::joint_series;
use super::pressure_series::PressureSeries;
use super::series::Series;
use crate::Result;
use crate::analysis::constraints::{Constraints, values_of};
use crate::analysis::direct::Direct;
use crate::analysis::newton::NOTHING_MOVES;
use crate::analysis::solver::{Linearization, TangentSolver as _};
use crate::analysis::unstable_modes::UnstableModes;
use crate::analysis::unstable_modes::normalize;
use crate::analysis::{State, equilibrium};
use crate::element::power_series::KnownOrders;
use crate::element::{Motion, Nodal, TangentWeights};
use crate::model::PathAnalysis;
use crate::norm::larger;
use crate::system::assembly::{TangentCoefficients, add_follower_loads};
use crate::system::power_series::SeriesStresses;
use crate::system::{Assembly, EvaluationPoint, Internal, LocalFrames, System, add_multiple};
use tegula_sparse::gmres::noise;

/// Length of a series without a last term, as of a path that is a straight line.
const STRAIGHT: f64 = 1e3;

/// Part of the response to the loads that joints leave, below which it is round-off.
const MOTIONLESS: f64 = 1e-12;

/// Displacement under the load at the end of the path, by the tangent at its start, that is round-off where joints hold the model.
const HELD: f64 = 1e-13;

/// Value of a constraint over its size above which a joint counts as open.
const OPEN: f64 = 1e-8;

/// Directions at a point whose tangent is factored.
#[derive(Debug, Clone)]
pub struct Directions {
    /// Newton increment `K⁻¹R`.
    pub increment: Vec<Nodal>,
    /// Change û of the displacements with the load factor, prescribed displacements included.
    pub unit: Vec<Nodal>,
    /// Multipliers of joints that belong to both.
    multipliers: [Vec<f64>; 2],
}

impl Directions {
    /// Newton increment without its part along a direction of the path, and the change of the load factor that this part stands for.
    pub fn across(&self, system: &System, direction: &[Nodal]) -> (Vec<Nodal>, f64) {
        let Self { increment, unit, .. } = self;
        let along = system.inner_product(direction, unit);
        let change = if along == 0.0 { 0.0 } else { -system.inner_product(direction, increment) / along };
        let mut across = increment.clone();
        add_multiple(&mut across, change, unit);
        (across, change)
    }
}

/// Workspace of expansions.
pub struct Expansion {
    solver: Direct,
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
    /// Local frames of the factored tangent.
    frames: LocalFrames,
    /// Constraints of joints, where there are some, and the weight of the augmented Lagrangian.
    constraints: Option<Constraints>,
    penalty: f64,
    /// Square roots of the compliances of the constraints at the factored tangent, where there is one.
    norm: Option<Vec<f64>>,
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
        let mut assembly = Assembly::new(system);
        let mut constraints = Constraints::new(system);
        if let Some(constraints) = &mut constraints {
            constraints.pass_critical_points();
        }
        Ok(Self {
            solver: Direct::new(system)?,
            penalty: equilibrium::penalty(system, &mut assembly, &State::first(system)),
            constraints,
            norm: None,
            assembly,
            stresses,
            load,
            prescribed,
            strain_factors,
            internal: fields(),
            field: fields(),
            frames: system.frames.clone(),
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

    /// Multipliers of joints at a point of the path; the local frames of the assembly are those of the point then.
    pub fn multipliers(&mut self, system: &System, u: &[Nodal], load: f64) -> Vec<f64> {
        let none = vec![0.0; system.constraints()];
        let k = EvaluationPoint::at_rest(system, u, load, Internal { history: &[], multipliers: &none });
        self.assembly.follow(system, &k);
        if none.is_empty() {
            return none;
        }
        self.assembly.forces(system, &k, &mut self.field);
        self.field.as_flattened_mut().iter_mut().for_each(|x| *x = -*x);
        add_loads(system, u, (load, 1.0), &mut self.field);
        let mut rest = vec![0.0; self.free.len()];
        self.assembly.frames.reduce(&self.field, &mut rest);
        let norm = self.norm.as_deref();
        joint_series::multipliers_at(system, &self.assembly.frames, (u, load), (&rest, norm))
    }

    /// Internal forces at a point of the path, with those of joints.
    pub fn forces(&mut self, system: &System, u: &[Nodal], load: f64, out: &mut [Nodal]) {
        let multipliers = self.multipliers(system, u, load);
        self.assembly.forces(system, &point(system, u, load, &multipliers), out);
    }

    /// Solves `K x + Gᵀν = b` with the factored tangent in place, where `G x = −rest`; returns ν.
    fn solve(&mut self, rest: &[f64]) -> std::result::Result<Vec<f64>, String> {
        self.solver.solve_tangent(&mut self.free)?;
        let Self { constraints, free, .. } = self;
        let Some(constraints) = constraints else { return Ok(Vec::new()) };
        let size = |x: &[f64]| x.iter().map(|x| x.abs()).fold(0.0, larger);
        let before = size(free);
        let multipliers = constraints.satisfy(rest, free).to_vec();
        if size(free) <= MOTIONLESS * before {
            free.fill(0.0);
        }
        Ok(multipliers)
    }

    /// Messages about joints with constraints that are redundant at the factored tangent.
    pub fn redundant<'a>(&'a self, system: &'a System) -> impl Iterator<Item = String> + 'a {
        self.constraints.iter().flat_map(|constraints| constraints.redundant(system))
    }

    /// Joint that is open at a point of the path, as a sentence without a full stop.
    pub fn open_joint(&self, system: &System, u: &[Nodal], load: f64) -> Option<String> {
        let motion = Motion::State { u, velocity: None };
        let open = self.constraints.as_ref()?.violation(system, (&motion, load), OPEN)?;
        Some(format!("{open}: its constraints contradict those of other joints"))
    }

    /// Factors the tangent at a point of the path; returns the number of its negative pivots.
    ///
    /// # Errors
    /// The tangent is singular, or the forces are not finite; the text gives the reason.
    pub fn factor(&mut self, system: &System, u: &[Nodal], load: f64) -> std::result::Result<usize, String> {
        // A run that is resumed has no earlier tangent.
        self.norm = None;
        let multipliers = self.multipliers(system, u, load);
        let k = point(system, u, load, &multipliers);
        let weights = TangentWeights { penalty: self.penalty, ..TangentWeights::STATIC };
        let parts = TangentCoefficients { weights, mass: 0.0, time: load };
        let moves = !system.dofs().prescribed.is_empty();
        let prescribed = moves.then_some(self.prescribed.as_slice());
        let at = Linearization { system, point: &k, parts: &parts, extrapolated: false, prescribed };
        self.frames.copy_from(&self.assembly.frames);
        self.field.fill([0.0; 3]);
        add_loads(system, u, (load, 1.0), &mut self.field);
        let mut negative = loop {
            let Self { solver, assembly, internal, field: external, .. } = self;
            solver.assemble(assembly, &at, internal);
            solver.add_curvature(assembly, &at, external);
            if system.has_body_curvature(&parts.weights) {
                assembly.add_body_curvature(system, &k, &parts.weights, (false, external));
            }
            if !internal.as_flattened().iter().all(|f| f.is_finite()) {
                return Err("the forces are no longer finite".into());
            }
            if let Some(done) = solver.prepare(assembly).transpose() {
                break done?;
            }
        };
        let Self { solver, frames, constraints, .. } = self;
        if let Some(constraints) = constraints {
            constraints.begin_step();
            constraints.take(system, (&k, &parts.weights), frames, solver)?;
            negative = negative.saturating_sub(constraints.negative_eigenvalues());
            self.norm = Some(constraints.schur().scale.clone());
        }
        Ok(negative)
    }

    /// Residual `λF − f` of a point in the free degrees of freedom, and its size and that of the largest of loads, internal forces, and internal
    /// forces without those of joints ([`System::force_norm`]).
    pub fn residual(&mut self, system: &System, u: &[Nodal], load: f64, out: &mut [f64]) -> [f64; 2] {
        let mut external = vec![[0.0; 3]; self.field.len()];
        add_loads(system, u, (load, 1.0), &mut external);
        let multipliers = self.multipliers(system, u, load);
        let mut size = system.force_norm(&external);
        if self.constraints.is_some() {
            // Forces of joints may balance those of the elements at every node.
            add_multiple(&mut self.field, -1.0, &external);
            size = larger(size, system.force_norm(&self.field));
        }
        self.assembly.forces(system, &point(system, u, load, &multipliers), &mut self.field);
        size = larger(size, system.force_norm(&self.field));
        add_multiple(&mut external, -1.0, &self.field);
        self.assembly.frames.reduce(&external, out);
        self.assembly.frames.expand(out, &mut external);
        [system.force_norm(&external), size]
    }

    /// Force per load factor at a point, without the part of prescribed displacements: `−∂R/∂λ` at fixed displacements.
    pub fn load_at(&mut self, system: &System, u: &[Nodal], load: f64, out: &mut [Nodal]) {
        out.copy_from_slice(&self.load);
        let motion = Motion::State { u, velocity: None };
        for (at, sign) in [(1.0, 1.0), (0.0, -1.0)] {
            add_follower_loads(system, &motion, at, sign, out);
        }
        if self.strain_factors.iter().all(|factor| *factor == 0.0) {
            return;
        }
        let multipliers = vec![0.0; system.constraints()];
        for (at, sign) in [(load, 1.0), (load + 1.0, -1.0)] {
            self.assembly.forces(system, &point(system, u, at, &multipliers), &mut self.field);
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
        self.frames.expand(&self.free, &mut mode);
        normalize(system, &mut mode);
        let still = vec![0.0; system.constraints()];
        let mut eigenvalue = f64::NAN;
        for _ in 0..iterations {
            let before = mode.clone();
            system.apply_metric(&mut mode);
            self.frames.reduce(&mode, &mut self.free);
            self.solve(&still)?;
            self.frames.expand(&self.free, &mut mode);
            eigenvalue = 1.0 / system.inner_product(&before, &mode);
            normalize(system, &mut mode);
        }
        Ok((eigenvalue, mode))
    }

    /// Eigenvectors of the negative eigenvalues of the factored tangent, whose number is given; `None` where they are not found.
    pub fn unstable_modes(&mut self, system: &System, negative: usize) -> Option<UnstableModes> {
        let Self { solver, frames, constraints, .. } = self;
        UnstableModes::of(system, frames, negative, &mut |x| solve_at_rest((solver, constraints), x))
    }

    /// Unstable modes of an earlier equilibrium at that of the factored tangent: [`UnstableModes::followed`].
    pub fn followed(
        &mut self,
        system: &System,
        modes: &UnstableModes,
        negative: usize,
    ) -> Option<UnstableModes> {
        let Self { solver, frames, constraints, .. } = self;
        modes.followed(system, frames, negative, &mut |x| solve_at_rest((solver, constraints), x))
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
        let Directions { unit, multipliers: [of_increment, of_unit], .. } = directions;
        let size = system.norm(&unit);
        let is_held =
            self.constraints.is_some() && before.is_empty() && size * options.end_load.abs() <= HELD;
        if size == 0.0 || is_held {
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
        let rate = of_increment.iter().zip(&of_unit).map(|(a, b)| share * a + load_rate * b).collect();
        let mut multipliers = vec![self.multipliers(system, u, load), rate];
        let mut series = Series {
            u: u.to_vec(),
            coefficients: vec![first],
            loads: vec![load, load_rate],
            range: STRAIGHT,
        };
        let mut directors = self.directors_at(system, &series, &multipliers);
        let mut pressures = PressureSeries::new(system, load);
        let highest = options.order as usize;
        for _ in 2..=highest {
            let along = (unit.as_slice(), of_unit.as_slice(), denominator);
            let known = (&series, &mut multipliers);
            let Some((next, load)) =
                self.next_order(system, along, known, (highest, &mut directors, &mut pressures))?
            else {
                // Where the range is short, high orders are beyond the largest number: the series ends before them.
                break;
            };
            series.loads.push(load);
            series.coefficients.push(next);
        }
        series.range = range(system, &series, options.tolerance)
            .ok_or_else(|| "the coefficients of the power series are not finite".to_owned())?
            .min(joint_series::range(system, &multipliers, options.tolerance));
        Ok(series)
    }

    /// Directors at the start of a series with their multipliers up to order 1, from those of joints.
    fn directors_at(&mut self, system: &System, series: &Series, of_joints: &[Vec<f64>]) -> DirectorSeries {
        let (u, load) = (series.u.as_slice(), series.loads[0]);
        let mut directors = DirectorSeries::new(system, u);
        if directors.is_empty() {
            return directors;
        }
        let mut forces = vec![[0.0; 3]; u.len()];
        self.assembly.forces(system, &point(system, u, load, &of_joints[0]), &mut forces);
        add_loads(system, u, (load, -1.0), &mut forces);
        directors.take_multipliers(&forces);
        forces.fill([0.0; 3]);
        let last = (series.coefficients[0].as_slice(), last(&series.loads));
        self.take_multipliers(system, (series, &[]), (last, of_joints), (forces, &mut directors));
        directors
    }

    /// Takes the multipliers of directors of an order, from its coefficients of displacements and load factor, the lower coefficients of the
    /// displacements, the multipliers of joints up to this order, and the known `forces` f_p of the elements and joints.
    fn take_multipliers(
        &mut self,
        system: &System,
        (series, lower): (&Series, &[Vec<Nodal>]),
        ((coefficient, load), of_joints): ((&[Nodal], f64), &[Vec<f64>]),
        (mut forces, directors): (Vec<Nodal>, &mut DirectorSeries),
    ) {
        let (u, at) = (series.u.as_slice(), series.loads[0]);
        let mut part = vec![[0.0; 3]; coefficient.len()];
        self.assembly.tangent_product(system, &point(system, u, at, &of_joints[0]), coefficient, &mut part);
        add_multiple(&mut forces, 1.0, &part);
        self.load_at(system, u, at, &mut part);
        add_multiple(&mut forces, -load, &part);
        if let Some(multipliers) = of_joints.last() {
            joint_series::add_forces(system, u, multipliers, &mut forces);
        }
        directors.add_forces(lower, coefficient, &mut forces);
        directors.take_multipliers(&forces);
    }

    /// Coefficients of displacements and load factor of the next order; `None` where they are not finite. Those of the multipliers are added.
    fn next_order(
        &mut self,
        system: &System,
        (unit, of_unit, denominator): (&[Nodal], &[f64], f64),
        (series, multipliers): (&Series, &mut Vec<Vec<f64>>),
        (highest, directors, pressures): (usize, &mut DirectorSeries, &mut PressureSeries),
    ) -> std::result::Result<Option<(Vec<Nodal>, f64)>, String> {
        let (u, at) = (series.u.as_slice(), series.loads[0]);
        let factors: Vec<f64> = self.strain_factors.iter().map(|f| f * last(&series.loads)).collect();
        let known = KnownOrders {
            reference: &system.coordinates.reference,
            u,
            coefficients: &series.coefficients,
            strain_factors: &factors,
            multipliers,
            highest,
        };
        self.assembly.forces_of_order(system, &known, &mut self.stresses, &mut self.field);
        pressures.subtract_known(system, series, &mut self.field);
        let mut next = vec![[0.0; 3]; u.len()];
        let known_forces = if directors.is_empty() { Vec::new() } else { self.field.clone() };
        let free = directors.is_empty() && self.constraints.is_none();
        let across = if free { Vec::new() } else { directors.part_across(system, &series.coefficients) };
        if !directors.is_empty() {
            self.assembly.tangent_product(system, &point(system, u, at, &multipliers[0]), &across, &mut next);
            add_multiple(&mut self.field, 1.0, &next);
            directors.add_forces(&series.coefficients, &across, &mut self.field);
        }
        // The solution is that of the negative forces.
        let mut rates = joint_series::rates(system, u, &across, &series.coefficients);
        rates.iter_mut().for_each(|rate| *rate = -*rate);
        self.frames.reduce(&self.field, &mut self.free);
        let mut of_order = self.solve(&rates)?;
        self.frames.expand(&self.free, &mut next);
        next.as_flattened_mut().iter_mut().for_each(|x| *x = -*x);
        if !across.is_empty() {
            add_multiple(&mut next, 1.0, &across);
        }
        let load = -system.inner_product(&next, &series.coefficients[0]) / denominator;
        add_multiple(&mut next, load, unit);
        of_order.iter_mut().zip(of_unit).for_each(|(x, unit)| *x = load * unit - *x);
        multipliers.push(of_order);
        if !(load.is_finite() && system.norm(&next).is_finite()) {
            return Ok(None);
        }
        if !directors.is_empty() {
            let order = ((next.as_slice(), load), multipliers.as_slice());
            self.take_multipliers(system, (series, &series.coefficients), order, (known_forces, directors));
        }
        Ok(Some((next, load)))
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
        let (unit, of_unit) = self.unit_response(system, u, load)?;
        let mut residual = vec![0.0; self.free.len()];
        self.residual(system, u, load, &mut residual);
        self.free.copy_from_slice(&residual);
        let of_increment = self.solve(&values_of(system, (u, load), &[]))?;
        let mut increment = vec![[0.0; 3]; u.len()];
        self.frames.expand(&self.free, &mut increment);
        Ok(Directions { increment, unit, multipliers: [of_increment, of_unit] })
    }

    /// Change `û` of the displacements with the load factor along the tangent, prescribed displacements included, and that of the multipliers.
    fn unit_response(
        &mut self,
        system: &System,
        u: &[Nodal],
        load: f64,
    ) -> std::result::Result<(Vec<Nodal>, Vec<f64>), String> {
        let mut force = vec![[0.0; 3]; u.len()];
        self.load_at(system, u, load, &mut force);
        if !system.dofs().prescribed.is_empty() {
            // The factorisation has left f + K ū.
            let mut without = vec![[0.0; 3]; u.len()];
            self.forces(system, u, load, &mut without);
            let product = self.internal.as_flattened().iter().zip(without.as_flattened());
            for (x, (with, without)) in force.as_flattened_mut().iter_mut().zip(product) {
                *x -= with - without;
            }
        }
        self.frames.reduce(&force, &mut self.free);
        let rates = joint_series::rates(system, u, &self.prescribed, &[]);
        let mut multipliers = self.solve(&rates)?;
        // The product with the factored tangent contains the augmented Lagrangian.
        let weights = TangentWeights { penalty: self.penalty, ..TangentWeights::STATIC };
        let rows = system.joints.iter().flat_map(|joint| joint.multipliers().zip(&joint.rows));
        rows.for_each(|(i, row)| multipliers[i] += row.weight(&weights) * rates[i]);
        self.frames.expand(&self.free, &mut force);
        add_multiple(&mut force, 1.0, &self.prescribed);
        Ok((force, multipliers))
    }
}

/// Adds all loads at a point of the path, times a factor.
fn add_loads(system: &System, u: &[Nodal], (load, factor): (f64, f64), out: &mut [Nodal]) {
    system.add_dead_loads(load, factor, out);
    add_follower_loads(system, &Motion::State { u, velocity: None }, load, factor, out);
}

/// Evaluation point of displacements at a load factor, with multipliers of joints.
fn point<'a>(system: &System, u: &'a [Nodal], load: f64, multipliers: &'a [f64]) -> EvaluationPoint<'a> {
    EvaluationPoint::at_rest(system, u, load, Internal { history: &[], multipliers })
}

/// Solves with the factored tangent of the motions that joints leave.
fn solve_at_rest(
    (solver, constraints): (&mut Direct, &mut Option<Constraints>),
    x: &mut [f64],
) -> std::result::Result<(), String> {
    solver.solve_tangent(x)?;
    if let Some(constraints) = constraints {
        constraints.constrain(x);
    }
    Ok(())
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
