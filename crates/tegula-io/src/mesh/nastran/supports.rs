//! Supports: `SPC`, `SPC1`, `SPCADD`, and the permanent constraints of `GRID`.
//!
//! The constraints of each node are taken together. Nodes with the same ones, and with normals along the same axes where these decide, are
//! one support.

use std::collections::{BTreeMap, BTreeSet};

use super::bars::{self, frame};
use super::cards::Field;
use super::file::File;
use super::rigid;
use crate::mesh::MeshError;
use crate::mesh::numbered::normals::{Directions, Normals, Target};
use crate::mesh::numbered::{Parts, Reader, shown};

/// Values of the degrees of freedom 1 to 6, each with its line.
pub type Values = [Option<(f64, usize)>; 6];

/// A support of nodes of elements, or of the body of a rigid element.
#[derive(Debug, Clone, PartialEq)]
pub struct Support {
    /// Name of the set, or of the body, and the nodes.
    pub target: Target,
    /// Line on which it stands first.
    pub line: usize,
    /// Card of that line.
    pub card: &'static str,
    /// Constraints.
    pub values: Values,
    /// Position of the node of a body.
    pub body: Option<[f64; 3]>,
}

/// Constraints of one node.
#[derive(Debug, Clone, Copy)]
struct Node {
    line: usize,
    card: &'static str,
    values: Values,
}

/// Supports of the set that the case control selects, and permanent ones. Those of nodes that move with bodies or bars are supports of these.
///
/// # Errors
/// The first mistake of a card.
pub fn supports(reader: &Reader<'_>, file: &File<'_>, parts: &Parts) -> Result<Vec<Support>, MeshError> {
    let carriers = frame::frame(reader, file, parts).unwrap_or_default().carriers;
    let position = |node: u64| parts.nodes.get(&node).map(|(position, _)| (*position).into());
    let carried = |support: &Support, node: u64, name: &str| Support {
        target: Target { name: name.to_owned(), nodes: Vec::new() },
        body: position(node),
        ..support.clone()
    };
    let mut out = Vec::new();
    for mut support in on_nodes(reader, file, parts)? {
        let with_bars = |node: &u64| carriers.contains_key(node);
        if support.body.is_some() || !support.target.nodes.iter().any(with_bars) {
            out.push(support);
            continue;
        }
        let (of_bars, others): (Vec<u64>, Vec<u64>) = support.target.nodes.iter().partition(|n| with_bars(n));
        let names = of_bars.iter().filter_map(|node| Some((*node, carriers.get(node)?)));
        out.extend(names.map(|(node, name)| carried(&support, node, name)));
        if !others.is_empty() {
            let name = format!("{} beside bars", support.target.name);
            support.target = Target { name, nodes: others };
            out.push(support);
        }
    }
    for (node, Node { line, card, values }) in constrained(reader, file, parts)? {
        if let Some(name) = carriers.get(&node).filter(|_| !parts.used.contains(&node)) {
            let target = Target { name: name.clone(), nodes: Vec::new() };
            out.push(Support { target, line, card, values, body: position(node) });
        }
    }
    out.sort_by_key(|support| support.line);
    Ok(out)
}

