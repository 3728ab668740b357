//! The JSON Schema for editors and other programs.
//!
//! The schema derived from the types lists tables of several kinds as alternatives. A validator that finds none of them
//! fulfilled reports the mistakes against every one. Here the key `type` chooses the one branch that is meant (`if`,
//! `then`), words are plain enumerations, and `null`, which TOML does not have, is gone: one slip gives one message.

use serde_json::{Map, Value, json};

use super::markers::{KEYWORD, Kind};
use super::schema::schema as derived;

/// File name of the schema that `tegula new` writes next to a model.
pub const SCHEMA_FILE: &str = "tegula.schema.json";
/// Title by which a file is known as this schema.
const TITLE: &str = "tegula model";

/// The JSON Schema of the model file.
pub fn schema() -> Value {
    let mut schema = derived();
    simplify(&mut schema);
    if let Some(root) = schema.as_object_mut() {
        root.insert("oneOf".into(), json!([{ "required": ["analysis"] }, { "required": ["steps"] }]));
    }
    schema
}

/// The JSON Schema of the model file as text.
pub fn schema_text() -> String {
    format!("{:#}\n", schema())
}

/// True for the text of such a schema, of any version.
pub fn is_schema(text: &str) -> bool {
    serde_json::from_str(text).is_ok_and(|schema: Value| schema["title"] == TITLE)
}

/// Line by which editors find the schema of a model.
pub(super) fn directive() -> String {
    format!("#:schema ./{SCHEMA_FILE}\n")
}

fn simplify(schema: &mut Value) {
    match schema {
        Value::Object(map) => {
            without_null(map);
            accept_markers(map);
            if let Some(Value::Array(branches)) = map.remove("oneOf") {
                if let Some(words) = words(&branches) {
                    map.extend(words);
                } else if let Some(tags) = tags(&branches) {
                    by_type(map, branches, tags);
                } else {
                    map.insert("oneOf".into(), Value::Array(branches));
                }
            }
            map.values_mut().for_each(simplify);
        }
        Value::Array(list) => list.iter_mut().for_each(simplify),
        _ => {}
    }
}

/// Takes `null` out of types and alternatives.
fn without_null(map: &mut Map<String, Value>) {
    if map.get("default") == Some(&Value::Null) {
        map.remove("default");
    }
    if let Some(Value::Array(types)) = map.get_mut("type") {
        types.retain(|t| t != "null");
        if let [only] = types.as_slice() {
            let only = only.clone();
            map.insert("type".into(), only);
        }
    }
    if let Some(Value::Array(mut some)) = map.remove("anyOf") {
        some.retain(|s| s["type"] != "null");
        match some.pop() {
            Some(Value::Object(only)) if some.is_empty() => {
                for (key, value) in only {
                    map.entry(key).or_insert(value);
                }
            }
            last => {
                some.extend(last);
                map.insert("anyOf".into(), Value::Array(some));
            }
        }
    }
}

/// Lets keys for points and directions take the name of a marker. Keywords of lists say nothing of strings, so that one slip
/// still gives one message.
fn accept_markers(map: &mut Map<String, Value>) {
    let Some(kind) = map.remove(KEYWORD) else { return };
    for entries in ["items", "additionalProperties"] {
        if let Some(Value::Object(inner)) = map.get_mut(entries)
            && inner.get("type") == Some(&json!("array"))
        {
            inner.insert(KEYWORD.into(), kind);
            return;
        }
    }
    let Some(kind) = Kind::named(&kind) else { return };
    map.insert("type".into(), json!(["array", "string"]));
    map.insert("pattern".into(), json!(kind.pattern()));
    let sentence = kind.sentence();
    let description = match map.get("description").and_then(Value::as_str) {
        Some(before) => format!("{before} {sentence}"),
        None => sentence.to_owned(),
    };
    map.insert("description".into(), json!(description));
}

/// One enumeration for alternatives that are all words.
fn words(branches: &[Value]) -> Option<Map<String, Value>> {
    let (mut words, mut about) = (Vec::new(), Vec::new());
    for branch in branches {
        let description = branch.get("description").cloned().unwrap_or_else(|| json!(""));
        let more = match (branch.get("const"), branch.get("enum")) {
            (Some(word), _) => vec![word.clone()],
            (None, Some(Value::Array(more))) => more.clone(),
            _ => return None,
        };
        about.extend(more.iter().map(|_| description.clone()));
        words.extend(more);
    }
    let mut out = Map::new();
    out.insert("type".into(), json!("string"));
    out.insert("enum".into(), Value::Array(words));
    out.insert("enumDescriptions".into(), Value::Array(about));
    Some(out)
}

/// Words of the key `type` of alternatives that are all tables told apart by it.
fn tags(branches: &[Value]) -> Option<Vec<Value>> {
    branches.iter().map(|branch| branch.pointer("/properties/type/const").cloned()).collect()
}

fn by_type(map: &mut Map<String, Value>, branches: Vec<Value>, tags: Vec<Value>) {
    let about: Vec<Value> =
        branches.iter().map(|b| b.get("description").cloned().unwrap_or_else(|| json!(""))).collect();
    let chosen = branches.into_iter().zip(&tags).map(|(branch, tag)| {
        json!({ "if": { "properties": { "type": { "const": tag } }, "required": ["type"] }, "then": branch })
    });
    let chosen: Vec<Value> = chosen.collect();
    map.insert("type".into(), json!("object"));
    map.insert("required".into(), json!(["type"]));
    map.insert(
        "properties".into(),
        json!({ "type": { "type": "string", "enum": tags, "enumDescriptions": about } }),
    );
    map.insert("allOf".into(), Value::Array(chosen));
}
