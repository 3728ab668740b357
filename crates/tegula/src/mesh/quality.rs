//! Mesh checks: whether a mesh is valid, and how well shaped its elements are.
//!
//! Thresholds are relative to each element's own size. Messages number elements and
//! nodes as the mesh file does; those of a generated mesh are counted from 0.

use std::collections::HashMap;

use super::Mesh;
use super::facet::{Facet, angle_between, show};
use super::topology::{EdgeUse, Edges};
use crate::Issue;

/// Number of issues of one kind that are written out.
const SHOWN: usize = 20;

/// Areas and Jacobians below this part of the squared diagonal are zero.
const FLAT: f64 = 1e-10;

/// Angle between the normals of neighbours (degrees) above which they lie on one another. The angle between their
/// directors could not tie them: its derivative, the sine, is below 2 % there.
const FOLDED_BACK_DEGREES: f64 = 179.0;

/// Issues that make a mesh unusable, in the order: no elements, coordinates, elements, neighbours, sets. Empty for a
/// good mesh.
pub fn check(mesh: &Mesh) -> Vec<Issue> {
    let edges = Edges::of(&mesh.quads);
    let mut issues = check_structure(mesh, &edges);
    check_shapes(mesh, &mut issues);
    check_duplicates(mesh, &mut issues);
    check_folds(mesh, &edges, &mut issues);
    check_sets(mesh, &mut issues);
    issues
}

/// Issues of the mesh structure that prevent any check of directors: elements must exist, with four different existing
/// nodes at finite positions, and neighbours must be oriented alike.
pub(super) fn check_structure(mesh: &Mesh, edges: &Edges) -> Vec<Issue> {
    let mut issues = Vec::new();
    if mesh.quads.is_empty() {
        issues.push(Issue::new(
            "mesh",
            "the mesh has no quadrilaterals",
            "mesh its surfaces with four-node quadrilaterals (in Gmsh: recombine, first order)",
        ));
    }
    if let Some(normals) = mesh.normals.as_ref().filter(|normals| normals.len() != mesh.quads.len()) {
        issues.push(Issue::new(
            "mesh",
            format!("the mesh has {} elements but normals for {}", mesh.quads.len(), normals.len()),
            "give normals for all elements or none",
        ));
    }
    let places: Vec<usize> =
        (0..mesh.positions.len()).filter(|&n| !mesh.positions[n].iter().all(|x| x.is_finite())).collect();
    report(&mut issues, "nodes without finite coordinates", &places, |&n| {
        let message = format!("node {} is at {}", mesh.node_label(n as u32), show(mesh.positions[n]));
        Issue::new("mesh", message, "give finite coordinates")
    });
    let elements = || (0usize..).zip(&mesh.quads);
    let outside: Vec<_> = elements().filter(|(_, quad)| Facet::of(mesh, quad).is_none()).collect();
    report(&mut issues, "elements with unknown nodes", &outside, |(e, quad)| {
        let node = quad.iter().max().copied().unwrap_or_default();
        let message = format!(
            "element {} has a node {node}, but the mesh has {} nodes",
            mesh.quad_label(*e),
            mesh.positions.len()
        );
        Issue::new("mesh", message, "use nodes of the mesh")
    });
    let repeated: Vec<_> = elements().filter_map(|(e, quad)| Some((e, repeated_node(quad)?))).collect();
    report(&mut issues, "elements with a repeated node", &repeated, |(e, node)| {
        let message = format!("{} has the node {} twice", element(mesh, *e), mesh.node_label(*node));
        Issue::new("mesh", message, "triangles are not supported: recombine the mesh into quadrilaterals")
    });
    let opposite = edges.opposite_neighbours(&mesh.quads);
    report(&mut issues, "pairs of neighbours of opposite orientation", &opposite, |[a, b]| {
        let message = format!(
            "elements {} and {} share the edge of nodes {} and {} but have their directors on opposite sides",
            named(mesh, a.quad as usize),
            named(mesh, b.quad as usize),
            mesh.node_label(a.low),
            mesh.node_label(a.high)
        );
        Issue::new(
            "mesh",
            message,
            "flip one of them, and those it belongs with, by reversing the node order",
        )
    });
    issues
}

