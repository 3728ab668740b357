//! Further mistakes of a model file whose keys or values are wrong already.
//!
//! They are taken out, and what a model cannot do without is filled in. If the rest is a model, it is checked as
//! one, so that the person who repairs the file sees all of its mistakes and not only the first kind. What may
//! follow from the changes alone is not reported.

use std::path::Path;

use serde::Deserialize as _;
use serde_json::Value as Json;
use tegula::compile::{check, define_sets};
use tegula::mesh::generators::generate;
use tegula::{Error, Issue, Mesh, Model};
use toml::de::DeTable;
use toml::{Spanned, Table, Value};

use super::Diagnostic;
use super::schema::{Wanted, schema, wanted};
use super::scheme_default::WithoutScheme;
use crate::memory;

/// Issues of the model that is left of `tree` without the keys of `found`; none where nothing is left that could be checked. The
/// values of the keys `undetermined` are arbitrary: nothing that may follow from them is reported.
pub(super) fn issues(
    path: &Path,
    tree: Spanned<DeTable<'_>>,
    found: &[Diagnostic],
    undetermined: Vec<String>,
) -> Vec<Issue> {
    let Ok(mut table) = Table::deserialize(toml::Deserializer::from(tree)) else { return Vec::new() };
    // From the back, so that the places of list entries before stay what they are.
    let mut keys: Vec<String> = found.iter().map(|d| d.key.clone()).chain(undetermined).collect();
    keys.sort_unstable();
    keys.dedup();
    for diagnostic in found.iter().filter(|d| !d.message.starts_with("missing key")) {
        // A key that went with its table or list is gone already.
        remove(&mut table, &diagnostic.key);
    }
    if found.iter().any(|d| d.message == "missing key \"analysis\"") {
        // Most checks depend on the kind of the analysis.
        return Vec::new();
    }
    let root = schema();
    let materials = table.get("materials").and_then(Value::as_table);
    let material = materials.and_then(|m| m.keys().next()).cloned().unwrap_or_default();
    let mut filler = Filler { root: &root, material, filled: Vec::new() };
    let mut value = Value::Table(table);
    if filler.complete(&root, &mut value, "").is_none() {
        return Vec::new();
    }
    keys.append(&mut filler.filled);
    let without_scheme = WithoutScheme::of_value(&value);
    let Ok(mut model) = value.try_into::<Model>() else { return Vec::new() };
    without_scheme.complete(&mut model);
    let mut issues = check::keys(&model);
    // A mesh that does not fit into memory is a mistake of its own.
    match memory::too_large(&model, memory::limit()) {
        Some(issue) => issues.push(issue),
        None => match mesh_of(path, &model) {
            Ok(mut mesh) => {
                let of_sets = define_sets(&model.sets, &mut mesh);
                // Sets that cannot be made are missing elsewhere, too.
                if of_sets.is_empty() && !keys.iter().any(|key| key.starts_with("sets")) {
                    issues.extend(sets(&model, &mesh, &keys));
                }
                issues.extend(of_sets);
            }
            Err(list) => issues.extend(list),
        },
    }
    // What lies in a table that was changed, or names something in one, may only follow from the change.
    let changed: Vec<&str> = keys.iter().map(|k| table_of(k)).collect();
    let follows = |key: &str| {
        let names = |list: &str, last: &str| key.ends_with(last) && keys.iter().any(|k| k.starts_with(list));
        changed.contains(&key)
            || changed.contains(&table_of(key))
            || keys.iter().any(|k| key.starts_with(k.as_str()) || k.split(['.', '[']).next() == Some(key))
            || (key.starts_with("mesh") && keys.iter().any(|k| k.starts_with("mesh")))
            || (keys.iter().any(|k| k.starts_with("analysis"))
                && (key == "loads" || key.starts_with("amplitudes")))
            || names("materials", ".material")
            // Springs and drives have the axis of a joint.
            || names("joints", ".axis")
            || names("amplitudes", ".amplitude")
    };
    issues.retain(|i| !follows(&i.place.key));
    issues
}

fn mesh_of(path: &Path, model: &Model) -> Result<Mesh, Vec<Issue>> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let file = model.mesh.file();
    let read = file.and_then(|file| crate::mesh::read(&model.mesh, &folder.join(&file.file)));
    let (Some(file), Some(read)) = (file, read) else {
        return generate(&model.mesh).map_err(|e| match e {
            Error::Model(list) => list,
            _ => Vec::new(),
        });
    };
    let mut mesh = read.map_err(|e| vec![e.issue()])?.mesh;
    let issues = mesh.name_points(&file.points);
    if issues.is_empty() { Ok(mesh) } else { Err(issues) }
}

/// Mistakes of sets. A mesh that was changed has the names of the one that is meant, not its places; and
/// not even those where its type, its points or its file are concerned.
fn sets(model: &Model, mesh: &Mesh, keys: &[String]) -> Vec<Issue> {
    let mut issues = check::sets(model, mesh);
    let changed: Vec<&String> = keys.iter().filter(|k| k.starts_with("mesh")).collect();
    if changed.iter().any(|k| {
        ["type", "points", "file", "angles", "longitudes", "vertices"].iter().any(|part| k.contains(part))
    }) {
        return Vec::new();
    }
    if !changed.is_empty() {
        issues.retain(|issue| issue.message.starts_with("the mesh has no set"));
    }
    issues
}

