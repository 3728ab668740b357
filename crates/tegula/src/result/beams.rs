//! Stress resultants of beams.

use crate::Vec3;
use crate::analysis::State;
use crate::element::Nodal;
use crate::system::{BeamLine, System};

/// Stress resultants in the middle of each element of a beam, along the axes of its cross-section: shear forces V₁, V₂ and axial
/// force N, bending moments M₁, M₂ and torsional moment T. They act on the cross-section whose normal points towards the
/// end of the beam.
///
/// They are the resultants of the internal forces on the node at the end of the element, `F` and `Σ d_i × f_i`, moved to its middle: so
/// they balance the loads, also where an element bends by a large angle.
pub fn beam_resultants(system: &System, state: &State, beam: &BeamLine) -> Vec<[f64; 6]> {
    let group = &system.groups[beam.group];
    let factors: Vec<f64> = system.factors(state.time).collect();
    let point = state.point(system);
    let mut forces = vec![0.0; 3 * group.len() * group.vectors_per_element()];
    group.evaluate(&point.of_group(system, beam.group, &factors), 0, &mut forces, None);
    let at = |v: u32| {
        let displacement: Nodal = state.u[v as usize];
        Vec3::from(system.coordinates.reference[v as usize]) + Vec3::from(displacement)
    };
    let resultants = |(element, forces): (usize, &[f64])| {
        // Position and directors of the node at the start, then those of the node at the end.
        let x: Vec<Vec3> = group.vectors(element).iter().map(|&v| at(v)).collect();
        let f: Vec<Vec3> = forces.chunks_exact(3).map(Vec3::from_column_slice).collect();
        let force = f[4];
        let moment = (5..8).map(|i| x[i].cross(&f[i])).sum::<Vec3>() + ((x[4] - x[0]) * 0.5).cross(&force);
        let axes = [1, 2, 3].map(|i| (x[i] + x[4 + i]).normalize());
        let [v1, v2, n] = axes.map(|axis| axis.dot(&force));
        let [m1, m2, t] = axes.map(|axis| axis.dot(&moment));
        [v1, v2, n, m1, m2, t]
    };
    forces.chunks_exact(24).enumerate().map(resultants).collect()
}
