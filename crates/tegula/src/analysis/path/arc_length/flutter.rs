//! Flutter along a path: under loads without a potential vibrations about an equilibrium may grow although no eigenvalue of the tangent has passed through
//! zero (H. Ziegler, *Principles of structural stability*, 1968). The masses decide, and the [complex modes](crate::analysis::modal) tell.

use crate::analysis::path::state::PathState;
use crate::analysis::{Observer, State, modal};
use crate::system::System;

/// Looks at the equilibrium at which a path begins.
pub(super) fn look_at_start(system: &System, state: &mut State, observer: &mut dyn Observer) {
    let Some(growing) = growing_vibration(system, state, observer) else { return };
    let Some(path) = state.path.as_deref_mut() else { return };
    path.flutters = growing.is_some();
    if let Some(vibration) = growing {
        observer.on_warning(&format!(
            "the path begins at an equilibrium that is unstable by flutter: {}",
            told(vibration)
        ));
    }
}

/// Looks at the equilibrium at the end of a step that has begun at the load factor `before`, and warns where vibrations about it grow that have not grown
/// before; where they no longer do, a message says so.
pub(super) fn look(system: &System, before: f64, state: &mut State, observer: &mut dyn Observer) {
    let Some(growing) = growing_vibration(system, state, observer) else { return };
    let (now, Some(PathState { flutters, .. })) = (state.time, state.path.as_deref_mut()) else { return };
    let between = format!("between load factors {before:.6} and {now:.6}");
    match (std::mem::replace(flutters, growing.is_some()), growing) {
        (false, Some(vibration)) => observer.on_warning(&format!(
            "{between} the equilibria of the path become unstable by flutter: {}",
            told(vibration)
        )),
        (true, None) => observer.on_event(&format!("{between} the flutter of the equilibria ends")),
        _ => {}
    }
}

/// Vibration about an equilibrium that grows, if one does; `None`, with a message, where the modes are not found.
fn growing_vibration(
    system: &System,
    state: &State,
    observer: &mut dyn Observer,
) -> Option<Option<(f64, f64)>> {
    match modal::growing_vibration(system, state) {
        Ok(found) => Some(found),
        Err(error) => {
            let now = state.time;
            observer.on_event(&format!(
                "whether the equilibrium at the load factor {now:.6} is stable against flutter is not known: {error}"
            ));
            None
        }
    }
}

fn told((growth, omega): (f64, f64)) -> String {
    format!(
        "a vibration of the circular frequency {omega:.4e} grows by e^(t/{:.3e}). Eigenvalues of the tangent do not tell it; a modal step behind a path or a \
         static step does",
        1.0 / growth
    )
}