/// Gives a model that was cut down what it cannot do without.
struct Filler<'s> {
    root: &'s Json,
    /// Name of a material of the model.
    material: String,
    /// Keys that were filled in.
    filled: Vec<String>,
}

impl<'s> Filler<'s> {
    /// Fills in all required keys in and below a value; none where nothing plausible is known.
    fn complete(&mut self, schema: &'s Json, value: &mut Value, path: &str) -> Option<()> {
        match (wanted(self.root, schema), value) {
            (Wanted::Table(keys) | Wanted::StringOrTable(keys), Value::Table(table)) => {
                self.table(keys, table, path)
            }
            (Wanted::Tagged(branches), Value::Table(table)) => {
                let chosen = table.get("type").and_then(Value::as_str).map(str::to_owned);
                // Without a type, the one that has most of the keys.
                let common = |(_, keys): &(&str, super::schema::Table<'_>)| {
                    keys.keys().filter(|key| table.contains_key(*key)).count()
                };
                let (tag, keys) = match chosen {
                    Some(tag) => branches.into_iter().find(|(name, _)| *name == tag)?,
                    None => branches.into_iter().min_by_key(|branch| std::cmp::Reverse(common(branch)))?,
                };
                if !table.contains_key("type") {
                    table.retain(|key, _| keys.get(key).is_some());
                    table.insert("type".into(), Value::String(tag.to_owned()));
                    self.filled.push(child(path, "type"));
                }
                self.table(keys, table, path)
            }
            (Wanted::Named(items), Value::Table(table)) => {
                table.iter_mut().try_for_each(|(name, value)| self.complete(items, value, &child(path, name)))
            }
            (Wanted::List(items, ..), Value::Array(list)) => list
                .iter_mut()
                .enumerate()
                .try_for_each(|(i, value)| self.complete(items, value, &format!("{path}[{i}]"))),
            _ => Some(()),
        }
    }

    fn table(&mut self, keys: super::schema::Table<'s>, table: &mut Table, path: &str) -> Option<()> {
        for key in keys.required().filter(|&key| !table.contains_key(key)).collect::<Vec<_>>() {
            table.insert(key.to_owned(), self.plausible(key, keys.get(key)?)?);
            self.filled.push(child(path, key));
        }
        for (key, value) in table.iter_mut() {
            if let Some(schema) = keys.get(key) {
                self.complete(schema, value, &child(path, key))?;
            }
        }
        Some(())
    }

    /// A value that is right on its own: within every range, and ascending in lists.
    fn plausible(&self, key: &str, schema: &'s Json) -> Option<Value> {
        const SMALL: f64 = 0.25;
        Some(match wanted(self.root, schema) {
            Wanted::Number => Value::Float(SMALL),
            Wanted::Integer(low, _) | Wanted::Count((low, _), _) => {
                Value::Integer(i64::try_from(low.max(1)).ok()?)
            }
            Wanted::Boolean => Value::Boolean(false),
            Wanted::Choice(choices) => Value::String((*choices.first()?).to_owned()),
            Wanted::String | Wanted::StringOrTable(_) => Value::String(match key {
                "on" => "all".into(),
                "material" => self.material.clone(),
                "expression" => "t".into(),
                "name" => "without name".into(),
                _ => return None,
            }),
            Wanted::List(items, low, _) => {
                let item = |i: usize| match self.plausible(key, items)? {
                    Value::Float(x) => Some(Value::Float(x * (i + 1) as f64)),
                    other => Some(other),
                };
                Value::Array((0..low).map(item).collect::<Option<_>>()?)
            }
            Wanted::Table(keys) => {
                let filled =
                    keys.required().map(|key| Some((key.to_owned(), self.plausible(key, keys.get(key)?)?)));
                Value::Table(filled.collect::<Option<_>>()?)
            }
            Wanted::Named(_) => Value::Table(Table::new()),
            Wanted::Tagged(_) | Wanted::Anything => return None,
        })
    }
}

fn child(path: &str, key: &str) -> String {
    super::locate::child(path, key)
}

/// The table that holds a key: the path up to its last dot.
fn table_of(key: &str) -> &str {
    key.rsplit_once('.').map_or("", |(table, _)| table)
}

/// Takes a key such as `sections[0].tickness` out, or the whole list for an entry such as `mesh.size[1]`; does
/// nothing if it is not a plain path to something that is there.
fn remove(table: &mut Table, key: &str) -> Option<Value> {
    let (parents, last) = key.rsplit_once('.').unwrap_or(("", key));
    let mut at = table;
    for part in parents.split('.').filter(|part| !part.is_empty()) {
        let (name, index) = match part.split_once('[') {
            Some((name, index)) => (name, Some(index.strip_suffix(']')?.parse::<usize>().ok()?)),
            None => (part, None),
        };
        at = match (at.get_mut(name)?, index) {
            (Value::Table(t), None) => t,
            (Value::Array(list), Some(i)) => list.get_mut(i)?.as_table_mut()?,
            _ => return None,
        };
    }
    at.remove(last.split('[').next().unwrap_or(last))
}
