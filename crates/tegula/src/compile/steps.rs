//! Analysis steps of a model: each as a model with one analysis, and how its loads continue those of the step before.

use super::perturbation_steps::{about_the_end, beside_held_loads};
use super::step_joints;
use crate::Issue;
use crate::checker::Checker;
use crate::load::{LoadFactor, TimeFunction};
use crate::model::{Analysis, AnalysisStep, Condition, Load, ModalAnalysis, Model, PrescribedStrain};

/// Longest name of a step: it becomes the name of a folder.
const LONGEST_NAME: usize = 40;

/// Analysis step of a model.
#[derive(Debug, Clone, PartialEq)]
pub struct StepModel {
    /// Name, that of its position where the model gives none.
    pub name: String,
    /// The model with the analysis of the step, and with all conditions and loads that act in it.
    pub model: Model,
    /// Index of the step at whose end this one starts; `None`: the reference configuration at rest.
    pub starts_from: Option<usize>,
    /// Time or load factor at which the step ends.
    pub ends_at: f64,
    /// Whether each of the model's conditions prescribes a motion that stays where the step before has left it.
    pub(super) staying: Vec<bool>,
    /// Names of joints that do not act in the step; `model` does not have them.
    pub released: Vec<String>,
    /// Names of joints whose sides do not move against each other in the step.
    pub locked: Vec<String>,
    /// Continuation of each of the model's loads from the step before.
    pub(super) loads: Vec<Continued>,
    /// Continuation of each of [`all_strains`] from the step before.
    pub(super) strains: Vec<(Continued, Option<String>)>,
    /// Continuation of the loads that a caller adds to all steps.
    pub(super) of_caller: Continued,
    /// Keys of the model file in place of those of `model`.
    pub(super) keys: Vec<(String, String)>,
    /// Key of the step in the model file; `None` for the one analysis of a model without steps.
    pub(super) place: Option<String>,
}

/// Continuation of a load from the step before.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Continued {
    /// Factor at the end of the step before; 0 where it did not have the load.
    pub(super) start: f64,
    /// Whether the step does not have the load any more.
    pub(super) released: bool,
    /// Whether its factor stays throughout the step.
    pub(super) held: bool,
}

impl Continued {
    /// Factor of the load, which follows an amplitude.
    pub(super) fn factor(&self, amplitude: Option<usize>) -> LoadFactor {
        LoadFactor { amplitude, start: self.start, released: self.released, held: self.held }
    }
}

impl StepModel {
    /// Key of the model file for a key of the step's model: `loads[3].on` may be `steps[1].loads[0].on`.
    pub fn key(&self, key: &str) -> String {
        let matching = |(own, _): &&(String, String)| {
            key.strip_prefix(own.as_str()).is_some_and(|rest| rest.is_empty() || rest.starts_with(['.', '[']))
        };
        let whole_list = ["conditions", "loads", "prescribed_strains", "released"].contains(&key);
        if let Some(place) = self.place.as_ref().filter(|_| whole_list) {
            return place.clone();
        }
        match self.keys.iter().find(matching) {
            Some((own, file)) => format!("{file}{}", &key[own.len()..]),
            None => key.to_owned(),
        }
    }

    /// Appends the loads of the inputs of a modal analysis, at the key `analysis` of the model file, to those of the step: they are
    /// compiled like all others, and their factor is 0.
    fn add_inputs(&mut self, analysis: &str) {
        let Analysis::Modal(modal) = &self.model.analysis else { return };
        for (i, input) in modal.inputs.iter().enumerate() {
            for (j, load) in input.loads.iter().enumerate() {
                let own = format!("loads[{}]", self.model.loads.len());
                self.keys.push((own, format!("{analysis}.inputs[{i}].loads[{j}]")));
                self.model.loads.push(load.clone());
                self.loads.push(Continued { released: true, ..Continued::default() });
            }
        }
    }

    /// Whether the condition with a key of the step's model prescribes a motion that stays where the step before has left it.
    pub(super) fn stays(&self, key: &str) -> bool {
        self.staying.iter().enumerate().any(|(i, stays)| *stays && key == format!("conditions[{i}]"))
    }

