//! Schema for editors, compared with models by a small validator.

use std::path::Path;

use serde_json::Value;

use super::super::editor::{is_schema, schema, schema_text};
use super::MODEL;

/// Mistakes of a value, one for each keyword that is not fulfilled, as a validator reports them.
fn mistakes(root: &Value, schema: &Value, value: &Value, path: &str) -> Vec<String> {
    let mut out = Vec::new();
    let Value::Object(keywords) = schema else {
        return if schema == &Value::Bool(false) { vec![format!("{path}: not allowed")] } else { out };
    };
    let number = |keyword: &Value| keyword.as_f64().unwrap();
    for (keyword, wanted) in keywords {
        let list = || wanted.as_array().unwrap();
        let fulfilled = match keyword.as_str() {
            "$ref" => {
                let target = root.pointer(wanted.as_str().unwrap().strip_prefix('#').unwrap()).unwrap();
                out.extend(mistakes(root, target, value, path));
                true
            }
            "type" => match wanted {
                Value::Array(several) => several.iter().any(|one| is_of_type(one, value)),
                one => is_of_type(one, value),
            },
            "pattern" => value.as_str().is_none_or(|text| has_pattern(text, wanted.as_str().unwrap())),
            "const" => value == wanted,
            "enum" => list().contains(value),
            "minimum" => value.as_f64().is_none_or(|x| x >= number(wanted)),
            "maximum" => value.as_f64().is_none_or(|x| x <= number(wanted)),
            "exclusiveMinimum" => value.as_f64().is_none_or(|x| x > number(wanted)),
            "exclusiveMaximum" => value.as_f64().is_none_or(|x| x < number(wanted)),
            "minItems" => value.as_array().is_none_or(|a| a.len() as u64 >= wanted.as_u64().unwrap()),
            "maxItems" => value.as_array().is_none_or(|a| a.len() as u64 <= wanted.as_u64().unwrap()),
            "items" => {
                for (i, item) in value.as_array().into_iter().flatten().enumerate() {
                    out.extend(mistakes(root, wanted, item, &format!("{path}[{i}]")));
                }
                true
            }
            "required" => value
                .as_object()
                .is_none_or(|table| list().iter().all(|key| table.contains_key(key.as_str().unwrap()))),
            "properties" => {
                for (key, value) in value.as_object().into_iter().flatten() {
                    if let Some(schema) = wanted.get(key) {
                        out.extend(mistakes(root, schema, value, &format!("{path}.{key}")));
                    }
                }
                true
            }
            "additionalProperties" => {
                let known = |key: &str| keywords.get("properties").is_some_and(|p| p.get(key).is_some());
                for (key, value) in value.as_object().into_iter().flatten().filter(|(key, _)| !known(key)) {
                    out.extend(mistakes(root, wanted, value, &format!("{path}.{key}")));
                }
                true
            }
            "allOf" => {
                list().iter().for_each(|schema| out.extend(mistakes(root, schema, value, path)));
                true
            }
            "anyOf" => list().iter().any(|schema| mistakes(root, schema, value, path).is_empty()),
            "oneOf" => {
                list().iter().filter(|schema| mistakes(root, schema, value, path).is_empty()).count() == 1
            }
            "if" => {
                if mistakes(root, wanted, value, path).is_empty() {
                    out.extend(mistakes(root, &keywords["then"], value, path));
                }
                true
            }
            "then" | "$schema" | "$defs" | "title" | "description" | "default" | "format"
            | "enumDescriptions" => true,
            other => panic!("keyword {other}"),
        };
        if !fulfilled {
            out.push(format!("{path}: {keyword} {wanted}"));
        }
    }
    out
}

/// Whether a text has one of the patterns of the schema.
fn has_pattern(text: &str, pattern: &str) -> bool {
    match pattern {
        "^[^.-][^.]*$" => !text.is_empty() && !text.starts_with('-') && !text.contains('.'),
        "^-?[^.-][^.]*\\.[xyz]$" => {
            let bare = text.strip_prefix('-').unwrap_or(text);
            bare.split_once('.').is_some_and(|(name, axis)| {
                !name.is_empty() && !name.starts_with('-') && ["x", "y", "z"].contains(&axis)
            })
        }
        other => panic!("pattern {other}"),
    }
}

fn is_of_type(name: &Value, value: &Value) -> bool {
    match name.as_str().unwrap() {
        "object" => value.is_object(),
        "array" => value.is_array(),
        "string" => value.is_string(),
        "boolean" => value.is_boolean(),
        "integer" => value.is_i64() || value.is_u64(),
        "number" => value.is_number(),
        other => panic!("type {other}"),
    }
}

fn of_text(text: &str) -> Vec<String> {
    let schema = schema();
    let table: toml::Table = text.parse().unwrap();
    mistakes(&schema, &schema, &serde_json::to_value(table).unwrap(), "")
}

