//! Supports: from fixed degrees of freedom to components of nodal vectors.
//!
//! Displacements 1 to 3 are components of the position. A rotation **θ** changes a director by **θ** × **d**, and the one about the
//! director itself changes nothing. So what fixed rotations 4 to 6 mean depends on the direction of the director **d**:
//!
//! | fixed rotations about | **d** along | fixed components of **d** |
//! |---|---|---|
//! | all axes | axis k | the two across k |
//! | all axes | any direction | all |
//! | i and j | k | i and j |
//! | i and j | any direction across k | k |
//! | i | i | none |
//! | i | j | k |

use super::document::{Document, axes, number, quoted, vector};
use crate::mesh::MeshError;
use crate::mesh::numbered::normals::{Directions, Normals, Target};
use crate::mesh::numbered::{Parts, Reader, shown};

/// Coordinates of the nodes of a symmetry plane are equal within this part of the size of the model.
const IN_PLANE: f64 = 1e-6;

/// Names of the axes.
const AXES: [&str; 3] = ["x", "y", "z"];

/// Fixed and prescribed degrees of freedom of a node or a set.
#[derive(Debug)]
pub(crate) struct Restraint {
    /// The node or set.
    pub target: Target,
    /// Line on which it stands first.
    pub line: usize,
    /// Value of each degree of freedom, and its line.
    pub dofs: [Option<(f64, usize)>; 6],
    /// Card in comments, as it is spelt in the file.
    pub card: &'static str,
}

/// Writes supports as entries of the list `head`, such as `[[conditions]]`.
///
/// # Errors
/// Rotations that have no counterpart in the components of the directors.
pub(crate) fn write(
    out: &mut Document,
    reader: &Reader<'_>,
    parts: &Parts,
    head: &str,
    restraints: &[Restraint],
) -> Result<(), MeshError> {
    let rotated = |r: &Restraint| r.dofs.iter().skip(3).any(Option::is_some);
    let normals = restraints.iter().any(rotated).then(|| Normals::new(parts));
    for restraint in restraints {
        let Restraint { target, line, dofs, card } = restraint;
        let common = normals.as_ref().map(|normals| normals.common(&target.nodes));
        let [u1, u2, u3, r1, r2, r3] = *dofs;
        if let Some((value, line)) = [r1, r2, r3].into_iter().flatten().find(|(value, _)| *value != 0.0) {
            return Err(reader.error(
                line,
                format!("the rotation {value} is prescribed"),
                "write two `prescribe` with `of = \"director\"` in the model file",
            ));
        }
        let rotations = [r1.is_some(), r2.is_some(), r3.is_some()];
        let fixed = [u1, u2, u3].map(|u| u.is_some_and(|(value, _)| value == 0.0));
        let components_of = |common| director_components(rotations, common);
        let mirrored = symmetry(parts, target, fixed, rotations);
        let director = match common.map(components_of) {
            Some(Some(director)) => director,
            // At the rim of a curved sheet the normals of the elements lie beside the plane of symmetry, to which those of the surface are parallel.
            Some(None) if mirrored.is_some() => [false; 3],
            Some(None) => return Err(oblique(reader, (*line, target), rotations)),
            None => [false; 3],
        };
        let plane = mirrored.filter(|&axis| director[axis] || common.map(components_of) == Some(None));
        let held = director == [true; 3] || common.is_some_and(|common| held(director, common));
        let mut entry = |kind: &str| {
            out.table(*line, head, card);
            out.key(*line, "type", &quoted(kind));
            out.key(*line, "on", &quoted(&target.name));
        };
        match (fixed, plane) {
            ([true, true, true], _) if held => entry("clamp"),
            ([true, true, true], None) if director == [false; 3] => entry("spherical"),
            (_, Some(axis)) => {
                entry("symmetry");
                let mut normal = [0.0; 3];
                normal[axis] = 1.0;
                out.key(*line, "normal", &vector(&normal));
                let mut others = fixed;
                others[axis] = false;
                if others != [false; 3] {
                    components(out, (head, card), (*line, target), others, [false; 3]);
                }
            }
            _ if fixed == [false; 3] && director == [false; 3] => {}
            _ => components(out, (head, card), (*line, target), fixed, director),
        }
        for (axis, u) in AXES.into_iter().zip([u1, u2, u3]) {
            if let Some((value, line)) = u.filter(|(value, _)| *value != 0.0) {
                out.table(line, head, card);
                out.key(line, "type", "\"prescribe\"");
                out.key(line, "on", &quoted(&target.name));
                out.key(line, "component", &quoted(axis));
                out.key(line, "value", &number(value));
            }
        }
    }
    Ok(())
}

