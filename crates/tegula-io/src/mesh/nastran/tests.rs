#![allow(clippy::unwrap_used)]

use std::borrow::Cow;
use std::path::Path;

use proptest::prelude::*;
use tegula::{Mesh, Vec3};

use super::Nastran;
use super::cards::{self, Card, without_tabs};
use crate::mesh::numbered::Reader;
use crate::mesh::{MeshError, MeshReader};

const SQUARE: &str =
    "GRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nGRID,3,,1.,1.,0.\nGRID,4,,0.,1.,0.\nCQUAD4,7,1,1,2,3,4\n";

fn parsed(text: &str) -> Result<Mesh, MeshError> {
    Nastran::parse(Path::new("part.bdf"), text.as_bytes(), 1.0)
}

fn read(text: &str) -> Mesh {
    parsed(text).unwrap_or_else(|error| panic!("{error}"))
}

fn cards(text: &str) -> Result<Vec<Card<'_>>, MeshError> {
    cards::cards(&Reader::new(Path::new("part.bdf")), text.lines().enumerate().map(|(i, line)| (i + 1, line)))
}

/// Name and data fields of the only card of a text.
fn fields(text: &str) -> (String, Vec<String>) {
    let cards = cards(text).unwrap_or_else(|error| panic!("{error}"));
    let [card] = &cards[..] else { panic!("{cards:?}") };
    (card.name.clone(), card.fields_from(0).map(|field| field.text.to_owned()).collect())
}

#[test]
fn all_formats_of_fields_give_one_card() {
    let expected = ["1", "", "0.5", "-1.+2", "3.", "", "", "", "9", "10"].map(str::to_owned).to_vec();
    for text in [
        "GRID,1,,0.5,-1.+2,3.,,,,+A\n+A,9,10\n",
        "grid, 1, , 0.5, -1.+2, 3. $ a comment, with commas\n , 9, 10",
        "GRID    1               0.5     -1.+2   3.\n        9       10",
        "GRID    1               0.5     -1.+2   3.                              +A\n$ between\n+A      9       10",
        "GRID*   1                               0.5             -1.+2           *A\n*A      3.\n*       9               10",
        "GRID*,1,,0.5,-1.+2\n*,3.\n,9,10",
        "GRID*   1                               0.5             -1.+2\n*       3.\n+       9       10",
    ] {
        assert_eq!(fields(text), ("GRID".into(), expected.clone()), "{text}");
    }
    // The other half of a large line is missing.
    let short = fields("SPC1*   1               123             5               6\n        7       8");
    assert_eq!(short.1, ["1", "123", "5", "6", "", "", "", "", "7", "8"]);
}

#[test]
fn tabs_reach_to_the_next_field() {
    assert_eq!(without_tabs(Cow::Borrowed("GRID\t1\t\t0.5\n\tx")), "GRID    1               0.5\n        x");
    assert_eq!(
        read(&SQUARE.replace("GRID,1,,0.,0.,0.", "GRID\t1\t\t.25\t0.\t0.")).positions[0],
        Vec3::new(0.25, 0.0, 0.0)
    );
}

#[test]
fn lines_that_belong_nowhere_are_refused() {
    for (text, message) in [
        ("+A,1\n", "part.bdf:1: the line continues no card"),
        ("GRID,1,,0.,0.,0.,,,,+A\n+B,1\n", "part.bdf:2: the line \"B\" does not continue"),
        ("GRID,1,,0.,0.\n  \n,,1.\n", "part.bdf:2: an empty line stands within the card GRID of line 1"),
        (
            "GRID,1,,0.,0.\n\n$ comment\n,,1.\n",
            "part.bdf:2: an empty line stands within the card GRID of line 1",
        ),
        ("SPC1,1,2,3,4,5,6,7,8,9\n", "part.bdf:1: the line has the value \"9\" behind its 8 data fields"),
        ("GRID*,1,,0.,0.,0.\n", "part.bdf:1: the line has the value \"0.\" behind its 4 data fields"),
        ("=,*1\n", "part.bdf:1: \"=\" is not the name of a card"),
        (
            "GRID    1               0.      0.      0.                                      9\n",
            "part.bdf:1: the line goes on behind column 80",
        ),
        (
            "GRÏD    1               0.      0.      0.\n",
            "part.bdf:1: the line has characters that have no columns",
        ),
        (
            "GRID,1,,0.,0.,0.\n+B,1\n",
            "part.bdf:2: the line \"B\" does not continue the one before, which has no",
        ),
        ("GRID,1,,0.,0.,0.\ninclude 'mesh.bdf'\n", "part.bdf:2: INCLUDE is not read"),
        (
            "INCLUDE 'a/very/long/path/of/another/file/of/the/same/model/that/goes/on/and/on/mesh.bdf'\n",
            "part.bdf:1: INCLUDE is not read",
        ),
        ("SOL 101\nCEND\nINCLUDE 'case.bdf'\nBEGIN BULK\n", "part.bdf:3: INCLUDE is not read"),
        ("INCLUDE 'executive.bdf'\nCEND\nBEGIN BULK\n", "part.bdf:1: INCLUDE is not read"),
    ] {
        let found = parsed(text).unwrap_err().to_string();
        assert!(found.starts_with(message), "{found}\nfor {message}");
    }
}

