//! Natural frequencies and mode shapes: `K φ = ω² M φ` by shift-invert Lanczos, about the
//! reference configuration or an equilibrium.
//!
//! The shift lies below zero, so that the matrix to factor stays positive definite for free
//! bodies. A Sturm count (negative pivots of `K − sM` with `s` behind the last mode) proves that
//! no mode was missed.

use nalgebra::{SMatrix, SVector};

use super::{Observer, State, Statistics};
use crate::analysis::newton::Newton;
use crate::analysis::statics::state_kinematics;
use crate::element::{Nodal, TangentWeights};
use crate::linear::lanczos::{BlockLanczos, SymmetricOperator};
use crate::linear::{Factor as _, SparseCholesky, SymmetricPattern};
use crate::model::NewtonMethod;
use crate::system::assembly::{TangentParts, add_follower_loads};
use crate::system::{System, VectorKind};
use crate::{Error, Result, Vec3};

/// Residual of a pair, over its value, at which a mode counts as found. The eigenvalue's error is its square.
const TOLERANCE: f64 = 1e-8;
/// Basis vectors per wanted mode before the iteration gives up.
const BASIS_PER_MODE: usize = 40;

/// A vibration mode.
#[derive(Debug, Clone, PartialEq)]
pub struct Mode {
    /// Frequency f = ω/2π [1/time]; 0 for rigid modes.
    pub frequency_hz: f64,
    /// Circular frequency ω [rad/time]; 0 for rigid modes, negative: −√−λ of an unstable equilibrium.
    pub omega: f64,
    /// True for a motion of the whole body without strain.
    pub rigid: bool,
    /// Shape in all nodal vectors, of modal mass 1.
    pub shape: Vec<Nodal>,
    /// Norm of the residual of the shift-inverted problem over its eigenvalue.
    pub residual: f64,
}

/// Modes in ascending order.
#[derive(Debug, Clone, PartialEq)]
pub struct ModalOutcome {
    /// The modes.
    pub modes: Vec<Mode>,
    /// Counts; iterations are applications of the inverse.
    pub statistics: Statistics,
    /// The Sturm count agreed: no mode below the last one is missing.
    pub sturm_checked: bool,
}

struct ShiftInvert<'a> {
    solver: &'a mut SparseCholesky,
    pattern: &'a SymmetricPattern,
    mass: &'a [f64],
    watch: &'a dyn Observer,
    applications: u64,
}

impl<'a> ShiftInvert<'a> {
    /// With a factored matrix, and pattern and values of the mass.
    fn new(
        solver: &'a mut SparseCholesky,
        (pattern, mass): (&'a SymmetricPattern, &'a [f64]),
        watch: &'a dyn Observer,
    ) -> Self {
        Self { solver, pattern, mass, watch, applications: 0 }
    }
}

impl SymmetricOperator for ShiftInvert<'_> {
    fn size(&self) -> usize {
        self.pattern.size()
    }

    fn apply(&mut self, m_x: &[f64], out: &mut [f64]) {
        out.copy_from_slice(m_x);
        self.solver.solve(out);
        self.applications += 1;
    }

    fn inner(&self, x: &[f64], out: &mut [f64]) {
        out.fill(0.0);
        self.pattern.add_product(self.mass, x, out);
    }

    fn stopped(&self) -> bool {
        self.watch.interrupted()
    }
}

/// Ends the analysis if the user has asked for it.
fn go_on(watch: &dyn Observer) -> Result<()> {
    if watch.interrupted() { Err(Error::Interrupted) } else { Ok(()) }
}

