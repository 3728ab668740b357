//! Middle surface of a layer of solids: its normals, and what its curvature explains of the edges through the thickness.
//!
//! The normal at a node inside the surface is the mean of those of the facets around, each over its area, as a narrow facet is nearer to the surface. At a rim
//! there are facets to one side alone, and the normal may differ from theirs as much as theirs from those beside, in the direction of that turn.

use std::collections::HashSet;

use super::Mesh;
use super::facet::{Facet, angle_between};
use super::topology::{EdgeUse, Edges};
use crate::Vec3;
use crate::norm::larger;

/// Angle of an edge to the normal (degrees) that is refused, beside a part of the angle by which a curved surface turns there: 0.4 % of the bending stiffness.
const OBLIQUE: f64 = 3.0;
/// Part of the largest angle between a facet and the normal that may be an error of the normal at nodes inside of the surface.
const OF_TURN_INSIDE: f64 = 0.25;
/// Part of the largest angle between neighbouring facets that may lie between a facet and the normal at a rim, which leans away from the facets beside; it is
/// half of it for facets of equal size.
const OF_TURN_AT_RIM: f64 = 0.75;
/// Angle between neighbouring facets (degrees) from which on they are sheets that meet at an edge, and no curved surface: the edges through the thickness are the
/// directors, and one director for both sheets leaves an error of 2 % of the flexibility at this angle where each sheet has one element.
pub(crate) const FOLD: f64 = 30.0;

/// Middle surface of a layer.
pub(crate) struct MiddleSurface<'a> {
    /// The mesh, whose quads are its facets.
    pub mesh: &'a Mesh,
    /// Directions of the edges through the thickness at the corners of the quads.
    pub through: &'a [[Vec3; 4]],
    /// Thickness at the nodes (length).
    pub thicknesses: &'a [f64],
    edges: Edges,
    /// Unit normals of the facets at their corners.
    normals: Vec<[Vec3; 4]>,
    /// Quads around each node, and their corners there.
    around: Vec<Vec<(usize, usize)>>,
    /// Nodes with facets on all sides.
    inside: Vec<bool>,
}

impl<'a> MiddleSurface<'a> {
    /// Middle surface of a mesh of solids; `None` for other meshes.
    pub(crate) fn of(mesh: &'a Mesh) -> Option<Self> {
        let (through, thicknesses) = (mesh.normals.as_deref()?, mesh.thickness.as_deref()?);
        let edges = Edges::of(&mesh.quads);
        let mut around = vec![Vec::new(); mesh.positions.len()];
        for (q, quad) in mesh.quads.iter().enumerate() {
            for (corner, node) in quad.iter().enumerate() {
                around.get_mut(*node as usize).into_iter().for_each(|here| here.push((q, corner)));
            }
        }
        let mut inside = vec![true; mesh.positions.len()];
        for uses in edges.iter().filter(|uses| uses.len() == 1) {
            for node in uses[0].nodes() {
                inside.get_mut(node as usize).into_iter().for_each(|inside| *inside = false);
            }
        }
        Some(Self { mesh, through, thicknesses, edges, normals: mesh.facet_normals(), around, inside })
    }

    /// Largest angle (degrees) between facets of a section and their neighbours, from [`FOLD`] on, and the nodes of the edge.
    pub(crate) fn sharpest_fold(&self, quads: &[u32]) -> Option<(f64, [u32; 2])> {
        let of_section: HashSet<u32> = quads.iter().copied().collect();
        let fold = |uses: &[EdgeUse]| {
            let [a, b] = uses else { return None };
            if !(of_section.contains(&a.quad) || of_section.contains(&b.quad)) {
                return None;
            }
            let angle = |node: u32| {
                let [a, b] = [a, b].map(|edge| &self.normals[edge.quad as usize][edge.corner_at(node)]);
                angle_between(a, b).to_degrees()
            };
            Some((larger(angle(a.low), angle(a.high)), a.nodes())).filter(|(angle, _)| *angle >= FOLD)
        };
        self.edges.iter().filter_map(fold).max_by(|a, b| a.0.total_cmp(&b.0))
    }

    /// Angle (degrees) between an edge through the thickness and the normal at a node, where it is more than the curvature explains.
    pub(crate) fn lean(&self, node: u32, edge: &Vec3) -> Option<f64> {
        let around = self.around.get(node as usize)?;
        let weighted = |&(q, corner): &(usize, usize)| {
            let area = Facet::of(self.mesh, &self.mesh.quads[q])?.area_vector().norm();
            Some(self.normals[q][corner] / area)
        };
        let mean = around.iter().filter_map(weighted).sum::<Vec3>().try_normalize(0.0)?;
        let lean = angle_between(edge, &mean).to_degrees();
        let explained = if self.inside[node as usize] {
            let turn = around
                .iter()
                .map(|&(q, corner)| angle_between(&self.normals[q][corner], &mean).to_degrees())
                .fold(0.0, larger);
            lean <= OBLIQUE + OF_TURN_INSIDE * turn
        } else {
            self.rim_explains(around, &mean, edge)
        };
        (!explained).then_some(lean)
    }

    /// Whether the turn of the surface beside a node at its rim explains the lean of an edge from the mean normal: the lean along the largest turn and across it,
    /// each against the turn of the facets beside, lies in the ellipse of what the turns in both directions allow.
    fn rim_explains(&self, around: &[(usize, usize)], mean: &Vec3, edge: &Vec3) -> bool {
        let nodes = around.iter().flat_map(|&(q, _)| self.mesh.quads[q]);
        let beside = nodes.filter_map(|node| self.around.get(node as usize)).flatten();
        let across_mean = |v: &Vec3| v - mean * v.dot(mean);
        let turns: Vec<Vec3> = beside.map(|&(q, corner)| across_mean(&self.normals[q][corner])).collect();
        let lean = across_mean(edge);
        let smallest = OBLIQUE.to_radians().sin();
        let largest = turns.iter().max_by(|a, b| a.norm().total_cmp(&b.norm()));
        let Some(along) = largest.and_then(|turn| turn.try_normalize(0.0)) else {
            return lean.norm() <= smallest;
        };
        let part = |direction: &Vec3| {
            let against = -lean.dot(direction).signum();
            let turn = turns.iter().map(|turn| against * turn.dot(direction)).fold(0.0, larger);
            (lean.dot(direction) / (smallest + OF_TURN_AT_RIM * turn)).powi(2)
        };
        part(&along) + part(&mean.cross(&along)) <= 1.0
    }
}
