//! Linear buckling: load factors λ at which the structure, linearised about its base state, becomes unstable.
//!
//! ```text
//! (K + λ K_σ) φ = 0
//! ```
//!
//! K is the tangent at the base state: with its stresses, the load stiffness of its follower loads and the multipliers of its joints.
//! K_σ is the geometric stiffness of the stresses that the loads of the analysis produce linearly from there; displacements
//! before buckling are neglected (O. C. Zienkiewicz, R. L. Taylor, *The Finite Element Method*, vol. 2; R. D. Cook et al., *Concepts and
//! Applications of Finite Element Analysis*, on linear buckling).
//!
//! **Spectrum.** K is positive definite, which its inertia shows; an unstable base state is refused. With the inner product of K the operator
//! `(K + σ K_σ)⁻¹ K` is symmetric and has the eigenvalues `ν = λ/(λ − σ)`: the largest ones belong to the factors next beyond the
//! shift σ (buckling transformation of R. G. Grimes, J. G. Lewis, H. D. Simon, SIAM J. Matrix Anal. Appl. 15 (1994) 228–272). Block Lanczos
//! finds them. As many factors lie between 0 and s as `K + s K_σ` has negative eigenvalues (Sylvester's law of inertia): a Sturm
//! sequence count proves that none was missed.
//!
//! **Joints.** Modes keep `G φ = 0`, as in the modal analysis.

mod increment;
mod problem;
mod search;

use super::{Observer, Statistics, mobility, modal};
use crate::element::Nodal;
use crate::model::{BucklingAnalysis, FactorSigns};
use crate::system::{Procedure, System, VectorKind};
use crate::{Error, Result};
use problem::Problem;
use search::{Found, Search};
use tegula_sparse::Factor as _;

/// Difference of the factor by the strain energy of a mode from that of the assembled matrices, over its value, above which round-off of the
/// stiffness hides the mode.
const HIDDEN: f64 = 1e-2;

/// Work of the skew stiffness of moments over that of the stiffness, in a mode, above which they count.
const SKEW: f64 = 1e-3;

/// A buckling mode.
#[derive(Debug, Clone, PartialEq)]
pub struct BucklingMode {
    /// Factor λ of the loads; negative where the loads must be reversed.
    pub factor: f64,
    /// Shape in all nodal vectors; the largest displacement is 1 (the largest change of a director where nothing is displaced).
    pub shape: Vec<Nodal>,
    /// Norm of the residual of the shift-inverted problem over its eigenvalue.
    pub residual: f64,
}

/// Factors in ascending order of their magnitude.
#[derive(Debug, Clone, PartialEq)]
pub struct BucklingOutcome {
    /// The modes.
    pub modes: Vec<BucklingMode>,
    /// Run counters; iterations are applications of the inverse.
    pub statistics: Statistics,
    /// Whether the Sturm sequence count was made and agreed: no factor below those found is missing.
    pub sturm_checked: bool,
}

/// Finds the lowest load factors about the state at which the analysis step of a system starts.
///
/// # Errors
/// The base state is unstable, or parts of the model move freely; the loads are zero, produce no stress, or stabilise the structure only;
/// follower loads have no potential; the iteration does not find the modes, the Sturm sequence count disagrees or round-off hides a
/// mode; the observer has asked to stop.
pub fn run(
    system: &System,
    options: &BucklingAnalysis,
    observer: &mut dyn Observer,
) -> Result<BucklingOutcome> {
    system.require(&[Procedure::Buckling])?;
    if system.linear {
        return Err(Error::model(
            "analysis.type",
            "the model is linear: without the terms of large displacements nothing buckles",
            "leave `linear` out of all steps",
        ));
    }
    let mut problem = Problem::new(system)?;
    stable_base(&mut problem)?;
    let redundant = problem.newton.constraints.iter().flat_map(|constraints| constraints.redundant(system));
    redundant.for_each(|message| observer.on_warning(&message));
    problem.load()?;
    let found = factors(&mut problem, options, observer)?;
    let modes: Vec<BucklingMode> =
        found.modes.into_iter().map(|mode| finish(&mut problem, mode)).collect::<Result<_>>()?;
    let statistics = Statistics {
        iterations: problem.applications,
        factorizations: problem.newton.solver.factorizations() as u64,
        ..Statistics::default()
    };
    Ok(BucklingOutcome { modes, statistics, sturm_checked: found.sturm_checked })
}

/// Factors the stiffness of the base state, which must be positive definite.
fn stable_base(problem: &mut Problem) -> Result<()> {
    let system = problem.system;
    let held = "Support the model, or let springs hold it, so that no part can move without strain.";
    let free = mobility::neutral_motions(system, &problem.state);
    if !free.is_empty() {
        return Err(Error::Singular {
            what: format!("The model is a mechanism in its base state, without load: {}.", free.join("; ")),
            help: held.into(),
        });
    }
    let rigid = modal::rigid_motions(system);
    if rigid > 0 && system.joints.is_empty() {
        return Err(Error::Singular {
            what: format!("The model moves freely in {rigid} way(s), which its supports do not prevent."),
            help: held.into(),
        });
    }
    match problem.factor(0.0) {
        Some(0) => Ok(()),
        Some(negative) => Err(Error::Singular {
            what: format!(
                "The base state is unstable: its stiffness has {negative} negative eigenvalue(s). Load factors of buckling are counted \
                 from a stable state."
            ),
            help: "Reduce the loads of the step before.".into(),
        }),
        None => Err(Error::Singular {
            what: "The stiffness of the base state is singular: parts of the model move freely, or it is at a critical point.".into(),
            help: held.into(),
        }),
    }
}

