//! `PSHELL` and `PCOMP`.

use std::collections::BTreeMap;

use super::notes::Notes;
use crate::conversion::materials::{Elastic, Material};
use crate::conversion::sections::{Layers, Ply, Section};
use crate::mesh::MeshError;
use crate::mesh::nastran::angles::Properties;
use crate::mesh::nastran::bulk::Bulk;
use crate::mesh::nastran::cards::Card;
use crate::mesh::nastran::file::File;
use crate::mesh::numbered::{Reader, shown};

/// Materials by their numbers.
type Materials = BTreeMap<u64, Material>;

/// Layers of a property, and the height of their middle above the mesh.
struct Property {
    layers: Layers,
    offset: Option<(f64, usize)>,
}

/// Sections of the properties that elements have, in the order of the file.
///
/// # Errors
/// The first mistake of a card, or a property that is missing.
pub(super) fn sections(
    reader: &Reader<'_>,
    file: &File<'_>,
    bulk: &Bulk,
    materials: &Materials,
    notes: &mut Notes,
) -> Result<Vec<Section>, MeshError> {
    let mut out = Vec::new();
    let mut lines: BTreeMap<u64, usize> = BTreeMap::new();
    let used = Properties::new(file, bulk);
    for card in &file.cards {
        let (is_layup, keyword) = match card.name.as_str() {
            "PSHELL" => (false, "PSHELL"),
            "PCOMP" => (true, "PCOMP"),
            _ => continue,
        };
        let number = card.id(reader, 0, "the number")?;
        if let Some(earlier) = lines.insert(number, card.line) {
            return Err(reader.error(
                card.line,
                format!("the property {number} is defined again; line {earlier} does so, too"),
                "give each property a number of its own",
            ));
        }
        if !used.has(number) {
            notes.add(format!("{keyword} {number}, which no element has"), card.line);
            continue;
        }
        let property = if is_layup {
            layup(reader, card, materials, notes)?
        } else {
            shell(reader, card, materials, notes)?
        };
        for group in used.groups(reader, bulk, number)? {
            let layers = match &property.layers {
                Layers::One { material, thickness, line } => {
                    Layers::One { material: material.clone(), thickness: *thickness, line: *line }
                }
                Layers::Plies(plies) => Layers::Plies(plies.clone()),
            };
            let (on, direction) = (group.name, group.direction);
            out.push(Section {
                on,
                card: keyword,
                line: card.line,
                element: None,
                layers,
                direction,
                offset: property.offset,
            });
        }
    }
    let missing =
        bulk.parts.elements.iter().zip(&bulk.shells).find(|(_, shell)| !lines.contains_key(&shell.property));
    match missing {
        None => Ok(out),
        Some((element, shell)) => Err(reader.error(
            element.line,
            format!(
                "element {} needs the property {}, which the file does not define",
                element.label, shell.property
            ),
            "define it with PSHELL or PCOMP",
        )),
    }
}

fn known<'m>(
    reader: &Reader<'_>,
    line: usize,
    materials: &'m Materials,
    number: u64,
) -> Result<&'m Material, MeshError> {
    materials.get(&number).ok_or_else(|| {
        let message = format!("there is no material {number} among MAT1 and MAT8");
        reader.error(line, message, "define it with MAT1 or MAT8; other materials are not read")
    })
}

