//! Watch of the rank of the constraints: singular positions of mechanisms.
//!
//! In a singular position constraints follow from others that are independent elsewhere, as where the bars of a parallelogram lie in one
//! line. Positions can be followed through it, but the motion may continue on several branches there, and the reactions are not unique.

use crate::analysis::Observer;
use crate::analysis::constraints::Schur;
use crate::system::System;

/// Watch of the rank of the constraints.
pub(super) struct RankWatch {
    /// Largest number of dependent constraints so far; `None` before the first step of a resumed motion.
    most: Option<usize>,
}

impl RankWatch {
    /// Watch of a motion with this Schur complement at its start, `None` where that is not known.
    pub fn new(at_start: Option<&Schur>) -> Self {
        Self { most: at_start.map(Schur::dependent) }
    }

    /// Reports a position in which more constraints depend on others than in all positions before.
    pub fn look(&mut self, system: &System, schur: Option<&Schur>, time: f64, observer: &mut dyn Observer) {
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
