//! Bars: `CBAR` with `PBAR` and `PBARL`.

use std::collections::BTreeMap;

use tegula::model::{
    BeamSection, BoxSection, CircularSection, Isotropic, RectangularSection, SectionConstants,
};
use tegula::section::beam;

use super::notes::Notes;
use crate::conversion::bars::{Section, text};
use crate::conversion::materials::{Elastic, Material};
use crate::mesh::MeshError;
use crate::mesh::nastran::bars;
use crate::mesh::nastran::cards::Card;
use crate::mesh::nastran::file::File;
use crate::mesh::numbered::bars::frame::Frame;
use crate::mesh::numbered::{Reader, shown};

/// Shear stiffness over GA of bars that are rigid in shear: next to their bending its flexibility is round-off.
const RIGID: f64 = 1e6;

/// Materials by their numbers.
type Materials = BTreeMap<u64, Material>;

/// Cross-sections of the properties that bars have.
///
/// # Errors
/// The first mistake of a card, or a property that is missing.
pub(super) fn sections(
    reader: &Reader<'_>,
    file: &File<'_>,
    frame: &Frame,
    materials: &Materials,
    notes: &mut Notes,
) -> Result<BTreeMap<u64, Section>, MeshError> {
    let used = bars::properties(file);
    let mut out = BTreeMap::new();
    let mut lines: BTreeMap<u64, usize> = file
        .cards
        .iter()
        .filter(|card| matches!(card.name.as_str(), "PSHELL" | "PCOMP"))
        .filter_map(|card| Some((card.field(0).text.parse().ok()?, card.line)))
        .collect();
    for card in file.cards.iter().filter(|card| matches!(card.name.as_str(), "PBAR" | "PBARL")) {
        let number = card.id(reader, 0, "the number")?;
        if let Some(earlier) = lines.insert(number, card.line) {
            let message = format!("the property {number} is defined again; line {earlier} does so, too");
            return Err(reader.error(card.line, message, "give each property a number of its own"));
        }
        if !used.contains(&number) {
            notes.add(format!("{} {number}, which no element has", card.name), card.line);
            continue;
        }
        let section = match card.name.as_str() {
            "PBAR" => constants(reader, card, materials, notes)?,
            _ => shape(reader, card, materials)?,
        };
        out.insert(number, section);
    }
    match frame.lines.iter().find(|line| !out.contains_key(&line.property)) {
        None => Ok(out),
        Some(line) => Err(reader.error(
            line.line,
            format!("{} needs the property {}, which the file does not define", line.name, line.property),
            "define it with PBAR or PBARL",
        )),
    }
}

/// Name, constants and density of the material of a card.
fn material<'m>(
    reader: &Reader<'_>,
    card: &Card<'_>,
    materials: &'m Materials,
) -> Result<(&'m str, Isotropic), MeshError> {
    let number = card.id(reader, 1, "the material MID")?;
    let found = materials.get(&number);
    match found.and_then(|material| Some((material, material.elastic.as_ref()?))) {
        Some((material, (_, Elastic::Isotropic([young, poisson])))) => {
            let density = material.density.map_or(0.0, |(_, density)| density);
            Ok((&material.name, Isotropic::new(*young, *poisson, density)))
        }
        _ => Err(reader.error(
            card.line,
            format!("there is no material {number} among MAT1"),
            "define it with MAT1; bars have no other materials",
        )),
    }
}

/// A value above 0.
fn positive(reader: &Reader<'_>, card: &Card<'_>, index: usize, what: &str) -> Result<f64, MeshError> {
    let value = card.required(reader, index, what)?;
    if value > 0.0 {
        return Ok(value);
    }
    let message = format!("{what} of {} {} is {value}", card.name, card.field(0).text);
    let help = "give a value above 0: a bar stretches, bends in both planes and twists";
    Err(reader.error(card.field(index).line, message, help))
}

