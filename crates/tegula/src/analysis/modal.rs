//! Natural frequencies and mode shapes: `K φ = ω² M φ` about the reference configuration or an equilibrium.
//!
//! Rigid modes are known beforehand, from geometry and supports. The lowest elastic modes are found orthogonal to them
//! by block Lanczos with shift-and-invert. The shift is below zero, so that the matrix to factor is positive definite
//! also for free bodies; where nearly all modes of a small model are requested, a dense solver finds all at once. A
//! Sturm sequence count (negative pivots of `K − sM` with `s` in a gap between modes) proves that none was missed.
//!
//! **Joints.** Modes satisfy `K φ + Gᵀ μ = ω² M φ` and `G φ = 0` with the gradients G of the constraints and the geometric
//! stiffness of their multipliers in K. With `A = K − σM` the inverse is `A⁻¹ − A⁻¹Gᵀ (G A⁻¹ Gᵀ)⁻¹ G A⁻¹`. Mechanisms are found
//! among the modes: they have the frequency 0 within round-off.

mod circulatory;
mod complex_modes;
mod convergence;
mod dense;
mod frequency_response;
mod growing;
mod isotropy;
mod problem;
mod reduced_model;
mod rigid;
mod search;
mod spinning;
mod strain_energy;

use super::statics::{self, StaticOutcome};
use super::{Observer, State, Statistics, equilibrium};
use crate::element::Nodal;
use crate::model::{ModalAnalysis, StaticAnalysis};
use crate::system::System;
use crate::{Error, Result};
pub use complex_modes::ComplexPart;
use complex_modes::SkewParts;
pub(super) use convergence::{Target, ritz_pairs};
pub(super) use growing::{GrowingMotion, KnownModes, growing_motion};
use problem::Problem;
pub(super) use problem::{go_on, has_springs, is_preloaded};
pub use reduced_model::ReducedModel;
use reduced_model::Reduction;
use rigid::RigidModes;
use search::Search;
use spinning::Spin;
use tegula_sparse::Factor as _;
use tegula_sparse::lanczos::RitzPair;

/// Number of rounds in which missed modes are searched for.
const ROUNDS: usize = 5;
/// Further modes that are found under loads without potential, to judge their coupling with the wanted ones.
const COUPLED: usize = 4;
/// Places in a gap, as fractions of its width, where eigenvalues are counted until a factorisation succeeds.
const PLACES: [f64; 4] = [0.5, 0.35, 0.65, 0.2];
/// Residual of a mode above which it is no solution. The iteration ends at 1e-8.
const LARGEST_RESIDUAL: f64 = 1e-6;
/// Shift below zero over the softening by centrifugal forces.
const SOFTENING: f64 = 1.05;
/// Difference δ of a mode's strain energy from the eigenvalue λ of the assembled stiffness, over λ, up to which the mode counts as resolved.
const HIDDEN: f64 = 1e-2;
/// Largest such difference of a mode apart from all others. Round-off δ of the stiffness mixes modes at the distance d by δ/d, which changes the
/// Rayleigh quotient of the strain energy by δ²/d only: it is right as long as this is a small part of λ.
const APART: [f64; 2] = [0.3, 1e-6];

/// Unbalanced force over the forces above which a state is no equilibrium about which a model vibrates.
const UNBALANCED: f64 = 1e-4;

/// Rayleigh quotient over that of the material stiffness up to which stresses cancel this stiffness: the mode is that of a critical point.
const NEUTRAL: f64 = 1e-7;

/// A vibration mode.
#[derive(Debug, Clone, PartialEq)]
pub struct Mode {
    /// Frequency f = ω/2π [1/time]; 0 for rigid modes.
    pub frequency_hz: f64,
    /// Circular frequency ω [rad/time]; 0 for rigid modes, negative: −√−λ of an unstable equilibrium.
    pub omega: f64,
    /// Whether the mode is a motion without strain: of a part of the model as a whole, or of a mechanism.
    pub rigid: bool,
    /// Shape in all nodal vectors, of modal mass 1.
    pub shape: Vec<Nodal>,
    /// Norm of the residual of the shift-inverted problem over its eigenvalue; of `Kφ − λMφ` over its terms where the
    /// dense solver found all modes. Of a rigid mode: ω² by its strain energy over that of the softest degree of
    /// freedom.
    pub residual: f64,
    /// Of a model that turns, or whose follower loads have no potential: the rest of its complex mode, whose real part is the shape; `None` for
    /// others.
    pub complex: Option<ComplexPart>,
}

