//! Validation of the syntax tree of a model file against the schema; every mismatch is reported.

use serde_json::Value;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::Diagnostic;
use super::diagnostic::Source;
use super::locate::child;
use super::schema::{Table, Wanted, doc, schema, wanted};
use super::syntax::shorten;
use super::unknown::{Surroundings, list, similar};

/// All violations of the schema of the model in the tree `root` of a text.
pub(super) fn validate(source: &Source, root: &DeTable<'_>) -> Vec<Diagnostic> {
    let schema = schema();
    let mut validator = Validator { source, schema: &schema, found: Vec::new() };
    if let Wanted::Table(table) = wanted(&schema, &schema) {
        let whole = Place { key: String::new(), span: 0..0, doc: "" };
        validator.table(table, None, root, &whole);
        validator.analysis(table, root, &whole);
    }
    validator.found.sort_by_key(|d| d.span.start);
    validator.found
}

/// The value that is looked at.
struct Place<'s> {
    key: String,
    span: std::ops::Range<usize>,
    /// Documentation of the value.
    doc: &'s str,
}

struct Validator<'a, 's> {
    source: &'a Source,
    schema: &'s Value,
    found: Vec<Diagnostic>,
}

/// The type chosen among the possible ones.
type Branches<'b, 's> = Option<(&'b str, &'b [(&'s str, Table<'s>)])>;

