//! Supports of nodes, of bodies, and of cross-sections of bars.

use crate::conversion::document::{Document, quoted, vector};
use crate::conversion::supports::{self, Restraint};
use crate::mesh::MeshError;
use crate::mesh::nastran::file::File;
use crate::mesh::nastran::supports::{Support, supports};
use crate::mesh::numbered::{Parts, Reader};

/// Name of the amplitude of drives that hold a body.
const AT_REST: &str = "at rest";

/// A joint to the ground: type, keys with their values in TOML, and whether it has a place.
type Held = (&'static str, Vec<(&'static str, String)>, bool);

/// Writes supports of nodes, of the bodies of rigid elements, and of cross-sections of bars.
///
/// # Errors
/// A support that cannot be read, or a prescribed motion of a body.
pub(super) fn write(
    out: &mut Document,
    reader: &Reader<'_>,
    file: &File<'_>,
    parts: &Parts,
) -> Result<(), MeshError> {
    let found = supports(reader, file, parts)?;
    let (bodies, nodes): (Vec<Support>, Vec<Support>) =
        found.into_iter().partition(|support| support.body.is_some());
    let mut driven = None;
    for Support { target, line, card, values, body } in bodies {
        if let Some((value, line)) = values.iter().flatten().find(|(value, _)| *value != 0.0) {
            return Err(reader.error(
                *line,
                format!("the displacement {value} of {} is prescribed", target.name),
                "give a joint `driven-length` or `driven-angle` in the model file that `tegula convert` writes of the rest",
            ));
        }
        let joints = joints(values.map(|value| value.is_some()));
        for (i, (kind, keys, has_place)) in joints.iter().enumerate() {
            let number = if i == 0 { String::new() } else { format!(" no {}", i + 1) };
            out.table(line, "[[joints]]", card);
            out.key(line, "type", &quoted(kind));
            out.key(line, "name", &quoted(&format!("support of {}{number}", target.name)));
            out.key(line, "between", &format!("[\"ground\", {}]", quoted(&target.name)));
            if *has_place {
                out.key(line, "at", &vector(&body.unwrap_or_default()));
            }
            for (key, value) in keys {
                out.key(line, key, value);
            }
            if kind.starts_with("driven") {
                driven = driven.or(Some((line, card)));
            }
        }
    }
    if let Some((line, card)) = driven {
        out.table(line, &format!("[amplitudes.{}]", quoted(AT_REST)), card);
        out.key(line, "type", "\"constant\"");
        out.key(line, "value", "1.0");
    }
    let restraint =
        |Support { target, line, card, values, .. }: Support| Restraint { target, line, dofs: values, card };
    let restraints: Vec<Restraint> = nodes.into_iter().map(restraint).collect();
    supports::write(out, reader, parts, "[[conditions]]", &restraints)
}

/// Joints that fix these displacements and rotations. Where no joint fixes just them, drives at rest do, one for each.
fn joints(fixed: [bool; 6]) -> Vec<Held> {
    let ([a, b, c], [d, e, f]) = ([fixed[0], fixed[1], fixed[2]], [fixed[3], fixed[4], fixed[5]]);
    let (translations, rotations) = ([a, b, c], [d, e, f]);
    let count = |of: [bool; 3]| of.into_iter().filter(|fixed| *fixed).count();
    let first = |of: [bool; 3], is: bool| of.into_iter().position(|fixed| fixed == is).unwrap_or_default();
    let unit = |axis: usize| {
        let mut out = [0.0; 3];
        out[axis] = 1.0;
        vector(&out)
    };
    let axis = |axis: usize| vec![("axis", unit(axis))];
    let single = |kind, keys| vec![(kind, keys, true)];
    let opposite = translations == rotations.map(|fixed| !fixed);
    match (count(translations), count(rotations)) {
        (3, 3) => single("fixed", Vec::new()),
        (3, 0) => single("spherical", Vec::new()),
        (3, 2) => single("revolute", axis(first(rotations, false))),
        (3, 1) => {
            let about = first(rotations, true);
            let axes = format!("[{}, {}]", unit((about + 1) % 3), unit((about + 2) % 3));
            single("universal", vec![("axes", axes)])
        }
        (2, 3) => single("prismatic", axis(first(translations, false))),
        (2, 2) if translations == rotations => single("cylindrical", axis(first(translations, false))),
        (1, 2) if opposite => single("planar", axis(first(translations, true))),
        _ => {
            let of = |directions: [bool; 3]| (0..3).filter(move |axis| directions[*axis]);
            let drive = |axis: usize, key: &'static str| {
                vec![("axis", unit(axis)), (key, "1.0".to_owned()), ("amplitude", quoted(AT_REST))]
            };
            let lengths = of(translations).map(|axis| ("driven-length", drive(axis, "length"), true));
            let angles = of(rotations).map(|axis| ("driven-angle", drive(axis, "angle"), false));
            lengths.chain(angles).collect()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::joints;

    #[test]
    fn joints_fix_the_components_of_a_support() {
        for (digits, expected) in [
            ("123456", &["fixed"][..]),
            ("123", &["spherical"]),
            ("12346", &["revolute"]),
            ("1234", &["universal"]),
            ("23456", &["prismatic"]),
            ("2356", &["cylindrical"]),
            ("156", &["planar"]),
            ("345", &["planar"]),
            ("23", &["driven-length", "driven-length"]),
            ("234", &["driven-length", "driven-length", "driven-angle"]),
            ("6", &["driven-angle"]),
        ] {
            let found = joints([1, 2, 3, 4, 5, 6].map(|digit: u32| digits.contains(&digit.to_string())));
            let kinds: Vec<&str> = found.iter().map(|(kind, ..)| *kind).collect();
            assert_eq!(kinds, expected, "{digits}");
        }
        let axis = |digits: [bool; 6]| joints(digits)[0].1[0].1.clone();
        assert_eq!(axis([true, false, false, false, true, true]), "[1.0, 0.0, 0.0]");
        assert_eq!(axis([true, true, true, true, false, true]), "[0.0, 1.0, 0.0]");
        assert_eq!(axis([true, true, true, true, false, false]), "[[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]");
    }
}
