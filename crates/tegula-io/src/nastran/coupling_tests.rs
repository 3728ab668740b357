#![allow(clippy::unwrap_used)]

use std::path::Path;

use tegula::Vec3;

use super::convert;
use super::tests::{LOAD, SECTION, SUPPORT, json, mistakes, model, strip};
use crate::solved::Solved;

/// The strip, thin, with an `RBE3` of the weights 1 and 3 of the nodes 3 and 6 at its end.
fn coupled(card: &str, at: &str, loads: &str) -> String {
    let more = format!("GRID,9,,2.,{at},0.\n{card}{loads}");
    strip().replace(SECTION, "PSHELL,3,4,.02,4,,4\n").replace(LOAD, &more)
}

const CARD: &str = "RBE3,5,,9,123456,1.,123,3,3.\n,123,6\n";
const FORCE: &str = "FORCE,2,9,,.04,0.,0.,1.\n";

#[test]
fn weights_of_nodes_are_those_of_a_distributing_coupling() {
    let found = model(&coupled(CARD, ".75", FORCE));
    let body = &found["bodies"][0];
    assert_eq!((&body["name"], &body["at"]), (&"RBE3 5".into(), &json("[2.0, 0.75, 0.0]")));
    assert_eq!(body["distributed"], json(r#"["nodes of RBE3 5 no 1", "nodes of RBE3 5 no 2"]"#));
    assert_eq!((&body["weights"], &found["loads"][0]["on"]), (&json("[1.0, 3.0]"), &"RBE3 5".into()));
    let one = model(&coupled("RBE3,5,,9,123,2.,123,3,6\n", ".5", FORCE));
    let body = &one["bodies"][0];
    assert_eq!((&body["distributed"], &body["weights"]), (&json(r#"["nodes of RBE3 5"]"#), &json("[2.0]")));
    let held = model(&coupled(CARD, ".75", FORCE).replace(SUPPORT, "SPC1,1,123456,1,4\nSPC1,1,2,9\n"));
    assert_eq!(
        (&held["joints"][0]["type"], &held["joints"][0]["between"][1]),
        (&"driven-length".into(), &"RBE3 5".into())
    );
}

/// A force at the weighted mean is F/4 and 3F/4 on the nodes, and the reference node moves by (u₃ + 3 u₆)/4. In the middle of the nodes the same force is F/2
/// on each, whatever the weights: two forces have its moment.
#[test]
fn two_unequal_weights_share_a_force_as_by_hand() {
    let corners = |solved: &Solved| [0.0, 1.0].map(|y| solved.at(Vec3::new(2.0, y, 0.0)));
    let forces = |first: f64, second: f64| {
        let loads = format!("FORCE,2,3,,{first:?},0.,0.,1.\nFORCE,2,6,,{second:?},0.,0.,1.\n");
        corners(&Solved::new(
            &coupled("", "0.", &loads)
                .replace("SOL 101", "SOL 106")
                .replace("BEGIN BULK\n", "BEGIN BULK\nPARAM,LGDISP,1\n"),
        ))
    };
    for (at, [first, second], tolerance) in [(".75", [0.01, 0.03], 1e-7), (".5", [0.02, 0.02], 1e-3)] {
        let solved = Solved::new(&coupled(CARD, at, FORCE));
        let found = corners(&solved);
        for (found, expected) in found.iter().zip(forces(first, second)) {
            assert!((found - expected).norm() < tolerance * expected.norm(), "{at}: {found} {expected}");
        }
        let [u3, u6] = found;
        // The arm from the weighted mean turns with the line through both nodes.
        let arm = (u6 - u3) * (at.parse::<f64>().unwrap() - 0.75);
        let expected = (u3 + u6 * 3.0) / 4.0 + arm;
        let moved = solved.moved("RBE3 5");
        assert!((moved - expected).norm() < 1e-3 * moved.norm(), "{at}: {moved} {expected}");
    }
}

#[test]
fn rotations_of_weighted_nodes_are_told() {
    let deck = coupled(&CARD.replace("1.,123,3", "1.,123456,3"), ".75", FORCE);
    let warnings = convert(Path::new("strip.bdf"), deck.as_bytes(), "strip.bdf").unwrap().warnings;
    for part in [
        "the components 456 of the nodes of RBE3 5 (line 19), whose rotations have the weight h²/12",
        "small displacements of SOL 101 (line 1), which may have any size here, as the model has RBE3 5 (line 19)",
    ] {
        assert!(warnings[0].message.contains(part), "{}", warnings[0].message);
    }
}

#[test]
fn interpolation_elements_that_have_no_counterpart_are_refused() {
    let deck = coupled(CARD, ".75", FORCE);
    for (from, to, message) in [
        ("9,123456,1.", "9,12346,1.", "REFC of RBE3 5 is \"12346\""),
        ("1.,123,3", "1.,12,3", "C of RBE3 5 is \"12\""),
        (",123,6\n", ",123,6,UM,3,3\n", "UM of RBE3 5 is not read"),
        (",123,6\n", ",123,6,ALPHA,1.-5\n", "ALPHA of RBE3 5 is not read"),
        (",123,6\n", ",123,6,4.,123\n", "the weight 4 of RBE3 5 has no nodes"),
        (",123,6\n", ",123,66\n", "RBE3 5 needs node 66"),
        (",123,6\n", ",123,9\n", "node 9 of RBE3 5 belongs to no shell"),
        (",123,6\n", ",123,6,5.\n", "C of RBE3 5 is \"\""),
        ("1.,123,3", "0.,123,3", "a weight of RBE3 5 is 0"),
        ("1.,123,3,3.", "3,6,,", "the weight WT1 of RBE3 is missing"),
        ("RBE3,5,,9,", "RBE3,5,,6,", "the reference node 6 of RBE3 5 belongs to a shell"),
        ("RBE3,5,,9,", "RBE3,5,,99,", "RBE3 5 needs node 99"),
        ("RBE3,5,,9,", "RBE3,5,7,9,", "field 3 of RBE3 is 7"),
        (
            CARD,
            &format!("{CARD}RBE2,5,9,123456,5\n"),
            "RBE3 5 has the same number or the same node as RBE2 5",
        ),
        (
            "RBE3,5,,9,123456",
            "MOMENT,2,9,,1.,1.,0.,0.\nRBE3,5,,9,123",
            "a moment acts on node 9, which follows displacements alone by REFC of RBE3 5",
        ),
    ] {
        let changed = deck.replacen(from, to, 1);
        assert_ne!(changed, deck, "{from}");
        let found = mistakes(&changed).remove(0).1;
        assert!(found.starts_with(message), "{found}\nfor {message}");
    }
    let turned = coupled("RBE3,5,,9,123,1.,123,3,6\n", ".5", FORCE)
        .replace(SUPPORT, "SPC1,1,123456,1,4\nSPC1,1,4,9\n");
    assert!(mistakes(&turned)[0].1.starts_with("a rotation is supported of node 9"));
}
