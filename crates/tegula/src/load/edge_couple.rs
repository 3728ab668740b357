//! Moment at an edge of a mesh as forces on the director of a node and on both ends of the edge.

use crate::{Mat3, Vec3};

/// Nodal forces of an edge moment: force F of the couple at the ends of the edge, and force f on the director.
pub(super) struct EdgeForces {
    pub couple: Vec3,
    pub director: Vec3,
}

/// Forces of a moment m at an edge t and a director d: `F = (m·d) w/|w|²` with `w = d × t`, `f = (m × d − (d·t) F)/|d|²`.
pub(super) fn edge_forces(m: &Vec3, t: &Vec3, d: &Vec3) -> EdgeForces {
    let w = d.cross(t);
    let couple = w * (m.dot(d) / w.norm_squared());
    EdgeForces { director: (m.cross(d) - couple * d.dot(t)) / d.norm_squared(), couple }
}

/// Derivatives with respect to t and d (columns) of the couple and of the force on the director (rows).
pub(super) fn edge_derivative(m: &Vec3, t: &Vec3, d: &Vec3) -> [[Mat3; 2]; 2] {
    let EdgeForces { couple, director } = edge_forces(m, t, d);
    let w = d.cross(t);
    let (w2, n2, p) = (w.norm_squared(), d.norm_squared(), d.dot(t));
    // δ(w/|w|²) = (I − 2 w wᵀ/|w|²) δw/|w|², δw = δd × t + d × δt
    let turned = (Mat3::identity() - w * w.transpose() * (2.0 / w2)) * (m.dot(d) / w2);
    let couple_t = turned * d.cross_matrix();
    let couple_d = w * m.transpose() / w2 - turned * t.cross_matrix();
    let director_t = -(couple * d.transpose() + couple_t * p) / n2;
    let director_d =
        (m.cross_matrix() - couple * t.transpose() - couple_d * p - director * d.transpose() * 2.0) / n2;
    [[couple_t, couple_d], [director_t, director_d]]
}
