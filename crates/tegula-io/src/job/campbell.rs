//! Campbell diagram: frequencies of a model over the angular velocity with which it turns, as a table and a picture.

use std::f64::consts::TAU;

use tegula::Result;
use tegula::analysis::modal::{self, ModalOutcome, Mode};
use tegula::analysis::{Observer, State};
use tegula::model::{Analysis, Load, ModalAnalysis};

use super::pictures::with_unit;
use super::{Prepared, ResultFolder};
use crate::out::{HistoryWriter, OutputError};
use crate::plot::{LinePlot, Series, Style, lines};

/// Table of the frequencies, and its picture.
pub(super) const TABLE: &str = "campbell.csv";
pub(super) const PICTURE: &str = "campbell.png";

/// Frequencies of a mode.
struct Frequency {
    speed: f64,
    number: usize,
    /// Circular frequency in the frame that turns with the model [rad/time].
    omega: f64,
    growth: f64,
    /// Circular frequency in the fixed frame [rad/time], negative for backward whirl; none for motions that do not whirl in one sense.
    fixed_frame: Option<f64>,
}

/// Modes at several angular velocities.
pub(super) struct Campbell {
    rows: Vec<Frequency>,
    /// Angular velocities, ascending or not, as the model has them.
    speeds: Vec<f64>,
}

/// Modes at all angular velocities of an analysis, with the relative equilibrium and the modes at the last one.
///
/// # Errors
/// Errors of the equilibrium and of the modes.
pub(super) fn run(
    prepared: &Prepared,
    analysis: &ModalAnalysis,
    observer: &mut dyn Observer,
) -> Result<(Campbell, Option<(State, ModalOutcome)>)> {
    let mut out = Campbell { rows: Vec::new(), speeds: analysis.speeds.clone() };
    let mut last = None;
    let mut model = (*prepared.model).clone();
    model.analysis = Analysis::Modal(ModalAnalysis { speeds: Vec::new(), ..analysis.clone() });
    for &speed in &analysis.speeds {
        for load in &mut model.loads {
            if let Load::Centrifugal(load) = load {
                load.velocity = speed;
            }
        }
        let system = prepared.own.compiler(&model, &prepared.mesh)?.system(0, None)?;
        let state = modal::prestress(&system, observer)?.state;
        let outcome = modal::run(&system, analysis.modes as usize, Some(&state), observer)?;
        out.rows.extend(outcome.modes.iter().enumerate().map(|(i, mode)| frequency(speed, i + 1, mode)));
        last = Some((state, outcome));
    }
    Ok((out, last))
}

fn frequency(speed: f64, number: usize, mode: &Mode) -> Frequency {
    let Mode { omega, complex, .. } = mode;
    // At rest both frames are one.
    let fixed_frame = complex.as_ref().map_or(Some(*omega), |part| part.fixed_frame);
    let growth = complex.as_ref().map_or(0.0, |part| part.growth);
    Frequency { speed, number, omega: *omega, growth, fixed_frame }
}

/// Writes `campbell.csv`.
pub(super) fn write(folder: &ResultFolder, campbell: &Campbell) -> std::result::Result<(), OutputError> {
    let names = ["speed", "mode", "omega", "growth", "fixed_frame_omega", "fixed_frame_frequency_hz"];
    let mut table = HistoryWriter::create(&folder.file(TABLE), &names)?;
    for row in &campbell.rows {
        let fixed = row.fixed_frame.unwrap_or(f64::NAN);
        table.append(&[row.speed, row.number as f64, row.omega, row.growth, fixed, fixed.abs() / TAU])?;
    }
    table.sync()
}

/// Draws the frequencies in the fixed frame over the angular velocity, with the line of the rotation itself.
pub(super) fn picture(
    folder: &ResultFolder,
    campbell: &Campbell,
    (title, unit): (&str, Option<&str>),
) -> std::result::Result<(), OutputError> {
    let of = |name: &str, wanted: &dyn Fn(&Frequency) -> Option<f64>| Series {
        name: name.into(),
        points: campbell.rows.iter().filter_map(|row| Some((row.speed, wanted(row)?.abs() / TAU))).collect(),
        style: Style::Markers,
    };
    let forward = |row: &Frequency| row.fixed_frame.filter(|omega| *omega >= 0.0);
    let backward = |row: &Frequency| row.fixed_frame.filter(|omega| *omega < 0.0);
    let other = |row: &Frequency| row.fixed_frame.is_none().then_some(row.omega);
    let mut speeds = campbell.speeds.clone();
    speeds.sort_by(f64::total_cmp);
    let series = vec![
        of("forward whirl, or none", &forward),
        of("backward whirl", &backward),
        of("no whirl in one sense (frame of the model)", &other),
        Series {
            name: "rotation".into(),
            points: speeds.iter().map(|speed| (*speed, speed.abs() / TAU)).collect(),
            style: Style::Dashed,
        },
    ];
    let plot = LinePlot {
        title: if title.is_empty() {
            "Campbell diagram".into()
        } else {
            format!("{title}: Campbell diagram")
        },
        x_label: "angular velocity [rad/time]".into(),
        y_label: with_unit("frequency in the fixed frame", unit),
        series: series.into_iter().filter(|series| !series.points.is_empty()).collect(),
        ..LinePlot::default()
    };
    lines(&folder.file(PICTURE), &plot)
}
