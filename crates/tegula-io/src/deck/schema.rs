//! The JSON Schema of the model, and what it expects of a value.

use serde_json::{Map, Value};
use tegula::Model;

use super::markers;

/// The JSON Schema of the model file as it follows from the types: that of the model and of its markers.
pub(super) fn schema() -> Value {
    let mut schema = schemars::schema_for!(Model).to_value();
    // A model has one analysis, or several in steps: neither is a default.
    if let Some(analysis) = schema.pointer_mut("/properties/analysis").and_then(Value::as_object_mut) {
        analysis.remove("default");
    }
    if let Some(keys) = schema.pointer_mut("/properties").and_then(Value::as_object_mut) {
        keys.insert(markers::KEY.into(), markers::schema());
    }
    schema
}

/// Kind of value that the schema expects.
#[derive(Debug, Clone)]
pub(super) enum Wanted<'s> {
    /// A table with these keys.
    Table(Table<'s>),
    /// A table whose kind is chosen by its key `type`.
    Tagged(Vec<(&'s str, Table<'s>)>),
    /// A table of things by name.
    Named(&'s Value),
    /// One of these strings.
    Choice(Vec<&'s str>),
    /// A list, with the smallest and greatest length.
    List(&'s Value, usize, usize),
    /// A finite number.
    Number,
    /// An integer in a range, both ends included.
    Integer(i128, i128),
    /// An integer in a range, both ends included, or one of these strings.
    Count((i128, i128), Vec<&'s str>),
    /// Any string.
    String,
    /// Any string, or a table with these keys.
    StringOrTable(Table<'s>),
    /// `true` or `false`.
    Boolean,
    /// Something this validator does not know; left to the typed reader.
    Anything,
}

/// Keys of a table.
#[derive(Debug, Clone, Copy)]
pub(super) struct Table<'s> {
    schema: &'s Value,
}

impl<'s> Table<'s> {
    fn properties(self) -> Option<&'s Map<String, Value>> {
        self.schema.get("properties")?.as_object()
    }

    /// Names of all keys, in the order of the documentation.
    pub fn keys(self) -> impl Iterator<Item = &'s str> {
        self.properties().into_iter().flatten().map(|(key, _)| key.as_str())
    }

    /// Schema of the value of a key.
    pub fn get(self, key: &str) -> Option<&'s Value> {
        self.properties()?.get(key)
    }

    /// Names of the keys that must be there.
    pub fn required(self) -> impl Iterator<Item = &'s str> {
        self.schema.get("required").and_then(Value::as_array).into_iter().flatten().filter_map(Value::as_str)
    }

    /// Whether keys other than the named ones are errors.
    pub fn is_closed(self) -> bool {
        self.schema.get("additionalProperties") == Some(&Value::Bool(false))
    }
}

/// The schema behind references and `null` alternatives.
pub(super) fn resolve<'s>(root: &'s Value, mut schema: &'s Value) -> &'s Value {
    // Bounded, so that a schema that refers to itself cannot hang the reader.
    for _ in 0..16 {
        let target = schema.get("$ref").and_then(Value::as_str).and_then(|r| r.strip_prefix('#'));
        let some = || {
            // More than one are no optional value.
            match own_alternatives(schema)?.as_slice() {
                [only] => Some(*only),
                _ => None,
            }
        };
        match target.and_then(|pointer| root.pointer(pointer)).or_else(some) {
            Some(next) => schema = next,
            None => break,
        }
    }
    schema
}

/// Alternatives of `anyOf` but for `null`.
fn own_alternatives(schema: &Value) -> Option<Vec<&Value>> {
    let all = schema.get("anyOf")?.as_array()?;
    Some(all.iter().filter(|s| s.get("type").and_then(Value::as_str) != Some("null")).collect())
}

