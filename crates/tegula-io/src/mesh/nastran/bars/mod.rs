//! Bars: `CBAR`, and in `frame` what they move with.

pub mod frame;

use std::collections::{BTreeMap, BTreeSet};

use tegula::Vec3;

use super::cards::Card;
use super::file::File;
use super::numbers;
use crate::mesh::MeshError;
use crate::mesh::numbered::bars::{self, Bar, End, Release};
use crate::mesh::numbered::{Parts, Reader, shown};

/// Nodes of all bars.
pub fn nodes(file: &File<'_>) -> BTreeSet<u64> {
    file.named("CBAR").flat_map(|card| [2, 3].map(|at| card.field(at).text.parse().ok())).flatten().collect()
}

/// Properties of all bars.
pub fn properties(file: &File<'_>) -> BTreeSet<u64> {
    let property = |card: &Card<'_>| {
        let text = card.field(1).text;
        if text.is_empty() { card.field(0).text.parse().ok() } else { text.parse().ok() }
    };
    file.named("CBAR").filter_map(property).collect()
}

/// Bars of a file.
///
/// # Errors
/// The first mistake of a card.
pub fn bars(reader: &Reader<'_>, file: &File<'_>, parts: &Parts) -> Result<Vec<Bar>, MeshError> {
    let mut out: Vec<Bar> = Vec::new();
    if file.named("CBAR").next().is_none() {
        return Ok(out);
    }
    let mut lines: BTreeMap<u64, usize> =
        parts.elements.iter().map(|element| (element.label, element.line)).collect();
    for card in file.named("CBAR") {
        let bar = bar(reader, card, parts)?;
        if let Some(earlier) = lines.insert(bar.label, bar.line) {
            let message = format!("element {} is defined again; line {earlier} does so, too", bar.label);
            return Err(reader.error(bar.line, message, "give each element a number of its own"));
        }
        out.push(bar);
    }
    Ok(out)
}

fn bar(reader: &Reader<'_>, card: &Card<'_>, parts: &Parts) -> Result<Bar, MeshError> {
    let label = card.id(reader, 0, "the number")?;
    let property = match card.field(1).text {
        "" => label,
        _ => card.id(reader, 1, "the property")?,
    };
    let nodes = [card.id(reader, 2, "the node GA")?, card.id(reader, 3, "the node GB")?];
    let [a, b] = nodes;
    let places = [place(reader, card, a, parts)?, place(reader, card, b, parts)?];
    let orientation = orientation(reader, card, places[0], parts)?;
    let system = card.field(7);
    if !(system.text.is_empty() || system.text.eq_ignore_ascii_case("GGG")) {
        return Err(reader.error(
            system.line,
            format!("OFFT of CBAR {label} is \"{}\", which is not read", shown(system.text)),
            "give the orientation vector and the offsets in the basic coordinate system, and leave the field blank",
        ));
    }
    let points = [
        places[0] + offset(reader, card, (label, 'A', a), parts)?,
        places[1] + offset(reader, card, (label, 'B', b), parts)?,
    ];
    card.only(reader, 16)?;
    let name = format!("CBAR {label}");
    if a == b {
        let message = format!("both ends of {name} are in one place");
        return Err(reader.error(card.line, message, "check its nodes"));
    }
    let help = "give a vector across the bar in X1, X2 and X3, or a node beside it in G0";
    let axes = bars::axes(reader, (card.line, &name), (points, orientation), help)?;
    let end = |k: usize| -> Result<End, MeshError> {
        let release = release(reader, card, (label, k), &axes)?;
        Ok(End { node: nodes[k], point: points[k], release })
    };
    let ends = [end(0)?, end(1)?];
    Ok(Bar { kind: "CBAR", label, property, ends, orientation, axes, line: card.line })
}

/// Place of a node that a card names.
fn place(reader: &Reader<'_>, card: &Card<'_>, node: u64, parts: &Parts) -> Result<Vec3, MeshError> {
    parts.nodes.get(&node).map(|(position, _)| *position).ok_or_else(|| {
        let message =
            format!("CBAR {} needs node {node}, which the file does not define", card.field(0).text);
        reader.error(card.line, message, "check the numbers of the card, or define the node")
    })
}

/// Orientation vector: its components, or the vector from GA to the node G0.
fn orientation(reader: &Reader<'_>, card: &Card<'_>, start: Vec3, parts: &Parts) -> Result<Vec3, MeshError> {
    if numbers::integer(card.field(4).text).is_some() {
        let node = card.id(reader, 4, "the node G0")?;
        for (at, name) in [(5, "X2"), (6, "X3")] {
            card.none(reader, at, name, "leave it blank where G0 is given")?;
        }
        return Ok(place(reader, card, node, parts)? - start);
    }
    let mut out = Vec3::zeros();
    for (i, (x, name)) in out.iter_mut().zip(["X1", "X2", "X3"]).enumerate() {
        *x = card.real(reader, 4 + i, name)?.unwrap_or(0.0);
    }
    Ok(out)
}

/// Offset of an end from its node.
fn offset(
    reader: &Reader<'_>,
    card: &Card<'_>,
    (label, end, node): (u64, char, u64),
    parts: &Parts,
) -> Result<Vec3, MeshError> {
    let first = if end == 'A' { 10 } else { 13 };
    let mut out = Vec3::zeros();
    for (i, x) in out.iter_mut().enumerate() {
        *x = card.real(reader, first + i, &format!("W{}{end}", i + 1))?.unwrap_or(0.0);
    }
    if out != Vec3::zeros() && !parts.used.contains(&node) {
        return Err(reader.error(
            card.line,
            format!("CBAR {label} has an offset W{end} at node {node}, which belongs to no shell"),
            "put the node on the axis of the bar, and leave the offset out: bars lie beside nodes of shells only",
        ));
    }
    Ok(out)
}

/// Pin flags of an end, as the motion that it does not share with its node.
fn release(
    reader: &Reader<'_>,
    card: &Card<'_>,
    (label, end): (u64, usize),
    axes: &[Vec3; 3],
) -> Result<Release, MeshError> {
    let field = card.field(8 + end);
    let digits: BTreeSet<char> = field.text.chars().collect();
    let digits: String = digits.into_iter().collect();
    match (digits.as_str(), axes) {
        ("" | "0", _) => Ok(Release::Nothing),
        ("456", _) => Ok(Release::Rotations),
        ("4", [axis, _, _]) | ("5", [_, axis, _]) | ("6", [_, _, axis]) => Ok(Release::Rotation(*axis)),
        _ => Err(reader.error(
            field.line,
            format!("P{} of CBAR {label} is \"{}\", which is not read", ['A', 'B'][end], shown(field.text)),
            "release one rotation, 4, 5 or 6, or all of them, 456",
        )),
    }
}
