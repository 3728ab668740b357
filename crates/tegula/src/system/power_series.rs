//! Power series of the internal forces of a model along an equilibrium path.

use super::{Assembly, EvaluationPoint, System};
use crate::element::Nodal;
use crate::element::power_series::{KnownOrders, PowerSeries};

/// Generalised stresses of the lower orders of a series, group by group.
#[derive(Debug, Default)]
pub struct SeriesStresses {
    of_groups: Vec<Vec<f64>>,
}

impl SeriesStresses {
    /// Room for a series up to order `highest`; `None` where a group has no power series.
    pub fn new(system: &System, highest: usize) -> Option<Self> {
        let room = |series: &dyn PowerSeries| vec![0.0; series.stored_stresses(highest)];
        let of_groups = system
            .groups
            .iter()
            .map(|group| if group.is_empty() { Some(Vec::new()) } else { group.power_series().map(room) });
        Some(Self { of_groups: of_groups.collect::<Option<_>>()? })
    }
}

impl Assembly {
    /// Internal forces of the next order of a series; those of lower orders come first, from 2 on.
    pub fn forces_of_order(
        &mut self,
        system: &System,
        known: &KnownOrders,
        stresses: &mut SeriesStresses,
        out: &mut [Nodal],
    ) {
        for ((_, group, offsets), stresses) in system.numbered_groups().zip(&mut stresses.of_groups) {
            if let Some(series) = group.power_series().filter(|_| !group.is_empty()) {
                series.forces_of_order(known, stresses, &mut self.element_forces[offsets.forces.clone()]);
            }
        }
        self.gather_forces(out);
    }

    /// Product of the tangent of all elements in a state with a field of all nodal vectors, constrained ones included, without the curvature of
    /// constraints.
    pub fn tangent_product(
        &mut self,
        system: &System,
        k: &EvaluationPoint,
        field: &[Nodal],
        out: &mut [Nodal],
    ) {
        self.set_time(system, k.time);
        for (g, group, offsets) in system.numbered_groups() {
            if let Some(series) = group.power_series().filter(|_| !group.is_empty()) {
                let k = k.of_group(system, g, &self.factors);
                series.tangent_products(&k, field, &mut self.element_forces[offsets.forces.clone()]);
            }
        }
        self.gather_forces(out);
    }
}
