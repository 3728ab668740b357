//! ParaView's list of the files of a time series (`.pvd`).
//!
//! A file is added at the end of the list, over its closing tags, with one write that brings the tags along: the list is
//! valid between any two writes, and a long series costs no more per file than a short one. Reading it back is lenient,
//! because a run must be able to resume from whatever is there.

use std::collections::HashSet;
use std::fs::{File, OpenOptions};
use std::io::{self, ErrorKind, Seek as _, SeekFrom, Write as _};
use std::path::{Path, PathBuf};

use super::file::{OutputError, write_whole};
use super::vtu::escape;

const HEAD: &str = "<?xml version=\"1.0\"?>\n\
                    <VTKFile type=\"Collection\" version=\"0.1\" byte_order=\"LittleEndian\">\n<Collection>\n";
const TAIL: &str = "</Collection>\n</VTKFile>\n";

/// A time series of result files, kept on disk.
#[derive(Debug, Clone)]
pub struct PvdSeries {
    path: PathBuf,
    entries: Vec<(f64, String)>,
    names: HashSet<String>,
    /// Byte of the file at which the closing tags begin.
    end: u64,
}

impl PvdSeries {
    /// Starts a new series and writes the empty list over an earlier one.
    pub fn create(path: &Path) -> Result<Self, OutputError> {
        let mut series = Self::new(path, Vec::new());
        series.write()?;
        Ok(series)
    }

    /// Opens an earlier series to continue it. Entries that cannot be read are omitted.
    pub fn open(path: &Path) -> Result<Self, OutputError> {
        let bytes = std::fs::read(path).map_err(|cause| OutputError::read(path, cause))?;
        let text = String::from_utf8_lossy(&bytes);
        if !text.contains("<VTKFile") {
            return Err(OutputError::damaged(
                path,
                "it is not a list of result files (no `<VTKFile` in it)",
                "Remove the file to start a new list",
            ));
        }
        Ok(Self::new(path, text.split("<DataSet").skip(1).filter_map(entry).collect()))
    }

    fn new(path: &Path, entries: Vec<(f64, String)>) -> Self {
        let names = entries.iter().map(|(_, name)| name.clone()).collect();
        Self { path: path.to_path_buf(), entries, names, end: 0 }
    }

    /// Adds a file, named relative to the list's folder.
    ///
    /// A file that is in the list already gets the new time.
    pub fn add(&mut self, time: f64, file: &str) -> Result<(), OutputError> {
        if !time.is_finite() {
            return Err(OutputError::refused(&self.path, format!("the time of `{file}` is {time}")));
        }
        if !self.names.insert(file.to_owned()) {
            self.entries.retain(|(_, name)| name != file);
            self.end = 0;
        }
        self.entries.push((time, file.to_owned()));
        let line = line(time, file);
        match self.append(&line) {
            Ok(true) => {
                self.end += line.len() as u64;
                Ok(())
            }
            Ok(false) => self.write(),
            Err(cause) => Err(OutputError::write(&self.path, cause)),
        }
    }

    /// Writes a line over the closing tags and these behind it; false where the file is not as it was left.
    fn append(&self, line: &str) -> io::Result<bool> {
        let mut file = match OpenOptions::new().write(true).open(&self.path) {
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(false),
            other => other?,
        };
        if self.end == 0 || file.metadata()?.len() != self.end + TAIL.len() as u64 {
            return Ok(false);
        }
        let mut put = |text: &str| {
            file.seek(SeekFrom::Start(self.end))?;
            file.write_all(text.as_bytes())
        };
        if let Err(error) = put(&format!("{line}{TAIL}")) {
            // A disk that is full has no room for the new line, but still that of the old tags.
            let _ = put(TAIL).and_then(|()| file.set_len(self.end + TAIL.len() as u64));
            return Err(error);
        }
        Ok(true)
    }

    /// Writes the list to the disk itself.
    pub fn sync(&self) -> Result<(), OutputError> {
        let sync = || File::open(&self.path)?.sync_data();
        sync().map_err(|cause| OutputError::write(&self.path, cause))
    }

    /// Drops the files later than `time` from the list (not from the disk) and rewrites it.
    pub fn truncate_after(&mut self, time: f64) -> Result<(), OutputError> {
        self.entries.retain(|&(t, _)| t <= time);
        self.names = self.entries.iter().map(|(_, name)| name.clone()).collect();
        self.write()
    }

    /// Drops the files that are no longer on the disk, and rewrites the list. Returns how many.
    pub fn drop_missing(&mut self) -> Result<usize, OutputError> {
        let folder = self.path.parent().unwrap_or(Path::new("")).to_path_buf();
        let before = self.entries.len();
        self.entries.retain(|(_, name)| folder.join(name).is_file());
        let missing = before - self.entries.len();
        if missing > 0 {
            self.names = self.entries.iter().map(|(_, name)| name.clone()).collect();
            self.write()?;
        }
        Ok(missing)
    }

    /// Times and relative file names, in the order in which they were added.
    pub fn entries(&self) -> &[(f64, String)] {
        &self.entries
    }

    /// Whether a file is in the list.
    pub fn lists(&self, file: &str) -> bool {
        self.names.contains(file)
    }

