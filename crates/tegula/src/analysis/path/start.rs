//! Start of a path: it must be an equilibrium.

use crate::analysis::{State, equilibrium};
use crate::norm::larger;
use crate::system::{Assembly, System, add_multiple};

/// Unbalanced force over the forces with which a path does not begin, and over the loads and the stiffness times the size of the model, below
/// which it is round-off.
const UNBALANCED: [f64; 2] = [1e-5, 1e-12];

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
    Err(format!(
        "its start is not in equilibrium, the residual is {:.1e} of the forces; let a static step before it find the equilibrium under \
         preloads",
        largest / size
    ))
}
