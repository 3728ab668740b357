//! Start of a path: it must be an equilibrium.

use super::state::one_of_many;
use crate::Result;
use crate::analysis::mobility::{is_searched, neutral_motions};
use crate::analysis::{State, equilibrium};
use crate::element::Nodal;
use crate::model::PathAnalysis;
use crate::norm::larger;
use crate::system::{Assembly, PathBefore, System, add_multiple};

/// Unbalanced force over the forces with which a path does not begin, and over the loads and the stiffness times the size of the model, below
/// which it is round-off.
const UNBALANCED: [f64; 2] = [1e-5, 1e-12];

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
    let unbalanced = equilibrium::unbalanced(system, assembly, state);
    let external = equilibrium::external(system, &state.point(system));
    let mut free = vec![0.0; system.unknowns()];
    assembly.frames.reduce(&unbalanced, &mut free);
    let mut internal = external.clone();
    add_multiple(&mut internal, -1.0, &unbalanced);
    let size = larger(system.force_norm(&external), system.force_norm(&internal));
    let mut left = unbalanced;
    assembly.frames.expand(&free, &mut left);
    let largest = system.force_norm(&left);
    if largest <= larger(UNBALANCED[0] * size, UNBALANCED[1] * scale) {
        return Ok(());
    }
    // Without stress, as where prescribed strains have bent the model freely, all forces are round-off.
    let stiffness = equilibrium::mean_stiffness(system, assembly, state).unwrap_or(0.0);
    if largest <= UNBALANCED[1] * stiffness * system.length * system.length {
        return Ok(());
    }
    Err(format!(
        "its start is not in equilibrium, the residual is {:.1e} of the forces; let a static step before it find the equilibrium under \
         preloads",
        largest / size
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