/// Issues of collapsed and inverted elements.
fn check_shapes(mesh: &Mesh, issues: &mut Vec<Issue>) {
    let mut collapsed = Vec::new();
    let mut concave = Vec::new();
    for (e, quad) in mesh.quads.iter().enumerate() {
        let Some(facet) = Facet::of(mesh, quad) else { continue };
        if repeated_node(quad).is_some() || facet.x.iter().flatten().any(|x| !x.is_finite()) {
            continue;
        }
        let area = facet.area_vector();
        let flat = FLAT * facet.diagonal().powi(2);
        // An undefined area (overflow) counts as zero.
        if area.norm() > flat {
            let mean = area.normalize();
            if let Some(corner) = (0..4).find(|&k| facet.corner_normal(k).dot(&mean) <= flat) {
                concave.push((e, quad[corner]));
            }
        } else {
            collapsed.push(e);
        }
    }
    report(issues, "collapsed elements", &collapsed, |&e| {
        Issue::new(
            "mesh",
            format!("{} has no area", element(mesh, e)),
            "move its nodes apart, and let them run round the element, or remove it",
        )
    });
    report(issues, "inside-out or concave elements", &concave, |&(e, node)| {
        Issue::new(
            "mesh",
            format!(
                "{} has an inner angle of 180° or more at node {}",
                element(mesh, e),
                mesh.node_label(node)
            ),
            "move its nodes so that it is convex, and let them run round the element",
        )
    });
}

/// Issues of elements on equal sets of four nodes.
fn check_duplicates(mesh: &Mesh, issues: &mut Vec<Issue>) {
    let mut first = HashMap::with_capacity(mesh.quads.len());
    let mut duplicates = Vec::new();
    for (e, quad) in mesh.quads.iter().enumerate() {
        let original = *first.entry(sorted(quad)).or_insert(e);
        if original != e {
            duplicates.push((original, e));
        }
    }
    report(issues, "elements given twice", &duplicates, |&(original, e)| {
        Issue::new(
            "mesh",
            format!("elements {} and {} have the same four nodes", mesh.quad_label(original), named(mesh, e)),
            "remove one of them; give one thickness that counts for both",
        )
    });
}

/// Issues of neighbours that lie on one another: the surface is folded back along their common edge.
fn check_folds(mesh: &Mesh, edges: &Edges, issues: &mut Vec<Issue>) {
    let flattest = FOLDED_BACK_DEGREES.to_radians();
    let normal = |edge: &EdgeUse, node| {
        let quad = mesh.quads.get(edge.quad as usize)?;
        Some(Facet::of(mesh, quad)?.corner_normal(edge.corner_at(node)))
    };
    let mut folded = Vec::new();
    for uses in edges.iter() {
        // Neighbours of opposite orientation and elements given twice have issues of their own; where three or
        // more meet, the others hold the angle.
        let [a, b] = uses else { continue };
        let back = |node| match (normal(a, node), normal(b, node)) {
            (Some(n), Some(m)) => angle_between(&n, &m) >= flattest,
            _ => false,
        };
        let alike = |edge: &EdgeUse| mesh.quads.get(edge.quad as usize).map(sorted);
        if a.forward != b.forward && alike(a) != alike(b) && (back(a.low) || back(a.high)) {
            folded.push((*a, *b));
        }
    }
    report(issues, "pairs of elements that lie on one another", &folded, |(a, b)| {
        let message = format!(
            "elements {} and {} share the edge of nodes {} and {} and lie on one another: the surface is folded back there",
            named(mesh, a.quad as usize),
            named(mesh, b.quad as usize),
            mesh.node_label(a.low),
            mesh.node_label(a.high)
        );
        Issue::new("mesh", message, "remove one of them, or open the fold by more than a degree")
    });
}