#[test]
fn templates_and_examples_fulfil_the_schema_for_editors() {
    for kind in crate::deck::template_kinds() {
        assert_eq!(of_text(crate::deck::template(kind).unwrap()), Vec::<String>::new(), "{kind}");
    }
    let examples = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples");
    let mut models = 0;
    for file in std::fs::read_dir(examples).unwrap().map(|f| f.unwrap().path()) {
        if file.extension().is_some_and(|e| e == "toml") {
            let text = std::fs::read_to_string(&file).unwrap();
            assert_eq!(of_text(&text), Vec::<String>::new(), "{}", file.display());
            models += 1;
        }
    }
    assert!(models >= 5, "{models} examples");
}

#[test]
fn one_slip_gives_one_message_in_editors() {
    assert_eq!(of_text(MODEL), Vec::<String>::new());
    for (from, to, place) in [
        ("load_steps = 4", "load_step = 4", ".analysis.load_step:"),
        ("load_steps = 4", "load_steps = \"4\"", ".analysis.load_steps:"),
        ("load_steps = 4", "load_steps = 0", ".analysis.load_steps:"),
        ("type = \"static\"", "type = \"statics\"", ".analysis.type:"),
        ("type = \"static\"", "", ".analysis:"),
        ("young = 210e9", "young = -210e9", ".materials.steel.young:"),
        ("poisson = 0.3", "poisson = 0.5", ".materials.steel.poisson:"),
        ("young = 210e9", "", ".materials.steel:"),
        ("thickness = 0.1", "thickness = 0.0", ".sections[0].thickness:"),
        ("thickness = 0.1", "thickness = 0.1\nelement = \"emms\"", ".sections[0].element:"),
        ("size = [10, 1.0]", "size = [10, 0.0]", ".mesh.size[1]:"),
        ("size = [10, 1.0]", "size = [10]", ".mesh.size:"),
        ("value = [0, 0, 4e4]", "value = [0, 0, \"4e4\"]", ".loads[0].value[2]:"),
        ("position = [\"x\"]", "position = [\"w\"]", ".conditions[0].position[0]:"),
        ("interval = 0.1", "interval = -0.1", ".output.interval:"),
        ("interval = 0.1", "fields = [\"stress\"]", ".output.fields[0]:"),
    ] {
        assert!(MODEL.contains(from), "{from}");
        let found = of_text(&MODEL.replacen(from, to, 1));
        assert!(found.len() == 1 && found[0].starts_with(place), "{to}: {found:#?}");
    }
}

/// References to markers are strings of points and directions, and of nothing else.
#[test]
fn editors_know_where_markers_may_stand() {
    let model = super::markers::BY_MARKERS;
    assert_eq!(of_text(model), Vec::<String>::new());
    for (from, to, place) in [
        ("at = \"A\"", "at = \"A.x\"", ".joints[0].at:"),
        ("at = \"A\"", "at = [0, 0]", ".joints[0].at:"),
        ("at = \"A\"", "at = 3", ".joints[0].at:"),
        ("axis = \"A.z\"", "axis = \"A\"", ".joints[0].axis:"),
        ("axis = \"A.z\"", "axis = \"A.w\"", ".joints[0].axis:"),
        ("axes = [\"B.y\", \"-B.x\"]", "axes = [\"B.y\", \"B\"]", ".bodies[0].axes[1]:"),
        ("points = [\"A\", \"C\"]", "points = \"A\"", ".springs[0].points:"),
        ("on = \"A\"", "onto = \"A\"", ".markers[1].onto:"),
        ("name = \"A\"", "", ".markers[0]:"),
        ("mass = 1.0", "mass = 1.0\nvelocity = \"A.x\"", ".bodies[0].velocity:"),
    ] {
        assert!(model.contains(from), "{from}");
        let found = of_text(&model.replacen(from, to, 1));
        assert!(found.len() == 1 && found[0].starts_with(place), "{to}: {found:#?}");
    }
}

#[test]
fn values_that_the_schema_forbids_are_refused_by_the_program() {
    for (from, to) in [
        ("young = 210e9", "young = 0.0"),
        ("poisson = 0.3", "poisson = -1.0"),
        ("thickness = 0.1", "thickness = 0.1\nretardation_time = -1.0"),
        ("size = [10, 1.0]", "size = [10, -1.0]"),
        ("elements = [16, 2]", "elements = [16, 2]\ndistortion = 0.5"),
        ("elements = [16, 2]", "elements = [16, 2]\ngrading = [0.0, 1.0]"),
        ("interval = 0.1", "interval = -0.1"),
        ("interval = 0.1", "every = 0"),
    ] {
        let text = MODEL.replacen(from, to, 1);
        assert!(!of_text(&text).is_empty(), "{to}");
        let refused = match crate::deck::Deck::parse("m.toml", text) {
            Ok(deck) => crate::job::prepare(&deck).is_err(),
            Err(_) => true,
        };
        assert!(refused, "{to}");
    }
}

#[test]
fn a_schema_is_known_by_its_title() {
    assert!(is_schema(&schema_text()));
    assert!(!is_schema("{\"title\": \"mine\"}") && !is_schema("my notes"));
}
