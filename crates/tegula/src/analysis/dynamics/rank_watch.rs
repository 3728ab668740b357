//! Watch of the rank of the constraints: singular positions of mechanisms.
//!
//! In a singular position constraints follow from others that are independent elsewhere, as where the bars of a parallelogram lie in one
//! line. Positions can be followed through it, but the motion may continue on several branches there, and the reactions are not unique.
//!
//! Constraints that act on stiff parts look dependent in the Schur complement of a tangent. The masses decide, a kinematic measure, wherever
//! more constraints look dependent than before.

use super::impact;
use crate::Result;
use crate::analysis::constraints::Schur;
use crate::analysis::newton::Newton;
use crate::analysis::{Observer, State};
use crate::system::System;

/// Watch of the rank of the constraints.
pub(super) struct RankWatch {
    /// Largest number of dependent constraints, by the masses; `None` before the first step of a resumed motion.
    most: Option<usize>,
    /// Largest number of constraints that looked dependent.
    suspected: usize,
}

impl RankWatch {
    /// Watch of a motion with this Schur complement of the masses at its start, `None` where that is not known.
    pub fn new(at_start: Option<&Schur>) -> Self {
        let most = at_start.map(Schur::dependent);
        Self { most, suspected: most.unwrap_or(0) }
    }

    /// Reports a state at the end of a step in which more constraints depend on others than in all states before.
    ///
    /// # Errors
    /// The mass matrix is singular.
    pub fn look(
        &mut self,
        system: &System,
        newton: &mut Newton,
        state: &mut State,
        observer: &mut dyn Observer,
    ) -> Result<()> {
        let Some(dependent) = newton.schur().map(Schur::dependent) else { return Ok(()) };
        if self.most.is_none() {
            (self.most, self.suspected) = (Some(dependent), dependent);
        }
        if dependent > self.suspected {
            self.suspected = dependent;
            impact::take_mass(system, newton, state)?;
            self.look_at_masses(system, newton.schur(), state.time, observer);
        }
        Ok(())
    }

    /// Reports a position with this Schur complement of the masses.
    pub fn look_at_masses(
        &mut self,
        system: &System,
        schur: Option<&Schur>,
        time: f64,
        observer: &mut dyn Observer,
    ) {
        let Some(schur) = schur else { return };
        let dependent = schur.dependent();
        let known = self.most.unwrap_or(dependent);
        self.most = Some(known.max(dependent));
        if dependent <= known {
            return;
        }
        let quoted = schur.dependent_joints(system).map(|(joint, _)| format!("\"{}\"", joint.name));
        observer.on_event(&format!(
            "time {time:.6e}: a singular position of the joints, where {dependent} constraint(s) follow from others, of {}; the motion may \
             continue on several branches, and the reactions of minimum norm are computed",
            quoted.collect::<Vec<_>>().join(", ")
        ));
    }
}
