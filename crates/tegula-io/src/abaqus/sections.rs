//! `*SHELL SECTION`.

use std::collections::BTreeSet;

use super::materials::Materials;
use crate::conversion::sections::{Layers, Ply, Section};
use crate::mesh::MeshError;
use crate::mesh::abaqus::cards::{Card, DataLine, Reader, shown};
use crate::mesh::numbered::Parts;

/// Section of a card.
///
/// # Errors
/// The first mistake, or the first parameter that is not read.
pub(super) fn section(
    reader: &Reader<'_>,
    card: &Card<'_>,
    parts: &Parts,
    materials: &Materials,
) -> Result<Section, MeshError> {
    refuse(reader, card)?;
    let is_solid = !parts.through.is_empty();
    match is_solid {
        true => reader.only(card, &["ELSET", "MATERIAL", "COMPOSITE", "OFFSET", "STACK DIRECTION"])?,
        false => reader.only(card, &["ELSET", "MATERIAL", "COMPOSITE", "OFFSET"])?,
    }
    let elements = reader.required(card, "ELSET")?;
    let Some((on, members)) = parts.element_sets.get(elements) else {
        return Err(reader.error(
            card.line,
            format!("there is no element set \"{}\"", shown(elements)),
            "check the name of the set",
        ));
    };
    if let Some(bar) = parts.bars.iter().find(|bar| members.contains(&bar.label)) {
        return Err(reader.error(
            card.line,
            format!("element {} of the set \"{}\" is a beam", bar.label, shown(on)),
            "give the section a set of shells alone",
        ));
    }
    if let Some(offset) = card.parameter("OFFSET")
        && reader.number(card.line, offset)? != 0.0
    {
        return Err(reader.error(
            card.line,
            "OFFSET of a shell section is not read",
            "remove it, and give `offset` of a `layup` in the model file that `tegula convert` writes; it is a length and has the other sign",
        ));
    }
    let layers = match card.has("COMPOSITE") {
        false => {
            let material = reader.required(card, "MATERIAL")?;
            let data = reader.single(card, "the thickness")?;
            let fields = data.list();
            points(reader, data, fields.get(1), fields.get(2..))?;
            let material = known(reader, card.line, materials, material)?;
            let thickness = reader.number(data.line, fields.first().copied().unwrap_or_default())?;
            Layers::One { material, thickness, line: data.line }
        }
        true => {
            let plies = card.data.iter().map(|data| ply(reader, *data, materials));
            let plies: Vec<Ply> = plies.collect::<Result<_, _>>()?;
            Layers::Plies(if is_solid { stacked(parts, members, plies) } else { plies })
        }
    };
    let (card, line) = ("*SHELL SECTION", card.line);
    let element = is_solid.then_some("solid-shell");
    Ok(Section { on: on.to_owned(), card, line, element, layers, direction: None, offset: None })
}

/// Layers of continuum shells, whose thicknesses are parts of that of the elements: those of the first node, which the check of the model compares
/// with all others.
fn stacked(parts: &Parts, members: &BTreeSet<u64>, mut plies: Vec<Ply>) -> Vec<Ply> {
    let total: f64 = plies.iter().map(|ply| ply.thickness).sum();
    let first = parts.elements.iter().find(|element| members.contains(&element.label));
    let through = first.and_then(|element| parts.through.get(element.nodes.first()?));
    let factor = through.map_or(1.0, |through| through.norm() / total);
    // Round-off of the coordinates does not change the thicknesses of the card.
    if factor.is_finite() && (factor - 1.0).abs() > 1e-9 {
        plies.iter_mut().for_each(|ply| ply.thickness *= factor);
    }
    plies
}

/// Parameters that change the shell and are not read.
fn refuse(reader: &Reader<'_>, card: &Card<'_>) -> Result<(), MeshError> {
    let help = |name: &str| match name {
        "NODAL THICKNESS" => Some(
            "give sections of different thicknesses, or `thickness_distribution`, a formula of the place",
        ),
        "ORIENTATION" => Some(
            "remove it, and give `direction` of a `layup` in the model file that `tegula convert` writes",
        ),
        "DENSITY" => Some("give *DENSITY of the material"),
        _ => None,
    };
    if let Some(direction) = card.parameter("STACK DIRECTION").filter(|direction| *direction != "3") {
        return Err(reader.error(
            card.line,
            format!("STACK DIRECTION={} is not read", shown(direction)),
            "number the nodes of the elements so that the thickness runs from the nodes 1 to 4 to the nodes 5 to 8, which is direction 3",
        ));
    }
    match card.parameters.iter().find_map(|p| Some((&p.name, help(&p.name)?))) {
        Some((name, help)) => {
            Err(reader.error(card.line, format!("{name} of a shell section is not read"), help))
        }
        None => Ok(()),
    }
}

/// Checks the number of section points, which is not needed: elastic layers are integrated exactly.
fn points(
    reader: &Reader<'_>,
    data: DataLine<'_>,
    points: Option<&&str>,
    rest: Option<&[&str]>,
) -> Result<(), MeshError> {
    reader.number(data.line, points.copied().unwrap_or_default())?;
    match rest.unwrap_or_default().iter().find(|field| !field.is_empty()) {
        Some(field) => Err(reader.error(
            data.line,
            format!("the section has a further value \"{}\"", shown(field)),
            "give the thickness and the number of section points",
        )),
        None => Ok(()),
    }
}

/// Ply of a data line: thickness, section points, material, angle.
fn ply(reader: &Reader<'_>, data: DataLine<'_>, materials: &Materials) -> Result<Ply, MeshError> {
    let fields = data.list();
    let field = |i: usize| fields.get(i).copied().unwrap_or_default();
    let thickness = reader.number(data.line, field(0))?;
    reader.number(data.line, field(1))?;
    let material = known(reader, data.line, materials, field(2))?;
    let angle = reader.number(data.line, field(3)).map_err(|_| {
        reader.error(
            data.line,
            format!("the angle of the ply is \"{}\"", shown(field(3))),
            "give the angle in degrees from the x axis projected on the surface; orientations are not read",
        )
    })?;
    Ok(Ply { material, thickness, angle, line: data.line })
}

fn known(reader: &Reader<'_>, line: usize, materials: &Materials, name: &str) -> Result<String, MeshError> {
    materials.spelling(name).map(str::to_owned).ok_or_else(|| {
        reader.error(
            line,
            format!("there is no material \"{}\"", shown(name)),
            "check the name, or define it with *MATERIAL",
        )
    })
}
