//! Grid points and elements: `GRID` and `CQUAD4`.

use std::collections::BTreeSet;

use tegula::Vec3;

use super::angles::Properties;
use super::bars::{self, frame};
use super::cards::Card;
use super::file::File;
use super::rigid::{self, Body};
use super::{loads, supports};
use crate::mesh::MeshError;
use crate::mesh::numbered::bars::lines::Line;
use crate::mesh::numbered::{Element, MOST_PRINTED, Parts, Reader, shown};

/// Grid points and elements of a file, by their numbers.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Bulk {
    /// Nodes, elements and sets.
    pub parts: Parts,
    /// Property and angle of each element, in the order of `parts.elements`.
    pub shells: Vec<Shell>,
}

/// Property and axes of the material of a `CQUAD4`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shell {
    /// Number of its property.
    pub property: u64,
    /// Angle of the material from the side of its first two nodes (degrees).
    pub angle: f64,
    /// Coordinate system that gives the axes of the material in place of the angle; 0 for the basic one.
    pub system: Option<i64>,
}

/// Cards of the mesh that are not read, with the remedy.
const MESH: &[(&str, &str)] = &[
    ("CTRIA3", "mesh the surface with quadrilaterals, CQUAD4"),
    ("CTRIAR", "mesh the surface with quadrilaterals, CQUAD4"),
    ("CTRIA6", "mesh the surface with quadrilaterals, CQUAD4"),
    ("CQUAD8", "mesh the surface with quadrilaterals of four nodes, CQUAD4"),
    ("CQUADR", "write CQUAD4: there is no drilling rotation here"),
    ("CQUAD", "mesh the surface with quadrilaterals of four nodes, CQUAD4"),
    ("CSHEAR", "give the web as CQUAD4"),
    ("CHEXA", "only shells are read: mesh the middle surface with CQUAD4"),
    ("CPENTA", "only shells are read: mesh the middle surface with CQUAD4"),
    ("CPYRAM", "only shells are read: mesh the middle surface with CQUAD4"),
    ("CTETRA", "only shells are read: mesh the middle surface with CQUAD4"),
    ("GRDSET", "write the coordinate systems and constraints of each GRID on it"),
];

/// Cards that are not read as a part of a model, with the remedy; where the file is a mesh alone, the model file has their counterparts.
const MODEL: &[(&str, &str)] = &[
    ("CBEAM", "give CBAR with PBAR, or beams in the model file that `tegula convert` writes of the rest"),
    ("CROD", "give beams or springs in the model file that `tegula convert` writes of the rest"),
    ("CONROD", "give beams or springs in the model file that `tegula convert` writes of the rest"),
    ("CBUSH", "give `[[bushings]]` in the model file that `tegula convert` writes of the rest"),
    ("CELAS1", "give `[[springs]]` in the model file that `tegula convert` writes of the rest"),
    ("CELAS2", "give `[[springs]]` in the model file that `tegula convert` writes of the rest"),
    ("CONM2", "give `[[masses]]` in the model file that `tegula convert` writes of the rest"),
    ("RBAR", "give an RBE2"),
    ("RBE1", "give an RBE2"),
    ("MPC", "equations between degrees of freedom are not read"),
];

/// Whether a card is refused by a message of its own.
pub fn is_refused(name: &str) -> bool {
    MESH.iter().chain(MODEL).any(|(other, _)| *other == name)
}

/// Error of the first card of a model that has no counterpart in the conversion.
pub fn refused(reader: &Reader<'_>, file: &File<'_>) -> Option<MeshError> {
    first(reader, file, MODEL)
}

/// Error of the first card of a list.
fn first(reader: &Reader<'_>, file: &File<'_>, list: &[(&str, &str)]) -> Option<MeshError> {
    file.cards.iter().find_map(|card| {
        let (name, help) = list.iter().find(|(name, _)| *name == card.name)?;
        Some(reader.error(card.line, format!("{name} is not read"), *help))
    })
}

/// Name of the set of the elements of a property.
pub fn property_set(property: u64) -> String {
    format!("property {property}")
}

/// Reads grid points and elements, and makes the sets that the other cards need. Their mistakes are reported by the conversion.
///
/// # Errors
/// The first mistake of a node or an element.
pub fn bulk(reader: &Reader<'_>, file: &File<'_>) -> Result<Bulk, MeshError> {
    if let Some(error) = first(reader, file, MESH) {
        return Err(error);
    }
    let mut bulk = Bulk::default();
    for card in file.named("GRID") {
        node(reader, card, &mut bulk.parts)?;
    }
    for card in file.named("CQUAD4") {
        element(reader, card, &mut bulk)?;
    }
    bulk.parts.check_elements(reader)?;
    for (element, shell) in bulk.parts.elements.iter().zip(&bulk.shells) {
        bulk.parts.element_sets.extend(&property_set(shell.property), [element.label]);
    }
    sets(reader, file, &mut bulk);
    Ok(bulk)
}

