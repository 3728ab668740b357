//! Result folder: locked by one run at a time; files of other origin are never touched.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::Write as _;
use std::path::{Path, PathBuf};

use tegula::model::PICTURES;

use super::summary::Summary;
use super::{JobError, Status, campbell, response, series};
use crate::out::{OutputError, PvdSeries, printable, vtu};

/// Names of the files that a run leaves, beside numbered field files and pictures.
const OWN: [&str; 17] = [
    "fields.pvd",
    "bodies.pvd",
    "mode_bodies.pvd",
    "critical_modes.pvd",
    "critical_mode_bodies.pvd",
    "modes.pvd",
    "history.csv",
    "modes.csv",
    campbell::TABLE,
    response::TABLE,
    response::STATE_SPACE,
    response::MATRICES[0],
    response::MATRICES[1],
    response::MATRICES[2],
    response::MATRICES[3],
    "checkpoint.bin",
    "log.txt",
];

/// Folders of numbered field files.
const SERIES: [&str; 6] = [
    series::STATES[0],
    series::STATES[1],
    series::MODES[0],
    series::MODES[1],
    series::CRITICAL_MODES[0],
    series::CRITICAL_MODES[1],
];

/// A result folder.
#[derive(Debug)]
pub struct ResultFolder {
    path: PathBuf,
    /// Locked as long as the run lasts.
    log: File,
}

/// Request of a run for a result folder.
#[derive(Debug, Clone, Copy)]
pub struct Claim<'a> {
    /// Path of its model file.
    pub model: &'a Path,
    /// Fingerprint of the model.
    pub fingerprint: u64,
    /// Replace the results of another model.
    pub force: bool,
}

impl ResultFolder {
    /// Claims the folder for a new run: makes it, or clears an earlier result of its own files.
    ///
    /// # Errors
    /// The folder holds something else than a result, that of another model, or another run is writing there.
    pub fn start(path: &Path, claim: &Claim<'_>) -> Result<Self, JobError> {
        let earlier = earlier(path)?;
        match &earlier {
            None if !is_step(path) && !is_empty(path)? => {
                return Err(refuse(
                    path,
                    "it holds files that are not a result of tegula. Choose another folder (`--out`), or empty it",
                ));
            }
            Some(summary) if !claim.force && !same_model(summary, claim) => {
                return Err(refuse(
                    path,
                    &format!(
                        "it holds the results of another model, `{}`. Choose another folder (`--out`), or replace \
                         them with `--force`",
                        summary.model
                    ),
                ));
            }
            _ => {}
        }
        Self::refuse_foreign(path)?;
        let folder = Self::open(path)?;
        folder.remove_temporaries()?;
        if let Some(summary) = earlier {
            folder.clear(summary)?;
        }
        Ok(folder)
    }

    /// Claims the folder of an earlier run to resume it.
    ///
    /// # Errors
    /// There is no earlier run, or another one is writing there.
    pub fn resume(path: &Path) -> Result<Self, JobError> {
        if earlier(path)?.is_none() {
            let reason = if is_empty(path)? {
                "there is no interrupted run in it. Run without `--resume`"
            } else {
                "it holds files, but no result of tegula to resume. Check the name of the folder (`--out`)"
            };
            return Err(refuse(path, reason));
        }
        if !path.join("checkpoint.bin").exists() {
            return Err(refuse(
                path,
                "its run has left no checkpoint to resume from. Run without `--resume` to start anew",
            ));
        }
        let folder = Self::open(path)?;
        folder.remove_temporaries()?;
        Ok(folder)
    }

    /// Refuses to resume the folder of a branch on its own: it belongs to the run of its path.
    ///
    /// # Errors
    /// It is one.
    pub(super) fn refuse_branch(path: &Path) -> Result<(), JobError> {
        let name = path.file_name().and_then(|name| name.to_str());
        let primary = path.parent().and_then(|parent| Some((parent, Summary::read(parent).ok()?)));
        match primary.filter(|(_, s)| s.branches.iter().any(|branch| Some(branch.folder.as_str()) == name)) {
            None => Ok(()),
            Some((primary, _)) => Err(refuse(
                path,
                &format!("it is a branch of the run in `{}`. Resume that run", primary.display()),
            )),
        }
    }

    /// Refuses a folder with a file of somebody else that has the name of a field file.
    ///
    /// # Errors
    /// There is such a file.
    pub(super) fn refuse_foreign(path: &Path) -> Result<(), JobError> {
        let foreign = SERIES.iter().find_map(|series| foreign(path, series));
        if let Some(file) = foreign {
            return Err(refuse(
                path,
                &format!(
                    "`{}` was not written by tegula and is in the way. Move it elsewhere",
                    file.display()
                ),
            ));
        }
        Ok(())
    }

