//! Named parts of a mesh, and searches for nodes by position.
//!
//! The name [`ALL`] always stands for the whole mesh. Orphan nodes, which no quad uses (construction points left over
//! in a mesh file), belong to no part unless a set names them.

use std::collections::BTreeMap;

use super::Mesh;
use super::facet::{Facet, show};
use super::topology::Edges;
use crate::{Issue, Vec3};

/// Name of the whole mesh.
pub const ALL: &str = "all";
/// Remedy where a part of a mesh has this name.
pub const RENAME_ALL: &str = "\"all\" stands for the whole mesh in model files: give the set another name";

impl Mesh {
    /// Nodes of a part, sorted: those of the node set `name`, else of the edges or
    /// quads of that name, else of all quads if `name` is [`ALL`].
    pub fn nodes_on(&self, name: &str) -> Option<Vec<u32>> {
        let mut nodes: Vec<u32> = if let Some(nodes) = self.node_sets.get(name) {
            nodes.clone()
        } else if let Some(edges) = self.edge_sets.get(name) {
            edges.iter().flatten().copied().collect()
        } else if let Some(quads) = self.quad_sets.get(name) {
            quads.iter().filter_map(|&quad| self.quads.get(quad as usize)).flatten().copied().collect()
        } else if name == ALL {
            return Some(self.used_nodes());
        } else {
            return None;
        };
        nodes.sort_unstable();
        nodes.dedup();
        Some(nodes)
    }

    /// Edges of a part, sorted by their smaller, then larger node: those of the edge
    /// set `name`, else the boundary edges with both nodes in the node set `name`,
    /// else all boundary edges if `name` is [`ALL`].
    ///
    /// Boundary edges run in the direction of their quad, so that the sheet lies to
    /// the left seen from the director's side; edges of sets run as the set has them.
    pub fn edges_on(&self, name: &str) -> Option<Vec<[u32; 2]>> {
        if let Some(edges) = self.edge_sets.get(name) {
            let mut edges = edges.clone();
            edges.sort_by_key(undirected);
            edges.dedup_by_key(|edge| undirected(edge));
            return Some(edges);
        }
        if self.node_sets.contains_key(name) {
            return Some(self.boundary_between(&self.nodes_on(name)?));
        }
        (name == ALL && !self.quad_sets.contains_key(ALL)).then(|| self.boundary_edges())
    }

    /// Table and message of a set that is called [`ALL`] and is not the whole mesh, with which a model would mean two things by this name.
    pub fn partial_all(&self) -> Option<(&'static str, String)> {
        let of = |sets, noun, held: Option<usize>, all: usize| {
            let held = held.filter(|held| *held < all)?;
            Some((sets, format!("the {noun} set \"{ALL}\" holds {held} of {all} {noun}s")))
        };
        of("node_sets", "node", self.node_sets.get(ALL).map(Vec::len), self.positions.len())
            .or_else(|| of("quad_sets", "element", self.quad_sets.get(ALL).map(Vec::len), self.quads.len()))
            .or_else(|| {
                let boundary = self.boundary_edges();
                let of_set =
                    |edge: &[u32; 2]| boundary.iter().any(|other| undirected(other) == undirected(edge));
                let set = self.edge_sets.get(ALL)?;
                let whole = set.len() == boundary.len() && set.iter().all(of_set);
                (!whole)
                    .then(|| ("edge_sets", format!("the edge set \"{ALL}\" is not the boundary of the mesh")))
            })
    }

    /// Quads of a part, sorted: those of the quad set `name`, else all if `name` is [`ALL`].
    pub fn quads_on(&self, name: &str) -> Option<Vec<u32>> {
        if let Some(quads) = self.quad_sets.get(name) {
            let mut quads = quads.clone();
            quads.sort_unstable();
            quads.dedup();
            return Some(quads);
        }
        (name == ALL).then(|| (0u32..).take(self.quads.len()).collect())
    }

    /// Names of all parts of the mesh, sorted, [`ALL`] among them.
    pub fn set_names(&self) -> Vec<String> {
        let sets = self.node_sets.keys().chain(self.edge_sets.keys()).chain(self.quad_sets.keys());
        let mut names: Vec<String> = sets.cloned().chain([ALL.to_owned()]).collect();
        names.sort_unstable();
        names.dedup();
        names
    }

