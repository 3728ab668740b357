//! State of an equilibrium path beyond displacements and load factor: where it is expanded, and the critical points found.

use serde::{Deserialize, Serialize};

use crate::element::Nodal;
use crate::system::System;

/// Place on a path at which it is expanded into a power series.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct ExpansionPoint {
    /// Path parameter from the start of the path.
    pub position: f64,
    /// Displacements.
    pub u: Vec<Nodal>,
    /// Load factor.
    pub load: f64,
    /// Derivative of the displacements with respect to the path parameter, by the series before; empty at the start of the path.
    pub direction: Vec<Nodal>,
    /// Length over which the residual of the step before fades; 0 at the start of the path.
    pub expected: f64,
    /// Number of the expansion, from 0.
    pub number: u32,
    /// Number of bifurcations that the path has passed.
    pub bifurcations: usize,
}

/// Kind of a critical point.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum CriticalKind {
    /// Limit point: the load factor has a maximum or a minimum.
    Limit,
    /// Bifurcation: another path crosses.
    Bifurcation,
}

impl CriticalKind {
    /// Name in messages.
    pub fn name(self) -> &'static str {
        match self {
            Self::Limit => "limit point",
            Self::Bifurcation => "bifurcation",
        }
    }
}

/// Critical point of a path: an eigenvalue of the tangent passes through zero.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CriticalPoint {
    /// Kind of the point.
    pub kind: CriticalKind,
    /// Load factor.
    pub load: f64,
    /// Path parameter from the start of the path.
    pub position: f64,
    /// Change of the number of negative eigenvalues of the tangent along the path.
    pub change: i32,
    /// Displacements.
    pub u: Vec<Nodal>,
    /// Eigenvector: motion at constant load, of unit norm ([`System::norm`](crate::System::norm)).
    pub mode: Vec<Nodal>,
}

/// Distance of two points of a path over the size of the displacements, and difference of their load factors over them, below which they
/// are one.
const SAME: f64 = 1e-5;

impl CriticalPoint {
    /// Whether a later point is this one.
    pub fn is_passed_again_at(&self, system: &System, later: &Self) -> bool {
        let difference: Vec<Nodal> =
            self.u.iter().zip(&later.u).map(|(a, b)| std::array::from_fn(|i| a[i] - b[i])).collect();
        self.kind == later.kind
            && system.norm(&difference) <= SAME * system.norm(&self.u)
            && (self.load - later.load).abs() <= SAME * self.load.abs()
    }
}

/// State of a path.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct PathState {
    /// Path parameter from the start of the path, summed over the expansions: nearly the arc length of the displacements
    /// ([`System::norm`](crate::System::norm)).
    pub position: f64,
    /// Where the present piece of the path is expanded.
    pub expansion: ExpansionPoint,
    /// Critical points passed so far.
    pub critical: Vec<CriticalPoint>,
    /// Least and largest load factor so far.
    pub loads: [f64; 2],
    /// Whether the path has ended.
    pub finished: bool,
}
