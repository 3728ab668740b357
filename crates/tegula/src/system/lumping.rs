//! Lumped mass for explicit integration.
//!
//! Positions get the row sums of the consistent mass over positions, directors those over directors, so that total mass
//! and rigid translations are kept. Row sums of gradient vectors may vanish; they get their diagonal.
//! O. C. Zienkiewicz, R. L. Taylor, *The Finite Element Method*, vol. 1, 5th ed. (2000), app. I.
//!
//! A director vibrates across the thickness with about √(12 E/ρ)/h, far above the membrane's √(E/ρ)/element size. Its
//! inertia may therefore be raised until bounds of both frequencies (row sums of stiffness over mass, Gershgorin)
//! agree. This adds a rotary inertia of about the element size squared, which vanishes with the mesh.

use super::{Assembly, System, VectorKind};
use crate::Issue;
use crate::analysis::statics::state_kinematics;
use crate::element::TangentWeights;
use crate::system::assembly::TangentParts;
use crate::system::numbering::CONSTRAINED;

/// Coupled mass below this part of the mean of both masses is rounding.
const ROUNDING: f64 = 1e-10;

/// Lumps the mass of a system; with `scale` the inertia of directors is raised. Returns what cannot be lumped.
pub fn lump(system: &mut System, scale: bool) -> Vec<Issue> {
    let help = "use `newmark`, `hht` or `energy-momentum`";
    if !system.unit.is_empty() {
        let what = "explicit steps do not keep directors of unit length (element `mitc4`) at their length";
        return vec![Issue::new(
            "analysis.scheme",
            what,
            "use another element, or `newmark`, `hht` or `energy-momentum`",
        )];
    }
    let n = system.vectors();
    let (mut mass, mut diagonal, mut coupling) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
    system.pattern.for_each_mass(|i, j, m| {
        if i == j {
            mass[i] += m;
            diagonal[i] = m;
        } else if system.kinds[i] == system.kinds[j] {
            mass[i] += m;
            mass[j] += m;
        } else {
            match (system.kinds[i], system.kinds[j]) {
                (VectorKind::Director, VectorKind::Position) => coupling[i] += m,
                (VectorKind::Position, VectorKind::Director) => coupling[j] += m,
                _ => {}
            }
        }
    });
    for v in 0..n {
        if system.kinds[v] == VectorKind::Gradient {
            mass[v] = diagonal[v];
        }
    }
    let coupled = (0..n).any(|v| {
        let position = system.position_of[system.nodes[v] as usize] as usize;
        coupling[v].abs() > ROUNDING * (mass[v] * mass[position]).abs().sqrt()
    });
    if coupled {
        let what = "the mass of a section does not lie about its mid-surface: it ties positions to directors, \
                    and cannot be lumped";
        return vec![Issue::new("analysis.scheme", what, help)];
    }
    if scale {
        raise_directors(system, &mut mass);
    }
    system.pattern.set_mass(|i, j| if i == j { mass[i] } else { 0.0 });
    Vec::new()
}

/// Raises the mass of directors (and gradients) until the bound of their frequencies is at most that of positions.
fn raise_directors(system: &System, mass: &mut [f64]) {
    let mut owner = vec![0; system.unknowns()];
    for v in 0..system.vectors() {
        for number in system.numbering.of(v) {
            if number != CONSTRAINED {
                owner[number as usize] = v;
            }
        }
    }
    let mut assembly = Assembly::new(system);
    let zero = vec![[0.0; 3]; system.vectors()];
    let mut forces = zero.clone();
    // Of the material only: prescribed strains would add their stress.
    let weights = TangentWeights { stress: 1.0, direction: 0.0, force: 1.0, rate: 0.0 };
    let parts = TangentParts { weights, mass: 0.0, time: 0.0 };
    let k = state_kinematics(system, &zero, 0.0);
    assembly.forces_and_tangent(system, &k, &parts, false, None, &mut forces);
    let is_position = |c: usize| system.kinds[owner[c]] == VectorKind::Position;
    let mut sums = vec![0.0; system.unknowns()];
    for j in 0..system.unknowns() {
        for at in system.pattern.column_pointers[j]..system.pattern.column_pointers[j + 1] {
            let i = system.pattern.row_indices[at];
            if is_position(i) == is_position(j) {
                sums[i] += assembly.values[at].abs();
                if i != j {
                    sums[j] += assembly.values[at].abs();
                }
            }
        }
    }
    let membrane = (0..sums.len())
        .filter(|&c| is_position(c) && mass[owner[c]] > 0.0)
        .map(|c| sums[c] / mass[owner[c]])
        .fold(0.0, f64::max);
    if membrane > 0.0 {
        for c in (0..sums.len()).filter(|&c| !is_position(c)) {
            mass[owner[c]] = mass[owner[c]].max(sums[c] / membrane);
        }
    }
}
