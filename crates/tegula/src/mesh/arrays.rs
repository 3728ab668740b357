//! Mesh of the nodes and elements that stand in a model.

use std::collections::{BTreeMap, HashMap, HashSet};

use super::input::{Input, MOST_ELEMENTS};
use super::sets::RENAME_ALL;
use super::{Labels, Mesh};
use crate::model::ArraysMesh;
use crate::{Error, Result};

/// Issues of one kind after which the others are only counted.
const SHOWN: usize = 5;

/// Mesh of the arrays; nodes of no element are dropped, and messages keep the numbers of the arrays.
///
/// # Errors
/// Numbers of nodes and elements that do not exist, collapsed and repeated elements, edges that are no sides, coordinates that are not finite.
pub(super) fn mesh(source: &ArraysMesh) -> Result<Mesh> {
    let mut input = Input::default();
    if source.quads.is_empty() {
        input.wrong("mesh.quads", "the mesh has no elements", "give four nodes of each element");
    }
    if source.nodes.len().max(source.quads.len()) as u64 > MOST_ELEMENTS {
        let message = format!("the mesh has more than {MOST_ELEMENTS} nodes or elements");
        input.wrong("mesh.nodes", message, "make a coarser mesh");
    }
    elements(source, &mut input);
    let mut used: Vec<u32> = source.quads.iter().flatten().copied().collect();
    used.sort_unstable();
    used.dedup();
    let place: HashMap<u32, u32> = used.iter().copied().zip(0..).collect();
    for &node in used.iter().filter(|&&node| (node as usize) < source.nodes.len()) {
        input.point("mesh.nodes", &format!("node {node}"), source.nodes[node as usize]);
    }
    let mut out = Mesh::default();
    // Sets of wrong elements would be wrong for the same reason.
    if input.issues.is_empty() {
        sets(source, &place, &mut input, &mut out);
    }
    if !input.issues.is_empty() {
        return Err(Error::Model(shortened(input)));
    }
    out.positions = used.iter().map(|&node| source.nodes[node as usize].into()).collect();
    out.quads = source.quads.iter().map(|quad| quad.map(|node| place[&node])).collect();
    if used.len() < source.nodes.len() {
        let quads = (0..source.quads.len() as u64).collect();
        let nodes = used.iter().map(|&node| u64::from(node)).collect();
        out.labels = Some(Labels { file: String::new(), nodes, quads });
    }
    if let Some((sets, message)) = out.partial_all() {
        return Err(Error::model(format!("mesh.{sets}.all"), message, RENAME_ALL));
    }
    if source.merge_coincident == Some(true) {
        out.merge_coincident_nodes().map_err(Error::Model)?;
    }
    let issues = out.name_points_of("mesh.points", &source.points);
    if issues.is_empty() { Ok(out) } else { Err(Error::Model(issues)) }
}

/// Checks the nodes of the elements.
fn elements(source: &ArraysMesh, input: &mut Input) {
    let mut known = HashMap::new();
    for (number, quad) in source.quads.iter().enumerate() {
        if let Some(node) = quad.iter().find(|&&node| node as usize >= source.nodes.len()) {
            let message = format!(
                "element {number} has the node {node}, and the mesh has {} nodes, from 0 on",
                source.nodes.len()
            );
            input.wrong("mesh.quads", message, "count nodes from 0, in the order of `nodes`");
            continue;
        }
        let mut sorted = *quad;
        sorted.sort_unstable();
        if let Some(pair) = sorted.windows(2).find(|pair| pair[0] == pair[1]) {
            let message = format!("element {number} has the node {} at two corners", pair[0]);
            input.wrong("mesh.quads", message, "leave collapsed elements out; elements have four corners");
        }
        if let Some(first) = known.insert(sorted, number) {
            let message = format!("elements {first} and {number} have the same four nodes");
            input.wrong("mesh.quads", message, "leave one of them out; one thickness has to count for both");
        }
    }
}