fn shell(
    reader: &Reader<'_>,
    card: &Card<'_>,
    materials: &Materials,
    notes: &mut Notes,
) -> Result<Property, MeshError> {
    let number = card.id(reader, 0, "the number")?;
    let membrane = card.id(reader, 1, "the material MID1")?;
    let thickness = card.required(reader, 2, "the thickness T")?;
    let same = |index: usize, name: &str, blank: &str| {
        let field = card.field(index);
        match field.text {
            "" => Err(reader.error(
                field.line,
                format!("{name} of PSHELL {number} is blank: {blank}"),
                format!("write {name} = {membrane}, the material of MID1, for a shell as it is here"),
            )),
            text if text.parse() == Ok(membrane) => Ok(()),
            text => Err(reader.error(
                field.line,
                format!("{name} of PSHELL {number} is {}, and MID1 is {membrane}", shown(text)),
                "a shell has one material; give a PCOMP, or a `layup` in a model file",
            )),
        }
    };
    same(3, "MID2", "this is a membrane without bending stiffness")?;
    same(5, "MID3", "this is a plate that is rigid in transverse shear")?;
    let factor = |index: usize, name: &str, expected: f64| match card.real(reader, index, name)? {
        Some(value) if (value - expected).abs() > 1e-4 * expected => Err(reader.error(
            card.field(index).line,
            format!("{name} of PSHELL {number} is {value}, which is not read"),
            format!("leave it blank: the layers of a shell give {expected:.6}"),
        )),
        _ => Ok(()),
    };
    factor(4, "12I/T**3", 1.0)?;
    factor(6, "TS/T", 5.0 / 6.0)?;
    card.none(reader, 7, "the mass NSM", "give `[[masses]]` in the model file that `tegula convert` writes")?;
    notes.fields(card, &[(8, "Z1"), (9, "Z2")]);
    card.none(reader, 10, "the material MID4", "give a PCOMP for a layup that is not symmetric")?;
    card.only(reader, 11)?;
    let material = known(reader, card.line, materials, membrane)?;
    let (material, line) = (material.name.clone(), card.line);
    let layers = match materials.get(&membrane).and_then(|material| material.elastic.as_ref()) {
        Some((_, Elastic::Orthotropic(_))) => {
            Layers::Plies(vec![Ply { material, thickness, angle: 0.0, line }])
        }
        _ => Layers::One { material, thickness, line },
    };
    Ok(Property { layers, offset: None })
}

fn layup(
    reader: &Reader<'_>,
    card: &Card<'_>,
    materials: &Materials,
    notes: &mut Notes,
) -> Result<Property, MeshError> {
    let number = card.id(reader, 0, "the number")?;
    let bottom = card.real(reader, 1, "Z0")?;
    card.none(reader, 2, "the mass NSM", "give `[[masses]]` in the model file that `tegula convert` writes")?;
    notes.fields(card, &[(3, "SB"), (4, "FT"), (5, "TREF"), (6, "GE")]);
    let symmetric = match card.field(7).text.to_uppercase().as_str() {
        "" => false,
        "SYM" => true,
        other => {
            let message = format!("LAM = {} of PCOMP {number} is not read", shown(other));
            return Err(reader.error(card.field(7).line, message, "leave it blank, or write SYM"));
        }
    };
    let mut plies: Vec<Ply> = Vec::new();
    let (mut material, mut thickness) = (None, None);
    for at in (8..card.count()).step_by(4) {
        let line = card.field(at).line;
        if (at..at + 4).all(|i| card.field(i).text.is_empty()) {
            continue;
        }
        // A blank material or thickness is that of the ply before.
        if !card.field(at).text.is_empty() {
            material = Some(card.id(reader, at, "the material of a ply")?);
        }
        thickness = card.real(reader, at + 1, "the thickness of a ply")?.or(thickness);
        let (Some(of), Some(t)) = (material, thickness) else {
            return Err(reader.error(
                line,
                "the first ply of PCOMP has no material or no thickness",
                "give both",
            ));
        };
        let angle = card.real(reader, at + 2, "the angle of a ply")?.unwrap_or(0.0);
        let sout = card.field(at + 3);
        if !matches!(sout.text.to_uppercase().as_str(), "" | "YES" | "NO") {
            let message = format!("SOUT of PCOMP {number} is \"{}\"", shown(sout.text));
            return Err(reader.error(sout.line, message, "write YES or NO"));
        }
        plies.push(Ply {
            material: known(reader, line, materials, of)?.name.clone(),
            thickness: t,
            angle,
            line,
        });
    }
    if plies.is_empty() {
        return Err(reader.error(
            card.line,
            format!("PCOMP {number} has no plies"),
            "give them on the lines behind it",
        ));
    }
    if symmetric {
        let upper: Vec<Ply> = plies.iter().rev().cloned().collect();
        plies.extend(upper);
    }
    let height: f64 = plies.iter().map(|ply| ply.thickness).sum();
    // Z0 is the height of the bottom; round-off of the sum is no offset.
    let middle = bottom.map_or(0.0, |bottom| bottom + 0.5 * height);
    let offset = (middle.abs() > 1e-6 * height).then_some((middle, card.line));
    Ok(Property { layers: Layers::Plies(plies), offset })
}
