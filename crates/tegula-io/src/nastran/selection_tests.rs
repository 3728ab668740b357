#![allow(clippy::unwrap_used)]

use std::path::Path;

use super::convert;
use super::tests::{CONTROL, LOAD, SUPPORT, json, mistakes, model, strip};

/// Messages of all warnings.
fn warnings(deck: &str) -> Vec<String> {
    let found = convert(Path::new("strip.bdf"), deck.as_bytes(), "strip.bdf").unwrap();
    found.warnings.into_iter().map(|issue| issue.message).collect()
}

/// Asserts the first message of a deck.
fn refused(deck: &str, message: &str) {
    let found = mistakes(deck).remove(0).1;
    assert!(found.starts_with(message), "{found}\nfor {message}");
}

#[test]
fn the_last_support_command_counts_and_a_subcase_overrides_the_top() {
    let supports = "SPC1,1,123456,1,4\nSPC1,2,123,1,4\n";
    let of = |control: &str| {
        let control = format!("SOL 101\nCEND\n{control}BEGIN BULK\n");
        strip().replace(CONTROL, &control).replace(SUPPORT, supports)
    };
    let second = json(r#"[{"type": "spherical", "on": "SPC 123"}]"#);
    for control in [
        "SPC = 1\nSPC = 2\nLOAD = 2\n",
        "SPC = 1\nLOAD = 2\nSUBCASE 1\nSPC = 2\n",
        "SPC = 1\nLOAD = 2\nSUBCASE 1\nSPC = 2\nSUBCASE 2\nSPC = 2\n",
        "LOAD = 2\nSUBCASE 1\nSPC = 1\nSPC = 2\n",
    ] {
        let deck = of(control);
        assert_eq!(model(&deck)["conditions"], second, "{control}");
        assert!(warnings(&deck)[0].contains("SPC1 (line"), "{control}");
    }
    assert!(
        warnings(&of("SPC = 1\nSPC = 2\nLOAD = 2\n"))[0].contains("the command SPC (line 3)"),
        "{:?}",
        warnings(&of("SPC = 1\nSPC = 2\nLOAD = 2\n"))
    );
    refused(
        &of("SPC = 1\nLOAD = 2\nSUBCASE 1\nSUBCASE 2\nSPC = 2\n"),
        "subcase 2 has other supports than the first one",
    );
}

#[test]
fn the_analysis_of_a_subcase_is_that_of_the_solution_sequence() {
    let of = |solution: &str, control: &str, cards: &str| {
        let control = format!("SOL {solution}\nCEND\nSPC = 1\n{control}BEGIN BULK\n{cards}");
        strip().replace(CONTROL, &control)
    };
    let one = |analysis: &str| format!("LOAD = 2\nANALYSIS = {analysis}\n");
    for (solution, analysis) in [("101", "statics"), ("106", "NLSTATICS"), ("400", "NLSTATIC")] {
        assert_eq!(model(&of(solution, &one(analysis), ""))["analysis"]["type"], "static");
    }
    for (solution, analysis) in [
        ("400", "MODES"),
        ("400", "BUCK"),
        ("400", "STATICS"),
        ("106", "MODES"),
        ("101", "NLSTATIC"),
        ("101", "HEAT"),
    ] {
        let message = format!("ANALYSIS = {analysis} is not read in this solution sequence");
        refused(&of(solution, &one(analysis), ""), &message);
    }
    let buckling = "SUBCASE 1\nANALYSIS = STATICS\nLOAD = 2\nSUBCASE 2\nANALYSIS = BUCK\nMETHOD = 7\n";
    assert_eq!(model(&of("105", buckling, "EIGRL,7,,,3\n"))["analysis"]["type"], "buckling");
    refused(&of("105", &buckling.replace("BUCK", "MODES"), "EIGRL,7,,,3\n"), "ANALYSIS = MODES");
    refused(&of("103", "METHOD = 7\nANALYSIS = BUCK\n", "EIGRL,7,,,3\n"), "ANALYSIS = BUCK");
    refused(&of("103", "METHOD(FLUID) = 7\n", "EIGRL,7,,,3\n"), "METHOD(FLUID) is not read");
    for option in ["STRUCTURE", "struct"] {
        let modes = model(&of("103", &format!("METHOD({option}) = 7\n"), "EIGRL,7,,,3\n"));
        assert_eq!(modes["analysis"]["modes"], serde_json::Value::from(3), "{option}");
    }
}

#[test]
fn parameters_that_change_results_are_not_ignored() {
    let with = |card: &str| strip().replace(LOAD, &format!("{LOAD}{card}\n"));
    assert!(warnings(&with("PARAM,FOLLOWK,YES"))[0].contains("PARAM,FOLLOWK (line 20)"));
    refused(&with("PARAM,FOLLOWK,NO"), "PARAM,FOLLOWK is NO");
    assert_eq!(
        warnings(&with("PARAM,COUPMASS,1\nPARAM,SNORM,20.")),
        [
            "these parameters change results a little in Nastran and have no counterpart here: PARAM,COUPMASS (line 20), PARAM,SNORM (line 21)"
        ]
    );
    let control = "SOL 106\nCEND\nSPC = 1\nLOAD = 2\nSUBCASE 1\nPARAM,LGDISP,1\nSUBCASE 2\nBEGIN BULK\n";
    refused(&strip().replace(CONTROL, control), "PARAM,LGDISP of a subcase is not read");
    let without = strip().replace(CONTROL, &control.replace("LGDISP,1", "POST,-1"));
    assert!(warnings(&without)[0].contains("PARAM,POST (line 6)"));
    let above = control.replace("SUBCASE 1\nPARAM,LGDISP,1\n", "PARAM,LGDISP,1\nSUBCASE 1\n");
    assert_eq!(model(&strip().replace(CONTROL, &above))["steps"][1]["analysis"]["linear"], false);
}

#[test]
fn cards_and_commands_that_no_analysis_uses_are_listed() {
    let more = "SPC1,3,1,2\nSPCADD,5,3\nFORCE,4,3,,1.,1.,0.,0.\nLOAD,6,1.,1.,4\nEIGRL,7,,,3\nNLPARM,8,5\n";
    let deck = format!("{}{more}", strip());
    assert_eq!(
        warnings(&deck),
        [
            "no analysis uses these parts of the input file: EIGRL (line 24), FORCE (line 22), LOAD (line 23), NLPARM (line 25), SPC1 (line 20), SPCADD (line 21)"
        ]
    );
    let commands = deck.replace("LOAD = 2\n", "LOAD = 2\nMETHOD = 7\nNLPARM = 8\n");
    assert!(warnings(&commands)[0].ends_with("the command METHOD (line 6), the command NLPARM (line 7)"));
    let nonlinear = commands.replace("SOL 101", "SOL 106");
    let found = warnings(&nonlinear).concat();
    assert!(found.contains("METHOD (line 6)") && !found.contains("NLPARM"), "{found}");
    // Sets of the selected combinations are used.
    let combined = strip()
        .replace("LOAD = 2", "LOAD = 9")
        .replace("SPC = 1", "SPC = 5")
        .replace(SUPPORT, "SPC1,1,123456,1,4\nSPCADD,5,1\n");
    assert_eq!(warnings(&format!("{combined}LOAD,9,1.,1.,2\n")), Vec::<String>::new());
    let free = warnings(&strip().replace("SPC = 1\n", "")).concat();
    assert!(free.ends_with("SPC1 (line 16); there is no command SPC"), "{free}");
    let many = format!("{}{}", strip(), "FORCE,4,3,,1.,1.,0.,0.\n".repeat(25));
    assert!(warnings(&many)[0].ends_with("38, 39 and 5 more)"), "{:?}", warnings(&many));
}

#[test]
fn supports_of_nodes_without_elements_are_named() {
    let deck = format!("{}GRID,9,,5.,0.,0.,,123\n", strip());
    assert!(
        warnings(&deck)[0].ends_with("the support of node 9 (line 20), as no element has it"),
        "{:?}",
        warnings(&deck)
    );
}

#[test]
fn lists_without_members_are_refused() {
    let loads = |cards: &str| strip().replace(LOAD, cards);
    refused(&loads("PLOAD4,2,11,3.,,,,THRU,20\n"), "the file has no element from 11 to 20");
    refused(&loads("PLOAD2,2,3.,11,THRU,20\n"), "an element of PLOAD2 is missing");
    refused(&loads(&format!("{LOAD}LOAD,9,2.\n")), "a scale factor with its load set of LOAD is missing");
    let supports = strip().replace(SUPPORT, "SPCADD,1,8,9\nSPC1,8,123456,1,4\n");
    refused(&supports, "SPCADD 1 names the set 9, of which there is no SPC or SPC1");
}

#[test]
fn gravity_along_a_vector_of_another_length_is_told() {
    let of = |card: &str| warnings(&strip().replace(LOAD, card));
    assert_eq!(of("GRAV,2,,9.81,0.,0.,-1.\n"), Vec::<String>::new());
    assert_eq!(of("GRAV,2,,9.81,0.,3.,-4.\n"), ["the vector N of GRAV on line 18 has the length 5.000000"]);
}

#[test]
fn text_behind_the_end_of_the_data_has_no_meaning() {
    let deck = format!(
        "{}ENDDATA\nFORCE,2,3\nany text, of, any, kind, at, all, with, many, more, fields\n",
        strip()
    );
    assert_eq!(model(&deck), model(&strip()));
}