    /// The whole list.
    fn write(&mut self) -> Result<(), OutputError> {
        let mut text = String::from(HEAD);
        text.extend(self.entries.iter().map(|(time, file)| line(*time, file)));
        self.end = text.len() as u64;
        text.push_str(TAIL);
        write_whole(&self.path, |w| w.write_all(text.as_bytes()))
    }
}

/// The line of a file in the list.
fn line(time: f64, file: &str) -> String {
    format!("<DataSet timestep=\"{time:?}\" group=\"\" part=\"0\" file=\"{}\"/>\n", escape(file))
}

/// Time and file name from what follows `<DataSet`; `None` where either is missing.
fn entry(rest: &str) -> Option<(f64, String)> {
    let time: f64 = attribute(rest, "timestep")?.trim().parse().ok()?;
    let file = attribute(rest, "file")?;
    (time.is_finite() && !file.is_empty()).then_some((time, file))
}

/// Value of one attribute of the element that begins at `rest`.
fn attribute(rest: &str, wanted: &str) -> Option<String> {
    let mut rest = rest;
    loop {
        let (name, after) = rest.split_once('=')?;
        if name.contains('>') {
            return None;
        }
        let after = after.trim_start();
        let quote = after.chars().next().filter(|c| matches!(c, '"' | '\''))?;
        let (value, next) = after[1..].split_once(quote)?;
        if name.trim() == wanted {
            return Some(unescape(value));
        }
        rest = next;
    }
}

/// Undoes `escape`, and reads the apostrophe that other writers may use.
fn unescape(text: &str) -> String {
    text.replace("&lt;", "<")
        .replace("&gt;", ">")
        .replace("&quot;", "\"")
        .replace("&apos;", "'")
        .replace("&amp;", "&")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_series_is_reopened_and_cut_back() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("fields.pvd");
        let mut series = PvdSeries::create(&path).unwrap();
        for i in 0..5 {
            series.add(0.1 * f64::from(i), &format!("a & \"b\"={i}.vtu")).unwrap();
        }
        let mut again = PvdSeries::open(&path).unwrap();
        assert_eq!(again.entries(), series.entries());
        again.truncate_after(0.1 * 3.0).unwrap();
        again.add(0.35, "later.vtu").unwrap();
        let last = PvdSeries::open(&path).unwrap();
        let times: Vec<f64> = last.entries().iter().map(|e| e.0).collect();
        assert_eq!(times, [0.0, 0.1, 0.2, 0.1 * 3.0, 0.35]);
    }

    #[test]
    fn a_list_is_valid_after_each_file_and_grows_by_one_line() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("fields.pvd");
        let mut series = PvdSeries::create(&path).unwrap();
        let inode = |path: &Path| {
            #[cfg(unix)]
            return std::os::unix::fs::MetadataExt::ino(&std::fs::metadata(path).unwrap());
            #[cfg(not(unix))]
            return path.exists();
        };
        let first = inode(&path);
        for i in 0..50 {
            series.add(f64::from(i), &format!("fields/{i:04}.vtu")).unwrap();
            let text = std::fs::read_to_string(&path).unwrap();
            assert!(text.starts_with(HEAD) && text.ends_with(TAIL), "{text}");
            assert_eq!(text.matches("</VTKFile>").count(), 1);
            assert_eq!(PvdSeries::open(&path).unwrap().entries(), series.entries());
        }
        // The file was appended to, not made anew.
        assert_eq!(inode(&path), first);
        // Somebody else has changed or removed it: it is written whole.
        std::fs::write(&path, "<VTKFile").unwrap();
        series.add(50.0, "a.vtu").unwrap();
        assert_eq!(PvdSeries::open(&path).unwrap().entries().len(), 51);
        std::fs::remove_file(&path).unwrap();
        series.add(51.0, "b.vtu").unwrap();
        assert_eq!(PvdSeries::open(&path).unwrap().entries(), series.entries());
    }

    #[test]
    fn the_same_file_is_listed_once() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.pvd");
        let mut series = PvdSeries::create(&path).unwrap();
        series.add(1.0, "a.vtu").unwrap();
        series.add(2.0, "a.vtu").unwrap();
        assert_eq!(series.entries(), [(2.0, "a.vtu".to_owned())]);
        assert_eq!(PvdSeries::open(&path).unwrap().entries(), series.entries());
        assert!(series.add(f64::NAN, "b.vtu").is_err());
    }

    #[test]
    fn broken_lists_give_what_they_hold() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.pvd");
        let text = "<VTKFile><Collection><DataSet part='0' file='a.vtu' timestep=\"1e-3\"></DataSet>\
            <DataSet file=\"no-time.vtu\"/><DataSet timestep=\"x\" file=\"b\"/>\
            <DataSet timestep=\"2\" file=\"c.vtu\"/><DataSet timestep=\"3\" fi";
        std::fs::write(&path, text).unwrap();
        let series = PvdSeries::open(&path).unwrap();
        assert_eq!(series.entries(), [(1e-3, "a.vtu".to_owned()), (2.0, "c.vtu".to_owned())]);
        std::fs::write(&path, "t,x\n").unwrap();
        assert!(PvdSeries::open(&path).unwrap_err().to_string().contains("not a list"));
        assert!(PvdSeries::open(&folder.path().join("none")).unwrap_err().to_string().contains("none"));
    }
}
