//! Values that a caller sets between the steps of an analysis.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// Value that a caller sets between the steps of an analysis, such as the output of a controller. Copies share the value.
///
/// It takes the place of an amplitude ([`System::signal`](crate::System::signal)), with the rate 0. With the energy–momentum scheme it is
/// constant within a step, and the account of energies is exact. Schemes that evaluate loads at the end of a step take the value there at the start of
/// the next one, too: a change acts half a step late, and the work is not that of the load. Prescribed motions have no velocity under it. A state does
/// not hold it; a caller that restores a state sets it again.
#[derive(Debug, Clone, Default)]
pub struct Signal(Arc<AtomicU64>);

impl Signal {
    /// Signal with a first value.
    pub fn new(value: f64) -> Self {
        Self(Arc::new(AtomicU64::new(value.to_bits())))
    }

    /// Sets the value for the steps to come.
    pub fn set(&self, value: f64) {
        self.0.store(value.to_bits(), Ordering::Relaxed);
    }

    /// Present value.
    pub fn value(&self) -> f64 {
        f64::from_bits(self.0.load(Ordering::Relaxed))
    }
}

impl PartialEq for Signal {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}
