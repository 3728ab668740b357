//! Beams: `B31` with the orientation and the shape of `*BEAM SECTION` and `*BEAM GENERAL SECTION`.

use std::collections::{BTreeMap, BTreeSet};

use tegula::Vec3;
use tegula::model::{BeamSection, BoxSection, CircularSection, RectangularSection};

use super::cards::{Card, Reader, label, shown};
use crate::mesh::MeshError;
use crate::mesh::numbered::bars::frame::{self, Frame};
use crate::mesh::numbered::bars::lines::Line;
use crate::mesh::numbered::bars::{self, Bar, End, Release};
use crate::mesh::numbered::{BarElement, Parts};

/// Keyword of a section whose material is given by name.
pub const SECTION: &str = "BEAM SECTION";
/// Keyword of a section that has its elastic constants.
pub const GENERAL: &str = "BEAM GENERAL SECTION";
/// Direction n1 of sections that give none.
const DEFAULT: Vec3 = Vec3::new(0.0, 0.0, -1.0);

/// Cards of the sections of beams.
pub fn sections<'c, 't>(cards: &'c [Card<'t>]) -> impl Iterator<Item = &'c Card<'t>> {
    cards.iter().filter(|card| matches!(card.keyword.as_str(), SECTION | GENERAL))
}

/// Name of the set of the nodes of a set that belong to shells and to no beam.
pub fn beside(set: &str) -> String {
    format!("{set} beside beams")
}

/// Adds the sets that supports and beams need. Mistakes of the beams are reported by the conversion.
pub fn sets(reader: &Reader<'_>, cards: &[Card<'_>], parts: &mut Parts) {
    if parts.bars.is_empty() {
        return;
    }
    let frame = frame(reader, cards, parts).unwrap_or_default();
    let mut out: BTreeMap<String, Vec<u64>> = frame.lines.iter().map(Line::set).zip(frame.attached).collect();
    for card in cards.iter().filter(|card| card.keyword == "BOUNDARY") {
        for field in card.data.iter().filter_map(|data| data.fields().next()) {
            let Some((name, members)) = parts.node_sets.get(field.trim_matches('"')) else { continue };
            let of_shells = members.iter().copied().filter(|node| parts.used.contains(node));
            let (of_beams, others): (Vec<u64>, Vec<u64>) =
                of_shells.partition(|node| parts.of_bars.contains(node));
            if !of_beams.is_empty() && label(field).is_none() {
                out.insert(beside(name), others);
            }
        }
    }
    for (name, members) in out.into_iter().filter(|(_, members)| !members.is_empty()) {
        if parts.node_sets.get(&name).is_none() {
            parts.node_sets.extend(&name, members);
        }
    }
}

/// Beams of a file, with the nodes of shells that move with them. The number of a property is the line of its section.
///
/// # Errors
/// The first mistake of an element or its section.
pub fn frame(reader: &Reader<'_>, cards: &[Card<'_>], parts: &Parts) -> Result<Frame, MeshError> {
    let mut of: BTreeMap<u64, (usize, Vec3)> = BTreeMap::new();
    for card in sections(cards) {
        let direction = direction(reader, card)?;
        for element in members(reader, card, parts)? {
            if let Some((earlier, _)) = of.insert(*element, (card.line, direction)) {
                let message = format!("the beam {element} has a section on line {earlier}, too");
                return Err(reader.error(card.line, message, "give each element one section"));
            }
        }
    }
    let found: Vec<Bar> =
        parts.bars.iter().map(|bar| oriented(reader, parts, bar, &of)).collect::<Result<_, _>>()?;
    frame::frame(reader, &found, (&BTreeMap::new(), &BTreeMap::new()), parts)
}

/// Elements of the set of a section.
fn members<'p>(
    reader: &Reader<'_>,
    card: &Card<'_>,
    parts: &'p Parts,
) -> Result<&'p BTreeSet<u64>, MeshError> {
    let name = reader.required(card, "ELSET")?;
    let Some((_, members)) = parts.element_sets.get(name) else {
        return Err(reader.error(
            card.line,
            format!("there is no element set \"{}\"", shown(name)),
            "check the name of the set",
        ));
    };
    match members.iter().find(|element| parts.bars.iter().all(|bar| bar.label != **element)) {
        None => Ok(members),
        Some(element) => Err(reader.error(
            card.line,
            format!("element {element} of the set \"{}\" is no beam", shown(name)),
            "give the section a set of elements of the type B31 alone",
        )),
    }
}

/// An element with its axes.
fn oriented(
    reader: &Reader<'_>,
    parts: &Parts,
    bar: &BarElement,
    sections: &BTreeMap<u64, (usize, Vec3)>,
) -> Result<Bar, MeshError> {
    let BarElement { label, nodes, beside, line } = *bar;
    let Some((property, direction)) = sections.get(&label).copied() else {
        return Err(reader.error(
            line,
            format!("the beam {label} has no section"),
            "give one with *BEAM SECTION or *BEAM GENERAL SECTION",
        ));
    };
    let place = |node: u64| parts.nodes.get(&node).map_or(Vec3::zeros(), |(position, _)| *position);
    let points = nodes.map(place);
    let orientation = beside.map_or(direction, |node| place(node) - points[0]);
    let name = format!("B31 {label}");
    let help = "give a direction n1 across the beam on the second line of its section, which is 0, 0, -1 where it is left out; beams along z need one";
    let axes = bars::axes(reader, (line, &name), (points, orientation), help)?;
    let end = |k: usize| End { node: nodes[k], point: points[k], release: Release::Nothing };
    let ends = [end(0), end(1)];
    Ok(Bar { kind: "B31", label, property: property as u64, ends, orientation, axes, line })
}

