//! Modes in the result folder: table, shapes, picture.

use tegula::analysis::State;
use tegula::analysis::modal::Mode;
use tegula::element::Nodal;
use tegula::model::{Field, Output};
use tegula::result::recovery;
use tegula::{Mesh, System};

use super::pictures::short;
use super::series::{FieldSeries, MODES};
use super::{Prepared, ResultFolder, drawn_outline, fields};
use crate::out::{HistoryWriter, OutputError};
use crate::plot::{Snapshot, SurfacePlot, surfaces};

/// Modes in the picture.
const PICTURED: usize = 6;
/// Columns of the picture.
const COLUMNS: usize = 3;
/// Largest displacement in the picture, as a part of the model.
const AMPLITUDE: f64 = 0.12;

/// Fields that a mode has none of: its amplitude is arbitrary.
pub(super) const WITHOUT: [Field; 3] = [Field::Velocity, Field::Failure, Field::PlasticStrain];

/// Rows of `modes.csv`, and for each the shapes with their time values.
type Row = (Vec<f64>, Vec<(f64, Vec<Nodal>)>);

/// Writes `modes.csv` with columns of these names, `modes.pvd` and the shapes with their stresses, small motions about a state; the time
/// value of a shape is the number of its mode. Frequencies would not do: viewers show one of several shapes with the same time, as
/// rigid modes and those of symmetric models have.
pub(super) fn write(
    folder: &ResultFolder,
    prepared: &Prepared,
    (output, about): (&Output, &State),
    names: &[&str],
    rows: impl Iterator<Item = Row>,
) -> Result<(), OutputError> {
    let Prepared { mesh, system, .. } = prepared;
    let mut table = HistoryWriter::create(&folder.file("modes.csv"), names)?;
    let mut series = FieldSeries::create(folder, prepared, MODES)?;
    let fields = output.fields.iter().copied().filter(|f| !WITHOUT.contains(f)).collect();
    let output = Output { fields, ..output.clone() };
    let mut written = 0;
    for (row, shapes) in rows {
        table.append(&row)?;
        for (time, shape) in &shapes {
            let frame = fields::Frame { state: about, small: Some(shape), forces: None, time: *time };
            let results = recovery::shells(&frame.snapshot(system));
            written += 1;
            series.write(folder, (mesh, system, &output), (written, &frame), &results)?;
        }
    }
    table.sync()
}

/// Writes vibration modes.
pub(super) fn write_frequencies(
    folder: &ResultFolder,
    prepared: &Prepared,
    output: &Output,
    about: &State,
    modes: &[Mode],
) -> Result<(), OutputError> {
    let parts = || modes.iter().filter_map(|mode| mode.complex.as_ref());
    let (complex, turns) = (parts().next().is_some(), parts().any(|part| part.speed != 0.0));
    let names = ["mode", "frequency_hz", "omega", "rigid", "residual", "growth", "fixed_frame_omega"];
    let names = &names[..5 + usize::from(complex) + usize::from(turns)];
    let row = |(i, mode): (usize, &Mode)| {
        let rigid = f64::from(u8::from(mode.rigid));
        let number = (i + 1) as f64;
        let mut row = vec![number, mode.frequency_hz, mode.omega, rigid, mode.residual];
        let mut shapes = vec![(number, mode.shape.clone())];
        if let Some(part) = &mode.complex {
            row.push(part.growth);
            // A quarter period later the motion has the shape −quadrature.
            shapes.push((number + 0.25, part.quadrature.iter().map(|x| x.map(|x| -x)).collect()));
        } else if complex {
            row.push(0.0);
        }
        if turns {
            let frame = mode.complex.as_ref().map_or(Some(mode.omega), |part| part.fixed_frame);
            row.push(frame.unwrap_or(f64::NAN));
        }
        (row, shapes)
    };
    write(folder, prepared, (output, about), names, modes.iter().enumerate().map(row))
}

/// A picture of the lowest modes that are not rigid, labelled with their frequencies.
pub(super) fn picture_of_frequencies(
    folder: &ResultFolder,
    prepared: &Prepared,
    title: &str,
    unit: Option<&str>,
    modes: &[Mode],
) -> Result<(), OutputError> {
    let unit = unit.map_or(String::new(), |unit| format!(" {unit}"));
    let label = |mode: &Mode| format!("f = {}{unit}", short(mode.frequency_hz));
    let elastic = modes.iter().filter(|m| !m.rigid).map(|mode| (mode.shape.as_slice(), label(mode)));
    picture(folder, prepared, if title.is_empty() { "Modes" } else { title }, elastic)
}

/// A picture of the first shapes, with their labels.
pub(super) fn picture<'a>(
    folder: &ResultFolder,
    prepared: &Prepared,
    title: &str,
    shapes: impl Iterator<Item = (&'a [Nodal], String)>,
) -> Result<(), OutputError> {
    let Prepared { mesh, system, .. } = prepared;
    let tile = |(i, (shape, label))| tile(mesh, system, (shape, label), i);
    let snapshots: Vec<Snapshot> = shapes.take(PICTURED).enumerate().map(tile).collect();
    if snapshots.is_empty() {
        return Ok(());
    }
    let plot = SurfacePlot {
        title: title.to_owned(),
        snapshots,
        quads: mesh.quads.clone(),
        bodies: drawn_outline::faces(system, mesh.positions.len()),
        color_label: "displacement over its maximum".into(),
        ..SurfacePlot::default()
    };
    surfaces(&folder.file("modes.png"), &plot)
}

/// A mode in its place of the picture: columns to the right, rows downwards.
fn tile(mesh: &Mesh, system: &System, (shape, label): (&[Nodal], String), index: usize) -> Snapshot {
    let u = fields::nodal(system, shape);
    let size = |u: &Nodal| u.iter().map(|x| x * x).sum::<f64>().sqrt();
    let of_bodies = system.outline.displacements(shape);
    let largest = u.iter().chain(&of_bodies).map(size).fold(0.0, tegula::norm::larger).max(f64::MIN_POSITIVE);
    let scale = AMPLITUDE * system.length / largest;
    let (azimuth, step) = ((-60.0_f64).to_radians(), 1.7 * system.length);
    let (column, row) = ((index % COLUMNS) as f64, (index / COLUMNS) as f64);
    let shift = [-azimuth.sin() * column * step, azimuth.cos() * column * step, -0.75 * row * step];
    let mut positions = fields::positions(mesh, system, shape, scale);
    positions.extend(drawn_outline::positions(system, shape, scale));
    for x in &mut positions {
        *x = std::array::from_fn(|i| x[i] + shift[i]);
    }
    let mean = |quad: &[u32; 4]| quad.iter().map(|&n| size(&u[n as usize])).sum::<f64>() / (4.0 * largest);
    Snapshot { positions, values: Some(mesh.quads.iter().map(mean).collect()), label, ..Snapshot::default() }
}