/// Writes the named sets to the mesh.
fn sets(source: &ArraysMesh, place: &HashMap<u32, u32>, input: &mut Input, out: &mut Mesh) {
    for (name, nodes) in &source.node_sets {
        let key = format!("mesh.node_sets.{name}");
        let of = |&node: &u32| {
            let found = place.get(&node).copied();
            found.ok_or_else(|| format!("the node {node} of the set \"{name}\" belongs to no element"))
        };
        take(nodes, of, (&key, "name nodes of elements, counted from 0"), (name, input), &mut out.node_sets);
    }
    let sorted = |[a, b]: [u32; 2]| [a.min(b), a.max(b)];
    let sides: HashSet<[u32; 2]> =
        source.quads.iter().flat_map(|&[a, b, c, d]| [[a, b], [b, c], [c, d], [d, a]].map(sorted)).collect();
    for (name, edges) in &source.edge_sets {
        let key = format!("mesh.edge_sets.{name}");
        let of = |&edge: &[u32; 2]| match edge.map(|node| place.get(&node).copied()) {
            [Some(a), Some(b)] if sides.contains(&sorted(edge)) => Ok(sorted([a, b])),
            _ => Err(format!(
                "the line from node {} to node {} of the set \"{name}\" is not the side of an element",
                edge[0], edge[1]
            )),
        };
        take(
            edges,
            of,
            (&key, "name sides of elements by their two nodes"),
            (name, input),
            &mut out.edge_sets,
        );
    }
    let count = source.quads.len();
    for (name, quads) in &source.quad_sets {
        let key = format!("mesh.quad_sets.{name}");
        let of = |&quad: &u32| {
            let found = Some(quad).filter(|&quad| (quad as usize) < count);
            found.ok_or_else(|| {
                format!(
                    "the set \"{name}\" has the element {quad}, and the mesh has {count} elements, from 0 on"
                )
            })
        };
        take(
            quads,
            of,
            (&key, "count elements from 0, in the order of `quads`"),
            (name, input),
            &mut out.quad_sets,
        );
    }
}

/// The members of a set, without repetition.
fn take<T, M: Copy + Eq + std::hash::Hash>(
    given: &[T],
    of: impl Fn(&T) -> std::result::Result<M, String>,
    (key, help): (&str, &str),
    (name, input): (&str, &mut Input),
    sets: &mut BTreeMap<String, Vec<M>>,
) {
    let mut seen = HashSet::new();
    let mut members = Vec::new();
    for item in given {
        match of(item) {
            Ok(member) if seen.insert(member) => members.push(member),
            Ok(_) => {}
            Err(message) => input.wrong(key, message, help),
        }
    }
    if given.is_empty() {
        input.wrong(key, format!("the set \"{name}\" is empty"), help);
    }
    sets.insert(name.to_owned(), members);
}

