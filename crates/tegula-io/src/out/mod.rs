//! Result files of a run: fields, histories and checkpoints.
//!
//! | file | written by | read by |
//! |---|---|---|
//! | `*.vtu` | [`vtu::write`] | ParaView, PyVista, meshio, and [`vtu_file::VtuFile`] |
//! | `*.pvd` | [`pvd::PvdSeries`] | ParaView, PyVista |
//! | `*.vtkhdf` | [`vtkhdf::write`] | ParaView, VTK, h5py |
//! | `*.csv` | [`csv::HistoryWriter`] | everything, and [`csv::read`] |
//! | `*.parquet` | [`parquet::write`] | pandas, Polars, DuckDB, R |
//! | `*.mtx` | [`matrix_market::write`] | Python (SciPy), MATLAB, Julia, Octave |
//! | checkpoints | [`save_checkpoint`] | this program |
//!
//! Every file but those that grow, histories and lists of files, is written whole or not at all
//! ([`file::write_whole`]): a run that is stopped, or a disk that is full, leaves the last good version in place.

// Tests may unwrap; the code they test may not.
#![cfg_attr(test, allow(clippy::unwrap_used))]

pub mod checkpoint;
pub mod csv;
pub mod file;
mod hdf5;
pub mod matrix_market;
pub mod numbers;
pub mod parquet;
pub mod pvd;
pub mod text;
pub mod vtkhdf;
pub mod vtu;
pub mod vtu_file;

pub use checkpoint::{fingerprint, load_checkpoint, save_checkpoint};
pub use csv::HistoryWriter;
pub(crate) use file::Destination;
pub use file::{OutputError, write_over, write_whole};
pub use pvd::PvdSeries;
pub use text::printable;
pub use vtu::{DataArray, VtuGrid};
