//! Verification: the paper's examples and benchmarks of the literature, computed and compared.
//!
//! A case is a function that adds rows to a [`Report`]. Reference numbers are tables in
//! `verification/reference/`, models are model files in `verification/models/` (which has two motions of the study
//! [`precision`](crate::precision), too). Run counters of all analyses are in `verification/statistics.txt`.
//! Adding a case: a file of `verify/` with its functions and their list, and a line in the registry below.

mod files;
pub(crate) mod history;
pub(crate) mod model;
mod reference;
mod report;
pub mod statistics;

use std::path::Path;

pub use report::{Report, Row, Table, Verdict};

/// How long a case takes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Cost {
    /// Seconds in all; runs with the tests too.
    Fast,
    /// Up to minutes; runs with `tegula verify`.
    Normal,
    /// Longer; runs with `tegula verify --all`.
    Long,
}

/// A verification case.
#[derive(Debug, Clone, Copy)]
pub struct Case {
    /// Name on the command line.
    pub name: &'static str,
    /// One line that describes the comparison.
    pub about: &'static str,
    /// How long it takes.
    pub cost: Cost,
    run: fn(&mut Report) -> tegula::Result<()>,
}

/// Declares the files of cases and lists their cases.
macro_rules! cases {
    ($($file:ident,)*) => {
        $(mod $file;)*

        /// All cases, in the order of the registry.
        pub fn cases() -> impl Iterator<Item = &'static Case> {
            [$($file::CASES),*].into_iter().flatten()
        }
    };
}

// The registry: one line for each file of cases, which lists them in its constant `CASES`.
cases! {
    plate,
    quarter_cylinder,
    frequencies,
    pendulum,
    machines,
    paper,
    patch,
    benchmarks,
    paths,
    imperfect_cylinder,
    inside,
    follower_loads,
    macneal_beams,
    macneal_plates,
    membrane_parts,
    results,
    composites,
    transients,
    transients_literature,
    large_cantilever,
}

/// Runs cases into a report; a case that ends in an error becomes a failed row.
///
/// `pictures`: folder for the figures of the cases, none are drawn without it. `on_row` sees each row as it comes.
pub fn run(cases: &[&Case], pictures: Option<&Path>, on_row: &mut dyn FnMut(&Row)) -> Report {
    let mut report = Report::new(pictures);
    for case in cases {
        let before = report.rows().len();
        statistics::take();
        report.begin(case.name);
        if let Err(error) = (case.run)(&mut report) {
            report.failed(case.name, &error.to_string());
        }
        report.count(case.name, statistics::take());
        report.rows()[before..].iter().for_each(&mut *on_row);
    }
    report
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wrong_value_is_a_miss() {
        let mut report = Report::new(None);
        report.relative("c", "q", "1x1", 1.001, 1.0, 1e-4);
        report.at_most("c", "q", "1x1", f64::NAN, 1.0);
        assert!(report.rows().iter().all(|r| !r.pass));
    }
}
