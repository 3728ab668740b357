//! Stills that a model asks for.

use std::fs;
use std::path::Path;

use super::{At, Drawing, still, stills};
use crate::deck::Deck;
use crate::job::{self, JobObserver, JobOptions};
use crate::plot::View;

/// Cantilever in four load steps.
const MODEL: &str = include_str!("../../templates/static.toml");

/// Collects warnings.
#[derive(Default)]
struct Warnings(Vec<String>);

impl JobObserver for Warnings {
    fn on_warning(&mut self, message: &str) {
        self.0.push(message.to_owned());
    }
}

/// Runs a model in a folder, and draws its stills; returns the warnings.
fn run(deck: &Deck, folder: &Path) -> Vec<String> {
    let mut warnings = Warnings::default();
    let options = JobOptions { folder: folder.to_owned(), resume: false, force: false };
    let outcome = job::run(deck, &options, &mut warnings);
    stills(deck, folder, &outcome, &mut warnings);
    outcome.unwrap();
    warnings.0
}

/// A model with these stills.
fn with(stills: &str) -> Result<Deck, String> {
    let text = MODEL.replace("[output]", &format!("[output]\nstills = [{stills}]"));
    let found = Deck::parse("cantilever.toml", text).map_err(|found| format!("{found:?}"))?;
    job::prepare(&found).map(|_| ()).map_err(|error| error.to_string())?;
    Ok(found)
}

#[test]
fn stills_of_a_model_are_those_that_are_drawn_afterwards() {
    let deck = with(
        "{ file = \"side.png\", field = \"displacement.z\", view = [-90.0, 0.0], scale = 3.0, range = [-1.0, 1.0], size = [300, 200], at = 0.0 }, \
         { file = \"end.svg\" }, { file = \"lost.png\", field = \"temperature\" }",
    )
    .unwrap();
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path().join("r");
    let warnings = run(&deck, &place);
    let side = Drawing {
        field: Some("displacement.z".into()),
        at: At::Value(0.0),
        view: View { azimuth_deg: -90.0, elevation_deg: 0.0 },
        scale: Some(3.0),
        range: Some([-1.0, 1.0]),
        size: (300, 200),
    };
    for (drawing, name) in [(side, "side.png"), (Drawing::default(), "end.svg")] {
        let again = folder.path().join(name);
        still(&place, &drawing, &again).unwrap();
        assert!(fs::read(place.join(name)).unwrap() == fs::read(again).unwrap(), "{name}");
    }
    assert!(!place.join("lost.png").exists());
    let told =
        |text: &&String| text.contains("the still \"lost.png\" is missing") && text.contains("temperature");
    assert_eq!(warnings.iter().filter(told).count(), 1, "{warnings:?}");
    // A run of the same model takes its earlier stills away at its start.
    let Deck { model, .. } = &deck;
    assert_eq!(model.output.stills.len(), 3);
    let fewer = Deck {
        model: tegula::Model {
            output: tegula::model::Output { stills: Vec::new(), ..model.output.clone() },
            ..model.clone()
        },
        ..deck.clone()
    };
    let options = JobOptions { folder: place.clone(), resume: false, force: true };
    job::run(&fewer, &options, &mut Warnings::default()).unwrap();
    assert!(!place.join("side.png").exists() && !place.join("end.svg").exists());
}

#[test]
fn stills_that_cannot_be_drawn_are_refused_before_the_run() {
    for (still, message) in [
        ("{ file = \"tip.jpg\" }", "no ending that names a kind of picture"),
        ("{ file = \"../tip.png\" }", "cannot be a name"),
        ("{ file = \"a.png\" }, { file = \"a.png\" }", "two stills have the file"),
        ("{ file = \"a.png\", at = 1.0, mode = 2 }", "`at` and `mode` are both given"),
        ("{ file = \"a.png\", mode = 0 }", "0 is out of range"),
        ("{ file = \"a.png\", mode = 2 }", "the analysis has states, and no modes"),
        ("{ file = \"energy.png\" }", "a picture that the program draws by itself"),
        ("{ file = \".png\" }", "no ending that names a kind of picture"),
        ("{ file = \"a.png\", range = [1.0, 1.0] }", "not below the second"),
        ("{ file = \"a.png\", size = [100, 4097] }", "100 × 4097 pixels"),
        ("{ file = \"a.png\", view = [nan, 0.0] }", "the view"),
    ] {
        let refused = with(still).map(|_| ()).unwrap_err();
        assert!(refused.contains(message), "{still}: {refused}");
    }
}
