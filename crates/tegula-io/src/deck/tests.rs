#![allow(clippy::unwrap_used)]

mod editor;
mod marker_keys;
mod marker_mistakes;
mod markers;
mod messages;
mod scheme_default;
mod syntax;

use std::path::Path;

use proptest::prelude::*;
use tegula::Issue;

use super::schema::{Table, Wanted, wanted};
use super::{Deck, Diagnostic, template, template_companions, template_kinds};

const MODEL: &str = r#"title = "t"
[analysis]
type = "static"
load_steps = 4
[mesh]
type = "plate"
size = [10, 1.0]
[mesh.grid]
elements = [16, 2]
[materials.steel]
type = "isotropic"
young = 210e9
poisson = 0.3
[[sections]]
material = "steel"
thickness = 0.1
[[conditions]]
type = "fix"
on = "u_min"
position = ["x"]
[[loads]]
type = "edge"
on = "u_max"
value = [0, 0, 4e4]
[output]
interval = 0.1
"#;

fn parse(text: &str) -> Result<Deck, Vec<Diagnostic>> {
    Deck::parse("m.toml", text)
}

/// All diagnostics as printed.
fn errors(text: &str) -> String {
    match parse(text) {
        Ok(_) => String::new(),
        Err(found) => found.iter().map(|d| format!("{d}\n")).collect(),
    }
}

/// Diagnostics of the model with `from` replaced.
fn with(from: &str, to: &str) -> String {
    assert!(MODEL.contains(from), "{from}");
    errors(&MODEL.replacen(from, to, 1))
}

#[test]
fn a_model_is_read() {
    let deck = parse(MODEL).unwrap();
    assert_eq!((deck.model.title.as_str(), deck.model.sections[0].thickness), ("t", 0.1));
    assert_eq!(Deck::parse("a/m.toml", MODEL).unwrap().beside("b.msh"), Path::new("a/b.msh"));
    assert_eq!(deck.beside("b.msh"), Path::new("b.msh"));
    // What a spreadsheet or an editor under Windows writes.
    assert_eq!(parse(&MODEL.replace('\n', "\r\n")).unwrap().model, deck.model);
    assert_eq!(parse(&format!("\u{feff}{MODEL}")).unwrap().model, deck.model);
}

#[test]
fn the_greatest_integers_pass() {
    let seed = |n: &str| parse(&MODEL.replace("[16, 2]", &format!("[0x10, 2]\nseed = {n}")));
    assert!(seed("9223372036854775807").is_ok());
    assert!(seed("18446744073709551615").is_ok());
    assert!(seed("18446744073709551616").is_err());
}

