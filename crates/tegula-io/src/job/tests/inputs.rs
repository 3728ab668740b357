//! Input that is refused or doubted, from the model file on.

use std::fs;

use super::super::*;
use super::{SWING, Warnings, options};
use crate::deck::Deck;

/// Issues of the swinging strip with changes, each as `key: message`.
fn refused(changes: &[(&str, &str)]) -> String {
    match prepare(&changed(changes)) {
        Err(JobError::Model(found)) => {
            found.iter().map(|d| format!("{}: {}", d.key, d.message)).collect::<Vec<_>>().join("\n")
        }
        Err(other) => panic!("{other}"),
        Ok(_) => String::new(),
    }
}

fn changed(changes: &[(&str, &str)]) -> Deck {
    let mut text = SWING.replace("SCHEME", "newmark");
    for (from, to) in changes {
        assert!(text.contains(from), "{from}");
        text = text.replace(from, to);
    }
    Deck::parse("swing.toml", text).unwrap()
}

#[test]
fn points_far_off_the_mesh_are_refused() {
    let at = |position: &str| refused(&[("on = \"u_max_v_max\" }]", &format!("at = {position} }}]"))]);
    assert_eq!(at("[1.1, 0.5, 0.0]"), "");
    assert_eq!(
        at("[1.0, 0.5, 7.0]"),
        "output.points[0].at: the point `corner` at (1.0, 0.5, 7.0) is 7.000e0 away from the nearest node 14 at \
         (1.0, 0.5, 0.0), farther than the largest element is wide"
    );
}

#[test]
fn contradicting_conditions_name_component_and_node() {
    let second =
        "[[conditions]]\ntype = \"prescribe\"\non = \"u_min\"\ncomponent = \"y\"\nvalue = 0.1\n[output]";
    assert_eq!(
        refused(&[("[output]", second)]),
        "conditions[1]: it prescribes the y component of the position of node 0, which conditions[0] supports \
         differently, and 2 more component(s)"
    );
}

#[test]
fn directions_normal_to_the_surface_are_named_once_and_at_their_key() {
    let wood = "\
        type = \"orthotropic\"\nyoung = [10e9, 1e9, 1e9]\npoisson = [0.3, 0.3, 0.4]\nshear = [1e9, 1e9, 1e9]\n";
    let isotropic = "type = \"isotropic\"\nyoung = 1e6\npoisson = 0.3\n";
    let layup = |direction: &str| {
        let plies = format!("stacking = \"[0/90]\", material = \"rubber\", ply_thickness = 0.01{direction}");
        let section = format!("layup = {{ {plies} }}\n");
        refused(&[(isotropic, wood), ("material = \"rubber\"\nthickness = 0.02\n", &section)])
    };
    assert_eq!(layup(", direction = [0, 2, 0]"), "");
    assert_eq!(
        layup(", direction = [0, 0, 2]"),
        "sections[0].layup.direction: the direction (0, 0, 2) is normal to the surface in 8 element(s), such as \
         element 0 at (0.1250, 0.1250, 0.0000): it has no projection there to count angles from"
    );
    let vanishing = layup(", direction = [0, 0, 0]");
    assert!(
        vanishing.starts_with("sections[0].layup.direction: ") && !vanishing.contains('\n'),
        "{vanishing}"
    );
    let natural =
        "[[prescribed_strains]]\ntype = \"natural\"\nstrain = [1e-3, 0, 0]\ndirection = [0, 0, 1]\n[output]";
    let found = refused(&[("[output]", natural)]);
    assert!(found.starts_with("prescribed_strains[0].direction: ") && !found.contains('\n'), "{found}");
}

#[test]
fn rubber_in_a_layup_of_resultants_is_refused_for_what_it_is() {
    let isotropic = "type = \"isotropic\"\nyoung = 1e6\npoisson = 0.3\n";
    let rubber = "type = \"neo-hookean\"\nshear = 1e6\nbulk = 1e8\n";
    let layup = "layup = { plies = [{ material = \"rubber\", thickness = 0.02 }] }\n";
    let with = |element: &str| {
        let section = format!("{layup}element = \"{element}\"\n");
        refused(&[(isotropic, rubber), ("material = \"rubber\"\nthickness = 0.02\n", &section)])
    };
    assert_eq!(
        with("mitc4"),
        "sections[0].layup: `mitc4` works with resultants of plane stress and cannot carry the neo-hookean \
         material \"rubber\""
    );
    assert_eq!(with("cm"), "");
}

