//! Seams: parts of a mesh that touch without being connected.
//!
//! Parts meshed apart have nodes of their own along their common edge: nodes that coincide, and nodes that lie on an
//! element of the other part where the division differs (hanging nodes). Nothing connects them, and the parts move
//! apart without any error.

use rayon::prelude::*;

use super::Mesh;
use super::facet::Facet;
use super::point_tree::PointTree;
use super::topology::{Disjoint, Edges};
use crate::{Issue, Vec3};

/// Nodes coincide where they are nearer than this part of the shortest edge at either of them; a node lies on an element
/// where it is nearer than this part of its shortest side.
pub const COINCIDENT: f64 = 1e-3;

/// A boundary node lies on a boundary edge of another part where it is nearer than this part of its length, as the chord of
/// an arc of nine degrees is to the arc, and nearer than `NARROW` of the element's shortest side.
const ON_BOUNDARY: f64 = 2e-2;
const NARROW: f64 = 0.1;

/// Hanging node: a node on an element that does not have it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Hanging {
    /// The node, on the boundary of its own sheet.
    pub node: u32,
    /// An element on which it lies.
    pub quad: u32,
}

/// Seam: nodes along which parts of a mesh, or parts of one sheet, touch without being connected.
#[derive(Debug, Clone, PartialEq)]
pub struct Seam {
    /// Pairs of nodes at one place.
    pub coincident: Vec<[u32; 2]>,
    /// Nodes on elements that do not have them and none that coincides with them.
    pub hanging: Vec<Hanging>,
    /// Least and largest coordinates of the seam's nodes (length).
    pub extent: [Vec3; 2],
}

impl Mesh {
    /// Pairs of different nodes of quads that coincide, ascending.
    pub fn coincident_nodes(&self) -> Vec<[u32; 2]> {
        let spacing = spacing(self);
        let used = || (0u32..).zip(&spacing).filter(|(_, size)| size.is_finite());
        let tree = PointTree::of(used().map(|(n, _)| (n, self.positions[n as usize])).collect());
        let nodes: Vec<u32> = used().map(|(n, _)| n).collect();
        let mut pairs: Vec<[u32; 2]> = nodes
            .par_iter()
            .flat_map_iter(|&a| {
                let (x, size) = (self.positions[a as usize], spacing[a as usize]);
                let reach = Vec3::repeat(COINCIDENT * size);
                let mut found = Vec::new();
                tree.within(&(x - reach), &(x + reach), |b, y| {
                    let near = COINCIDENT * size.min(spacing[b as usize]);
                    if b != a && (y - x).norm() <= near {
                        found.push([a.min(b), a.max(b)]);
                    }
                });
                found
            })
            .collect();
        pairs.sort_unstable();
        pairs.dedup();
        pairs
    }

    /// Seams along which sheets touch without being connected, in the order of their first nodes.
    pub fn seams(&self) -> Vec<Seam> {
        let edges = Edges::of(&self.quads);
        let coincident = self.coincident_nodes();
        let hanging = hanging(self, &edges, &coincident);
        if coincident.is_empty() && hanging.is_empty() {
            return Vec::new();
        }
        // Seams are sets of nodes; neighbours along an edge belong to one seam.
        let mut joined = Disjoint::new(self.positions.len());
        let mut on_seam = vec![false; self.positions.len()];
        for &[a, b] in &coincident {
            joined.join(a as usize, b as usize);
            (on_seam[a as usize], on_seam[b as usize]) = (true, true);
        }
        hanging.iter().for_each(|h| on_seam[h.node as usize] = true);
        for edge in edges.iter().map(|uses| uses[0].nodes().map(|n| n as usize)) {
            if on_seam[edge[0]] && on_seam[edge[1]] {
                joined.join(edge[0], edge[1]);
            }
        }
        let mut seams: Vec<Seam> = Vec::new();
        let mut of_root = vec![usize::MAX; self.positions.len()];
        let mut seam_of = |node: u32, seams: &mut Vec<Seam>| {
            let number = &mut of_root[joined.root(node as usize)];
            if *number == usize::MAX {
                *number = seams.len();
                let x = self.positions[node as usize];
                seams.push(Seam { coincident: Vec::new(), hanging: Vec::new(), extent: [x, x] });
            }
            let (seam, x) = (&mut seams[*number], self.positions[node as usize]);
            seam.extent = [seam.extent[0].inf(&x), seam.extent[1].sup(&x)];
            *number
        };
        for pair in coincident {
            let seam = seam_of(pair[0], &mut seams);
            seams[seam].coincident.push(pair);
        }
        for h in hanging {
            let seam = seam_of(h.node, &mut seams);
            seams[seam].hanging.push(h);
        }
        seams
    }