#[test]
fn all_errors_come_at_once_in_the_order_of_the_text() {
    let text = MODEL
        .replace("load_steps", "load_stepz")
        .replace("poisson = 0.3", "poisson = \"0.3\"")
        .replace("\"edge\"", "\"egde\"")
        .replace("thickness = 0.1\n", "");
    insta::assert_snapshot!(errors(&text), @r#"
    m.toml:4:1: analysis.load_stepz: unknown key "load_stepz"
      help: did you mean "load_steps"?
    m.toml:13:11: materials.steel.poisson: expected a number, found the string "0.3"
      help: write it without quotes: 0.3
    m.toml:14:1: sections[0]: missing key "thickness", or it is 0
      help: add "thickness", a number above 0: Thickness h (length)
    m.toml:21:8: loads[0].type: unknown type "egde"
      help: did you mean "edge"? (one of "force", "moment", "follower-force", "follower-moment", "edge", "edge-moment", "traction", "pressure", "gravity", "centrifugal")
    "#);
}

#[test]
fn spans_and_columns_count_characters() {
    let found = parse("\u{feff}title = \"ä\" \nmodes = 3").unwrap_err();
    let modes = found.iter().find(|d| d.message.starts_with("unknown")).unwrap();
    assert_eq!((modes.line, modes.column, modes.span.clone()), (2, 1, 17..22));
    let title = &parse("title = [\"ä\", 3]").unwrap_err()[0];
    assert_eq!((title.line, title.column), (1, 1));
    let syntax = &parse("\u{feff}a = \"ä\" x").unwrap_err()[0];
    assert_eq!((syntax.line, syntax.column), (1, 9));
}

#[test]
fn issues_are_placed_in_the_text() {
    let text = MODEL.replace("[materials.steel]", "[materials.\"my.steel[1]\"]");
    let deck = parse(&text).unwrap();
    let place = |key: &str| {
        let found = deck.locate(&[Issue::new(key, "message", "help")]);
        (found[0].line, found[0].column, &text[found[0].span.clone()])
    };
    assert_eq!(place("loads[0].on"), (23, 6, "\"u_max\""));
    assert_eq!(place("loads[0].value[2]"), (24, 16, "4e4"));
    assert_eq!(place("loads[0].amplitude"), (21, 1, "[[loads]]"));
    assert_eq!(place("loads[0]"), (21, 1, "[[loads]]"));
    assert_eq!(place("loads[7].on"), (21, 1, "[[loads]]"));
    assert_eq!(place("mesh.grid.elements"), (9, 12, "[16, 2]"));
    assert_eq!(place("mesh.grid.grading"), (8, 1, "[mesh.grid]"));
    assert_eq!(place("materials.my.steel[1].young"), (12, 9, "210e9"));
    assert_eq!(place("materials.\"my.steel[1]\".young"), (12, 9, "210e9"));
    assert_eq!(place("damping.mass"), (1, 1, ""));
    assert_eq!(place(""), (1, 1, ""));
    assert_eq!(place("]x[.."), (1, 1, ""));
    let printed = deck.locate(&[Issue::new("loads[0].on", "no set \"u_max\"", "sets are a, b")]);
    assert_eq!(printed[0].to_string(), "m.toml:23:6: loads[0].on: no set \"u_max\"\n  help: sets are a, b");
}

#[test]
fn keys_are_found_by_their_place() {
    let (tree, _) = toml::de::DeTable::parse_recoverable(MODEL);
    let key = |text: &str| super::locate::key_at(tree.get_ref(), MODEL.find(text).unwrap());
    assert_eq!(key("210e9"), "materials.steel.young");
    assert_eq!(key("poisson"), "materials.steel.poisson");
    assert_eq!(key("4e4"), "loads[0].value[2]");
    assert_eq!(key("\n"), "");
}

#[test]
fn files_that_cannot_be_read() {
    let directory = tempfile::tempdir().unwrap();
    let path = |name: &str| directory.path().join(name);
    let message = |name: &str, bytes: Option<&[u8]>| {
        if let Some(bytes) = bytes {
            std::fs::write(path(name), bytes).unwrap();
        }
        let found = Deck::read(path(name)).unwrap_err();
        assert_eq!(found.len(), 1);
        found[0].to_string().replace(&path(name).display().to_string(), "FILE")
    };
    insta::assert_snapshot!(message("missing.toml", None), @r"
    FILE: there is no such file
      help: check the path, or begin with a new model: tegula new static
    ");
    insta::assert_snapshot!(message("", None), @r"
    FILE: this is a directory, not a model file
      help: give the path of the model file in it, such as model.toml
    ");
    insta::assert_snapshot!(message("empty.toml", Some(b" \n")), @r"
    FILE: the file is empty
      help: begin with a new model: tegula new static
    ");
    insta::assert_snapshot!(message("latin.toml", Some(b"title = \"t\"\n# \xe4")), @r"
    FILE:2:3: the file is not UTF-8 text from here on
      help: save it with the encoding UTF-8
    ");
    insta::assert_snapshot!(message("zero.toml", Some(b"title = \"t\0\"")), @r"
    FILE:1:11: the file holds a zero byte here: it is damaged, or no text
      help: remove the byte, or save the file as plain UTF-8 text
    ");
    std::fs::write(path("good.toml"), MODEL).unwrap();
    assert_eq!(Deck::read(path("good.toml")).unwrap().model, parse(MODEL).unwrap().model);
}

#[test]
fn templates_are_complete_models() {
    for kind in template_kinds() {
        let text = template(kind).unwrap();
        assert_eq!(errors(text), "", "{kind}");
        assert!(text.lines().all(|line| line.chars().count() <= 110), "{kind}");
    }
    assert_eq!(template("other"), None);
}

#[test]
fn keys_in_the_comments_of_templates_exist() {
    for kind in template_kinds() {
        let uncomment = |line: &str| {
            let bare = line.strip_prefix("# ").filter(|bare| !bare.contains("..")).unwrap_or(line);
            let key = bare.split(" = ").next().unwrap_or_default();
            let is_key = bare.contains(" = ") && key.chars().all(|c| c.is_ascii_lowercase() || c == '_');
            if is_key || bare.starts_with("[[") { format!("{bare}\n") } else { format!("{line}\n") }
        };
        let text: String = template(kind).unwrap().lines().map(uncomment).collect();
        assert!(text.len() < template(kind).unwrap().len());
        assert_eq!(errors(&text), "", "{kind}");
    }
}

#[test]
fn the_gmsh_template_fits_its_mesh() {
    let deck = parse(template("gmsh").unwrap()).unwrap();
    let directory = tempfile::tempdir().unwrap();
    for (name, content) in template_companions("gmsh") {
        std::fs::write(directory.path().join(name), content).unwrap();
    }
    let tegula::model::MeshSource::Gmsh(source) = &deck.model.mesh else { panic!("{:?}", deck.model.mesh) };
    let mesh = crate::mesh::gmsh::read(&directory.path().join(&source.file), source.scale).unwrap();
    assert_eq!(mesh.quads.len(), 128);
    assert!(deck.model.sections.iter().all(|section| mesh.quad_sets.contains_key(&section.on)));
    assert!(["left", "right"].iter().all(|&edge| mesh.edge_sets[edge].len() == 8));
    assert_eq!(mesh.node_sets["corner"].len(), 1);
}

#[test]
fn what_is_written_is_read_back() {
    for kind in template_kinds() {
        let model = parse(template(kind).unwrap()).unwrap().model;
        assert_eq!(parse(&toml::to_string(&model).unwrap()).unwrap().model, model);
    }
}

/// Every part of the model's schema is one that the validator knows.
#[test]
fn nothing_of_the_schema_is_left_to_the_typed_reader() {
    fn walk(root: &serde_json::Value, schema: &serde_json::Value, path: &str) -> usize {
        let inside = |table: &Table<'_>| {
            table.keys().map(|key| walk(root, table.get(key).unwrap(), &format!("{path}.{key}"))).sum()
        };
        1 + match wanted(root, schema) {
            Wanted::Table(table) | Wanted::StringOrTable(table) => inside(&table),
            Wanted::Tagged(branches) => branches.iter().map(|(_, table)| inside(table)).sum::<usize>(),
            Wanted::Named(items) | Wanted::List(items, ..) => walk(root, items, path),
            Wanted::Anything => panic!("{path}: {schema}"),
            _ => 0,
        }
    }
    let root = super::schema::schema();
    assert!(walk(&root, &root, "") > 100);
}

/// Diagnostics must lie in the text, whatever it is.
fn check(text: &str) -> Result<(), TestCaseError> {
    match parse(text) {
        Ok(deck) => {
            deck.locate(&[Issue::new("materials.steel.young", "", ""), Issue::new(text, "", "")]);
        }
        Err(found) => {
            prop_assert!(!found.is_empty());
            for d in found {
                prop_assert!(text.get(d.span.clone()).is_some(), "{d:?}");
                prop_assert!(!d.message.is_empty());
                prop_assert!(d.help != super::UNEXPECTED, "{d}");
            }
        }
    }
    Ok(())
}

proptest! {
    #[test]
    fn no_text_panics(text in "\\PC{0,80}", toml in "([a-c\\[\\]{}.=,\"'#\n0-9e_-]|type|mesh|loads){0,40}") {
        check(&text)?;
        check(&toml)?;
    }

    #[test]
    fn no_change_of_a_template_panics(
        kind in 0..4usize,
        changes in proptest::collection::vec((any::<prop::sample::Index>(), 0..40usize, "[a-z\\[\\]{}=.,\"0-9\né]{0,4}"), 1..5),
    ) {
        let mut text = template(template_kinds()[kind]).unwrap().to_owned();
        for (place, removed, inserted) in changes {
            let bytes: Vec<char> = text.chars().collect();
            let start = place.index(bytes.len() + 1);
            let end = (start + removed).min(bytes.len());
            text = bytes[..start].iter().chain(&inserted.chars().collect::<Vec<_>>()).chain(&bytes[end..]).collect();
        }
        check(&text)?;
    }
}

#[test]
fn wrong_keys_do_not_hide_wrong_values() {
    let text = template("static").unwrap().replace("\nthickness", "\nthickness = 0.01\ntickness");
    let text = text.replace("on = \"u_min\"", "on = \"no-such-set\"");
    let found = Deck::parse("model.toml", text).unwrap_err();
    let all: Vec<String> = found.iter().map(|d| format!("{}: {}", d.key, d.message)).collect();
    assert!(all.iter().any(|m| m.contains("unknown key \"tickness\"")), "{all:#?}");
    assert!(all.iter().any(|m| m.contains("no-such-set")), "{all:#?}");
}

#[test]
fn wrong_values_do_not_hide_others() {
    let text = template("static").unwrap().replace("load_steps = 4", "load_steps = \"four\"");
    let text =
        text.replace("poisson = 0.3", "poisson = 0.7").replace("on = \"u_min\"", "on = \"no-such-set\"");
    let found = Deck::parse("model.toml", text).unwrap_err();
    let keys: Vec<&str> = found.iter().map(|d| d.key.as_str()).collect();
    assert_eq!(keys, ["analysis.load_steps", "materials.steel.poisson", "conditions[0].on"]);
}

/// Wrong and missing keys that a model cannot do without are filled in for the checks behind.
#[test]
fn required_keys_that_are_wrong_do_not_hide_others() {
    let keys = |changes: &[(&str, &str)]| {
        let mut text =
            MODEL.replace("poisson = 0.3", "poisson = 0.7").replace("on = \"u_min\"", "on = \"no-such-set\"");
        for (from, to) in changes {
            assert!(text.contains(from), "{from}");
            text = text.replacen(from, to, 1);
        }
        let found = parse(&text).unwrap_err();
        found.iter().map(|d| d.key.clone()).collect::<Vec<_>>().join(" ")
    };
    const BEHIND: &str = "materials.steel.poisson conditions[0].on";
    let both = |first: &str| format!("{first} {BEHIND}");
    assert_eq!(keys(&[("size = [10, 1.0]", "size = [10, \"1\"]")]), both("mesh.size[1]"));
    assert_eq!(keys(&[("size = [10, 1.0]", "")]), both("mesh"));
    assert_eq!(keys(&[("elements = [16, 2]", "")]), both("mesh.grid"));
    assert_eq!(
        keys(&[("thickness = 0.1", "thickness = \"x\"")]),
        "materials.steel.poisson sections[0].thickness conditions[0].on"
    );
    assert_eq!(keys(&[("value = [0, 0, 4e4]", "value = [0, 0]")]), format!("{BEHIND} loads[0].value"));
    assert_eq!(keys(&[("\"edge\"", "\"egde\"")]), format!("{BEHIND} loads[0].type"));
    assert_eq!(keys(&[("\"static\"", "\"statik\"")]), both("analysis.type"));
    assert_eq!(keys(&[("\"plate\"", "\"plane\"")]), "mesh.type materials.steel.poisson");
    // What lies in the changed table itself may follow from the change.
    assert_eq!(keys(&[("young = 210e9\n", "")]), "materials.steel conditions[0].on");
}
