//! Supports of bodies and of cross-sections of bars: joints to the ground.

use super::document::{Document, quoted, vector};
use crate::mesh::MeshError;
use crate::mesh::numbered::Reader;

/// Name of the amplitude of drives that hold a body.
const AT_REST: &str = "at rest";

/// A joint to the ground: type, keys with their values in TOML, and whether it has a place.
type Held = (&'static str, Vec<(&'static str, String)>, bool);

/// Support of a body or of a cross-section.
#[derive(Debug)]
pub(crate) struct Hold {
    /// Name of the body.
    pub name: String,
    /// Its place.
    pub at: [f64; 3],
    /// Line on which the support stands first.
    pub line: usize,
    /// Card of that line, as it is spelt in the file.
    pub card: &'static str,
    /// Value of each degree of freedom, and its line.
    pub values: [Option<(f64, usize)>; 6],
}

/// Writes supports as joints.
///
/// # Errors
/// A prescribed motion.
pub(crate) fn write(out: &mut Document, reader: &Reader<'_>, holds: &[Hold]) -> Result<(), MeshError> {
    let mut driven = None;
    for Hold { name, at, line, card, values } in holds {
        if let Some((value, line)) = values.iter().flatten().find(|(value, _)| *value != 0.0) {
            return Err(reader.error(
                *line,
                format!("the displacement {value} of {name} is prescribed"),
                "give a joint `driven-length` or `driven-angle` in the model file that `tegula convert` writes of the rest",
            ));
        }
        let joints = joints(values.map(|value| value.is_some()));
        for (i, (kind, keys, has_place)) in joints.iter().enumerate() {
            let number = if i == 0 { String::new() } else { format!(" no {}", i + 1) };
            out.table(*line, "[[joints]]", card);
            out.key(*line, "type", &quoted(kind));
            out.key(*line, "name", &quoted(&format!("support of {name}{number}")));
            out.key(*line, "between", &format!("[\"ground\", {}]", quoted(name)));
            if *has_place {
                out.key(*line, "at", &vector(at));
            }
            for (key, value) in keys {
                out.key(*line, key, value);
            }
            if kind.starts_with("driven") {
                driven = driven.or(Some((*line, *card)));
            }
        }
    }
    if let Some((line, card)) = driven {
        out.table(line, &format!("[amplitudes.{}]", quoted(AT_REST)), card);
        out.key(line, "type", "\"constant\"");
        out.key(line, "value", "1.0");
    }
    Ok(())
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
