//! Modes under circulatory follower loads, which have no potential: whether these loads change them.
//!
//! The tangent of such loads is K + N with a skew N, and vibrations about the equilibrium satisfy
//! `(K + N) φ = λ M φ`. Modes of K alone change by N in the second order,
//!
//! ```text
//! δλᵢ = Σⱼ Nᵢⱼ² / (λⱼ − λᵢ),   Nᵢⱼ = φᵢ·N φⱼ = −Nⱼᵢ
//! ```
//!
//! and pairs of nearly equal λ in the first one, where they may become complex: vibrations that grow (flutter; H. Ziegler,
//! *Principles of structural stability*, 1968). Where the change is small the modes of K are those of the model; else the
//! [complex](super::complex_modes) ones are found.

use super::problem::Problem;
use super::{Mode, dot};
use crate::analysis::State;
use crate::analysis::potential::{Place, have_potential};
use crate::element::{Motion, TangentWeights};
use crate::load::WrongStiffness;
use crate::system::assembly::TangentCoefficients;
use crate::system::{CirculatoryStiffness, System};
use crate::{Error, Result};
use nalgebra::DMatrix;
use tegula_sparse::Factor as _;
use tegula_sparse::norm::larger;

/// Change of an eigenvalue λ = ω² by N, over λ, up to which N is neglected: that of a frequency is half of it.
const NEGLIGIBLE: f64 = 2e-3;
/// Imaginary part of an eigenvalue over λ from which on N is not neglected, since the vibration grows: the growth rate over the frequency is half of it.
const GROWING: f64 = 1e-8;

/// Circulatory stiffness of the follower loads at an equilibrium; `None` where they have a potential.
pub(super) fn stiffness(system: &System, equilibrium: &State) -> Option<CirculatoryStiffness> {
    let mut skew = CirculatoryStiffness::new(system);
    let parts = TangentCoefficients { weights: TangentWeights::STATIC, mass: 0.0, time: equilibrium.time };
    skew.take(system, &Motion::State { u: &equilibrium.u, velocity: None }, &parts);
    let frames = crate::analysis::equilibrium::frames(system, equilibrium);
    let place = Place { u: &equilibrium.u, time: equilibrium.time, frames: &frames };
    (!have_potential(system, &place, skew.clone(), &[])).then_some(skew)
}

/// Refuses loads of a caller whose stiffness is not known: their forces depend on the positions of other nodes than their own, or the blocks that they
/// give are not the derivatives of their forces. Modes would have a wrong stiffness.
///
/// # Errors
/// There is such a load.
pub(super) fn refuse_loads_of_unknown_stiffness(system: &System, equilibrium: &State) -> Result<()> {
    let motion = Motion::State { u: &equilibrium.u, velocity: None };
    for (load, _, number) in system.field_loads() {
        let name = &system.load_sets[system.load_of_follower[number]].name;
        let now = || system.motion_of_load(&motion, load);
        if load.couples_nodes(equilibrium.time, now(), system.length) {
            return Err(Error::Singular {
                what: format!(
                    "The forces of the load \"{name}\" depend on the motion of other nodes than those on which they act: this part of their stiffness is not known."
                ),
                help: "Use springs or bushings of the model between the nodes, or run a transient analysis about the equilibrium.".into(),
            });
        }
        match load.wrong_stiffness(equilibrium.time, now(), system.length) {
            None => {}
            Some(WrongStiffness::OfFunction) => {
                return Err(Error::Singular {
                    what: format!(
                        "The stiffness that the load \"{name}\" gives is not the derivative of its forces by the positions, with the other sign."
                    ),
                    help: "Correct the function of the stiffness, or leave it out: differences of the forces take its place.".into(),
                });
            }
            Some(WrongStiffness::OfDifferences) => {
                return Err(Error::Singular {
                    what: format!(
                        "The stiffness of the load \"{name}\" is not known: differences of its forces over small and large increments of the positions do not agree."
                    ),
                    help: "Compute the forces in double precision, or give a function of their stiffness."
                        .into(),
                });
            }
        }
    }
    Ok(())
}

/// Refusal of circulatory follower loads where the response to inputs is wanted.
pub(super) fn with_inputs() -> Error {
    Error::Singular {
        what: "The follower loads have no potential; the response to inputs about such an equilibrium is not computed.".into(),
        help: "Use loads of constant direction for the equilibrium, or run a transient analysis.".into(),
    }
}

/// Whether the circulatory stiffness would change the frequency of an elastic one of the first `wanted` modes by more than 0.1 %, or let a vibration grow.
///
/// # Errors
/// The shifted stiffness cannot be factored.
pub(super) fn matters(
    problem: &mut Problem,
    skew: &CirculatoryStiffness,
    modes: &[Mode],
    wanted: usize,
) -> Result<bool> {
    let elastic: Vec<&Mode> = modes.iter().filter(|m| !m.rigid).collect();
    let judged = modes.iter().take(wanted).filter(|m| !m.rigid).count();
    if judged == 0 {
        return Ok(false);
    }
    if !problem.factor_shifted() {
        return Err(Error::Outside("the shifted matrix changed between two factorisations".into()));
    }
    let size = problem.pattern.size();
    let frames = &problem.newton.assembly.frames;
    let reduced: Vec<Vec<f64>> = elastic
        .iter()
        .map(|mode| {
            let mut x = vec![0.0; size];
            frames.components(&mode.shape, &mut x);
            x
        })
        .collect();
    let products: Vec<Vec<f64>> = reduced
        .iter()
        .map(|x| {
            let mut out = vec![0.0; size];
            skew.product(frames, x, &mut out);
            out
        })
        .collect();
    let lambdas: Vec<f64> = elastic.iter().map(|m| m.omega * m.omega.abs()).collect();
    // Coupling to all modes, including those that were not asked for: Nφ·(K − σM)⁻¹ Nφ = Σ N²/(λ − σ).
    let mut changes: Vec<f64> = products
        .iter()
        .zip(&lambdas)
        .take(judged)
        .map(|(product, lambda)| {
            let mut response = product.clone();
            problem.newton.solver.solve(&mut response);
            problem.constrain(&mut response);
            (dot(product, &response) / lambda).abs()
        })
        .collect();
    // Coupling among the computed modes, whatever their distance.
    let coupled = DMatrix::from_fn(elastic.len(), elastic.len(), |i, j| {
        dot(&reduced[i], &products[j]) + if i == j { lambdas[i] } else { 0.0 }
    });
    let found = tegula_sparse::eigenvalues(&coupled).unwrap_or_default();
    for (change, lambda) in changes.iter_mut().zip(&lambdas) {
        let nearest = found.iter().map(|z| (z.re - lambda).hypot(z.im)).reduce(f64::min);
        *change = larger(*change, nearest.unwrap_or(f64::NAN) / lambda.abs());
    }
    let largest = changes.iter().copied().reduce(larger).unwrap_or(f64::NAN);
    let grows = found.iter().any(|z| z.im.abs() > GROWING * z.re.abs());
    Ok(grows || !(largest <= NEGLIGIBLE))
}