/// Supports of nodes of shells and of the bodies of rigid elements, as if there were no bars.
///
/// # Errors
/// The first mistake of a card.
pub fn on_nodes(reader: &Reader<'_>, file: &File<'_>, parts: &Parts) -> Result<Vec<Support>, MeshError> {
    let nodes = constrained(reader, file, parts)?;
    let bodies = rigid::bodies(reader, file, parts)?;
    let mut of_bodies: BTreeMap<u64, &rigid::Body> = BTreeMap::new();
    for body in &bodies {
        if let Some((node, found)) =
            body.nodes.iter().chain(&body.of_bars).find_map(|node| Some((node, nodes.get(node)?)))
        {
            return Err(reader.error(
                found.line,
                format!("node {node} is supported, and {} of line {} holds it", body.name, body.line),
                "support the independent node of the RBE2, and let it belong to no element",
            ));
        }
        of_bodies.insert(body.node, body);
    }
    let normals = Normals::new(parts);
    let mut out: Vec<Support> = Vec::new();
    let mut groups: BTreeMap<(String, Option<[bool; 6]>), usize> = BTreeMap::new();
    for (node, Node { line, card, values }) in nodes {
        if let Some(body) = of_bodies.get(&node) {
            if let Some((_, line)) =
                values.iter().skip(3).flatten().next().filter(|_| body.translations_alone)
            {
                return Err(body.no_rotations(reader, *line, "a rotation is supported of"));
            }
            let target = Target { name: body.name.clone(), nodes: Vec::new() };
            out.push(Support { target, line, card, values, body: Some(body.at) });
            continue;
        }
        if !parts.used.contains(&node) {
            continue;
        }
        let key = values.map(|value| value.map(|(value, _)| value.to_bits()));
        let rotations = values.iter().skip(3).filter(|value| value.is_some()).count();
        let all = values.iter().all(Option::is_some);
        let decides = (rotations > 0 && !all).then(|| bits(normals.common(&[node])));
        let at = *groups.entry((format!("{key:?}"), decides)).or_insert(out.len());
        if at == out.len() {
            out.push(Support {
                target: Target { name: String::new(), nodes: Vec::new() },
                line,
                card,
                values,
                body: None,
            });
        }
        if let Some(support) = out.get_mut(at) {
            support.target.nodes.push(node);
        }
    }
    out.sort_by_key(|support| support.line);
    name(&mut out);
    Ok(out)
}

/// Degrees of freedom that are fixed, by the numbers of the nodes.
///
/// # Errors
/// The first mistake of a card.
pub fn held(
    reader: &Reader<'_>,
    file: &File<'_>,
    parts: &Parts,
) -> Result<BTreeMap<u64, [bool; 6]>, MeshError> {
    let fixed = |value: Option<(f64, usize)>| value.is_some_and(|(value, _)| value == 0.0);
    let nodes = constrained(reader, file, parts)?.into_iter();
    Ok(nodes.map(|(node, found)| (node, found.values.map(fixed))).collect())
}

/// Supported nodes that belong to no shell or bar and are the independent node of no rigid element, with the lines of their supports.
///
/// # Errors
/// The first mistake of a card.
pub fn without_effect(
    reader: &Reader<'_>,
    file: &File<'_>,
    parts: &Parts,
) -> Result<Vec<(u64, usize)>, MeshError> {
    let mut bodies = bars::nodes(file);
    bodies.extend(rigid::bodies(reader, file, parts)?.into_iter().map(|body| body.node));
    let nodes = constrained(reader, file, parts)?.into_iter();
    let dropped = nodes.filter(|(node, _)| !parts.used.contains(node) && !bodies.contains(node));
    Ok(dropped.map(|(node, found)| (node, found.line)).collect())
}

fn bits(directions: Directions) -> [bool; 6] {
    let ([a, b, c], [d, e, f]) = (directions.along, directions.across);
    [a, b, c, d, e, f]
}

/// Names supports after their degrees of freedom, with a number where several have the same ones.
fn name(supports: &mut [Support]) {
    let mut taken: BTreeMap<String, usize> = BTreeMap::new();
    for support in supports.iter_mut().filter(|support| support.body.is_none()) {
        let digits = (1..).zip(&support.values).filter(|(_, value)| value.is_some());
        let digits: String = digits.map(|(digit, _): (u32, _)| digit.to_string()).collect();
        let count = taken.entry(digits.clone()).or_insert(0);
        *count += 1;
        support.target.name =
            if *count == 1 { format!("SPC {digits}") } else { format!("SPC {digits} no {count}") };
    }
}

