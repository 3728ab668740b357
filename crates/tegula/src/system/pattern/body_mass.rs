//! Mass of rigid bodies with their patches.
//!
//! The mass of a model is a scalar for each pair of nodal vectors. Vectors attached to a body are linear in its position and
//! its directors, `v_a = Σ α_ap w_p`, and so is their part of the kinetic energy: `½ m_ab v_a·v_b = ½ m_ab α_ap α_bq w_p·w_q`.
//! The mass of attached vectors is therefore added to that of the body, its first moments and its Euler tensor, and where an
//! element couples attached vectors with others, to pairs of the body's vectors with these. In the tangent, where the
//! directors share a rotation, `δd_i = δθ × d_i`, such pairs have blocks that depend on the directors.

use std::collections::BTreeMap;

use super::builder::key;
use crate::Mat3;
use crate::system::{DofMap, LocalFrames};

/// A nodal vector or the directors of a rigid body.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Side {
    Vector(u32),
    /// Number of the body's directors, and their nodal vectors.
    Triad(u32, [u32; 3]),
}

impl Side {
    /// Side and place in it of a nodal vector.
    fn of(vector: u32, dofs: &DofMap) -> (Self, usize) {
        let found = dofs.triad_of(vector as usize).and_then(|body| {
            let place = dofs.triads[body].iter().position(|d| *d == vector)?;
            Some((Self::Triad(body as u32, dofs.triads[body]), place))
        });
        found.unwrap_or((Self::Vector(vector), 0))
    }

    /// Nodal vectors.
    fn vectors(&self) -> &[u32] {
        match self {
            Self::Vector(vector) => std::slice::from_ref(vector),
            Self::Triad(_, directors) => directors,
        }
    }

    /// Nodal vector that has the degrees of freedom.
    fn numbered(&self) -> u32 {
        self.vectors()[0]
    }
}

/// Masses of the directors of a body with each other, with those of another body or with another nodal vector.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct BodyMass {
    /// Row and column of the block in the tangent.
    sides: [Side; 2],
    /// Block of the tangent.
    pub block: usize,
    /// Mass of each pair, by rows of three.
    masses: [f64; 9],
}

/// Separates masses of pairs into those of plain nodal vectors and those of bodies.
pub(super) fn condense(masses: Vec<(u64, f64)>, dofs: &DofMap) -> (Vec<(u64, f64)>, Vec<BodyMass>) {
    if dofs.triads.is_empty() {
        return (masses, Vec::new());
    }
    let mut out = Condensed { dofs, plain: Vec::new(), bodies: BTreeMap::new() };
    for (pair, mass) in masses {
        let [a, b] = [(pair >> 32) as u32, pair as u32];
        if ![a, b].iter().any(|v| dofs.is_carried(*v as usize)) {
            out.plain.push((pair, mass));
            continue;
        }
        let parts = [a, b].map(|v| match dofs.attachment(v as usize) {
            Some(attached) => attached.parts(&dofs.triads[attached.triad as usize]),
            None => [Some((v, 1.0)), None, None, None],
        });
        for (i, (p, alpha)) in parts[0].into_iter().enumerate().filter_map(|(i, p)| Some((i, p?))) {
            for (j, (q, beta)) in parts[1].into_iter().enumerate().filter_map(|(j, q)| Some((j, q?))) {
                // Of a vector with itself both orders of two parts are met.
                if a != b || i >= j {
                    let twice = if a != b && p == q { 2.0 } else { 1.0 };
                    out.add(p, q, twice * mass * alpha * beta);
                }
            }
        }
    }
    (out.plain, out.bodies.into_values().collect())
}

/// Masses in the making.
struct Condensed<'a> {
    dofs: &'a DofMap,
    plain: Vec<(u64, f64)>,
    bodies: BTreeMap<[Side; 2], BodyMass>,
}

impl Condensed<'_> {
    fn add(&mut self, p: u32, q: u32, mass: f64) {
        if mass == 0.0 {
            return;
        }
        let (mut row, mut column) = (Side::of(p, self.dofs), Side::of(q, self.dofs));
        if row.0.numbered() < column.0.numbered() {
            std::mem::swap(&mut row, &mut column);
        }
        let ((first, i), (second, j)) = (row, column);
        if matches!([first, second], [Side::Vector(_), Side::Vector(_)]) {
            self.plain.push((key(p, q), mass));
            return;
        }
        let sides = [first, second];
        let new = BodyMass { sides, block: 0, masses: [0.0; 9] };
        let found = self.bodies.entry(sides).or_insert(new);
        found.masses[3 * i + j] += mass;
        if first == second && i != j {
            found.masses[3 * j + i] += mass;
        }
    }
}

impl BodyMass {
    /// Key of its block.
    pub fn key(&self) -> u64 {
        key(self.sides[0].numbered(), self.sides[1].numbered())
    }

    /// Nodal vectors of the block's row and column.
    pub fn place(&self) -> [u32; 2] {
        self.sides.map(|side| side.numbered())
    }

    /// Calls `f(i, j, m)` for every pair of nodal vectors.
    pub fn for_each(&self, mut f: impl FnMut(u32, u32, f64)) {
        let [rows, columns] = [self.sides[0].vectors(), self.sides[1].vectors()];
        for (i, &a) in rows.iter().enumerate() {
            let count = if self.sides[0] == self.sides[1] { i + 1 } else { columns.len() };
            for (j, &b) in columns[..count].iter().enumerate() {
                f(a, b, self.masses[3 * i + j]);
            }
        }
    }

    /// Block in the tangent, `Σ m_ij P_iᵀ S P_j`, with `P_i = −[d_i]×` for directors and the unit matrix for other vectors, and a
    /// symmetric matrix S.
    pub fn tangent(&self, matrix: &Mat3, frames: &LocalFrames) -> Mat3 {
        let arms = |side: &Side, i: usize| match side {
            Side::Triad(body, _) => -frames.triad(*body as usize).column(i).into_owned().cross_matrix(),
            Side::Vector(_) => Mat3::identity(),
        };
        let [rows, columns] = [&self.sides[0], &self.sides[1]];
        let mut k = Mat3::zeros();
        for i in 0..rows.vectors().len() {
            for j in 0..columns.vectors().len() {
                k += arms(rows, i).tr_mul(&(matrix * arms(columns, j))) * self.masses[3 * i + j];
            }
        }
        k
    }
}
