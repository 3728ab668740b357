//! Total energy of motions by schemes that do not conserve it.
//!
//! Newmark's method, HHT and generalised-α are stable for linear models. Where stiff parts rotate fast, they may gain energy in every step
//! (J. C. Simo, N. Tarnow, ZAMP 43 (1992) 757–792), and constant steps go on with it.

use crate::analysis::{Balance, Observer};
use tegula_sparse::norm::larger;

/// Gain of energy over the largest energy that triggers the first report, and growth of it that triggers the next one.
const FIRST: f64 = 0.05;
const GROWTH: f64 = 2.0;

/// Number of first steps that are not judged: from rest, the error is as large as the energy.
const FIRST_STEPS: u64 = 20;

/// Reports that a motion gains energy, each time that the gain has grown.
pub(super) struct EnergyWatch {
    /// Lowest sum that an exact integration keeps constant, so far.
    lowest: f64,
    /// Gain that triggers the next report.
    next: f64,
}

impl EnergyWatch {
    /// Watch without any report yet.
    pub fn new() -> Self {
        Self { lowest: f64::INFINITY, next: FIRST }
    }

    /// Looks at the energies at the end of a step with this number; `scale` is the largest energy so far.
    pub fn look(
        &mut self,
        (balance, scale): (&Balance, f64),
        (step, time): (u64, f64),
        observer: &mut dyn Observer,
    ) {
        self.lowest = self.lowest.min(balance.total);
        let scale = larger(scale, larger(balance.kinetic, balance.strain));
        let gain = (balance.total - self.lowest) / scale;
        if step <= FIRST_STEPS || scale == 0.0 || gain <= self.next {
            return;
        }
        self.next = GROWTH * gain;
        observer.on_event(&format!(
            "time {time:.6e}: the motion has gained {:.0} % of its largest energy: the time steps are too long for it; take shorter or automatic \
             steps, or the scheme \"energy-momentum\"",
            100.0 * gain
        ));
    }
}
