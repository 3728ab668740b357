//! Nodes and elements that supports and loads act on.

use std::collections::BTreeSet;

use crate::mesh::MeshError;
use crate::mesh::abaqus::cards::{Reader, label, shown};
use crate::mesh::numbered::Parts;
use crate::mesh::numbered::normals::Target;

/// Nodes of a data line by number or name of a set. With `all` every node must belong to an element, as a load on another one would be
/// lost.
///
/// # Errors
/// There is no such node or set, or its nodes belong to no elements.
pub(super) fn nodes(
    reader: &Reader<'_>,
    parts: &Parts,
    (line, field): (usize, &str),
    all: bool,
) -> Result<Target, MeshError> {
    let lost = |node: u64| {
        reader.error(
            line,
            format!("node {node} belongs to no element"),
            "remove it from this card and its set, or check the elements",
        )
    };
    if let Some(node) = label(field) {
        return match (parts.nodes.contains_key(&node), parts.has(node)) {
            (_, true) => Ok(Target { name: node.to_string(), nodes: vec![node] }),
            (true, false) => Err(lost(node)),
            (false, false) => Err(reader.error(
                line,
                format!("the file has no node {node}"),
                "check the number of the node",
            )),
        };
    }
    let field = field.trim_matches('"');
    let Some((name, members)) = parts.node_sets.get(field) else {
        let element_set = parts.element_sets.get(field).is_some();
        return Err(reader.error(
            line,
            format!("there is no node set \"{}\"", shown(field)),
            match element_set {
                true => "this is an element set: make a node set of it with *NSET, NSET=NAME, ELSET=NAME",
                false => "check the name of the set",
            },
        ));
    };
    if let Some(node) = parts.node_sets.repeated(name).filter(|_| all) {
        return Err(twice(reader, (line, name), format!("node {node}")));
    }
    let (used, orphans): (Vec<u64>, Vec<u64>) = members.iter().partition(|node| parts.has(**node));
    match orphans.first() {
        Some(&node) if all || used.is_empty() => Err(lost(node)),
        None if used.is_empty() => {
            Err(reader.error(line, format!("the node set \"{}\" is empty", shown(name)), "check the set"))
        }
        _ => Ok(Target { name: name.to_owned(), nodes: used }),
    }
}

/// Error of a member that a set has twice.
fn twice(reader: &Reader<'_>, (line, set): (usize, &str), member: String) -> MeshError {
    reader.error(
        line,
        format!("the set \"{}\" lists {member} twice", shown(set)),
        "programs differ in whether it has a load once or twice: list it once, or load its sets one by one",
    )
}

/// Name and numbers of the elements of a data line, by number or name of a set.
///
/// # Errors
/// There is no such element or set.
pub(super) fn elements(
    reader: &Reader<'_>,
    parts: &Parts,
    (line, field): (usize, &str),
) -> Result<(String, BTreeSet<u64>), MeshError> {
    if let Some(element) = label(field) {
        if parts.single_elements.contains(&element) {
            return Ok((element.to_string(), BTreeSet::from([element])));
        }
        return Err(reader.error(line, format!("the file has no element {element}"), "check the number"));
    }
    let field = field.trim_matches('"');
    if let Some(element) = parts.element_sets.repeated(field) {
        return Err(twice(reader, (line, field), format!("element {element}")));
    }
    match parts.element_sets.get(field) {
        Some((name, members)) if !members.is_empty() => Ok((name.to_owned(), members.clone())),
        _ => Err(reader.error(
            line,
            format!("there is no element set \"{}\"", shown(field)),
            "check the name of the set",
        )),
    }
}
