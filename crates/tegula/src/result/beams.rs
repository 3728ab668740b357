//! Stress resultants of beams.

use crate::Vec3;
use crate::analysis::State;
use crate::system::{BeamLine, System};

/// Stress resultants in the middle of each element of a beam, along the axes of its cross-section: shear forces V₁, V₂ and axial
/// force N, bending moments M₁, M₂ and torsional moment T. They act on the cross-section whose normal points towards the
/// end of the beam.
pub fn beam_resultants(system: &System, state: &State, beam: &BeamLine) -> Vec<[f64; 6]> {
    let group = &system.groups[beam.group];
    let factors: Vec<f64> = system.factors(state.time).collect();
    let mut stresses = vec![0.0; group.len() * group.stresses_per_element()];
    let point = state.point(system);
    group.stresses(&point.of_group(system, beam.group, &factors), &mut stresses);
    let place = |body: usize| {
        let centre = system.coordinates.bodies[body].centre as usize;
        Vec3::from(system.coordinates.reference[centre])
    };
    let elements = beam.bodies.clone().zip(stresses.chunks_exact(6));
    let resultants = elements.map(|(body, n)| {
        // The stress of the stretch is the axial force over the length.
        let length = (place(body + 1) - place(body)).norm();
        std::array::from_fn(|i| if i == 2 { n[i] * length } else { n[i] })
    });
    resultants.collect()
}