#[test]
fn lists_have_ranges() {
    let known = [1, 2, 4, 7, 9].into();
    let reader = Reader::new(Path::new("part.bdf"));
    let list = |text: &str| cards(text).unwrap()[0].list(&reader, 1, "a node", &known);
    assert_eq!(list("SPCX,1,9,2").unwrap(), [9, 2]);
    assert_eq!(list("SPCX,1,1,THRU,5,,9").unwrap(), [1, 2, 4, 9]);
    assert_eq!(list("SPCX,1,3,thru,8").unwrap(), [4, 7]);
    for text in [
        "SPCX,1",
        "SPCX,1,THRU,5",
        "SPCX,1,1,THRU",
        "SPCX,1,5,THRU,1",
        "SPCX,1,1,THRU,5,EXCEPT,2",
        "SPCX,1,2.",
        "SPCX,1,-2",
    ] {
        assert!(list(text).is_err(), "{text}");
    }
}

#[test]
fn bare_continuations_continue_the_line_before() {
    for text in
        ["GRID,1,,,,,,,,+A\n+,9", "GRID,1,,,,,,,,+A\n,9", "GRID,1,,,,,,,,+\n+,9", "GRID,1,,,,,,,,+a\n+A,9"]
    {
        assert_eq!(fields(text).1.len(), 9, "{text}");
    }
}

#[test]
fn a_missing_field_is_told_with_its_line() {
    let reader = Reader::new(Path::new("part.bdf"));
    let help = |text: &str, index| cards(text).unwrap()[0].id(&reader, index, "x").unwrap_err().to_string();
    assert!(help("PCOMP,1", 2).contains("fill field 4"), "{}", help("PCOMP,1", 2));
    assert!(!help("PCOMP,1", 2).contains("of line"));
    assert!(help("PCOMP,1\n,,,1", 9).contains("fill field 3 of line 2 of the card"));
}

#[test]
fn the_last_command_of_the_first_subcase_selects_the_supports() {
    let sets = |control: &str| {
        let text = format!("SOL 101\nCEND\n{control}BEGIN BULK\n{SQUARE}SPC1,1,123,1\nSPC1,2,123456,2\n");
        read(&text).node_sets.into_keys().collect::<Vec<_>>()
    };
    assert_eq!(sets("SPC = 1\n"), ["SPC 123"]);
    assert_eq!(sets("SPC = 1\nSPC = 2\n"), ["SPC 123456"]);
    assert_eq!(sets("SPC = 1\nSUBCASE 1\nSPC = 2\n"), ["SPC 123456"]);
    assert_eq!(sets("SPC = 1\nSUBC 1\nLOAD = 3\nSUBCASE 2\nSPC = 2\n"), ["SPC 123"]);
}