    /// The name most like `name`, for "did you mean"; `None` if more than half of the letters differ.
    pub fn closest_name(&self, name: &str) -> Option<String> {
        let letters: Vec<char> = name.to_lowercase().chars().collect();
        let mut best: Option<(usize, String)> = None;
        for candidate in self.set_names() {
            let other: Vec<char> = candidate.to_lowercase().chars().collect();
            let distance = edit_distance(&letters, &other);
            let alike = 2 * distance <= letters.len().max(other.len());
            if alike && best.as_ref().is_none_or(|(least, _)| distance < *least) {
                best = Some((distance, candidate));
            }
        }
        best.map(|(_, candidate)| candidate)
    }

    /// The node of a quad nearest to `position`, the first one of several equally near;
    /// `None` if no quad has a node with finite distance.
    pub fn nearest_node(&self, position: Vec3) -> Option<u32> {
        self.nearest_of(&self.used_nodes(), position)
    }

    /// Least and largest coordinates of the quads' nodes (length); zero without quads.
    pub fn bounding_box(&self) -> (Vec3, Vec3) {
        let nodes = self.used_nodes();
        let mut positions = nodes.iter().filter_map(|&node| self.positions.get(node as usize));
        let Some(first) = positions.next() else { return (Vec3::zeros(), Vec3::zeros()) };
        positions.fold((*first, *first), |(low, high), x| (low.inf(x), high.sup(x)))
    }

    /// Largest side of the bounding box (length).
    pub fn extent(&self) -> f64 {
        let (low, high) = self.bounding_box();
        (high - low).max()
    }

    /// Edges that belong to a single quad, in the direction in which it runs through
    /// them, sorted by their smaller, then larger node.
    pub fn boundary_edges(&self) -> Vec<[u32; 2]> {
        let edges = Edges::of(&self.quads);
        edges.iter().filter(|uses| uses.len() == 1).map(|uses| uses[0].nodes()).collect()
    }

    /// Boundary edges with both ends among some nodes, which are sorted.
    pub fn boundary_between(&self, nodes: &[u32]) -> Vec<[u32; 2]> {
        let mut edges = self.boundary_edges();
        edges.retain(|edge| edge.iter().all(|node| nodes.binary_search(node).is_ok()));
        edges
    }

    /// Edges that belong to a single one of some quads, in the direction in which it runs through them; indices out of range are left out.
    pub fn boundary_of(&self, quads: &[u32]) -> Vec<[u32; 2]> {
        let quads: Vec<[u32; 4]> =
            quads.iter().filter_map(|&quad| self.quads.get(quad as usize)).copied().collect();
        let edges = Edges::of(&quads);
        edges.iter().filter(|uses| uses.len() == 1).map(|uses| uses[0].nodes()).collect()
    }

    /// Mesh with all coordinates times `factor`, which must not be zero.
    ///
    /// Normals stay: r,u × r,v keeps its direction even under a negative factor.
    #[must_use]
    pub fn scaled(mut self, factor: f64) -> Self {
        for position in &mut self.positions {
            *position *= factor;
        }
        self
    }

    /// Adds a node set for each named point, with the node nearest to it.
    ///
    /// Returns an issue, and adds no set, for each point with a name already in use
    /// or farther from its node than the longest diagonal of an element.
    pub fn name_points(&mut self, points: &BTreeMap<String, [f64; 3]>) -> Vec<Issue> {
        self.name_points_of("mesh.points", points)
    }

    /// [`Self::name_points`] for the points at a given key of the model.
    pub(super) fn name_points_of(&mut self, key: &str, points: &BTreeMap<String, [f64; 3]>) -> Vec<Issue> {
        let names = self.set_names();
        let mut issues = Vec::new();
        for (name, &position) in points {
            let key = format!("{key}.{name}");
            let position = Vec3::from(position);
            if names.contains(name) {
                issues.push(Issue::new(
                    key,
                    format!("the mesh already has a set `{name}`"),
                    "give the point another name",
                ));
                continue;
            }
            match self.node_near(name, position) {
                Ok(node) => drop(self.node_sets.insert(name.clone(), vec![node])),
                Err((message, help)) => issues.push(Issue::new(key, message, help)),
            }
        }
        issues
    }

