//! Checks of a report: the trust that a result deserves.

use serde::Serialize;

use crate::job::{IMBALANCE, Status, Summary};
use crate::out::numbers::significant;

/// Verdict on a check.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub(super) enum Verdict {
    /// As it should be.
    Good,
    /// Needs a look.
    Doubtful,
    /// The result is not to be used.
    Bad,
    /// A number without a limit.
    Fact,
}

/// A line of the table of checks.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Check {
    /// Quantity.
    pub name: &'static str,
    /// Its value in words.
    pub value: String,
    /// Verdict.
    pub verdict: Verdict,
}

/// Size in bytes with a unit.
fn bytes(n: u64) -> String {
    format!("{} MB", significant(n as f64 / 1e6, 3))
}

/// The checks of a run.
pub(super) fn of(s: &Summary) -> Vec<Check> {
    let mut out = Vec::new();
    let mut add = |name, value: String, verdict| out.push(Check { name, value, verdict });
    let (words, verdict) = match s.status {
        Status::Complete => ("complete", Verdict::Good),
        Status::Running => ("not ended, or the run was killed", Verdict::Doubtful),
        Status::Interrupted => ("interrupted", Verdict::Doubtful),
        Status::Failed => ("failed", Verdict::Bad),
    };
    add("Status", words.into(), verdict);
    if let Some(error) = &s.error {
        add("Reason", error.clone(), Verdict::Bad);
    }
    match s.warnings.len() {
        0 => add("Warnings", "none".into(), Verdict::Good),
        n => add("Warnings", format!("{n}, listed below"), Verdict::Doubtful),
    }
    if let Some(balance) = &s.balance {
        for (name, error) in [("Balance of forces", balance.force), ("Balance of moments", balance.moment)] {
            let verdict = if error <= IMBALANCE { Verdict::Good } else { Verdict::Doubtful };
            add(name, format!("{} of their sum", significant(error, 2)), verdict);
        }
    }
    match s.negative_pivots {
        Some(n) if n > 0 => {
            let pivots = if n == 1 { "1 negative pivot".into() } else { format!("{n} negative pivots") };
            let value = format!("{pivots} of the tangent: the equilibrium may be unstable");
            add("Stability", value, Verdict::Doubtful);
        }
        None if s.analysis == "static" && s.status == Status::Complete => {
            add("Stability", "no negative pivot of the tangent".into(), Verdict::Good);
        }
        _ => {}
    }
    if let Some(error) = s.energy_error {
        add(
            "Error of the energy balance",
            format!("{} of the largest energy", significant(error, 2)),
            Verdict::Fact,
        );
    }
    match s.sturm_checked {
        Some(true) => {
            add("Modes", "a Sturm sequence count confirms that none is missing".into(), Verdict::Good)
        }
        Some(false) => add("Modes", "not confirmed that none is missing".into(), Verdict::Doubtful),
        None => {}
    }
    if let Some(stop) = &s.stop {
        let parameter = if s.analysis == "transient" { "time" } else { "load factor" };
        let (value, time) = (significant(stop.value, 9), significant(stop.time, 9));
        let value = format!("`{}` has crossed {value} at {parameter} {time}", stop.column);
        add("Stop condition", value, Verdict::Fact);
    }
    if s.frequencies_hz.is_none() && s.load_factors.is_none() && s.analyses.is_empty() {
        let parameter = if s.analysis == "transient" { "Time" } else { "Load factor" };
        let end = if s.analysis == "path" { String::new() } else { format!(" of {}", significant(s.end, 9)) };
        add(parameter, format!("{}{end}", significant(s.time, 9)), Verdict::Fact);
        let per_step = s.iterations as f64 / s.steps.max(1) as f64;
        // Steps of power series have no iterations.
        let each = if s.iterations > 0 {
            format!(", {} iterations each", significant(per_step, 3))
        } else {
            String::new()
        };
        add("Steps", format!("{}{each}, {} cut back", s.steps, s.cutbacks), Verdict::Fact);
    }
    add("Factorisations", s.factorizations.to_string(), Verdict::Fact);
    add("Model", format!("{} shell elements, {} unknowns", s.elements, s.unknowns), Verdict::Fact);
    if s.mass != 0.0 {
        add("Mass", significant(s.mass, 9), Verdict::Fact);
    }
    let memory = s.peak_memory_bytes.map(|n| format!(", {} of memory", bytes(n))).unwrap_or_default();
    add("Cost", format!("{} s on {} threads{memory}", significant(s.wall_s, 3), s.threads), Verdict::Fact);
    out
}