/// Sets of supports, loads, rigid elements, requests, and of the elements with one direction of the material.
fn sets(reader: &Reader<'_>, file: &File<'_>, bulk: &mut Bulk) {
    let mut nodes: Vec<(String, Vec<u64>)> = Vec::new();
    let mut elements: Vec<(String, Vec<u64>)> = Vec::new();
    if let Ok(found) = rigid::bodies(reader, file, &bulk.parts) {
        nodes.extend(found.iter().flat_map(Body::sets));
    }
    for found in [supports::on_nodes, supports::supports] {
        let found = found(reader, file, &bulk.parts).unwrap_or_default();
        nodes.extend(found.into_iter().map(|support| (support.target.name, support.target.nodes)));
    }
    let frame = frame::frame(reader, file, &bulk.parts).unwrap_or_default();
    nodes.extend(frame.lines.iter().map(Line::set).zip(frame.attached));
    nodes.extend(frame.hinged.into_iter().map(|node| (node.to_string(), vec![node])));
    for found in loads::nodal(reader, file, &bulk.parts).unwrap_or_default() {
        if !found.body {
            nodes.push((found.name, found.nodes));
        }
    }
    let pressures = loads::pressures(reader, file, &bulk.parts).unwrap_or_default();
    elements.extend(pressures.into_iter().map(|found| (found.name, found.elements)));
    let properties = Properties::new(file, bulk);
    for property in properties.numbers() {
        let groups = properties.groups(reader, bulk, property).unwrap_or_default();
        elements.extend(groups.into_iter().map(|group| (group.name, group.elements)));
    }
    for (_, printed) in printed(file, &bulk.parts) {
        let of_shells = printed.into_iter().filter(|node| bulk.parts.used.contains(node));
        nodes.extend(of_shells.map(|node| (node.to_string(), vec![node])));
    }
    for (name, members) in nodes {
        if bulk.parts.node_sets.get(&name).is_none() {
            bulk.parts.node_sets.extend(&name, members);
        }
    }
    for (name, members) in elements {
        if bulk.parts.element_sets.get(&name).is_none() {
            bulk.parts.element_sets.extend(&name, members);
        }
    }
}

/// Nodes of shells and bars whose displacements the case control asks for by a set of few of them, each with the line of the request.
pub fn printed(file: &File<'_>, parts: &Parts) -> Vec<(usize, Vec<u64>)> {
    let mut out: Vec<(usize, Vec<u64>)> = Vec::new();
    let mut taken = BTreeSet::new();
    let of_bars = bars::nodes(file);
    for command in &file.case {
        if !is_displacement(&command.name) {
            continue;
        }
        let listed = file.case.iter().filter(|other| other.name == "SET").find_map(|set| {
            let (number, members) = set.value.split_once('=')?;
            let own = number.trim().eq_ignore_ascii_case(command.value.trim());
            own.then(|| members.split(',').map(|m| m.trim().parse().ok()).collect::<Option<Vec<u64>>>())?
        });
        let Some(nodes) = listed.filter(|nodes| nodes.len() <= MOST_PRINTED) else { continue };
        if nodes.iter().all(|node| parts.used.contains(node) || of_bars.contains(node)) {
            out.push((command.line, nodes.into_iter().filter(|node| taken.insert(*node)).collect()));
        }
    }
    out
}

/// Whether a command asks for displacements.
fn is_displacement(name: &str) -> bool {
    name == "VECTOR" || (name.len() >= 4 && "DISPLACEMENT".starts_with(name))
}

fn node(reader: &Reader<'_>, card: &Card<'_>, parts: &mut Parts) -> Result<(), MeshError> {
    let label = card.id(reader, 0, "the number")?;
    let global =
        "give coordinates, supports and loads in the basic coordinate system, without CORD2R and the like";
    card.zero(reader, 1, &format!("the coordinate system CP of node {label}"), global)?;
    let mut position = Vec3::zeros();
    for (axis, x) in position.iter_mut().enumerate() {
        *x = card.real(reader, 2 + axis, "a coordinate")?.unwrap_or(0.0);
    }
    card.zero(reader, 5, &format!("the coordinate system CD of node {label}"), global)?;
    card.none(reader, 7, "the superelement", "give a model without superelements")?;
    card.only(reader, 8)?;
    match parts.nodes.insert(label, (position, card.line)) {
        None => Ok(()),
        Some((_, earlier)) => Err(reader.error(
            card.line,
            format!("node {label} is defined again; line {earlier} does so, too"),
            "give each node once",
        )),
    }
}

fn element(reader: &Reader<'_>, card: &Card<'_>, bulk: &mut Bulk) -> Result<(), MeshError> {
    let label = card.id(reader, 0, "the number")?;
    let property = match card.field(1).text {
        "" => label,
        _ => card.id(reader, 1, "the property")?,
    };
    let mut nodes = [0; 4];
    for (corner, node) in nodes.iter_mut().enumerate() {
        *node = card.id(reader, 2 + corner, "a node")?;
    }
    let angle = card.field(6);
    let system = super::numbers::integer(angle.text);
    let theta = if system.is_some() { 0.0 } else { card.real(reader, 6, "the angle THETA")?.unwrap_or(0.0) };
    card.none(
        reader,
        7,
        "the offset ZOFFS",
        "give `offset` of a `layup` in the model file that `tegula convert` writes",
    )?;
    let same = "give sections of different thicknesses, or `thickness_distribution`, a formula of the place";
    card.none(reader, 9, "TFLAG", same)?;
    for corner in 0..4 {
        let field = card.field(10 + corner);
        if !field.text.is_empty() {
            let message = format!(
                "the thickness T{} of element {label} is {}, which is not read",
                corner + 1,
                shown(field.text)
            );
            return Err(reader.error(field.line, message, same));
        }
    }
    if let Some(field) =
        [8].into_iter().map(|i| card.field(i)).chain(card.fields_from(14)).find(|f| !f.text.is_empty())
    {
        let message = format!("CQUAD4 has a further value \"{}\", which is not read", shown(field.text));
        return Err(reader.error(field.line, message, "remove it, or check the columns of the card"));
    }
    bulk.parts.elements.push(Element { label, nodes, line: card.line });
    bulk.shells.push(Shell { property, angle: theta, system });
    Ok(())
}
