//! Nodes, elements and sets of an input file, by their numbers in it.

use std::collections::BTreeSet;

use tegula::Vec3;

use super::cards::{Card, DataLine, Reader, label, shown};
use super::sets::{ELEMENTS, NODES};
use super::solids::Solid;
use super::{beams, elements, solids};
use crate::mesh::MeshError;
use crate::mesh::numbered::{MOST_PRINTED, Parts};

/// Cards that a mesh cannot be read with: beginning of the keyword, reason, remedy.
const REFUSED: &[(&[&str], &str, &str)] = &[
    (
        &["PART", "END PART", "ASSEMBLY", "END ASSEMBLY", "INSTANCE", "END INSTANCE"],
        "files of parts and instances are not read",
        "write a flat input file: in Abaqus/CAE `Do not use parts and assemblies in input files` in the attributes of the model",
    ),
    (&["INCLUDE"], "other files are not included", "put the text of that file in the place of the card"),
    (
        &["NGEN", "NFILL", "NCOPY", "NMAP", "ELGEN", "ELCOPY", "SYSTEM"],
        "nodes and elements are not generated or transformed",
        "list them with *NODE and *ELEMENT, in global coordinates",
    ),
    (
        &["CONTACT", "SURFACE INTERACTION", "SURFACE BEHAVIOR", "FRICTION", "CLEARANCE"],
        "there is no contact",
        "remove the contact cards; stops of joints bound the motion of bodies",
    ),
    (
        &[
            "TIE",
            "MPC",
            "EQUATION",
            "COUPLING",
            "KINEMATIC",
            "DISTRIBUTING",
            "RIGID BODY",
            "EMBEDDED ELEMENT",
        ],
        "couplings of nodes are not read",
        "remove the card, and give bodies, joints or ties in the model file",
    ),
    (
        &["TRANSFORM"],
        "nodal coordinate systems are not read",
        "give supports and loads along the global axes",
    ),
];

/// Reads nodes, elements and sets of the cards.
///
/// # Errors
/// The first mistake, or the first card or element that cannot be read.
pub fn parts(reader: &Reader<'_>, cards: &[Card<'_>]) -> Result<Parts, MeshError> {
    for card in cards {
        refuse(reader, card)?;
    }
    let (mut parts, mut solids) = (Parts::default(), Vec::new());
    for card in cards.iter().filter(|card| card.keyword == "NODE") {
        parts.read_nodes(reader, card)?;
    }
    for card in cards.iter().filter(|card| card.keyword == "ELEMENT") {
        elements::read(reader, card, &mut parts, &mut solids)?;
    }
    solids::middle(reader, &mut parts, &solids)?;
    parts.check_elements(reader)?;
    let nodes: BTreeSet<u64> = parts.nodes.keys().copied().collect();
    let elements = parts.labels();
    for card in cards {
        match card.keyword.as_str() {
            "NSET" if card.has("ELSET") => parts.nodes_of_elements(reader, card, &solids)?,
            "NSET" => parts.node_sets.add(reader, card, NODES, &nodes)?,
            "ELSET" => parts.element_sets.add(reader, card, ELEMENTS, &elements)?,
            _ => {}
        }
    }
    parts.single_sets(cards, &elements);
    beams::sets(reader, cards, &mut parts);
    Ok(parts)
}

/// Whether a card is one without which the mesh would be another one.
pub fn is_refused(keyword: &str) -> bool {
    refusal(keyword).is_some()
}

fn refusal(keyword: &str) -> Option<(&'static str, &'static str)> {
    let begins = |word: &&str| {
        keyword.strip_prefix(*word).is_some_and(|rest| rest.is_empty() || rest.starts_with(' '))
    };
    // Requests for results of contacts do not change anything.
    let request = keyword.ends_with(" PRINT") || keyword.ends_with(" FILE") || keyword.ends_with(" OUTPUT");
    let found = REFUSED.iter().find(|(words, _, _)| !request && words.iter().any(begins))?;
    Some((found.1, found.2))
}