/// Modes in ascending order.
#[derive(Debug, Clone, PartialEq)]
pub struct ModalOutcome {
    /// The modes.
    pub modes: Vec<Mode>,
    /// Run counters; iterations are applications of the inverse.
    pub statistics: Statistics,
    /// Whether the Sturm sequence count was made and agreed: no mode below those found is missing.
    pub sturm_checked: bool,
}

/// Response of a model to small motions under its inputs.
#[derive(Debug, Clone, PartialEq)]
pub struct Response {
    /// The model reduced to its modes and residual vectors.
    pub reduced: ReducedModel,
    /// Frequencies of the steady-state response, ascending [1/time]; empty where it is not wanted.
    pub frequencies: Vec<f64>,
}

/// Finds the `wanted` lowest modes.
///
/// # Errors
/// The mass is not positive definite, the iteration does not find the modes, the Sturm sequence count disagrees,
/// round-off hides a mode, or the observer has asked to stop, which is noticed between two applications of the inverse.
pub fn run(
    system: &System,
    wanted: usize,
    equilibrium: Option<&State>,
    observer: &mut dyn Observer,
) -> Result<ModalOutcome> {
    let mut problem = Problem::new(system, equilibrium)?;
    Ok(modes_about(&mut problem, wanted, equilibrium, observer)?.0)
}

/// Finds the modes of an analysis and the response to its inputs; `None` where it has none.
///
/// # Errors
/// As for [`run`]; or the equilibrium is unstable, the range of frequencies ends above the modes, the response has no bound.
pub fn run_with_inputs(
    system: &System,
    analysis: &ModalAnalysis,
    equilibrium: Option<&State>,
    observer: &mut dyn Observer,
) -> Result<(ModalOutcome, Option<Response>)> {
    let mut problem = Problem::new(system, equilibrium)?;
    let (mut outcome, all) = modes_about(&mut problem, analysis.modes as usize, equilibrium, observer)?;
    if analysis.inputs.is_empty() {
        return Ok((outcome, None));
    }
    if outcome.modes.iter().any(|mode| mode.complex.as_ref().is_some_and(|part| part.speed != 0.0)) {
        return Err(Error::model(
            "analysis.inputs",
            "the response of a model that turns is not computed",
            "leave the inputs or the centrifugal load out",
        ));
    }
    if outcome.modes.iter().any(|mode| mode.complex.is_some()) {
        return Err(circulatory::with_inputs());
    }
    if outcome.modes.len() < problem.rigid.len() {
        return Err(Error::Singular {
            what: format!(
                "The model has {} rigid modes, and {} modes are wanted: the response to inputs would lack rigid motions.",
                problem.rigid.len(),
                outcome.modes.len()
            ),
            help: "Raise `modes`.".into(),
        });
    }
    let before = problem.applications;
    let mut reduction = Reduction::new(&mut problem, analysis, &outcome.modes)?;
    let mut frequencies = Vec::new();
    if let Some(wanted) = &analysis.frequency_response {
        let reduced = reduction.reduced();
        frequencies = frequency_response::frequencies(wanted, &reduced, (&outcome.modes, all))?;
        frequency_response::refine(&mut reduction, &frequencies, observer)?;
    } else if let Some(frequency) = frequency_response::nearly_static(&outcome.modes) {
        frequency_response::refine(&mut reduction, &[frequency], observer)?;
    }
    let reduced = reduction.finish();
    outcome.statistics.iterations += problem.applications - before;
    outcome.statistics.factorizations = problem.newton.solver.factorizations() as u64;
    Ok((outcome, Some(Response { reduced, frequencies })))
}

