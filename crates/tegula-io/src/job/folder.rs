//! The result folder: claimed by one run at a time, never mixed with anything foreign.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::Write as _;
use std::path::{Path, PathBuf};

use super::summary::Summary;
use super::{JobError, Status};
use crate::out::OutputError;

/// Names of the files that a run leaves, beside the numbered ones in `fields` and `modes`
/// and the pictures of points.
const OWN: [&str; 11] = [
    "fields.pvd",
    "modes.pvd",
    "history.csv",
    "modes.csv",
    "checkpoint.bin",
    "energy.png",
    "step_size.png",
    "load_displacement.png",
    "snapshots.png",
    "modes.png",
    "log.txt",
];

/// A result folder.
#[derive(Debug)]
pub struct ResultFolder {
    path: PathBuf,
    /// Locked as long as the run lasts.
    log: File,
}

impl ResultFolder {
    /// Claims the folder for a new run: makes it, or clears an earlier result of its own files.
    ///
    /// # Errors
    /// The folder holds something else than a result, or another run is writing there.
    pub fn start(path: &Path) -> Result<Self, JobError> {
        let known = known(path)?;
        if !known && !is_empty(path)? {
            return Err(refuse(
                path,
                "it holds files that are not a result of tegula. Choose another folder (`--out`), or empty it",
            ));
        }
        let folder = Self::open(path)?;
        folder.remove_temporaries()?;
        if known {
            folder.clear()?;
        }
        Ok(folder)
    }

    /// Claims the folder of an earlier run to go on with it.
    ///
    /// # Errors
    /// There is no earlier run, or another one is writing there.
    pub fn resume(path: &Path) -> Result<Self, JobError> {
        if !known(path)? || !path.join("checkpoint.bin").exists() {
            return Err(refuse(path, "there is no interrupted run in it to resume. Run without `--resume`"));
        }
        let folder = Self::open(path)?;
        folder.remove_temporaries()?;
        Ok(folder)
    }

    /// Removes half-written files that a killed run has left.
    fn remove_temporaries(&self) -> Result<(), OutputError> {
        for place in ["", "fields", "modes"] {
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
        let log = OpenOptions::new().create(true).append(true).open(path.join("log.txt")).map_err(failed)?;
        match log.try_lock() {
            Ok(()) => Ok(Self { path: path.to_owned(), log }),
            Err(TryLockError::WouldBlock) => {
                Err(refuse(path, "another run is writing there. Wait for it, or choose another folder"))
            }
            // A file system without locks: better without one than not at all.
            Err(TryLockError::Error(_)) => Ok(Self { path: path.to_owned(), log }),
        }
    }

    /// Removes what an earlier run left; its summary goes last but says `running` first.
    fn clear(&self) -> Result<(), JobError> {
        let mut summary = Summary::read(&self.path)?;
        summary.status = Status::Running;
        summary.write(&self.path)?;
        for name in OWN.iter().filter(|&&name| name != "log.txt") {
            remove(&self.path.join(name))?;
        }
        self.log.set_len(0).map_err(|cause| OutputError::write(&self.file("log.txt"), cause))?;
        for entry in fs::read_dir(&self.path).into_iter().flatten().flatten() {
            let name = entry.file_name();
            let name = name.to_string_lossy();
            if name.starts_with("point_") && name.ends_with(".png") {
                remove(&entry.path())?;
            }
        }
        for series in ["fields", "modes"] {
            self.remove_numbered(series, 0)?;
            // Fails where the user has put something into it, which stays.
            let _ = fs::remove_dir(self.path.join(series));
        }
        Ok(())
    }

    /// Removes the files `series/NNNN.vtu` with numbers from `first`.
    pub(super) fn remove_numbered(&self, series: &str, first: usize) -> Result<(), OutputError> {
        for entry in fs::read_dir(self.path.join(series)).into_iter().flatten().flatten() {
            let name = entry.file_name();
            let number = name.to_str().and_then(|n| n.strip_suffix(".vtu")).and_then(|n| n.parse().ok());
            if number.is_some_and(|n: usize| n >= first) {
                remove(&entry.path())?;
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
        writeln!(self.log, "{line}").map_err(|cause| OutputError::write(&self.path.join("log.txt"), cause))
    }
}

fn refuse(path: &Path, reason: &str) -> JobError {
    JobError::Folder { folder: path.to_owned(), reason: reason.into() }
}

/// True if the folder holds a result of this program.
fn known(path: &Path) -> Result<bool, JobError> {
    if path.exists() && !path.is_dir() {
        return Err(refuse(path, "it is a file. Choose another name (`--out`)"));
    }
    Ok(path.join("summary.json").exists() && Summary::read(path).is_ok())
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

fn remove(path: &Path) -> Result<(), OutputError> {
    match fs::remove_file(path) {
        Err(cause) if cause.kind() != std::io::ErrorKind::NotFound => Err(OutputError::write(path, cause)),
        _ => Ok(()),
    }
}
