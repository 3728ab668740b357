//! Distance of a point from an axis: the length of a spring that acts across a guide or a bearing.
//!
//! With the directions e₁ and e₂ across the axis, which move with the first side, and the vector d from a point of the axis to the point of the second side, the
//! distance is `r = √(f₁² + f₂²)` of the forms `f_i = e_i·d`. They are quadratic in the nodal vectors: with their means f̄_i over a step and the gradients ∂f_i in its
//! middle
//!
//! ```text
//! w = (f̄₁ ∂f₁ + f̄₂ ∂f₂)/(½ (r₀ + r₁)),   w·(q₁ − q₀) = r₁ − r₀
//! ```
//!
//! exactly, so that the force `F̄ w` with the mean F̄ of the law over the step does the work of a discrete gradient (O. Gonzalez, *Time integration and discrete Hamiltonian
//! systems*, J. Nonlinear Sci. 6 (1996) 449–467). The forms do not change in rigid motions, so that momenta are conserved.

use super::joint::{Few, MOST_VECTORS, few};
use super::joints::End;
use super::{Attachment, Row};
use crate::{Mat3, Vec3};

/// Components of the vector from an axis to a point.
#[derive(Debug, Clone, PartialEq)]
pub struct Across {
    /// Nodal vectors of the forms.
    pub(super) vectors: Vec<u32>,
    /// Forms f₁ and f₂.
    forms: [Row; 2],
}

impl Across {
    /// Vector to the point `to` of the second side from the axis through `from` along `axis` on the first one. `None` where the first side has no axes, or both
    /// have too many nodal vectors.
    pub fn new([first, second]: &[End; 2], [from, to]: [&Vec3; 2], axis: &Vec3) -> Option<Self> {
        let [a, b]: [Attachment; 2] = [first.point(from), second.point(to)];
        let mut vectors = Vec::new();
        let mut form = |e: &Vec3| {
            let e = first.axis(e)?;
            let mut row = Row::default();
            row.add_product(&mut vectors, 1.0, &e, &b);
            row.add_product(&mut vectors, -1.0, &e, &a);
            Some(row)
        };
        let [e1, e2] = crate::element::geometry::tangents(&axis.normalize());
        let forms = [form(&e1)?, form(&e2)?];
        (vectors.len() <= MOST_VECTORS).then_some(Self { vectors, forms })
    }

    /// Values at the nodal vectors.
    pub(super) fn few(&self, value: impl Fn(usize) -> Vec3) -> Few {
        few(&self.vectors, |v| value(v as usize))
    }

    /// Values (f₁, f₂, 0) of the forms.
    pub(super) fn value(&self, v: &Few) -> Vec3 {
        Vec3::new(self.forms[0].form(v), self.forms[1].form(v), 0.0)
    }

    /// Change of the forms with changes of the nodal vectors.
    pub(super) fn change(&self, v: &Few, change: &Few) -> Vec3 {
        Vec3::new(self.forms[0].form_rate(v, change), self.forms[1].form_rate(v, change), 0.0)
    }

    /// Forces on the nodal vectors that do the work of a force on the components.
    pub(super) fn forces(&self, v: &Few, force: &Vec3) -> Few {
        let mut out = [Vec3::zeros(); MOST_VECTORS];
        self.forms.iter().zip(force.iter()).for_each(|(form, f)| form.add_gradient(*f, v, 0.0, &mut out));
        out
    }

    /// Writes the lower blocks of a stiffness against changes of the components, and of a force on them, whose direction depends on the nodal vectors.
    pub(super) fn write_blocks(&self, v: &Few, (stiffness, force): (&Mat3, &Vec3), blocks: &mut [f64]) {
        let unit = [Vec3::x(), Vec3::y()];
        let gradients = unit.map(|e| self.forces(v, &e));
        let mut block = blocks.chunks_exact_mut(9);
        for a in 0..self.vectors.len() {
            for b in 0..=a {
                let Some(out) = block.next() else { break };
                let mut sum = Mat3::zeros();
                for i in 0..2 {
                    for j in 0..2 {
                        sum += gradients[i][a] * gradients[j][b].transpose() * stiffness[(i, j)];
                    }
                }
                out.iter_mut().enumerate().for_each(|(i, out)| *out = sum[(i / 3, i % 3)]);
            }
        }
        self.forms.iter().zip(force.iter()).for_each(|(form, f)| form.add_second_derivative(*f, 0.0, blocks));
    }
}
