//! tegula-io

pub mod out;
pub mod plot;
