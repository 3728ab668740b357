//! Atomic writes: files are written completely or not at all.
//!
//! The contents go to a temporary file in the same folder, which is flushed to the disk and then renamed over
//! the target. A rename within one folder is atomic, so a reader sees the old file or the new one and never a
//! part of either.

use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use thiserror::Error;

/// Why a result could not be written or read back, with the path and what to do about it.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum OutputError {
    /// The operating system refused to write.
    #[error(
        "cannot write `{}`: {cause}. Check that the folder exists, that you may write there and that the disk is not full",
        path.display()
    )]
    Write {
        /// File that should have been written.
        path: PathBuf,
        /// Error of the operating system.
        cause: io::Error,
    },
    /// The operating system refused to read.
    #[error("cannot read `{}`: {cause}. Check the name and that you may read the file", path.display())]
    Read {
        /// File that should have been read.
        path: PathBuf,
        /// Error of the operating system.
        cause: io::Error,
    },
    /// The data are inconsistent; nothing was written.
    #[error("`{}` was not written: {problem}", path.display())]
    Refused {
        /// File that should have been written.
        path: PathBuf,
        /// Value that does not fit, and values that would.
        problem: String,
    },
    /// The file was read but does not hold what it should.
    #[error("`{}` cannot be used: {problem}. {remedy}", path.display())]
    Damaged {
        /// File that was read.
        path: PathBuf,
        /// Mistake and its place.
        problem: String,
        /// Remedy.
        remedy: String,
    },
    /// A checkpoint that belongs to another model.
    #[error(
        "`{}` belongs to another model (fingerprint {found:016x}, this model has {expected:016x}). \
         Undo the changes to the model file to resume, or run without `--resume` to start anew",
        path.display()
    )]
    OtherModel {
        /// Checkpoint that was read.
        path: PathBuf,
        /// Fingerprint in the checkpoint.
        found: u64,
        /// Fingerprint of the model that asked for it.
        expected: u64,
    },
}

impl OutputError {
    /// A failed write of `path`.
    pub(crate) fn write(path: &Path, cause: io::Error) -> Self {
        Self::Write { path: path.to_path_buf(), cause }
    }

    /// A failed read of `path`.
    pub(crate) fn read(path: &Path, cause: io::Error) -> Self {
        Self::Read { path: path.to_path_buf(), cause }
    }

    /// Data that do not fit together.
    pub(crate) fn refused(path: &Path, problem: impl Into<String>) -> Self {
        Self::Refused { path: path.to_path_buf(), problem: problem.into() }
    }

    /// A file that does not hold what it should.
    pub(crate) fn damaged(path: &Path, problem: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self::Damaged { path: path.to_path_buf(), problem: problem.into(), remedy: remedy.into() }
    }
}

/// Writes a file whole or not at all.
///
/// `write` receives a buffered writer. When it returns an error, an earlier file of that name stays untouched
/// and nothing is left behind. A symbolic link stays and the file that it names is written; devices and pipes, as
/// `/dev/stdout`, are written to and never replaced.
pub fn write_whole(
    path: &Path,
    write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), OutputError> {
    let failed = |cause| OutputError::write(path, cause);
    match Destination::of(path).map_err(failed)? {
        Destination::File(target) => replace(path, &target, |file| write(file).map_err(failed)),
        Destination::Stream => {
            let stream = std::fs::OpenOptions::new().append(true).open(path).map_err(failed)?;
            let mut buffered = BufWriter::with_capacity(1 << 16, stream);
            write(&mut buffered).and_then(|()| buffered.flush()).map_err(failed)
        }
    }
}

/// Writes a file whole or not at all, as [`write_whole`] does, in a format that needs to return to bytes already written.
/// Devices and pipes are refused.
pub(crate) fn write_whole_seekable<T>(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<&mut std::fs::File>) -> Result<T, OutputError>,
) -> Result<T, OutputError> {
    match Destination::of(path).map_err(|cause| OutputError::write(path, cause))? {
        Destination::File(target) => replace(path, &target, write),
        Destination::Stream => {
            Err(OutputError::refused(path, "this format needs a file; give the name of one"))
        }
    }
}

/// Writes a temporary file, and puts it in the place of `target` once it is complete; `path` names it in messages.
fn replace<T>(
    path: &Path,
    target: &Path,
    write: impl FnOnce(&mut BufWriter<&mut std::fs::File>) -> Result<T, OutputError>,
) -> Result<T, OutputError> {
    let failed = |cause| OutputError::write(path, cause);
    let folder = folder_of(target);
    let mut temporary = temporary_in(folder).map_err(failed)?;
    let written = {
        let mut buffered = BufWriter::with_capacity(1 << 16, temporary.as_file_mut());
        let written = write(&mut buffered)?;
        buffered.flush().map_err(failed)?;
        written
    };
    temporary.as_file().sync_all().map_err(failed)?;
    temporary.persist(target).map_err(|e| failed(e.error))?;
    // The rename itself reaches the disk with the folder's entry; not every file system can promise that.
    #[cfg(unix)]
    if let Ok(folder) = std::fs::File::open(folder) {
        let _ = folder.sync_all();
    }
    Ok(written)
}

