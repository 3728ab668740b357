//! Bodies, beams and springs as VTU files: their outline with its motion, and the resultants of beams.

use std::path::Path;

use tegula::System;
use tegula::model::{Field, Output};
use tegula::result::beams::beam_resultants;

use super::Frame;
use crate::out::{DataArray, OutputError, VtuGrid, vtu};

const FORCE: [&str; 3] = ["v1", "v2", "n"];
const MOMENT: [&str; 3] = ["m1", "m2", "t"];

/// Writes the outline in a state, at the reference or deformed, or with a small motion about the state.
///
/// The cell array `part` is the number of the body, beam, rod or spring, in the order of the model and from 0. The arrays `beam_force`
/// and `beam_moment` are the resultants in the middle of the elements of beams, NaN elsewhere.
pub(in crate::job) fn write(
    path: &Path,
    system: &System,
    output: &Output,
    frame: &Frame<'_>,
) -> Result<(), OutputError> {
    let (state, outline) = (frame.state, &*system.outline);
    let at = |u: f64| outline.positions(&system.coordinates.reference, &state.u, u);
    let deformed = output.deformed || frame.small.is_some();
    let points = at(f64::from(u8::from(deformed)));
    let has = |field: Field| output.fields.contains(&field);
    let mut point_data = Vec::new();
    if has(Field::Displacement) {
        let moved = outline.displacements(frame.small.unwrap_or(&state.u));
        point_data.push(DataArray::new("displacement", 3, moved.concat()));
    }
    if has(Field::Velocity) {
        point_data.push(DataArray::new("velocity", 3, outline.displacements(&state.v).concat()));
    }
    let owners = || outline.owner_of_quad.iter().chain(&outline.owner_of_line);
    let part: Vec<f64> = owners().map(|[part, _]| f64::from(*part)).collect();
    let mut cell_data = vec![DataArray::new("part", 1, part)];
    if frame.small.is_none() && !system.beams.is_empty() {
        // Beams are the parts behind the bodies that are no nodes of theirs.
        let before = system.beams.first().map_or(0, |beam| beam.bodies.start);
        let resultants: Vec<Vec<[f64; 6]>> =
            system.beams.iter().map(|beam| beam_resultants(system, state, beam)).collect();
        let of = |[part, element]: &[u32; 2]| {
            let of_beam = (*part as usize).checked_sub(before).and_then(|beam| resultants.get(beam));
            of_beam.and_then(|values| values.get(*element as usize)).copied().unwrap_or([f64::NAN; 6])
        };
        let values: Vec<[f64; 6]> = owners().map(of).collect();
        for (first, name, components) in [(0, "beam_force", &FORCE), (3, "beam_moment", &MOMENT)] {
            let values: Vec<f64> = values.iter().flat_map(|v| &v[first..first + 3]).copied().collect();
            cell_data.push(DataArray::new(name, 3, values).with_component_names(components));
        }
    }
    let (quads, lines) = (&outline.quads[..], &outline.lines[..]);
    vtu::write(path, &VtuGrid { points: &points, quads, lines, point_data, cell_data, time: frame.time })
}
