//! Scope of the methods: power series need equilibrium equations that are polynomials, the arc-length method smooth loads.

use super::joint_series;
use crate::analysis::equilibrium::unknowns_of;
use crate::analysis::potential::{Place, have_potential};
use crate::error::Issue;
use crate::load::{FollowerLoad, TimeFunction};
use crate::model::{PathAnalysis, PathMethod};
use crate::system::power_series::SeriesStresses;
use crate::system::{CirculatoryStiffness, System, VectorKind};
use tegula_sparse::gmres::noise;

/// Load factors at which an amplitude is compared with a straight line.
const TRIALS: [f64; 6] = [-1.4371, -0.7193, 0.3179, 0.8867, 1.7731, 3.9897];
/// Departure from the line over its values that is round-off.
const ROUND_OFF: f64 = 1e-12;

/// Room for the stresses of a series, or the reason why a model has no power series, as a sentence without a full stop.
pub fn stresses(system: &System, highest: usize) -> Result<SeriesStresses, String> {
    if let Some(reason) = reason(system) {
        return Err(reason);
    }
    SeriesStresses::new(system, highest).ok_or_else(|| {
        let group = system.groups.iter().find(|group| !group.is_empty() && group.power_series().is_none());
        let name = group.map_or("", |group| group.name());
        format!("the forces of `{name}` are no polynomials of the displacements")
    })
}

/// Method that follows a path: the one wanted, else power series where the model has some. Why it has none comes with it.
pub fn method(system: &System, options: &PathAnalysis) -> Result<(PathMethod, Option<String>), Issue> {
    let impossible = |reason: String| {
        Issue::new(
            "analysis.type",
            format!("the path cannot be followed: {reason}"),
            "take loads that grow from 0 smoothly with the load factor; or a static analysis, up to the limit point",
        )
    };
    if let Some(reason) = jump(system) {
        return Err(impossible(reason));
    }
    let why = match options.method {
        Some(PathMethod::ArcLength) => None,
        wanted => match (stresses(system, 2).err(), wanted) {
            (None, _) => return Ok((PathMethod::Series, None)),
            (Some(reason), Some(_)) => return Err(without_series(&reason)),
            (why, None) => why,
        },
    };
    match kink(system).or_else(|| turning(system, options.end_load)) {
        Some(reason) => Err(impossible(reason)),
        None => Ok((PathMethod::ArcLength, why)),
    }
}

/// Mistake of a model for which power series are wanted, and which has none.
pub fn without_series(reason: &str) -> Issue {
    Issue::new(
        "analysis.method",
        format!("the path cannot be expanded into power series: {reason}"),
        "take linear materials, joints of quadratic constraints without drives, springs of constant stiffness between points, and loads of constant direction, or pressures on faces with held edges, that grow from 0 in a \
         straight line; or leave `method` out for the arc-length method",
    )
}

/// Why the first state of a path is no equilibrium, as text.
fn jump(system: &System) -> Option<String> {
    let amplitudes = &system.amplitudes;
    let jumps = system.load_factors().any(|factor| factor.jumps(amplitudes))
        || system.dofs().prescribed.iter().any(|motion| motion.jumps(amplitudes));
    jumps.then(|| {
        "an amplitude is not at load factor 0 where the step before has left its load (0 in a first step): the path would not begin in \
         equilibrium"
            .into()
    })
}

/// Amplitude with which a path would change its direction suddenly, as text.
fn kink(system: &System) -> Option<String> {
    let has_kinks =
        |i: &usize| system.amplitudes.get(*i).is_some_and(|function| !function.kinks().is_empty());
    let amplitude = system.amplitudes_in_use().map(|(i, _)| i).find(has_kinks)?;
    let name = system.amplitude_name(amplitude);
    Some(format!(
        "the amplitude \"{name}\" has kinks, where the path would change its direction; a formula such as `expression = \"t\"` has none"
    ))
}

/// Load factors up to the end of a path at which the slope of amplitudes is looked at.
const LOOKS: u32 = 1000;

/// Amplitude that does not rise or fall all the way, as text: where its slope vanishes the load factor is no measure of the load.
fn turning(system: &System, end: f64) -> Option<String> {
    let turns = |i: &usize| {
        let Some(function) = system.amplitudes.get(*i) else { return false };
        let first = function.rate(0.0);
        let constant = (0..=LOOKS).all(|k| function.rate(end * f64::from(k) / f64::from(LOOKS)) == 0.0);
        !constant
            && (0..=LOOKS).any(|k| {
                let rate = function.rate(end * f64::from(k) / f64::from(LOOKS));
                !(rate * first > SLOPE * first * first)
            })
    };
    let amplitude = system.amplitudes_in_use().map(|(i, _)| i).find(turns)?;
    let name = system.amplitude_name(amplitude);
    Some(format!(
        "the slope of the amplitude \"{name}\" vanishes or changes its sign on the way to load factor {end}, so that the load factor is no \
         measure of the load there"
    ))
}

