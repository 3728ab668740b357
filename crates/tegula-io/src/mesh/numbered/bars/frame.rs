//! Frame: which cross-sections of bars, bodies of rigid elements and nodes of shells move together.
//!
//! All bars that meet in a node move with one carrier: the body of a rigid element that holds the node, else the first cross-section that
//! is not released there, else the ground where the node is supported. A node of a shell is attached to its carrier. Joints connect the
//! other cross-sections with it.

use std::collections::{BTreeMap, BTreeSet};

use tegula::Vec3;

use super::lines::{self, Line};
use super::{Bar, Release};
use crate::mesh::MeshError;
use crate::mesh::numbered::{Parts, Reader};

/// Bars of a file with what connects them.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Frame {
    /// Lines of bars.
    pub lines: Vec<Line>,
    /// Nodes of shells that move with each line.
    pub attached: Vec<Vec<u64>>,
    /// Cross-sections that nodes move with, by the numbers of the nodes.
    pub carriers: BTreeMap<u64, String>,
    /// Joints of the other cross-sections.
    pub joints: Vec<Joint>,
    /// Nodes of shells to which joints connect bars.
    pub hinged: BTreeSet<u64>,
}

/// A joint of a cross-section.
#[derive(Debug, Clone, PartialEq)]
pub struct Joint {
    /// Name of the joint.
    pub name: String,
    /// Both sides: the carrier of the node, and the cross-section.
    pub between: [String; 2],
    /// Place of the cross-section.
    pub at: Vec3,
    /// Motion that the joint leaves free.
    pub release: Release,
    /// Line of the bar.
    pub line: usize,
}

/// A cross-section in a node: index of the line of bars, and number along it.
type Place = (usize, usize);

/// The frame of the bars of a file; `bodies` has the names of the bodies of rigid elements by the nodes that they hold, `held` the degrees of
/// freedom that supports fix.
///
/// # Errors
/// All bars are released in a node.
pub fn frame(
    reader: &Reader<'_>,
    bars: &[Bar],
    (bodies, held): (&BTreeMap<u64, String>, &BTreeMap<u64, [bool; 6]>),
    parts: &Parts,
) -> Result<Frame, MeshError> {
    let lines = lines::lines(bars);
    let mut places: BTreeMap<u64, Vec<Place>> = BTreeMap::new();
    for (i, line) in lines.iter().enumerate() {
        for (k, node) in line.nodes.iter().enumerate() {
            places.entry(*node).or_default().push((i, k));
        }
    }
    let mut out = Frame { attached: vec![Vec::new(); lines.len()], ..Frame::default() };
    for (node, places) in places {
        let release = |(i, k): &Place| lines[*i].release(*k);
        let unreleased = places.iter().find(|place| release(place) == Release::Nothing);
        let spherical = places.iter().all(|place| release(place) == Release::Rotations);
        let support = held.get(&node).copied().unwrap_or_default();
        let grounded = support == [true; 6] || (spherical && matches!(support, [true, true, true, ..]));
        let used = parts.used.contains(&node);
        let carrier = match (bodies.get(&node), unreleased) {
            (Some(body), _) => body.clone(),
            (None, Some(&(i, k))) => {
                let section = lines[i].section(k);
                out.carriers.insert(node, section.clone());
                if used {
                    out.attached[i].push(node);
                }
                section
            }
            (None, None) if grounded => "ground".to_owned(),
            (None, None) if used && spherical && on_node(&lines, &places, node, parts) => {
                out.hinged.insert(node);
                node.to_string()
            }
            (None, None) => {
                let first = places.first().map(|(i, _)| &lines[*i]);
                let of =
                    first.map_or_else(String::new, |line| format!(", as of the line of bars {}", line.name));
                return Err(reader.error(
                    first.map_or(1, |line| line.line),
                    format!("all bars at node {node} are released there by pin flags{of}"),
                    "leave the pin flags of one of them out, or support the node with 123456",
                ));
            }
        };
        for place in places {
            let section = lines[place.0].section(place.1);
            if section != carrier {
                out.joints.push(joint(&lines[place.0], place.1, (&carrier, section)));
            }
        }
    }
    out.lines = lines;
    Ok(out)
}

/// Whether all cross-sections of a node lie on it.
fn on_node(lines: &[Line], places: &[Place], node: u64, parts: &Parts) -> bool {
    let at = parts.nodes.get(&node).map(|(position, _)| *position);
    places.iter().all(|(i, k)| Some(lines[*i].points[*k]) == at)
}

/// The joint of a cross-section and what it moves with.
fn joint(line: &Line, at: usize, (carrier, section): (&str, String)) -> Joint {
    Joint {
        name: format!("{section} at node {}", line.nodes[at]),
        between: [carrier.to_owned(), section],
        at: line.points[at],
        release: line.release(at),
        line: line.line,
    }
}
