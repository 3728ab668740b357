//! Mass lumping and rotary-inertia scaling for explicit integration.
//!
//! Positions get the row sums of the consistent mass over positions, directors those over directors, so that total mass
//! and rigid translations are kept. O. C. Zienkiewicz, R. L. Taylor, *The Finite Element Method*, vol. 1, 5th ed.
//! (2000), app. I.
//!
//! A director vibrates across the thickness with about √(12 E/ρ)/h, far above the membrane's √(E/ρ)/element size.
//! Rotary-inertia scaling may therefore raise its inertia until, element by element, the highest frequency of the
//! directors is not above the highest one of the positions of any element. This adds a rotary inertia of about the
//! element size squared, which vanishes with the mesh.

use super::EvaluationPoint;
use super::assembly::{ElementBlocks, pairs};
use super::connection_frequency::is_connection;
use super::element_frequency::{MassShares, of_elements, row_sums};
use super::lumped_body::LumpedBody;
use super::pattern::BATCH;
use super::{System, VectorKind};
use crate::Issue;
use crate::element::{TangentRequest, TangentWeights};

/// Coupling mass below this part of the mean of both masses is round-off.
const ROUNDING: f64 = 1e-10;

/// Lumps the mass of a system's elements and the `added` masses (pairs of nodal vectors); with `scale` it scales the
/// rotary inertia of directors. Returns issues for masses that cannot be lumped.
pub fn lump(system: &mut System, added: &[(u32, u32, f64)], scale: bool) -> Vec<Issue> {
    if let Some((what, help)) = unsuitable(system) {
        return vec![Issue::new("analysis.scheme", what, help)];
    }
    let shares = MassShares::new(system);
    let mut mass: Vec<f64> = (0..system.vectors()).map(|v| shares.own(v)).collect();
    for body in &system.coordinates.bodies {
        mass[body.centre as usize] += body.mass;
    }
    for &(a, b, m) in added {
        mass[a as usize] += m;
        if a != b {
            mass[b as usize] += m;
        }
    }
    let of_body = |v: usize| system.coordinates.body_of(v).is_some_and(|body| body.directors.is_some());
    if mass.iter().enumerate().any(|(v, m)| *m <= 0.0 && !of_body(v)) {
        return vec![Issue::new(
            "analysis.scheme",
            "some degrees of freedom have no mass: explicit integration needs mass everywhere",
            "give every material a density, or the section a `total_mass`",
        )];
    }
    if let Some(body) = LumpedBody::all(system, &mass).iter().find(|b| !b.resists_all_motions()) {
        let name = &system.coordinates.bodies[body.body].name;
        return vec![Issue::new(
            "analysis.scheme",
            format!(
                "body \"{name}\" has no moment of inertia about one of its axes, as a rod: explicit steps need one about every axis"
            ),
            "give it `inertia` or a shape like a cylinder, or use `energy-momentum`",
        )];
    }
    if scale {
        scale_rotary_inertia(system, &shares, &mut mass);
    }
    system.pattern.set_mass(|i, j| if i == j { mass[i] } else { 0.0 });
    Vec::new()
}

/// Reason why explicit steps cannot be taken with the elements of a system, and the remedy.
fn unsuitable(system: &System) -> Option<(&'static str, &'static str)> {
    let other = "use another element, or `newmark`, `hht` or `energy-momentum`";
    if !system.coordinates.inextensible.is_empty() {
        return Some((
            "explicit steps do not satisfy the constraint of inextensible directors (element `mitc4`)",
            other,
        ));
    }
    if system.coordinates.kinds.contains(&VectorKind::Gradient) {
        return Some((
            "the mass of gradient vectors (element `ancf-full`) cannot be lumped: its row sums vanish",
            other,
        ));
    }
    // An offset couples positions and directors by mass.
    let coupled = system.groups.iter().any(|group| {
        (0..group.len()).any(|e| {
            let (vectors, mass) = (group.vectors(e), group.mass(e));
            if mass.is_empty() {
                return false;
            }
            let own = row_sums(&system.coordinates.kinds, vectors, mass);
            let mut pair = 0;
            (0..vectors.len()).any(|a| {
                (0..=a).any(|b| {
                    let m = mass[pair];
                    pair += 1;
                    let kinds = [a, b].map(|i| system.coordinates.kinds[vectors[i] as usize]);
                    kinds[0] != kinds[1] && m.abs() > ROUNDING * (own[a] * own[b]).abs().sqrt()
                })
            })
        })
    });
    coupled.then_some((
        "the mass of a section is not symmetric about its mid-surface: it couples positions and directors, and cannot \
         be lumped",
        "use `newmark`, `hht` or `energy-momentum`, or a section without `offset` and with layers whose mass is \
         symmetric",
    ))
}

/// Rotary-inertia scaling: raises the mass of directors until the bound of their frequencies in every element is at
/// most the highest one of positions.
fn scale_rotary_inertia(system: &System, shares: &MassShares, mass: &mut [f64]) {
    let (mut membrane, mut directors) = (0.0_f64, Vec::new());
    at_rest(system, |part| {
        let of = |kind| of_elements(system, shares, mass, part, move |k| k == kind);
        membrane = of(VectorKind::Position).into_iter().fold(membrane, f64::max);
        directors.extend(of(VectorKind::Director));
    });
    if membrane > 0.0 {
        let mut raise = vec![1.0_f64; mass.len()];
        let elements = system
            .groups
            .iter()
            .filter(|g| !is_connection(g.as_ref()))
            .flat_map(|g| (0..g.len()).map(move |e| g.vectors(e)));
        for (vectors, bound) in elements.zip(&directors) {
            for &v in
                vectors.iter().filter(|&&v| system.coordinates.kinds[v as usize] == VectorKind::Director)
            {
                raise[v as usize] = raise[v as usize].max(bound / membrane);
            }
        }
        mass.iter_mut().zip(raise).for_each(|(m, r)| *m *= r);
    }
}

/// Hands the stiffness of all elements in the reference configuration to `take`, batch by batch, group by group.
fn at_rest(system: &System, mut take: impl FnMut(ElementBlocks)) {
    let rest = vec![[0.0; 3]; system.vectors()];
    let factors: Vec<f64> = system.prescribed_strains.iter().map(|f| system.factor(&f.factor, 0.0)).collect();
    // Material stiffness only: prescribed strains would add their stress.
    let weights = TangentWeights {
        stress: 1.0,
        direction: 0.0,
        force: 1.0,
        rate: 0.0,
        augmentation: 0.0,
        penalty: 0.0,
        multiplier: 0.0,
    };
    let history = vec![0.0; system.offsets.last().map_or(0, |last| last.history.end)];
    let k = EvaluationPoint::at_rest(system, &rest, 0.0, &history);
    let groups = system.groups.iter().map(AsRef::as_ref).enumerate();
    for (g, group) in groups.filter(|(_, group)| !is_connection(*group)) {
        let k = k.of_group(system, g, &factors);
        let m = group.vectors_per_element();
        let mut forces = vec![0.0; 3 * m * group.len().min(BATCH)];
        let mut blocks = vec![0.0; 9 * pairs(m) * group.len().min(BATCH)];
        for first in (0..group.len()).step_by(BATCH) {
            let count = (group.len() - first).min(BATCH);
            let blocks = &mut blocks[..9 * pairs(m) * count];
            let request = TangentRequest { weights, stress: None, prescribed: None, blocks: &mut *blocks };
            group.evaluate(&k, first, &mut forces[..3 * m * count], Some(request));
            take(ElementBlocks { group, first, blocks });
        }
    }
}
