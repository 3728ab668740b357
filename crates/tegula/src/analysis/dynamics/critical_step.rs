//! Lower bound of the critical time step `2/ω` of central differences, with the highest circular frequency ω.

use crate::analysis::State;
use crate::element::TangentWeights;
use crate::system::assembly::TangentCoefficients;
use crate::system::element_frequency::{MassShares, of_followers, of_part};
use crate::system::{Assembly, System};

/// Estimator of the critical time step from below.
pub struct CriticalStep {
    shares: MassShares,
    /// Retardation time of the strain-rate damping (time).
    retardation: f64,
}

impl CriticalStep {
    /// Estimator for a system.
    pub fn new(system: &System) -> Self {
        let retardation = system.groups.iter().map(|g| g.retardation_time()).fold(0.0, f64::max);
        Self { shares: MassShares::new(system), retardation }
    }

    /// Lower bound of the critical time step at a state with the lumped masses `mass` (time).
    ///
    /// ω is that of the element with the highest frequency, see [`crate::system::element_frequency`]. Strain-rate
    /// damping with the velocity of the last half step lowers the bound to `2/ω (√(1 + ξ²) − ξ)`, `ξ = τ ω/2`.
    pub fn below(&self, system: &System, assembly: &mut Assembly, mass: &[f64], state: &State) -> f64 {
        let weights = TangentWeights::STATIC;
        let parts = TangentCoefficients { weights, mass: 0.0, time: state.time };
        let mut highest = 0.0_f64;
        let k = state.point(system);
        assembly.for_each_element(system, &k, &parts, |part| {
            let bound = of_part(system, &self.shares, mass, part);
            highest = if bound.is_nan() { bound } else { highest.max(bound) };
        });
        let loads = of_followers(system, &self.shares, mass, &state.u, state.time);
        let omega = (highest + loads).sqrt();
        let xi = 0.5 * self.retardation * omega;
        2.0 / omega / ((1.0 + xi * xi).sqrt() + xi)
    }
}
