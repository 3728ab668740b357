//! Change of the elements' shape since the last estimate of the critical time step: fibres at both surfaces of the
//! shell.

use rayon::prelude::*;

use crate::Vec3;
use crate::element::Nodal;
use crate::system::System;
use tegula_sparse::norm::larger;

/// Pairs of corners: sides and diagonals.
const PAIRS: [(usize, usize); 6] = [(0, 1), (1, 2), (2, 3), (3, 0), (0, 2), (1, 3)];
/// Fibres of an element: pairs of corners at the top and at the bottom, and the directors.
const FIBRES: usize = 2 * PAIRS.len() + 4;
/// Elements per task.
const CHUNK: usize = 256;

/// Lengths of fibres at the last estimate of the critical time step.
pub(super) struct FibreWatch {
    /// Squared lengths, element by element of [`System::shells`].
    squares: Vec<[f64; FIBRES]>,
}

impl FibreWatch {
    /// Monitor without lengths yet.
    pub fn new(system: &System) -> Self {
        Self { squares: vec![[0.0; FIBRES]; system.shells.len()] }
    }

    /// Stores the lengths at displacements `u`.
    pub fn take(&mut self, system: &System, u: &[Nodal]) {
        self.squares.par_iter_mut().with_min_len(CHUNK).enumerate().for_each(|(shell, squares)| {
            *squares = fibres(system, shell, u);
        });
    }

    /// Largest change of a fibre's length since [`take`](Self::take), over its length; NaN if any change is NaN.
    pub fn change(&self, system: &System, u: &[Nodal]) -> f64 {
        let of_shell = |(shell, before): (usize, &[f64; FIBRES])| {
            let pairs = fibres(system, shell, u).into_iter().zip(before);
            pairs.fold(0.0, |most: f64, (now, before)| larger(most, (0.5 * (now / before - 1.0)).abs()))
        };
        self.squares.par_iter().with_min_len(CHUNK).enumerate().map(of_shell).reduce(|| 0.0, larger)
    }
}

/// Squared lengths of the fibres of a shell.
fn fibres(system: &System, shell: usize, u: &[Nodal]) -> [f64; FIBRES] {
    let shell = &system.shells[shell];
    let vectors = system.groups[shell.groups.start].vectors(shell.member);
    let half = 0.5 * system.sections[shell.section].section.thickness;
    let at = |a: usize| {
        let v = vectors[a] as usize;
        Vec3::from(system.coordinates.reference[v]) + Vec3::from(u[v])
    };
    let mut out = [0.0; FIBRES];
    for (i, &(a, b)) in PAIRS.iter().enumerate() {
        let (middle, turn) = (at(b) - at(a), (at(4 + b) - at(4 + a)) * half);
        out[2 * i] = (middle + turn).norm_squared();
        out[2 * i + 1] = (middle - turn).norm_squared();
    }
    for a in 0..4 {
        out[2 * PAIRS.len() + a] = at(4 + a).norm_squared();
    }
    out
}
