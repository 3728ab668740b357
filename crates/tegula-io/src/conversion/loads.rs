//! Loads of a model file.

use super::document::{Document, number, quoted, vector};

/// A load of the model file.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Load {
    /// Card that it comes from, as it is spelt in the file.
    pub card: &'static str,
    /// Type in the model file.
    pub kind: &'static str,
    /// Set that it acts on; `None` for all masses.
    pub on: Option<String>,
    /// Components of the value; a pressure has one.
    pub value: Vec<f64>,
    /// Line of the card.
    pub line: usize,
}

impl Load {
    /// Writes the load as an entry of the list `head`, such as `[[loads]]`.
    pub fn write(&self, out: &mut Document, head: &str) {
        out.table(self.line, head, self.card);
        out.key(self.line, "type", &quoted(self.kind));
        if let Some(on) = &self.on {
            out.key(self.line, "on", &quoted(on));
        }
        match self.value[..] {
            [value] => out.key(self.line, "value", &number(value)),
            _ => out.key(self.line, "value", &vector(&self.value)),
        }
    }
}
