//! Rigid elements, `RBE2`, and interpolation elements, `RBE3`: the bodies that they are.

use super::cards::Card;
use super::file::File;
use super::{bars, interpolation};
use crate::mesh::MeshError;
use crate::mesh::numbered::{Parts, Reader, shown};

/// A rigid element or an interpolation element.
#[derive(Debug, Clone, PartialEq)]
pub struct Body {
    /// Name of the body.
    pub name: String,
    /// Independent node, or reference node, which gives the place of the body.
    pub node: u64,
    /// Nodes of elements that it holds; the independent one where it belongs to an element.
    pub nodes: Vec<u64>,
    /// Nodes of bars that it holds, and that belong to no shell.
    pub of_bars: Vec<u64>,
    /// Nodes whose mean motion it follows, by their weights.
    pub weighted: Vec<(f64, Vec<u64>)>,
    /// Whether rotations of these nodes are to take part.
    pub rotations: bool,
    /// Whether the reference node follows displacements alone.
    pub translations_alone: bool,
    /// Position of the independent node.
    pub at: [f64; 3],
    /// Line of the card.
    pub line: usize,
}

impl Body {
    /// Name of the set of its nodes.
    pub fn set(&self) -> String {
        format!("nodes of {}", self.name)
    }

    /// Card that it comes from.
    pub fn card(&self) -> &'static str {
        if self.weighted.is_empty() { "RBE2" } else { "RBE3" }
    }

    /// Names of the sets of the nodes that it follows, with weights and nodes.
    pub fn weighted_sets(&self) -> impl Iterator<Item = (String, f64, &[u64])> {
        let name = |i: usize| match self.weighted.len() {
            1 => self.set(),
            _ => format!("{} no {}", self.set(), i + 1),
        };
        self.weighted.iter().enumerate().map(move |(i, (weight, nodes))| (name(i), *weight, &nodes[..]))
    }

    /// Error of what needs the rotations of a reference node that has none.
    pub fn no_rotations(&self, reader: &Reader<'_>, line: usize, what: &str) -> MeshError {
        reader.error(
            line,
            format!("{what} node {}, which follows displacements alone by REFC of {}", self.node, self.name),
            "write 123456 in REFC",
        )
    }

    /// Names and nodes of all sets that it needs.
    pub fn sets(&self) -> Vec<(String, Vec<u64>)> {
        let weighted = self.weighted_sets().map(|(name, _, nodes)| (name, nodes.to_vec()));
        if self.weighted.is_empty() { vec![(self.set(), self.nodes.clone())] } else { weighted.collect() }
    }

    /// All nodes that it holds, and the independent one.
    pub fn held(&self) -> impl Iterator<Item = u64> {
        [self.node].into_iter().chain(self.nodes.iter().copied()).chain(self.of_bars.iter().copied())
    }
}

/// Bodies of the rigid elements and the interpolation elements of a file.
///
/// # Errors
/// A card is incomplete, has components that are not read, or names unknown nodes.
pub fn bodies(reader: &Reader<'_>, file: &File<'_>, parts: &Parts) -> Result<Vec<Body>, MeshError> {
    let mut out = rigid(reader, file, parts)?;
    for body in interpolation::bodies(reader, file, parts)? {
        if let Some(other) = out.iter().find(|other| other.node == body.node || other.name == body.name) {
            return Err(reader.error(
                body.line,
                format!(
                    "{} has the same number or the same node as {} on line {}",
                    body.name, other.name, other.line
                ),
                "give each its own number and its own reference node",
            ));
        }
        out.push(body);
    }
    Ok(out)
}

/// The card of a rigid element without a thermal expansion, a real number at its end.
///
/// # Errors
/// It is not zero.
fn without_expansion<'t>(reader: &Reader<'_>, card: &Card<'t>) -> Result<Card<'t>, MeshError> {
    let last = card.field(card.count().saturating_sub(1));
    match super::numbers::real(last.text) {
        None => Ok(card.clone()),
        Some(0.0) => Ok(card.without_last()),
        Some(_) => Err(reader.error(
            last.line,
            "the thermal expansion of RBE2 is not read",
            "leave it out: there are no temperatures",
        )),
    }
}

/// Bodies of rigid elements.
fn rigid(reader: &Reader<'_>, file: &File<'_>, parts: &Parts) -> Result<Vec<Body>, MeshError> {
    let known = parts.nodes.keys().copied().collect();
    let of_bars = bars::nodes(file);
    let mut out: Vec<Body> = Vec::new();
    for card in file.named("RBE2") {
        let label = card.id(reader, 0, "the number")?;
        let node = card.id(reader, 1, "the independent node")?;
        let components = card.field(2);
        if components.text != "123456" {
            return Err(reader.error(
                components.line,
                format!("RBE2 holds the degrees of freedom \"{}\"", shown(components.text)),
                "write 123456: a rigid patch holds its nodes with their normals",
            ));
        }
        let mut nodes = without_expansion(reader, card)?.list(reader, 3, "a dependent node", &known)?;
        for &of in nodes.iter().chain([&node]) {
            let held = of == node || parts.used.contains(&of) || of_bars.contains(&of);
            if !parts.nodes.contains_key(&of) || !held {
                let message = match parts.nodes.contains_key(&of) {
                    true => format!("node {of} of RBE2 {label} belongs to no element"),
                    false => format!("RBE2 {label} needs node {of}, which the file does not define"),
                };
                return Err(reader.error(card.line, message, "check the numbers of the card"));
            }
        }
        if let Some(other) =
            out.iter().find(|other| other.node == node || other.name == format!("RBE2 {label}"))
        {
            return Err(reader.error(
                card.line,
                format!(
                    "RBE2 {label} has the same number or the same independent node as the RBE2 on line {}",
                    other.line
                ),
                "join the two into one",
            ));
        }
        if parts.used.contains(&node) {
            nodes.push(node);
        }
        nodes.sort_unstable();
        nodes.dedup();
        let (nodes, of_bars): (Vec<u64>, Vec<u64>) =
            nodes.into_iter().partition(|of| parts.used.contains(of));
        if nodes.is_empty() {
            let message = format!("RBE2 {label} holds nodes of bars alone, and no node of a shell");
            let help =
                "let the bars share a node, or connect their nodes by a stiff CBAR, in place of the RBE2";
            return Err(reader.error(card.line, message, help));
        }
        let at = parts.nodes.get(&node).map_or([0.0; 3], |(position, _)| (*position).into());
        out.push(Body {
            name: format!("RBE2 {label}"),
            node,
            nodes,
            of_bars,
            weighted: Vec::new(),
            rotations: false,
            translations_alone: false,
            at,
            line: card.line,
        });
    }
    Ok(out)
}
