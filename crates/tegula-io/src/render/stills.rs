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
    let steps: Vec<_> = summary.analyses.iter().map(|step| folder.join(&step.folder)).collect();
    let folders = if steps.is_empty() { vec![folder.to_owned()] } else { steps };
    for (folder, wanted) in folders.iter().flat_map(|f| deck.model.output.stills.iter().map(move |s| (f, s)))
    {
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
