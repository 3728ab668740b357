//! Directors of a mesh: one per node on smooth surfaces, several where sheets meet at an angle.
//!
//! At each node the normals of the quads around are gathered into groups:
//! neighbours whose normals at the node differ by less than the fold angle join.
//! Each group gets one director, the mean of its normals weighted by the quads'
//! inner angles at the node (Thürmer & Wüthrich, J. Graphics Tools 3, 1998), which
//! does not depend on how finely the quads around the node are cut.
//! Groups at one node form a rigid cross: director-angle constraints tie them to each other.

use super::Mesh;
use super::facet::{Facet, angle_between, show};
use super::junction::{self, UNTIED_DEGREES};
use super::quality::{check_structure, report};
use super::topology::{Disjoint, Edges};
use crate::{Error, Issue, Result, Vec3};

pub use crate::model::FOLD_ANGLE_DEGREES;

/// Directors of a mesh.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Directors {
    /// Unit vector of each director; those of a node follow one another, nodes in ascending order.
    pub values: Vec<Vec3>,
    /// Node of each director.
    pub node: Vec<u32>,
    /// Director at each corner of each quad.
    pub corners: Vec<[u32; 4]>,
    /// Director-angle constraints: pairs of directors at one node whose angle is constant, nodes in ascending order.
    pub ties: Vec<Tie>,
    /// First director of each node; `u32::MAX` at nodes without quads.
    pub first: Vec<u32>,
}

/// Director-angle constraint: a pair of directors of one node whose angle is constant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tie {
    /// The directors.
    pub directors: [u32; 2],
    /// The node's share of the edges that both sheets have in common (length); 0 if they touch at the node only.
    pub length: f64,
}

impl Directors {
    /// Node of a tie.
    pub fn node_of(&self, tie: &Tie) -> u32 {
        self.node[tie.directors[0] as usize]
    }

    /// Directors of `mesh`, whose facets form a fold where they meet at `fold_angle_degrees` or more
    /// ([`FOLD_ANGLE_DEGREES`] is a good choice).
    ///
    /// The normal at a corner is `mesh.normals` where given, else the bilinear r,ξ × r,η.
    ///
    /// # Errors
    /// Fold angles outside 0…180; an invalid mesh (see [`super::quality::check`]), including neighbours of opposite
    /// orientation; elements without normal; nodes where normals cancel.
    pub fn of(mesh: &Mesh, fold_angle_degrees: f64) -> Result<Self> {
        if !(fold_angle_degrees > 0.0 && fold_angle_degrees <= 180.0) {
            return Err(Error::model(
                "mesh",
                format!("the fold angle is {fold_angle_degrees:?} degrees"),
                format!("give an angle above 0 and up to 180 degrees, {FOLD_ANGLE_DEGREES} for example"),
            ));
        }
        if mesh.quads.len() > (u32::MAX / 4) as usize {
            return Err(Error::model("mesh", "the mesh has over a thousand million elements", "use fewer"));
        }
        let edges = Edges::of(&mesh.quads);
        let issues = check_structure(mesh, &edges);
        if !issues.is_empty() {
            return Err(Error::Model(issues));
        }
        let normals = corner_normals(mesh)?;
        let fold_angle = fold_angle_degrees.to_radians();
        let mut joined = join_neighbours(mesh, &edges, &normals, fold_angle);
        gather(mesh, &normals, &mut joined, fold_angle)
    }
}

/// Unit normals at the corners of all quads, four per quad.
fn corner_normals(mesh: &Mesh) -> Result<Vec<Vec3>> {
    let mut normals = Vec::with_capacity(4 * mesh.quads.len());
    let mut missing = Vec::new();
    for (e, quad) in mesh.quads.iter().enumerate() {
        let exact = mesh.normals.as_ref().and_then(|normals| normals.get(e));
        let facet = Facet::of(mesh, quad);
        for corner in 0..4 {
            let normal = match (exact, &facet) {
                (Some(exact), _) => exact[corner],
                (None, Some(facet)) => facet_normal(facet, corner),
                (None, None) => Vec3::zeros(),
            };
            // Scaled first, so that small elements do not lose their normal.
            let unit = (normal / normal.amax()).normalize();
            if !unit.iter().all(|x| x.is_finite()) {
                missing.push((e, quad[corner]));
            }
            normals.push(unit);
        }
    }
    let mut issues = Vec::new();
    report(&mut issues, "corners without normal", &missing, |(e, node)| {
        let message =
            format!("element {} has no normal at node {}", mesh.quad_label(*e), mesh.node_label(*node));
        Issue::new("mesh", message, "move its nodes apart so that it has an area")
    });
    if issues.is_empty() { Ok(normals) } else { Err(Error::Model(issues)) }
}