    /// Removes half-written files that a killed run has left.
    fn remove_temporaries(&self) -> Result<(), OutputError> {
        for place in SERIES.into_iter().chain([""]) {
            for entry in fs::read_dir(self.path.join(place)).into_iter().flatten().flatten() {
                if is_temporary(&entry) {
                    remove(&entry.path())?;
                }
            }
        }
        Ok(())
    }

    fn open(path: &Path) -> Result<Self, JobError> {
        let failed = |cause| OutputError::write(path, cause);
        fs::create_dir_all(path).map_err(failed)?;
        let log = path.join("log.txt");
        if log.is_symlink() {
            // As all files of a result it is a file of the folder: what a link leads to stays as it is.
            remove(&log)?;
        }
        let log = OpenOptions::new().create(true).append(true).open(log).map_err(failed)?;
        match log.try_lock() {
            Ok(()) => Ok(Self { path: path.to_owned(), log }),
            Err(TryLockError::WouldBlock) => {
                Err(refuse(path, "another run is writing there. Wait for it, or choose another folder"))
            }
            // A file system without locks: better without one than not at all.
            Err(TryLockError::Error(_)) => Ok(Self { path: path.to_owned(), log }),
        }
    }

    /// Removes the files of an earlier run; its summary goes last but says `running` first.
    fn clear(&self, mut earlier: Summary) -> Result<(), JobError> {
        earlier.status = Status::Running;
        earlier.write(&self.path)?;
        for series in SERIES {
            self.remove_numbered(series, 0)?;
            // Fails where the user has put something into it, which stays.
            let _ = fs::remove_dir(self.path.join(series));
        }
        for name in OWN.iter().chain(&PICTURES).filter(|&&name| name != "log.txt") {
            remove(&self.path.join(name))?;
        }
        self.log.set_len(0).map_err(|cause| OutputError::write(&self.file("log.txt"), cause))?;
        for point in earlier.points.keys() {
            remove(&self.path.join(format!("point_{point}.png")))?;
        }
        for still in earlier.stills.iter().filter(|name| is_inside(name)) {
            remove(&self.path.join(still))?;
        }
        let analyses = earlier.analyses.iter().map(|step| &step.folder);
        let branches = earlier.branches.iter().map(|branch| &branch.folder);
        analyses.chain(branches).try_for_each(|folder| self.clear_step(folder))
    }

    /// Removes the results of an analysis step or of a branch, in a folder of its own, as far as they are of this program.
    fn clear_step(&self, folder: &str) -> Result<(), JobError> {
        let path = self.path.join(folder);
        if !is_inside(folder) || !path.is_dir() {
            return Ok(());
        }
        if let Some(summary) = earlier(&path)? {
            let step = Self::open(&path)?;
            step.remove_temporaries()?;
            step.clear(summary)?;
            remove(&step.file("log.txt"))?;
            remove(&step.file("summary.json"))?;
        }
        // Fails where the user has put something into it, which stays.
        let _ = fs::remove_dir(&path);
        Ok(())
    }

    /// Claims the folder of an interrupted run of several analyses to resume it.
    ///
    /// # Errors
    /// There is no such run of this model, or another run is writing there.
    pub(super) fn resume_steps(path: &Path, fingerprint: u64) -> Result<Self, JobError> {
        match earlier(path)? {
            Some(summary) if summary.fingerprint != format!("{fingerprint:016x}") => Err(refuse(
                path,
                "its results are of another model, or of another state of this model file. Run without `--resume` to \
                 start anew",
            )),
            Some(_) => Self::open(path),
            None if is_empty(path)? => {
                Err(refuse(path, "there is no interrupted run in it. Run without `--resume`"))
            }
            None => Err(refuse(
                path,
                "it holds files, but no result of tegula to resume. Check the name of the folder (`--out`)",
            )),
        }
    }

    /// Removes the files `series/NNNN.vtu` of this program with numbers from `first`; files of others stay.
    pub(super) fn remove_numbered(&self, series: &str, first: usize) -> Result<(), OutputError> {
        let listed = PvdSeries::open(&self.path.join(format!("{series}.pvd"))).ok();
        for (number, path) in numbered(&self.path, series) {
            if number >= first && own(&listed, series, &path) {
                remove(&path)?;
            }
        }
        Ok(())
    }

    /// Makes the folder of a numbered series.
    pub(super) fn make_series(&self, series: &str) -> Result<(), OutputError> {
        let path = self.path.join(series);
        fs::create_dir_all(&path).map_err(|cause| OutputError::write(&path, cause))
    }

    /// Path of the folder.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Path of a file in it.
    pub fn file(&self, name: &str) -> PathBuf {
        self.path.join(name)
    }

