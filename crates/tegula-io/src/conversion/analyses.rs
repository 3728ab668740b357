//! Analyses of a model file.

use super::document::Document;

/// Analysis of a step.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct StepAnalysis {
    /// Line of the card of the analysis.
    pub line: usize,
    /// Card of the analysis, as it is spelt in the file.
    pub card: &'static str,
    /// Name of the step; empty where it has none.
    pub name: String,
    /// Keys of the analysis with their values in TOML.
    pub keys: Vec<(&'static str, String)>,
}

impl StepAnalysis {
    /// Whether displacements are large.
    pub fn is_nonlinear(&self) -> bool {
        self.keys.iter().all(|(key, _)| *key != "linear")
    }

    /// Writes the table `head`, such as `[analysis]`.
    pub fn write(&self, out: &mut Document, head: &str) {
        out.table(self.line, head, self.card);
        for (key, value) in &self.keys {
            out.key(self.line, key, value);
        }
    }
}
