//! Field files of a run: a numbered series for the shells, one for the outline of bodies, beams and springs, where the model has them.

use tegula::result::ShellResult;
use tegula::{Mesh, System};

use super::fields::{self, Frame};
use super::{Prepared, ResultFolder};
use crate::out::{OutputError, PvdSeries};
use tegula::model::Output;

/// Name of the series of shells and of that of bodies.
pub(super) type Names = [&'static str; 2];
/// Series of the states of a run.
pub(super) const STATES: Names = ["fields", "bodies"];
/// Series of the modes of a modal analysis.
pub(super) const MODES: Names = ["modes", "mode_bodies"];

/// Series of the modes of the critical points of a path.
pub(super) const CRITICAL_MODES: Names = ["critical_modes", "critical_mode_bodies"];

/// Numbered field files with their lists.
pub(super) struct FieldSeries {
    shells: Option<PvdSeries>,
    bodies: Option<PvdSeries>,
    names: Names,
}

impl FieldSeries {
    /// New series in a folder.
    pub fn create(folder: &ResultFolder, prepared: &Prepared, names: Names) -> Result<Self, OutputError> {
        Self::with(folder, prepared, names, |name| PvdSeries::create(&folder.file(&format!("{name}.pvd"))))
    }

    /// Series of a run that restarts after `frames` files, the last one of which was written at the time `last`. Returns the number
    /// of files that are no longer there, too.
    pub fn resume(
        folder: &ResultFolder,
        prepared: &Prepared,
        names: Names,
        (frames, last): (usize, f64),
    ) -> Result<(Self, usize), OutputError> {
        let mut missing = 0;
        let series = Self::with(folder, prepared, names, |name| {
            let list = folder.file(&format!("{name}.pvd"));
            folder.remove_numbered(name, frames)?;
            let mut series = if list.exists() { PvdSeries::open(&list)? } else { PvdSeries::create(&list)? };
            series.truncate_after(last)?;
            series.drop_missing()?;
            missing += frames.saturating_sub(series.entries().len());
            Ok(series)
        })?;
        Ok((series, missing))
    }

    fn with(
        folder: &ResultFolder,
        Prepared { mesh, system, .. }: &Prepared,
        names: Names,
        mut series: impl FnMut(&str) -> Result<PvdSeries, OutputError>,
    ) -> Result<Self, OutputError> {
        let mut one = |name: &str, wanted: bool| {
            wanted.then(|| folder.make_series(name).and_then(|()| series(name))).transpose()
        };
        let bodies = !system.outline.is_empty();
        Ok(Self { shells: one(names[0], !mesh.quads.is_empty())?, bodies: one(names[1], bodies)?, names })
    }

    /// Writes the files of a state or of a mode.
    pub fn write(
        &mut self,
        folder: &ResultFolder,
        (mesh, system, output): (&Mesh, &System, &Output),
        (number, frame): (usize, &Frame<'_>),
        results: &[ShellResult],
    ) -> Result<(), OutputError> {
        let [of_shells, of_bodies] = self.names.map(|name| format!("{name}/{number:04}.vtu"));
        if let Some(series) = &mut self.shells {
            fields::write(&folder.file(&of_shells), mesh, system, output, frame, results)?;
            series.add(frame.time, &of_shells)?;
        }
        if let Some(series) = &mut self.bodies {
            fields::bodies::write(&folder.file(&of_bodies), system, output, frame)?;
            series.add(frame.time, &of_bodies)?;
        }
        Ok(())
    }

    /// Size of the files with a number (bytes).
    pub fn bytes(&self, folder: &ResultFolder, number: usize) -> u64 {
        let size = |name: &str| {
            std::fs::metadata(folder.file(&format!("{name}/{number:04}.vtu"))).map_or(0, |f| f.len())
        };
        self.names.iter().map(|name| size(name)).sum()
    }

    /// Writes the lists to the disk itself.
    pub fn sync(&self) -> Result<(), OutputError> {
        self.shells.iter().chain(&self.bodies).try_for_each(PvdSeries::sync)
    }
}