    /// Adds a line to the log.
    pub(super) fn log(&mut self, line: &str) -> Result<(), OutputError> {
        writeln!(self.log, "{}", printable(line))
            .map_err(|cause| OutputError::write(&self.path.join("log.txt"), cause))
    }
}

fn refuse(path: &Path, reason: &str) -> JobError {
    JobError::Folder { folder: path.to_owned(), reason: reason.into() }
}

/// True for the folder of an analysis step in the result folder of a run of several, and for that of a branch of a path. Files of the user in it
/// stay.
fn is_step(path: &Path) -> bool {
    let name = path.file_name().and_then(|name| name.to_str());
    let whole = path.parent().and_then(|parent| Summary::read(parent).ok());
    whole.is_some_and(|summary| {
        let analyses = summary.analyses.iter().map(|step| step.folder.as_str());
        analyses
            .chain(summary.branches.iter().map(|branch| branch.folder.as_str()))
            .any(|own| Some(own) == name)
    })
}

/// The summary of the result that the folder holds.
fn earlier(path: &Path) -> Result<Option<Summary>, JobError> {
    if path.exists() && !path.is_dir() {
        return Err(refuse(path, "it is a file. Choose another name (`--out`)"));
    }
    Ok(Summary::read(path).ok())
}

/// True if a result is that of the model which claims the folder: of the same text, from the same file, or from a file
/// of the same name that has been moved.
fn same_model(earlier: &Summary, claim: &Claim<'_>) -> bool {
    if earlier.fingerprint == format!("{:016x}", claim.fingerprint) {
        return true;
    }
    // The standard input, and texts of other programs: their names, in angle brackets, tell nothing about the model.
    if claim.model.file_name().is_some_and(|name| name.to_string_lossy().starts_with('<')) {
        return false;
    }
    let before = Path::new(earlier.model_path.as_ref().unwrap_or(&earlier.model));
    match (before.canonicalize(), claim.model.canonicalize()) {
        (Ok(before), Ok(now)) => before == now,
        (Err(_), Ok(_)) => before.file_name() == claim.model.file_name(),
        // A pipe is there but has no place among the files; whatever came through it before is another model.
        (_, Err(_)) => !claim.model.exists() && before.file_name() == claim.model.file_name(),
    }
}

/// Numbers and paths of the files `series/NNNN.vtu`.
fn numbered(folder: &Path, series: &str) -> Vec<(usize, PathBuf)> {
    let number = |entry: &fs::DirEntry| {
        let number: usize = entry.file_name().to_str()?.strip_suffix(".vtu")?.parse().ok()?;
        // Not +1.vtu, not 7.vtu: those are no names of this program.
        (entry.file_name().to_str() == Some(&format!("{number:04}.vtu"))).then_some(number)
    };
    let entries = fs::read_dir(folder.join(series)).into_iter().flatten().flatten();
    entries.filter_map(|entry| Some((number(&entry)?, entry.path()))).collect()
}

/// True if a file of a series was written by this program; versions before this mark are known by their list.
fn own(listed: &Option<PvdSeries>, series: &str, path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    vtu::is_own(path) || listed.as_ref().is_some_and(|list| list.lists(&format!("{series}/{name}")))
}

/// A file of somebody else that has the name of one which this program writes.
fn foreign(folder: &Path, series: &str) -> Option<PathBuf> {
    let listed = PvdSeries::open(&folder.join(format!("{series}.pvd"))).ok();
    numbered(folder, series).into_iter().map(|(_, path)| path).find(|path| !own(&listed, series, path))
}

fn is_empty(path: &Path) -> Result<bool, OutputError> {
    if !path.exists() {
        return Ok(true);
    }
    let mut entries = fs::read_dir(path).map_err(|cause| OutputError::read(path, cause))?;
    // A run that was stopped before its first summary has left an empty log and a half-written file at most.
    let left = |e: &fs::DirEntry| {
        is_temporary(e) || (e.file_name() == "log.txt" && e.metadata().is_ok_and(|m| m.len() == 0))
    };
    Ok(entries.all(|e| e.is_ok_and(|e| left(&e))))
}

/// True for a file that was being written when its run was killed.
fn is_temporary(entry: &fs::DirEntry) -> bool {
    let name = entry.file_name();
    let name = name.to_string_lossy();
    name.starts_with(".tegula-") && name.ends_with(".part") && entry.file_type().is_ok_and(|t| t.is_file())
}

/// Whether a path leads nowhere but into the folder to which it is relative, as a summary that was changed by hand may not.
fn is_inside(path: &str) -> bool {
    Path::new(path).components().all(|c| matches!(c, std::path::Component::Normal(_)))
}

fn remove(path: &Path) -> Result<(), OutputError> {
    match fs::remove_file(path) {
        Err(cause) if cause.kind() != std::io::ErrorKind::NotFound => Err(OutputError::write(path, cause)),
        _ => Ok(()),
    }
}
