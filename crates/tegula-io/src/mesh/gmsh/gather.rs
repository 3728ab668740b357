//! Mesh from the checked content of a Gmsh file.

use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};

use tegula::Mesh;
use tegula::mesh::Labels;
use tegula::mesh::sets::RENAME_ALL;

use super::hexahedra;
use super::raw::{Corners, Raw, RawElement, Refused, Shape};
use super::scanner::Scanner;
use crate::mesh::MeshError;

/// Quads, their nodes in the order of the Gmsh numbers, and the sets of the physical groups.
pub(super) fn mesh(scanner: &Scanner<'_>, raw: Raw, scale: f64) -> Result<Mesh, MeshError> {
    refuse(scanner, &raw.refused)?;
    let listed = listed_nodes(scanner, &raw, scale)?;
    if hexahedra::any(&raw) {
        return named_all(scanner, hexahedra::mesh(scanner, &raw, &listed, scale)?);
    }
    let quads = Quads::collect(scanner, &raw, &listed)?;
    if quads.corners.is_empty() {
        return Err(scanner.whole(
            "the mesh holds no quadrilaterals",
            "mesh the surfaces in Gmsh (gmsh -2) with \"Recombine Surface {:};\"; \
             once there are physical groups only their elements are saved, so give the surfaces one, too",
        ));
    }

    let used: BTreeSet<u64> = quads.corners.iter().flatten().copied().collect();
    if u32::try_from(used.len().max(quads.corners.len())).is_err() {
        return Err(scanner.whole("the mesh has more than 4294967295 nodes or quads", "make a coarser mesh"));
    }
    let index: HashMap<u64, u32> = used.iter().copied().zip(0..).collect();
    let local = |tag: &u64| index.get(tag).copied();

    let labels = Labels {
        file: scanner.file_name(),
        nodes: used.iter().copied().collect(),
        quads: quads.tags.clone(),
    };
    let mut mesh = Mesh { labels: Some(labels), ..Mesh::default() };
    for tag in &used {
        if let Some(&node) = listed.get(tag) {
            mesh.positions.push(raw.nodes[node].position * scale);
        }
    }
    for corners in &quads.corners {
        if let [Some(a), Some(b), Some(c), Some(d)] = corners.each_ref().map(local) {
            mesh.quads.push([a, b, c, d]);
        }
    }
    for (name, members) in quads.sets {
        mesh.quad_sets.insert(name, distinct(members, |&q| q));
    }
    let sides: HashSet<[u64; 2]> = quads.corners.iter().flat_map(sides).collect();
    let (mut node_sets, mut edge_sets) = (BTreeMap::new(), BTreeMap::new());
    for element in &raw.elements {
        match element.corners {
            Corners::Point(tag) => {
                for name in raw.set_names(element, 0) {
                    let Some(node) = local(&tag) else { return Err(lost_node(scanner, element, &name, tag)) };
                    node_sets.entry(name).or_insert_with(Vec::new).push(node);
                }
            }
            Corners::Line(ends) => {
                for name in raw.set_names(element, 1) {
                    let (true, [Some(a), Some(b)]) =
                        (sides.contains(&sorted(ends)), ends.each_ref().map(local))
                    else {
                        return Err(lost_line(scanner, element, &name, ends));
                    };
                    edge_sets.entry(name).or_insert_with(Vec::new).push([a, b]);
                }
            }
            Corners::Quad(_) | Corners::Hexahedron(_) => {}
        }
    }
    mesh.node_sets = node_sets.into_iter().map(|(name, set)| (name, distinct(set, |&n| n))).collect();
    mesh.edge_sets = edge_sets.into_iter().map(|(name, set)| (name, distinct(set, |&e| sorted(e)))).collect();
    named_all(scanner, mesh)
}

/// The mesh, unless a group calls a part of it "all".
fn named_all(scanner: &Scanner<'_>, mesh: Mesh) -> Result<Mesh, MeshError> {
    if let Some((_, message)) = mesh.partial_all() {
        return Err(scanner.whole(message, RENAME_ALL));
    }
    Ok(mesh)
}

