//! Folds of a mesh: lines along which sheets meet at an angle and neighbouring elements have directors of their own.

use std::collections::{BTreeMap, BTreeSet};

use super::Mesh;
use super::directors::Directors;
use super::facet::{Facet, angle_between};
use super::topology::{Disjoint, EdgeUse, Edges};
use crate::Vec3;

/// Folds at smaller angles (degrees) on both sides of an element, in the same sense, are most likely those of a curved
/// surface.
const CURVED_DEGREES: f64 = 50.0;

/// A line of edges along which sheets meet at an angle, from one end or branching to the next.
#[derive(Debug, Clone, PartialEq)]
pub struct Fold {
    /// Number of its edges.
    pub edges: usize,
    /// Length of all of them (length).
    pub length: f64,
    /// Number of elements that meet at an edge; three or more make a junction.
    pub sheets: usize,
    /// Least and largest angle between the normals of neighbouring elements (degrees); `None` at junctions.
    pub angles: Option<[f64; 2]>,
    /// Its end nodes; one node twice where it is closed.
    pub ends: [u32; 2],
}

/// Elements between two folds in the same sense: a curved surface that is computed as a prism.
#[derive(Debug, Clone, PartialEq)]
pub struct Prism {
    /// The elements.
    pub quads: Vec<u32>,
    /// Least and largest angle of their folds (degrees).
    pub angles: [f64; 2],
}

/// Folds and junctions of a mesh.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Folds {
    /// Lines in the order of their first edges.
    pub lines: Vec<Fold>,
    /// Elements that look like a curved surface; `None` where the true normals are known.
    pub prism: Option<Prism>,
}

/// Edge of a fold.
struct FoldEdge {
    nodes: [u32; 2],
    sheets: usize,
    /// Angle between two neighbours (degrees), positive where they fold to the side of their directors.
    turn: Option<f64>,
    sides: [EdgeUse; 2],
}

impl Folds {
    /// The folds of a mesh with its directors.
    pub fn of(mesh: &Mesh, directors: &Directors) -> Self {
        if directors.ties.is_empty() {
            return Self::default();
        }
        let edges: Vec<FoldEdge> =
            Edges::of(&mesh.quads).iter().filter_map(|uses| fold_edge(mesh, directors, uses)).collect();
        let prism = if mesh.normals.is_none() { prism(&edges) } else { None };
        Self { lines: lines(mesh, &edges), prism }
    }

    /// Length of all folds and junctions (length).
    pub fn length(&self) -> f64 {
        self.lines.iter().map(|line| line.length).sum()
    }
}

/// Fold edge of some elements if they have different directors at one of its ends.
fn fold_edge(mesh: &Mesh, directors: &Directors, uses: &[EdgeUse]) -> Option<FoldEdge> {
    let [first, .., last] = uses else { return None };
    let director = |side: &EdgeUse, node| directors.corners[side.quad as usize][side.corner_at(node)];
    let nodes = [first.low, first.high];
    let folded = nodes.iter().any(|&n| uses.iter().any(|side| director(side, n) != director(first, n)));
    let turn = || {
        let normal = |side: &EdgeUse| -> Option<Vec3> {
            let quad = &mesh.quads[side.quad as usize];
            let at = nodes.map(|n| match &mesh.normals {
                Some(normals) => Some(normals[side.quad as usize][side.corner_at(n)]),
                None => Facet::of(mesh, quad).map(|f| f.corner_normal(side.corner_at(n)).normalize()),
            });
            Some(at[0]? + at[1]?)
        };
        let centre = |side: &EdgeUse| Facet::of(mesh, &mesh.quads[side.quad as usize]).map(|f| f.center());
        let (a, b) = (normal(first)?, normal(last)?);
        let inwards = a.dot(&(centre(last)? - centre(first)?));
        Some(angle_between(&a, &b).to_degrees().copysign(inwards))
    };
    folded.then(|| FoldEdge {
        nodes,
        sheets: uses.len(),
        turn: if uses.len() == 2 { turn() } else { None },
        sides: [*first, *last],
    })
}