/// The `wanted` lowest modes, complex ones of a model that turns or whose follower loads have no potential, and whether these are all.
fn modes_about(
    problem: &mut Problem,
    wanted: usize,
    equilibrium: Option<&State>,
    observer: &mut dyn Observer,
) -> Result<(ModalOutcome, bool)> {
    let system = problem.system;
    let Some(state) = equilibrium else {
        let (outcome, all) = lowest_modes(problem, (wanted, 0), observer)?;
        let unstable = outcome.modes.iter().filter(|mode| mode.omega < 0.0).count();
        if unstable > 0 {
            observer.on_warning(&format!(
                "the reference configuration is unstable: {unstable} of the modes found do not vibrate but grow, with negative frequencies −√−ω²/2π; \
                 `prestressed = true`, or a static step before, finds an equilibrium"
            ));
        }
        return Ok((outcome, all));
    };
    let at_rest = State { v: Vec::new(), a: Vec::new(), ..state.clone() };
    if let Some(imbalance) =
        equilibrium::imbalance(system, &mut problem.newton.assembly, &at_rest, (UNBALANCED, 0.0))
    {
        observer.on_warning(&format!(
            "the modes are those about no equilibrium: loads, inner forces and supports of this step leave {imbalance:.1e} of the forces unbalanced; \
             let a static step before it have the same loads and supports"
        ));
    }
    circulatory::refuse_loads_of_unknown_stiffness(system, state)?;
    let circulatory = circulatory::stiffness(system, state);
    if let Some(spin) = Spin::of(system, state.time).filter(|spin| spin.omega != 0.0) {
        let parts = SkewParts { spin: Some(spin), circulatory };
        return Ok((complex_modes::modes(problem, (wanted, 0, &parts), None, observer)?, false));
    }
    // Modes just above the wanted ones couple with them most.
    let coupled = if circulatory.is_some() { COUPLED } else { 0 };
    let (mut outcome, all) = lowest_modes(problem, (wanted, coupled), observer)?;
    if let Some(stiffness) = circulatory
        && circulatory::matters(problem, &stiffness, &outcome.modes, wanted)?
    {
        let parts = SkewParts { spin: None, circulatory: Some(stiffness) };
        let known = Some(std::mem::take(&mut outcome.modes));
        let mut outcome = complex_modes::modes(problem, (wanted, coupled, &parts), known, observer)?;
        outcome.modes.truncate(wanted);
        return Ok((outcome, false));
    }
    outcome.modes.truncate(wanted);
    outcome.statistics.steps = outcome.modes.len() as u64;
    Ok((outcome, all))
}

/// The `wanted` lowest modes and some `more`, without skew matrices, and whether the wanted ones are all.
fn lowest_modes(
    problem: &mut Problem,
    (wanted, more): (usize, usize),
    observer: &mut dyn Observer,
) -> Result<(ModalOutcome, bool)> {
    let system = problem.system;
    problem.first_shift(&*observer)?;
    let groups = 0..problem.groups.len();
    let all = problem.number_of_modes();
    if all == 0 {
        observer.on_warning("supports and joints hold the whole model: it has no modes");
    } else if wanted > all {
        observer.on_event(&format!(
            "{wanted} modes are wanted, but supports and joints leave the model {all} only"
        ));
    }
    let redundant = problem.newton.constraints.iter().flat_map(|constraints| constraints.redundant(system));
    redundant.for_each(|message| observer.on_warning(&message));
    if !problem.balanced {
        observer.on_warning(
            "springs, torsion springs or bushings have forces in the reference configuration that joints and supports do not balance: the modes \
             are those of the stiffness there, about no equilibrium; `prestressed = true` finds one first",
        );
    }
    let wanted = wanted.min(all);
    let found = (wanted + more).min(all);
    let elastic = found.saturating_sub(problem.rigid.len());
    let mut searches: Vec<Search> = groups.map(|group| Search::new(problem, group, elastic)).collect();
    for search in &mut searches {
        search.estimate(problem, &*observer)?;
    }
    settle(problem)?;
    let mut modes = rigid_modes(problem, found)?;
    let sturm_checked = find(problem, &mut searches, observer)?;
    for search in searches {
        for (value, pair) in search.finish() {
            modes.push(mode(problem, value, pair, &mut *observer)?);
        }
    }
    modes.sort_by(|a, b| a.omega.total_cmp(&b.omega));
    modes.truncate(found);
    let statistics = Statistics {
        steps: modes.len() as u64,
        iterations: problem.applications,
        factorizations: problem.newton.solver.factorizations() as u64,
        ..Statistics::default()
    };
    Ok((ModalOutcome { modes, statistics, sturm_checked }, wanted == all))
}

