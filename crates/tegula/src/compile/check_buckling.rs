//! Checks of the keys of a buckling analysis.

use crate::checker::Checker;
use crate::model::{BucklingAnalysis, Model};

/// Number of factors, and a load that they multiply.
pub(super) fn buckling(model: &Model, buckling: &BucklingAnalysis, c: &mut Checker) {
    if buckling.factors == 0 {
        c.add("analysis.factors", "`factors` is 0", "give at least 1");
    }
    if model.loads.is_empty()
        && model.prescribed_strains.is_empty()
        && !model.conditions.iter().any(|condition| condition.motion().is_some())
    {
        c.add(
            "loads",
            "a buckling analysis without loads, prescribed strains and prescribed motions has no load that its factors multiply",
            "add a [[loads]] entry",
        );
    }
}