/// Direction n1 of a section: its second data line.
fn direction(reader: &Reader<'_>, card: &Card<'_>) -> Result<Vec3, MeshError> {
    let Some(data) = card.data.get(1) else { return Ok(DEFAULT) };
    let fields = data.list();
    if fields.len() > 3 {
        return Err(reader.error(
            data.line,
            format!("a direction has three components, and there are {}", fields.len()),
            "write the direction n1 of the cross-section on the second line",
        ));
    }
    let mut out = Vec3::zeros();
    for (x, field) in out.iter_mut().zip(fields) {
        *x = reader.number(data.line, field)?;
    }
    Ok(out)
}

/// Sizes of the first data line of a section, of which each must be above 0, and whose number must be among the `counts`.
///
/// # Errors
/// A size is missing, is no number or not above 0.
pub fn sizes(
    reader: &Reader<'_>,
    card: &Card<'_>,
    (counts, what): (&[usize], &str),
) -> Result<(Vec<f64>, usize), MeshError> {
    let Some(data) = card.data.first() else {
        return Err(reader.error(
            card.line,
            format!("*{} has no data line", card.keyword),
            format!("give {what} on the line behind it"),
        ));
    };
    let out: Vec<f64> =
        data.fields().map(|field| reader.number(data.line, field)).collect::<Result<_, _>>()?;
    if !counts.contains(&out.len()) {
        let message = format!("the section has {} values on its first line", out.len());
        return Err(reader.error(data.line, message, format!("give {what}")));
    }
    Ok((out, data.line))
}

/// Shape of a section; `None` for one whose constants are given.
///
/// # Errors
/// The shape is not read, or a size of it is wrong.
pub fn shape(reader: &Reader<'_>, card: &Card<'_>) -> Result<Option<BeamSection>, MeshError> {
    let kind = match card.keyword == GENERAL && !card.has("SECTION") {
        true => "GENERAL".to_owned(),
        false => reader.required(card, "SECTION")?.to_uppercase(),
    };
    let sizes = |counts: &[usize], what: &str| -> Result<(Vec<f64>, usize), MeshError> {
        let (out, line) = sizes(reader, card, (counts, what))?;
        match out.iter().find(|size| !(**size > 0.0)) {
            None => Ok((out, line)),
            Some(size) => {
                let message = format!("a size of the section {kind} is {size}");
                Err(reader.error(line, message, format!("give {what}, all above 0")))
            }
        }
    };
    let wrong = |line: usize, message: String, help: &str| Err(reader.error(line, message, help));
    match kind.as_str() {
        "RECT" => match sizes(&[2], "the sides along n1 and n2")?.0[..] {
            [a, b] => Ok(Some(BeamSection::Rectangle(RectangularSection { size: [a, b] }))),
            _ => Ok(None),
        },
        "CIRC" => match sizes(&[1, 2], "the radius, or both diameters as CalculiX has them")? {
            (of, line) if of.len() == 2 && of.first() != of.last() => wrong(
                line,
                format!("the section is an ellipse with the diameters {of:?}"),
                "give two equal diameters, or the constants of the section by *BEAM GENERAL SECTION",
            ),
            (of, _) => {
                let half = if of.len() == 2 { 0.5 } else { 1.0 };
                let radius = half * of.first().copied().unwrap_or_default();
                Ok(Some(BeamSection::Circle(CircularSection { radius, inner_radius: 0.0 })))
            }
        },
        "PIPE" => {
            let (of, line) = sizes(&[2], "the outer radius and the thickness of the wall")?;
            match of[..] {
                [radius, wall] if wall <= radius => {
                    let inner_radius = radius - wall;
                    Ok(Some(BeamSection::Circle(CircularSection { radius, inner_radius })))
                }
                _ => wrong(
                    line,
                    "the wall of the pipe is thicker than its radius".into(),
                    "give the outer radius and the thickness of the wall",
                ),
            }
        }
        "BOX" => {
            let what = "the sides along n1 and n2 and the thicknesses of the four walls";
            let (of, line) = sizes(&[6], what)?;
            match of[..] {
                [a, b, thickness, ref others @ ..]
                    if others.iter().all(|other| (other - thickness).abs() <= 1e-9 * thickness) =>
                {
                    Ok(Some(BeamSection::Box(BoxSection { size: [a, b], thickness })))
                }
                _ => wrong(
                    line,
                    format!(
                        "the walls of the box have the thicknesses {:?}",
                        of.get(2..).unwrap_or_default()
                    ),
                    "give the constants of the section by *BEAM GENERAL SECTION: a box has walls of one thickness",
                ),
            }
        }
        "GENERAL" => Ok(None),
        other => wrong(
            card.line,
            format!("the section {} of beams is not read", shown(other)),
            "give RECT, CIRC, PIPE or BOX, or the constants of the section by *BEAM GENERAL SECTION, SECTION=GENERAL",
        ),
    }
}