/// Constraints of all nodes.
fn constrained(
    reader: &Reader<'_>,
    file: &File<'_>,
    parts: &Parts,
) -> Result<BTreeMap<u64, Node>, MeshError> {
    let mut out = BTreeMap::new();
    for card in file.named("GRID") {
        let field = card.field(6);
        if !field.text.is_empty() && field.text != "0" {
            let node = card.id(reader, 0, "the number")?;
            add(reader, (&mut out, parts), (node, "GRID"), field, 0.0)?;
        }
    }
    let Some((set, command)) = file.support_set() else { return Ok(out) };
    let selected = selected(reader, file, set)?;
    let known: BTreeSet<u64> = parts.nodes.keys().copied().collect();
    let mut any = BTreeSet::new();
    for card in file.cards.iter().filter(|card| matches!(card.name.as_str(), "SPC" | "SPC1")) {
        let own = card.id(reader, 0, "the set")?;
        if !selected.contains_key(&own) {
            continue;
        }
        any.insert(own);
        if card.name == "SPC1" {
            for node in card.list(reader, 2, "a node", &known)? {
                add(reader, (&mut out, parts), (node, "SPC1"), card.field(1), 0.0)?;
            }
            continue;
        }
        card.only(reader, 7)?;
        for at in [1, 4].into_iter().filter(|&at| at == 1 || !card.field(at).text.is_empty()) {
            let node = card.id(reader, at, "a node")?;
            let value = card.real(reader, at + 2, "the displacement")?.unwrap_or(0.0);
            add(reader, (&mut out, parts), (node, "SPC"), card.field(at + 1), value)?;
        }
    }
    if any.is_empty() {
        let message = format!("there is no SPC or SPC1 of the set {set}");
        return Err(reader.error(command, message, "check the number of the set"));
    }
    match selected.iter().find(|(own, line)| **line > 0 && !any.contains(own)) {
        None => Ok(out),
        Some((own, line)) => Err(reader.error(
            *line,
            format!("SPCADD {set} names the set {own}, of which there is no SPC or SPC1"),
            "check the number of the set",
        )),
    }
}

/// Numbers of the sets that a set stands for, with the lines of `SPCADD` that name them; 0 for the set itself.
///
/// # Errors
/// A number of `SPCADD` is none.
pub fn selected(reader: &Reader<'_>, file: &File<'_>, set: u64) -> Result<BTreeMap<u64, usize>, MeshError> {
    let mut out = BTreeMap::from([(set, 0)]);
    for card in file.named("SPCADD") {
        if card.id(reader, 0, "the set")? == set {
            for at in (1..card.count()).filter(|&at| !card.field(at).text.is_empty()) {
                out.entry(card.id(reader, at, "a set")?).or_insert(card.field(at).line);
            }
        }
    }
    Ok(out)
}

/// Adds the constraints of the components `field` of a node.
fn add(
    reader: &Reader<'_>,
    (out, parts): (&mut BTreeMap<u64, Node>, &Parts),
    (node, card): (u64, &'static str),
    field: Field<'_>,
    value: f64,
) -> Result<(), MeshError> {
    if !parts.nodes.contains_key(&node) {
        return Err(reader.error(
            field.line,
            format!("the file has no node {node}"),
            "check the number of the node",
        ));
    }
    for digit in components(reader, field)? {
        let of = out.entry(node).or_insert(Node { line: field.line, card, values: [None; 6] });
        let Some(slot) = of.values.get_mut(digit - 1) else { continue };
        if let Some((earlier, line)) = slot.filter(|(earlier, _)| *earlier != value) {
            return Err(reader.error(
                field.line,
                format!(
                    "degree of freedom {digit} of node {node} gets {value}, and {earlier} on line {line}"
                ),
                "give it one value",
            ));
        }
        slot.get_or_insert((value, field.line));
    }
    Ok(())
}

/// Degrees of freedom of a field of digits.
fn components(reader: &Reader<'_>, field: Field<'_>) -> Result<Vec<usize>, MeshError> {
    let digits: Option<Vec<usize>> = field
        .text
        .chars()
        .map(|c| c.to_digit(10).filter(|d| (1..=6).contains(d)).map(|d| d as usize))
        .collect();
    digits.filter(|digits| !digits.is_empty()).ok_or_else(|| {
        reader.error(
            field.line,
            format!("\"{}\" is not a list of degrees of freedom", shown(field.text)),
            "write digits from 1 to 6 without blanks, such as 123456",
        )
    })
}