    /// Forces that fall to 0 over the step, behind the step `before`: they have not where it ends early.
    pub(super) fn falling(&self, before: Option<&Self>) -> Option<&'static str> {
        let lost = |before: &Self| before.model.conditions.iter().any(|c| !self.model.conditions.contains(c));
        let unlocked = |before: &Self| before.locked.iter().any(|name| !self.locked.contains(name));
        let falls = |load: &Continued| load.released && load.start != 0.0;
        let found = [
            (self.loads.iter().any(falls), "a load that it does not have any more"),
            (
                self.strains.iter().any(|(strain, _)| falls(strain)),
                "a prescribed strain that it does not have any more",
            ),
            (before.is_some() && !self.released.is_empty(), "the force of a joint that it releases"),
            (before.is_some_and(unlocked), "the force of a joint that it does not lock any more"),
            (before.is_some_and(lost), "the reaction of a support that it does not have any more"),
        ];
        found.into_iter().find(|(falls, _)| *falls).map(|(_, what)| what).filter(|_| self.ends_early())
    }

    /// Whether the loads depend on a load factor that is another one than 1 at the end of the step.
    fn ends_early(&self) -> bool {
        self.model.analysis.seeks_equilibria() && self.ends_at != 1.0
    }

    /// Issues of the step's model at the keys of the model file.
    pub fn located(&self, issues: Vec<Issue>) -> Vec<Issue> {
        let locate = |issue: Issue| Issue { place: crate::Place::key(self.key(&issue.place.key)), ..issue };
        issues.into_iter().map(locate).collect()
    }
}

/// Prescribed strains of the whole model and of all its steps, without their amplitudes: as often as the step with most of
/// the same kind has it. The elements hold all of them.
pub(super) fn all_strains(model: &Model) -> Vec<PrescribedStrain> {
    let mut all: Vec<PrescribedStrain> =
        model.prescribed_strains.iter().map(PrescribedStrain::without_amplitude).collect();
    for (number, step) in model.steps.iter().enumerate() {
        let mut left = all.clone();
        // A buckling step has its own strains beside those of its base state.
        let of_base = match step.analysis {
            Analysis::Buckling(_) => {
                base(model, number).map(|before| &model.steps[before].prescribed_strains)
            }
            _ => None,
        };
        let own = of_base.into_iter().flatten().chain(&step.prescribed_strains);
        for strain in model.prescribed_strains.iter().chain(own) {
            let strain = strain.without_amplitude();
            match left.iter().position(|other| *other == strain) {
                Some(i) => drop(left.remove(i)),
                None => all.push(strain),
            }
        }
    }
    all
}

/// Pairs of equal entries of two lists, each entry in one pair at most: first those that are equal, then those that are equal
/// but for their amplitudes. The result gives for each entry of `old` the index of its partner.
fn partners<T: PartialEq>(old: &[T], new: &[T], without_amplitude: impl Fn(&T) -> T) -> Vec<Option<usize>> {
    let mut out = vec![None; old.len()];
    let mut taken = vec![false; new.len()];
    for exact in [true, false] {
        for (old, out) in old.iter().zip(&mut out).filter(|(_, out)| out.is_none()) {
            let same = |other: &T| {
                if exact { other == old } else { without_amplitude(other) == without_amplitude(old) }
            };
            *out = (0..new.len()).find(|&i| !taken[i] && same(&new[i]));
            if let Some(i) = *out {
                taken[i] = true;
            }
        }
    }
    out
}

/// Analysis steps of a model, at least one: a model without `steps` has the step of its `analysis`. Each ends where it ends without a stop
/// condition.
pub fn steps(model: &Model) -> Vec<StepModel> {
    steps_with_ends(model, &[])
}

/// Analysis steps of a model of which the first ones have ended at these times or load factors.
pub(super) fn steps_with_ends(model: &Model, ends: &[f64]) -> Vec<StepModel> {
    if model.steps.is_empty() {
        let mut only = StepModel {
            name: String::new(),
            model: model.clone(),
            starts_from: None,
            ends_at: end_of(&model.analysis),
            staying: vec![false; model.conditions.len()],
            released: Vec::new(),
            locked: Vec::new(),
            loads: vec![Continued::default(); model.loads.len()],
            strains: model
                .prescribed_strains
                .iter()
                .map(|strain| (Continued::default(), strain.amplitude().cloned()))
                .collect(),
            of_caller: Continued::default(),
            keys: Vec::new(),
            place: None,
        };
        only.add_inputs("analysis");
        return vec![only];
    }
    let mut out: Vec<StepModel> = Vec::new();
    for (number, step) in model.steps.iter().enumerate() {
        let before = base(model, number);
        let mut next = match (&step.analysis, before) {
            (Analysis::Modal(_), Some(before)) => about_the_end(model, number, step, &out[before], before),
            (Analysis::Buckling(_), Some(before)) => {
                let at_the_end = about_the_end(model, number, step, &out[before], before);
                beside_held_loads(at_the_end, (step, number), &out[before], &all_strains(model))
            }
            _ => one_step(model, number, step, before.map(|i| (i, &out[i]))),
        };
        next.add_inputs(&format!("steps[{number}].analysis"));
        next.ends_at = ends.get(number).copied().unwrap_or_else(|| end_of(&step.analysis));
        out.push(next);
    }
    out
}

