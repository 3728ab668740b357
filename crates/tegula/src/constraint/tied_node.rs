//! Node that follows a point of a shell element: tie of meshes whose nodes do not match.
//!
//! With the shape functions N at the place of the node and its height z over the mid-surface, its position satisfies
//!
//! ```text
//! r = Σ N_a (r_a + z d_a).
//! ```
//!
//! The material vectors `r,ξ`, `r,η` and `d = Σ N_a d_a` of the point are a base. In it the director of the node and two tangents across it have
//! constant components at the reference; `D`, `t₁`, `t₂` are these combinations at present. The director rotates with the element,
//!
//! ```text
//! t₁·(d − D) = 0,   t₂·(d − D) = 0,
//! ```
//!
//! and keeps its own length. Both conditions are quadratic in the nodal vectors and hold in rigid motions of any size. As a
//! collocation at nodes, the tie transfers constant stress exactly where all nodes of the coarser side meet those of the finer one. C. Farhat,
//! F.-X. Roux, *A method of finite element tearing and interconnecting*, Int. J. Numer. Methods Eng. 32 (1991) 1205–1227, for the multipliers.

use super::{Attachment, Quantity, Row};
use crate::element::geometry::tangents;
use crate::{Mat3, Vec3};

/// Point of an element that a node follows.
#[derive(Debug, Clone, PartialEq)]
pub struct FollowedPoint {
    /// The point with its height.
    pub point: Attachment,
    /// Material vectors `r,ξ`, `r,η` and d of the point, with their values at the reference.
    pub base: [(Attachment, Vec3); 3],
}

impl FollowedPoint {
    /// Vector that has constant components in the base; `value` at the reference.
    fn material(&self, value: &Vec3) -> Option<Attachment> {
        let columns = [0, 1, 2].map(|i| self.base[i].1);
        let components = Mat3::from_columns(&columns).try_inverse()? * value;
        let mut out = Attachment::default();
        for ((vector, _), c) in self.base.iter().zip(components.iter()) {
            out.terms.extend(vector.terms.iter().map(|(v, weight)| (*v, weight * c)));
        }
        Some(out)
    }

    /// Constraints of a node at a point, and of its director where it follows, too. `length` is the size of the model. `None` for an element without
    /// area.
    pub fn rows(
        &self,
        position: u32,
        director: Option<(u32, Vec3)>,
        (vectors, length): (&mut Vec<u32>, f64),
    ) -> Option<Vec<Row>> {
        let node = Attachment::vector(position);
        let mut rows = Vec::with_capacity(5);
        for e in [Vec3::x(), Vec3::y(), Vec3::z()] {
            let mut row = Row::coincident(vectors, &node, &self.point, &e);
            (row.size, row.measure) = (length, 1.0);
            rows.push(row);
        }
        if let Some((vector, value)) = director {
            let (own, followed) = (Attachment::vector(vector), self.material(&value)?);
            for tangent in tangents(&value.normalize()) {
                let tangent = self.material(&tangent)?;
                let mut row = Row::default();
                (row.size, row.measure, row.keeps) = (1.0, length * length, Quantity::Axes);
                row.add_product(vectors, 1.0, &tangent, &own);
                row.add_product(vectors, -1.0, &tangent, &followed);
                rows.push(row);
            }
        }
        Some(rows)
    }
}