    /// Merges nodes that coincide and returns how many are removed; sets, numbers and thicknesses follow. The first of
    /// several nodes stays where it is.
    ///
    /// # Errors
    /// Elements would lose a side.
    pub fn merge_coincident_nodes(&mut self) -> Result<usize, Vec<Issue>> {
        let pairs = self.coincident_nodes();
        let mut joined = Disjoint::new(self.positions.len());
        pairs.iter().for_each(|&[a, b]| joined.join(a as usize, b as usize));
        let root: Vec<u32> = (0..self.positions.len()).map(|n| joined.root(n) as u32).collect();
        let of = |node: u32| root.get(node as usize).copied().unwrap_or(node);
        let mut collapsed = Vec::new();
        for (e, quad) in self.quads.iter().enumerate() {
            let nodes = quad.map(of);
            if let Some(k) = (1..4).find(|&k| nodes[..k].contains(&nodes[k])) {
                collapsed.push((e, quad[k]));
            }
        }
        let mut issues = Vec::new();
        super::quality::report(
            &mut issues,
            "elements that merging would collapse",
            &collapsed,
            |&(e, node)| {
                let message = format!(
                    "merging coincident nodes would collapse element {} at node {}",
                    self.quad_label(e),
                    self.node_label(node)
                );
                Issue::new("mesh", message, "move the nodes of the element apart, or remove it")
            },
        );
        if !issues.is_empty() {
            return Err(issues);
        }
        let kept: Vec<bool> = root.iter().enumerate().map(|(n, &r)| n == r as usize).collect();
        let mut count = 0;
        let number: Vec<u32> = kept
            .iter()
            .map(|&keep| {
                count += u32::from(keep);
                count.saturating_sub(1)
            })
            .collect();
        self.renumber(&kept, |node| number.get(of(node) as usize).copied().unwrap_or(node));
        Ok(kept.len() - count as usize)
    }

    /// Removes the nodes that are not `kept` and gives the others their new numbers.
    fn renumber(&mut self, kept: &[bool], new: impl Fn(u32) -> u32) {
        fn keep<T>(list: &mut Vec<T>, kept: &[bool]) {
            let mut flags = kept.iter();
            list.retain(|_| flags.next().copied().unwrap_or(true));
        }
        keep(&mut self.positions, kept);
        if let Some(thickness) = &mut self.thickness {
            keep(thickness, kept);
        }
        if let Some(labels) = &mut self.labels {
            keep(&mut labels.nodes, kept);
        }
        self.fields.nodes.values_mut().for_each(|values| keep(values, kept));
        self.quads.iter_mut().flatten().for_each(|n| *n = new(*n));
        self.edge_sets.values_mut().flatten().flatten().for_each(|n| *n = new(*n));
        let mut last_set = vec![u32::MAX; self.positions.len()];
        for (number, set) in (0u32..).zip(self.node_sets.values_mut()) {
            set.iter_mut().for_each(|n| *n = new(*n));
            set.retain(|&n| {
                last_set.get_mut(n as usize).is_none_or(|last| std::mem::replace(last, number) != number)
            });
        }
    }
}

/// Length of the shortest edge at each node; infinite at nodes without quads.
fn spacing(mesh: &Mesh) -> Vec<f64> {
    let mut spacing = vec![f64::INFINITY; mesh.positions.len()];
    for quad in &mesh.quads {
        let Some(facet) = Facet::of(mesh, quad) else { continue };
        for k in 0..4 {
            let side = facet.side(k);
            for node in [quad[k], quad[(k + 1) % 4]] {
                let size = &mut spacing[node as usize];
                *size = size.min(side);
            }
        }
    }
    spacing
}

/// Boundary nodes that lie on elements which neither have them nor a node that coincides with them, ascending.
fn hanging(mesh: &Mesh, edges: &Edges, coincident: &[[u32; 2]]) -> Vec<Hanging> {
    let mut boundary = vec![false; mesh.positions.len()];
    let mut free_sides = vec![[false; 4]; mesh.quads.len()];
    for side in edges.iter().filter(|uses| uses.len() == 1).map(|uses| uses[0]) {
        side.nodes().iter().for_each(|&n| boundary[n as usize] = true);
        free_sides[side.quad as usize][usize::from(side.side)] = true;
    }
    let mut joined = Disjoint::new(mesh.positions.len());
    coincident.iter().for_each(|&[a, b]| joined.join(a as usize, b as usize));
    let place: Vec<u32> = (0..mesh.positions.len()).map(|n| joined.root(n) as u32).collect();
    let points = (0u32..).zip(&boundary).filter(|(_, b)| **b).map(|(n, _)| (n, mesh.positions[n as usize]));
    let tree = PointTree::of(points.collect());
    let mut found: Vec<Hanging> = (0..mesh.quads.len())
        .into_par_iter()
        .flat_map_iter(|e| {
            let mut found = Vec::new();
            let quad = &mesh.quads[e];
            if let Some(facet) = Facet::of(mesh, quad) {
                let own = quad.map(|n| place[n as usize]);
                let reach = Vec3::repeat(ON_BOUNDARY * facet.diagonal());
                let (low, high) =
                    facet.x.iter().fold((facet.x[0], facet.x[0]), |(low, high), x| (low.inf(x), high.sup(x)));
                tree.within(&(low - reach), &(high + reach), |node, x| {
                    if !own.contains(&place[node as usize]) && touches(&facet, &free_sides[e], x) {
                        found.push(Hanging { node, quad: e as u32 });
                    }
                });
            }
            found
        })
        .collect();
    found.sort_unstable();
    found.dedup_by_key(|h| h.node);
    found
}

/// True if a point lies on a free side of an element, or on the element.
fn touches(facet: &Facet, free: &[bool; 4], point: &Vec3) -> bool {
    let shortest = (0..4).map(|k| facet.side(k)).fold(f64::INFINITY, f64::min);
    let on_side = |k: usize| {
        let (a, b) = (facet.x[k], facet.x[(k + 1) % 4]);
        let along = b - a;
        let t = (point - a).dot(&along) / along.norm_squared();
        let free = (ON_BOUNDARY * along.norm()).min(NARROW * shortest);
        (0.0..=1.0).contains(&t) && (a + along * t - point).norm() <= free
    };
    (0..4).any(|k| free[k] && on_side(k))
        || facet.distance_inside(point).is_some_and(|distance| distance <= COINCIDENT * shortest)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;
