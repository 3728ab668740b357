//! Compiled part of the Python package `tegula`. Its public part, with documentation and types, is in `python/tegula`.

mod consistency;
mod convert;
mod equations;
mod failure;
mod given;
mod matrices;
mod model;
mod own;
mod report;
mod simulation;
mod state;
mod threads;
mod watch;

#[pyo3::pymodule]
mod _tegula {
    #[pymodule_export]
    use super::equations::Equations;
    #[pymodule_export]
    use super::model::Deck;
    #[pymodule_export]
    use super::own::Own;
    #[pymodule_export]
    use super::report::{FieldFile, read_table, report_page, write_report};
    #[pymodule_export]
    use super::simulation::Steps;
    #[pymodule_export]
    use super::state::State;

    /// Version of the package.
    #[pymodule_export]
    const VERSION: &str = env!("CARGO_PKG_VERSION");
}