#[test]
fn sizes_beyond_all_measure_are_told_from_negative_ones() {
    let issue = |size: &str| {
        let Err(JobError::Model(found)) = prepare(&changed(&[("size = [1.0, 0.5]", size)])) else { panic!() };
        found[0].help.clone()
    };
    assert!(issue("size = [1e200, 0.5]").contains("between 1e-60 and 1e60"));
    assert_eq!(issue("size = [-1.0, 0.5]"), "give a positive number");
}

#[test]
fn steps_longer_than_the_analysis_are_refused() {
    assert_eq!(
        refused(&[("end_time = 0.2", "end_time = 0.2\ntime_step = 0.5")]),
        "analysis.time_step: the step 0.5 is longer than the whole analysis of 0.2"
    );
}

#[test]
fn endless_names_are_refused_without_an_echo() {
    let long = "n".repeat(400);
    let found = refused(&[("name = \"corner\"", &format!("name = \"{long}\""))]);
    assert_eq!(
        found,
        "output.points[0].name: the name of the point has 400 characters; at most 60 are taken"
    );
}

#[test]
fn errors_of_a_mesh_file_name_the_file_and_its_numbers() {
    let folder = tempfile::tempdir().unwrap();
    let mesh = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n6\n10 0 0 0\n20 1 0 0\n30 1 1 0\n40 0 1 0\n\
        50 0 0 0\n60 0 1 0\n$EndNodes\n$Elements\n2\n7 3 2 0 1 10 20 30 40\n9 3 2 0 1 30 20 50 60\n$EndElements\n";
    fs::write(folder.path().join("fold.msh"), mesh).unwrap();
    let text = SWING
        .replace("SCHEME", "newmark")
        .replace("type = \"hinge\"\non = \"u_min\"", "type = \"clamp\"\non = \"all\"");
    let (before, after) = text.split_once("[mesh]").unwrap();
    let (_, after) = after.split_once("[materials").unwrap();
    let text = format!("{before}[mesh]\ntype = \"gmsh\"\nfile = \"fold.msh\"\n[materials{after}")
        .replace("u_max_v_max", "all");
    let deck = Deck::parse(folder.path().join("fold.toml"), text).unwrap();
    let Err(JobError::Model(found)) = prepare(&deck) else { panic!("no model error") };
    let fold = found.iter().find(|d| d.key == "mesh.file").unwrap();
    assert_eq!(
        fold.message,
        "fold.msh: elements 7 at (0.5, 0.5, 0.0) and 9 at (0.5, 0.5, 0.0) share the edge of nodes 20 and 30 and lie \
         on one another: the surface is folded back there"
    );
    assert!(fold.line > 0);
}

#[test]
fn amplitudes_without_value_are_named() {
    let with = |expression: &str, prescribed: bool| {
        let mut text = SWING.replace("SCHEME", "newmark").replace(
            "type = \"ramp\"\nend = 0.1",
            &format!("type = \"expression\"\nexpression = \"{expression}\""),
        );
        if prescribed {
            text.push_str("\n[[conditions]]\ntype = \"prescribe\"\non = \"u_max\"\ncomponent = \"z\"\nvalue = 0.01\namplitude = \"pull\"\n");
        }
        match prepare(&Deck::parse("swing.toml", text).unwrap()) {
            Err(JobError::Model(found)) => {
                format!("{}:{}: {}", found[0].line, found[0].key, found[0].message)
            }
            Err(other) => panic!("{other}"),
            Ok(_) => String::new(),
        }
    };
    assert_eq!(with("sqrt(t)", false), "");
    assert_eq!(
        with("sqrt(t)", true),
        "34:amplitudes.pull.expression: the velocity at t = 0 is inf, but a prescribed motion follows this amplitude"
    );
    assert_eq!(with("ln(1-10*t)", false), "34:amplitudes.pull.expression: the value at t = 0.1 is -inf");
    assert_eq!(with("t^2", true), "");
}

#[test]
fn a_gap_that_the_check_does_not_meet_is_named_in_the_run() {
    // Without value in a window shorter than the instants that the check tries.
    let expression = "sqrt((t-0.1001)^2 - 0.00008^2)";
    let text =
        SWING.replace("SCHEME", "newmark").replace("tolerance = 1e-4", "time_step = 0.002002").replace(
            "type = \"ramp\"\nend = 0.1",
            &format!("type = \"expression\"\nexpression = \"{expression}\""),
        );
    let folder = tempfile::tempdir().unwrap();
    let error = run(&Deck::parse("gap.toml", text).unwrap(), &options(folder.path(), false), &mut Unwatched)
        .unwrap_err();
    let message = error.to_string();
    assert!(message.contains("the value of the amplitude \"pull\" is NaN at 1.0"), "{message}");
}

