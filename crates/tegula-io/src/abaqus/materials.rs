//! `*MATERIAL` with `*ELASTIC`, `*DENSITY` and `*EXPANSION`.

use std::collections::HashMap;

use crate::conversion::document::Document;
use crate::conversion::materials::{Elastic, Material};
use crate::mesh::MeshError;
use crate::mesh::abaqus::cards::{Card, Reader, shown};

/// Materials of an input file in its order.
#[derive(Debug, Default)]
pub(super) struct Materials {
    list: Vec<Material>,
    index: HashMap<String, usize>,
}

impl Materials {
    /// Reads the materials of the cards.
    ///
    /// # Errors
    /// The first mistake.
    pub fn read(reader: &Reader<'_>, cards: &[Card<'_>]) -> Result<Self, MeshError> {
        let mut materials = Self::default();
        for card in cards {
            match card.keyword.as_str() {
                "MATERIAL" => materials.begin(reader, card)?,
                "ELASTIC" => {
                    let elastic = elastic(reader, card)?;
                    let of = &mut materials.current(reader, card)?.elastic;
                    once(reader, card, of, elastic)?;
                }
                "DENSITY" => {
                    reader.only(card, &[])?;
                    let [density] = constants(reader, card, "the density")?;
                    once(reader, card, &mut materials.current(reader, card)?.density, density)?;
                }
                "EXPANSION" => {
                    let expansion = expansion(reader, card)?;
                    once(reader, card, &mut materials.current(reader, card)?.expansion, expansion)?;
                }
                _ => {}
            }
        }
        for material in &materials.list {
            check(material, reader)?;
        }
        Ok(materials)
    }

    /// Spelling of the name of a material where it is defined.
    pub fn spelling(&self, name: &str) -> Option<&str> {
        let material = self.list.get(*self.index.get(&name.to_uppercase())?)?;
        Some(&material.name)
    }

    /// Whether a material is isotropic.
    pub fn is_isotropic(&self, name: &str) -> bool {
        let material = self.index.get(&name.to_uppercase()).and_then(|at| self.list.get(*at));
        material.is_some_and(|of| matches!(of.elastic, Some((_, Elastic::Isotropic(_)))))
    }

    /// Writes the tables of the materials.
    pub fn write(&self, out: &mut Document) {
        for material in &self.list {
            material.write(out);
        }
    }

    fn begin(&mut self, reader: &Reader<'_>, card: &Card<'_>) -> Result<(), MeshError> {
        reader.only(card, &["NAME"])?;
        let name = reader.required(card, "NAME")?;
        if self.index.insert(name.to_uppercase(), self.list.len()).is_some() {
            return Err(reader.error(
                card.line,
                format!("the material {} is defined twice", shown(name)),
                "keep one of them",
            ));
        }
        self.list.push(Material {
            name: name.to_owned(),
            card: "*MATERIAL",
            line: card.line,
            elastic: None,
            density: None,
            expansion: None,
        });
        Ok(())
    }

    fn current(&mut self, reader: &Reader<'_>, card: &Card<'_>) -> Result<&mut Material, MeshError> {
        self.list.last_mut().filter(|material| material.line < card.line).ok_or_else(|| {
            reader.error(
                card.line,
                format!("*{} stands before any *MATERIAL", card.keyword),
                "put it behind the material that it belongs to",
            )
        })
    }
}

/// Refuses a material without *ELASTIC, and expansions without directions.
fn check(material: &Material, reader: &Reader<'_>) -> Result<(), MeshError> {
    let Some((_, elastic)) = &material.elastic else {
        return Err(reader.error(
            material.line,
            format!("the material {} has no *ELASTIC", shown(&material.name)),
            "only linear elastic materials are read; give others in a model file",
        ));
    };
    match (elastic, &material.expansion) {
        (Elastic::Isotropic(_), Some((line, values))) if values.len() > 1 => Err(reader.error(
            *line,
            "an isotropic material has one thermal expansion",
            "write *EXPANSION without TYPE=ORTHO and with one number",
        )),
        _ => Ok(()),
    }
}