/// Step at whose end a step starts; `None`: at the reference configuration. Modes leave the state as it is.
fn base(model: &Model, number: usize) -> Option<usize> {
    let stays = |analysis: &Analysis| matches!(analysis, Analysis::Modal(_) | Analysis::Buckling(_));
    (0..number).rev().find(|&i| !stays(&model.steps[i].analysis))
}

/// Keys of a step that stand for those of a model of its own, with the exception of lists.
pub(super) fn own_keys(number: usize) -> Vec<(String, String)> {
    [("analysis", "analysis"), ("initial_velocities", "initial_velocities"), ("output.at", "at")]
        .map(|(own, file)| (own.to_owned(), format!("steps[{number}].{file}")))
        .into()
}

fn one_step(
    model: &Model,
    number: usize,
    step: &AnalysisStep,
    before: Option<(usize, &StepModel)>,
) -> StepModel {
    let mut keys = own_keys(number);
    let mut of_list = |list: &str, common: usize, own: usize| {
        keys.extend(
            (0..own).map(|i| (format!("{list}[{}]", common + i), format!("steps[{number}].{list}[{i}]"))),
        );
    };
    of_list("conditions", model.conditions.len(), step.conditions.len());
    of_list("loads", model.loads.len(), step.loads.len());
    of_list("prescribed_strains", model.prescribed_strains.len(), step.prescribed_strains.len());
    let (joints, joint_keys) = step_joints::acting(model, step);
    keys.extend(joint_keys);
    let last = before.map(|(_, before)| before);
    let (loads, continued) = continued_loads(model, step, last);
    let (prescribed_strains, strains) = continued_strains(model, step, last);
    let conditions = [model.conditions.clone(), step.conditions.clone()].concat();
    StepModel {
        name: name(step, number),
        starts_from: before.map(|(i, _)| i),
        ends_at: end_of(&step.analysis),
        staying: conditions.iter().map(|condition| motion_stays(condition, step, last)).collect(),
        released: step.released.clone(),
        locked: step.locked.clone(),
        strains,
        model: Model {
            analysis: step.analysis.clone(),
            conditions,
            loads,
            prescribed_strains,
            joints,
            initial_velocities: step.initial_velocities.clone(),
            output: output(model, step),
            steps: Vec::new(),
            ..model.clone()
        },
        loads: continued,
        of_caller: last.map_or_else(Continued::default, |before| Continued {
            start: end_factor(before, &before.of_caller, None),
            released: false,
            held: stays_as_left(step, before) || stays_again(step, &before.of_caller),
        }),
        keys,
        place: Some(format!("steps[{number}]")),
    }
}

/// Loads of a step and their continuation from the step before; behind those of the model file the loads that only that step has, which fall
/// to 0 in a static step.
fn continued_loads(
    model: &Model,
    step: &AnalysisStep,
    before: Option<&StepModel>,
) -> (Vec<Load>, Vec<Continued>) {
    let is_static = step.analysis.seeks_equilibria();
    let mut loads = [model.loads.clone(), step.loads.clone()].concat();
    let mut continued = vec![Continued::default(); loads.len()];
    let Some(before) = before else { return (loads, continued) };
    let found = partners(&before.model.loads, &loads, Load::without_amplitude);
    for ((old, was), partner) in before.model.loads.iter().zip(&before.loads).zip(found) {
        let start = end_factor(before, was, old.amplitude().as_deref());
        match partner {
            Some(i) => {
                let stays = (stays_as_left(step, before) || stays_again(step, was))
                    && !was.released
                    && loads[i].amplitude().is_none();
                continued[i] = Continued { start, held: stays, ..Continued::default() };
            }
            None if is_static && start != 0.0 => {
                loads.push(old.clone());
                continued.push(Continued { start, released: true, held: false });
            }
            None => {}
        }
    }
    (loads, continued)
}

