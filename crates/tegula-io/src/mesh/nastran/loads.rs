//! Loads of each load set: `FORCE`, `MOMENT`, `PLOAD2` and `PLOAD4`.
//!
//! Loads of one set on the same node or element add up. Nodes with the same sum are one load on a set.

use std::collections::BTreeMap;

use super::bars::frame;
use super::cards::Card;
use super::file::File;
use super::rigid;
use crate::mesh::MeshError;
use crate::mesh::numbered::{Parts, Reader, shown};

/// Force or moment on every node of a set.
#[derive(Debug, Clone, PartialEq)]
pub struct Nodal {
    /// Load set.
    pub set: u64,
    /// Card: `FORCE` or `MOMENT`.
    pub card: &'static str,
    /// Name of the set of nodes, or of a body.
    pub name: String,
    /// The nodes.
    pub nodes: Vec<u64>,
    /// Whether it acts on a cross-section of bars, or on the body of a rigid element, whose node belongs to no shell.
    pub body: bool,
    /// Components.
    pub value: [f64; 3],
    /// Line of the first card.
    pub line: usize,
}

/// Pressure on elements, along their normals.
#[derive(Debug, Clone, PartialEq)]
pub struct Pressure {
    /// Load set.
    pub set: u64,
    /// Card: `PLOAD2` or `PLOAD4`.
    pub card: &'static str,
    /// Name of the set of elements.
    pub name: String,
    /// The elements.
    pub elements: Vec<u64>,
    /// Pressure.
    pub value: f64,
    /// Line of the first card.
    pub line: usize,
}