/// Joins the edges of folds to lines, which end where they branch or where the number of sheets changes.
fn lines(mesh: &Mesh, edges: &[FoldEdge]) -> Vec<Fold> {
    let mut at_node: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    for (e, edge) in edges.iter().enumerate() {
        edge.nodes.iter().for_each(|&n| at_node.entry(n).or_default().push(e));
    }
    let mut joined = Disjoint::new(edges.len());
    let mut inner = BTreeSet::new();
    for (&node, here) in &at_node {
        if let [a, b] = here[..]
            && edges[a].sheets == edges[b].sheets
        {
            joined.join(a, b);
            inner.insert(node);
        }
    }
    let mut lines: Vec<Fold> = Vec::new();
    let mut of_root = vec![usize::MAX; edges.len()];
    for (e, edge) in edges.iter().enumerate() {
        let root = joined.root(e);
        let [a, b] = edge.nodes;
        if of_root[root] == usize::MAX {
            of_root[root] = lines.len();
            lines.push(Fold {
                edges: 0,
                length: 0.0,
                sheets: edge.sheets,
                angles: None,
                ends: [u32::MAX; 2],
            });
        }
        let line = &mut lines[of_root[root]];
        line.edges += 1;
        line.length += (mesh.positions[b as usize] - mesh.positions[a as usize]).norm();
        if let Some(angle) = edge.turn.map(f64::abs) {
            let [low, high] = line.angles.unwrap_or([angle; 2]);
            line.angles = Some([low.min(angle), high.max(angle)]);
        }
        for node in [a, b].into_iter().filter(|n| !inner.contains(n)) {
            let free = usize::from(line.ends[0] != u32::MAX);
            line.ends[free] = node;
        }
    }
    // Closed lines have no ends.
    for (e, edge) in edges.iter().enumerate() {
        let line = &mut lines[of_root[joined.root(e)]];
        if line.ends[0] == u32::MAX {
            line.ends = [edge.nodes[0]; 2];
        }
    }
    lines
}

