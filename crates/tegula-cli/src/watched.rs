//! Observer of a run with a progress line and, with `--watch`, a page.

use tegula::analysis::State;
use tegula_io::job::{JobObserver, Prepared, Progress, RecordedStep, Start};
use tegula_io::out::OutputError;
use tegula_io::watch::RunPage;

use crate::interrupt;
use crate::progress::ProgressLine;
use crate::ranks::Ranks;
use crate::report::Failure;

/// Progress line and page of a run.
pub struct Watched {
    /// Progress line.
    pub line: ProgressLine,
    /// Page.
    pub page: Option<RunPage>,
    /// Ranks of the run, which stop together.
    pub ranks: Ranks,
}

/// Serves a page and prints its address.
pub fn serve() -> Result<RunPage, Failure> {
    let page = RunPage::serve().map_err(|e| {
        Failure::File(format!(
            "the page of the run cannot be served on this computer: {e}. Run without `--watch`"
        ))
    })?;
    tell!("watch the run at {}", page.url());
    Ok(page)
}

impl Watched {
    /// Ends the page when the end of the run has been fetched, or nobody fetches it, or the user is in a hurry.
    pub fn close(self) {
        let stopped = interrupt::requested();
        if let Some(page) = self.page {
            page.close(|| !stopped && interrupt::requested());
        }
    }

    fn both(&mut self, event: impl Fn(&mut dyn JobObserver)) {
        event(&mut self.line);
        if let Some(page) = &mut self.page {
            event(page);
        }
    }
}

impl JobObserver for Watched {
    fn on_start(&mut self, start: &Start) {
        self.both(|observer| observer.on_start(start));
    }

    fn on_model(&mut self, prepared: &Prepared, columns: &[String]) {
        self.both(|observer| observer.on_model(prepared, columns));
    }

    fn on_step(&mut self, progress: &Progress) {
        self.both(|observer| observer.on_step(progress));
    }

    fn on_modes(&mut self, found: usize, wanted: usize, vectors: usize) {
        self.both(|observer| observer.on_modes(found, wanted, vectors));
    }

    fn on_recorded_step(&mut self, step: &RecordedStep<'_>) {
        self.both(|observer| observer.on_recorded_step(step));
    }

    fn on_last_state(&mut self, prepared: &Prepared, state: &State) {
        self.both(|observer| observer.on_last_state(prepared, state));
    }

    fn on_event(&mut self, message: &str) {
        self.both(|observer| observer.on_event(message));
    }

    fn on_warning(&mut self, message: &str) {
        self.both(|observer| observer.on_warning(message));
    }

    fn on_output_failure(&mut self, error: &OutputError) {
        self.ranks.fail(error);
    }

    fn interrupted(&self) -> bool {
        if self.page.as_ref().is_some_and(JobObserver::interrupted) {
            interrupt::request();
        }
        self.ranks.any(self.line.interrupted())
    }
}
