//! Stills that a model asks for, drawn from the files of a complete run.

use std::path::Path;

use tegula::model::Still;

use super::{At, Drawing, still};
use crate::deck::Deck;
use crate::job::{JobError, JobObserver, Summary};
use crate::plot::View;

/// Draws the stills of a model whose run is complete, with `[[steps]]` in the folder of each step. One that cannot be drawn is a warning: the results do not
/// depend on it.
pub fn stills(deck: &Deck, folder: &Path, outcome: &Result<Summary, JobError>, watch: &mut dyn JobObserver) {
    let Ok(summary) = outcome else { return };
    let has_modes = |analysis: &str| matches!(analysis, "modal" | "buckling");
    let one = (folder.to_owned(), has_modes(&summary.analysis));
    let steps = summary.analyses.iter().map(|step| (folder.join(&step.folder), has_modes(&step.analysis)));
    let folders: Vec<_> = if summary.analyses.is_empty() { vec![one] } else { steps.collect() };
    let wanted = folders.iter().flat_map(|of| deck.model.output.stills.iter().map(move |still| (of, still)));
    for ((folder, modes), wanted) in wanted {
        // A still of a mode is for modal steps, one of a time for the others.
        let is_idle = if *modes { wanted.at.is_some() } else { wanted.mode.is_some() };
        if is_idle {
            continue;
        }
        if let Err(error) = still(folder, &drawing(wanted), &folder.join(&wanted.file)) {
            watch.on_warning(&format!("the still \"{}\" is missing: {error}", wanted.file));
        }
    }
}

fn drawing(still: &Still) -> Drawing {
    let [azimuth_deg, elevation_deg] = still.view;
    Drawing {
        field: still.field.clone(),
        at: still.mode.map(At::Mode).or(still.at.map(At::Value)).unwrap_or(At::Default),
        view: View { azimuth_deg, elevation_deg },
        scale: still.scale,
        range: still.range,
        size: still.size.into(),
    }
}

#[cfg(test)]
#[path = "stills_tests.rs"]
mod tests;