/// Issues of empty sets and of sets of things that do not exist.
fn check_sets(mesh: &Mesh, issues: &mut Vec<Issue>) {
    let nodes = mesh.node_sets.iter().map(|(name, set)| (name, "node", set.len(), set.iter().max().copied()));
    let edges = mesh
        .edge_sets
        .iter()
        .map(|(name, set)| (name, "edge", set.len(), set.iter().flatten().max().copied()));
    let quads =
        mesh.quad_sets.iter().map(|(name, set)| (name, "element", set.len(), set.iter().max().copied()));
    let mut empty = Vec::new();
    let mut outside = Vec::new();
    for (name, kind, length, largest) in nodes.chain(edges).chain(quads) {
        let (entries, count) =
            if kind == "element" { ("element", mesh.quads.len()) } else { ("node", mesh.positions.len()) };
        // Sets that the model picks by place may hold nodes, say, and no edges.
        if length == 0 && !holds_others(mesh, name) {
            empty.push((name, kind));
        }
        if let Some(largest) = largest.filter(|&largest| largest as usize >= count) {
            outside.push((name, kind, entries, largest, count));
        }
    }
    report(issues, "empty sets", &empty, |(name, kind)| {
        Issue::new("mesh", format!("the {kind} set `{name}` is empty"), "remove it or put something into it")
    });
    report(
        issues,
        "sets of things the mesh does not have",
        &outside,
        |(name, kind, entries, largest, count)| {
            let message =
                format!("the {kind} set `{name}` has the {entries} {largest}, but the mesh has {count}");
            Issue::new("mesh", message, format!("use {entries}s of the mesh"))
        },
    );
}

/// Whether some set of this name holds something.
fn holds_others(mesh: &Mesh, name: &str) -> bool {
    mesh.node_sets.get(name).is_some_and(|set| !set.is_empty())
        || mesh.edge_sets.get(name).is_some_and(|set| !set.is_empty())
        || mesh.quad_sets.get(name).is_some_and(|set| !set.is_empty())
}

/// Writes out the first issues of a kind and counts the others.
pub(super) fn report<T>(issues: &mut Vec<Issue>, kind: &str, found: &[T], write: impl Fn(&T) -> Issue) {
    issues.extend(found.iter().take(SHOWN).map(write));
    if found.len() > SHOWN {
        let message = format!("and {} more {kind}", found.len() - SHOWN);
        issues.push(Issue::new("mesh", message, "see those written out above"));
    }
}

/// "17 at (x, y, z)", the number and the centre of an element.
fn named(mesh: &Mesh, element: usize) -> String {
    let facet = mesh.quads.get(element).and_then(|quad| Facet::of(mesh, quad));
    let place = facet.map(|facet| format!(" at {}", show(facet.center()))).unwrap_or_default();
    format!("{}{place}", mesh.quad_label(element))
}

/// "element 17 at (x, y, z)".
fn element(mesh: &Mesh, element: usize) -> String {
    format!("element {}", named(mesh, element))
}

fn sorted(quad: &[u32; 4]) -> [u32; 4] {
    let mut nodes = *quad;
    nodes.sort_unstable();
    nodes
}

fn repeated_node(quad: &[u32; 4]) -> Option<u32> {
    (1..4).find(|&k| quad[..k].contains(&quad[k])).map(|k| quad[k])
}

/// Shape quality of the elements of a mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quality {
    /// Area of the smallest element, projected on its mean plane (length²).
    pub min_area: f64,
    /// Largest ratio of longest to shortest side of an element; 1 for squares.
    pub max_aspect: f64,
    /// Largest distance of an element's corners from its mean plane, relative to the square root of its area.
    pub max_warp: f64,
    /// Smallest inner angle (degrees); 90 for rectangles.
    pub min_angle_deg: f64,
    /// Largest inner angle (degrees); 90 for rectangles.
    pub max_angle_deg: f64,
}

