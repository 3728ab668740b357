//! Force laws of springs and bushings that a motion meets outside their range: places without a force, poles, falling forces.

use super::{Assembly, EvaluationPoint, System};
use crate::element::ElementGroup;

impl Assembly {
    /// Reason why a spring or bushing has no finite forces or tangent in a motion, if one of them is the cause.
    pub fn reason_without_forces(&self, system: &System, k: &EvaluationPoint) -> Option<String> {
        let factors: Vec<f64> = system.factors(k.time).collect();
        let of_group = |(g, group, _): (usize, &dyn ElementGroup, _)| {
            (0..group.len()).find_map(|e| group.reason_without_forces(&k.of_group(system, g, &factors), e))
        };
        system.numbered_groups().find_map(of_group)
    }

    /// A spring whose force does not grow with its elongation in a state, as text, if there is one.
    pub fn falling_force(&self, system: &System, k: &EvaluationPoint) -> Option<String> {
        let of_group =
            |(g, group, _): (usize, &dyn ElementGroup, _)| group.falling_force(&k.of_group(system, g, &[]));
        system.numbered_groups().find_map(of_group)
    }

    /// A pole of the force law of a spring between the ends of a motion that starts at a time, as text, if there is one.
    pub fn pole_in_step(&self, system: &System, k: &EvaluationPoint, start: f64) -> Option<String> {
        let of_group = |(g, group, _): (usize, &dyn ElementGroup, _)| {
            group.pole_in_step(&k.of_group(system, g, &[]), start)
        };
        system.numbered_groups().find_map(of_group)
    }
}
