//! Replacement of references by coordinates in the syntax tree.

use std::ops::Range;

use serde_json::Value;
use tegula::Issue;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::super::diagnostic::Source;
use super::super::locate::child;
use super::super::schema::{Table, Wanted, wanted};
use super::super::syntax::shorten;
use super::reference::Kind;
use super::{KEY, Markers, Replaced};

/// Coordinates in place of a reference that is mistaken: they only keep the tree readable for further checks.
fn stand_in(kind: Kind) -> &'static str {
    match kind {
        Kind::Point => "[0.0, 0.0, 0.0]",
        Kind::Direction => "[1.0, 0.0, 0.0]",
    }
}

impl Markers {
    /// Puts coordinates in place of all references in the tree `root`. `schema` is that of the model.
    pub fn replace<'m>(&'m self, source: &Source, schema: &Value, root: &mut DeTable<'m>) -> Replaced {
        let done = Replaced { found: self.found.clone(), ..Replaced::default() };
        let mut walk = Walk { source, schema, markers: self, used: self.used.clone(), done };
        if let Wanted::Table(table) = wanted(schema, schema) {
            walk.table(table, root, "");
        }
        let Walk { mut done, used, .. } = walk;
        let idle = self.names.markers.iter().filter(|&(_, &i)| !used[i]);
        done.unused.extend(idle.map(|(name, i)| {
            Issue::new(
                format!("{KEY}[{i}]"),
                format!("nothing uses the marker \"{}\"", shorten(name)),
                "leave it out, or name it in place of coordinates",
            )
        }));
        done
    }
}

/// Walk through the tree along the schema.
struct Walk<'a, 'm> {
    source: &'a Source,
    schema: &'a Value,
    markers: &'m Markers,
    used: Vec<bool>,
    done: Replaced,
}

impl<'a, 'm> Walk<'a, 'm> {
    fn table(&mut self, keys: Table<'a>, found: &mut DeTable<'m>, path: &str) {
        for (key, value) in found.iter_mut() {
            if let Some(schema) = keys.get(key.get_ref()) {
                let span = value.span();
                self.value(schema, None, value, (&child(path, key.get_ref()), span));
            }
        }
    }

    /// Goes into a value at a place; `of_list` is the kind of the entries of the list around it.
    fn value(
        &mut self,
        schema: &'a Value,
        of_list: Option<Kind>,
        value: &mut Spanned<DeValue<'m>>,
        (path, span): (&str, Range<usize>),
    ) {
        let kind = Kind::of(schema).or(of_list);
        match (wanted(self.schema, schema), value.get_mut()) {
            (Wanted::Table(keys), DeValue::Table(found)) => self.table(keys, found, path),
            (Wanted::Tagged(branches), DeValue::Table(found)) => {
                let tag = found.get("type").and_then(|tag| tag.get_ref().as_str());
                let keys = branches.iter().find(|(name, _)| Some(*name) == tag).map(|&(_, keys)| keys);
                if let Some(keys) = keys {
                    self.table(keys, found, path);
                }
            }
            (Wanted::Named(items), DeValue::Table(found)) => {
                for (key, value) in found.iter_mut() {
                    let span = value.span();
                    self.value(items, kind, value, (&child(path, key.get_ref()), span));
                }
            }
            (Wanted::List(items, ..), found) => {
                let numbers = matches!(wanted(self.schema, items), Wanted::Number);
                match (numbers, kind, found) {
                    (true, Some(kind), DeValue::String(text)) => {
                        let text = text.to_string();
                        *value = self.coordinates(&text, kind, path, &span);
                    }
                    (false, _, DeValue::Array(found)) => {
                        for (i, item) in found.iter_mut().enumerate() {
                            let span = if item.span().is_empty() { span.clone() } else { item.span() };
                            self.value(items, kind, item, (&format!("{path}[{i}]"), span));
                        }
                    }
                    _ => {}
                }
            }
            _ => {}
        }
    }

    /// Coordinates that a reference means, at its place in the text.
    fn coordinates(
        &mut self,
        text: &str,
        kind: Kind,
        path: &str,
        span: &Range<usize>,
    ) -> Spanned<DeValue<'m>> {
        let place = match self.markers.names.find(text, kind) {
            Ok(reference) => {
                self.used[reference.marker] = true;
                let texts = self.markers.places[reference.marker].as_ref();
                let place = texts.map(|texts| match reference.axis {
                    None => &texts.origin,
                    Some((axis, opposite)) => &texts.axes[axis][usize::from(opposite)],
                });
                if place.is_none() {
                    self.done.undetermined.push(path.to_owned());
                }
                place.map(String::as_str)
            }
            Err((message, help)) => {
                self.done.found.push(self.source.at(span.clone(), path, message, help));
                None
            }
        };
        let numbers = DeValue::parse(place.unwrap_or(stand_in(kind))).map(Spanned::into_inner);
        let value = match numbers {
            Ok(DeValue::Array(numbers)) => {
                let at_place = |number: Spanned<DeValue<'m>>| Spanned::new(span.clone(), number.into_inner());
                DeValue::Array(numbers.into_iter().map(at_place).collect())
            }
            // Left as a string, which the validator refuses.
            _ => DeValue::String(text.to_owned().into()),
        };
        Spanned::new(span.clone(), value)
    }
}
