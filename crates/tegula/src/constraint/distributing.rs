//! Distributing coupling: a rigid body that follows the weighted mean motion of nodes, and distributes the forces on it to them.
//!
//! Nodes a with weights `w_a` of sum 1 have the positions `x_a` at the reference and `r_a` now; X are coordinates of the
//! reference from the weighted mean of the `x_a`, along axes e of the body. The body's point at this mean stays at the
//! weighted mean of the nodes, and its directors d satisfy
//!
//! ```text
//! r + C_i d_i = Σ w_a r_a,
//! d_i · m_j = d_j · m_i,    m_i = Σ w_a (X_ai r_a + ℓ_a² D_ai d_a),    i ≠ j.
//! ```
//!
//! The second condition makes R the rotation of the polar decomposition `Σ w_a y_a X_aᵀ = R U`, U symmetric: it is the one that
//! best fits the nodes, with the least `Σ w_a (|y_a − R X_a|² + ℓ_a² |d_a − R D_a|²)`, y the distances from the mean. The
//! directors `d_a` of shells, D at the reference, take part with `ℓ² = h²/12`: then the sum is the integral over the
//! thickness h, of points `r_a + ζ d_a`. So a straight edge, whose positions say nothing about rotations about it, determines
//! them, too.
//!
//! All rows are quadratic forms of nodal vectors, in which no vector is multiplied by itself: the forces `Gᵀλ` on the nodes
//! have the resultant of the loads on the body, and nothing holds the nodes in their distances. The coordinates i are the
//! principal axes of `Σ w_a (X_a X_aᵀ + ℓ_a² D_a D_aᵀ)`, in which the rows of the three rotations do not couple at the
//! reference; the row of i and j is divided by the sum of these two principal values.
//!
//! W. Kabsch, *A solution for the best rotation to relate two sets of vectors*, Acta Cryst. A32 (1976) 922–923. For small motions
//! these are the equations of the element RBE3 of NASTRAN with these weights.

use super::joint::Role;
use super::joints::End;
use super::{Attachment, Joint, Row};
use crate::norm::larger;
use crate::{Mat3, Vec3};

/// Smaller one of the sums of two principal values over that of all three, below which a rotation is not determined.
const UNDETERMINED: f64 = 1e-12;
/// Weight of a vector in a mean over the largest possible one, below which it is round-off.
const ROUND_OFF: f64 = 1e-14;

/// A node whose motion a body follows.
#[derive(Debug, Clone, PartialEq)]
pub struct AveragedNode {
    /// Nodal vector of the position, and its value at the reference.
    pub position: (u32, Vec3),
    /// Weight w; only ratios matter.
    pub weight: f64,
    /// Nodal vectors of the directors with their values at the reference, and their shares of `ℓ²` \[length²\].
    pub directors: Vec<(u32, Vec3, f64)>,
    /// Mass of the node, for the augmented Lagrangian.
    pub mass: f64,
}

/// Weighted mean of the nodes at the reference, and principal axes (columns) and values \[length²\] of their distances from it.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Spread {
    mean: Vec3,
    axes: Mat3,
    values: Vec3,
    /// Sum of the weights.
    total: f64,
}

impl Spread {
    fn new(nodes: &[AveragedNode]) -> Self {
        let total: f64 = nodes.iter().map(|node| node.weight).sum();
        let mean = nodes.iter().map(|node| node.position.1 * (node.weight / total)).sum::<Vec3>();
        let second = |node: &AveragedNode| -> Mat3 {
            let arm = node.position.1 - mean;
            let of_directors: Mat3 =
                node.directors.iter().map(|(_, d, share)| d * d.transpose() * *share).sum();
            (arm * arm.transpose() + of_directors) * (node.weight / total)
        };
        let eigen = nodes.iter().map(second).sum::<Mat3>().symmetric_eigen();
        let [first, other] = [0, 1].map(|i| eigen.eigenvectors.column(i).into_owned());
        Self {
            mean,
            axes: Mat3::from_columns(&[first, other, first.cross(&other)]),
            values: eigen.eigenvalues,
            total,
        }
    }