fn refuse(reader: &Reader<'_>, card: &Card<'_>) -> Result<(), MeshError> {
    match refusal(&card.keyword) {
        Some((reason, help)) => {
            Err(reader.error(card.line, format!("*{}: {reason}", shown(&card.keyword)), help))
        }
        None => Ok(()),
    }
}

impl Parts {
    fn read_nodes(&mut self, reader: &Reader<'_>, card: &Card<'_>) -> Result<(), MeshError> {
        reader.only(card, &["NSET", "SYSTEM"])?;
        if card.parameter("SYSTEM").is_some_and(|system| !system.eq_ignore_ascii_case("R")) {
            return Err(reader.error(
                card.line,
                "coordinates of a cylindrical or spherical system are not read",
                "give rectangular coordinates",
            ));
        }
        let mut labels = Vec::new();
        for data in &card.data {
            let mut fields = data.fields();
            let label = reader.label(data.line, fields.next().unwrap_or_default(), "a node")?;
            let mut coordinates = [0.0; 3];
            for (x, field) in coordinates.iter_mut().zip(&mut fields) {
                *x = reader.number(data.line, field)?;
            }
            let position = Vec3::from(coordinates);
            if fields.any(|field| !field.is_empty()) {
                return Err(reader.error(
                    data.line,
                    format!("node {label} has more than three coordinates"),
                    "remove the direction cosines of its normal: normals are those of the elements",
                ));
            }
            if let Some((_, earlier)) = self.nodes.insert(label, (position, data.line)) {
                return Err(reader.error(
                    data.line,
                    format!("node {label} is defined again; line {earlier} does so, too"),
                    "give each node once",
                ));
            }
            labels.push(label);
        }
        if let Some(name) = reader.set_name(card, "NSET")? {
            self.node_sets.extend(name, labels);
        }
        Ok(())
    }

    /// `*NSET, ELSET=`: the nodes of the elements of a set.
    fn nodes_of_elements(
        &mut self,
        reader: &Reader<'_>,
        card: &Card<'_>,
        solids: &[Solid],
    ) -> Result<(), MeshError> {
        reader.only(card, &["NSET", "ELSET"])?;
        reader.set_name(card, "NSET")?;
        let (name, of) = (reader.required(card, "NSET")?, reader.required(card, "ELSET")?);
        let Some((_, members)) = self.element_sets.get(of) else {
            return Err(reader.error(
                card.line,
                format!("there is no element set \"{}\" above", shown(of)),
                "check the name, or define the set before",
            ));
        };
        let inside = self.elements.iter().filter(|element| members.contains(&element.label));
        let mut nodes: BTreeSet<u64> = inside.flat_map(|element| element.nodes).collect();
        nodes
            .extend(solids.iter().filter(|solid| members.contains(&solid.label)).flat_map(|solid| solid.top));
        nodes.extend(self.bars.iter().filter(|bar| members.contains(&bar.label)).flat_map(|bar| bar.nodes));
        self.node_sets.extend(name, nodes);
        Ok(())
    }

    /// Nodes and elements that supports, loads and requests name by their numbers.
    fn single_sets(&mut self, cards: &[Card<'_>], elements: &BTreeSet<u64>) {
        for card in cards {
            let first = |data: &DataLine<'_>| label(data.fields().next().unwrap_or_default());
            match card.keyword.as_str() {
                "BOUNDARY" | "CLOAD" => self.single_nodes.extend(card.data.iter().filter_map(first)),
                "DLOAD" => self.single_elements.extend(card.data.iter().filter_map(first)),
                "NODE PRINT" => {
                    let set = card.parameter("NSET").and_then(|name| self.node_sets.get(name));
                    if let Some((_, members)) = set.filter(|(_, members)| members.len() <= MOST_PRINTED) {
                        self.single_nodes.extend(members);
                    }
                }
                _ => {}
            }
        }
        let mut single = std::mem::take(&mut self.single_nodes);
        single.retain(|node| self.has(*node));
        self.single_nodes = single;
        self.single_elements.retain(|element| elements.contains(element));
    }
}
