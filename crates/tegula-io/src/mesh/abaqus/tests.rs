#![allow(clippy::unwrap_used)]

use std::path::Path;

use proptest::prelude::*;
use tegula::{Mesh, Vec3};

use super::Abaqus;
use super::cards::{Card, Reader};
use crate::mesh::{MeshError, MeshReader};

const SQUARE: &str =
    "*NODE\n1, 0, 0, 0\n2, 1, 0, 0\n3, 1, 1, 0\n4, 0, 1, 0\n*ELEMENT, TYPE=S4, ELSET=E\n7, 1, 2, 3, 4\n";

fn parsed(text: &str) -> Result<Mesh, MeshError> {
    Abaqus::parse(Path::new("part.inp"), text.as_bytes(), 1.0)
}

fn read(text: &str) -> Mesh {
    parsed(text).unwrap_or_else(|error| panic!("{error}"))
}

/// Error of a text, as printed.
fn error(text: &str) -> String {
    parsed(text).unwrap_err().to_string()
}

/// Error of the square with further cards.
fn error_behind_square(cards: &str) -> String {
    error(&format!("{SQUARE}{cards}"))
}

fn cards(text: &str) -> Vec<Card<'_>> {
    Reader::new(Path::new("part.inp")).cards(text).unwrap()
}

#[test]
fn keyword_lines_have_parameters_in_any_case_and_continue_behind_commas() {
    let found = cards(
        "** a comment\n\n*Shell  section , elset = Top Side,\n material=\"Steel\" ,\nOFFSET= 0\n0.5 , 3,\n*HEADING\r\n a, title\r\n**x\n",
    );
    let [section, heading] = &found[..] else { panic!("{found:?}") };
    assert_eq!((section.keyword.as_str(), section.line), ("SHELL SECTION", 3));
    let parameters: Vec<(&str, &str)> =
        section.parameters.iter().map(|p| (p.name.as_str(), p.value)).collect();
    assert_eq!(parameters, [("ELSET", "Top Side"), ("MATERIAL", "Steel"), ("OFFSET", "0")]);
    assert_eq!(section.fields().collect::<Vec<_>>(), [(6, "0.5"), (6, "3")]);
    assert_eq!((heading.line, heading.data[0].line, heading.data[0].text), (7, 8, "a, title"));
}

#[test]
fn numbers_may_have_a_fortran_exponent_and_must_be_finite() {
    let reader = Reader::new(Path::new("part.inp"));
    for (text, expected) in [("1.5D-3", 1.5e-3), ("2.d0", 2.0), (".5", 0.5), ("-4", -4.0), ("", 0.0)] {
        assert_eq!(reader.number(1, text).unwrap(), expected, "{text}");
    }
    for text in ["nan", "inf", "1e999", "1,5", "1..2", "0x10", "infinity", "1 2", "e"] {
        assert!(reader.number(3, text).unwrap_err().to_string().starts_with("part.inp:3:"), "{text}");
    }
}

#[test]
fn a_plate_is_read_with_its_sets_and_numbers() {
    let mesh = Abaqus::parse(Path::new("a/part.inp"), Abaqus::example(), 2.0).unwrap();
    assert_eq!(mesh.positions[5], Vec3::new(4.0, 2.0, 0.0));
    assert_eq!(mesh.quads, [[0, 1, 4, 3], [1, 2, 5, 4]]);
    assert_eq!(mesh.node_sets["all nodes"], [0, 1, 2, 3, 4, 5]);
    assert_eq!(mesh.node_sets["left"], [0, 3]);
    assert_eq!(mesh.node_sets["ends"], [0, 2, 3, 5]);
    assert_eq!(mesh.node_sets["12"], [4]);
    assert_eq!(mesh.quad_sets["plate"], [0, 1]);
    let labels = mesh.labels.unwrap();
    assert_eq!(
        (labels.file.as_str(), labels.nodes, labels.quads),
        ("part.inp", vec![1, 2, 3, 11, 12, 13], vec![1, 2])
    );
}

#[test]
fn nodes_of_no_element_are_dropped_also_from_sets() {
    let mesh = read(&format!(
        "*NODE, NSET=N\n900000000000, 5, 5, 5\n{SQUARE}*NSET, NSET=n, ELSET=e\n*NSET, NSET=FAR\n900000000000\n*ELSET, ELSET=F, GENERATE\n1, 10, 3\n"
    ));
    assert_eq!(mesh.positions.len(), 4);
    assert_eq!(mesh.node_sets.keys().collect::<Vec<_>>(), ["N"]);
    assert_eq!(mesh.node_sets["N"], [0, 1, 2, 3]);
    assert_eq!(mesh.quad_sets["F"], [0]);
}

#[test]
fn elements_may_go_over_two_lines() {
    let mesh = read(&SQUARE.replace("7, 1, 2, 3, 4", "7, 1, 2,\n3, 4"));
    assert_eq!(mesh.quads, [[0, 1, 2, 3]]);
}

