//! Lower bound of the critical time step `2/ω` of central differences, with the highest circular frequency ω.

use crate::analysis::State;
use crate::element::TangentWeights;
use crate::norm::larger;
use crate::system::assembly::TangentCoefficients;
use crate::system::connection_frequency::{Connections, is_connection};
use crate::system::element_frequency::{MassShares, of_followers, of_part};
use crate::system::{Assembly, System};

/// Estimator of the critical time step from below.
pub struct CriticalStep {
    shares: MassShares,
    connections: Connections,
    /// Retardation time of the strain-rate damping (time).
    retardation: f64,
    /// Largest damping over mass of springs and bushings at the last state \[1/time\].
    pub damping: f64,
}

impl CriticalStep {
    /// Estimator for a system with the lumped masses `mass`.
    pub fn new(system: &System, mass: &[f64]) -> Self {
        let retardation = system.groups.iter().map(|g| g.retardation_time()).fold(0.0, larger);
        let shares = MassShares::new(system);
        Self { connections: Connections::new(system, &shares, mass), shares, retardation, damping: 0.0 }
    }

    /// Lower bound of the critical time step at a state with the lumped masses `mass` (time).
    ///
    /// ω is that of the element with the highest frequency, see [`crate::system::element_frequency`]. Strain-rate
    /// damping with the velocity of the last half step lowers the bound to `2/ω (√(1 + ξ²) − ξ)`, `ξ = τ ω/2`; dampers with the
    /// largest damping over mass γ do so with `ξ = γ/(2 ω)`. Joints do not raise the highest frequency: they are constraints.
    pub fn below(&mut self, system: &System, assembly: &mut Assembly, mass: &[f64], state: &State) -> f64 {
        let weights = TangentWeights::STATIC;
        let parts = TangentCoefficients { weights, mass: 0.0, time: state.time };
        let mut highest = 0.0_f64;
        let k = state.point(system);
        assembly.for_each_element(system, &k, &parts, |part| {
            if !is_connection(part.group) {
                highest = larger(highest, of_part(system, &self.shares, mass, part));
            }
        });
        let loads = of_followers(system, &self.shares, mass, &state.u, state.time);
        let bounds = self.connections.bounds(system, (&self.shares, mass), (&k, &state.u));
        self.damping = bounds.damping;
        let omega = (larger(highest, bounds.stiffness) + loads).sqrt();
        if omega == 0.0 {
            return 2.0 / bounds.damping;
        }
        let xi = 0.5 * larger(self.retardation * omega, bounds.damping / omega);
        2.0 / omega / ((1.0 + xi * xi).sqrt() + xi)
    }
}
