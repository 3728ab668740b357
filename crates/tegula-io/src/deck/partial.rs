//! What else is wrong with a model file whose keys or values are wrong already.
//!
//! They are taken out; if the rest is a model, it is checked as one, so that the
//! person who repairs the file sees all of its mistakes and not only the first kind.

use std::path::Path;

use tegula::mesh::generators::generate;
use tegula::model::{MeshSource, check};
use tegula::{Error, Issue, Model};
use toml::{Table, Value};

use super::Diagnostic;

/// Issues of the model that is left without the keys of `found`; none where nothing is left that could be checked.
pub(super) fn issues(path: &Path, text: &str, found: &[Diagnostic]) -> Vec<Issue> {
    let Ok(mut table) = text.parse::<Table>() else { return Vec::new() };
    // From the back, so that the places of list entries before stay what they are.
    let mut keys: Vec<&str> = found.iter().map(|d| d.key.as_str()).collect();
    keys.sort_unstable();
    keys.dedup();
    for key in keys.iter().rev() {
        if !remove(&mut table, key) {
            return Vec::new();
        }
    }
    let Ok(model) = Value::Table(table).try_into::<Model>() else { return Vec::new() };
    let mut issues = check::keys(&model);
    let mesh = match &model.mesh {
        MeshSource::Gmsh(gmsh) => {
            let file = path.parent().unwrap_or(Path::new("")).join(&gmsh.file);
            crate::mesh::gmsh::read(&file, gmsh.scale).map_err(|e| vec![e.issue()])
        }
        generator => generate(generator).map_err(|e| match e {
            Error::Model(list) => list,
            _ => Vec::new(),
        }),
    };
    match mesh {
        Ok(mesh) => issues.extend(check::sets(&model, &mesh)),
        Err(list) => issues.extend(list),
    }
    // What lies in a table that was changed, or names something in one, may only follow from the change.
    let changed: Vec<&str> = keys.iter().map(|k| table_of(k)).collect();
    let follows = |key: &str| {
        let names = |list: &str, last: &str| key.ends_with(last) && keys.iter().any(|k| k.starts_with(list));
        changed.contains(&key)
            || changed.contains(&table_of(key))
            || keys.iter().any(|k| key.starts_with(k) || k.split(['.', '[']).next() == Some(key))
            || names("materials", ".material")
            || names("amplitudes", ".amplitude")
    };
    issues.retain(|i| !follows(&i.place.key));
    issues
}

/// The table that holds a key: the path up to its last dot.
fn table_of(key: &str) -> &str {
    key.rsplit_once('.').map_or("", |(table, _)| table)
}

/// Takes a key such as `sections[0].tickness` out; false if it is not a plain path to something that is there.
fn remove(table: &mut Table, key: &str) -> bool {
    let Some((parents, last)) = key.rsplit_once('.') else { return table.remove(key).is_some() };
    let mut at = table;
    for part in parents.split('.') {
        let (name, index) = match part.split_once('[') {
            Some((name, index)) => (name, index.strip_suffix(']').and_then(|i| i.parse::<usize>().ok())),
            None => (part, None),
        };
        let next = match (at.get_mut(name), index) {
            (Some(Value::Table(t)), None) => t,
            (Some(Value::Array(list)), Some(i)) => match list.get_mut(i) {
                Some(Value::Table(t)) => t,
                _ => return false,
            },
            _ => return false,
        };
        at = next;
    }
    at.remove(last).is_some()
}
