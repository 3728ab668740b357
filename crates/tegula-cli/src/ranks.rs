//! Ranks of a run that `mpirun` has started.
//!
//! Rank 0 writes the results and tells what happens. All other ranks go through the run in step with it, and leave what they write in a temporary folder.

use std::num::NonZero;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use tegula_io::job::{JobError, JobOptions, Summary};

use crate::info::instruction_set;
use crate::report::Failure;
use crate::terminal;

/// Variables with the number of ranks on a computer, as launchers of MPI set them.
const LOCAL_SIZES: [&str; 2] = ["OMPI_COMM_WORLD_LOCAL_SIZE", "MPI_LOCALNRANKS"];

/// Time that other ranks leave to rank 0 to tell why a run ends.
const BEHIND_FIRST: Duration = Duration::from_secs(2);

/// Ranks that share the subdomains of iterative solvers.
struct Shared(tegula_petsc::Communicator);

impl tegula::bddc::Ranks for Shared {
    fn rank(&self) -> usize {
        self.0.rank()
    }

    fn size(&self) -> usize {
        self.0.size()
    }

    fn gather(&self, values: &mut [f64], begins: &[usize]) -> Result<(), String> {
        self.0.gather(values, begins).map_err(|error| error.to_string())
    }
}

/// Ranks of a run, of which this process is one.
#[derive(Default)]
pub struct Ranks {
    all: Option<tegula_petsc::Communicator>,
    /// Folder of a rank whose results nobody reads.
    unread: Option<tempfile::TempDir>,
}

impl Ranks {
    /// Starts MPI where `mpirun` has started the program.
    ///
    /// # Errors
    /// MPI or PETSc does not start.
    pub fn start() -> Result<Self, Failure> {
        if !tegula_petsc::is_launched() {
            return Ok(Self::default());
        }
        let all = tegula_petsc::Communicator::start()
            .map_err(|error| Failure::Usage(format!("MPI and PETSc do not start: {error}")))?;
        let before = std::panic::take_hook();
        std::panic::set_hook(Box::new(move |panic| {
            before(panic);
            terminal::speak();
            tell!("rank {} of {} has failed; the run is ended", all.rank(), all.size());
            all.abort(101);
        }));
        // There is no other method, and there are no other ranks: this is the one start.
        let _ = tegula::analysis::solve_by(Arc::new(tegula_petsc::Mumps(all)));
        let _ = tegula::bddc::share_subdomains(Arc::new(Shared(all)));
        if all.rank() > 0 {
            terminal::silence();
        }
        Ok(Self { all: Some(all), unread: None })
    }

    /// Whether this rank writes the results.
    pub fn is_first(&self) -> bool {
        self.all.is_none_or(|all| all.rank() == 0)
    }

    /// Number of threads of each rank: that which is wanted, else an equal part of the processors (collective).
    ///
    /// # Errors
    /// MPI failed.
    pub fn threads(&self, wanted: Option<u32>) -> Result<Option<u32>, Failure> {
        let Some(all) = self.all else { return Ok(wanted) };
        let number = |name: &str| std::env::var(name).ok()?.trim().parse::<usize>().ok();
        let local = LOCAL_SIZES.iter().find_map(|name| number(name)).unwrap_or(all.size()).max(1);
        let processors = std::thread::available_parallelism().map_or(1, NonZero::get);
        let part = number("RAYON_NUM_THREADS").unwrap_or((processors / local).max(1));
        // Sums depend on the number of threads: it is the same in all ranks.
        let threads = all.of_first(wanted.map_or(part as u64, u64::from)).map_err(failed)?;
        Ok(Some(threads.min(u64::from(u32::MAX)) as u32))
    }