/// Quads once each, in the order of the file, and the groups they belong to.
#[derive(Default)]
struct Quads {
    corners: Vec<[u64; 4]>,
    /// Number of each in the file.
    tags: Vec<u64>,
    sets: BTreeMap<String, Vec<u32>>,
}

impl Quads {
    fn collect(scanner: &Scanner<'_>, raw: &Raw, listed: &HashMap<u64, usize>) -> Result<Self, MeshError> {
        let mut quads = Self::default();
        // The quad on four nodes, and the elements of the file that are this quad.
        let mut known: HashMap<[u64; 4], (u32, Vec<&RawElement>)> = HashMap::new();
        for element in &raw.elements {
            let tags: &[u64] = match &element.corners {
                Corners::Point(tag) => std::slice::from_ref(tag),
                Corners::Line(tags) => tags,
                Corners::Quad(tags) => tags,
                Corners::Hexahedron(tags) => tags,
            };
            if let Some(missing) = tags.iter().find(|&tag| !listed.contains_key(tag)) {
                return Err(scanner.error(
                    element.at,
                    format!("element {} needs node {missing}, which $Nodes does not list", element.tag),
                    "the file is damaged: save the mesh again in Gmsh",
                ));
            }
            let Corners::Quad(corners) = element.corners else { continue };
            let mut key = corners;
            key.sort_unstable();
            if let Some(twice) = key.windows(2).find(|pair| pair[0] == pair[1]) {
                return Err(scanner.error(
                    element.at,
                    format!("element {} has node {} at two corners", element.tag, twice[0]),
                    "remove collapsed quadrilaterals, such as those at the pole of a sphere: mesh that part unstructured",
                ));
            }
            let next = quads.corners.len() as u32;
            let (quad, copies) = known.entry(key).or_insert((next, Vec::new()));
            let quad = *quad;
            if quad == next {
                quads.corners.push(corners);
                quads.tags.push(element.tag);
            } else if let Some(first) = copies.iter().find(|first| !raw.is_copy(first, element)) {
                return Err(twice(scanner, first, element));
            }
            copies.push(element);
            for name in raw.set_names(element, 2) {
                quads.sets.entry(name).or_default().push(quad);
            }
        }
        Ok(quads)
    }
}

impl Raw {
    /// True if `second` is `first` once more because it belongs to another physical group too: format 2.2 writes
    /// it again for each of its groups, on the same entity and with its nodes in the same order.
    pub(super) fn is_copy(&self, first: &RawElement, second: &RawElement) -> bool {
        let alike = match (&first.corners, &second.corners) {
            (Corners::Quad(a), Corners::Quad(b)) => a == b,
            (Corners::Hexahedron(a), Corners::Hexahedron(b)) => a == b,
            _ => false,
        };
        self.copies && alike && first.entity == second.entity && first.groups != second.groups
    }

    /// Names of the sets an element belongs to: those of its physical groups, or their numbers.
    pub(super) fn set_names(&self, element: &RawElement, dimension: u8) -> Vec<String> {
        let groups = element.groups.and_then(|list| self.groups.get(list)).map_or(&[][..], Vec::as_slice);
        let name = |&group: &i64| {
            let tag = group.unsigned_abs();
            self.names.get(&(dimension, tag)).cloned().unwrap_or_else(|| tag.to_string())
        };
        groups.iter().map(name).collect()
    }
}

/// Index into the nodes of the file by number.
fn listed_nodes(scanner: &Scanner<'_>, raw: &Raw, scale: f64) -> Result<HashMap<u64, usize>, MeshError> {
    let mut listed = HashMap::new();
    for (i, node) in raw.nodes.iter().enumerate() {
        if !node.position.iter().all(|x| (x * scale).is_finite()) {
            return Err(scanner.error(
                node.coordinates,
                format!("node {} has a coordinate that is not a finite number", node.tag),
                "repair the geometry, or the scale of the mesh, and mesh it again",
            ));
        }
        if listed.insert(node.tag, i).is_some() {
            return Err(scanner.error(
                node.at,
                format!("node {} is listed twice", node.tag),
                "renumber the nodes: open the mesh in Gmsh and save it again",
            ));
        }
    }
    Ok(listed)
}