/// Section constants of a `PBAR`. The axes 1 and 2 of the beam are y and z of the bar; I1 belongs to bending in the plane of x and y, about z.
fn constants(
    reader: &Reader<'_>,
    card: &Card<'_>,
    materials: &Materials,
    notes: &mut Notes,
) -> Result<Section, MeshError> {
    let (_, Isotropic { young, poisson, density, .. }) = material(reader, card, materials)?;
    let area = positive(reader, card, 2, "A")?;
    let about_z = positive(reader, card, 3, "I1")?;
    let about_y = positive(reader, card, 4, "I2")?;
    let torsion = positive(reader, card, 5, "J")?;
    let added = card.real(reader, 6, "NSM")?.unwrap_or(0.0);
    let names = ["C1", "C2", "D1", "D2", "E1", "E2", "F1", "F2"];
    let fields: Vec<(usize, &str)> = (8..).zip(names).collect();
    notes.fields(card, &fields);
    let factor = |index: usize, what: &str| -> Result<f64, MeshError> {
        let value = card.real(reader, index, what)?.filter(|value| *value != 0.0);
        value.map_or(Ok(RIGID), |_| positive(reader, card, index, what))
    };
    let factors = [factor(16, "K1")?, factor(17, "K2")?];
    let help = "turn the orientation vectors into the principal axes of the section, and give its principal moments in I1 and I2";
    card.none(reader, 18, "the product of inertia I12", help)?;
    card.only(reader, 19)?;
    let modulus = 0.5 * young / (1.0 + poisson);
    let constants = SectionConstants {
        axial: young * area,
        shear: factors.map(|factor| factor * modulus * area),
        bending: [young * about_y, young * about_z],
        torsion: modulus * torsion,
        mass: density * area + added,
        inertia: [density * about_y, density * about_z],
    };
    Ok(Section { text: text(&BeamSection::Constants(constants)), material: None, line: card.line })
}

/// Cross-section of a `PBARL`.
fn shape(reader: &Reader<'_>, card: &Card<'_>, materials: &Materials) -> Result<Section, MeshError> {
    let number = card.field(0).text;
    let (name, material) = material(reader, card, materials)?;
    let group = card.field(2);
    if !(group.text.is_empty() || group.text.eq_ignore_ascii_case("MSCBML0")) {
        let message = format!("the group \"{}\" of PBARL {number} is not read", shown(group.text));
        return Err(reader.error(group.line, message, "leave it blank"));
    }
    let size = |i: usize| positive(reader, card, 8 + i, &format!("DIM{}", i + 1));
    let kind = card.field(3);
    let (section, count) = match kind.text.to_uppercase().as_str() {
        "ROD" => (BeamSection::Circle(CircularSection { radius: size(0)?, inner_radius: 0.0 }), 1),
        "TUBE" => {
            let inner_radius = card.real(reader, 9, "DIM2")?.unwrap_or(0.0);
            (BeamSection::Circle(CircularSection { radius: size(0)?, inner_radius }), 2)
        }
        "BAR" => (BeamSection::Rectangle(RectangularSection { size: [size(1)?, size(0)?] }), 2),
        "BOX" => {
            let (walls, thickness) = ([size(1)?, size(0)?], size(2)?);
            if (size(3)? - thickness).abs() > 1e-9 * thickness {
                let message =
                    format!("the walls of PBARL {number} have the thicknesses {thickness} and {}", size(3)?);
                let help = "give a PBAR with the constants of the section: a box has walls of one thickness";
                return Err(reader.error(card.field(11).line, message, help));
            }
            (BeamSection::Box(BoxSection { size: walls, thickness }), 4)
        }
        other => {
            let message = format!("the type \"{}\" of PBARL {number} is not read", shown(other));
            let help = "give ROD, TUBE, BAR or BOX, or a PBAR with the constants of the section";
            return Err(reader.error(kind.line, message, help));
        }
    };
    for at in 4..8 {
        card.none(
            reader,
            at,
            &format!("field {}", at + 2),
            "leave it blank: DIM1 is the first field of the next line",
        )?;
    }
    let added = card.real(reader, 8 + count, "NSM")?.unwrap_or(0.0);
    card.only(reader, 9 + count)?;
    let with_mass = beam::constants(&section, Some(&material)).filter(|_| added != 0.0);
    let line = card.line;
    Ok(match with_mass {
        None => Section { text: text(&section), material: Some(name.to_owned()), line },
        Some(mut constants) => {
            constants.mass += added;
            Section { text: text(&BeamSection::Constants(constants)), material: None, line }
        }
    })
}