    /// The node nearest to the point `name` at `position`.
    ///
    /// # Errors
    /// The point is farther from the node than the longest diagonal of an element, or there is no node: message and
    /// remedy.
    pub fn node_near(&self, name: &str, position: Vec3) -> Result<u32, (String, String)> {
        let facets = self.quads.iter().filter_map(|quad| Facet::of(self, quad));
        let reach = facets.map(|facet| facet.diagonal()).fold(0.0, crate::norm::larger);
        let nearest = self.nearest_node(position);
        let Some((node, x)) = nearest.and_then(|node| Some((node, *self.positions.get(node as usize)?)))
        else {
            return Err((
                format!("the point `{name}` at {} has no nearest node", show(position)),
                "give three finite coordinates on a mesh with elements".into(),
            ));
        };
        let distance = (x - position).norm();
        if distance <= reach {
            return Ok(node);
        }
        Err((
            format!(
                "the point `{name}` at {} is {distance:.3e} away from the nearest node {} at {}, \
                 farther than the largest element is wide",
                show(position),
                self.node_label(node),
                show(x)
            ),
            "give a position on the mesh".into(),
        ))
    }

    /// Nodes of all quads, sorted; indices out of range left out.
    fn used_nodes(&self) -> Vec<u32> {
        let mut used = vec![false; self.positions.len()];
        for &node in self.quads.iter().flatten() {
            if let Some(used) = used.get_mut(node as usize) {
                *used = true;
            }
        }
        (0u32..).zip(used).filter_map(|(node, used)| used.then_some(node)).collect()
    }

    fn nearest_of(&self, nodes: &[u32], position: Vec3) -> Option<u32> {
        let mut best = (f64::INFINITY, None);
        for &node in nodes {
            let distance =
                self.positions.get(node as usize).map_or(f64::NAN, |x| (x - position).norm_squared());
            if distance < best.0 {
                best = (distance, Some(node));
            }
        }
        best.1
    }
}

/// The edge's nodes, smaller first.
pub(crate) fn undirected(edge: &[u32; 2]) -> [u32; 2] {
    [edge[0].min(edge[1]), edge[0].max(edge[1])]
}

