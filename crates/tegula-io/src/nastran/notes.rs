//! Warning of cards, commands and fields that have no effect.

use tegula::Issue;

use crate::conversion::{listed, without_effect};
use crate::mesh::nastran::cards::Card;

/// Cards, commands and fields without effect, each with its line.
#[derive(Debug, Default)]
pub(super) struct Notes {
    named: Vec<(String, usize)>,
    /// Whole phrases.
    pub phrases: Vec<String>,
}

impl Notes {
    /// Adds a card or a command.
    pub fn add(&mut self, name: impl Into<String>, line: usize) {
        self.named.push((name.into(), line));
    }

    /// Adds those of the fields of a card that are not blank.
    pub fn fields(&mut self, card: &Card<'_>, fields: &[(usize, &str)]) {
        for (index, name) in fields {
            let field = card.field(*index);
            if !field.text.is_empty() {
                self.add(format!("{name} of {}", card.name), field.line);
            }
        }
    }

    /// The warning.
    pub fn warning(&self) -> Option<Issue> {
        let named = listed("", self.named.iter().map(|(name, line)| (name.as_str(), *line)));
        let all: Vec<&str> =
            [named.as_str()].into_iter().chain(self.phrases.iter().map(String::as_str)).collect();
        let list: Vec<&str> = all.into_iter().filter(|part| !part.is_empty()).collect();
        without_effect("parts", &list.join("; "))
    }
}