/// `anyOf`: an integer or constant strings, or a string or a table.
fn mixed<'s>(root: &'s Value, branches: &[&'s Value]) -> Wanted<'s> {
    if let [text, table] = branches
        && let (Wanted::String, Wanted::Table(table)) = (wanted(root, text), wanted(root, table))
    {
        return Wanted::StringOrTable(table);
    }
    let (mut range, mut choices) = (None, Vec::new());
    for branch in branches {
        match wanted(root, branch) {
            Wanted::Integer(low, high) => range = Some((low, high)),
            Wanted::Choice(more) => choices.extend(more),
            _ => return Wanted::Anything,
        }
    }
    range.map_or(Wanted::Anything, |range| Wanted::Count(range, choices))
}

/// Kind of value that `schema`, part of the schema `root`, expects.
pub(super) fn wanted<'s>(root: &'s Value, schema: &'s Value) -> Wanted<'s> {
    let schema = resolve(root, schema);
    if let Some(choices) = schema.get("enum").and_then(Value::as_array) {
        return Wanted::Choice(choices.iter().filter_map(Value::as_str).collect());
    }
    if let Some(branches) = own_alternatives(schema) {
        return mixed(root, &branches);
    }
    if let Some(branches) = schema.get("oneOf").and_then(Value::as_array) {
        return alternatives(root, branches);
    }
    let kind = match schema.get("type") {
        Some(Value::String(kind)) => kind.as_str(),
        Some(Value::Array(kinds)) => {
            kinds.iter().filter_map(Value::as_str).find(|&k| k != "null").unwrap_or_default()
        }
        _ => "",
    };
    let size = |key, default| {
        schema.get(key).and_then(Value::as_u64).and_then(|n| usize::try_from(n).ok()).unwrap_or(default)
    };
    match kind {
        "object" if schema.get("properties").is_some() => Wanted::Table(Table { schema }),
        "object" => match schema.get("additionalProperties") {
            Some(items @ Value::Object(_)) => Wanted::Named(items),
            _ => Wanted::Table(Table { schema }),
        },
        "array" => {
            let items = schema.get("items").unwrap_or(&Value::Null);
            Wanted::List(items, size("minItems", 0), size("maxItems", usize::MAX))
        }
        "number" => Wanted::Number,
        "integer" => {
            let (low, high) = integer_range(schema);
            Wanted::Integer(low, high)
        }
        "string" => match schema.get("const").and_then(Value::as_str) {
            Some(only) => Wanted::Choice(vec![only]),
            None => Wanted::String,
        },
        "boolean" => Wanted::Boolean,
        _ => Wanted::Anything,
    }
}

/// `oneOf`: constant strings, strings in groups, or tables told apart by `type`.
fn alternatives<'s>(root: &'s Value, branches: &'s [Value]) -> Wanted<'s> {
    let mut choices = Vec::new();
    let mut tagged = Vec::new();
    for branch in branches {
        match wanted(root, branch) {
            Wanted::Choice(more) => choices.extend(more),
            Wanted::Table(table) => {
                let tag = table.get("type").and_then(|s| s.get("const")).and_then(Value::as_str);
                tagged.extend(tag.map(|tag| (tag, table)));
            }
            _ => return Wanted::Anything,
        }
    }
    match (choices.is_empty(), tagged.len() == branches.len()) {
        (true, true) => Wanted::Tagged(tagged),
        (false, _) if tagged.is_empty() => Wanted::Choice(choices),
        _ => Wanted::Anything,
    }
}

fn integer_range(schema: &Value) -> (i128, i128) {
    let (low, high) = match schema.get("format").and_then(Value::as_str) {
        Some("uint8") => (0, u8::MAX.into()),
        Some("uint16") => (0, u16::MAX.into()),
        Some("uint32") => (0, u32::MAX.into()),
        Some("uint64" | "uint") => (0, u64::MAX.into()),
        Some("int32") => (i32::MIN.into(), i32::MAX.into()),
        _ => (i64::MIN.into(), i64::MAX.into()),
    };
    let bound = |key| schema.get(key).and_then(Value::as_i64).map(i128::from);
    (bound("minimum").unwrap_or(low).max(low), bound("maximum").unwrap_or(high).min(high))
}

impl Wanted<'_> {
    /// The thing in words, with its article.
    pub fn noun(&self, root: &Value) -> String {
        match self {
            Self::Table(_) | Self::Tagged(_) => "a table".into(),
            Self::Named(_) => "a table of things by name".into(),
            Self::Choice(_) | Self::String => "a string".into(),
            Self::StringOrTable(_) => "a string or a table".into(),
            Self::List(items, low, high) => {
                let items = wanted(root, items).plural();
                if low == high { format!("a list of {low} {items}") } else { format!("a list of {items}") }
            }
            Self::Number => "a number".into(),
            Self::Integer(..) => "an integer".into(),
            Self::Count(_, choices) => {
                let quoted: Vec<String> = choices.iter().map(|choice| format!("\"{choice}\"")).collect();
                format!("an integer or {}", quoted.join(", "))
            }
            Self::Boolean => "true or false".into(),
            Self::Anything => "a value".into(),
        }
    }

    /// Several of the thing, in words.
    pub fn plural(&self) -> &'static str {
        match self {
            Self::Table(_) | Self::Tagged(_) | Self::Named(_) => "tables",
            Self::Choice(_) | Self::String => "strings",
            Self::StringOrTable(_) => "strings or tables",
            Self::List(..) => "lists",
            Self::Number => "numbers",
            Self::Integer(..) => "integers",
            Self::Count(..) => "integers or strings",
            Self::Boolean => "true or false",
            Self::Anything => "values",
        }
    }
}

/// Documentation of a key.
pub(super) fn doc<'s>(root: &'s Value, schema: &'s Value) -> &'s str {
    let text = |s: &'s Value| s.get("description").and_then(Value::as_str);
    text(schema).or_else(|| text(resolve(root, schema))).unwrap_or_default()
}