/// Forces and moments of all load sets.
///
/// # Errors
/// The first mistake of a card.
pub fn nodal(reader: &Reader<'_>, file: &File<'_>, parts: &Parts) -> Result<Vec<Nodal>, MeshError> {
    let mut sums: BTreeMap<(u64, &'static str, u64), ([f64; 3], usize)> = BTreeMap::new();
    for card in &file.cards {
        let kind = match card.name.as_str() {
            "FORCE" => "FORCE",
            "MOMENT" => "MOMENT",
            _ => continue,
        };
        let set = card.id(reader, 0, "the load set")?;
        let node = card.id(reader, 1, "the node")?;
        card.none(reader, 2, "the coordinate system", "give its components in the basic coordinate system")?;
        let size = card.required(reader, 3, "the scale factor")?;
        let direction = components(reader, card, 4)?;
        card.only(reader, 7)?;
        let (sum, _) = sums.entry((set, kind, node)).or_insert(([0.0; 3], card.line));
        for (total, along) in sum.iter_mut().zip(direction) {
            *total += size * along;
        }
    }
    let bodies = rigid::bodies(reader, file, parts)?;
    let carriers = frame::frame(reader, file, parts).unwrap_or_default().carriers;
    let mut out: Vec<Nodal> = Vec::new();
    let mut index: BTreeMap<(u64, &str, [u64; 3]), usize> = BTreeMap::new();
    for ((set, card, node), (value, line)) in sums {
        if value == [0.0; 3] {
            continue;
        }
        let follows = bodies.iter().find(|body| body.node == node && body.translations_alone);
        if let Some(body) = follows.filter(|_| card == "MOMENT") {
            return Err(body.no_rotations(reader, line, "a moment acts on"));
        }
        let of_body = bodies.iter().find(|body| body.node == node).map(|body| &body.name);
        let of = of_body.or_else(|| carriers.get(&node)).filter(|_| !parts.used.contains(&node));
        if let Some(name) = of {
            let name = name.clone();
            out.push(Nodal { set, card, name, nodes: Vec::new(), body: true, value, line });
            continue;
        }
        if !parts.used.contains(&node) {
            let message = match parts.nodes.contains_key(&node) {
                true => format!("node {node} belongs to no shell, and to no bar that is not released there"),
                false => format!("the file has no node {node}"),
            };
            return Err(reader.error(
                line,
                message,
                "load nodes of shells or of bars that are not released there, or the independent node of an RBE2",
            ));
        }
        // A zero of either sign is the same value.
        let at = *index.entry((set, card, value.map(|x| (x + 0.0).to_bits()))).or_insert(out.len());
        if at == out.len() {
            out.push(Nodal { set, card, name: String::new(), nodes: Vec::new(), body: false, value, line });
        }
        if let Some(load) = out.get_mut(at) {
            load.nodes.push(node);
            load.line = load.line.min(line);
        }
    }
    let mut names = Names::default();
    for load in out.iter_mut().filter(|load| !load.body) {
        load.name = names.name(load.card, load.set, &load.nodes);
    }
    Ok(out)
}

/// Pressures of all load sets.
///
/// # Errors
/// The first mistake of a card.
pub fn pressures(reader: &Reader<'_>, file: &File<'_>, parts: &Parts) -> Result<Vec<Pressure>, MeshError> {
    let known = parts.elements.iter().map(|element| element.label).collect();
    let mut sums: BTreeMap<(u64, u64), (f64, &'static str, usize)> = BTreeMap::new();
    for card in &file.cards {
        let (kind, value, elements) = match card.name.as_str() {
            "PLOAD2" => (
                "PLOAD2",
                card.required(reader, 1, "the pressure")?,
                card.list(reader, 2, "an element", &known)?,
            ),
            "PLOAD4" => ("PLOAD4", uniform(reader, card)?, pload4(reader, card, &known)?),
            _ => continue,
        };
        let set = card.id(reader, 0, "the load set")?;
        for element in elements {
            if !known.contains(&element) {
                let message = format!("the file has no element {element}");
                return Err(reader.error(card.line, message, "check the number of the element"));
            }
            sums.entry((set, element)).or_insert((0.0, kind, card.line)).0 += value;
        }
    }
    let mut out: Vec<Pressure> = Vec::new();
    let mut index: BTreeMap<(u64, u64), usize> = BTreeMap::new();
    for ((set, element), (value, card, line)) in sums {
        if value == 0.0 {
            continue;
        }
        let at = *index.entry((set, value.to_bits())).or_insert(out.len());
        if at == out.len() {
            out.push(Pressure { set, card, name: String::new(), elements: Vec::new(), value, line });
        }
        if let Some(load) = out.get_mut(at) {
            load.elements.push(element);
            load.line = load.line.min(line);
        }
    }
    let mut names = Names::default();
    for load in &mut out {
        load.name = names.name("pressure", load.set, &load.elements);
    }
    Ok(out)
}

/// Names of sets: the number of a single member, else the kind and the load set, with a further number from the second on.
#[derive(Default)]
struct Names(BTreeMap<(&'static str, u64), usize>);

impl Names {
    fn name(&mut self, kind: &'static str, set: u64, members: &[u64]) -> String {
        if let [single] = members {
            return single.to_string();
        }
        let count = self.0.entry((kind, set)).or_insert(0);
        *count += 1;
        if *count == 1 { format!("{kind} {set}") } else { format!("{kind} {set} no {count}") }
    }
}

/// Three components of a vector from a field on; blank ones are 0.
///
/// # Errors
/// A field is no real number.
pub fn components(reader: &Reader<'_>, card: &Card<'_>, index: usize) -> Result<[f64; 3], MeshError> {
    let mut out = [0.0; 3];
    for (axis, x) in out.iter_mut().enumerate() {
        *x = card.real(reader, index + axis, "a component")?.unwrap_or(0.0);
    }
    Ok(out)
}

/// Pressure of a `PLOAD4`, which must be the same at all corners and act along the normal.
fn uniform(reader: &Reader<'_>, card: &Card<'_>) -> Result<f64, MeshError> {
    let value = card.required(reader, 2, "the pressure")?;
    for corner in 1..4 {
        if let Some(other) = card.real(reader, 2 + corner, "the pressure")?.filter(|other| *other != value) {
            return Err(reader.error(
                card.field(2 + corner).line,
                format!("the pressure at corner {} is {other}, and {value} at the first one", corner + 1),
                "give each element one pressure",
            ));
        }
    }
    match card.fields_from(8).find(|field| !field.text.is_empty()) {
        None => Ok(value),
        Some(field) => Err(reader.error(
            field.line,
            format!("\"{}\" of PLOAD4 is not read: pressures act along the normal", shown(field.text)),
            "give a load with a direction as `traction` in the model file that `tegula convert` writes",
        )),
    }
}

/// Elements of a `PLOAD4`.
fn pload4(
    reader: &Reader<'_>,
    card: &Card<'_>,
    known: &std::collections::BTreeSet<u64>,
) -> Result<Vec<u64>, MeshError> {
    let first = card.id(reader, 1, "the element")?;
    let word = card.field(6);
    if word.text.is_empty() && card.field(7).text.is_empty() {
        return Ok(vec![first]);
    }
    let last = match word.text.eq_ignore_ascii_case("THRU") {
        true => card.id(reader, 7, "the last element")?,
        false => 0,
    };
    if last < first {
        return Err(reader.error(
            word.line,
            format!("the fields 8 and 9 of PLOAD4 hold \"{}\"", shown(word.text)),
            "write THRU and the last element, or leave them blank; corners of solids are not read",
        ));
    }
    let found: Vec<u64> = known.range(first..=last).copied().collect();
    if found.is_empty() {
        return Err(reader.error(
            word.line,
            format!("the file has no element from {first} to {last}"),
            "check the numbers of the elements",
        ));
    }
    Ok(found)
}