#[test]
fn what_is_most_likely_not_meant_is_said() {
    let warnings = |changes: &[(&str, &str)]| {
        let mut text = SWING.replace("SCHEME", "newmark");
        for (from, to) in changes {
            assert!(text.contains(from), "{from}");
            text = text.replace(from, to);
        }
        let prepared = prepare(&Deck::parse("swing.toml", text).unwrap()).unwrap_or_else(|e| panic!("{e}"));
        prepared.warnings.iter().map(|w| format!("{}: {}", w.key, w.message)).collect::<Vec<_>>().join("\n")
    };
    const MODAL: (&str, &str) = (
        "type = \"transient\"\nend_time = 0.2\ntolerance = 1e-4\nscheme = { type = \"newmark\" }",
        "type = \"modal\"\nmodes = 4",
    );
    assert_eq!(warnings(&[]), "");
    assert_eq!(
        warnings(&[("value = [0.0, 1.0, 0.0]", "value = [0, 0, 0]")]),
        "loads[1].value: the load is zero, whatever its amplitude"
    );
    assert!(warnings(&[MODAL]).starts_with("loads: loads and prescribed values have no effect"));
    assert_eq!(warnings(&[MODAL, ("modes = 4", "modes = 4\nprestressed = true")]), "");
    assert_eq!(warnings(&[("thickness = 0.02", "thickness = 0.02\neas = false\nans_thickness = false")]), "");
    assert_eq!(
        warnings(&[(
            "thickness = 0.02",
            "thickness = 0.02\nelement = \"mitc4\"\neas = false\nans_thickness = false\nthickness_eas = 1"
        )]),
        "sections[0].ans_thickness: `mitc4` has no such remedy to switch off: the key has no effect\n\
         sections[0].thickness_eas: `mitc4` has no such remedy to switch off: the key has no effect"
    );
    assert!(
        warnings(&[("thickness = 0.02", "thickness = 20.0")])
            .contains("the thickness 20 is 57 times the size 3.536e-1")
    );
    let bent = [
        (
            "type = \"plate\"\nsize = [1.0, 0.5]",
            "type = \"cylinder\"\nradius = 0.1\nangles = [0, 90]\nlength = 1.0",
        ),
        ("thickness = 0.02", "thickness = 0.2"),
    ];
    assert!(
        warnings(&bent).contains("the thickness 0.2 is larger than the radius of curvature 1.0"),
        "{}",
        warnings(&bent)
    );
}

#[test]
fn large_strains_are_reported_but_for_rubber() {
    let warnings = |changes: &[(&str, &str)]| {
        let mut text = SWING
            .replace("type = \"transient\"", "type = \"static\"")
            .replace("end_time = 0.2\ntolerance = 1e-4\nscheme = { type = \"SCHEME\" }", "load_steps = 4")
            .replace("type = \"hinge\"", "type = \"clamp\"")
            .replace("type = \"force\"\non = \"u_max_v_max\"", "type = \"edge\"\non = \"u_max\"")
            .replace("value = [0.0, 1.0, 0.0]", "value = [8e3, 0, 0]")
            .replace("type = \"gravity\"\nvalue = [0.0, 0.0, -9.81]", "type = \"pressure\"\nvalue = 1e-3");
        for (from, to) in changes {
            assert!(text.contains(from), "{from}");
            text = text.replace(from, to);
        }
        let deck = Deck::parse("stretch.toml", text).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let mut warnings = Warnings::default();
        run(&deck, &options(folder.path(), false), &mut warnings).unwrap();
        warnings.0.join("\n")
    };
    let one = warnings(&[]);
    assert!(one.starts_with("element ") && one.contains("is strained by") && !one.contains('\n'), "{one}");
    let isotropic = "type = \"isotropic\"\nyoung = 1e6\npoisson = 0.3\n";
    let rubber = "type = \"neo-hookean\"\nshear = 0.4e6\nbulk = 1e8\n";
    let solid = ("material = \"rubber\"", "material = \"rubber\"\nelement = \"cm\"");
    assert_eq!(warnings(&[(isotropic, rubber), solid]), "");
    // Plastic strain stores hardly any energy.
    let metal = "type = \"plastic\"\nyoung = 1e9\npoisson = 0.3\nyield_stress = 0.2e6\nhardening = 0.5e6\n";
    let yielding = warnings(&[(isotropic, metal)]);
    assert!(yielding.starts_with("element ") && yielding.contains("is strained by"), "{yielding}");
}
