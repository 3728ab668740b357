//! Checks of the amplitudes of a model over the whole time of its analysis.

use std::collections::BTreeMap;

use crate::Issue;
use crate::load::TimeFunction;
use crate::model::{Amplitude, Analysis, Condition, Model};

/// Instants at which a formula is tried, beside the first. An undefined interval between them is found during the
/// analysis.
const INSTANTS: u32 = 1000;

/// Time between two points of a table over the end of the analysis below which a change is a jump.
const JUMP: f64 = 1e-8;

/// Amplitudes that are no functions of time, or have no value at a time at which the model needs one.
pub(super) fn amplitudes(model: &Model) -> Vec<Issue> {
    let mut issues = Vec::new();
    for (name, amplitude) in &model.amplitudes {
        let key = key(name, amplitude);
        match TimeFunction::new(amplitude) {
            Ok(function) => issues.extend(
                undefined_interval(model, name, &function)
                    .or_else(|| jump(model, name, amplitude))
                    .map(|(message, help)| Issue::new(key, message, help)),
            ),
            Err((message, help)) => issues.push(Issue::new(key, message, help)),
        }
    }
    issues
}

/// The key at which an amplitude is wrong.
pub(super) fn key(name: &str, amplitude: &Amplitude) -> String {
    let last = match amplitude {
        Amplitude::Constant(_) => "value",
        Amplitude::Ramp(_) => "end",
        Amplitude::Table(_) => "times",
        Amplitude::Spline(_) => "times",
        Amplitude::Expression(_) => "expression",
    };
    format!("amplitudes.{name}.{last}")
}

/// The first time at which the table of a prescribed motion jumps in a transient analysis. Nothing moves at an infinite
/// velocity: what a scheme makes of it depends on its steps.
fn jump(model: &Model, name: &str, amplitude: &Amplitude) -> Option<(String, String)> {
    let (Analysis::Transient(t), Amplitude::Table(table)) = (&model.analysis, amplitude) else { return None };
    let drives = |c: &Condition| c.motion().is_some_and(|m| m.amplitude.as_deref() == Some(name));
    if !model.conditions.iter().any(drives) && !drives_joint(model, name) {
        return None;
    }
    let pieces = table.times.windows(2).zip(table.values.windows(2));
    let jumps = |(times, values): &(&[f64], &[f64])| {
        times[1] - times[0] < JUMP * t.end_time && values[0] != values[1]
    };
    let (times, _) = pieces.into_iter().find(jumps)?;
    Some((
        format!("a prescribed motion uses this table, which is discontinuous at t = {}", times[0]),
        "a motion needs time: let the values change over several time steps, at best smoothly by a formula"
            .into(),
    ))
}

/// Whether a driven joint follows an amplitude.
fn drives_joint(model: &Model, name: &str) -> bool {
    model.joints.iter().any(|joint| joint.common().drive().is_some_and(|drive| drive.amplitude == name))
}

/// The first time at which a function that is in use has no finite value, or no velocity where a motion follows it.
fn undefined_interval(model: &Model, name: &str, function: &TimeFunction) -> Option<(String, String)> {
    let (end, moves) = match &model.analysis {
        Analysis::Static(_) => (1.0, false),
        Analysis::Path(p) => (p.end_load, false),
        Analysis::Modal(m) => (if m.prestressed { 1.0 } else { 0.0 }, false),
        Analysis::Buckling(_) => (1.0, false),
        Analysis::Transient(t) => (t.end_time, true),
    };
    let is = |amplitude: &Option<String>| amplitude.as_deref() == Some(name);
    let drives = model.conditions.iter().any(|c| c.motion().is_some_and(|m| is(m.amplitude)))
        || drives_joint(model, name);
    let loads = model.loads.iter().any(|load| is(load.amplitude()));
    let strains = model.prescribed_strains.iter().any(|p| p.amplitude().is_some_and(|a| a == name));
    if !(drives || loads || strains) || !end.is_finite() {
        return None;
    }
    let motion = drives && moves;
    let (t, (what, value)) = (0..=INSTANTS)
        .map(|i| end * f64::from(i) / f64::from(INSTANTS))
        .find_map(|t| Some((t, function.undefined(t, motion)?)))?;
    let (message, help) = if what == "value" {
        (
            format!("the {what} at t = {t} is {value}"),
            format!("the formula needs a finite value from 0 to {end}"),
        )
    } else {
        (
            format!("the {what} at t = {t} is {value}, but a prescribed motion follows this amplitude"),
            "let the motion begin and end smoothly, such as with t^2 or 1 - cos(t)".to_owned(),
        )
    };
    Some((message, help))
}

/// Amplitudes of a model as functions of time, and their numbers by name; what is wrong with them becomes an issue.
pub(super) fn time_functions(
    model: &Model,
    issues: &mut Vec<Issue>,
) -> (Vec<TimeFunction>, BTreeMap<String, usize>) {
    let mut functions = Vec::new();
    let mut names = BTreeMap::new();
    for (name, amplitude) in &model.amplitudes {
        match TimeFunction::new(amplitude) {
            Ok(f) => {
                names.insert(name.clone(), functions.len());
                functions.push(f);
            }
            Err((message, help)) => issues.push(Issue::new(key(name, amplitude), message, help)),
        }
    }
    (functions, names)
}