    /// Whether the nodes determine all rotations.
    fn determines_rotations(&self) -> bool {
        let sums = [(0, 1), (1, 2), (2, 0)].map(|(i, j)| self.values[i] + self.values[j]);
        let smallest = sums.into_iter().fold(f64::INFINITY, |a, b| if b < a { b } else { a });
        smallest > UNDETERMINED * self.values.sum()
    }

    /// Mean `m_i` along a principal axis.
    fn moment(&self, nodes: &[AveragedNode], i: usize) -> Attachment {
        let axis = self.axes.column(i);
        let smallest = ROUND_OFF * self.values.sum().sqrt();
        let of_node = |node: &AveragedNode| {
            let weight = node.weight / self.total;
            let position = (node.position.0, weight * (node.position.1 - self.mean).dot(&axis));
            let directors =
                node.directors.iter().map(move |(v, d, share)| (*v, weight * share * d.dot(&axis)));
            std::iter::once(position)
                .chain(directors)
                .filter(|(_, w)| w.abs() > smallest * weight)
                .collect::<Vec<_>>()
        };
        Attachment { terms: nodes.iter().flat_map(of_node).collect(), constant: Vec3::zeros() }
    }
}

/// Coupling of a body and nodes, in a model of this length, behind the `others`; `None` where the nodes do not determine the
/// rotation of the body, or the end is no body with axes.
pub fn distributing(
    name: &str,
    body: &End,
    nodes: &[AveragedNode],
    (length, others): (f64, &[Joint]),
) -> Option<Joint> {
    let End::Body { vectors: (centre, directors), reference: (place, _), inertia } = body else {
        return None;
    };
    let spread = Spread::new(nodes);
    if !spread.determines_rotations() {
        return None;
    }
    // The vectors of the body come first, as gradients expect.
    let mut vectors = [&[*centre][..], directors].concat();
    vectors.extend(nodes.iter().map(|node| node.position.0));
    vectors.extend(nodes.iter().flat_map(|node| node.directors.iter().map(|director| director.0)));
    let mass: f64 = nodes.iter().map(|node| node.mass).sum();
    let mut rows = Vec::with_capacity(6);
    let terms = nodes.iter().map(|node| (node.position.0, node.weight / spread.total)).collect();
    let mean = Attachment { terms, constant: Vec3::zeros() };
    for e in [Vec3::x(), Vec3::y(), Vec3::z()] {
        let mut row = Row::coincident(&mut vectors, &body.point(&spread.mean), &mean, &e);
        (row.size, row.inertia, row.measure) = (length, larger(mass, inertia[0]), 1.0);
        rows.push(row);
    }
    let moments = [0, 1, 2].map(|i| spread.moment(nodes, i));
    for (i, j) in [(1, 2), (2, 0), (0, 1)] {
        let sum = spread.values[i] + spread.values[j];
        let axis = |i: usize| body.axis(&spread.axes.column(i).into_owned());
        let mut row = Row::default();
        row.add_product(&mut vectors, 1.0 / sum, &axis(i)?, &moments[j]);
        row.add_product(&mut vectors, -1.0 / sum, &axis(j)?, &moments[i]);
        (row.size, row.inertia, row.measure) = (1.0, larger(mass * sum, inertia[1]), sum);
        rows.push(row);
    }
    let of_first = (0..vectors.len()).map(|place| place < 4).collect();
    let (number, first) = (others.len(), others.last().map_or(0, |last| last.multipliers().end));
    let point = body.point(place);
    let name = name.to_owned();
    let (drive, role, engages, law) = (None, Role::Acting, false, None);
    Some(Joint {
        name,
        vectors,
        of_first,
        point,
        axes: None,
        rows,
        first,
        number,
        drive,
        role,
        engages,
        law,
        counted: None,
    })
}