/// Elements between two folds of moderate angle in the same sense.
fn prism(edges: &[FoldEdge]) -> Option<Prism> {
    let mut turns: BTreeMap<u32, [Option<f64>; 4]> = BTreeMap::new();
    for edge in edges {
        for side in edge.sides {
            turns.entry(side.quad).or_default()[usize::from(side.side)] = edge.turn;
        }
    }
    let mut prism = Prism { quads: Vec::new(), angles: [f64::INFINITY, 0.0] };
    for (quad, turns) in turns {
        for pair in [[turns[0], turns[2]], [turns[1], turns[3]]] {
            if let [Some(a), Some(b)] = pair
                && a * b > 0.0
                && a.abs().max(b.abs()) <= CURVED_DEGREES
            {
                prism.quads.push(quad);
                prism.angles =
                    [prism.angles[0].min(a.abs()).min(b.abs()), prism.angles[1].max(a.abs()).max(b.abs())];
            }
        }
    }
    prism.quads.dedup();
    (!prism.quads.is_empty()).then_some(prism)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::mesh::directors::FOLD_ANGLE_DEGREES;
    use crate::mesh::generators::generate;
    use crate::model::{ExtrusionMesh, Grid, MeshSource};

    fn extrusion(vertices: &[[f64; 3]], elements: [u32; 2]) -> Mesh {
        let grid = Grid::uniform(elements[0], elements[1]);
        let source = ExtrusionMesh { vertices: vertices.to_vec(), sweep: [0.0, 2.0, 0.0], grid };
        generate(&MeshSource::Extrusion(source)).unwrap()
    }

    fn folds(mesh: &Mesh) -> Folds {
        Folds::of(mesh, &Directors::of(mesh, FOLD_ANGLE_DEGREES).unwrap())
    }

    #[test]
    fn smooth_sheets_have_none() {
        assert_eq!(folds(&extrusion(&[[0.0; 3], [1.0, 0.0, 0.0]], [4, 2])), Folds::default());
        let bent = extrusion(&[[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.3]], [4, 2]);
        assert_eq!(folds(&bent), Folds::default());
    }

    #[test]
    fn folds_are_lines_with_length_angle_and_ends() {
        let mesh = extrusion(
            &[[0.0; 3], [1.0, 0.0, 0.0], [1.0, 0.0, 1.0], [2.0, 0.0, 2.0], [3.0, 0.0, 2.0]],
            [8, 4],
        );
        let found = folds(&mesh);
        assert_eq!(found.lines.len(), 3);
        for (line, angle) in found.lines.iter().zip([90.0, 45.0, 45.0]) {
            let [low, high] = line.angles.unwrap();
            assert!((low - angle).abs() < 1e-9 && (high - angle).abs() < 1e-9, "{line:?}");
            assert!((line.edges, line.sheets) == (4, 2) && (line.length - 2.0).abs() < 1e-12, "{line:?}");
            let ends = line.ends.map(|n| mesh.positions[n as usize]);
            assert!(((ends[1] - ends[0]).norm() - 2.0).abs() < 1e-12, "{line:?}");
        }
        assert!((found.length() - 6.0).abs() < 1e-12);
        assert_eq!(found.prism, None);
    }

    #[test]
    fn a_closed_box_has_twelve_folds_and_a_tee_one_junction() {
        let node = |x: u32, y: u32, z: u32| x + 3 * y + 9 * z;
        let mut mesh = Mesh::default();
        for n in 0..27u32 {
            mesh.positions.push(Vec3::new(f64::from(n % 3), f64::from(n / 3 % 3), f64::from(n / 9)));
        }
        for i in 0..2 {
            for j in 0..2 {
                for (at, outside) in [(0, false), (2, true)] {
                    let quads: [[u32; 4]; 3] = [
                        [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(a, b)| node(i + a, j + b, at)),
                        [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(a, b)| node(at, i + a, j + b)),
                        [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(a, b)| node(j + b, at, i + a)),
                    ];
                    for mut quad in quads {
                        if !outside {
                            quad.reverse();
                        }
                        mesh.quads.push(quad);
                    }
                }
            }
        }
        let found = folds(&mesh);
        assert_eq!(found.lines.len(), 12);
        assert!(found.lines.iter().all(|l| l.edges == 2 && l.ends[0] != l.ends[1] && l.sheets == 2));
        // Another sheet at the edge x = z = 0.
        mesh.positions.extend([0.0, 1.0, 2.0].map(|y| Vec3::new(-1.0, y, -1.0)));
        mesh.quads.extend([[0, 3, 28, 27], [3, 6, 29, 28]]);
        let found = folds(&mesh);
        let junctions: Vec<&Fold> = found.lines.iter().filter(|l| l.sheets == 3).collect();
        assert_eq!((found.lines.len(), junctions.len()), (12, 1));
        assert_eq!((junctions[0].angles, junctions[0].ends), (None, [0, 6]));
    }

    #[test]
    fn coarse_arcs_are_told_from_profiles() {
        let arc = |degrees: f64, n: u32| -> Vec<[f64; 3]> {
            (0..=n).map(|k| (f64::from(k) * degrees).to_radians()).map(|t| [t.sin(), 0.0, t.cos()]).collect()
        };
        let mut coarse = extrusion(&arc(22.5, 4), [4, 2]);
        coarse.normals = None;
        let prism = folds(&coarse).prism.unwrap();
        assert_eq!(prism.quads, [1, 2, 5, 6]);
        assert!(prism.angles.iter().all(|a| (a - 22.5).abs() < 1e-9));
        // A zigzag, and a tube of six sides.
        let mut zigzag = extrusion(
            &[[0.0; 3], [1.0, 0.0, 0.2], [2.0, 0.0, 0.0], [3.0, 0.0, 0.2], [4.0, 0.0, 0.0]],
            [4, 2],
        );
        zigzag.normals = None;
        assert!(folds(&zigzag).lines.len() == 3 && folds(&zigzag).prism.is_none());
        let mut tube = extrusion(&arc(60.0, 5), [5, 2]);
        tube.normals = None;
        assert_eq!(folds(&tube).prism, None);
    }

    #[test]
    fn a_closed_line_has_its_first_node_twice() {
        // The rim of a cup: a bottom of four elements with walls around.
        let mut mesh = Mesh::default();
        for z in [0.0, 1.0] {
            for (x, y) in [(0, 0), (1, 0), (2, 0), (2, 1), (2, 2), (1, 2), (0, 2), (0, 1)] {
                mesh.positions.push(Vec3::new(f64::from(x), f64::from(y), z));
            }
        }
        mesh.positions.push(Vec3::new(1.0, 1.0, 0.0));
        mesh.quads = vec![[0, 1, 16, 7], [1, 2, 3, 16], [16, 3, 4, 5], [7, 16, 5, 6]];
        mesh.quads.extend((0..8).map(|k| [(k + 1) % 8, k, k + 8, (k + 1) % 8 + 8]));
        let rim: Vec<Fold> = folds(&mesh).lines.into_iter().filter(|l| l.edges == 8).collect();
        // Walls meet at the corners too, so that the rim is four lines of two edges.
        assert!(rim.is_empty());
        for k in 0..8 {
            let angle = (f64::from(k) * 45.0).to_radians();
            let (x, y) = (1.0 + 1.5 * angle.cos(), 1.0 + 1.5 * angle.sin());
            mesh.positions[(k as usize + 3) % 8] = Vec3::new(x, y, 0.0);
            mesh.positions[(k as usize + 3) % 8 + 8] = Vec3::new(x, y, 1.0);
        }
        let smooth = Directors::of(&mesh, 60.0).unwrap();
        let found = Folds::of(&mesh, &smooth);
        assert_eq!(found.lines.len(), 1);
        assert_eq!((found.lines[0].edges, found.lines[0].ends), (8, [0, 0]));
    }
}
