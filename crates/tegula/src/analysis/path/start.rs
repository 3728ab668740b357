//! Start of a path: it must be an equilibrium.

use super::state::one_of_many;
use crate::Result;
use crate::analysis::mobility::{is_searched, neutral_motions};
use crate::analysis::{State, equilibrium};
use crate::element::Nodal;
use crate::model::PathAnalysis;
use crate::system::{Assembly, PathBefore, System};

/// Unbalanced force over the forces with which a path does not begin.
const UNBALANCED: f64 = 1e-5;

/// Refuses the end of a path where a mechanism may move to other equilibria freely. Before, loads may still be zero that hold the motion.
///
/// # Errors
/// There are motions that the loads neither hold nor drive.
pub fn hold_mechanisms(system: &System, state: &State) -> Result<()> {
    let finished = state.path.as_ref().is_some_and(|path| path.finished);
    let neutral = if finished && is_searched(system) { neutral_motions(system, state) } else { Vec::new() };
    if neutral.is_empty() {
        return Ok(());
    }
    Err(one_of_many(state, &neutral))
}

/// Refuses a path that does not begin in equilibrium. `scale` is that of forces times lengths to come.
pub fn in_equilibrium(
    system: &System,
    assembly: &mut Assembly,
    state: &State,
    scale: f64,
) -> std::result::Result<(), String> {
    let Some(imbalance) = equilibrium::imbalance(system, assembly, state, (UNBALANCED, scale)) else {
        return Ok(());
    };
    Err(format!(
        "its start is not in equilibrium, the residual is {imbalance:.1e} of the forces; let a static step before it find the equilibrium \
         under preloads"
    ))
}

/// Cosine of the angle between the direction of a path and that of the path before at its end, above which one continues the other.
const CONTINUES: f64 = 0.5;

/// Direction in which a path with rising loads leads away from a critical point at its start: that of the path before, which has ended there. The
/// tangent is singular; at a bifurcation it does not tell the direction, and a limit point would be found again.
pub fn away_from_critical_point<'s>(system: &'s System, options: &PathAnalysis) -> Option<&'s [Nodal]> {
    let before = &system.path_before;
    (before.at_critical_point && options.end_load > 0.0).then_some(&before.direction)
}

/// Whether a direction in which the load factor rises goes on (true) or back along the path of the step before, which has ended at a critical point or behind
/// one; `None` where it does neither, and where rising loads lead back along a path on which they rose: those of this step relieve the others.
pub fn forward(system: &System, rising: &[Nodal]) -> Option<bool> {
    let PathBefore { direction: before, rises, .. } = &system.path_before;
    if before.is_empty() {
        return None;
    }
    let product = system.inner_product(before, rising);
    let is_along = product.abs() > CONTINUES * system.norm(before) * system.norm(rising);
    (is_along && !(*rises && product < 0.0)).then_some(product > 0.0)
}
