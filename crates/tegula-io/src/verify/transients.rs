//! Transient benchmarks: hinged plate pendulum (T5), oscillating clamped plate (T6).

use tegula::analysis::{Observer, Step, dynamics};
use tegula::model::Analysis;
use tegula::{Error, Result};

use super::model::{Compiled, read};
use super::reference::records;
use super::report::Report;

const HINGED: &str = include_str!("../../../../verification/models/hinged_plate.toml");
const OSCILLATING: &str = include_str!("../../../../verification/models/oscillating_plate.toml");
const REFERENCE: &str = include_str!("../../../../verification/reference/transients.csv");

/// T5: the history within 1 % of its range.
pub fn hinged_plate(report: &mut Report) -> Result<()> {
    compare(report, "hinged-plate", HINGED, "T5", 0.01)
}

/// T6: the history within 1 % of its range.
pub fn oscillating_plate(report: &mut Report) -> Result<()> {
    compare(report, "oscillating-plate", OSCILLATING, "T6", 0.01)
}

struct Deflection {
    vector: usize,
    rows: Vec<(f64, f64, f64)>,
}

impl Observer for Deflection {
    fn on_step(&mut self, step: &Step) -> Result<()> {
        self.rows.push((step.state.time, step.state.u[self.vector][2], step.state.v[self.vector][2]));
        Ok(())
    }
}

fn compare(report: &mut Report, case: &str, model: &str, prefix: &str, tolerance: f64) -> Result<()> {
    let model = read(model)?;
    let compiled = Compiled::new(&model)?;
    let Analysis::Transient(options) = &model.analysis else {
        return Err(Error::Outside("the model is not transient".into()));
    };
    let mut observer = Deflection { vector: compiled.point("u_max_v_min")?, rows: Vec::new() };
    let outcome = dynamics::run(&compiled.system, options, None, &mut observer)?;
    let reference: Vec<(f64, f64)> = records(REFERENCE)
        .iter()
        .filter(|r| r.text("case").starts_with(prefix))
        .map(|r| (r.number("time_s"), r.number("value")))
        .collect();
    let (low, high) = reference.iter().fold((0.0_f64, 0.0_f64), |(l, h), r| (l.min(r.1), h.max(r.1)));
    let at = |t: f64| {
        let rows = &observer.rows;
        let i = rows.partition_point(|r| r.0 < t).clamp(1, rows.len() - 1);
        let ((t0, x0, v0), (t1, x1, v1)) = (rows[i - 1], rows[i]);
        let (h, s) = (t1 - t0, (t - t0) / (t1 - t0));
        let a = s * s * (3.0 - 2.0 * s);
        (1.0 - a) * x0 + a * x1 + h * s * (1.0 - s) * ((1.0 - s) * v0 - s * v1)
    };
    let worst = reference
        .iter()
        .map(|(t, x)| (at(*t) - x).abs() / (high - low))
        .fold(0.0, |a: f64, b| if b.is_nan() { b } else { a.max(b) });
    report.at_most(case, "corner deflection, largest difference / range", "", worst, tolerance);
    report.at_most(case, "steps cut back", "", outcome.statistics.cutbacks as f64, outcome.statistics.steps as f64 * 0.02);
    Ok(())
}