/// Slope of an amplitude over that at the start, below which it vanishes.
const SLOPE: f64 = 1e-6;

/// Whether loads depend on the displacements that are no pressures.
fn other_follower_loads(system: &System) -> bool {
    let is_pressure = |load: &FollowerLoad| matches!(load, FollowerLoad::Pressure { .. });
    !system.followers.iter().all(is_pressure)
        || !system.centrifugal.is_empty()
        || system.inertia_relief.is_some()
}

fn driven_beside_pressures(system: &System) -> bool {
    !system.followers.is_empty() && system.dofs().prescribed.iter().any(|motion| !motion.held)
}

fn pressures_on_bodies(system: &System) -> bool {
    let mut nodes = system.followers.iter().flat_map(FollowerLoad::vectors);
    nodes.any(|&node| system.dofs().is_carried(node as usize))
}

/// Part of the length of a model by which its nodes are displaced where the load stiffness is looked at.
const DISPLACED: f64 = 0.05;

/// Whether the load stiffness of pressures is symmetric, in the reference configuration and in another one: the motions of edges decide, which
/// supports hold or leave in all configurations. A pressure may vanish at one load factor.
fn pressures_have_potential(system: &System) -> bool {
    let mut free = vec![0.0; system.unknowns()];
    let positions = unknowns_of(system, system.dofs(), VectorKind::Position);
    for (number, random) in positions.zip(noise()) {
        free[number as usize] = DISPLACED * system.length * random;
    }
    let rest = vec![[0.0; 3]; system.vectors()];
    let mut displaced = rest.clone();
    system.frames.expand(&free, &mut displaced);
    let places =
        [0.0, 1.0].map(|time| [&rest, &displaced].map(|u| Place { u, time, frames: &system.frames }));
    places.iter().flatten().all(|place| have_potential(system, place, CirculatoryStiffness::new(system), &[]))
}

fn reason(system: &System) -> Option<String> {
    let dofs = system.dofs();
    let is_unit = |v: usize| dofs.unit.iter().any(|unit| unit.vector as usize == v);
    let driven = dofs.prescribed.iter().any(|motion| !motion.held && is_unit(motion.place().0));
    let given = [
        (driven, "prescribed motions turn inextensible directors"),
        (
            other_follower_loads(system),
            "loads other than pressures depend on the displacements: moments, follower, centrifugal and turning forces, or reactions of released joints",
        ),
        (driven_beside_pressures(system), "pressures act beside prescribed motions"),
        (pressures_on_bodies(system), "pressures act on nodes that bodies or beams carry"),
        (!system.without_internal_variables(), "a material or an enhanced strain keeps a history"),
    ];
    if let Some((_, reason)) = given.into_iter().find(|(is, _)| *is) {
        return Some(reason.into());
    }
    if !system.followers.is_empty() && !pressures_have_potential(system) {
        return Some("pressures without a potential act, whose load stiffness is not symmetric: on faces with free edges, or of varying size".into());
    }
    if let Some(name) = joint_series::without_series(system) {
        return Some(format!(
            "the constraints of joint \"{name}\" are no quadratic forms, or depend on a drive, friction or stops"
        ));
    }
    let bent = system.amplitudes_in_use().find(|(i, _)| !system.amplitudes.get(*i).is_some_and(is_affine))?;
    let name = system.amplitude_names.get(bent.0).map_or("", String::as_str);
    Some(format!("the amplitude \"{name}\" is no straight line over the load factor"))
}

/// Whether a function of the load factor is `b + c λ`.
fn is_affine(function: &TimeFunction) -> bool {
    let (start, end) = (function.value(0.0), function.value(1.0));
    let straight = |t: f64| {
        let line = start + t * (end - start);
        (function.value(t) - line).abs() <= ROUND_OFF * (start.abs() + t.abs() * (end - start).abs())
    };
    TRIALS.into_iter().all(straight)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn straight_lines_are_told_from_bent_ones() {
        let table = TimeFunction::Table(vec![(0.0, 0.0), (1.0, 1.0)]);
        assert!(is_affine(&TimeFunction::Constant(0.3)));
        assert!(!is_affine(&table), "constant before and behind its points");
    }
}
