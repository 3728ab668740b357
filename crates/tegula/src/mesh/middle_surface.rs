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
/// Part of the turn of the facets around, in the direction against the lean, that may be an error of the normal inside the surface.
const OF_TURN_INSIDE: f64 = 0.5;
/// Part of it that may lie between a facet and the normal at a rim, which leans away from the facets beside: half of it for facets of equal size.
const OF_TURN_AT_RIM: f64 = 0.75;
/// Sine of the angle of a corner below which its edges do not tell the normal there: they lie along a rim.
const FLAT: f64 = 0.5;
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
        Some(Self { mesh, through, thicknesses, edges, normals: normals(mesh), around, inside })
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
        let explained = self.curvature_explains(node, (around, &mean), edge);
        (!explained).then(|| angle_between(edge, &mean).to_degrees())
    }

    /// Whether the turn of the surface around a node explains the lean of an edge from the mean normal: the lean along the largest turn and across it, each
    /// against the turn of facets there, lies in the ellipse of what these turns allow. At a rim these are the facets beside, too.
    fn curvature_explains(&self, node: u32, (around, mean): (&[(usize, usize)], &Vec3), edge: &Vec3) -> bool {
        let across_mean = |v: &Vec3| v - mean * v.dot(mean);
        let turn = |&(q, corner): &(usize, usize)| across_mean(&self.normals[q][corner]);
        let (turns, part_of_turn): (Vec<Vec3>, f64) = if self.inside[node as usize] {
            (around.iter().map(turn).collect(), OF_TURN_INSIDE)
        } else {
            let nodes = around.iter().flat_map(|&(q, _)| self.mesh.quads[q]);
            let beside = nodes.filter_map(|node| self.around.get(node as usize)).flatten();
            (beside.map(turn).collect(), OF_TURN_AT_RIM)
        };
        let lean = across_mean(edge);
        let smallest = OBLIQUE.to_radians().sin();
        let largest = turns.iter().max_by(|a, b| a.norm().total_cmp(&b.norm()));
        let Some(along) = largest.and_then(|turn| turn.try_normalize(0.0)) else {
            return lean.norm() <= smallest;
        };
        let part = |direction: &Vec3| {
            let against = -lean.dot(direction).signum();
            let turn = turns.iter().map(|turn| against * turn.dot(direction)).fold(0.0, larger);
            (lean.dot(direction) / (smallest + part_of_turn * turn)).powi(2)
        };
        part(&along) + part(&mean.cross(&along)) <= 1.0
    }
}

/// Unit normals of the facets at their corners; that of the whole facet where the edges of a corner are nearly parallel, as at the corners of a square that is
/// drawn out to a disc.
fn normals(mesh: &Mesh) -> Vec<[Vec3; 4]> {
    let mut normals = mesh.facet_normals();
    for (normals, quad) in normals.iter_mut().zip(&mesh.quads) {
        let Some(facet) = Facet::of(mesh, quad) else { continue };
        let Some(whole) = facet.area_vector().try_normalize(0.0) else { continue };
        for (corner, normal) in normals.iter_mut().enumerate() {
            if facet.corner_angle(corner).sin() < FLAT {
                *normal = whole;
            }
        }
    }
    normals
}