impl<'s> Validator<'_, 's> {
    fn report(&mut self, place: &Place<'s>, message: impl Into<String>, help: impl Into<String>) {
        let span = place.span.clone();
        self.found.push(self.source.at(span, place.key.as_str(), message, help));
    }

    fn value(&mut self, schema: &'s Value, value: &Spanned<DeValue<'_>>, place: &Place<'s>) {
        let wanted = wanted(self.schema, schema);
        match (&wanted, value.get_ref()) {
            (Wanted::Anything, _) | (Wanted::String | Wanted::StringOrTable(_), DeValue::String(_)) => {}
            (Wanted::Boolean, DeValue::Boolean(_)) => {}
            (Wanted::Table(table) | Wanted::StringOrTable(table), DeValue::Table(found)) => {
                self.table(*table, None, found, place);
            }
            (Wanted::Tagged(branches), DeValue::Table(found)) => self.tagged(branches, found, place),
            (Wanted::Named(items), DeValue::Table(found)) => self.named(items, found, place),
            (Wanted::List(items, low, high), DeValue::Array(found)) => {
                self.list(items, (*low, *high), found, place);
            }
            (Wanted::Choice(choices) | Wanted::Count(_, choices), DeValue::String(found)) => {
                self.choice(choices, found, place);
            }
            (Wanted::Integer(low, high) | Wanted::Count((low, high), _), DeValue::Integer(found)) => {
                let value = i128::from_str_radix(found.as_str(), found.radix()).ok();
                if !value.is_some_and(|value| (low..=high).contains(&&value)) {
                    self.report(
                        place,
                        format!("{} is out of range", shorten(found.as_str())),
                        format!("give an integer from {low} to {high}"),
                    );
                }
            }
            (Wanted::Number, DeValue::Integer(found)) => {
                if i64::from_str_radix(found.as_str(), found.radix()).is_err() {
                    self.report(
                        place,
                        format!("the integer {} is too large", shorten(found.as_str())),
                        "write it with an exponent, such as 1e20",
                    );
                }
            }
            (Wanted::Number, DeValue::Float(found)) => self.number(found.as_str(), place),
            (_, found) => {
                let message = format!("expected {}, found {}", wanted.noun(self.schema), describe(found));
                let help = self.remedy(&wanted, found, place);
                self.report(place, message, help);
            }
        }
    }

    fn number(&mut self, found: &str, place: &Place<'s>) {
        if found.parse::<f64>().is_ok_and(f64::is_finite) {
            return;
        }
        if found.contains("inf") || found.contains("nan") {
            self.report(place, format!("{found} is not a finite number"), place.doc);
        } else {
            let message = format!("the number {} is too large", shorten(found));
            self.report(place, message, "give a number below 1.7e308");
        }
    }

    fn choice(&mut self, choices: &[&str], found: &str, place: &Place<'s>) {
        if choices.contains(&found) {
            return;
        }
        self.report(place, format!("unknown value \"{}\"", shorten(found)), choose(found, choices));
    }

    fn list(
        &mut self,
        items: &'s Value,
        (low, high): (usize, usize),
        found: &[Spanned<DeValue<'_>>],
        place: &Place<'s>,
    ) {
        if !(low..=high).contains(&found.len()) {
            let things = wanted(self.schema, items).plural();
            let wanted = match (low == high, found.len() < low) {
                (true, _) => format!("{low}"),
                (false, true) => format!("at least {low}"),
                (false, false) => format!("at most {high}"),
            };
            self.report(place, format!("expected {wanted} {things}, found {}", found.len()), place.doc);
        }
        for (i, item) in found.iter().enumerate() {
            let place = Place {
                key: format!("{}[{i}]", place.key),
                span: self.item_span(item, place),
                doc: place.doc,
            };
            self.value(items, item, &place);
        }
    }

    /// The span of a list entry; the list's own where the parser gives none.
    fn item_span(&self, item: &Spanned<DeValue<'_>>, place: &Place<'s>) -> std::ops::Range<usize> {
        if item.span().is_empty() { place.span.clone() } else { item.span() }
    }

    fn named(&mut self, items: &'s Value, found: &DeTable<'_>, place: &Place<'s>) {
        let tables = matches!(wanted(self.schema, items), Wanted::Table(_) | Wanted::Tagged(_));
        let nameless = found.iter().find(|(_, value)| tables && !value.get_ref().is_table());
        if let Some((key, value)) = nameless {
            let message =
                format!("expected a table for each name, found the key \"{}\"", shorten(key.get_ref()));
            let help = format!("put a name of your choice into the header: [{}.NAME]", place.key);
            self.report(
                &Place { key: place.key.clone(), span: key.span().start..value.span().end, doc: "" },
                message,
                help,
            );
            return;
        }
        for (key, value) in found {
            let place = Place { key: child(&place.key, key.get_ref()), span: value.span(), doc: place.doc };
            self.value(items, value, &place);
        }
    }

    fn tagged(&mut self, branches: &[(&'s str, Table<'s>)], found: &DeTable<'_>, place: &Place<'s>) {
        let tags: Vec<&str> = branches.iter().map(|&(tag, _)| tag).collect();
        let only = || if let [only] = branches { Some(*only) } else { None };
        let branch = match found.get("type") {
            Some(value) => {
                let place = Place { key: child(&place.key, "type"), span: value.span(), doc: "" };
                match value.get_ref() {
                    DeValue::String(tag) => {
                        let branch = branches.iter().find(|(name, _)| name == tag).copied();
                        if branch.is_none() {
                            let message = format!("unknown type \"{}\"", shorten(tag));
                            self.report(&place, message, choose(tag, &tags));
                        }
                        branch.or_else(only)
                    }
                    other => {
                        let message = format!("expected a string, found {}", describe(other));
                        self.report(&place, message, format!("one of {}", list(tags.iter().copied())));
                        only()
                    }
                }
            }
            None => {
                // A misspelled "type" is one mistake, not two.
                let slip = found.iter().find(|(key, _)| {
                    let known = branches.iter().any(|(_, table)| table.get(key.get_ref()).is_some());
                    !known && similar(key.get_ref(), ["type"].into_iter()).is_some()
                });
                if let Some((key, _)) = slip {
                    let place = Place { key: child(&place.key, key.get_ref()), span: key.span(), doc: "" };
                    let message = format!("unknown key \"{}\"", shorten(key.get_ref()));
                    self.report(&place, message, "did you mean \"type\"?");
                    return;
                }
                let help = format!("add \"type\", one of {}", list(tags.iter().copied()));
                self.report(place, "missing key \"type\"", help);
                only()
            }
        };
        if let Some((tag, table)) = branch {
            self.table(table, Some((tag, branches)), found, place);
        }
    }

    /// Keys of a table; `branches` where its type has been checked already.
    fn table(
        &mut self,
        table: Table<'s>,
        branches: Branches<'_, 's>,
        found: &DeTable<'_>,
        place: &Place<'s>,
    ) {
        let mut meant = Vec::new();
        for (key, value) in found {
            let name: &str = key.get_ref();
            if branches.is_some() && name == "type" {
                continue;
            }
            let path = child(&place.key, name);
            if let Some(schema) = table.get(name) {
                let doc = doc(self.schema, schema);
                self.value(schema, value, &Place { key: path, span: value.span(), doc });
            } else if table.is_closed() {
                let surroundings = Surroundings { root: self.schema, path: &place.key, table, branches };
                let (guess, help) = surroundings.advise(name);
                meant.extend(guess);
                let message = format!("unknown key \"{}\"", shorten(name));
                self.report(&Place { key: path, span: key.span(), doc: "" }, message, help);
            }
        }
        for key in table.required() {
            let excused = meant.contains(&key) || (branches.is_some() && key == "type");
            if found.contains_key(key) || excused {
                continue;
            }
            self.missing(table, key, place);
        }
    }

    /// A model has one `analysis`, or several in `steps`.
    fn analysis(&mut self, table: Table<'s>, found: &DeTable<'_>, whole: &Place<'s>) {
        let steps =
            found.get("steps").is_some_and(|steps| steps.get_ref().as_array().is_none_or(|s| !s.is_empty()));
        match (found.get_key_value("analysis"), steps) {
            (Some((key, value)), true) => {
                let place =
                    Place { key: "analysis".into(), span: key.span().start..value.span().end, doc: "" };
                self.report(
                    &place,
                    "the model has both `analysis` and `steps`",
                    "put all analyses into `steps`",
                );
            }
            (None, false) if !self.found.iter().any(|d| d.help.contains("\"analysis\"")) => {
                self.missing(table, "analysis", whole);
            }
            _ => {}
        }
    }

    fn missing(&mut self, table: Table<'s>, key: &str, place: &Place<'s>) {
        let schema = table.get(key).unwrap_or(&Value::Null);
        let (noun, doc) = (wanted(self.schema, schema).noun(self.schema), doc(self.schema, schema));
        self.report(place, format!("missing key \"{key}\""), format!("add \"{key}\", {noun}: {doc}"));
    }

    /// Remedy for a value of the wrong kind.
    fn remedy(&self, wanted_here: &Wanted<'s>, found: &DeValue<'_>, place: &Place<'s>) -> String {
        let key = place.key.as_str();
        let name = key.rsplit('.').next().unwrap_or_default();
        match (wanted_here, found) {
            (Wanted::Number | Wanted::Integer(..), DeValue::String(text)) if text.parse::<f64>().is_ok() => {
                format!("write it without quotes: {text}")
            }
            (Wanted::Number, DeValue::String(text)) if text.replacen(',', ".", 1).parse::<f64>().is_ok() => {
                format!("write it without quotes, with a decimal point: {}", text.replacen(',', ".", 1))
            }
            (Wanted::Integer(..), DeValue::Float(number)) => match number.as_str().parse::<f64>() {
                Ok(x) if x.fract() == 0.0 && x.abs() < 1e15 => format!("write it without a point: {x}"),
                _ => place.doc.to_owned(),
            },
            (Wanted::Boolean, _) => "write true or false, without quotes".to_owned(),
            (
                Wanted::String | Wanted::StringOrTable(_),
                DeValue::Integer(_) | DeValue::Float(_) | DeValue::Boolean(_),
            ) => {
                let text = self.source.text().get(place.span.clone()).unwrap_or_default();
                format!("write it in quotes: \"{}\"", shorten(text))
            }
            (Wanted::Choice(choices), _) => format!("one of {}", list(choices.iter().copied())),
            (Wanted::List(items, ..), found) => match (wanted(self.schema, items), found) {
                (Wanted::Table(_) | Wanted::Tagged(_), DeValue::Table(_)) => {
                    format!("write the header with double brackets, once for each entry: [[{key}]]")
                }
                (Wanted::Choice(_) | Wanted::String, DeValue::String(text)) => {
                    format!("write it in brackets: [\"{}\"]", shorten(text))
                }
                (Wanted::List(..), DeValue::String(text)) => {
                    format!("write a list with an entry for each: [\"{}\", …]", shorten(text))
                }
                _ => place.doc.to_owned(),
            },
            (Wanted::Named(_), DeValue::Array(_)) => {
                format!("write a table for each, with a name of your choice: [{key}.NAME]")
            }
            (Wanted::Table(_) | Wanted::Tagged(_), DeValue::Array(_)) => {
                format!("write the header with single brackets, once: [{key}]")
            }
            (Wanted::Tagged(branches), DeValue::String(tag)) => {
                let tags = branches.iter().map(|&(tag, _)| tag);
                let tag = similar(tag, tags.clone()).or(tags.clone().next()).unwrap_or_default();
                format!("write it as a table: {name} = {{ type = \"{tag}\", … }}")
            }
            _ => place.doc.to_owned(),
        }
    }
}

/// Advice on a word that is none of `choices`.
fn choose(found: &str, choices: &[&str]) -> String {
    let all = list(choices.iter().copied());
    match similar(found, choices.iter().copied()) {
        Some(meant) if choices.len() > 1 => format!("did you mean \"{meant}\"? (one of {all})"),
        Some(meant) => format!("did you mean \"{meant}\"?"),
        None if choices.len() == 1 => format!("the only one is {all}"),
        None => format!("one of {all}"),
    }
}

/// Description of a value of the text, in words.
fn describe(found: &DeValue<'_>) -> String {
    match found {
        DeValue::String(text) => format!("the string \"{}\"", shorten(text)),
        DeValue::Integer(number) => format!("the integer {}", shorten(number.as_str())),
        DeValue::Float(number) => format!("the number {}", shorten(number.as_str())),
        DeValue::Boolean(value) => format!("{value}"),
        DeValue::Datetime(_) => "a date".to_owned(),
        DeValue::Array(_) => "a list".to_owned(),
        DeValue::Table(_) => "a table".to_owned(),
    }
}