/// Modes of the wanted signs, the lowest in magnitude.
fn factors(problem: &mut Problem, options: &BucklingAnalysis, observer: &mut dyn Observer) -> Result<Found> {
    let wanted = options.factors as usize;
    let extremes = search::extremes(problem, wanted, observer)?;
    let mut find =
        |sign: f64, wanted: usize| Search::new(sign, wanted).run(problem, extremes, &mut *observer);
    let mut found = find(1.0, wanted)?;
    if options.signs == FactorSigns::Both {
        let negative = find(-1.0, wanted)?;
        found.sturm_checked &= negative.sturm_checked;
        found.modes.extend(negative.modes);
        found.modes.sort_by(|a, b| a.factor.abs().total_cmp(&b.factor.abs()));
        found.modes.truncate(wanted);
    }
    if found.modes.is_empty() {
        let reversed = if options.signs == FactorSigns::Both { None } else { find(-1.0, 1)?.modes.pop() };
        return Err(match reversed {
            Some(mode) => {
                let mode = finish(problem, mode)?;
                Error::Singular {
                    what: format!(
                        "The loads stabilise the structure: there is no positive load factor below {:.0e} times the lowest one of the \
                         reversed loads, which is {:.6e}.",
                        search::REACH,
                        -mode.factor
                    ),
                    help: "Reverse the loads, or give `signs = \"both\"`.".into(),
                }
            }
            None => search::without_stress(),
        });
    }
    if found.modes.len() < wanted {
        observer.on_warning(&format!(
            "{wanted} load factors are wanted, but the structure has only {} within {:.0e} times the lowest one",
            found.modes.len(),
            search::REACH
        ));
    }
    Ok(found)
}

/// Mode in all nodal vectors, with the factor by its strain energy where that is known without cancellation.
///
/// # Errors
/// The assembled matrices do not resolve the mode.
fn finish(problem: &mut Problem, mut mode: search::Mode) -> Result<BucklingMode> {
    let system = problem.system;
    problem.constrain(&mut mode.vector);
    let mut shape = vec![[0.0; 3]; system.vectors()];
    problem.newton.assembly.frames.expand(&mode.vector, &mut shape);
    if problem.is_without_stress(&mode.vector, &shape) {
        return Err(search::without_stress());
    }
    let mut factor = mode.factor;
    let hidden = match problem.strain_energy(&shape) {
        Some(energy) => {
            factor = -2.0 * energy / problem.stress_product(&mode.vector);
            (factor - mode.factor).abs() / factor.abs()
        }
        None => problem.round_off(&mode.vector),
    };
    if !(hidden <= HIDDEN) {
        return Err(Error::NotConverged {
            at: format!("the load factor {:.4e}", mode.factor),
            reason: "round-off of the stiffest part of the model hides it".into(),
            help: "The stiffnesses of connected parts differ too much. Reduce the larger one: a part a thousand times as stiff as its \
                   neighbour is practically rigid."
                .into(),
        });
    }
    let [base, end] = problem::TIMES;
    let skew = system.skew_work_of_moments(&problem.state.u, &shape, |load| {
        let base = system.factor(load, base);
        base + factor * (system.factor(load, end) - base)
    });
    if !(skew <= SKEW * (factor * problem.stress_product(&mode.vector)).abs()) {
        return Err(Error::Singular {
            what: format!(
                "Moments that are constant in space have no potential where bodies or nodes of beams turn about other axes than theirs, as in \
                 the mode of the load factor {factor:.4e}: load factors of buckling need not exist (flutter)."
            ),
            help: "Replace the moments by pairs of forces, or run a transient analysis.".into(),
        });
    }
    normalise(system, &mut shape);
    Ok(BucklingMode { factor, shape, residual: mode.residual })
}

/// Scales a shape to a largest displacement of 1, and [orients](System::orient) it.
fn normalise(system: &System, shape: &mut [Nodal]) {
    let size = |v: &Nodal| v.iter().map(|x| x * x).sum::<f64>().sqrt();
    let largest = |position: bool| {
        let kinds = system.coordinates.kinds.iter();
        let of_kind = kinds.zip(&*shape).filter(|(kind, _)| (**kind == VectorKind::Position) == position);
        of_kind.map(|(_, v)| v).max_by(|a, b| size(a).total_cmp(&size(b))).copied().unwrap_or([0.0; 3])
    };
    let (moved, turned) = (largest(true), largest(false));
    // Displacements that are round-off beside the rotations are none.
    let chosen = if size(&moved) > f64::EPSILON * system.length * size(&turned) { moved } else { turned };
    let scale = size(&chosen);
    if scale != 0.0 {
        shape.as_flattened_mut().iter_mut().for_each(|x| *x /= scale);
    }
    system.orient(shape);
}