/// One error for all elements that cannot be computed.
fn refuse(scanner: &Scanner<'_>, refused: &BTreeMap<i64, Refused>) -> Result<(), MeshError> {
    let Some(at) = refused.values().map(|r| r.at).min() else { return Ok(()) };
    let found: Vec<String> = refused.values().map(describe).collect();
    let mut help = Vec::new();
    let mut advise = |wanted: bool, advice: &'static str| {
        if wanted {
            help.push(advice);
        }
    };
    advise(
        refused.values().any(|r| r.shape == Shape::Solid),
        "mesh the surfaces only (gmsh -2) and give no physical volume, or extrude them by one layer with \"Layers{1}; Recombine;\"",
    );
    advise(
        refused.values().any(|r| r.shape == Shape::Triangle),
        "recombine the triangles with \"Recombine Surface {:};\" in the .geo file or Mesh > Recombine 2D in Gmsh, \
         and where some remain add \"Mesh.SubdivisionAlgorithm = 1;\"",
    );
    advise(
        refused.values().any(|r| match r.shape {
            Shape::Line => true,
            Shape::Triangle => r.nodes > 3,
            Shape::Quadrilateral => r.nodes > 4,
            Shape::Point | Shape::Solid => false,
        }),
        "use order 1: \"Mesh.ElementOrder = 1;\" in the .geo file or Mesh > Set order 1 in Gmsh",
    );
    Err(scanner.error(
        at,
        format!("the mesh holds {}, but only quadrilaterals of 4 nodes and one layer of hexahedra of 8 nodes can be computed", found.join(", ")),
        help.join("; "),
    ))
}

fn describe(refused: &Refused) -> String {
    let shape = match refused.shape {
        Shape::Point => "point",
        Shape::Line => "line",
        Shape::Triangle => "triangle",
        Shape::Quadrilateral => "quadrilateral",
        Shape::Solid => "solid",
    };
    let Refused { count, nodes, first, .. } = refused;
    match count {
        1 => format!("1 {shape} of {nodes} nodes (element {first})"),
        _ => format!("{count} {shape}s of {nodes} nodes (the first is element {first})"),
    }
}

fn twice(scanner: &Scanner<'_>, first: &RawElement, second: &RawElement) -> MeshError {
    scanner.error(
        second.at,
        format!("elements {} and {} have the same four nodes", first.tag, second.tag),
        "remove one of them; one thickness has to count for both",
    )
}

pub(super) fn lost_node(scanner: &Scanner<'_>, element: &RawElement, name: &str, node: u64) -> MeshError {
    scanner.error(
        element.at,
        format!("node {node} of the physical point \"{name}\" belongs to no element"),
        "put the point into its surface with \"Point{…} In Surface{…};\" in the .geo file, or take it out of the group",
    )
}

pub(super) fn lost_line(
    scanner: &Scanner<'_>,
    element: &RawElement,
    name: &str,
    [a, b]: [u64; 2],
) -> MeshError {
    scanner.error(
        element.at,
        format!("the line from node {a} to node {b} of the physical curve \"{name}\" is not the side of an element"),
        "put the curve into its surface with \"Curve{…} In Surface{…};\" in the .geo file, or take it out of the group",
    )
}

pub(super) fn sides(&[a, b, c, d]: &[u64; 4]) -> [[u64; 2]; 4] {
    [sorted([a, b]), sorted([b, c]), sorted([c, d]), sorted([d, a])]
}

pub(super) fn sorted<T: Ord>([a, b]: [T; 2]) -> [T; 2] {
    if a <= b { [a, b] } else { [b, a] }
}

/// The items without repetition, each where it first stands.
pub(super) fn distinct<T, K: std::hash::Hash + Eq>(items: Vec<T>, key: impl Fn(&T) -> K) -> Vec<T> {
    let mut seen = HashSet::new();
    items.into_iter().filter(|item| seen.insert(key(item))).collect()
}
