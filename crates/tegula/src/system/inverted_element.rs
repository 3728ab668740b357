//! Detection of inverted elements.
//!
//! Strains are quadratic, so an element that has passed through itself has small strains again and Newton's method can
//! converge there. No real shell reaches such a state: it is no solution.

use rayon::prelude::*;

use super::System;
use crate::Vec3;
use crate::element::Nodal;
use crate::element::geometry::{GAUSS_POINTS, covariant_base};

/// Elements per task.
const CHUNK: usize = 256;

/// First inverted shell, whose volume measure `det[r,ξ r,η d]` has changed its sign at an integration point, as text.
pub fn inverted_element(system: &System, u: &[Nodal]) -> Option<String> {
    if system.linear {
        return None;
    }
    let turned = |shell: &super::Shell| {
        let vectors = system.groups[shell.groups.start].vectors(shell.member);
        let current = |a: usize| {
            let v = vectors[a] as usize;
            Vec3::from(system.coordinates.reference[v]) + Vec3::from(u[v])
        };
        let (positions, directors) = (std::array::from_fn(current), std::array::from_fn(|a| current(4 + a)));
        let g = system.geometry(shell);
        GAUSS_POINTS.iter().any(|&[xi, eta]| {
            let now = covariant_base(&positions, &directors, xi, eta).determinant();
            let reference = covariant_base(&g.positions, &g.directors, xi, eta).determinant();
            now * reference <= 0.0
        })
    };
    let shell = system.shells.par_iter().with_min_len(CHUNK).find_first(|s| turned(s))?;
    let c = system.geometry(shell).centre();
    let label = system.quad_label(shell.quad);
    Some(format!("element {label} at ({:.4}, {:.4}, {:.4}) is inverted", c.x, c.y, c.z))
}