impl Mesh {
    /// Unit normals of the bilinear facets at the corners of all quads; zero where a facet has none.
    pub(crate) fn facet_normals(&self) -> Vec<[Vec3; 4]> {
        let unit = |normal: Vec3| (normal / normal.amax()).try_normalize(0.0).unwrap_or_else(Vec3::zeros);
        let of_quad = |quad: &[u32; 4]| match Facet::of(self, quad) {
            Some(facet) => std::array::from_fn(|corner| unit(facet_normal(&facet, corner))),
            None => [Vec3::zeros(); 4],
        };
        self.quads.iter().map(of_quad).collect()
    }
}

/// Normal r,ξ × r,η at a corner; the mean normal where the corner is flat or reentrant.
fn facet_normal(facet: &Facet, corner: usize) -> Vec3 {
    let (normal, mean) = (facet.corner_normal(corner), facet.area_vector());
    if normal.dot(&mean) > 1e-9 * mean.norm_squared() { normal } else { mean }
}

/// Joins the corners at both ends of every edge whose normals differ by less than the fold angle.
fn join_neighbours(mesh: &Mesh, edges: &Edges, normals: &[Vec3], fold_angle: f64) -> Disjoint {
    let mut joined = Disjoint::new(4 * mesh.quads.len());
    for uses in edges.iter() {
        for (k, a) in uses.iter().enumerate() {
            for b in &uses[k + 1..] {
                for node in [a.low, a.high] {
                    let [a, b] = [a, b].map(|edge| 4 * edge.quad as usize + edge.corner_at(node));
                    if angle_between(&normals[a], &normals[b]) < fold_angle {
                        joined.join(a, b);
                    }
                }
            }
        }
    }
    joined
}

/// Corners at one node that share a director.
struct Group {
    /// Representative corner.
    root: usize,
    /// Sum of the weighted normals, and of the weights.
    sum: Vec3,
    weight: f64,
    /// Other ends of the edges at the node.
    neighbours: Vec<u32>,
}

impl Group {
    /// Half the length of the edges that two groups at a node have in common.
    fn common_length(&self, other: &Self, node: usize, mesh: &Mesh) -> f64 {
        let mut common: Vec<u32> =
            self.neighbours.iter().copied().filter(|end| other.neighbours.contains(end)).collect();
        common.sort_unstable();
        common.dedup();
        let lengths = common.iter().map(|&end| (mesh.positions[end as usize] - mesh.positions[node]).norm());
        0.5 * lengths.sum::<f64>()
    }
}

