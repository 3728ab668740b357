//! Natural frequencies and mode shapes in the result folder.

use tegula::analysis::State;
use tegula::analysis::modal::Mode;
use tegula::element::Nodal;
use tegula::model::Field;
use tegula::result::recover;
use tegula::{Mesh, System};

use super::{Prepared, ResultFolder, fields};
use crate::out::{HistoryWriter, OutputError, PvdSeries};
use crate::plot::{Snapshot, SurfacePlot, surfaces};

/// Modes in the picture.
const PICTURED: usize = 6;
/// Columns of the picture.
const COLUMNS: usize = 3;
/// Largest displacement in the picture, as a part of the model.
const AMPLITUDE: f64 = 0.12;

/// Writes `modes.csv`, `modes.pvd` and the shapes; the time value of a shape is its frequency.
pub(super) fn write(
    folder: &ResultFolder,
    prepared: &Prepared,
    wanted: &[Field],
    modes: &[Mode],
) -> Result<(), OutputError> {
    let Prepared { mesh, system, .. } = prepared;
    let names = ["mode", "frequency_hz", "omega", "rigid", "residual"];
    let mut table = HistoryWriter::create(&folder.file("modes.csv"), &names)?;
    folder.make_series("modes")?;
    let mut series = PvdSeries::create(&folder.file("modes.pvd"))?;
    for (i, mode) in modes.iter().enumerate() {
        let rigid = f64::from(u8::from(mode.rigid));
        table.append(&[(i + 1) as f64, mode.frequency_hz, mode.omega, rigid, mode.residual])?;
        let state = State { time: mode.frequency_hz, u: mode.shape.clone(), ..State::at_rest(system) };
        let results = recover(system, &state);
        let name = format!("modes/{:04}.vtu", i + 1);
        let wanted: Vec<Field> = wanted.iter().copied().filter(|&f| f != Field::Velocity).collect();
        fields::write(&folder.file(&name), mesh, system, &wanted, &state, &results)?;
        series.add(mode.frequency_hz, &name)?;
    }
    table.sync()
}

/// A picture of the lowest modes that are not rigid.
pub(super) fn picture(
    folder: &ResultFolder,
    prepared: &Prepared,
    title: &str,
    modes: &[Mode],
) -> Result<(), OutputError> {
    let Prepared { mesh, system, .. } = prepared;
    let elastic: Vec<&Mode> = modes.iter().filter(|m| !m.rigid).take(PICTURED).collect();
    if elastic.is_empty() {
        return Ok(());
    }
    let snapshots = elastic.iter().enumerate().map(|(i, m)| tile(mesh, system, m, i)).collect();
    let plot = SurfacePlot {
        title: if title.is_empty() { "Modes".into() } else { title.to_owned() },
        snapshots,
        quads: mesh.quads.clone(),
        color_label: "displacement over its maximum".into(),
        ..SurfacePlot::default()
    };
    surfaces(&folder.file("modes.png"), &plot)
}

/// A mode in its place of the picture: columns to the right, rows downwards.
fn tile(mesh: &Mesh, system: &System, mode: &Mode, index: usize) -> Snapshot {
    let u = fields::nodal(system, &mode.shape);
    let size = |u: &Nodal| u.iter().map(|x| x * x).sum::<f64>().sqrt();
    let largest = u.iter().map(size).fold(0.0, f64::max).max(f64::MIN_POSITIVE);
    let scale = AMPLITUDE * system.length / largest;
    let (azimuth, step) = ((-60.0_f64).to_radians(), 1.7 * system.length);
    let (column, row) = ((index % COLUMNS) as f64, (index / COLUMNS) as f64);
    let shift = [-azimuth.sin() * column * step, azimuth.cos() * column * step, -0.75 * row * step];
    let mut positions = fields::positions(mesh, system, &mode.shape, scale);
    for x in &mut positions {
        *x = std::array::from_fn(|i| x[i] + shift[i]);
    }
    let mean = |quad: &[u32; 4]| quad.iter().map(|&n| size(&u[n as usize])).sum::<f64>() / (4.0 * largest);
    Snapshot {
        positions,
        values: Some(mesh.quads.iter().map(mean).collect()),
        label: format!("f = {:.4}", mode.frequency_hz),
        opacity: 1.0,
    }
}
