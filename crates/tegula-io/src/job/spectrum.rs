//! The eigenvalue solver of the library, seen from a job.

use tegula::analysis::{Observer, State, Statistics};
use tegula::{Error, System};

use super::modes::ModeRow;

/// What the eigenvalue solver found.
pub(super) enum Spectrum {}

impl Spectrum {
    pub fn rows(&self) -> Vec<ModeRow<'_>> {
        match *self {}
    }

    pub fn sturm_checked(&self) -> bool {
        match *self {}
    }

    pub fn statistics(&self) -> Statistics {
        match *self {}
    }
}

/// The lowest modes about an equilibrium.
pub(super) fn solve(
    _system: &System,
    _modes: usize,
    _equilibrium: Option<&State>,
    _observer: &mut dyn Observer,
) -> tegula::Result<Spectrum> {
    Err(Error::Outside("natural frequencies are not available in this version".into()))
}
