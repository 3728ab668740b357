//! Reactions, loads and their balance: columns of the history, entries of the summary.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use tegula::element::Nodal;
use tegula::result::{Equilibrium, Resultant};
use tegula::system::ForceSet;
use tegula::{System, Vec3};

use super::summary::{number, vector};

/// Force and moment at the end of the run.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct ForceResult {
    /// Force.
    #[serde(deserialize_with = "vector")]
    pub force: [f64; 3],
    /// Moment about the point `about`.
    #[serde(deserialize_with = "vector")]
    pub moment: [f64; 3],
    /// Mean of the set's nodes at the reference (length).
    #[serde(deserialize_with = "vector")]
    pub about: [f64; 3],
}

/// Resultant of loads, reactions and inertia at the end of the run, over the sum of their sizes: 0 in perfect balance.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct BalanceResult {
    /// Resultant force over the sum of the sizes of all nodal forces.
    #[serde(deserialize_with = "number")]
    pub force: f64,
    /// Resultant moment about the middle of the model over the sum of the sizes of all nodal moments.
    #[serde(deserialize_with = "number")]
    pub moment: f64,
}

/// Names of the columns behind all others.
pub(super) fn names(system: &System) -> Vec<String> {
    let of_set = |kind: &'static str| {
        move |set: &ForceSet| {
            let name = set.name.replace(['\n', '\r'], " ");
            ["fx", "fy", "fz", "mx", "my", "mz"].map(|c| format!("{kind}.{name}.{c}"))
        }
    };
    let supports = system.support_sets.iter().flat_map(of_set("support"));
    let loads = system.load_sets.iter().flat_map(of_set("load"));
    let balance = ["balance.force", "balance.moment"].map(str::to_owned);
    supports.chain(loads).chain(balance).collect()
}

/// Values of the columns.
pub(super) fn row(forces: &Equilibrium) -> Vec<f64> {
    let sets = forces.supports.iter().chain(&forces.loads);
    let values = sets.flat_map(|r| [<[f64; 3]>::from(r.force), r.moment.into()].concat());
    values.chain([forces.force_error, forces.moment_error]).collect()
}

/// Forces of the last step, from the values of the columns and the reactions that a checkpoint keeps; `None` if there are none.
pub(super) fn restored(system: &System, row: &[f64], reactions: &[Nodal]) -> Option<Equilibrium> {
    let (sets, errors) = row.split_at_checked(row.len().checked_sub(2)?)?;
    let resultant =
        |r: &[f64]| Resultant { force: Vec3::new(r[0], r[1], r[2]), moment: Vec3::new(r[3], r[4], r[5]) };
    let all: Vec<Resultant> = sets.chunks_exact(6).map(resultant).collect();
    if all.len() != system.support_sets.len() + system.load_sets.len() || reactions.len() != system.vectors()
    {
        return None;
    }
    let (supports, loads) = all.split_at(system.support_sets.len());
    Some(Equilibrium {
        supports: supports.to_vec(),
        loads: loads.to_vec(),
        force_error: errors[0],
        moment_error: errors[1],
        reactions: reactions.to_vec(),
        ..Equilibrium::default()
    })
}

/// Entries of the summary: supports, loads, balance.
pub(super) fn results(
    system: &System,
    forces: &Equilibrium,
) -> (BTreeMap<String, ForceResult>, BTreeMap<String, ForceResult>, BalanceResult) {
    let named = |sets: &[ForceSet], values: &[Resultant]| {
        let entry = |(set, r): (&ForceSet, &Resultant)| {
            let result =
                ForceResult { force: r.force.into(), moment: r.moment.into(), about: set.about.into() };
            (set.name.clone(), result)
        };
        sets.iter().zip(values).map(entry).collect()
    };
    let balance = BalanceResult { force: forces.force_error, moment: forces.moment_error };
    (named(&system.support_sets, &forces.supports), named(&system.load_sets, &forces.loads), balance)
}