    /// Compares the programs and the models of all ranks, which are to be one (collective).
    ///
    /// # Errors
    /// They differ, or a rank cannot read the model.
    pub fn agree(&self, model: Result<(&Path, &str), ()>) -> Result<(), Failure> {
        let Some(all) = self.all else { return Ok(()) };
        let text = model.map(|(_, text)| text.as_bytes().to_vec()).unwrap_or_default();
        if all.any(model.is_err()).map_err(failed)? {
            // Those that cannot read it say why.
            return match model {
                Ok((path, _)) if self.is_first() => Err(Failure::File(format!(
                    "`{}` can be read by rank 0, but not by all others: give the path of a file that all computers have",
                    path.display()
                ))),
                _ => Ok(()),
            };
        }
        let program = std::env::current_exe().and_then(std::fs::read).unwrap_or_default();
        // Other instructions give other last digits, by which ranks would decide each for itself.
        let processor = instruction_set().as_bytes().to_vec();
        for (what, bytes) in
            [("programs", program), ("model files", text), ("instruction sets of the processors", processor)]
        {
            let here = tegula_io::out::fingerprint(bytes);
            let first = all.of_first(here).map_err(failed)?;
            if all.any(first != here).map_err(failed)? {
                return Err(Failure::Usage(format!(
                    "the {what} of the ranks differ: all computers need the same program, the same model and processors of one kind"
                )));
            }
        }
        Ok(())
    }

    /// Options of this rank (collective): ranks other than 0 run in a temporary folder, into which they copy the results of an earlier run that goes on.
    ///
    /// # Errors
    /// There is no such folder.
    pub fn options(&mut self, options: JobOptions) -> Result<JobOptions, Failure> {
        let Some(all) = self.all else { return Ok(options) };
        let made = if all.rank() == 0 { Ok(options) } else { self.unread_folder(options) };
        // Rank 0 changes its folder when all others have copied it.
        if all.any(made.is_err()).map_err(failed)? {
            let reason = made.err().map(|error| format!(": {error}")).unwrap_or_default();
            return Err(Failure::File(format!("a rank has no temporary folder for the run{reason}")));
        }
        made.map_err(|error| Failure::File(error.to_string()))
    }

    fn unread_folder(&mut self, options: JobOptions) -> std::io::Result<JobOptions> {
        let folder = tempfile::Builder::new().prefix("tegula-rank-").tempdir()?;
        let path = folder.path().join("results");
        if options.resume && options.folder.is_dir() {
            copy(&options.folder, &path)?;
        }
        self.unread = Some(folder);
        Ok(JobOptions { folder: path, ..options })
    }

    /// Whether a statement is true in some rank (collective).
    pub fn any(&self, here: bool) -> bool {
        self.all.map_or(here, |all| all.any(here).unwrap_or(true))
    }

    /// Ends all ranks where one alone has failed, which would leave all others waiting.
    pub fn settle(&self, outcome: Result<Summary, JobError>) -> Result<Summary, JobError> {
        if let Err(error @ (JobError::Output(_) | JobError::Folder { .. })) = &outcome {
            self.fail(error);
        }
        outcome
    }

    /// Waits, in ranks other than 0, until rank 0 has told why the run does not begin: a launcher ends all ranks when the first of them ends.
    pub fn leave_the_word_to_the_first(&self) {
        if !self.is_first() {
            std::thread::sleep(BEHIND_FIRST);
        }
    }

    /// Ends all ranks because of an error of this one.
    pub fn fail(&self, error: &dyn std::fmt::Display) {
        let Some(all) = self.all else { return };
        // Where rank 0 has failed, too, its message is the one to read.
        self.leave_the_word_to_the_first();
        terminal::speak();
        terminal::report("error", &format!("rank {} of {}: {error}", all.rank(), all.size()));
        all.abort(1);
    }

    /// Ends MPI (collective).
    ///
    /// # Errors
    /// It does not end.
    pub fn end(self) -> Result<(), Failure> {
        // A launcher may kill ranks that wait here.
        drop(self.unread);
        self.all.map_or(Ok(()), |all| all.end().map_err(failed))
    }
}

fn failed(error: tegula_petsc::PetscError) -> Failure {
    Failure::Analysis(format!("MPI failed: {error}"))
}

/// Copies a folder with all that is in it.
fn copy(from: &Path, to: &Path) -> std::io::Result<()> {
    std::fs::create_dir_all(to)?;
    for entry in std::fs::read_dir(from)? {
        let entry = entry?;
        let (kind, place) = (entry.file_type()?, to.join(entry.file_name()));
        if kind.is_dir() {
            copy(&entry.path(), &place)?;
        } else if kind.is_file() {
            std::fs::copy(entry.path(), place)?;
        }
    }
    Ok(())
}
