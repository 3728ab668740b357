//! Analyses of the solution sequences: `EIGRL`, `EIGR`, `NLPARM`, `PARAM,LGDISP`.

use super::case_control::{Control, Solution, Subcase};
use super::parameters::Parameters;
use crate::conversion::analyses::StepAnalysis;
use crate::conversion::document::quoted;
use crate::mesh::MeshError;
use crate::mesh::nastran::cards::Card;
use crate::mesh::nastran::file::File;
use crate::mesh::numbered::Reader;

/// An analysis, and the load set that acts.
#[derive(Debug)]
pub(super) struct Step {
    /// The analysis.
    pub analysis: StepAnalysis,
    /// Number and line of the load set.
    pub loads: Option<(u64, usize)>,
}

/// Analyses of the subcases.
///
/// # Errors
/// Subcases that are no consecutive analyses of one model, or a method that is not read.
pub(super) fn steps(
    reader: &Reader<'_>,
    file: &File<'_>,
    control: &Control,
    parameters: &Parameters,
    notes: &mut Vec<String>,
) -> Result<Vec<Step>, MeshError> {
    let (solution, line) = control.solution;
    let subcases = &control.subcases;
    let supports = file.support_set().map(|(set, _)| set);
    if let Some(other) = subcases.iter().find(|other| other.selected("SPC").map(|(set, _)| set) != supports) {
        return Err(reader.error(
            other.line,
            format!("subcase {} has other supports than the first one", other.number),
            "write a file for each set of supports, or `conditions` of `[[steps]]` in a model file",
        ));
    }
    let single = subcases.len() == 1;
    let step = |subcase: &Subcase, card, keys| {
        let name = if single { String::new() } else { format!("subcase {}", subcase.number) };
        let line = if single { line } else { subcase.line };
        Step { analysis: StepAnalysis { line, card, name, keys }, loads: subcase.selected("LOAD") }
    };
    match solution {
        Solution::Statics => {
            let keys = || vec![("type", quoted("static")), ("linear", "true".into())];
            Ok(subcases.iter().map(|subcase| step(subcase, "SOL 101", keys())).collect())
        }
        Solution::Nonlinear(by_default) => {
            let card = if by_default { "SOL 400" } else { "SOL 106" };
            let large = parameters.large_displacements.unwrap_or(by_default);
            let one = |subcase: &Subcase| {
                let mut keys = vec![("type", quoted("static"))];
                let increments = increments(reader, file, subcase)?;
                match (large, increments) {
                    (false, _) => keys.push(("linear", "true".into())),
                    (true, Some(n)) if n > 1 => keys.push(("load_steps", n.to_string())),
                    _ => {}
                }
                Ok(step(subcase, card, keys))
            };
            subcases.iter().map(one).collect()
        }
        Solution::Modes => {
            let [subcase] = &subcases[..] else {
                return Err(several(reader, control, "SOL 103 has one subcase here"));
            };
            modes(reader, file, subcase, notes).map(|keys| vec![step(subcase, "SOL 103", keys)])
        }
        Solution::Buckling => buckling(reader, file, control, notes).map(|step| vec![step]),
    }
}

/// Keys of an analysis of modes.
fn modes(
    reader: &Reader<'_>,
    file: &File<'_>,
    subcase: &Subcase,
    notes: &mut Vec<String>,
) -> Result<Vec<(&'static str, String)>, MeshError> {
    if let Some((_, line)) = subcase.selected("LOAD").or(subcase.selected("STATSUB")) {
        return Err(reader.error(
            line,
            "modes do not depend on loads, and modes of a loaded structure are not read",
            "remove the loads, or give `prestressed = true` in the model file that `tegula convert` writes",
        ));
    }
    let count = method(reader, file, subcase, notes)?;
    Ok(vec![("type", quoted("modal")), ("modes", count.to_string())])
}

/// Buckling, under the loads of the static subcase.
fn buckling(
    reader: &Reader<'_>,
    file: &File<'_>,
    control: &Control,
    notes: &mut Vec<String>,
) -> Result<Step, MeshError> {
    let [statics, buckling] = &control.subcases[..] else {
        let message = "SOL 105 has two subcases here: statics with LOAD, buckling with METHOD";
        return Err(several(reader, control, message));
    };
    let first = buckling.selected("STATSUB").is_none_or(|(number, _)| number == statics.number);
    if !first || statics.selected("LOAD").is_none() {
        return Err(reader.error(
            buckling.line,
            "the buckling subcase does not follow a static one with loads",
            "give LOAD in the first subcase and METHOD in the second one",
        ));
    }
    let count = method(reader, file, buckling, notes)?;
    let keys = vec![("type", quoted("buckling")), ("factors", count.to_string()), ("signs", quoted("both"))];
    let analysis = StepAnalysis { line: control.solution.1, card: "SOL 105", name: String::new(), keys };
    Ok(Step { analysis, loads: statics.selected("LOAD") })
}

fn several(reader: &Reader<'_>, control: &Control, message: &str) -> MeshError {
    let line = control.subcases.get(1).map_or(control.solution.1, |subcase| subcase.line);
    reader.error(line, message, "write a file for each other subcase")
}

/// Card of a number.
fn numbered<'f>(
    reader: &Reader<'_>,
    file: &'f File<'_>,
    names: &[&str],
    (number, line): (u64, usize),
) -> Result<&'f Card<'f>, MeshError> {
    let own =
        |card: &&Card<'_>| names.contains(&card.name.as_str()) && card.field(0).text.parse() == Ok(number);
    let mut found = file.cards.iter().filter(own);
    match (found.next(), found.next()) {
        (Some(card), None) => Ok(card),
        (Some(_), Some(again)) => Err(reader.error(
            again.line,
            format!("{} {number} is defined again", again.name),
            "keep one of them",
        )),
        _ => Err(reader.error(
            line,
            format!("there is no {} {number}", names.join(" or ")),
            "check the number",
        )),
    }
}

/// Number of modes or factors that `METHOD` asks for.
fn method(
    reader: &Reader<'_>,
    file: &File<'_>,
    subcase: &Subcase,
    notes: &mut Vec<String>,
) -> Result<u64, MeshError> {
    let Some(selected) = subcase.selected("METHOD") else {
        let line = subcase.line.max(1);
        return Err(reader.error(
            line,
            "there is no METHOD",
            "select an EIGRL with METHOD = in the case control",
        ));
    };
    let card = numbered(reader, file, &["EIGRL", "EIGR"], selected)?;
    let (from, to, count) = match card.name.as_str() {
        "EIGRL" => (1, 2, 3),
        _ => (2, 3, 5),
    };
    if let Some(low) = card.real(reader, from, "the lower end of the range")?.filter(|low| *low > 0.0) {
        return Err(reader.error(
            card.line,
            format!("{} asks for modes above {low}", card.name),
            "leave the lower end of the range blank: the lowest modes are computed",
        ));
    }
    if let Some(high) = card.real(reader, to, "the upper end of the range")? {
        notes.push(format!(
            "the upper end {high} of the range of {} (line {}), as the number of modes decides",
            card.name, card.line
        ));
    }
    card.id(reader, count, "the number ND of modes")
}

/// Number of increments of `NLPARM`.
fn increments(reader: &Reader<'_>, file: &File<'_>, subcase: &Subcase) -> Result<Option<u64>, MeshError> {
    let Some(selected) = subcase.selected("NLPARM") else { return Ok(None) };
    let card = numbered(reader, file, &["NLPARM"], selected)?;
    match card.field(1).text.is_empty() {
        true => Ok(Some(10)),
        false => card.id(reader, 1, "the number of increments").map(Some),
    }
}