/// Finds the `wanted` lowest modes.
///
/// # Errors
/// The mass is not positive definite, the iteration does not find the modes, the Sturm count disagrees, or the
/// observer has asked to stop, which is noticed between two applications of the inverse.
pub fn run(
    system: &System,
    wanted: usize,
    equilibrium: Option<&State>,
    observer: &mut dyn Observer,
) -> Result<ModalOutcome> {
    let mut newton = Newton::new(system, Some(NewtonMethod::Displacement))?;
    let zero = vec![[0.0; 3]; system.vectors()];
    let (u, time) = equilibrium.map_or((zero.as_slice(), 0.0), |s| (s.u.as_slice(), s.time));
    let parts = TangentParts {
        weights: TangentWeights { stress: 1.0, direction: 1.0, force: 1.0, rate: 0.0 },
        mass: 0.0,
        time,
    };
    let mut internal = zero.clone();
    if let Some(state) = equilibrium {
        newton.assembly.history.copy_from_slice(&state.history);
    }
    let k = state_kinematics(system, u, time);
    newton.assembly.follow(system, &k);
    newton.assembly.forces_and_tangent(system, &k, &parts, false, None, &mut internal);
    if equilibrium.is_some() {
        let mut loads = zero.clone();
        system.add_dead_loads(time, 1.0, &mut loads);
        add_follower_loads(system, &k, time, 1.0, &mut loads);
        newton.assembly.add_curvature(system, &k, &parts.weights, &loads);
    }
    let stiffness = newton.assembly.values.clone();
    let mut mass = vec![0.0; stiffness.len()];
    newton.assembly.mass_values(system, &mut mass);
    let mut values = vec![0.0; stiffness.len()];
    let mut shifted = |solver: &mut SparseCholesky, shift: f64| {
        for ((v, k), m) in values.iter_mut().zip(&stiffness).zip(&mass) {
            *v = k - shift * m;
        }
        solver.factor(&values)
    };

    let pattern = system.tangent_pattern();
    let wanted = wanted.min(system.unknowns());
    let extra = (wanted + 4).min(system.unknowns());
    let mut shift = first_shift(&pattern, &stiffness, &mass)?;
    let mut attempts = 0;
    go_on(observer)?;
    while !shifted(&mut newton.solver, shift).is_ok_and(|i| i.negative == 0) {
        go_on(observer)?;
        shift *= 100.0;
        attempts += 1;
        if attempts > 12 {
            return Err(Error::Singular {
                what: "The stiffness has no positive definite shift: a mass or a section stiffness is not positive."
                    .into(),
                help: "Check densities, thicknesses and materials; about an equilibrium check that it is stable.".into(),
            });
        }
    }
    // A few blocks show where the wanted modes lie; a shift of that size converges fast and stays well conditioned.
    let block = wanted.clamp(2, 8);
    let mut applications;
    {
        let mut operator = ShiftInvert::new(&mut newton.solver, (&pattern, &mass), &*observer);
        let mut lanczos = BlockLanczos::new(&mut operator, block);
        while lanczos.len() < (2 * wanted + 8).min(system.unknowns()) && lanczos.expand(&mut operator) > 0 {}
        go_on(observer)?;
        let estimate = lanczos.ritz_values().get(wanted - 1).map_or(0.0, |v| shift + 1.0 / v.0);
        applications = operator.applications;
        if estimate > 0.0 {
            shift = -0.05 * estimate;
        }
    }
    if !shifted(&mut newton.solver, shift).is_ok_and(|i| i.negative == 0) {
        return Err(Error::Singular {
            what: "The stiffness is not positive definite: the configuration is unstable.".into(),
            help: "Modes about an unstable equilibrium are not computed; check loads and supports.".into(),
        });
    }

    let mut lanczos;
    let mut sturm_rounds = 0;
    {
        let mut operator = ShiftInvert::new(&mut newton.solver, (&pattern, &mass), &*observer);
        lanczos = BlockLanczos::new(&mut operator, block);
        applications += operator.applications;
    }
    go_on(observer)?;
    let limit = (BASIS_PER_MODE * extra + 200).min(system.unknowns());
    let (pairs, sturm_checked) = loop {
        loop {
            let mut operator = ShiftInvert::new(&mut newton.solver, (&pattern, &mass), &*observer);
            let added = lanczos.expand(&mut operator);
            applications += operator.applications;
            go_on(observer)?;
            let values = lanczos.ritz_values();
            let found = values.iter().take(extra).filter(|v| v.1 <= TOLERANCE).count();
            observer.on_iteration(lanczos.len() as u32, values.get(wanted - 1).map_or(1.0, |v| v.1), 0.0);
            if found >= extra.min(values.len()) && values.len() >= extra || added == 0 {
                break;
            }
            if lanczos.len() >= limit {
                return Err(Error::NotConverged {
                    at: format!("mode {} of {wanted}", found + 1),
                    reason: format!("{found} modes found in a space of {} vectors", lanczos.len()),
                    help: "Ask for fewer modes, or check that all parts of the model are connected.".into(),
                });
            }
        }
        let pairs = lanczos.ritz_pairs(extra);
        let eigenvalues: Vec<f64> = pairs.iter().map(|p| shift + 1.0 / p.value).collect();
        // Count below a point in a gap behind the last wanted mode.
        let gap = (wanted..eigenvalues.len())
            .find(|&i| eigenvalues[i] - eigenvalues[i - 1] > 1e-4 * eigenvalues[i].abs());
        let Some(gap) = gap else { break (pairs, extra == system.unknowns()) };
        let point = 0.5 * (eigenvalues[gap] + eigenvalues[gap - 1]);
        go_on(observer)?;
        let below = shifted(&mut newton.solver, point).map_or(usize::MAX, |i| i.negative);
        if below == gap {
            break (pairs, true);
        }
        sturm_rounds += 1;
        if below < gap || below == usize::MAX || sturm_rounds > 4 {
            return Err(Error::NotConverged {
                at: format!("mode {wanted}"),
                reason: format!("{gap} modes were found below ω² = {point:.6e}, but the matrix has {below}"),
                help: "Ask for a few modes more or less, so that the last one lies in a clear gap.".into(),
            });
        }
        observer.on_event(&format!(
            "{} mode(s) were missed below ω² = {point:.6e}; searching again",
            below - gap
        ));
        if !shifted(&mut newton.solver, shift).is_ok_and(|i| i.negative == 0) {
            return Err(Error::Outside("the shifted matrix changed between two factorisations".into()));
        }
        let mut operator = ShiftInvert::new(&mut newton.solver, (&pattern, &mass), &*observer);
        lanczos.add_random(&mut operator);
        applications += operator.applications;
        go_on(observer)?;
    };

    let stress_free = equilibrium.is_none() && energy_is_quadratic(system);
    let rigid_motions = RigidMotions::new(system, u);
    let mut modes: Vec<Mode> = pairs
        .into_iter()
        .map(|p| {
            let mut shape = vec![[0.0; 3]; system.vectors()];
            newton.assembly.numbering.expand(&p.vector, &mut shape);
            // About the stress-free reference the strain energy gives the quotient without cancellation.
            let lambda = if stress_free {
                newton.assembly.small_strain_energy(system, &shape) / system.kinetic_energy(&shape)
            } else {
                shift + 1.0 / p.value
            };
            let rigid = rigid_motions.contain(system, &shape);
            let omega = if rigid { 0.0 } else { lambda.signum() * lambda.abs().sqrt() };
            Mode { frequency_hz: omega / std::f64::consts::TAU, omega, rigid, shape, residual: p.residual }
        })
        .collect();
    modes.sort_by(|a, b| a.omega.total_cmp(&b.omega));
    modes.truncate(wanted);
    let statistics = Statistics {
        steps: modes.len() as u64,
        iterations: applications,
        factorizations: newton.solver.factorizations() as u64,
        ..Statistics::default()
    };
    Ok(ModalOutcome { modes, statistics, sturm_checked })
}

