//! Schur complement of the tangent at constraints, with its rank.

use super::complete_pivoting::CompletePivoting;
use crate::constraint::Joint;
use crate::norm::larger;
use crate::system::System;

/// Pivot of the scaled Schur complement over the largest one, below which constraints count as dependent; and its decrease
/// where one of these constraints stays open.
const DEPENDENT: f64 = 1e-4;
const READMITTED: f64 = 1e-3;

/// Schur complement S with its factor.
pub(in crate::analysis) struct Schur {
    /// S by rows, scaled where it is factored.
    pub matrix: Vec<f64>,
    /// Square roots of the diagonal: rows and columns are scaled by their inverse.
    pub scale: Vec<f64>,
    factor: CompletePivoting,
    /// Pivot over the largest one, below which constraints count as dependent.
    cut: f64,
}

impl Schur {
    pub fn new(m: usize) -> Self {
        Self {
            matrix: vec![0.0; m * m],
            scale: vec![1.0; m],
            factor: CompletePivoting::new(m),
            cut: DEPENDENT,
        }
    }

    pub fn factor(&mut self) {
        let m = self.scale.len();
        for (i, scale) in self.scale.iter_mut().enumerate() {
            let diagonal = self.matrix[i * m + i].abs().sqrt();
            *scale = if diagonal > 0.0 { diagonal } else { 1.0 };
        }
        for (row, a) in self.matrix.chunks_mut(m).zip(&self.scale) {
            row.iter_mut().zip(&self.scale).for_each(|(x, b)| *x /= a * b);
        }
        self.factor.factor(&self.matrix);
        self.factor.decide_rank(self.cut);
    }

    /// Decides the rank anew after constraints were taken back.
    pub(super) fn reset_cut(&mut self) {
        if self.cut < DEPENDENT {
            self.set_cut(DEPENDENT);
        }
    }

    /// Takes some of the constraints back that were left out as dependent.
    pub(super) fn readmit(&mut self) {
        self.set_cut(READMITTED * self.cut);
    }

    fn set_cut(&mut self, cut: f64) {
        self.cut = cut;
        self.factor.decide_rank(cut);
    }

    /// Solves `S x = b`, where b becomes scratch space. Where the rank falls, `x + old` has minimum norm.
    pub fn solve(&mut self, b: &mut [f64], old: &[f64], x: &mut [f64]) {
        let scale = &self.scale;
        b.iter_mut().zip(scale).for_each(|(b, s)| *b /= s);
        self.factor.solve(b, |i| old.get(i).map_or(0.0, |x| x * scale[i]));
        for ((x, b), s) in x.iter_mut().zip(&*b).zip(scale) {
            *x = b / s;
        }
    }
    /// Coefficients y of constraints that depend on each other, or nearly so, and their pivot over the largest one, of the sign of
    /// `yᵀ S y`; `None` where none do.
    pub(super) fn first_null_vector(&self, y: &mut [f64]) -> Option<f64> {
        let pivot = self.factor.first_null_vector(y)?;
        let of_unit_diagonal = |j: usize| {
            let row = &self.matrix[j * self.scale.len()..][..self.scale.len()];
            y[j] * row.iter().zip(&*y).map(|(s, y)| s * y).sum::<f64>()
        };
        let energy: f64 = (0..self.scale.len()).map(of_unit_diagonal).sum();
        y.iter_mut().zip(&self.scale).for_each(|(y, scale)| *y /= scale);
        Some(pivot.abs().copysign(energy))
    }

    /// Largest of the coefficients y of constraints of unit compliance; only of some constraints where wanted.
    pub(super) fn largest(&self, y: &[f64], some: &[bool], only: bool) -> f64 {
        let scaled = y.iter().zip(&self.scale).zip(some);
        scaled.filter(|(_, is)| **is || !only).map(|((y, scale), _)| (y * scale).abs()).fold(0.0, larger)
    }

    /// Counts the first of the constraints that depend on others as independent, until the rank is decided again.
    pub(super) fn admit_next(&mut self) {
        self.factor.admit_next();
    }

    /// Constraints that do not depend on others.
    pub(super) fn independent(&self) -> &[usize] {
        self.factor.independent()
    }

    /// Number of constraints that follow from others.
    pub fn dependent(&self) -> usize {
        self.factor.dependent().len()
    }

    /// Joints with constraints that follow from others in the last factor, and the number of these.
    pub fn dependent_joints<'a>(
        &'a self,
        system: &'a System,
    ) -> impl Iterator<Item = (&'a Joint, usize)> + 'a {
        let dependent = self.factor.dependent();
        let count =
            move |joint: &Joint| dependent.iter().filter(|row| joint.multipliers().contains(*row)).count();
        let counted = system.joints.iter().map(move |joint| (joint, count(joint)));
        counted.filter(|(_, count)| *count > 0)
    }

    /// Messages about joints with constraints that are redundant in the last factor.
    pub fn redundant<'a>(&'a self, system: &'a System) -> impl Iterator<Item = String> + 'a {
        self.dependent_joints(system).map(|(Joint { name, .. }, count)| {
            format!(
                "joint \"{name}\": {count} of its constraints follow from those of other joints and supports; its reactions \
                 are not unique, and those of minimum norm are computed"
            )
        })
    }
}