/// Equilibrium under the loads, about which a prestressed model vibrates.
///
/// # Errors
/// No equilibrium was found; where parts of the model move freely, the error says so.
pub fn prestress(system: &System, observer: &mut dyn Observer) -> Result<StaticOutcome> {
    // Above a critical speed, Coriolis forces may hold what centrifugal forces alone would tear away.
    let options =
        StaticAnalysis { allow_unstable: !system.centrifugal.is_empty(), ..StaticAnalysis::default() };
    statics::run(system, &options, None, observer).map_err(|error| {
        let rigid = rigid_motions(system);
        match error {
            Error::NotConverged { at, .. } if rigid > 0 => Error::Singular {
                what: format!(
                    "The model moves freely in {rigid} way(s), which its supports do not prevent, and no equilibrium was \
                     found at {at} under its loads and prescribed strains."
                ),
                help: "Support the model so that it cannot move as a whole, or leave `prestressed` out.".into(),
            },
            error => error,
        }
    })
}

/// Number of rigid motions of all parts of a model at the reference configuration that neither supports nor springs to the ground
/// prevent; parts with joints do not count.
pub fn rigid_motions(system: &System) -> usize {
    RigidModes::count(system)
}

/// Factors with the shifts of all groups. Shifts whose matrix is not positive definite are moved further below zero: where no stress can make the
/// configuration unstable they are lost in round-off, else they are above the lowest eigenvalue.
fn settle(problem: &mut Problem) -> Result<()> {
    let softening = SOFTENING * problem.softening;
    problem.groups.iter_mut().for_each(|g| g.shift = g.shift.min(-softening));
    for _ in 0..ROUNDS {
        if problem.factor_shifted() {
            return Ok(());
        }
        problem.groups.iter_mut().for_each(|g| g.shift *= 10.0);
    }
    Err(if problem.stress_free {
        hidden("the stiffness is not positive definite".into())
    } else {
        Error::Singular {
            what: "The stiffness is not positive definite with any shift tried: the configuration is far from stable.".into(),
            help: "Check loads and supports; with more `modes` the shifts reach further.".into(),
        }
    })
}

/// Whether the assembled stiffness, whose eigenvalue is λ, resolves a mode that has the Rayleigh quotient `exact` of its strain energy.
fn is_resolved(exact: f64, lambda: f64, distance: f64) -> bool {
    let (size, error) = (exact.abs(), (exact - lambda).abs());
    error <= HIDDEN * size || (error <= APART[0] * size && error * error <= APART[1] * size * distance)
}

fn hidden(reason: String) -> Error {
    Error::NotConverged {
        at: "the modes".into(),
        reason: format!("round-off of the stiffest part of the model hides them: {reason}"),
        help:
            "The stiffnesses of connected parts differ too much. Reduce the larger one: a part a thousand times as \
               stiff as its neighbour is practically rigid."
                .into(),
    }
}

/// Finds the modes of all groups and checks them by a Sturm sequence count; true if the count was made and agreed.
fn find(problem: &mut Problem, searches: &mut [Search], observer: &mut dyn Observer) -> Result<bool> {
    for _ in 0..ROUNDS {
        for search in searches.iter_mut() {
            search.run(problem, observer)?;
        }
        go_on(&*observer)?;
        let Some((counted, found)) = count(problem, searches) else {
            observer.on_event(
                "the Sturm count could not be made: no factorisation succeeded in a gap between the modes",
            );
            return Ok(false);
        };
        if counted == found {
            return Ok(true);
        }
        if counted < found {
            return Err(miscounted(counted, found));
        }
        observer.on_event(&format!("{} mode(s) were missed; searching again", counted - found));
        if !problem.factor_shifted() {
            return Err(Error::Outside("the shifted matrix changed between two factorisations".into()));
        }
    }
    let (counted, found) = count(problem, searches).unwrap_or_default();
    Err(miscounted(counted, found))
}

/// Eigenvalues below the last gap of each group: their Sturm sequence count, and the number found.
fn count(problem: &mut Problem, searches: &[Search]) -> Option<(usize, usize)> {
    PLACES.into_iter().find_map(|part| {
        let gaps: Vec<(f64, usize)> = searches.iter().map(|s| s.gap(problem, part)).collect();
        let found = gaps.iter().map(|g| g.1).sum();
        let mut lambdas = gaps.iter().map(|g| g.0);
        let counted = problem.factor(|_| lambdas.next().unwrap_or(f64::NAN))?;
        Some((counted, found))
    })
}

fn miscounted(counted: usize, found: usize) -> Error {
    Error::NotConverged {
        at: "the Sturm count".into(),
        reason: format!("{found} modes were found below a gap in the spectrum, but the matrix has {counted}"),
        help: "Ask for a few modes more or less, so that the last one lies in a clear gap.".into(),
    }
}

