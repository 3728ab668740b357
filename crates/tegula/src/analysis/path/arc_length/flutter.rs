//! Flutter along a path: under loads without a potential vibrations about an equilibrium may grow although no eigenvalue of the tangent has passed through
//! zero (H. Ziegler, *Principles of structural stability*, 1968). The masses decide, and the [complex modes](crate::analysis::modal) tell.

use crate::analysis::path::state::PathState;
use crate::analysis::{Observer, State, modal};
use crate::system::System;

/// Looks at the equilibrium at the end of a step that has begun at the load factor `before`, and warns where vibrations about it grow that have not grown before.
pub(super) fn look(system: &System, before: f64, state: &mut State, observer: &mut dyn Observer) {
    let growing = modal::growing_vibration(system, state);
    let (now, Some(PathState { flutters, .. })) = (state.time, state.path.as_deref_mut()) else { return };
    let flutters = std::mem::replace(flutters, growing.is_some());
    let Some((growth, omega)) = growing.filter(|_| !flutters) else { return };
    observer.on_warning(&format!(
        "between load factors {before:.6} and {now:.6} the equilibria of the path become unstable by flutter: about the last one a vibration of the \
         circular frequency {omega:.4e} grows by e^(t/{:.3e}). Eigenvalues of the tangent do not tell it; a modal step behind a path or a static \
         step does",
        1.0 / growth
    ));
}
