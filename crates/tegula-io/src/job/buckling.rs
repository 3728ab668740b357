//! Load factors of linear buckling and their modes.

use tegula::analysis::buckling::{self, BucklingMode, BucklingOutcome};
use tegula::analysis::{State, Statistics};
use tegula::model::BucklingAnalysis;

use super::pictures::short;
use super::{JobError, JobObserver, JobOptions, Prepared, ResultFolder, Summary, eigenproblem, modes};
use crate::deck::Deck;
use crate::out::OutputError;

/// Runs a buckling analysis.
pub(super) fn run(
    deck: &Deck,
    analysis: &BucklingAnalysis,
    prepared: &Prepared,
    options: &JobOptions,
    watch: &mut dyn JobObserver,
) -> Result<Summary, JobError> {
    eigenproblem::run(
        (deck, prepared, options),
        watch,
        |forward| buckling::run(&prepared.system, analysis, forward),
        |folder, summary, _: &Statistics, found| record(deck, prepared, folder, summary, &found),
    )
}

/// Writes the load factors and the modes.
fn record(
    deck: &Deck,
    prepared: &Prepared,
    folder: &mut ResultFolder,
    summary: &mut Summary,
    outcome: &BucklingOutcome,
) -> Result<(), OutputError> {
    let base = State { time: 0.0, ..State::first(&prepared.system) };
    let row = |(i, mode): (usize, &BucklingMode)| {
        let number = (i + 1) as f64;
        (vec![number, mode.factor, mode.residual], vec![(number, mode.shape.clone())])
    };
    let rows = outcome.modes.iter().enumerate().map(row);
    let names = ["mode", "load_factor", "residual"];
    modes::write(folder, prepared, (&deck.model.output, &base), &names, rows)?;
    let drawn = || {
        let tiles = outcome.modes.iter().map(|m| (m.shape.as_slice(), format!("λ = {}", short(m.factor))));
        let title = if deck.model.title.is_empty() { "Buckling modes" } else { &deck.model.title };
        modes::picture(folder, prepared, title, tiles)
    };
    if deck.model.output.pictures
        && let Err(problem) = drawn()
    {
        folder.log(&format!("a picture is missing: {problem}"))?;
    }
    summary.load_factors = Some(outcome.modes.iter().map(|m| m.factor).collect());
    summary.sturm_checked = Some(outcome.sturm_checked);
    summary.iterations = outcome.statistics.iterations;
    summary.factorizations = outcome.statistics.factorizations;
    folder.log(&format!("Complete: {} buckling modes", outcome.modes.len()))
}
