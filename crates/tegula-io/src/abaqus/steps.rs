//! `*STEP` with `*STATIC`, `*FREQUENCY` or `*BUCKLE`.

use crate::conversion::analyses::StepAnalysis;
use crate::conversion::document::quoted;
use crate::mesh::MeshError;
use crate::mesh::abaqus::cards::{Card, DataLine, Reader, shown};

/// Most load steps that a static analysis begins with.
const MOST_LOAD_STEPS: f64 = 1e6;

/// Cards of a step, from behind `*STEP` to before `*END STEP`.
#[derive(Debug)]
pub(super) struct StepCards<'c, 't> {
    head: &'c Card<'t>,
    cards: &'c [Card<'t>],
}

/// Cards before the first step, and those of the steps.
///
/// # Errors
/// Steps do not begin and end in turn, cards stand behind a step, or there is none.
pub(super) fn split<'c, 't>(
    reader: &Reader<'_>,
    cards: &'c [Card<'t>],
) -> Result<(&'c [Card<'t>], Vec<StepCards<'c, 't>>), MeshError> {
    let first = cards.iter().position(|card| card.keyword == "STEP").unwrap_or(cards.len());
    let (model, mut rest) = cards.split_at(first);
    let outside = ["END STEP", "STATIC", "FREQUENCY", "BUCKLE", "CLOAD", "DLOAD"];
    if let Some(card) = model.iter().find(|card| outside.contains(&card.keyword.as_str())) {
        return Err(reader.error(
            card.line,
            format!("*{} stands outside of a step", card.keyword),
            "put it between *STEP and *END STEP",
        ));
    }
    let mut steps = Vec::new();
    while let [head, behind @ ..] = rest {
        if head.keyword != "STEP" {
            return Err(reader.error(
                head.line,
                format!("*{} stands behind the end of a step", shown(&head.keyword)),
                "put it before the first *STEP, or between *STEP and *END STEP",
            ));
        }
        let end = behind.iter().position(|card| matches!(card.keyword.as_str(), "END STEP" | "STEP"));
        let Some(end) = end.filter(|&end| behind.get(end).is_some_and(|card| card.keyword == "END STEP"))
        else {
            return Err(reader.error(head.line, "the step has no end", "close it with *END STEP"));
        };
        steps.push(StepCards { head, cards: behind.get(..end).unwrap_or_default() });
        rest = behind.get(end + 1..).unwrap_or_default();
    }
    if steps.is_empty() {
        return Err(reader.whole(
            "the file has no *STEP, so there is nothing to compute",
            "add a step, or name the file in a model file: [mesh] with type = \"abaqus\"",
        ));
    }
    Ok((model, steps))
}

impl<'c, 't> StepCards<'c, 't> {
    /// Cards with one of these keywords.
    pub fn of(&self, keywords: &[&str]) -> Vec<&'c Card<'t>> {
        self.cards.iter().filter(|card| keywords.contains(&card.keyword.as_str())).collect()
    }

    /// Line of `*STEP`.
    pub fn line(&self) -> usize {
        self.head.line
    }

    /// Whether the step is about the state of the step before in all programs.
    pub fn is_perturbation(&self) -> bool {
        self.head.has("PERTURBATION")
    }

    /// Whether the step is a linear static analysis about the state of the step before, whose loads do not continue.
    pub fn is_static_perturbation(&self) -> bool {
        self.is_perturbation() && !self.of(&["STATIC"]).is_empty()
    }