/// Rigid modes, up to the number that is wanted.
///
/// # Errors
/// The strains of one of them have an energy.
fn rigid_modes(problem: &Problem, wanted: usize) -> Result<Vec<Mode>> {
    let mut modes = Vec::new();
    for index in 0..problem.rigid.len().min(wanted) {
        let shape = problem.rigid.shape(index, &problem.parts);
        // Under loads the rigid modes of parts are their translations, which strain no configuration.
        let energy = problem.material_energy(&shape);
        let group = problem.groups.iter().find(|g| g.rigid.contains(&index));
        let residual = 2.0 * energy / group.map_or(f64::NAN, |g| g.lowest);
        refuse_residual("a rigid motion of a part", residual)?;
        modes.push(Mode { frequency_hz: 0.0, omega: 0.0, rigid: true, shape, residual, complex: None });
    }
    Ok(modes)
}

/// Refuses what is no solution of the eigenvalue problem, however it was found.
///
/// # Errors
/// The residual is not small.
fn refuse_residual(mode: &str, residual: f64) -> Result<()> {
    if residual <= LARGEST_RESIDUAL {
        return Ok(());
    }
    Err(Error::NotConverged {
        at: "the modes".into(),
        reason: format!("{mode} does not satisfy the eigenvalue problem: its residual is {residual:.1e}"),
        help: "Reduce stiffnesses and masses that are more than ten decades larger than others; if there are none, change the number of modes.".into(),
    })
}

/// Elastic mode of an eigenvalue λ of the assembled stiffness, at a distance from the nearest other one.
///
/// # Errors
/// The mode has a residual, or the assembled stiffness does not resolve it.
fn mode(
    problem: &mut Problem,
    [lambda, distance]: [f64; 2],
    mut pair: RitzPair,
    observer: &mut dyn Observer,
) -> Result<Mode> {
    let system = problem.system;
    problem.constrain(&mut pair.vector);
    let mut shape = vec![[0.0; 3]; system.vectors()];
    problem.newton.assembly.frames.expand(&pair.vector, &mut shape);
    let strain_energy = problem.rayleigh_quotient(&pair.vector, &shape);
    let mut exact = strain_energy.value;
    // Joints let parts move against each other without strain.
    let free = system.may_be_loose() && exact.abs() <= strain_energy.round_off;
    if !free {
        refuse_residual(&format!("a mode of ω² = {lambda:.4e}"), pair.residual)?;
    }
    let neutral = exact.abs() <= NEUTRAL * strain_energy.material;
    if !(free || neutral || is_resolved(exact, lambda, distance)) {
        return Err(hidden(format!(
            "a mode of ω² = {exact:.4e} by its strain energy has {lambda:.4e} by the assembled stiffness"
        )));
    }
    if free && strain_energy.material > strain_energy.round_off_of_material {
        observer.on_warning(&format!(
            "a slow motion counts as free: springs or parts that resist it give ω² = {:.1e} (rad/time)², which stresses and loads cancel \
             within their round-off of {:.1e}",
            strain_energy.material, strain_energy.round_off
        ));
    }
    if free {
        exact = 0.0;
    }
    let omega = if free { 0.0 } else { exact.signum() * exact.abs().sqrt() };
    Ok(Mode {
        frequency_hz: omega / std::f64::consts::TAU,
        omega,
        rigid: free,
        shape,
        residual: pair.residual,
        complex: None,
    })
}

/// Product of two vectors of free degrees of freedom.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::is_resolved;

    #[test]
    fn round_off_hides_modes_that_are_near_to_others() {
        assert!(is_resolved(1.0, 1.009, 1e-3) && !is_resolved(1.0, 1.011, 1e-3));
        // Apart from all others by 1e6 the strain energy is right to 0.04/1e6.
        assert!(is_resolved(1.0, 1.2, 1e6) && is_resolved(-1.0, -1.2, 1e6) && !is_resolved(1.0, 1.4, 1e6));
        assert!(!is_resolved(1.0, 1.2, 1e3) && is_resolved(1.0, 1.2, f64::INFINITY));
        assert!(
            !is_resolved(1.0, f64::NAN, 1e6)
                && !is_resolved(f64::NAN, 1.0, 1e6)
                && !is_resolved(1.0, 1.2, f64::NAN)
        );
    }
}
