//! `MAT1` and `MAT8`.

use std::collections::BTreeMap;

use super::notes::Notes;
use crate::conversion::materials::{Elastic, Material};
use crate::mesh::MeshError;
use crate::mesh::nastran::cards::Card;
use crate::mesh::nastran::file::File;
use crate::mesh::numbered::Reader;

/// Part by which E, G and ν of an isotropic material may differ from E = 2 (1 + ν) G.
const CONSISTENT: f64 = 1e-3;

/// Name of a material in the model file.
pub(super) fn name(material: u64) -> String {
    format!("material {material}")
}

/// Materials by their numbers.
///
/// # Errors
/// The first mistake of a card.
pub(super) fn materials(
    reader: &Reader<'_>,
    file: &File<'_>,
    notes: &mut Notes,
) -> Result<BTreeMap<u64, Material>, MeshError> {
    let mut out: BTreeMap<u64, Material> = BTreeMap::new();
    for card in &file.cards {
        let material = match card.name.as_str() {
            "MAT1" => isotropic(reader, card, notes)?,
            "MAT8" => orthotropic(reader, card, notes)?,
            _ => continue,
        };
        if let Some(earlier) = out.insert(card.id(reader, 0, "the number")?, material) {
            return Err(reader.error(
                card.line,
                format!(
                    "the material {} is defined again; line {} does so, too",
                    card.field(0).text,
                    earlier.line
                ),
                "give each material a number of its own",
            ));
        }
    }
    Ok(out)
}

fn isotropic(reader: &Reader<'_>, card: &Card<'_>, notes: &mut Notes) -> Result<Material, MeshError> {
    let number = card.id(reader, 0, "the number")?;
    let young = card.real(reader, 1, "E")?;
    let shear = card.real(reader, 2, "G")?;
    let poisson = card.real(reader, 3, "NU")?;
    let constants = match (young, shear, poisson) {
        (Some(e), Some(g), Some(nu)) => {
            let from = 2.0 * (1.0 + nu) * g;
            if (e - from).abs() > CONSISTENT * e.abs() {
                return Err(reader.error(
                    card.line,
                    format!("E is {e}, but 2 (1 + NU) G is {from}: the material is not isotropic"),
                    "leave G blank, or give a MAT8",
                ));
            }
            [e, nu]
        }
        (Some(e), None, Some(nu)) => [e, nu],
        (Some(e), Some(g), None) => [e, e / (2.0 * g) - 1.0],
        (None, Some(g), Some(nu)) => [2.0 * (1.0 + nu) * g, nu],
        _ => {
            return Err(reader.error(
                card.line,
                "MAT1 has fewer than two of E, G and NU",
                "give two of them",
            ));
        }
    };
    let density = card.real(reader, 4, "RHO")?;
    let expansion = card.real(reader, 5, "A")?;
    notes.fields(card, &[(6, "TREF"), (7, "GE"), (8, "ST"), (9, "SC"), (10, "SS")]);
    card.none(reader, 11, "MCSID", "leave it out")?;
    card.only(reader, 12)?;
    Ok(material(card, number, Elastic::Isotropic(constants), density, expansion.map(|a| vec![a])))
}

fn orthotropic(reader: &Reader<'_>, card: &Card<'_>, notes: &mut Notes) -> Result<Material, MeshError> {
    let number = card.id(reader, 0, "the number")?;
    let e1 = card.required(reader, 1, "E1")?;
    let e2 = card.required(reader, 2, "E2")?;
    let nu12 = card.required(reader, 3, "NU12")?;
    let g12 = card.required(reader, 4, "G12")?;
    let transverse = |index: usize, what: &str| -> Result<f64, MeshError> {
        card.real(reader, index, what)?.filter(|g| *g != 0.0).ok_or_else(|| {
            reader.error(
                card.line,
                format!("{what} of MAT8 {number} is blank or 0, which stands for rigid transverse shear"),
                "give the transverse shear moduli G1Z and G2Z, which the shells need; for thin shells G12 will do",
            )
        })
    };
    let (g1z, g2z) = (transverse(5, "G1Z")?, transverse(6, "G2Z")?);
    let density = card.real(reader, 7, "RHO")?;
    let a1 = card.real(reader, 8, "A1")?;
    let a2 = card.real(reader, 9, "A2")?;
    let names = ["TREF", "Xt", "Xc", "Yt", "Yc", "S", "GE", "F12", "STRN"];
    let fields: Vec<(usize, &str)> = (10..).zip(names).collect();
    notes.fields(card, &fields);
    card.only(reader, 19)?;
    let expansion = (a1.is_some() || a2.is_some()).then(|| {
        let (a1, a2) = (a1.unwrap_or(0.0), a2.unwrap_or(0.0));
        vec![a1, a2, a2]
    });
    // Plane stress does not depend on E3, ν13 and ν23; these values are admissible wherever the others are.
    let constants = [e1, e2, e2, nu12, 0.0, 0.0, g12, g1z, g2z];
    Ok(material(card, number, Elastic::Orthotropic(constants), density, expansion))
}

fn material(
    card: &Card<'_>,
    number: u64,
    elastic: Elastic,
    density: Option<f64>,
    expansion: Option<Vec<f64>>,
) -> Material {
    let line = card.line;
    Material {
        name: name(number),
        card: if card.name == "MAT1" { "MAT1" } else { "MAT8" },
        line,
        elastic: Some((line, elastic)),
        density: density.map(|density| (line, density)),
        expansion: expansion.map(|expansion| (line, expansion)),
    }
}
