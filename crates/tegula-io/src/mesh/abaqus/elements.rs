//! `*ELEMENT`: shells, beams and continuum shells.

use super::cards::{Card, DataLine, Reader, shown};
use super::solids::Solid;
use crate::mesh::MeshError;
use crate::mesh::numbered::{BarElement, Element, Parts};

/// Kind of element that is read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    /// Shell of four nodes.
    Shell,
    /// Beam of two nodes, and perhaps a third one that orients it.
    Beam,
    /// Continuum shell of eight nodes.
    ContinuumShell,
}

impl Kind {
    /// Number of nodes.
    fn nodes(self) -> usize {
        match self {
            Self::Shell => 4,
            Self::Beam => 2,
            Self::ContinuumShell => 8,
        }
    }

    /// Nodes of such an element in messages.
    fn told(self) -> &'static str {
        match self {
            Self::Shell => "a quadrilateral has 4",
            Self::Beam => "a B31 has 2, and perhaps one beside its axis",
            Self::ContinuumShell => "an SC8R has 8",
        }
    }
}

/// Adds the elements of a card to `parts`; those of eight nodes go to `solids`.
///
/// # Errors
/// The type is not read, or the first mistake of an element.
pub fn read(
    reader: &Reader<'_>,
    card: &Card<'_>,
    parts: &mut Parts,
    solids: &mut Vec<Solid>,
) -> Result<(), MeshError> {
    reader.only(card, &["TYPE", "ELSET"])?;
    let kind = kind(reader, card)?;
    let mut labels = Vec::new();
    let mut pending: Vec<(usize, &str)> = Vec::new();
    let mut add = |data: DataLine<'_>, fields: &[(usize, &str)]| -> Result<(), MeshError> {
        let (label, line, nodes) = numbers(reader, data, fields, kind)?;
        labels.push(label);
        match (kind, &nodes[..]) {
            (Kind::Shell, &[a, b, c, d]) => {
                parts.elements.push(Element { label, nodes: [a, b, c, d], line });
            }
            (Kind::Beam, &[a, b, ref beside @ ..]) => {
                let beside = beside.first().copied();
                parts.bars.push(BarElement { label, nodes: [a, b], beside, line });
            }
            (_, &[a, b, c, d, e, f, g, h]) => {
                solids.push(Solid { label, bottom: [a, b, c, d], top: [e, f, g, h], line });
            }
            _ => {}
        }
        Ok(())
    };
    for data in &card.data {
        pending.extend(data.fields().filter(|field| !field.is_empty()).map(|field| (data.line, field)));
        // The list of nodes continues on the next line behind a comma.
        if data.text.ends_with(',') && pending.len() <= kind.nodes() {
            continue;
        }
        add(*data, &pending)?;
        pending.clear();
    }
    if let (Some(data), false) = (card.data.last(), pending.is_empty()) {
        add(*data, &pending)?;
    }
    if let Some(name) = reader.set_name(card, "ELSET")? {
        parts.element_sets.extend(name, labels);
    }
    Ok(())
}

/// Kind of the elements of a card.
fn kind(reader: &Reader<'_>, card: &Card<'_>) -> Result<Kind, MeshError> {
    let name = reader.required(card, "TYPE")?.to_uppercase();
    let help = match name.as_str() {
        "S4" | "S4R" => return Ok(Kind::Shell),
        "B31" => return Ok(Kind::Beam),
        "SC8R" => return Ok(Kind::ContinuumShell),
        "S3" | "S3R" | "STRI3" | "STRI65" | "S6" | "SC6R" => {
            "mesh the surface with quadrilaterals of four nodes, S4"
        }
        "S8R" | "S8R5" | "S8" | "S9R5" => {
            "save the mesh in first order as S4, with about twice as many elements along each side"
        }
        "S4R5" | "S4RS" | "S4RSW" => "write TYPE=S4; there are no hourglass modes here",
        "B32" | "B32R" | "B33" | "B31H" | "B31R" | "B31OS" | "T3D2" => {
            "write beams of two nodes, TYPE=B31, or give `[[beams]]` in the model file"
        }
        _ => {
            "shells S4, continuum shells SC8R and beams B31 are read: mesh the middle surface with S4, and give bodies in the model file"
        }
    };
    Err(reader.error(card.line, format!("elements of type {} are not read", shown(&name)), help))
}

/// Number, line and nodes of the fields of one data line and its continuations.
fn numbers(
    reader: &Reader<'_>,
    data: DataLine<'_>,
    fields: &[(usize, &str)],
    kind: Kind,
) -> Result<(u64, usize, Vec<u64>), MeshError> {
    let [(line, first), nodes @ ..] = fields else {
        return Err(reader.error(
            data.line,
            "the line holds no element",
            format!("write its number and its {} nodes", kind.nodes()),
        ));
    };
    let element = reader.label(*line, first, "an element")?;
    let more = nodes.len().saturating_sub(kind.nodes());
    if nodes.len() < kind.nodes() || more > usize::from(kind == Kind::Beam) {
        return Err(reader.error(
            data.line,
            format!("element {element} has {} nodes, and {}", nodes.len(), kind.told()),
            format!("write the number of the element and those of its {} nodes", kind.nodes()),
        ));
    }
    let corners = nodes.iter().map(|(line, field)| reader.label(*line, field, "a node"));
    Ok((element, *line, corners.collect::<Result<_, _>>()?))
}
