//! Reactions, loads, section forces of cuts, and the balance: columns of the history, entries of the summary.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use tegula::element::Nodal;
use tegula::result::{CutResultant, Equilibrium, Resultant};
use tegula::system::{Cut, ForceSet, RigidAcceleration};
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
    /// Mean of the set's nodes at the reference; of cuts the point in the configuration on which the forces act (length).
    #[serde(deserialize_with = "vector")]
    pub about: [f64; 3],
}

/// Acceleration of a model with inertia relief at the end of the run, in which it is at rest.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct AccelerationResult {
    /// Acceleration of the centre of mass [length/time²].
    #[serde(deserialize_with = "vector")]
    pub linear: [f64; 3],
    /// Angular acceleration [rad/time²].
    #[serde(deserialize_with = "vector")]
    pub angular: [f64; 3],
    /// Centre of mass (length).
    #[serde(deserialize_with = "vector")]
    pub centre: [f64; 3],
}

impl From<RigidAcceleration> for AccelerationResult {
    fn from(RigidAcceleration { linear, angular, centre }: RigidAcceleration) -> Self {
        Self { linear: linear.into(), angular: angular.into(), centre: centre.into() }
    }
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
    let named = |kind: &str, name: &str| {
        let name = name.replace(['\n', '\r'], " ");
        ["fx", "fy", "fz", "mx", "my", "mz"].map(|c| format!("{kind}.{name}.{c}"))
    };
    let supports = system.support_sets.iter().flat_map(|set| named("support", &set.name));
    let loads = system.load_sets.iter().flat_map(|set| named("load", &set.name));
    let of_cut = |cut: &Cut| {
        let about = ["x", "y", "z"].map(|c| format!("cut.{}.{c}", cut.name));
        named("cut", &cut.name).into_iter().chain(about)
    };
    let cuts = system.cuts.iter().flat_map(of_cut);
    let balance = ["balance.force", "balance.moment"].map(str::to_owned);
    supports.chain(loads).chain(cuts).chain(balance).collect()
}

/// Values of the columns.
pub(super) fn row(forces: &Equilibrium) -> Vec<f64> {
    let vectors = |r: &Resultant| [r.force, r.moment];
    let sets = forces.supports.iter().chain(&forces.loads).flat_map(vectors);
    let cuts = forces.cuts.iter().flat_map(|cut| vectors(&cut.resultant).into_iter().chain([cut.about]));
    let values = sets.chain(cuts).flat_map(<[f64; 3]>::from);
    values.chain([forces.force_error, forces.moment_error]).collect()
}

/// Forces of the last step, from the values of the columns and the reactions that a checkpoint keeps; `None` if there are none.
pub(super) fn restored(system: &System, row: &[f64], reactions: &[Nodal]) -> Option<Equilibrium> {
    let (sets, errors) = row.split_at_checked(row.len().checked_sub(2)?)?;
    let resultant =
        |r: &[f64]| Resultant { force: Vec3::new(r[0], r[1], r[2]), moment: Vec3::new(r[3], r[4], r[5]) };
    let cut = |r: &[f64]| CutResultant { resultant: resultant(&r[..6]), about: Vec3::new(r[6], r[7], r[8]) };
    let (of_supports, of_loads) = (6 * system.support_sets.len(), 6 * system.load_sets.len());
    let fits = sets.len() == of_supports + of_loads + 9 * system.cuts.len();
    if !fits || reactions.len() != system.vectors() {
        return None;
    }
    let (supports, rest) = sets.split_at(of_supports);
    let (loads, cuts) = rest.split_at(of_loads);
    Some(Equilibrium {
        supports: supports.chunks_exact(6).map(resultant).collect(),
        loads: loads.chunks_exact(6).map(resultant).collect(),
        cuts: cuts.chunks_exact(9).map(cut).collect(),
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

/// Entries of the summary for cuts.
pub(super) fn of_cuts(system: &System, forces: &Equilibrium) -> BTreeMap<String, ForceResult> {
    let entry = |(cut, found): (&Cut, &CutResultant)| {
        let Resultant { force, moment } = found.resultant;
        let result = ForceResult { force: force.into(), moment: moment.into(), about: found.about.into() };
        (cut.name.clone(), result)
    };
    system.cuts.iter().zip(&forces.cuts).map(entry).collect()
}