/// The first issues of each key, and the number of the others.
fn shortened(input: Input) -> Vec<crate::Issue> {
    let mut counts: BTreeMap<String, usize> = BTreeMap::new();
    let mut out = Vec::new();
    for issue in input.issues {
        let count = counts.entry(issue.place.key.clone()).or_default();
        *count += 1;
        if *count <= SHOWN {
            out.push(issue);
        }
    }
    for (key, count) in counts.into_iter().filter(|(_, count)| *count > SHOWN) {
        let message = format!("mistakes beside these, in the same list: {}", count - SHOWN);
        out.push(crate::Issue::new(&key, message, "see those written out above"));
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::MeshSource;

    /// Two elements in a row; node 3 belongs to none.
    fn strip() -> ArraysMesh {
        ArraysMesh {
            nodes: vec![
                [0.0, 0.0, 0.0],
                [1.0, 0.0, 0.0],
                [2.0, 0.0, 0.0],
                [9.0, 9.0, 9.0],
                [0.0, 1.0, 0.0],
                [1.0, 1.0, 0.0],
                [2.0, 1.0, 0.5],
            ],
            quads: vec![[0, 1, 5, 4], [1, 2, 6, 5]],
            node_sets: [("corner".into(), vec![6, 6])].into(),
            edge_sets: [("end".into(), vec![[6, 2]])].into(),
            quad_sets: [("right".into(), vec![1])].into(),
            points: [("near".into(), [0.1, 0.9, 0.0])].into(),
            ..ArraysMesh::default()
        }
    }

    fn built(source: ArraysMesh) -> Result<Mesh> {
        crate::mesh::generators::generate(&MeshSource::Arrays(source))
    }

    #[test]
    fn arrays_become_a_mesh_without_the_nodes_of_no_element() {
        let mesh = built(strip()).unwrap();
        assert_eq!(mesh.positions.len(), 6);
        assert_eq!(mesh.quads, [[0, 1, 4, 3], [1, 2, 5, 4]]);
        assert_eq!(mesh.positions[5], crate::Vec3::new(2.0, 1.0, 0.5));
        assert_eq!(mesh.node_sets["corner"], [5]);
        assert_eq!(mesh.node_sets["near"], [3]);
        assert_eq!(mesh.edge_sets["end"], [[2, 5]]);
        assert_eq!(mesh.quad_sets["right"], [1]);
        assert_eq!(mesh.node_label(5), 6);
    }

    #[test]
    fn coincident_nodes_are_merged_where_wanted() {
        let mut source = strip();
        source.nodes.extend([[1.0, 0.0, 0.0], [1.0, 1.0, 0.0]]);
        source.quads[1] = [7, 2, 6, 8];
        assert_eq!(built(source.clone()).unwrap().positions.len(), 8);
        source.merge_coincident = Some(true);
        let mesh = built(source).unwrap();
        assert_eq!(mesh.positions.len(), 6);
        assert_eq!(mesh.quads[1][0], mesh.quads[0][1]);
    }

    #[test]
    fn mistakes_of_arrays_are_named_with_their_numbers() {
        let told = |change: &dyn Fn(&mut ArraysMesh)| {
            let mut source = strip();
            change(&mut source);
            match built(source) {
                Err(Error::Model(issues)) => issues
                    .iter()
                    .map(|i| format!("{}: {}", i.place.key, i.message))
                    .collect::<Vec<_>>()
                    .join("\n"),
                other => panic!("{other:?}"),
            }
        };
        assert_eq!(
            told(&|m| m.quads[1][2] = 7),
            "mesh.quads: element 1 has the node 7, and the mesh has 7 nodes, from 0 on"
        );
        assert!(told(&|m| m.quads[1][2] = 1).contains("element 1 has the node 1 at two corners"));
        assert!(told(&|m| m.quads.push([5, 4, 0, 1])).contains("elements 0 and 2 have the same four nodes"));
        assert!(told(&|m| m.nodes[6][1] = f64::NAN).starts_with("mesh.nodes: node 6 is [2.0, NaN, 0.5]"));
        assert_eq!(
            told(&|m| m.node_sets.get_mut("corner").unwrap()[0] = 3),
            "mesh.node_sets.corner: the node 3 of the set \"corner\" belongs to no element"
        );
        assert!(
            told(&|m| m.edge_sets.get_mut("end").unwrap()[0] = [0, 5])
                .contains("from node 0 to node 5 of the set \"end\" is not the side of an element")
        );
        assert!(
            told(&|m| m.quad_sets.get_mut("right").unwrap()[0] = 2)
                .contains("has the element 2, and the mesh has 2 elements, from 0 on")
        );
        assert!(told(&|m| m.quads.clear()).starts_with("mesh.quads: the mesh has no elements"));
        assert!(
            told(&|m| drop(m.quad_sets.insert("all".into(), vec![0])))
                .contains("mesh.quad_sets.all: the element set \"all\" holds 1 of 2 elements")
        );
        assert!(
            told(&|m| drop(m.node_sets.insert("all".into(), vec![0])))
                .contains("mesh.node_sets.all: the node set \"all\" holds 1 of 6 nodes")
        );
        assert!(
            told(&|m| drop(m.edge_sets.insert("all".into(), vec![[0, 1]])))
                .contains("mesh.edge_sets.all: the edge set \"all\" is not the boundary of the mesh")
        );
        assert!(
            told(&|m| drop(m.node_sets.insert("none".into(), vec![]))).contains("the set \"none\" is empty")
        );
        let many = told(&|m| m.quads = (0..20).map(|i| [i, i, i, i]).collect());
        assert!(
            many.contains("mistakes beside these, in the same list: ")
                && many.lines().filter(|line| line.starts_with("mesh.quads")).count() == 6
        );
    }
}