    /// Analysis of the step; `nonlinear` tells whether displacements are large, as it does for the steps behind.
    ///
    /// # Errors
    /// The step has no analysis or several, or its parameters or data are not read.
    pub fn analysis(&self, reader: &Reader<'_>, nonlinear: &mut bool) -> Result<StepAnalysis, MeshError> {
        reader.only(self.head, &["NAME", "NLGEOM", "INC", "PERTURBATION", "UNSYMM"])?;
        match self.head.parameter("NLGEOM").map(str::to_uppercase).as_deref() {
            None | Some("NO") => {}
            Some("" | "YES") => *nonlinear = true,
            Some(other) => {
                return Err(reader.error(
                    self.head.line,
                    format!("NLGEOM={} is not read", shown(other)),
                    "write NLGEOM, NLGEOM=YES or NLGEOM=NO",
                ));
            }
        }
        let found = self.of(&["STATIC", "FREQUENCY", "BUCKLE"]);
        let [card] = found[..] else {
            return Err(reader.error(
                found.get(1).map_or(self.head.line, |card| card.line),
                format!("the step has {} analyses", found.len()),
                "give it one of *STATIC, *FREQUENCY and *BUCKLE",
            ));
        };
        let (card_name, keys) = match card.keyword.as_str() {
            "STATIC" => ("*STATIC", statics(reader, card, *nonlinear)?),
            "FREQUENCY" => {
                reader.only(card, &["SOLVER", "EIGENSOLVER", "STORAGE", "NORMALIZATION"])?;
                let modes = wanted(reader, card, "the number of modes", true)?;
                ("*FREQUENCY", vec![("type", quoted("modal")), ("modes", modes)])
            }
            _ => {
                reader.only(card, &["SOLVER", "EIGENSOLVER"])?;
                let factors = wanted(reader, card, "the number of buckling factors", false)?;
                ("*BUCKLE", vec![("type", quoted("buckling")), ("factors", factors)])
            }
        };
        let name = self.head.parameter("NAME").unwrap_or_default().to_owned();
        Ok(StepAnalysis { line: card.line, card: card_name, name, keys })
    }
}

/// Keys of a static analysis.
fn statics(
    reader: &Reader<'_>,
    card: &Card<'_>,
    nonlinear: bool,
) -> Result<Vec<(&'static str, String)>, MeshError> {
    let refused = |message: &str, help: &str| Err(reader.error(card.line, message, help));
    if card.has("RIKS") {
        return refused("*STATIC, RIKS is not read", "give `type = \"path\"` in a model file");
    }
    if card.has("STABILIZE") {
        return refused(
            "*STATIC, STABILIZE is not read",
            "give a transient analysis with `[damping]` in a model file",
        );
    }
    reader.only(card, &["SOLVER", "DIRECT"])?;
    let mut keys = vec![("type", quoted("static"))];
    let steps = match card.data[..] {
        [] => 1.0,
        _ => load_steps(reader, reader.single(card, "the first increment and the period")?)?,
    };
    match nonlinear {
        false => keys.push(("linear", "true".into())),
        // Both are whole numbers below a million.
        true if steps > 1.0 => keys.push(("load_steps", format!("{steps:.0}"))),
        true => {}
    }
    Ok(keys)
}

/// Number of first increments in the period of a step.
fn load_steps(reader: &Reader<'_>, data: DataLine<'_>) -> Result<f64, MeshError> {
    let fields = data.list();
    let mut numbers = [0.0; 4];
    for (x, field) in numbers.iter_mut().zip(&fields) {
        *x = reader.number(data.line, field)?;
    }
    let [first, period, ..] = numbers;
    let period = if period == 0.0 { 1.0 } else { period };
    let first = if first == 0.0 { period } else { first };
    // Round-off of the quotient does not make a further step.
    let steps = (period / first - 1e-9).ceil();
    if fields.len() > 4 || !(first > 0.0 && period > 0.0 && steps <= MOST_LOAD_STEPS) {
        return Err(reader.error(
            data.line,
            "these are no first increment and period",
            "write the first increment and the period of the step, both above 0 and at most a million increments",
        ));
    }
    Ok(steps.max(1.0))
}

/// Number of modes or factors of a data line. With `alone` no other values may follow.
fn wanted(reader: &Reader<'_>, card: &Card<'_>, what: &str, alone: bool) -> Result<String, MeshError> {
    let data = reader.single(card, what)?;
    let fields = data.list();
    let count = fields.first().and_then(|field| field.parse::<u32>().ok()).filter(|&n| n > 0);
    let Some(count) = count else {
        return Err(reader.error(
            data.line,
            format!("\"{}\" is not {what}", shown(fields.first().copied().unwrap_or_default())),
            format!("write {what}, a whole number above 0"),
        ));
    };
    match fields.iter().skip(1).find(|field| !field.is_empty()) {
        Some(field) if alone => Err(reader.error(
            data.line,
            format!("*{} has a further value \"{}\"", card.keyword, shown(field)),
            format!("give {what} only; the modes are the lowest ones"),
        )),
        _ => Ok(count.to_string()),
    }
}
