//! Conversion between the path of a key, such as `loads[2].on`, and its place in the text.

use std::ops::Range;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// The path of `key` in the table `parent`; names that are not plain are quoted.
pub(super) fn child(parent: &str, key: &str) -> String {
    let plain = !key.is_empty() && key.chars().all(|c| c.is_alphanumeric() || c == '_' || c == '-');
    let dot = if parent.is_empty() { "" } else { "." };
    if plain { format!("{parent}{dot}{key}") } else { format!("{parent}{dot}{key:?}") }
}

/// The bytes of the value at `path`, or of the innermost table or list around it that is in the text.
pub(super) fn span_of(root: &DeTable<'_>, path: &str) -> Range<usize> {
    let Some((mut value, mut rest)) = in_table(root, path) else { return 0..0 };
    loop {
        let next = match value.get_ref() {
            DeValue::Table(table) => in_table(table, rest),
            DeValue::Array(items) => in_list(items, rest),
            _ => None,
        };
        match next {
            Some(found) => (value, rest) = found,
            None => return value.span(),
        }
    }
}

type Step<'t, 'i, 'p> = Option<(&'t Spanned<DeValue<'i>>, &'p str)>;

/// The value of the key with which `path` begins, and the path behind it. Names may hold dots and
/// brackets without quotes: the longest that fits is taken.
fn in_table<'t, 'i, 'p>(table: &'t DeTable<'i>, path: &'p str) -> Step<'t, 'i, 'p> {
    let path = path.strip_prefix('.').unwrap_or(path);
    let behind = |key: &str| {
        let quoted = || path.strip_prefix(format!("{key:?}").as_str());
        let rest = path.strip_prefix(key).filter(|_| !key.is_empty()).or_else(quoted)?;
        (rest.is_empty() || rest.starts_with(['.', '['])).then_some(rest)
    };
    table
        .iter()
        .filter_map(|(key, value)| Some((value, behind(key.get_ref())?)))
        .min_by_key(|(_, rest)| rest.len())
}

/// The entry of a list that `[i]` at the beginning of `path` means, and the path behind it.
fn in_list<'t, 'i, 'p>(items: &'t [Spanned<DeValue<'i>>], path: &'p str) -> Step<'t, 'i, 'p> {
    let (index, rest) = path.strip_prefix('[')?.split_once(']')?;
    Some((items.get(index.parse::<usize>().ok()?)?, rest))
}

/// The path of the innermost key whose name or value covers the byte `offset`; empty if none does.
pub(super) fn key_at(root: &DeTable<'_>, offset: usize) -> String {
    let mut best = (usize::MAX, String::new());
    let mut open: Vec<(String, &Spanned<DeValue<'_>>)> = Vec::new();
    let mut cover = |path: &str, span: Range<usize>| {
        if span.contains(&offset) && span.len() < best.0 {
            best = (span.len(), path.to_owned());
        }
    };
    for (key, value) in root {
        let path = child("", key.get_ref());
        cover(&path, key.span());
        open.push((path, value));
    }
    while let Some((path, value)) = open.pop() {
        cover(&path, value.span());
        match value.get_ref() {
            DeValue::Table(table) => {
                for (key, value) in table {
                    let path = child(&path, key.get_ref());
                    cover(&path, key.span());
                    open.push((path, value));
                }
            }
            DeValue::Array(items) => {
                open.extend(items.iter().enumerate().map(|(i, item)| (format!("{path}[{i}]"), item)));
            }
            _ => {}
        }
    }
    best.1
}
