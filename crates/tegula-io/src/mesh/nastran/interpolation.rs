//! Interpolation elements: `RBE3`.

use std::collections::BTreeSet;

use super::cards::Card;
use super::file::File;
use super::numbers;
use super::rigid::Body;
use crate::mesh::MeshError;
use crate::mesh::numbered::{Parts, Reader, shown};

/// Weight of nodes, the components that take part, and the nodes.
struct Group {
    weight: f64,
    components: String,
    nodes: Vec<u64>,
}

/// Bodies of the interpolation elements of a file.
///
/// # Errors
/// A card is incomplete, has components that are not read, or names unknown nodes.
pub fn bodies(reader: &Reader<'_>, file: &File<'_>, parts: &Parts) -> Result<Vec<Body>, MeshError> {
    file.named("RBE3").map(|card| body(reader, card, parts)).collect()
}

fn body(reader: &Reader<'_>, card: &Card<'_>, parts: &Parts) -> Result<Body, MeshError> {
    let label = card.id(reader, 0, "the number")?;
    card.none(reader, 1, "field 3", "leave it blank")?;
    let node = card.id(reader, 2, "the reference node")?;
    let components = card.field(3);
    let translations_alone = match sorted(components.text).as_str() {
        "123" => true,
        "123456" => false,
        _ => {
            return Err(reader.error(
                components.line,
                format!("REFC of RBE3 {label} is \"{}\", which is not read", shown(components.text)),
                "write 123456, or 123: a body follows the mean motion in all directions",
            ));
        }
    };
    let place = parts.nodes.get(&node).map(|(position, _)| *position);
    let Some(place) = place.filter(|_| !parts.used.contains(&node)) else {
        let message = match place {
            Some(_) => format!("the reference node {node} of RBE3 {label} belongs to a shell"),
            None => format!("RBE3 {label} needs node {node}, which the file does not define"),
        };
        return Err(reader.error(card.line, message, "give a node of its own as the reference node"));
    };
    let found = groups(reader, card, label)?;
    for group in &found {
        let missing = group.nodes.iter().find(|of| !parts.used.contains(of));
        if let Some(of) = missing {
            let message = match parts.nodes.contains_key(of) {
                true => format!("node {of} of RBE3 {label} belongs to no shell"),
                false => format!("RBE3 {label} needs node {of}, which the file does not define"),
            };
            return Err(reader.error(card.line, message, "name nodes of shells"));
        }
    }
    Ok(Body {
        name: format!("RBE3 {label}"),
        node,
        nodes: Vec::new(),
        of_bars: Vec::new(),
        rotations: found.iter().any(|group| group.components == "123456"),
        weighted: found.into_iter().map(|group| (group.weight, group.nodes)).collect(),
        translations_alone,
        at: place.into(),
        line: card.line,
    })
}

/// Digits of components in ascending order.
fn sorted(text: &str) -> String {
    text.chars().collect::<BTreeSet<char>>().into_iter().collect()
}

/// Groups of nodes with their weights. A real number begins a group.
fn groups(reader: &Reader<'_>, card: &Card<'_>, label: u64) -> Result<Vec<Group>, MeshError> {
    let mut out: Vec<Group> = Vec::new();
    let mut at = 4;
    while at < card.count() {
        let field = card.field(at);
        at += 1;
        if field.text.is_empty() {
            continue;
        }
        if let Some(weight) = numbers::real(field.text) {
            if !(weight > 0.0) {
                let message = format!("a weight of RBE3 {label} is {weight}");
                return Err(reader.error(
                    field.line,
                    message,
                    "give weights above 0, or leave the nodes out",
                ));
            }
            let components = card.field(at);
            at += 1;
            let digits = sorted(components.text);
            if !matches!(digits.as_str(), "123" | "123456") {
                return Err(reader.error(
                    components.line,
                    format!("C of RBE3 {label} is \"{}\", which is not read", shown(components.text)),
                    "write 123: nodes take part with all displacements",
                ));
            }
            out.push(Group { weight, components: digits, nodes: Vec::new() });
            continue;
        }
        if field.text.bytes().all(|b| b.is_ascii_alphabetic()) {
            let name = field.text.to_uppercase();
            let help = match name.as_str() {
                "UM" => "leave UM out: the reference node depends on the others",
                "ALPHA" => "leave ALPHA out: there are no temperatures",
                _ => "list nodes by their numbers",
            };
            return Err(reader.error(
                field.line,
                format!("{} of RBE3 {label} is not read", shown(&name)),
                help,
            ));
        }
        let node = card.id(reader, at - 1, "a node")?;
        match out.last_mut() {
            Some(group) => group.nodes.push(node),
            None => return Err(card.missing(reader, 4, "the weight WT1")),
        }
    }
    match out.iter().find(|group| group.nodes.is_empty()) {
        None if !out.is_empty() => Ok(out),
        Some(group) => Err(reader.error(
            card.line,
            format!("the weight {} of RBE3 {label} has no nodes", group.weight),
            "list its nodes behind the components",
        )),
        None => Err(card.missing(reader, 4, "the weight WT1")),
    }
}