#[test]
fn ranges_of_any_length_take_no_memory() {
    let mesh = read(&format!("{SQUARE}*NSET, NSET=A, GENERATE\n1, 18446744073709551615, 2\n"));
    assert_eq!(mesh.node_sets["A"], [0, 2]);
    let found = error_behind_square("*NSET, NSET=A, GENERATE\n5, 18446744073709551615\n");
    assert!(
        found.starts_with("part.inp:9: the range from 5 to 18446744073709551615 holds no node"),
        "{found}"
    );
    assert!(error_behind_square("*NSET, NSET=A, GENERATE\n3, 1\n").contains("ends at 1"));
    assert!(
        error_behind_square("*NSET, NSET=A, GENERATE\n1, 3, 0\n")
            .contains("\"0\" is not the number of an increment")
    );
}

#[test]
fn mistakes_name_their_line() {
    for (from, to, message) in [
        ("2, 1, 0, 0", "2, 1, x, 0", "part.inp:3: \"x\" is not a number"),
        ("2, 1, 0, 0", "2, 1, inf, 0", "part.inp:3: \"inf\" is not a number"),
        ("2, 1, 0, 0", "2.5, 1, 0, 0", "part.inp:3: \"2.5\" is not the number of a node"),
        ("2, 1, 0, 0", "1, 1, 0, 0", "part.inp:3: node 1 is defined again; line 2 does so, too"),
        ("2, 1, 0, 0", "2, 1, 0, 0, 1.", "part.inp:3: node 2 has more than three coordinates"),
        (
            "7, 1, 2, 3, 4",
            "7, 1, 2, 3, 5",
            "part.inp:7: element 7 needs node 5, which the file does not define",
        ),
        ("7, 1, 2, 3, 4", "7, 1, 2, 3, 3", "part.inp:7: element 7 has node 3 at two corners"),
        ("7, 1, 2, 3, 4", "7, 1, 2, 3", "part.inp:7: element 7 has 3 nodes"),
        ("7, 1, 2, 3, 4", "7, 1, 2,", "part.inp:7: element 7 has 2 nodes"),
        ("7, 1, 2, 3, 4", "7, 1, 2, 3, 4\n7, 4, 3, 2, 1", "part.inp:8: element 7 is defined again; line 7"),
        ("TYPE=S4,", "TYPE=S8R,", "part.inp:6: elements of type S8R are not read"),
        ("TYPE=S4,", "TYPE=C3D8,", "part.inp:6: elements of type C3D8 are not read"),
        ("TYPE=S4,", "TYPE=,", "part.inp:6: \"TYPE=\" is no parameter"),
        ("TYPE=S4, ", "", "part.inp:6: *ELEMENT has no TYPE"),
        ("TYPE=S4,", "TYPE=S4, TYPE=S4,", "part.inp:6: *ELEMENT has the parameter TYPE twice"),
        ("ELSET=E", "ELSET=12", "part.inp:6: the set \"12\" is called by a number"),
        ("*NODE", "*NODE, INPUT=nodes.txt", "part.inp:1: the parameter INPUT of *NODE is not read"),
        ("*NODE", "1, 2\n*NODE", "part.inp:1: \"1, 2\" stands before the first keyword"),
        ("*NODE", "*, A=B\n*NODE", "part.inp:1: the keyword is missing"),
        ("7, 1, 2, 3, 4\n", "", "part.inp: the file has no shells"),
    ] {
        let found = error(&SQUARE.replacen(from, to, 1));
        assert!(found.starts_with(message), "{found}\nfor {message}");
    }
    for (cards, message) in [
        ("*NSET, NSET=A\n1, 9\n", "part.inp:9: the file has no node 9, which the set names"),
        (
            "*NSET, NSET=A\nB\n",
            "part.inp:9: \"B\" is neither the number of a node nor the name of a set above",
        ),
        ("*ELSET, ELSET=A\n1\n", "part.inp:9: the file has no element 1"),
        ("*NSET\n1\n", "part.inp:8: *NSET has no NSET"),
        ("*NSET, NSET=A, ELSET=B\n", "part.inp:8: there is no element set \"B\" above"),
        ("*NSET, NSET=all\n1\n", "part.inp: the node set \"all\" holds 1 of 4"),
        ("*PART, NAME=P\n", "part.inp:8: *PART: files of parts and instances are not read"),
        ("*INCLUDE, INPUT=x\n", "part.inp:8: *INCLUDE: other files are not included"),
        ("*Contact Pair, INTERACTION=I\n", "part.inp:8: *CONTACT PAIR: there is no contact"),
        ("*SURFACE INTERACTION, NAME=I\n", "part.inp:8: *SURFACE INTERACTION: there is no contact"),
    ] {
        let found = error_behind_square(cards);
        assert!(found.starts_with(message), "{found}\nfor {message}");
    }
}

proptest! {
    #[test]
    fn damaged_files_never_panic(at in 0_usize..400, with in "[*,=0-9a-zA-Z .\n-]{0,12}", cut in 0_usize..20) {
        let example = String::from_utf8(Abaqus::example().to_vec()).unwrap();
        let start = at.min(example.len());
        let end = (start + cut).min(example.len());
        let _ = parsed(&format!("{}{with}{}", &example[..start], &example[end..]));
    }
}
