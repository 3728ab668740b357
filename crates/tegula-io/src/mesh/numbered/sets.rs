//! Named sets of nodes and elements by their numbers.

use std::collections::{BTreeSet, HashMap};

/// Named sets of numbers. Upper and lower case are the same; a set has the spelling with which it first stands in the file.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Sets {
    index: HashMap<String, usize>,
    list: Vec<(String, BTreeSet<u64>)>,
    /// A member that stands twice in a set, by the name of the set in capitals.
    repeated: HashMap<String, u64>,
}

impl Sets {
    /// Adds members to the set `name`; a new set where there is none.
    pub fn extend(&mut self, name: &str, members: impl IntoIterator<Item = u64>) {
        let (next, capitals) = (self.list.len(), name.to_uppercase());
        let at = *self.index.entry(capitals.clone()).or_insert(next);
        if at == next {
            self.list.push((name.to_owned(), BTreeSet::new()));
        }
        let Some((_, set)) = self.list.get_mut(at) else { return };
        for member in members {
            if !set.insert(member) {
                self.repeated.entry(capitals.clone()).or_insert(member);
            }
        }
    }

    /// A member that the file lists twice in the set `name`, where there is one.
    pub fn repeated(&self, name: &str) -> Option<u64> {
        self.repeated.get(&name.to_uppercase()).copied()
    }

    /// Spelling and members of the set `name`.
    pub fn get(&self, name: &str) -> Option<(&str, &BTreeSet<u64>)> {
        let (spelling, members) = self.list.get(*self.index.get(&name.to_uppercase())?)?;
        Some((spelling, members))
    }

    /// All sets in the order of the file.
    pub fn iter(&self) -> impl Iterator<Item = (&str, &BTreeSet<u64>)> {
        self.list.iter().map(|(name, members)| (name.as_str(), members))
    }
}
