//! Suggestions for an unknown key.

use serde_json::Value;

use super::schema::{Table, Wanted, resolve, wanted};

/// Name among `candidates` of which `word` may be a misspelling.
pub(super) fn similar<'c>(word: &str, candidates: impl Iterator<Item = &'c str>) -> Option<&'c str> {
    closest(word, candidates, |length| (length / 3).max(1))
}

/// The candidate at the smallest edit distance, if within the `limit` for its length.
fn closest<'c>(
    word: &str,
    candidates: impl Iterator<Item = &'c str>,
    limit: impl Fn(usize) -> usize,
) -> Option<&'c str> {
    // No key is that long, and the distance takes time of the square of the length.
    if word.len() > 60 {
        return None;
    }
    let plain = |s: &str| s.to_lowercase().replace(['-', ' '], "_");
    let word = plain(word);
    candidates
        .map(|candidate| {
            let other = plain(candidate);
            let distance = strsim::damerau_levenshtein(&word, &other);
            let length = word.chars().count().min(other.chars().count());
            // At least one letter has to be right.
            (distance, distance <= limit(length) && distance < length.max(1), candidate)
        })
        .filter(|&(_, near, _)| near)
        .min_by_key(|&(distance, ..)| distance)
        .map(|(.., candidate)| candidate)
}

/// Place of an unknown key.
pub(super) struct Surroundings<'s, 'k> {
    /// Schema of the model.
    pub root: &'s Value,
    /// Path of the table.
    pub path: &'k str,
    /// Keys of the table.
    pub table: Table<'s>,
    /// The chosen `type` and all there are, where the table has one.
    pub branches: Option<(&'k str, &'k [(&'s str, Table<'s>)])>,
}

impl<'s> Surroundings<'s, '_> {
    /// Most likely intended key of this table for `key` or around it, and advice.
    pub fn advise(&self, key: &str) -> (Option<&'s str>, String) {
        let sure = closest(key, self.table.keys(), |length| usize::from(length > 3));
        let meant = match sure {
            Some(meant) => Some(meant),
            None => {
                if let Some(inner) = self.inner_table(key) {
                    let advice = format!("it belongs into the table \"{inner}\": {inner}.{key}");
                    return (Some(inner), advice);
                }
                if let Some(advice) = self.in_other_type(key).or_else(|| self.at_top_level(key)) {
                    return (None, advice);
                }
                similar(key, self.table.keys())
            }
        };
        if let Some(meant) = meant {
            return (Some(meant), format!("did you mean \"{meant}\"?"));
        }
        let here = list(self.table.keys());
        let help = match (self.in_one_other_place(key), here.is_empty()) {
            (Some(place), _) => format!("\"{key}\" is a key of \"{place}\"; here there are {here}"),
            (None, false) => format!("the keys here are {here}"),
            (None, true) => "there are no keys here".to_owned(),
        };
        (None, help)
    }

    /// The table in this one that has the key.
    fn inner_table(&self, key: &str) -> Option<&'s str> {
        self.table.keys().find(|name| {
            let schema = self.table.get(name).map(|schema| wanted(self.root, schema));
            matches!(schema, Some(Wanted::Table(inner)) if inner.get(key).is_some())
        })
    }

    fn in_other_type(&self, key: &str) -> Option<String> {
        let (chosen, branches) = self.branches?;
        let others = branches.iter().filter(|(_, table)| table.get(key).is_some()).map(|&(tag, _)| tag);
        let others = list(others);
        (!others.is_empty()).then(|| format!("\"{key}\" is a key of the type {others}, not of \"{chosen}\""))
    }

    fn at_top_level(&self, key: &str) -> Option<String> {
        let schema = self.root.get("properties")?.get(key).filter(|_| !self.path.is_empty())?;
        Some(match wanted(self.root, schema) {
            Wanted::Table(_) | Wanted::Tagged(_) | Wanted::Named(_) => {
                format!("it belongs to the top level of the file: [{key}]")
            }
            Wanted::List(..) => format!("it belongs to the top level of the file: [[{key}]]"),
            _ => "it belongs to the top level of the file, before the first [table]".to_owned(),
        })
    }

    /// The part of the model that has the key, if it is the only one.
    fn in_one_other_place(&self, key: &str) -> Option<&'s str> {
        let properties = self.root.get("properties")?.as_object()?;
        let mut places =
            properties.iter().filter(|(_, schema)| self.holds(schema, key)).map(|(name, _)| name);
        let place = places.next()?;
        places.next().is_none().then_some(place)
    }

    fn holds(&self, schema: &Value, key: &str) -> bool {
        let schema = resolve(self.root, schema);
        match wanted(self.root, schema) {
            Wanted::Table(table) => table.get(key).is_some(),
            Wanted::Tagged(branches) => branches.iter().any(|(_, table)| table.get(key).is_some()),
            Wanted::Named(items) => self.holds(items, key),
            Wanted::List(items, ..) => self.holds(items, key),
            _ => false,
        }
    }
}

/// The words in quotes with commas between them.
pub(super) fn list<'c>(words: impl IntoIterator<Item = &'c str>) -> String {
    words.into_iter().map(|word| format!("\"{word}\"")).collect::<Vec<_>>().join(", ")
}
