//! Kinetic energy of velocities by backward differences against that of the motion.
//!
//! The velocities of BDF2 are differences of positions: `½ (3 q₁ − 4 q₀ + q₋₁)/Δt`, for a point on a circle too large by about Δθ²/3, where
//! a step turns it by Δθ. Kinetic energy, reactions, power and work belong to them. The inertia forces have the part Δθ³/2 of the centripetal
//! force along the motion: a drive at a constant rate does work of 2π Δθ³ of the kinetic energy in each revolution against the numerical
//! damping.

use crate::analysis::State;
use crate::norm::larger;
use crate::system::System;

/// Difference of both energies over the largest one so far that is reported: at a tenth of a radian a step.
const REPORTED: f64 = 6.6e-3;

/// Number of first steps that are not judged but at the end of the run: from rest, the error is as large as the energy.
const FIRST_STEPS: u64 = 20;

/// Watches the kinetic energy of models with drives.
pub(super) struct DifferenceEnergy {
    driven: bool,
    /// Largest kinetic energy so far.
    largest: f64,
    told: bool,
}

impl DifferenceEnergy {
    pub fn new(system: &System) -> Self {
        Self { driven: system.joints.iter().any(|joint| joint.drive.is_some()), largest: 0.0, told: false }
    }

    /// Looks at the end of a step with this kinetic energy of the velocities of the scheme, and says once that the energies differ.
    pub fn look(&mut self, system: &System, state: &State, kinetic: f64, last: bool) -> Option<String> {
        if !self.driven || self.told || state.mean_rates[0].is_empty() {
            return None;
        }
        let motion = system.kinetic_energy(&state.v);
        self.largest = larger(self.largest, motion);
        let apart = (kinetic - motion).abs() / self.largest;
        self.told = apart > REPORTED && (state.step > FIRST_STEPS || last);
        self.told.then(|| {
            format!(
                "the kinetic energies of the velocities of `bdf2` and of the motion differ by {:.1} % of the largest one: the steps are \
                 long for this motion. Reactions, power and work have errors of this size or more, and drives work against the numerical \
                 damping; take shorter steps, or another scheme",
                100.0 * apart
            )
        })
    }
}
