//! Mistakes in the values of stills.

use crate::checker::Checker;
use crate::model::{Analysis, Model, PICTURES, PIXELS};

/// Longest name of a file (characters).
const LONGEST_NAME: usize = 60;

/// Mistakes in the values of stills.
pub(super) fn keys(model: &Model, c: &mut Checker) {
    for (i, still) in model.output.stills.iter().enumerate() {
        let key = format!("output.stills[{i}]");
        let fits = c.file_name(&format!("{key}.file"), &still.file, LONGEST_NAME);
        let stem = still.file.strip_suffix(".png").or(still.file.strip_suffix(".svg"));
        let is_picture = stem.is_some_and(|stem| !stem.is_empty());
        if fits && !is_picture {
            c.add(
                format!("{key}.file"),
                format!("\"{}\" has no ending that names a kind of picture", still.file),
                "give a name that ends with \".png\" or \".svg\"",
            );
        }
        let is_own = PICTURES.contains(&still.file.as_str()) || still.file.starts_with("point_");
        if is_own && still.file.ends_with(".png") {
            c.add(
                format!("{key}.file"),
                format!("\"{}\" is the name of a picture that the program draws by itself", still.file),
                "give the still another name",
            );
        }
        if model.output.stills[..i].iter().any(|other| other.file == still.file) {
            let message = format!("two stills have the file \"{}\"", still.file);
            c.add(format!("{key}.file"), message, "give each still a file of its own");
        }
        if still.at.is_some() && still.mode.is_some() {
            c.add(key.as_str(), "`at` and `mode` are both given", "keep one of them");
        }
        let is_modal = matches!(model.analysis, Analysis::Modal(_) | Analysis::Buckling(_));
        let idle = if is_modal { still.at.map(|_| "at") } else { still.mode.map(|_| "mode") };
        if let Some(idle) = idle.filter(|_| model.steps.is_empty()) {
            let what = if is_modal { "modes, and no states" } else { "states, and no modes" };
            c.add(format!("{key}.{idle}"), format!("the analysis has {what}"), "leave it out");
        }
        if still.mode == Some(0) {
            c.add(format!("{key}.mode"), "there is no mode 0", "modes are counted from 1");
        }
        c.finite(&format!("{key}.view"), "the view", &still.view);
        still.at.iter().for_each(|at| c.finite(&format!("{key}.at"), "the state", &[*at]));
        still.scale.iter().for_each(|scale| c.finite(&format!("{key}.scale"), "the scale", &[*scale]));
        if still.range.is_some_and(|[low, high]| !(low < high && (high - low).is_finite())) {
            c.add(
                format!("{key}.range"),
                "the first value is not below the second one",
                "give the values at both ends of the colours",
            );
        }
        let [fewest, most] = PIXELS;
        if still.size.iter().any(|side| !(fewest..=most).contains(side)) {
            c.add(
                format!("{key}.size"),
                format!("the size is {} × {} pixels", still.size[0], still.size[1]),
                format!("give {fewest} to {most} pixels along each side"),
            );
        }
    }
}
