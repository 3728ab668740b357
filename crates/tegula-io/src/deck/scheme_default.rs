//! Default of the scheme of time integration where the model has bodies, beams, joints, ties or springs, which Newmark's scheme does not move:
//! energy–momentum, or generalised-α where a material yields, whose dissipation the former does not follow.

use tegula::Model;
use tegula::model::{Analysis, EnergyMomentumScheme, GeneralizedAlphaScheme, Material, Scheme};
use toml::Value;
use toml::de::{DeTable, DeValue};

/// Analyses of a model file that have no key `scheme`.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct WithoutScheme {
    /// Whether `analysis` has none.
    whole: bool,
    /// Whether the analysis of each entry of `steps` has none.
    steps: Vec<bool>,
}

impl WithoutScheme {
    /// Analyses without a scheme in the syntax tree of a file.
    pub fn of(tree: &DeTable<'_>) -> Self {
        let lacks = |table: &DeTable<'_>| {
            let analysis = table.get("analysis").map(|value| value.get_ref());
            matches!(analysis, Some(DeValue::Table(analysis)) if !analysis.contains_key("scheme"))
        };
        let steps = match tree.get("steps").map(|value| value.get_ref()) {
            Some(DeValue::Array(list)) => list.iter().collect(),
            _ => Vec::new(),
        };
        let of_step = |step: &toml::Spanned<DeValue<'_>>| matches!(step.get_ref(), DeValue::Table(table) if lacks(table));
        Self { whole: lacks(tree), steps: steps.into_iter().map(of_step).collect() }
    }

    /// Analyses without a scheme in a table.
    pub fn of_value(value: &Value) -> Self {
        let lacks =
            |value: &Value| value.get("analysis").is_some_and(|analysis| analysis.get("scheme").is_none());
        let steps = value.get("steps").and_then(Value::as_array);
        Self { whole: lacks(value), steps: steps.into_iter().flatten().map(lacks).collect() }
    }

    /// Gives a scheme to analyses of a mechanism that have none.
    pub fn complete(&self, model: &mut Model) {
        if !model.is_mechanism() {
            return;
        }
        let scheme = match model.materials.values().any(Material::yields) {
            true => Scheme::GeneralizedAlpha(GeneralizedAlphaScheme::default()),
            false => Scheme::EnergyMomentum(EnergyMomentumScheme::default()),
        };
        let complete = |analysis: &mut Analysis| {
            if let Analysis::Transient(options) = analysis
                && !options.linear
            {
                options.scheme = scheme;
            }
        };
        if self.whole {
            complete(&mut model.analysis);
        }
        for (step, _) in model.steps.iter_mut().zip(&self.steps).filter(|(_, lacks)| **lacks) {
            complete(&mut step.analysis);
        }
    }
}
