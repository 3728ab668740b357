//! Convergence of block Lanczos: the basis grows until the wanted Ritz pairs are found.

use super::problem::go_on;
use crate::analysis::Observer;
use crate::{Error, Result};
use tegula_sparse::lanczos::{BlockLanczos, RitzPair};

/// Residual of a Ritz pair, over its value, at which a mode counts as found. The eigenvalue's error is its square.
const TOLERANCE: f64 = 1e-8;

/// Pairs that are looked for.
pub(in crate::analysis) struct Target {
    /// Name of a pair in messages.
    pub name: &'static str,
    /// Pairs that are wanted, and those with some beyond them.
    pub wanted: [usize; 2],
    /// Dimension of the space of the modes.
    pub size: usize,
    /// Basis vectors before the iteration gives up.
    pub limit: usize,
}

/// Expands a basis until the pairs are found, or the space is exhausted; `expand` adds a block and returns the number of its vectors.
///
/// # Errors
/// The pairs are not found, or the observer has asked to stop.
pub(in crate::analysis) fn ritz_pairs(
    lanczos: &mut BlockLanczos,
    mut expand: impl FnMut(&mut BlockLanczos, &dyn Observer) -> usize,
    target: &Target,
    observer: &mut dyn Observer,
) -> Result<Vec<RitzPair>> {
    let Target { name, wanted: [wanted, extra], size, limit } = *target;
    loop {
        // Beyond the dimension of the space there is only round-off.
        let full = lanczos.len() >= size;
        let added = expand(lanczos, &*observer);
        go_on(&*observer)?;
        let values = lanczos.ritz_values();
        let found = values.iter().take(extra).filter(|v| v.1 <= TOLERANCE).count();
        let last = values.get(wanted - 1).map_or(1.0, |v| v.1);
        observer.on_iteration(lanczos.len() as u32, last, 0.0);
        observer.on_modes(found.min(wanted), wanted, lanczos.len());
        if found >= extra || added == 0 || full {
            return Ok(lanczos.ritz_pairs(extra));
        }
        if limit < size && lanczos.len() >= limit {
            return Err(Error::NotConverged {
                at: format!("{name} {} of {wanted}", found + 1),
                reason: format!("{found} {name}s found in a space of {} vectors", lanczos.len()),
                help: format!("Ask for fewer {name}s, or check that all parts of the model are connected."),
            });
        }
    }
}
