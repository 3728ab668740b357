//! Natural frequencies and the response to inputs.

use tegula::analysis::modal::{self, ModalOutcome, Response};
use tegula::analysis::{State, Statistics};
use tegula::model::ModalAnalysis;

use super::campbell::{self, Campbell};
use super::eigenproblem::{self, Forward};
use super::{JobError, JobObserver, JobOptions, Prepared, ResultFolder, Summary};
use super::{modes, response};
use crate::deck::Deck;
use crate::out::OutputError;

/// Runs a modal analysis.
pub(super) fn run(
    deck: &Deck,
    analysis: &ModalAnalysis,
    prepared: &Prepared,
    options: &JobOptions,
    watch: &mut dyn JobObserver,
) -> Result<Summary, JobError> {
    eigenproblem::run(
        (deck, prepared, options),
        watch,
        |forward| spectrum(analysis, prepared, forward),
        |folder, summary, before, found| record(deck, prepared, folder, summary, before, &found),
    )
}

/// The modes, and the state about which they are: the equilibrium under the loads where that is wanted.
fn spectrum(
    analysis: &ModalAnalysis,
    prepared: &Prepared,
    forward: &mut Forward<'_>,
) -> tegula::Result<Found> {
    if let (campbell, Some((about, outcome))) = campbell::run(prepared, analysis, forward)? {
        return Ok(Found { about, outcome, response: None, campbell: Some(campbell) });
    }
    let system = &prepared.system;
    let mut equilibrium: Option<State> = None;
    if analysis.prestressed {
        let outcome = modal::prestress(system, forward)?;
        forward.before = outcome.statistics;
        equilibrium = Some(outcome.state);
    }
    if system.continues() {
        // The step before was static: its loads act as at its end.
        equilibrium = Some(State { time: 1.0, ..State::first(system) });
    }
    let (outcome, response) = modal::run_with_inputs(system, analysis, equilibrium.as_ref(), forward)?;
    let about = equilibrium.unwrap_or_else(|| State::unloaded(system));
    Ok(Found { about, outcome, response, campbell: None })
}

/// Result of a modal analysis.
struct Found {
    /// State about which the model vibrates.
    about: State,
    outcome: ModalOutcome,
    response: Option<Response>,
    campbell: Option<Campbell>,
}

/// Writes what was found.
fn record(
    deck: &Deck,
    prepared: &Prepared,
    folder: &mut ResultFolder,
    summary: &mut Summary,
    before: &Statistics,
    Found { about, outcome, response, campbell }: &Found,
) -> Result<(), OutputError> {
    let rows = outcome.modes.as_slice();
    modes::write_frequencies(folder, prepared, &deck.model.output, about, rows)?;
    let unit = deck.model.output.units.of_frequency();
    let drawn = || modes::picture_of_frequencies(folder, prepared, &deck.model.title, unit.as_deref(), rows);
    if deck.model.output.pictures
        && let Err(problem) = drawn()
    {
        folder.log(&format!("a picture is missing: {problem}"))?;
    }
    if let Some(campbell) = campbell {
        campbell::write(folder, campbell)?;
        let drawn = || campbell::picture(folder, campbell, (&deck.model.title, unit.as_deref()));
        if deck.model.output.pictures
            && let Err(problem) = drawn()
        {
            folder.log(&format!("a picture is missing: {problem}"))?;
        }
    }
    summary.frequencies_hz = Some(rows.iter().map(|m| m.frequency_hz).collect());
    summary.sturm_checked = Some(outcome.sturm_checked);
    let s = &outcome.statistics;
    summary.steps = before.steps;
    summary.iterations = before.iterations + s.iterations;
    summary.factorizations = before.factorizations + s.factorizations;
    summary.cutbacks = before.cutbacks;
    let mut end = format!("Complete: {} modes", rows.len());
    if let Some(response) = response {
        if let Some(problem) = response::write(folder, prepared, &deck.model, (about, response))? {
            folder.log(&problem)?;
        }
        let (n, reduced) = (response.frequencies.len(), &response.reduced);
        let residual = reduced.lambdas.len() - reduced.modes;
        end += &format!(", {residual} residual vectors, response at {n} frequencies");
    }
    folder.log(&end)
}