/// Prescribed strains of a step, and the continuation of [`all_strains`] from the step before, with their amplitudes.
fn continued_strains(
    model: &Model,
    step: &AnalysisStep,
    before: Option<&StepModel>,
) -> (Vec<PrescribedStrain>, Vec<(Continued, Option<String>)>) {
    let strains = [model.prescribed_strains.clone(), step.prescribed_strains.clone()].concat();
    let all = all_strains(model);
    let bare: Vec<PrescribedStrain> = strains.iter().map(PrescribedStrain::without_amplitude).collect();
    let own = partners(&all, &bare, PrescribedStrain::clone);
    let continued_strain = |(i, own): (usize, &Option<usize>)| {
        let earlier = before.and_then(|before| Some((before, before.strains.get(i)?)));
        let start = earlier.map_or(0.0, |(b, (was, amplitude))| end_factor(b, was, amplitude.as_deref()));
        let amplitude = own.and_then(|o| strains[o].amplitude().cloned());
        let had = earlier.is_some_and(|(_, (was, _))| !was.released);
        let stays = own.is_some()
            && amplitude.is_none()
            && had
            && earlier
                .is_some_and(|(before, (was, _))| stays_as_left(step, before) || stays_again(step, was));
        (Continued { start, released: own.is_none(), held: stays }, amplitude)
    };
    let continued = own.iter().enumerate().map(continued_strain).collect();
    (strains, continued)
}

/// Whether a condition of a step prescribes a motion that stays where the step before has left it.
fn motion_stays(condition: &Condition, step: &AnalysisStep, before: Option<&StepModel>) -> bool {
    let without_amplitude = condition.motion().is_some_and(|motion| motion.amplitude.is_none());
    let left = |before: &StepModel| {
        let place = before.model.conditions.iter().position(|other| other == condition);
        place.is_some_and(|i| stays_as_left(step, before) || (is_motion(step) && before.staying[i]))
    };
    without_amplitude && before.is_some_and(left)
}

pub(super) fn name(step: &AnalysisStep, number: usize) -> String {
    if step.name.is_empty() { format!("step {}", number + 1) } else { step.name.clone() }
}

pub(super) fn output(model: &Model, step: &AnalysisStep) -> crate::model::Output {
    crate::model::Output { at: step.at.clone(), ..model.output.clone() }
}

/// Factor of a load at the end of a step.
pub(super) fn end_factor(step: &StepModel, load: &Continued, amplitude: Option<&str>) -> f64 {
    let function = amplitude.and_then(|name| TimeFunction::new(step.model.amplitudes.get(name)?).ok());
    let full = step.model.analysis.seeks_equilibria() && step.ends_at == 1.0;
    if full && function.is_none() && !load.released && !load.held {
        return 1.0;
    }
    let factor = load.factor(function.as_ref().map(|_| 0));
    let amplitudes: Vec<TimeFunction> = function.into_iter().collect();
    factor.value(&amplitudes, super::procedure(&step.model.analysis).parameter(), step.ends_at)
}

/// Time or load factor at which an analysis ends where no stop condition ends it.
fn end_of(analysis: &Analysis) -> f64 {
    match analysis {
        Analysis::Static(_) | Analysis::Modal(_) | Analysis::Buckling(_) => 1.0,
        Analysis::Path(path) => path.end_load,
        Analysis::Transient(transient) => transient.end_time,
    }
}

/// Whether loads, motions and strains without amplitude stay in a step as the one before has left them: in motions behind a static step or a
/// path that has ended at another load factor than 1.
fn stays_as_left(step: &AnalysisStep, before: &StepModel) -> bool {
    is_motion(step) && before.ends_early()
}

/// Whether a load that has stayed in the motion before stays in a step, too.
fn stays_again(step: &AnalysisStep, was: &Continued) -> bool {
    is_motion(step) && was.held
}

fn is_motion(step: &AnalysisStep) -> bool {
    matches!(step.analysis, Analysis::Transient(_))
}