/// Least number of letters to insert, remove, replace or swap with the next one that
/// makes `a` into `b` (optimal string alignment).
fn edit_distance(a: &[char], b: &[char]) -> usize {
    let mut before_last = vec![0; b.len() + 1];
    let mut last: Vec<usize> = (0..=b.len()).collect();
    for i in 1..=a.len() {
        let mut row = vec![i];
        for j in 1..=b.len() {
            let replaced = last[j - 1] + usize::from(a[i - 1] != b[j - 1]);
            let mut least = replaced.min(last[j] + 1).min(row[j - 1] + 1);
            if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                least = least.min(before_last[j - 2] + 1);
            }
            row.push(least);
        }
        before_last = std::mem::replace(&mut last, row);
    }
    last[b.len()]
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// ```text
    ///  3---4---5
    ///  | 0 | 1 |     7: unused
    ///  0---1---2
    /// ```
    fn two_quads() -> Mesh {
        let at = |x: f64, y: f64| Vec3::new(x, y, 0.0);
        let mut mesh = Mesh {
            positions: vec![
                at(0.0, 0.0),
                at(1.0, 0.0),
                at(2.0, 0.0),
                at(0.0, 1.0),
                at(1.0, 1.0),
                at(2.0, 1.0),
                at(9.0, 9.0),
            ],
            quads: vec![[0, 1, 4, 3], [1, 2, 5, 4]],
            ..Mesh::default()
        };
        mesh.node_sets.insert("bottom".into(), vec![2, 1, 0, 1]);
        mesh.node_sets.insert("middle".into(), vec![1, 4]);
        mesh.edge_sets.insert("left".into(), vec![[3, 0], [0, 3]]);
        mesh.quad_sets.insert("right".into(), vec![1]);
        mesh
    }

    #[test]
    fn parts_are_found_by_name() {
        let mesh = two_quads();
        assert_eq!(mesh.nodes_on("bottom"), Some(vec![0, 1, 2]));
        assert_eq!(mesh.nodes_on("left"), Some(vec![0, 3]));
        assert_eq!(mesh.nodes_on("right"), Some(vec![1, 2, 4, 5]));
        assert_eq!(mesh.nodes_on("all"), Some(vec![0, 1, 2, 3, 4, 5]));
        assert_eq!(mesh.nodes_on("top"), None);

        assert_eq!(mesh.edges_on("left"), Some(vec![[3, 0]]));
        assert_eq!(mesh.edges_on("bottom"), Some(vec![[0, 1], [1, 2]]));
        assert_eq!(mesh.edges_on("middle"), Some(vec![]));
        assert_eq!(mesh.edges_on("all"), Some(mesh.boundary_edges()));
        assert_eq!(mesh.edges_on("right"), None);
        assert_eq!(mesh.edges_on("top"), None);

        assert_eq!(mesh.quads_on("right"), Some(vec![1]));
        assert_eq!(mesh.quads_on("all"), Some(vec![0, 1]));
        assert_eq!(mesh.quads_on("bottom"), None);
        assert_eq!(mesh.set_names(), ["all", "bottom", "left", "middle", "right"]);
    }

    #[test]
    fn boundary_runs_round_the_quads() {
        let boundary = two_quads().boundary_edges();
        assert_eq!(boundary, [[0, 1], [3, 0], [1, 2], [2, 5], [4, 3], [5, 4]]);
    }

    #[test]
    fn similar_names_are_offered() {
        let mesh = two_quads();
        assert_eq!(mesh.closest_name("botom").as_deref(), Some("bottom"));
        assert_eq!(mesh.closest_name("LEFT").as_deref(), Some("left"));
        assert_eq!(mesh.closest_name("rihgt").as_deref(), Some("right"));
        assert_eq!(mesh.closest_name("spherical joint"), None);
        assert_eq!(mesh.closest_name(""), None);
    }

    #[test]
    fn space_is_measured_without_unused_nodes() {
        let mesh = two_quads();
        assert_eq!(mesh.bounding_box(), (Vec3::zeros(), Vec3::new(2.0, 1.0, 0.0)));
        assert_eq!(mesh.extent(), 2.0);
        assert_eq!(mesh.nearest_node(Vec3::new(9.0, 9.0, 0.0)), Some(5));
        assert_eq!(mesh.nearest_node(Vec3::new(0.5, 0.0, 0.0)), Some(0));
        assert_eq!(mesh.nearest_node(Vec3::new(f64::NAN, 0.0, 0.0)), None);
        assert_eq!(mesh.scaled(-3.0).extent(), 6.0);
        assert_eq!(Mesh::default().extent(), 0.0);
        assert_eq!(Mesh::default().nearest_node(Vec3::zeros()), None);
    }

    #[test]
    fn points_become_sets_or_issues() {
        let mut mesh = two_quads();
        let points = BTreeMap::from([
            ("tip".to_owned(), [2.1, 0.9, 0.0]),
            ("away".to_owned(), [5.0, 0.0, 0.0]),
            ("left".to_owned(), [0.0, 0.0, 0.0]),
            ("all".to_owned(), [0.0, 0.0, 0.0]),
            ("odd".to_owned(), [f64::INFINITY, 0.0, 0.0]),
        ]);
        let issues = mesh.name_points(&points);
        let keys: Vec<&str> = issues.iter().map(|issue| issue.place.key.as_str()).collect();
        assert_eq!(keys, ["mesh.points.all", "mesh.points.away", "mesh.points.left", "mesh.points.odd"]);
        assert!(issues[1].message.contains("3.000e0 away from the nearest node 2"), "{}", issues[1]);
        assert_eq!(mesh.nodes_on("tip"), Some(vec![5]));
        assert_eq!(mesh.nodes_on("away"), None);
    }

    #[test]
    fn indices_out_of_range_do_no_harm() {
        let mut mesh = two_quads();
        mesh.quads.push([100, 101, 102, u32::MAX]);
        mesh.quad_sets.insert("odd".into(), vec![77]);
        assert_eq!(mesh.nodes_on("odd"), Some(vec![]));
        assert_eq!(mesh.nodes_on("all").map(|nodes| nodes.len()), Some(6));
        assert_eq!(mesh.boundary_edges().len(), 10);
    }

    proptest! {
        #[test]
        fn edit_distance_is_a_distance(a in "[ab]{0,6}", b in "[ab]{0,6}") {
            let [a, b] = [a, b].map(|text| text.chars().collect::<Vec<_>>());
            let distance = edit_distance(&a, &b);
            prop_assert_eq!(distance, edit_distance(&b, &a));
            prop_assert_eq!(distance == 0, a == b);
            prop_assert!(distance <= a.len().max(b.len()));
            prop_assert!(distance >= a.len().abs_diff(b.len()));
        }
    }
}
