//! Share of a mode's stiffness that the enhanced strains of the elements remove.
//!
//! Enhanced strains lower the stiffness of in-plane bending of an element. A mode of instability that relies on this
//! reduction may belong to the elements and not to the structure (T. Sussman, K.-J. Bathe, Comput. Struct. 140 (2014)
//! 14–22): its material stiffness `φᵀ BᵀHB φ` is many times larger with the strains of the displacements alone.

use crate::element::shell::{GroupSetup, Member, ShellElement};
use crate::element::{ElementGroup, GroupPoint, InternalVariables, Motion, Nodal, TangentWeights};
use crate::system::{ShellSection, System};

/// Share above which a message mentions it: without enhanced strains the stiffness of the mode would double.
pub(super) const NOTEWORTHY: f64 = 0.5;

/// Share of the material stiffness of a mode at displacements `u` that the enhanced in-plane strains remove,
/// `1 − φᵀ K φ / φᵀ K̂ φ` with K̂ of equal elements without enhanced strains.
///
/// `None` where no element has enhanced strains, where a material yields, so that its stiffness depends on the path, or
/// where the stiffness without them is not positive, either.
pub(super) fn share(system: &System, u: &[Nodal], mode: &[Nodal]) -> Option<f64> {
    if system.yields() {
        return None;
    }
    let k = GroupPoint {
        reference: &system.coordinates.reference,
        motion: Motion::State { u, velocity: Some(mode) },
        linear: system.linear,
        interior: InternalVariables { history: &[], factors: &[] },
        time: 0.0,
        drives: &[],
        preload: 1.0,
        inextensible: &system.coordinates.inextensible,
        multipliers: &[],
    };
    let (mut with, mut without, mut any) = (0.0, 0.0, false);
    for (number, section) in system.sections.iter().enumerate() {
        let own = stiffness(system, number, section, section.element.as_ref(), &k, mode)?;
        with += own;
        without += match section.element.without_enhanced_strains() {
            None => own,
            Some(plain) => {
                any = true;
                stiffness(system, number, section, plain.as_ref(), &k, mode)?
            }
        };
    }
    (any && without > 0.0).then(|| 1.0 - with / without)
}

/// Material stiffness `φᵀ BᵀHB φ` of the elements of a section, computed with the element type `element`.
fn stiffness(
    system: &System,
    number: usize,
    section: &ShellSection,
    element: &dyn ShellElement,
    k: &GroupPoint,
    mode: &[Nodal],
) -> Option<f64> {
    let laws = section.section.laws.clone();
    let mut builder = element.builder(GroupSetup { laws, reference_kernel: true, ..GroupSetup::default() });
    for shell in system.shells.iter().filter(|s| s.section == number) {
        let vectors = system.groups[shell.groups.start].vectors(shell.member);
        let geometry = system.geometry(shell);
        let integration_points = section.section.integration_points(element, &geometry, &[]).ok()?;
        let mass = element.mass(&geometry, &section.section.inertia);
        builder.push(Member { vectors, geometry: &geometry, integration_points, mass }).ok()?;
    }
    Some(builder.finish().iter().map(|group| quadratic_form(group.as_ref(), k, mode)).sum())
}

/// Material stiffness `φᵀ BᵀHB φ` of a group, with the rates `B φ` of its sampled strains.
fn quadratic_form(group: &dyn ElementGroup, k: &GroupPoint, mode: &[Nodal]) -> f64 {
    let size = group.stresses_per_element();
    let history = vec![0.0; group.len() * group.history_per_element()];
    let k = GroupPoint { interior: InternalVariables { history: &history, factors: &[] }, ..*k };
    let mut before = vec![0.0; group.len() * size];
    let mut after = before.clone();
    group.stresses(&k, &mut before);
    let weights = TangentWeights::STATIC;
    group.extrapolate(&k, mode, &weights, &mut after);
    let of_element = |(e, (before, after)): (usize, (&[f64], &[f64]))| -> f64 {
        let rates = group.strain_rates(e, &k);
        rates.iter().zip(before.iter().zip(after)).map(|(s, (b, a))| s * (a - b)).sum()
    };
    before.chunks(size).zip(after.chunks(size)).enumerate().map(of_element).sum()
}