/// Writes a file over an earlier one of that name without new space on the disk, where the length allows it. For the last
/// words of a run whose disk is full; stopped in the middle it leaves a mixture.
pub fn write_over(path: &Path, contents: &[u8]) -> Result<(), OutputError> {
    let write = || {
        let mut file = std::fs::OpenOptions::new().write(true).open(path)?;
        file.write_all(contents)?;
        file.set_len(contents.len() as u64)?;
        file.sync_all()
    };
    write().map_err(|cause| OutputError::write(path, cause))
}

/// Place that a path leads to.
pub(crate) enum Destination {
    /// A file, which may be there or not; symbolic links are followed.
    File(PathBuf),
    /// A device or pipe: to be written to, not replaced by a file of its name.
    Stream,
}

impl Destination {
    /// Destination of `path`; an error for a folder and for links that lead in a circle.
    pub(crate) fn of(path: &Path) -> io::Result<Self> {
        // Names of open files, as `/dev/stdout`: others may have written to them before.
        let of_system =
            ["/dev/stdout", "/dev/stderr", "/dev/fd", "/proc"].iter().any(|name| path.starts_with(name));
        match std::fs::metadata(path) {
            Ok(found) if found.is_dir() => Err(io::ErrorKind::IsADirectory.into()),
            Ok(found) if of_system || !found.is_file() => Ok(Self::Stream),
            // What was opened before its name was removed has a link, but no path.
            Ok(_) => std::fs::canonicalize(path).map_or(Ok(Self::Stream), |path| Ok(Self::File(path))),
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(Self::File(named_by_links(path))),
            Err(error) => Err(error),
        }
    }
}

/// The path at the end of symbolic links to a file that is not there; `path` itself where it is no link.
fn named_by_links(path: &Path) -> PathBuf {
    let mut path = path.to_path_buf();
    while let Ok(next) = std::fs::read_link(&path) {
        path = folder_of(&path).join(next);
    }
    path
}

/// The folder that holds `path`, `.` for a bare name.
fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    }
}

/// A temporary file with the rights that an ordinary new file would have.
pub(crate) fn temporary_in(folder: &Path) -> io::Result<tempfile::NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".tegula-").suffix(".part");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        // Cut down by the user's umask.
        builder.permissions(std::fs::Permissions::from_mode(0o666));
        builder.tempfile_in(folder)
    }
    #[cfg(not(unix))]
    builder.tempfile_in(folder)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn a_failed_write_leaves_the_old_file_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        write_whole(&path, |w| w.write_all(b"old")).unwrap();
        let error = write_whole(&path, |w| {
            w.write_all(b"half of the new")?;
            Err(io::Error::other("stopped"))
        })
        .unwrap_err();
        assert!(error.to_string().contains("a.txt") && error.to_string().contains("stopped"));
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
        write_whole(&path, |w| w.write_all(b"new")).unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn a_file_is_written_over_in_its_place() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        assert!(write_over(&path, b"x").unwrap_err().to_string().contains("a.txt"));
        for text in ["first and long", "second", "third and longer"] {
            fs::write(&path, "0123456789").unwrap();
            write_over(&path, text.as_bytes()).unwrap();
            assert_eq!(fs::read_to_string(&path).unwrap(), text);
        }
    }

    #[test]
    fn a_missing_folder_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("nowhere").join("a.txt");
        let message = write_whole(&path, |_| Ok(())).unwrap_err().to_string();
        assert!(message.contains("nowhere") && message.contains("folder exists"), "{message}");
    }

    #[test]
    fn bare_names_go_to_the_working_folder() {
        assert_eq!(folder_of(Path::new("a.txt")), Path::new("."));
        assert_eq!(folder_of(Path::new("b/a.txt")), Path::new("b"));
    }

    #[cfg(unix)]
    #[test]
    fn others_may_read_what_the_umask_lets_them() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let (whole, plain) = (folder.path().join("whole"), folder.path().join("plain"));
        write_whole(&whole, |w| w.write_all(b"x")).unwrap();
        fs::write(&plain, "x").unwrap();
        let mode = |p: &Path| fs::metadata(p).unwrap().permissions().mode();
        assert_eq!(mode(&whole), mode(&plain));
    }

    #[cfg(unix)]
    #[test]
    fn links_and_pipes_are_written_through() {
        let folder = tempfile::tempdir().unwrap();
        let [file, link, pipe] = ["file", "link", "pipe"].map(|name| folder.path().join(name));
        std::os::unix::fs::symlink("file", &link).unwrap();
        // At first the link leads to nothing.
        for text in ["first", "second"] {
            write_whole(&link, |w| w.write_all(text.as_bytes())).unwrap();
            assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
            assert_eq!(fs::read_to_string(&file).unwrap(), text);
        }
        assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        let reader = std::thread::spawn({
            let pipe = pipe.clone();
            move || fs::read_to_string(pipe).unwrap()
        });
        write_whole(&pipe, |w| w.write_all(b"through")).unwrap();
        assert_eq!(reader.join().unwrap(), "through");
        use std::os::unix::fs::FileTypeExt;
        assert!(fs::symlink_metadata(&pipe).unwrap().file_type().is_fifo());
        let circle = folder.path().join("circle");
        std::os::unix::fs::symlink("circle", &circle).unwrap();
        assert!(write_whole(&circle, |_| Ok(())).is_err());
        assert!(write_whole(folder.path(), |_| Ok(())).is_err());
    }
}
