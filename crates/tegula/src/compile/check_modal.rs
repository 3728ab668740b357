//! Checks of a modal analysis and of the response to its inputs.

use crate::checker::Checker;
use crate::model::{Beam, FrequencyResponse, Load, ModalAnalysis, Model, Spacing};

/// Longest name of an input (characters). It becomes part of file names.
const LONGEST_NAME: usize = 60;

/// Largest number of frequencies of a response.
const MOST_FREQUENCIES: u32 = 100_000;

/// Modal damping above which motions hardly swing.
const CRITICAL: f64 = 1.0;

/// Adds the mistakes of a modal analysis.
pub(super) fn modal(model: &Model, modal: &ModalAnalysis, c: &mut Checker) {
    if modal.modes == 0 {
        c.add("analysis.modes", "no modes wanted", "give at least 1");
    }
    if !(0.0..CRITICAL).contains(&modal.damping_ratio) {
        c.add(
            "analysis.damping_ratio",
            format!("the damping ratio is {}", modal.damping_ratio),
            "give a part of the critical damping, at least 0 and below 1, such as 0.02",
        );
    }
    speeds(model, modal, c);
    inputs(model, modal, c);
    if let Some(response) = &modal.frequency_response {
        frequencies(response, c);
        if modal.inputs.is_empty() {
            c.add(
                "analysis.frequency_response",
                "no input excites the response",
                "add an [[analysis.inputs]] entry with a name and its loads",
            );
        }
    } else if modal.inputs.is_empty() && modal.damping_ratio != 0.0 {
        c.add(
            "analysis.damping_ratio",
            "modes have no damping: it acts in the response to inputs only",
            "add [[analysis.inputs]], or leave `damping_ratio` out",
        );
    }
}

/// Adds the mistakes of the angular velocities of a Campbell diagram.
fn speeds(model: &Model, modal: &ModalAnalysis, c: &mut Checker) {
    for (i, speed) in modal.speeds.iter().enumerate().filter(|(_, speed)| !speed.is_finite()) {
        c.add(
            format!("analysis.speeds[{i}]"),
            format!("the angular velocity is {speed}"),
            "give a finite number",
        );
    }
    let turns = model.loads.iter().any(|load| matches!(load, Load::Centrifugal(_)));
    if !modal.speeds.is_empty() && !turns {
        c.add(
            "analysis.speeds",
            "the model has no centrifugal load, whose angular velocity they are",
            "add a load of the type \"centrifugal\", which gives the axis, or leave `speeds` out",
        );
    }
    let centrifugal = || model.loads.iter().filter(|load| matches!(load, Load::Centrifugal(_)));
    if !modal.speeds.is_empty()
        && (centrifugal().count() > 1 || centrifugal().any(|load| load.amplitude().is_some()))
    {
        c.add(
            "analysis.speeds",
            "they take the place of the angular velocity of one centrifugal load without an amplitude",
            "keep one such load, and leave its `amplitude` out",
        );
    }
    if !modal.speeds.is_empty() && !modal.inputs.is_empty() {
        c.add(
            "analysis.speeds",
            "the response of a model that turns is not computed",
            "leave out `inputs` or `speeds`",
        );
    }
}

fn inputs(model: &Model, modal: &ModalAnalysis, c: &mut Checker) {
    for (i, input) in modal.inputs.iter().enumerate() {
        let key = format!("analysis.inputs[{i}]");
        c.file_name(&format!("{key}.name"), &input.name, LONGEST_NAME);
        if modal.inputs[..i].iter().any(|other| other.name == input.name) {
            c.add(
                format!("{key}.name"),
                format!("two inputs are named \"{}\"", input.name),
                "give each input its own name",
            );
        }
        if input.loads.is_empty() {
            c.add(format!("{key}.loads"), "the input has no loads", "give at least one, as in [[loads]]");
        }
        for (j, load) in input.loads.iter().enumerate() {
            let key = format!("{key}.loads[{j}]");
            if load.amplitude().is_some() {
                c.add(
                    format!("{key}.amplitude"),
                    "the response is that to any function of time: the loads of an input have no amplitude",
                    "leave `amplitude` out",
                );
            }
            if load.values().iter().all(|value| *value == 0.0) {
                c.add(key, "the load of the input is 0: there is no response to it", "give its value");
            }
        }
    }
    if !modal.inputs.is_empty()
        && model.output.points.is_empty()
        && model.bodies.is_empty()
        && !model.beams.iter().any(shown)
    {
        c.add(
            "analysis.inputs",
            "the response has no outputs: the model records no points and has no bodies or beams",
            "add an [[output.points]] entry for each point whose motion is wanted",
        );
    }
}

/// Whether nodes of a beam are in the history.
fn shown(beam: &Beam) -> bool {
    beam.history.as_ref().is_none_or(|nodes| !nodes.is_empty())
}

fn frequencies(response: &FrequencyResponse, c: &mut Checker) {
    let FrequencyResponse { from, to, points, spacing } = response;
    c.not_negative("analysis.frequency_response.from", "the lowest frequency", *from);
    c.positive("analysis.frequency_response.to", "the highest frequency", *to);
    if from >= to {
        c.add(
            "analysis.frequency_response.to",
            format!("the range from {from} to {to} holds no frequency"),
            "give a highest frequency above the lowest one",
        );
    }
    if *from == 0.0 && *spacing == Spacing::Logarithmic {
        c.add(
            "analysis.frequency_response.from",
            "equal ratios of frequencies cannot begin at 0",
            "give a lowest frequency above 0, or spacing = \"linear\"",
        );
    }
    if !(2..=MOST_FREQUENCIES).contains(points) {
        c.add(
            "analysis.frequency_response.points",
            format!("{points} frequencies are wanted"),
            format!("give a number from 2 to {MOST_FREQUENCIES}"),
        );
    }
}
