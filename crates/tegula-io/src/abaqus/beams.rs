//! `*BEAM SECTION` and `*BEAM GENERAL SECTION`, and supports of the nodes of beams.

use std::collections::BTreeMap;

use tegula::model::{BeamSection, Isotropic, SectionConstants};
use tegula::section::beam;

use super::materials::Materials;
use crate::conversion::bars::{Section, text};
use crate::conversion::held::Hold;
use crate::conversion::supports::Restraint;
use crate::mesh::MeshError;
use crate::mesh::abaqus::beams::{self, GENERAL};
use crate::mesh::abaqus::cards::{Card, Reader, shown};
use crate::mesh::numbered::Parts;
use crate::mesh::numbered::bars::frame::Frame;
use crate::mesh::numbered::normals::Target;

/// Cross-sections of a file by the lines of their cards.
///
/// # Errors
/// The first mistake of a card.
pub(super) fn sections(
    reader: &Reader<'_>,
    cards: &[Card<'_>],
    materials: &Materials,
) -> Result<BTreeMap<u64, Section>, MeshError> {
    let section = |card: &Card<'_>| -> Result<(u64, Section), MeshError> {
        let found = match card.keyword.as_str() {
            GENERAL => general(reader, card)?,
            _ => of_material(reader, card, materials)?,
        };
        Ok((card.line as u64, found))
    };
    beams::sections(cards).map(section).collect()
}

/// Section of a shape and a material.
fn of_material(reader: &Reader<'_>, card: &Card<'_>, materials: &Materials) -> Result<Section, MeshError> {
    reader.only(card, &["ELSET", "MATERIAL", "SECTION", "POISSON", "TEMPERATURE"])?;
    if let Some(data) = card.data.get(2) {
        return Err(reader.error(
            data.line,
            "a *BEAM SECTION has no third line",
            "give the sizes on the first line and the direction n1 on the second one",
        ));
    }
    let Some(shape) = beams::shape(reader, card)? else {
        return Err(reader.error(
            card.line,
            "*BEAM SECTION, SECTION=GENERAL is not read",
            "give the constants with the elastic moduli by *BEAM GENERAL SECTION, SECTION=GENERAL",
        ));
    };
    let name = reader.required(card, "MATERIAL")?;
    match materials.spelling(name) {
        None => Err(reader.error(
            card.line,
            format!("there is no material \"{}\"", shown(name)),
            "check the name, or define it with *MATERIAL",
        )),
        Some(_) if !materials.is_isotropic(name) => Err(reader.error(
            card.line,
            format!("the material {} of a beam is not isotropic", shown(name)),
            "give *ELASTIC, TYPE=ISOTROPIC: beams have no other materials",
        )),
        Some(spelt) => Ok(Section { text: text(&shape), material: Some(spelt.to_owned()), line: card.line }),
    }
}

/// Section with elastic moduli of its own: constants of the section, or a shape.
fn general(reader: &Reader<'_>, card: &Card<'_>) -> Result<Section, MeshError> {
    reader.only(card, &["ELSET", "SECTION", "DENSITY", "POISSON"])?;
    let density = card.parameter("DENSITY").map_or(Ok(0.0), |field| reader.number(card.line, field))?;
    let [_, _, moduli] = card.data[..] else {
        return Err(reader.error(
            card.line,
            format!("*{GENERAL} has {} data lines that are not empty", card.data.len()),
            "give three: the section, the direction n1, which may not be left out here, and the moduli E and G",
        ));
    };
    let fields = moduli.list();
    let values: Vec<f64> =
        fields.iter().map(|field| reader.number(moduli.line, field)).collect::<Result<_, _>>()?;
    let (young, modulus) = match values[..] {
        [young, modulus] | [young, modulus, ..] if young > 0.0 && modulus > 0.0 && values.len() <= 3 => {
            (young, modulus)
        }
        _ => {
            return Err(reader.error(
                moduli.line,
                "these are no moduli of a beam",
                "write Young's modulus E and the shear modulus G, both above 0; they do not depend on the temperature",
            ));
        }
    };
    let constants = match beams::shape(reader, card)? {
        Some(shape) => {
            let material = Isotropic::new(young, 0.5 * young / modulus - 1.0, density);
            beam::constants(&shape, Some(&material))
        }
        None => Some(given(reader, card, (young, modulus), density)?),
    };
    let section = constants.map_or_else(String::new, |found| text(&BeamSection::Constants(found)));
    Ok(Section { text: section, material: None, line: card.line })
}