/// Writes a `fix`.
fn components(
    out: &mut Document,
    (head, card): (&str, &str),
    (line, target): (usize, &Target),
    position: [bool; 3],
    director: [bool; 3],
) {
    out.table(line, head, card);
    out.key(line, "type", "\"fix\"");
    out.key(line, "on", &quoted(&target.name));
    if position != [false; 3] {
        out.key(line, "position", &axes(position));
    }
    if director != [false; 3] {
        out.key(line, "director", &axes(director));
    }
}

/// Whether these components of the directors fix their directions.
fn held(director: [bool; 3], common: Directions) -> bool {
    (0..3).any(|k| common.along[k] && (0..3).all(|i| i == k || director[i]))
}

/// Components of the directors that are fixed with these rotations; `None` where no components along the axes are.
fn director_components(rotations: [bool; 3], common: Directions) -> Option<[bool; 3]> {
    let along = (0..3).find(|&k| common.along[k]);
    let except = |k: usize| [k != 0, k != 1, k != 2];
    match (rotations.iter().filter(|fixed| **fixed).count(), along) {
        (0, _) => Some([false; 3]),
        (3, Some(k)) => Some(except(k)),
        (3, None) => Some([true; 3]),
        (2, _) => {
            let free = rotations.iter().position(|fixed| !fixed)?;
            match (common.along[free], common.across[free]) {
                (true, _) => Some(except(free)),
                (_, true) => Some([free == 0, free == 1, free == 2]),
                _ => None,
            }
        }
        (_, None) => None,
        (_, Some(k)) => {
            let about = rotations.iter().position(|fixed| *fixed)?;
            // Along the axis of the rotation it changes nothing; else the third axis is the one along which the director would tilt.
            Some([0, 1, 2].map(|i| about != k && i != about && i != k))
        }
    }
}

/// Axis of a plane of symmetry: no displacement along it, no rotations about the others, and all nodes in one plane.
fn symmetry(parts: &Parts, target: &Target, fixed: [bool; 3], rotations: [bool; 3]) -> Option<usize> {
    let axis = (0..3).find(|&k| fixed[k] && !rotations[k] && (0..3).all(|i| i == k || rotations[i]))?;
    let along = |node: &u64| parts.nodes.get(node).map(|(position, _)| position[axis]);
    let first = target.nodes.iter().find_map(along)?;
    let size = parts.used.iter().filter_map(along).map(|x| (x - first).abs()).fold(0.0, tegula::norm::larger);
    let flat = target.nodes.iter().filter_map(along).all(|x| (x - first).abs() <= IN_PLANE * size);
    flat.then_some(axis)
}

/// Error of rotations without a counterpart.
fn oblique(reader: &Reader<'_>, (line, target): (usize, &Target), rotations: [bool; 3]) -> MeshError {
    let numbers: Vec<String> =
        (4..).zip(rotations).filter(|(_, fixed)| *fixed).map(|(number, _)| number.to_string()).collect();
    reader.error(
        line,
        format!(
            "the fixed rotations {} of {} are no components of the directors there along x, y and z",
            numbers.join(", "),
            shown(&target.name)
        ),
        "shells have directors: one fixed rotation needs normals along an axis, two need normals along the third axis or across it; \
         fix all three rotations, or split the set",
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    const ANY: Directions = Directions { along: [false; 3], across: [false; 3] };

    fn along(k: usize) -> Directions {
        Directions { along: [k == 0, k == 1, k == 2], across: [k != 0, k != 1, k != 2] }
    }

    #[test]
    fn rotations_fix_the_components_that_they_would_change() {
        let found = |rotations: [u8; 3], common| {
            director_components(rotations.map(|r| r == 1), common).map(|found| found.map(u8::from))
        };
        // Normals along z: a rotation about x changes the y component, one about y the x component.
        assert_eq!(found([1, 0, 0], along(2)), Some([0, 1, 0]));
        assert_eq!(found([0, 1, 0], along(2)), Some([1, 0, 0]));
        assert_eq!(found([0, 0, 1], along(2)), Some([0, 0, 0]));
        assert_eq!(found([1, 1, 0], along(2)), Some([1, 1, 0]));
        assert_eq!(found([1, 1, 1], along(2)), Some([1, 1, 0]));
        assert_eq!(found([0, 1, 1], along(2)), Some([1, 0, 0]));
        assert_eq!(found([1, 0, 0], along(1)), Some([0, 0, 1]));
        let across_x = Directions { along: [false; 3], across: [true, false, false] };
        assert_eq!(found([0, 1, 1], across_x), Some([1, 0, 0]));
        assert_eq!(found([1, 1, 0], across_x), None);
        assert_eq!(found([1, 0, 0], across_x), None);
        assert_eq!(found([1, 1, 1], ANY), Some([1, 1, 1]));
        assert_eq!(found([0, 0, 0], ANY), Some([0, 0, 0]));
    }
}
