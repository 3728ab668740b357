//! Modes at the critical points of an equilibrium path in the result folder.

use tegula::System;
use tegula::analysis::State;
use tegula::analysis::path::CriticalPoint;
use tegula::model::Output;
use tegula::result::recovery;

use super::modes::WITHOUT;
use super::series::{CRITICAL_MODES, FieldSeries};
use super::{Prepared, ResultFolder, fields};
use crate::out::OutputError;

/// Writes `critical_modes.pvd` and the modes with their stresses, small motions about the critical points; the time value of a mode is
/// the number of its point.
pub(super) fn write(
    folder: &ResultFolder,
    prepared: &Prepared,
    output: &Output,
    points: &[CriticalPoint],
) -> Result<(), OutputError> {
    let Prepared { mesh, system, .. } = prepared;
    let mut series = FieldSeries::create(folder, prepared, CRITICAL_MODES)?;
    let fields = output.fields.iter().copied().filter(|f| !WITHOUT.contains(f)).collect();
    let output = Output { fields, ..output.clone() };
    for (i, point) in points.iter().enumerate() {
        let about = state(system, point);
        let frame =
            fields::Frame { state: &about, small: Some(&point.mode), forces: None, time: (i + 1) as f64 };
        let results = recovery::shells(&frame.snapshot(system));
        series.write(folder, (mesh, system, &output), (i + 1, &frame), &results)?;
    }
    Ok(())
}

/// State of a critical point.
fn state(system: &System, point: &CriticalPoint) -> State {
    State { u: point.u.clone(), time: point.load, ..State::at_rest(system) }
}
