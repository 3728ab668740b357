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

/// Makes analyses of small displacements those of large ones, as the model has the part `name` on a `line`, which moves in these only; the phrase
/// tells which analysis is changed.
pub(crate) fn make_nonlinear<'a>(
    analyses: impl Iterator<Item = &'a mut StepAnalysis>,
    (name, line): (String, usize),
) -> Option<String> {
    let mut changed = None;
    for analysis in analyses.filter(|analysis| !analysis.is_nonlinear()) {
        analysis.keys.retain(|(key, _)| *key != "linear");
        changed = changed.or(Some((analysis.card, analysis.line)));
    }
    let (card, at) = changed?;
    Some(format!(
        "small displacements of {card} (line {at}), which may have any size here, as the model has {name} (line {line})"
    ))
}
