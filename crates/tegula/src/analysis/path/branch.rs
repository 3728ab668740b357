//! Branch switching: from a bifurcation onto the path that crosses there.
//!
//! The crossing path leaves the bifurcation along the critical mode φ. Its equilibrium at the distance s, `⟨φ, u − u_b⟩ = s`, is found by
//! Newton's method with the load factor as an unknown, from `u_b + s φ`: `δ = K⁻¹R + δλ û` with `⟨φ, δ⟩ = 0`. The primary path does not
//! have such an equilibrium next to the bifurcation.
//!
//! A path that passes the bifurcation as the crossing one goes along φ itself: its load factor has an extremum there. The other path
//! is then the primary one, and ψ, the response to the loads without its part along φ, stands in the place of φ.

use super::expansion::{Directions, Expansion};
use crate::analysis::dynamics::project_unit_vectors;
use crate::analysis::unstable_modes::normalize;
use crate::element::Nodal;
use crate::system::{System, add_multiple};

/// Distance from the bifurcation at which the crossing path is looked for first ([`System::norm`]).
pub const FIRST: f64 = 1e-3;
/// Halvings of the distance.
pub const HALVINGS: usize = 16;
/// Iterations for one distance.
const ITERATIONS: usize = 20;
/// Increment over the distance with which the iteration ends.
const CONVERGED: f64 = 1e-9;
/// Increment over the distance beyond which it diverges.
const DIVERGED: f64 = 10.0;

/// Equilibrium on a crossing path.
pub struct Branch {
    /// Displacements.
    pub u: Vec<Nodal>,
    /// Load factor.
    pub load: f64,
    /// Negative pivots of the tangent, which is factored.
    pub negative: usize,
}

/// Direction ψ in which the primary path leaves a bifurcation, towards rising (sign 1) or falling (−1) loads: the response to rising loads
/// without its part along the eigenvector of the eigenvalue next to zero, both next to the bifurcation.
pub fn primary_direction(
    system: &System,
    response: &[Nodal],
    eigenvector: &[Nodal],
    sign: f64,
) -> Vec<Nodal> {
    let mut direction = response.to_vec();
    add_multiple(&mut direction, -system.inner_product(eigenvector, response), eigenvector);
    normalize(system, &mut direction);
    direction.as_flattened_mut().iter_mut().for_each(|x| *x *= sign);
    direction
}

/// Finds an equilibrium on the path that crosses at a bifurcation (displacements, load factor), on the side of `mode`.
///
/// # Errors
/// None was found, or none before a wanted load factor, which is told.
pub fn onto_branch(
    system: &System,
    expansion: &mut Expansion,
    at: (&[Nodal], f64),
    (mode, end_load): (&[Nodal], f64),
) -> Result<Branch, Option<f64>> {
    let mut distance = FIRST;
    let mut passed = None;
    for _ in 0..HALVINGS {
        if let Some(branch) = correct(system, expansion, at, (mode, distance)) {
            passed = wanted_between(system, end_load, [at.1, branch.load]);
            if passed.is_none() {
                return Ok(branch);
            }
        }
        distance *= 0.5;
    }
    Err(passed)
}

/// Wanted load factor, or that of the end of the path, between a bifurcation and the first point of a crossing path.
pub fn wanted_between(system: &System, end_load: f64, [from, to]: [f64; 2]) -> Option<f64> {
    let mut wanted = system.wanted_times.iter().copied().chain([end_load]);
    wanted.find(|load| (from < *load && *load < to) || (to < *load && *load < from))
}

/// Reason of a crossing path that was not found, or whose first point has passed a wanted load factor.
pub fn not_found(passed: Option<f64>) -> String {
    match passed {
        Some(load) => format!(
            "load factor {load}, which is wanted, is so near to the bifurcation that the crossing path has no point between both"
        ),
        None => "no equilibrium was found on the path that crosses at the bifurcation".into(),
    }
}

fn correct(
    system: &System,
    expansion: &mut Expansion,
    (start, load): (&[Nodal], f64),
    (mode, distance): (&[Nodal], f64),
) -> Option<Branch> {
    let (mut u, mut load) = (start.to_vec(), load);
    add_multiple(&mut u, distance, mode);
    project_unit_vectors(system, &mut u);
    for _ in 0..ITERATIONS {
        expansion.factor(system, &u, load).ok()?;
        let Directions { mut increment, unit, .. } = expansion.directions(system, &u, load).ok()?;
        let change = -system.inner_product(mode, &increment) / system.inner_product(mode, &unit);
        add_multiple(&mut increment, change, &unit);
        add_multiple(&mut u, 1.0, &increment);
        project_unit_vectors(system, &mut u);
        load += change;
        let size = system.norm(&increment) / distance;
        if !(size <= DIVERGED && load.is_finite()) {
            return None;
        }
        if size <= CONVERGED {
            let negative = expansion.factor(system, &u, load).ok()?;
            return Some(Branch { u, load, negative });
        }
    }
    None
}
