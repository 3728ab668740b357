//! Response of a model to small motions: `frequency_response.csv` with its picture, and the matrices of a state space.
//!
//! Outputs are the displacements of the recorded points, and displacements and small rotations of the bodies.

use nalgebra::{Complex, DMatrix};
use serde::Serialize;
use std::f64::consts::TAU;
use tegula::analysis::State;
use tegula::analysis::modal::{ReducedModel, Response};
use tegula::element::Nodal;
use tegula::system::coordinates::Body;
use tegula::{Model, System, Vec3};

use super::pictures::with_unit;
use super::{Prepared, ResultFolder, bodies};
use crate::out::{HistoryWriter, OutputError, matrix_market, write_whole};
use crate::plot::{LinePlot, Series, Style, lines};

/// Table of a frequency response, and its picture.
pub(super) const TABLE: &str = "frequency_response.csv";
pub(super) const PICTURE: &str = "frequency_response.png";
/// Names in a state space, and its matrices A, B, C, D.
pub(super) const STATE_SPACE: &str = "state_space.json";
pub(super) const MATRICES: [&str; 4] =
    ["state_space_a.mtx", "state_space_b.mtx", "state_space_c.mtx", "state_space_d.mtx"];

/// Curves in the picture.
const CURVES: usize = 8;

/// Outputs of a model, linear in its displacements.
struct Outputs {
    names: Vec<String>,
    /// Row for each output, column for each coordinate of the reduced model.
    matrix: DMatrix<f64>,
}

impl Outputs {
    fn new(prepared: &Prepared, about: &State, reduced: &ReducedModel) -> Self {
        let Prepared { system, probes, .. } = prepared;
        let mut names = Vec::new();
        for probe in probes {
            names.extend(["ux", "uy", "uz"].map(|column| format!("{}.{column}", probe.name)));
        }
        for body in bodies::shown(system) {
            let columns = ["ux", "uy", "uz", "rx", "ry", "rz"];
            let columns = if body.directors.is_some() { &columns[..] } else { &columns[..3] };
            names.extend(columns.iter().map(|column| format!("body.{}.{column}", body.name)));
        }
        let column = |shape: &Vec<Nodal>| {
            let motion = State { u: shape.clone(), ..State::default() };
            let mut column: Vec<f64> = probes.iter().flat_map(|probe| probe.displacement(&motion)).collect();
            for body in bodies::shown(system) {
                column.extend(shape[body.centre as usize]);
                column.extend(rotation(system, (about, body), shape).iter().flat_map(|r| [r.x, r.y, r.z]));
            }
            column
        };
        let columns: Vec<Vec<f64>> = reduced.shapes.iter().map(column).collect();
        let matrix = DMatrix::from_fn(names.len(), columns.len(), |i, j| columns[j][i]);
        Self { names, matrix }
    }
}

/// Small rotation `½ Σ d × δd` of a body with the directors d (rad).
fn rotation(system: &System, (about, body): (&State, &Body), shape: &[Nodal]) -> Option<Vec3> {
    let of = |v: u32| {
        let v = v as usize;
        let d = Vec3::from(system.coordinates.reference[v]) + Vec3::from(about.u[v]);
        d.cross(&Vec3::from(shape[v]))
    };
    Some(body.directors?.map(of).iter().sum::<Vec3>() * 0.5)
}

/// Writes what a response consists of. Returns a message where the picture is missing: the results do not depend on it.
///
/// # Errors
/// A file cannot be written.
pub(super) fn write(
    folder: &ResultFolder,
    prepared: &Prepared,
    model: &Model,
    (about, response): (&State, &Response),
) -> Result<Option<String>, OutputError> {
    let outputs = Outputs::new(prepared, about, &response.reduced);
    state_space(folder, &outputs, &response.reduced)?;
    if response.frequencies.is_empty() {
        return Ok(None);
    }
    let curves = curves(&outputs, response);
    table(folder, &response.frequencies, &curves)?;
    if !model.output.pictures {
        return Ok(None);
    }
    let drawn = lines(&folder.file(PICTURE), &plot(model, &response.frequencies, &curves));
    Ok(drawn.err().map(|problem| format!("a picture is missing: {problem}")))
}

/// Complex amplitudes of an output under an input at all frequencies.
struct Curve {
    name: String,
    /// Whether the output is a displacement.
    displacement: bool,
    values: Vec<Complex<f64>>,
}

impl Curve {
    fn peak(&self) -> f64 {
        tegula::norm::max_norm(self.values.iter().map(|value| value.norm()))
    }
}

/// Curves of all outputs under all inputs.
fn curves(outputs: &Outputs, response: &Response) -> Vec<Curve> {
    let reduced = &response.reduced;
    let matrix = outputs.matrix.map(Complex::from);
    let mut out = Vec::new();
    for (input, of_input) in reduced.names.iter().enumerate() {
        let new = |output: &String| Curve {
            name: format!("{output}/{of_input}"),
            displacement: output.rsplit('.').next().is_some_and(|column| column.starts_with('u')),
            values: Vec::with_capacity(response.frequencies.len()),
        };
        let mut of_outputs: Vec<Curve> = outputs.names.iter().map(new).collect();
        for frequency in &response.frequencies {
            let values = &matrix * reduced.response(TAU * frequency, input);
            of_outputs.iter_mut().zip(values.iter()).for_each(|(curve, value)| curve.values.push(*value));
        }
        out.extend(of_outputs);
    }
    out
}

