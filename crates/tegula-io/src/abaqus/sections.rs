//! `*SHELL SECTION`.

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
    reader.only(card, &["ELSET", "MATERIAL", "COMPOSITE", "OFFSET"])?;
    let elements = reader.required(card, "ELSET")?;
    let Some((on, _)) = parts.element_sets.get(elements) else {
        return Err(reader.error(
            card.line,
            format!("there is no element set \"{}\"", shown(elements)),
            "check the name of the set",
        ));
    };
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
            Layers::Plies(plies.collect::<Result<_, _>>()?)
        }
    };
    let (card, line) = ("*SHELL SECTION", card.line);
    Ok(Section { on: on.to_owned(), card, line, layers, direction: None, offset: None })
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
