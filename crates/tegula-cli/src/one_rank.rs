//! Ranks of a run in a program that is built without MPI: this process alone.

use std::path::Path;

use tegula_io::job::{JobError, JobOptions, Summary};

use crate::report::Failure;
use crate::terminal;

/// Variables with the number of ranks, as launchers of MPI set them.
const SIZES: [&str; 3] = ["OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "PMIX_SIZE"];

/// This process.
#[derive(Default)]
pub struct Ranks;

impl Ranks {
    /// This process; a warning tells where a launcher has started several.
    pub fn start() -> Result<Self, Failure> {
        let launched = SIZES.iter().find_map(|name| std::env::var(name).ok()?.trim().parse::<usize>().ok());
        if let Some(ranks) = launched.filter(|&ranks| ranks > 1) {
            terminal::report(
                "warning",
                &format!(
                    "`mpirun` has started this program {ranks} times, and each of them runs the model alone: one run on several processes needs the program \
                     built with `--features petsc`"
                ),
            );
        }
        Ok(Self)
    }

    /// Whether this rank writes the results: it does.
    pub fn is_first(&self) -> bool {
        true
    }

    /// Number of threads: that which is wanted.
    pub fn threads(&self, wanted: Option<u32>) -> Result<Option<u32>, Failure> {
        Ok(wanted)
    }

    /// Nothing to compare.
    pub fn agree(&self, _model: Result<(&Path, &str), ()>) -> Result<(), Failure> {
        Ok(())
    }

    /// The options as they are.
    pub fn options(&mut self, options: JobOptions) -> Result<JobOptions, Failure> {
        Ok(options)
    }

    /// No wait: this rank tells why the run does not begin.
    pub fn leave_the_word_to_the_first(&self) {}

    /// Whether a statement is true here.
    pub fn any(&self, here: bool) -> bool {
        here
    }

    /// The outcome as it is.
    pub fn settle(&self, outcome: Result<Summary, JobError>) -> Result<Summary, JobError> {
        outcome
    }

    /// Nobody else to end.
    pub fn fail(&self, _error: &dyn std::fmt::Display) {}

    /// Nothing to end.
    pub fn end(self) -> Result<(), Failure> {
        Ok(())
    }
}
