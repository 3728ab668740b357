//! Analysis steps about the state in which another one has ended, and which leave it as it is: modes and linear buckling.

use super::steps::{Continued, StepModel, end_factor, name, output, own_keys};
use crate::model::{AnalysisStep, Condition, Model, PrescribedStrain};

/// Buckling step, from that of its base state: the loads and prescribed strains of the base state stay as they are, and those of the step
/// itself are new. A motion of a component that the base state prescribes, too, takes the place of that one.
pub(super) fn beside_held_loads(
    base: StepModel,
    (step, number): (&AnalysisStep, usize),
    before: &StepModel,
    all: &[PrescribedStrain],
) -> StepModel {
    let mut out = base;
    let mut own_keys = |list: &str, first: usize, own: usize| {
        let key = |i: usize| (format!("{list}[{}]", first + i), format!("steps[{number}].{list}[{i}]"));
        out.keys.extend((0..own).map(key));
    };
    own_keys("loads", before.model.loads.len(), step.loads.len());
    own_keys("prescribed_strains", before.model.prescribed_strains.len(), step.prescribed_strains.len());
    out.loads.resize(out.loads.len() + step.loads.len(), Continued::default());
    out.model.loads.extend_from_slice(&step.loads);
    for (i, condition) in step.conditions.iter().enumerate() {
        let list = &mut out.model.conditions;
        let place = list.iter().position(|other| moves_the_same(other, condition)).unwrap_or(list.len());
        if place < list.len() {
            (list[place], out.staying[place]) = (condition.clone(), false);
        } else {
            list.push(condition.clone());
            out.staying.push(false);
        }
        out.keys.insert(0, (format!("conditions[{place}]"), format!("steps[{number}].conditions[{i}]")));
    }
    out.model.prescribed_strains.extend_from_slice(&step.prescribed_strains);
    for strain in &step.prescribed_strains {
        let bare = strain.without_amplitude();
        let is_free = |i: &usize| all[*i] == bare && out.strains[*i].0 == held_at_zero();
        if let Some(place) = (0..all.len()).find(is_free) {
            out.strains[place] = (Continued::default(), strain.amplitude().cloned());
        }
    }
    out
}

/// Whether both conditions prescribe the same component of the same set.
fn moves_the_same(condition: &Condition, other: &Condition) -> bool {
    let moved = |c: &Condition| c.motion().map(|motion| (motion.of, motion.component));
    moved(condition).is_some() && moved(condition) == moved(other) && condition.on() == other.on()
}

/// Prescribed strain that the base state of a buckling step does not have.
fn held_at_zero() -> Continued {
    Continued { held: true, ..Continued::default() }
}

/// Modal step: the conditions of the step at whose end it stands, and its loads with their factors there.
pub(super) fn about_the_end(
    model: &Model,
    number: usize,
    step: &AnalysisStep,
    before: &StepModel,
    index: usize,
) -> StepModel {
    let held = |was: &Continued, amplitude: Option<&str>| Continued {
        start: end_factor(before, was, amplitude),
        released: false,
        held: true,
    };
    let loads = before.loads.iter().zip(&before.model.loads);
    let strains = before.strains.iter();
    StepModel {
        name: name(step, number),
        loads: loads.map(|(was, load)| held(was, load.amplitude().as_deref())).collect(),
        strains: strains.map(|(was, amplitude)| (held(was, amplitude.as_deref()), None)).collect(),
        of_caller: held(&before.of_caller, None),
        model: Model { analysis: step.analysis.clone(), output: output(model, step), ..before.model.clone() },
        starts_from: Some(index),
        place: Some(format!("steps[{number}]")),
        keys: [own_keys(number), before.keys.clone()].concat(),
        ..before.clone()
    }
}
