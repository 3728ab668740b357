//! Tables and pictures of a work-precision study.

use std::fmt::Write as _;
use std::path::Path;

use super::{Reference, Row, Stepping, Transient, schemes};
use tegula::model::Scheme;
use tegula_io::out::OutputError;
use tegula_io::plot::{LinePlot, Series, Style, lines};

/// Measure of cost, the abscissa of a work-precision diagram.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Cost {
    /// Processor seconds of all threads.
    Seconds,
    /// Iterations, with factorisations at their cost; implicit schemes only.
    Work,
}

fn stepping_kind(stepping: Stepping) -> &'static str {
    match stepping {
        Stepping::Fixed(_) => "constant",
        Stepping::Tolerance(_) => "automatic",
        Stepping::Critical(_) => "critical",
    }
}

fn stepping_value(stepping: Stepping) -> f64 {
    match stepping {
        Stepping::Fixed(x) | Stepping::Tolerance(x) | Stepping::Critical(x) => x,
    }
}

/// Step length or tolerance as text.
fn steps(stepping: Stepping) -> String {
    match stepping {
        Stepping::Fixed(step) => {
            let step = format!("{:.4}", 1e3 * step);
            format!("{} ms", step.trim_end_matches('0').trim_end_matches('.'))
        }
        Stepping::Tolerance(tolerance) => format!("tolerance {tolerance:.0e}"),
        Stepping::Critical(part) => format!("{part} of the critical step"),
    }
}

/// All rows as comma-separated values.
pub fn csv(rows: &[Row]) -> String {
    let mut out = String::from(
        "transient,scheme,steps,step_or_tolerance,taken,repeated,iterations,factorizations,work,cpu_s,error,failure\n",
    );
    for r in rows {
        let s = &r.statistics;
        let _ = writeln!(
            out,
            "{},{},{},{:e},{},{},{},{},{:.1},{:.4},{:.4e},{}",
            r.transient.name(),
            r.scheme.name(),
            stepping_kind(r.stepping),
            stepping_value(r.stepping),
            s.steps,
            s.cutbacks,
            s.iterations,
            s.factorizations,
            r.work,
            r.seconds,
            r.error,
            r.failure.replace([',', '\n'], ";")
        );
    }
    out
}

/// Tables in Markdown, one for each transient.
pub fn markdown(references: &[Reference], rows: &[Row]) -> String {
    let mut out = String::new();
    for reference in references {
        let _ = writeln!(
            out,
            "{}**{}**: {} unknowns, a factorisation at the cost of {:.1} iterations; the reference is extrapolated \
             from steps of {:.2e} ms and twice that, which moves it by {:.0e}\n\n\
             | scheme | steps | taken | repeated | iterations | factorisations | work | CPU s | error |\n\
             |:--|:--|---:|---:|---:|---:|---:|---:|---:|",
            if out.is_empty() { "" } else { "\n" },
            reference.transient.title(),
            reference.unknowns,
            reference.price,
            1e3 * reference.step,
            reference.uncertainty
        );
        for r in rows.iter().filter(|r| r.transient == reference.transient) {
            let steps = steps(r.stepping);
            let name = r.scheme.name();
            if !r.failure.is_empty() {
                let _ = writeln!(out, "| {name} | {steps} | – | – | – | – | – | – | failed |");
                continue;
            }
            let s = &r.statistics;
            let (iterations, work) = match r.scheme {
                Scheme::Explicit(_) => ("–".into(), "–".into()),
                _ => (s.iterations.to_string(), format!("{:.0}", r.work)),
            };
            let _ = writeln!(
                out,
                "| {name} | {steps} | {} | {} | {iterations} | {} | {work} | {:.3} | {:.1e} |",
                s.steps, s.cutbacks, s.factorizations, r.seconds, r.error
            );
        }
    }
    out
}

/// Draws the errors of a transient over what they cost, a line for each scheme and kind of steps.
///
/// # Errors
/// The file cannot be written.
pub fn picture(path: &Path, transient: Transient, rows: &[Row], cost: Cost) -> Result<(), OutputError> {
    let mut series = Vec::new();
    for automatic in [true, false] {
        for scheme in schemes() {
            let explicit = matches!(scheme, Scheme::Explicit(_));
            if explicit && (automatic || cost == Cost::Work) {
                continue;
            }
            let of_line = |r: &&Row| {
                let fits = matches!(r.stepping, Stepping::Tolerance(_)) == automatic;
                r.transient == transient && r.scheme.name() == scheme.name() && fits
            };
            let points = rows
                .iter()
                .filter(of_line)
                .map(|r| (if cost == Cost::Work { r.work } else { r.seconds }, r.error))
                // What failed has neither.
                .filter(|p| p.0.is_finite() && p.1.is_finite())
                .collect();
            let name = match (explicit, automatic) {
                (true, _) => scheme.name().to_string(),
                (_, true) => format!("{}, automatic", scheme.name()),
                (_, false) => format!("{}, constant", scheme.name()),
            };
            series.push(Series { name, points, style: Style::Both });
        }
    }
    let mut note = "Lower left is better. Against the same mesh with a much shorter step.".to_string();
    for r in rows.iter().filter(|r| r.transient == transient && !r.failure.is_empty()) {
        let _ = write!(note, " {} with {} failed.", r.scheme.name(), steps(r.stepping));
    }
    let plot = LinePlot {
        title: format!("Error and cost: {}", transient.title()),
        x_label: match cost {
            Cost::Seconds => "processor time [s]".into(),
            Cost::Work => "iterations, factorisations at their cost".into(),
        },
        y_label: "error of position / size of the model".into(),
        series,
        x_log: true,
        y_log: true,
        note,
    };
    lines(path, &plot)
}
