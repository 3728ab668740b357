//! Stills that a model asks for.

use std::fs;

use super::{SWING, Warnings, options};
use crate::deck::Deck;
use crate::job::run;
use crate::plot::View;
use crate::render::{self, At, Drawing};

/// A run with these stills.
fn swing(stills: &str) -> Result<Deck, String> {
    let text =
        SWING.replace("SCHEME", "newmark").replace("[output]", &format!("[output]\nstills = [{stills}]"));
    let found = Deck::parse("swing.toml", text).map_err(|found| format!("{found:?}"))?;
    crate::job::prepare(&found).map(|_| ()).map_err(|error| error.to_string())?;
    Ok(found)
}

#[test]
fn stills_of_a_model_are_those_that_are_drawn_afterwards() {
    let deck = swing(
        "{ file = \"side.png\", field = \"displacement.z\", view = [-90.0, 0.0], scale = 3.0, range = [-1.0, 1.0], size = [300, 200], at = 0.0 }, \
         { file = \"end.svg\" }, { file = \"lost.png\", field = \"temperature\" }",
    )
    .unwrap();
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path().join("r");
    let mut warnings = Warnings::default();
    run(&deck, &options(&place, false), &mut warnings).unwrap();
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
        render::still(&place, &drawing, &again).unwrap();
        assert!(fs::read(place.join(name)).unwrap() == fs::read(again).unwrap(), "{name}");
    }
    assert!(!place.join("lost.png").exists());
    let told =
        |text: &&String| text.contains("the still \"lost.png\" is missing") && text.contains("temperature");
    assert_eq!(warnings.0.iter().filter(told).count(), 1, "{:?}", warnings.0);
    // The folder is still known as that of a result.
    run(&deck, &options(&place, false), &mut Warnings::default()).unwrap();
}

#[test]
fn stills_that_cannot_be_drawn_are_refused_before_the_run() {
    for (still, message) in [
        ("{ file = \"tip.jpg\" }", "no ending that names a kind of picture"),
        ("{ file = \"../tip.png\" }", "cannot be a name"),
        ("{ file = \"a.png\" }, { file = \"a.png\" }", "two stills have the file"),
        ("{ file = \"a.png\", at = 1.0, mode = 2 }", "`at` and `mode` are both given"),
        ("{ file = \"a.png\", mode = 0 }", "0 is out of range"),
        ("{ file = \"a.png\", range = [1.0, 1.0] }", "not below the second"),
        ("{ file = \"a.png\", size = [100, 4097] }", "100 × 4097 pixels"),
        ("{ file = \"a.png\", view = [nan, 0.0] }", "the view"),
    ] {
        let refused = swing(still).map(|_| ()).unwrap_err();
        assert!(refused.contains(message), "{still}: {refused}");
    }
}