/// True if the strain energy of a small motion about the reference configuration is that of any multiple of it, times
/// the square: all materials are linear, and no prescribed strain stresses the reference.
fn energy_is_quadratic(system: &System) -> bool {
    system.sections.iter().all(|s| s.section.is_linear())
        && system.prescribed_strains.iter().all(|p| system.amplitude(p.amplitude, 0.0) == 0.0)
}

/// A shift far below the lowest elastic eigenvalue that still makes the matrix positive definite.
fn first_shift(pattern: &SymmetricPattern, stiffness: &[f64], mass: &[f64]) -> Result<f64> {
    let lowest = pattern
        .diagonal(stiffness)
        .zip(pattern.diagonal(mass))
        .filter(|(_, m)| *m > 0.0)
        .map(|(k, m)| k / m)
        .fold(f64::INFINITY, f64::min);
    if lowest.is_finite() && lowest > 0.0 {
        Ok(-1e-10 * lowest)
    } else {
        Err(Error::Singular {
            what: "The model has no mass or no stiffness.".into(),
            help: "Give every material a density and every section a thickness.".into(),
        })
    }
}

/// The six rigid motions of a configuration, for telling rigid modes from elastic ones.
struct RigidMotions {
    fields: Vec<Vec<Nodal>>,
    gram: SMatrix<f64, 6, 6>,
}

impl RigidMotions {
    fn new(system: &System, u: &[Nodal]) -> Self {
        let current = |v: usize| Vec3::from(system.reference[v]) + Vec3::from(u[v]);
        let axes = [Vec3::x(), Vec3::y(), Vec3::z()];
        let mut fields = Vec::new();
        for a in axes {
            fields.push(
                (0..system.vectors())
                    .map(|v| if system.kinds[v] == VectorKind::Position { a.into() } else { [0.0; 3] })
                    .collect::<Vec<Nodal>>(),
            );
        }
        for a in axes {
            fields.push((0..system.vectors()).map(|v| a.cross(&current(v)).into()).collect());
        }
        let products: Vec<Vec<Nodal>> = fields.iter().map(|f| mass_product(system, f)).collect();
        let gram = SMatrix::from_fn(|i, j| crate::system::dot(&fields[i], &products[j]));
        Self { fields, gram }
    }

    /// True if a shape is a combination of the motions (to 1e-3 in the mass norm).
    fn contain(&self, system: &System, shape: &[Nodal]) -> bool {
        let m_shape = mass_product(system, shape);
        let right = SVector::<f64, 6>::from_fn(|i, _| crate::system::dot(&self.fields[i], &m_shape));
        let Some(c) = self.gram.cholesky().map(|g| g.solve(&right)) else { return false };
        let total = crate::system::dot(shape, &m_shape);
        total - c.dot(&right) <= 1e-6 * total
    }
}

fn mass_product(system: &System, field: &[Nodal]) -> Vec<Nodal> {
    let mut out = vec![[0.0; 3]; field.len()];
    system.pattern.add_mass_product(1.0, field, &mut out);
    out
}
