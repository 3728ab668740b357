//! Rigid motions that the supports leave free.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::SMatrix;

use crate::mesh::Mesh;
use crate::system::supports::Support;
use crate::system::{Coordinates, VectorKind};
use crate::{Issue, Vec3};

/// Rigid-body motions that the supports leave free, sheet by sheet.
///
/// Each connected part of the mesh, with the parts that rigid bodies connect with it, has six rigid motions. A support prevents a combination of them; a part with a motion
/// that no support prevents is under-constrained (free mechanism).
pub fn mechanisms(mesh: &Mesh, coordinates: &Coordinates, supports: &[Support]) -> Vec<Issue> {
    let Coordinates { reference, kinds, nodes, .. } = coordinates;
    let part_of = joined_parts(mesh, coordinates);
    let count = part_of.iter().filter(|&&p| p != u32::MAX).max().map_or(0, |&p| p as usize + 1);
    let mut normal = vec![SMatrix::<f64, 6, 6>::zeros(); count];
    let mut first = vec![usize::MAX; count];
    let mut size = vec![0; count];
    for (node, &p) in part_of.iter().enumerate().filter(|(_, p)| **p != u32::MAX) {
        first[p as usize] = first[p as usize].min(node);
        size[p as usize] += 1;
    }
    let lengths = extents(mesh, &part_of, count);
    for s in supports {
        let v = s.vector as usize;
        let part = part_of[nodes[v] as usize];
        if part == u32::MAX {
            continue;
        }
        let origin = mesh.positions[first[part as usize]];
        let length = lengths[part as usize];
        // Motion t L + ω × (x − origin) of a position, ω × d of a director.
        let arm = match kinds[v] {
            VectorKind::Position => (Vec3::from(reference[v]) - origin) / length,
            VectorKind::Director | VectorKind::Gradient => Vec3::from(reference[v]),
        };
        let translation = if kinds[v] == VectorKind::Position { s.direction } else { Vec3::zeros() };
        let rotation = arm.cross(&s.direction);
        let row = SMatrix::<f64, 1, 6>::from_fn(|_, c| if c < 3 { translation[c] } else { rotation[c - 3] });
        normal[part as usize] += row.transpose() * row;
    }
    let mut issues = Vec::new();
    for (part, n) in normal.iter().enumerate() {
        let eigen = n.symmetric_eigen();
        let largest = eigen.eigenvalues.max();
        let mut free: Vec<usize> =
            (0..6).filter(|&i| eigen.eigenvalues[i] <= 1e-16_f64.max(1e-12 * largest)).collect();
        free.sort_by(|&a, &b| eigen.eigenvalues[a].total_cmp(&eigen.eigenvalues[b]));
        let Some(&mode) = free.first() else { continue };
        let v = eigen.eigenvectors.column(mode);
        let (t, w) = (Vec3::new(v[0], v[1], v[2]), Vec3::new(v[3], v[4], v[5]));
        let how = if free.len() == 6 {
            "has no support at all".to_string()
        } else if w.norm() < 1e-6 {
            let t = t.normalize();
            format!("can translate freely along ({:.3}, {:.3}, {:.3})", t.x, t.y, t.z)
        } else {
            // The axis: the point where the motion vanishes across ω.
            let p = mesh.positions[first[part]] + w.cross(&t) / w.norm_squared() * lengths[part];
            let w = w.normalize();
            format!(
                "can rotate freely about the axis through ({:.4}, {:.4}, {:.4}) along ({:.3}, {:.3}, {:.3})",
                p.x, p.y, p.z, w.x, w.y, w.z
            )
        };
        issues.push(Issue::new(
            "conditions",
            format!(
                "the model is under-constrained: the part containing node {} ({} nodes) {how} ({} free rigid motion(s))",
                mesh.node_label(first[part] as u32),
                size[part],
                free.len()
            ),
            "add a support against this motion, or use a transient analysis",
        ));
    }
    issues
}

/// Part of each node, `u32::MAX` for nodes without elements: parts with nodes that are attached to one body are one.
fn joined_parts(mesh: &Mesh, coordinates: &Coordinates) -> Vec<u32> {
    let mut part_of = mesh.parts();
    for body in &coordinates.bodies {
        let nodes = body.attached.iter().map(|attached| coordinates.nodes[attached.vector as usize]);
        let joined: BTreeSet<u32> = nodes.map(|node| part_of[node as usize]).collect();
        let Some(&first) = joined.first() else { continue };
        part_of.iter_mut().filter(|part| joined.contains(part)).for_each(|part| *part = first);
    }
    let left: BTreeSet<u32> = part_of.iter().copied().filter(|&part| part != u32::MAX).collect();
    let numbers: BTreeMap<u32, u32> = left.into_iter().zip(0..).collect();
    part_of.iter().map(|part| numbers.get(part).copied().unwrap_or(u32::MAX)).collect()
}

/// Diagonals of the boxes about the parts of a mesh.
fn extents(mesh: &Mesh, part_of: &[u32], count: usize) -> Vec<f64> {
    let mut boxes = vec![[Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY)]; count];
    for (x, &part) in mesh.positions.iter().zip(part_of).filter(|(_, p)| **p != u32::MAX) {
        let [low, high] = &mut boxes[part as usize];
        (*low, *high) = (low.inf(x), high.sup(x));
    }
    boxes.iter().map(|[low, high]| (high - low).norm()).collect()
}