/// Amplitudes, and phases in degrees above −180 and up to 180: negative where the output lags behind the input.
fn table(folder: &ResultFolder, frequencies: &[f64], curves: &[Curve]) -> Result<(), OutputError> {
    let mut names = vec!["frequency_hz".to_owned()];
    names.extend(curves.iter().flat_map(|c| ["amplitude", "phase"].map(|what| format!("{}.{what}", c.name))));
    let mut table = HistoryWriter::create(&folder.file(TABLE), &names)?;
    for (i, frequency) in frequencies.iter().enumerate() {
        let mut row = vec![*frequency];
        for curve in curves {
            let (amplitude, phase) = (curve.values[i].norm(), curve.values[i].arg().to_degrees());
            row.extend([amplitude, if phase <= -180.0 { 180.0 } else { phase }]);
        }
        table.append(&row)?;
    }
    table.sync()
}

/// Amplitudes of the displacements with the highest peaks.
fn plot(model: &Model, frequencies: &[f64], curves: &[Curve]) -> LinePlot {
    let mut shown: Vec<(f64, &Curve)> =
        curves.iter().filter(|curve| curve.displacement).map(|curve| (curve.peak(), curve)).collect();
    shown.sort_by(|a, b| b.0.total_cmp(&a.0));
    // Round-off of displacements that symmetry forbids is nothing to look at.
    let least = 1e-9 * shown.first().map_or(0.0, |(peak, _)| *peak);
    let left = shown.len().saturating_sub(CURVES);
    let series = shown.iter().filter(|(peak, _)| *peak > least).take(CURVES).map(|(_, curve)| Series {
        name: curve.name.clone(),
        points: frequencies.iter().copied().zip(curve.values.iter().map(|value| value.norm())).collect(),
        style: Style::Line,
    });
    let units = &model.output.units;
    LinePlot {
        title: if model.title.is_empty() {
            "Frequency response".into()
        } else {
            format!("{}: frequency response", model.title)
        },
        x_label: with_unit("frequency", units.of_frequency().as_deref()),
        y_label: with_unit("amplitude of displacement", units.length.as_deref()),
        series: series.collect(),
        x_log: frequencies.first().is_some_and(|first| *first > 0.0),
        y_log: true,
        note: if left > 0 {
            format!("The {CURVES} displacements with the highest peaks.")
        } else {
            String::new()
        },
    }
}

/// Names in a state space.
#[derive(Serialize)]
struct Names<'a> {
    /// Coordinates: modes first, then residual vectors. The states are the coordinates and behind them their rates.
    coordinates: Vec<Coordinate>,
    inputs: &'a [String],
    outputs: &'a [String],
    files: [&'static str; 4],
}

/// Coordinate of a state space.
#[derive(Serialize)]
struct Coordinate {
    kind: &'static str,
    /// Circular frequency [rad/time].
    omega: f64,
    damping_ratio: f64,
}

/// State space `ż = A z + B u`, `y = C z + D u` with the coordinates q and their rates as states z.
fn state_space(folder: &ResultFolder, outputs: &Outputs, reduced: &ReducedModel) -> Result<(), OutputError> {
    let n = reduced.lambdas.len();
    let inputs = reduced.names.len();
    let mut a = DMatrix::zeros(2 * n, 2 * n);
    let mut b = DMatrix::zeros(2 * n, inputs);
    let mut c = DMatrix::zeros(outputs.names.len(), 2 * n);
    for i in 0..n {
        a[(i, n + i)] = 1.0;
        a[(n + i, i)] = -reduced.lambdas[i];
    }
    a.view_mut((n, n), (n, n)).copy_from(&(-&reduced.damping));
    b.rows_mut(n, n).copy_from(&reduced.input);
    c.columns_mut(0, n).copy_from(&outputs.matrix);
    let d = DMatrix::zeros(outputs.names.len(), inputs);
    let comments = [
        "A: rates of the states by states; states are the modal coordinates and behind them their rates",
        "B: rates of the states by inputs",
        "C: outputs by states",
        "D: outputs by inputs; zero, since residual vectors carry the static response of higher modes",
    ];
    for ((name, comment), matrix) in MATRICES.into_iter().zip(comments).zip([&a, &b, &c, &d]) {
        matrix_market::write(&folder.file(name), comment, matrix)?;
    }
    let coordinate = |i: usize| Coordinate {
        kind: if i < reduced.modes { "mode" } else { "residual vector" },
        omega: reduced.lambdas[i].max(0.0).sqrt(),
        damping_ratio: reduced.damping_ratio(i),
    };
    let names = Names {
        coordinates: (0..n).map(coordinate).collect(),
        inputs: &reduced.names,
        outputs: &outputs.names,
        files: MATRICES,
    };
    let path = folder.file(STATE_SPACE);
    let text = serde_json::to_string_pretty(&names)
        .map_err(|e| OutputError::refused(&path, format!("it cannot be written as JSON: {e}")))?;
    write_whole(&path, |file| writeln!(file, "{text}"))
}