/// Mistakes in the order and the keys of the analysis steps.
pub(super) fn issues(model: &Model) -> Vec<Issue> {
    let mut c = Checker::default();
    if model.steps.is_empty() {
        return c.issues;
    }
    if !model.initial_velocities.is_empty() {
        c.add(
            "initial_velocities",
            "it is not said in which step these velocities are given",
            "move them into the step: [[steps.initial_velocities]]",
        );
    }
    if !model.output.at.is_empty() {
        c.add(
            "output.at",
            "it is not said in which step these times are meant",
            "move the list into the step, as its key `at`",
        );
    }
    let linear = |analysis: &Analysis| match analysis {
        Analysis::Static(s) => Some(s.linear),
        Analysis::Transient(t) => Some(t.linear),
        Analysis::Path(_) | Analysis::Modal(_) | Analysis::Buckling(_) => None,
    };
    let first = model.steps.iter().find_map(|step| linear(&step.analysis));
    let mut moving = false;
    for (i, step) in model.steps.iter().enumerate() {
        let key = format!("steps[{i}]");
        step_joints::keys(model, step, &key, &mut c);
        if !step.name.is_empty() {
            c.file_name(&format!("{key}.name"), &step.name, LONGEST_NAME);
        }
        if linear(&step.analysis).is_some_and(|l| Some(l) != first) {
            c.add(
                format!("{key}.analysis.linear"),
                "some steps are linear and others are not: a state of one theory is none of the other",
                "give `linear` the same value in all steps",
            );
        }
        match &step.analysis {
            Analysis::Static(_) | Analysis::Path(_) if moving => c.add(
                format!("{key}.analysis.type"),
                "a static step follows a transient one: the state in motion is no equilibrium to start from",
                "put the static steps first, or let the motion come to rest in transient steps with damping",
            ),
            Analysis::Modal(_) if moving => c.add(
                format!("{key}.analysis.type"),
                "modes are computed about equilibria, and the step before leaves the model in motion",
                "put the modal step behind a static one",
            ),
            Analysis::Buckling(_) if moving => c.add(
                format!("{key}.analysis.type"),
                "buckling is computed about equilibria, and the step before leaves the model in motion",
                "put the buckling step behind a static one",
            ),
            Analysis::Buckling(_) => buckling_step(&mut c, &key, (step, i), (model, first)),
            Analysis::Modal(modal) => modal_step(&mut c, &key, (step, i), (model, modal)),
            Analysis::Transient(_) => moving = true,
            Analysis::Static(_) | Analysis::Path(_) => {}
        }
        if !step.initial_velocities.is_empty() && !matches!(step.analysis, Analysis::Transient(_)) {
            c.add(
                format!("{key}.initial_velocities"),
                "only a transient step has velocities",
                "move them into the transient step that begins with them",
            );
        }
    }
    c.issues
}

/// Keys that a modal step must not have: it vibrates about the state of the step before.
fn modal_step(
    c: &mut Checker,
    key: &str,
    (step, number): (&AnalysisStep, usize),
    (model, modal): (&Model, &ModalAnalysis),
) {
    if !modal.speeds.is_empty() {
        c.add(
            format!("{key}.analysis.speeds"),
            "a modal step vibrates about the state of the step before, at its angular velocity",
            "give `speeds` in a model without steps, with `prestressed = true`",
        );
    }
    if modal.prestressed {
        c.add(
            format!("{key}.analysis.prestressed"),
            "a modal step vibrates about the state of the step before: there is nothing to choose",
            "leave `prestressed` out; put a static step with the loads before this one",
        );
    }
    let given = [
        ("conditions", !step.conditions.is_empty()),
        ("loads", !step.loads.is_empty()),
        ("prescribed_strains", !step.prescribed_strains.is_empty()),
    ];
    for (list, _) in given.into_iter().filter(|(_, given)| *given) {
        c.add(
            format!("{key}.{list}"),
            "a modal step vibrates about the state of the step before, under its supports and loads",
            "put them into a static step before this one",
        );
    }
    joints_of_base(
        c,
        key,
        (step, number),
        model,
        "a modal step vibrates about the state of the step before, with its joints",
    );
}

/// Lists of joints that a step about the state of the step before must not have.
fn joints_of_base(
    c: &mut Checker,
    key: &str,
    (step, number): (&AnalysisStep, usize),
    model: &Model,
    message: &str,
) {
    // About the reference configuration, where nothing has forces.
    if base(model, number).is_none() {
        return;
    }
    let given = [("released", !step.released.is_empty()), ("locked", !step.locked.is_empty())];
    for (list, _) in given.into_iter().filter(|(_, given)| *given) {
        c.add(format!("{key}.{list}"), message, "put the list into a static step before this one");
    }
}

/// Keys that a buckling step must not have, and linear steps before it.
fn buckling_step(
    c: &mut Checker,
    key: &str,
    (step, number): (&AnalysisStep, usize),
    (model, linear): (&Model, Option<bool>),
) {
    if linear == Some(true) {
        c.add(
            format!("{key}.analysis.type"),
            "some steps are linear: without the terms of large displacements nothing buckles",
            "leave `linear` out of all steps",
        );
    }
    if base(model, number).is_some()
        && step.loads.is_empty()
        && step.prescribed_strains.is_empty()
        && !step.conditions.iter().any(|c| c.motion().is_some())
    {
        c.add(
            format!("{key}.loads"),
            "the buckling step has no loads of its own; those of the step before stay as they are",
            "add a [[steps.loads]] entry to this step, whose loads the factors multiply",
        );
    }
    joints_of_base(
        c,
        key,
        (step, number),
        model,
        "a buckling step is linearised about the state of the step before, with its joints",
    );
}