/// Sets a property that a material has once.
fn once<T>(
    reader: &Reader<'_>,
    card: &Card<'_>,
    of: &mut Option<(usize, T)>,
    value: T,
) -> Result<(), MeshError> {
    match of.replace((card.line, value)) {
        None => Ok(()),
        Some((earlier, _)) => Err(reader.error(
            card.line,
            format!("the material has *{} twice; the other one is on line {earlier}", card.keyword),
            "keep one of them",
        )),
    }
}

fn elastic(reader: &Reader<'_>, card: &Card<'_>) -> Result<Elastic, MeshError> {
    reader.only(card, &["TYPE", "MODULI"])?;
    let moduli = card.parameter("MODULI").unwrap_or("LONG TERM");
    let kind = card.parameter("TYPE").unwrap_or("ISOTROPIC").to_uppercase();
    match kind.as_str() {
        _ if !moduli.eq_ignore_ascii_case("LONG TERM") => {
            Err(reader.error(card.line, "instantaneous moduli are not read", "give the long-term ones"))
        }
        "ISOTROPIC" | "ISO" => {
            Ok(Elastic::Isotropic(constants(reader, card, "Young's modulus and Poisson's ratio")?))
        }
        "ENGINEERING CONSTANTS" => {
            Ok(Elastic::Orthotropic(constants(reader, card, "E1, E2, E3, ν12, ν13, ν23, G12, G13 and G23")?))
        }
        "LAMINA" => {
            let [e1, e2, nu12, g12, g13, g23] = constants(reader, card, "E1, E2, ν12, G12, G13 and G23")?;
            // Plane stress does not depend on E3, ν13 and ν23; these values are admissible wherever the others are.
            Ok(Elastic::Orthotropic([e1, e2, e2, nu12, 0.0, 0.0, g12, g13, g23]))
        }
        other => Err(reader.error(
            card.line,
            format!("*ELASTIC of the type {} is not read", shown(other)),
            "give TYPE=ISOTROPIC, ENGINEERING CONSTANTS or LAMINA",
        )),
    }
}

fn expansion(reader: &Reader<'_>, card: &Card<'_>) -> Result<Vec<f64>, MeshError> {
    reader.only(card, &["TYPE", "ZERO"])?;
    match card.parameter("TYPE").unwrap_or("ISO").to_uppercase().as_str() {
        "ISO" => Ok(constants::<1>(reader, card, "the thermal expansion")?.to_vec()),
        "ORTHO" => Ok(constants::<3>(reader, card, "three thermal expansions")?.to_vec()),
        other => Err(reader.error(
            card.line,
            format!("*EXPANSION of the type {} is not read", shown(other)),
            "give TYPE=ISO or TYPE=ORTHO",
        )),
    }
}

/// Constants of a material that do not depend on the temperature, over as many lines as they take; `what` names them in the help.
fn constants<const N: usize>(
    reader: &Reader<'_>,
    card: &Card<'_>,
    what: &str,
) -> Result<[f64; N], MeshError> {
    let fields: Vec<(usize, &str)> = card.fields().collect();
    let (given, rest) = fields.split_at(N.min(fields.len()));
    if given.len() < N || given.iter().any(|(_, field)| field.is_empty()) {
        let line = given.last().map_or(card.line, |(line, _)| *line);
        return Err(reader.error(
            line,
            format!("*{} needs {N} numbers, and there are {}", card.keyword, given.len()),
            format!("give {what}"),
        ));
    }
    if let Some((line, field)) = rest.iter().find(|(_, field)| !field.is_empty()) {
        return Err(reader.error(
            *line,
            format!("*{} has a further value \"{}\"", card.keyword, shown(field)),
            format!("give {what} once: constants do not depend on the temperature here"),
        ));
    }
    let mut out = [0.0; N];
    for (x, (line, field)) in out.iter_mut().zip(given) {
        *x = reader.number(*line, field)?;
    }
    Ok(out)
}