#[test]
fn the_example_is_read_with_its_numbers_and_sets() {
    let mesh = Nastran::parse(Path::new("a/part.bdf"), Nastran::example(), 2.0).unwrap();
    assert_eq!(mesh.positions[2], Vec3::new(4.0, 0.0, 0.0));
    assert_eq!(mesh.positions[5], Vec3::new(4.0, 2.0, 0.0));
    assert_eq!(mesh.quads, [[0, 1, 4, 3], [1, 2, 5, 4]]);
    assert_eq!(mesh.quad_sets["property 7"], [0, 1]);
    assert_eq!(mesh.node_sets["SPC 123456"], [0, 3]);
    let labels = mesh.labels.unwrap();
    assert_eq!((labels.nodes, labels.quads), (vec![1, 2, 3, 11, 12, 13], vec![1, 2]));
}

#[test]
fn a_mesh_skips_the_cards_of_the_model_also_with_mistakes() {
    let mesh =
        read(&format!("{SQUARE}SPC1,1,9,99\nFORCE,x\nPLOAD4,1\nRBE2,1\nMAT9,1\nCBAR,9,1,1,2\nMPC,1\n"));
    assert_eq!((mesh.positions.len(), mesh.quads.len()), (4, 1));
}

#[test]
fn mistakes_name_their_line() {
    for (from, to, message) in [
        (
            "GRID,2,,1.,0.,0.",
            "GRID,2,,1,0.,0.",
            "part.bdf:2: a coordinate of GRID is \"1\", which is no real number",
        ),
        ("GRID,2,,1.,0.,0.", "GRID,2.,,1.,0.,0.", "part.bdf:2: the number of GRID is \"2.\""),
        ("GRID,2,,1.,0.,0.", "GRID,1,,1.,0.,0.", "part.bdf:2: node 1 is defined again; line 1 does so, too"),
        ("GRID,2,,1.,0.,0.", "GRID,2,5,1.,0.,0.", "part.bdf:2: the coordinate system CP of node 2 is 5"),
        ("GRID,2,,1.,0.,0.", "GRID,2,,1.,0.,0.,5", "part.bdf:2: the coordinate system CD of node 2 is 5"),
        ("7,1,1,2,3,4", "7,1,1,2,3,5", "part.bdf:5: element 7 needs node 5"),
        ("7,1,1,2,3,4", "7,1,1,2,3,3", "part.bdf:5: element 7 has node 3 at two corners"),
        ("7,1,1,2,3,4", "7,1,1,2,3", "part.bdf:5: a node of CQUAD4 is missing"),
        ("7,1,1,2,3,4", "7,1,1,2,3,4,,0.1", "part.bdf:5: the offset ZOFFS of CQUAD4 is 0.1"),
        ("7,1,1,2,3,4", "7,1,1,2,3,4\n,,,0.1", "part.bdf:6: the thickness T1 of element 7 is 0.1"),
        ("7,1,1,2,3,4", "7,1,1,2,3,4\nCQUAD4,7,1,4,3,2,1", "part.bdf:6: element 7 is defined again; line 5"),
        ("CQUAD4", "CTRIA3", "part.bdf:5: CTRIA3 is not read"),
        ("CQUAD4", "GRDSET", "part.bdf:5: GRDSET is not read"),
    ] {
        let found = parsed(&SQUARE.replacen(from, to, 1)).unwrap_err().to_string();
        assert!(found.starts_with(message), "{found}\nfor {message}");
    }
    let behind = format!("SOL 101\nCEND\nBEGIN BULK\n{SQUARE}ENDDATA\n\n$ comment\nGRID,9\n");
    assert_eq!(read(&behind).positions.len(), 4);
    let open = format!("SOL 101\nBEGIN BULK\n{SQUARE}");
    assert!(parsed(&open).unwrap_err().to_string().starts_with("part.bdf:2: there is no CEND"));
}

proptest! {
    #[test]
    fn damaged_files_never_panic(at in 0_usize..500, with in "[*+,=0-9a-zA-Z .$\t\n-]{0,12}", cut in 0_usize..20) {
        let example = String::from_utf8(Nastran::example().to_vec()).unwrap();
        let start = at.min(example.len());
        let end = (start + cut).min(example.len());
        let _ = parsed(&format!("{}{with}{}", &example[..start], &example[end..]));
    }

    #[test]
    fn bytes_of_any_kind_never_panic(bytes in proptest::collection::vec(any::<u8>(), 0..200)) {
        let _ = Nastran::parse(Path::new("part.bdf"), &bytes, 1.0);
    }
}