/// Averages the groups of each node and numbers them.
fn gather(mesh: &Mesh, normals: &[Vec3], joined: &mut Disjoint, fold_angle: f64) -> Result<Directors> {
    let (start, corners) = corners_of_nodes(mesh);
    let mut directors = Directors { corners: vec![[0; 4]; mesh.quads.len()], ..Directors::default() };
    let (mut cancelled, mut loose) = (Vec::new(), Vec::new());
    let mut groups: Vec<Group> = Vec::new();
    for node in 0..mesh.positions.len() {
        let here = &corners[start[node]..start[node + 1]];
        groups.clear();
        for &corner in here {
            let quad = &mesh.quads[corner / 4];
            let angle = Facet::of(mesh, quad).map_or(0.0, |facet| facet.corner_angle(corner % 4));
            // A corner of no angle still contributes, with a small weight.
            let weight = angle.max(1e-6);
            let ends = [quad[(corner + 1) % 4], quad[(corner + 3) % 4]];
            let root = joined.root(corner);
            let found = groups.iter().position(|group| group.root == root);
            let found = found.unwrap_or_else(|| {
                groups.push(Group { root, sum: Vec3::zeros(), weight: 0.0, neighbours: Vec::new() });
                groups.len() - 1
            });
            let group = &mut groups[found];
            group.sum += normals[corner] * weight;
            group.weight += weight;
            group.neighbours.extend(ends);
        }
        join_touching(&mut groups, joined, fold_angle);
        let first = directors.values.len() as u32;
        directors.first.push(if here.is_empty() { u32::MAX } else { first });
        for group in &groups {
            if group.sum.norm() <= 1e-6 * group.weight {
                cancelled.push(node);
            }
            if let Some(other) = untied(group, &groups)
                && loose.last().is_none_or(|&(last, _)| last != node)
            {
                loose.push((node, [group.root / 4, other.root / 4]));
            }
            directors.values.push(group.sum.normalize());
            directors.node.push(node as u32);
        }
        for &corner in here {
            let root = joined.root(corner);
            let found = groups.iter().position(|group| group.root == root).unwrap_or_default();
            directors.corners[corner / 4][corner % 4] = first + found as u32;
        }
        let values = &directors.values[first as usize..];
        for ([i, j], length) in junction::ties(values, |i, j| groups[i].common_length(&groups[j], node, mesh))
        {
            directors.ties.push(Tie { directors: [i, j].map(|k| first + k as u32), length });
        }
    }
    let mut issues = Vec::new();
    report(&mut issues, "nodes where the normals cancel", &cancelled, |&node| {
        Issue::new(
            "mesh",
            format!(
                "the normals of the elements at node {} at {} cancel",
                mesh.node_label(node as u32),
                show(mesh.positions[node])
            ),
            "orient the elements around the node alike, or refine the mesh there",
        )
    });
    report(&mut issues, "nodes at which sheets lie on one another", &loose, |(node, quads)| {
        let [a, b] = quads.map(|quad| mesh.quad_label(quad));
        let message = format!(
            "at node {} at {} the surface is folded back: the sheets of elements {a} and {b} lie on one another",
            mesh.node_label(*node as u32),
            show(mesh.positions[*node])
        );
        Issue::new("mesh", message, "open the fold by more than a degree, or remove one of the elements")
    });
    if issues.is_empty() { Ok(directors) } else { Err(Error::Model(issues)) }
}

/// Group that has an edge in common with this one, if all others are parallel to it within a degree: d₁·d₂ does not
/// change to first order there, so that no director-angle constraint would hold it.
fn untied<'a>(group: &Group, groups: &'a [Group]) -> Option<&'a Group> {
    let parallel = |other: &Group| {
        let (a, b) = (group.sum.normalize(), other.sum.normalize());
        a.cross(&b).norm() < UNTIED_DEGREES.to_radians().sin()
    };
    let shares = |other: &&Group| group.neighbours.iter().any(|node| other.neighbours.contains(node));
    let mut others = groups.iter().filter(|other| other.root != group.root);
    others.clone().all(parallel).then(|| others.find(shares)).flatten()
}

/// Joins groups that touch at the node only, without a common edge, and have equal directions: a director-angle
/// constraint could not tie two nearly parallel directors.
fn join_touching(groups: &mut Vec<Group>, joined: &mut Disjoint, fold_angle: f64) {
    let mut b = 1;
    while b < groups.len() {
        let other = &groups[b];
        let twin = groups[..b].iter().position(|group| {
            angle_between(&group.sum, &other.sum) < fold_angle
                && !group.neighbours.iter().any(|node| other.neighbours.contains(node))
        });
        if let Some(a) = twin {
            let other = groups.remove(b);
            joined.join(groups[a].root, other.root);
            groups[a].root = joined.root(other.root);
            groups[a].sum += other.sum;
            groups[a].weight += other.weight;
            groups[a].neighbours.extend(other.neighbours);
        } else {
            b += 1;
        }
    }
}

/// Corners (4 × quad + corner) at each node: those of node n are `corners[start[n]..start[n + 1]]`.
fn corners_of_nodes(mesh: &Mesh) -> (Vec<usize>, Vec<usize>) {
    let mut start = vec![0; mesh.positions.len() + 1];
    for &node in mesh.quads.iter().flatten() {
        start[node as usize + 1] += 1;
    }
    for node in 0..mesh.positions.len() {
        start[node + 1] += start[node];
    }
    let mut next = start.clone();
    let mut corners = vec![0; 4 * mesh.quads.len()];
    for (corner, &node) in mesh.quads.iter().flatten().enumerate() {
        corners[next[node as usize]] = corner;
        next[node as usize] += 1;
    }
    (start, corners)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;