/// Extremes of the shapes of all elements; without elements, those of a square of zero area.
pub fn quality(mesh: &Mesh) -> Quality {
    let mut quality = Quality {
        min_area: f64::INFINITY,
        max_aspect: 1.0,
        max_warp: 0.0,
        min_angle_deg: 90.0,
        max_angle_deg: 90.0,
    };
    for facet in mesh.quads.iter().filter_map(|quad| Facet::of(mesh, quad)) {
        let area_vector = facet.area_vector();
        let area = area_vector.norm();
        let sides = [0, 1, 2, 3].map(|k| facet.side(k));
        let angles = [0, 1, 2, 3].map(|k| facet.corner_angle(k).to_degrees());
        let [longest, largest_angle] = [sides, angles].map(|x| x.into_iter().fold(0.0, crate::norm::larger));
        let [shortest, smallest_angle] = [sides, angles].map(|x| x.into_iter().fold(f64::INFINITY, f64::min));
        // The corners lie above and below the mean plane in turn, by half the distance of the diagonals.
        let height = 0.5 * (facet.x[1] - facet.x[0]).dot(&area_vector).abs() / area;
        quality.min_area = quality.min_area.min(area);
        quality.max_aspect = quality.max_aspect.max(longest / shortest);
        quality.max_warp = quality.max_warp.max(height / area.sqrt());
        quality.min_angle_deg = quality.min_angle_deg.min(smallest_angle);
        quality.max_angle_deg = quality.max_angle_deg.max(largest_angle);
    }
    if quality.min_area.is_infinite() {
        quality.min_area = 0.0;
    }
    quality
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::Vec3;

    /// n by n unit squares, nodes u fastest.
    fn squares(n: u32) -> Mesh {
        let node = |i, j| j * (n + 1) + i;
        let positions =
            (0..=n).flat_map(|j| (0..=n).map(move |i| Vec3::new(f64::from(i), f64::from(j), 0.0)));
        let quads = (0..n).flat_map(|j| {
            (0..n).map(move |i| [node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)])
        });
        Mesh { positions: positions.collect(), quads: quads.collect(), ..Mesh::default() }
    }

    fn only(mesh: &Mesh, part: &str) {
        let issues = check(mesh);
        assert_eq!(issues.len(), 1, "{issues:?}");
        assert!(issues[0].message.contains(part), "{}", issues[0]);
    }

    #[test]
    fn good_mesh_has_no_issues() {
        assert!(check(&squares(3)).is_empty());
        let quality = quality(&squares(3));
        assert_eq!((quality.min_area, quality.max_aspect, quality.max_warp), (1.0, 1.0, 0.0));
        assert!((quality.min_angle_deg - 90.0).abs() < 1e-12 && (quality.max_angle_deg - 90.0).abs() < 1e-12);
    }

    #[test]
    fn each_fault_is_found() {
        only(&Mesh::default(), "no quadrilaterals");

        let mut mesh = squares(2);
        mesh.positions[4].x = f64::NAN;
        only(&mesh, "node 4 is at (NaN, 1.0, 0.0)");

        let mut mesh = squares(2);
        mesh.quads[3][2] = 99;
        only(&mesh, "element 3 has a node 99");

        let mut mesh = squares(2);
        mesh.quads[3] = [4, 5, 8, 8];
        only(&mesh, "element 3 at (1.75, 1.5, 0.0) has the node 8 twice");

        let mut mesh = squares(1);
        mesh.positions[3] = Vec3::new(1.0, 0.0, 0.0);
        mesh.positions[2] = Vec3::new(0.0, 0.0, 0.0);
        only(&mesh, "element 0 at (0.5, 0.0, 0.0) has no area");

        let mut mesh = squares(1);
        mesh.positions[3] = Vec3::new(0.3, 0.3, 0.0);
        only(&mesh, "element 0 at (0.325, 0.325, 0.0) has an inner angle of 180° or more at node 3");

        let mut mesh = squares(1);
        mesh.positions[3] = Vec3::new(0.5, 0.5, 0.0);
        only(&mesh, "180° or more at node 3");

        let mut mesh = squares(2);
        mesh.quads[0].reverse();
        let issues = check(&mesh);
        assert_eq!(issues.len(), 2);
        assert!(issues[0].message.contains("elements 0 at (0.5, 0.5, 0.0) and 1 at"), "{}", issues[0]);
        assert!(issues[0].help.contains("flip"));

        let mut mesh = squares(2);
        mesh.quads.push([4, 3, 0, 1]);
        only(&mesh, "elements 0 and 4 at (0.5, 0.5, 0.0) have the same four nodes");

        // Element 1 lies on element 0 and shares its edge of nodes 1 and 2 only.
        let mut mesh = squares(1);
        mesh.positions.extend([mesh.positions[0], mesh.positions[2]]);
        mesh.quads.push([3, 1, 4, 5]);
        only(
            &mesh,
            "elements 0 at (0.5, 0.5, 0.0) and 1 at (0.5, 0.5, 0.0) share the edge of nodes 1 and 3 and lie on one another",
        );
        mesh.positions[4].z = 0.1;
        mesh.positions[5].z = 0.1;
        assert!(check(&mesh).is_empty());

        let mut mesh = squares(2);
        mesh.normals = Some(Vec::new());
        only(&mesh, "4 elements but normals for 0");
    }

    #[test]
    fn sets_are_checked() {
        let mut mesh = squares(1);
        mesh.node_sets.insert("empty".into(), vec![]);
        mesh.node_sets.insert("nodes".into(), vec![4]);
        mesh.edge_sets.insert("edges".into(), vec![[0, 1], [1, 9]]);
        mesh.quad_sets.insert("quads".into(), vec![1]);
        let messages: Vec<String> = check(&mesh).into_iter().map(|issue| issue.message).collect();
        assert_eq!(
            messages,
            [
                "the node set `empty` is empty",
                "the node set `nodes` has the node 4, but the mesh has 4",
                "the edge set `edges` has the node 9, but the mesh has 4",
                "the element set `quads` has the element 1, but the mesh has 1",
            ]
        );
    }

    #[test]
    fn many_issues_are_counted() {
        let mut mesh = squares(10);
        for position in &mut mesh.positions {
            position.z = f64::INFINITY;
        }
        let issues = check(&mesh);
        assert_eq!(issues.len(), SHOWN + 1);
        assert_eq!(issues[SHOWN].message, "and 101 more nodes without finite coordinates");
    }

    #[test]
    fn warp_and_aspect_are_measured() {
        let mut mesh = squares(1);
        for (position, height) in mesh.positions.iter_mut().zip([0.1, -0.1, -0.1, 0.1]) {
            position.z = height;
            position.x *= 4.0;
        }
        let quality = quality(&mesh);
        assert!((quality.max_warp - 0.1 / 2.0).abs() < 1e-12, "{quality:?}");
        assert!((quality.max_aspect - (16.04f64 / 1.04).sqrt()).abs() < 1e-12, "{quality:?}");
    }

    proptest! {
        #[test]
        fn any_mesh_is_checked_without_panic(
            positions in prop::collection::vec(prop::array::uniform3(prop_oneof![
                -2.0f64..2.0, Just(0.0), Just(f64::NAN), Just(1e300), Just(f64::INFINITY)
            ]), 0..6),
            quads in prop::collection::vec(prop::array::uniform4(0u32..7), 0..6),
        ) {
            let mesh = Mesh { positions: positions.into_iter().map(Vec3::from).collect(), quads, ..Mesh::default() };
            check(&mesh);
            quality(&mesh);
            mesh.extent();
            mesh.nearest_node(Vec3::zeros());
        }

        #[test]
        fn faults_do_not_depend_on_units(exponent in -60i32..60) {
            let scale = 10f64.powi(exponent);
            prop_assert!(check(&squares(2).scaled(scale)).is_empty());
            let mut mesh = squares(1);
            mesh.positions[3] = Vec3::new(0.3, 0.3, 0.0);
            prop_assert_eq!(check(&mesh.scaled(scale)).len(), 1);
        }
    }
}