/// Constants of a section that are given: A, I11, I12, I22 and J. The shear factor of such a section is 1.
fn given(
    reader: &Reader<'_>,
    card: &Card<'_>,
    (young, modulus): (f64, f64),
    density: f64,
) -> Result<SectionConstants, MeshError> {
    let what = "the area A, the moments of area I11, I12 and I22, and the torsion constant J";
    let (values, line) = beams::sizes(reader, card, (&[5, 6, 7], what))?;
    let [area, about_1, product, about_2, torsion, ref warping @ ..] = values[..] else {
        return Err(reader.error(line, "the section is incomplete", format!("give {what}")));
    };
    if product != 0.0 {
        return Err(reader.error(
            line,
            format!("the product of area I12 is {product}"),
            "turn n1 into a principal axis of the section, and give its principal moments in I11 and I22",
        ));
    }
    if [area, about_1, about_2, torsion].iter().any(|value| !(*value > 0.0)) {
        let message = format!("the section has the constants {values:?}");
        let help = format!("give {what}; all but I12 are above 0");
        return Err(reader.error(line, message, help));
    }
    if warping.iter().any(|value| *value != 0.0) {
        return Err(reader.error(
            line,
            "the warping constants of a section are not read",
            "leave them out: cross-sections of beams do not warp",
        ));
    }
    Ok(SectionConstants {
        axial: young * area,
        shear: [modulus * area; 2],
        bending: [young * about_1, young * about_2],
        torsion: modulus * torsion,
        mass: density * area,
        inertia: [density * about_1, density * about_2],
    })
}

/// Supports of shells without the nodes of beams, and those of the cross-sections of beams, of which each has all degrees of freedom that cards fix.
///
/// # Errors
/// A degree of freedom of a node of a beam has two values.
pub(super) fn held(
    reader: &Reader<'_>,
    parts: &Parts,
    frame: &Frame,
    restraints: Vec<Restraint>,
) -> Result<(Vec<Restraint>, Vec<Hold>), MeshError> {
    let mut of_shells = Vec::new();
    let mut holds: BTreeMap<u64, Hold> = BTreeMap::new();
    for restraint in restraints {
        let Restraint { target: Target { name, nodes }, line, dofs, card } = restraint;
        let (of_beams, others): (Vec<u64>, Vec<u64>) =
            nodes.into_iter().partition(|node| frame.carriers.contains_key(node));
        for node in &of_beams {
            let (Some(section), Some((at, _))) = (frame.carriers.get(node), parts.nodes.get(node)) else {
                continue;
            };
            let (name, at) = (section.clone(), (*at).into());
            let hold = holds.entry(*node).or_insert(Hold { name, at, line, card, values: [None; 6] });
            for (i, (of, value)) in hold.values.iter_mut().zip(dofs).enumerate() {
                let Some((value, line)) = value else { continue };
                if let Some((earlier, at)) = of.filter(|(earlier, _)| *earlier != value) {
                    let message = format!(
                        "degree of freedom {} of node {node} gets {value}, and {earlier} on line {at}",
                        i + 1
                    );
                    return Err(reader.error(line, message, "give it one value"));
                }
                *of = Some((value, line));
            }
        }
        if !others.is_empty() {
            let on_shells = of_beams.iter().any(|node| parts.used.contains(node));
            let name = if on_shells { beams::beside(&name) } else { name };
            of_shells.push(Restraint { target: Target { name, nodes: others }, line, dofs, card });
        }
    }
    let mut holds: Vec<Hold> = holds.into_values().collect();
    holds.sort_by_key(|hold| hold.line);
    Ok((of_shells, holds))
}
