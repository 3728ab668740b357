//! Stills that the model asks for, drawn from the files of a complete run.

use tegula::model::Still;

use super::{JobObserver, JobOptions};
use crate::deck::Deck;
use crate::plot::View;
use crate::render::{self, At, Drawing};

/// Draws all stills. One that cannot be drawn is a warning: the results do not depend on it.
pub(super) fn draw(deck: &Deck, options: &JobOptions, watch: &mut dyn JobObserver) {
    for still in &deck.model.output.stills {
        let file = options.folder.join(&still.file);
        if let Err(error) = render::still(&options.folder, &drawing(still), &file) {
            watch.on_warning(&format!("the still \"{}\" is missing: {error}", still.file));
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
