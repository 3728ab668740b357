//! LBLᵀ factorisation of indefinite matrices on the fronts of the multifrontal method.
//!
//! The columns of a front are eliminated with Bunch–Kaufman pivots, 1×1 and 2×2, chosen among themselves. The signs of
//! the pivots are the inertia of the matrix. Fronts are worked off one after another: such matrices are met at
//! limit points and in saddle points, not in every iteration.
//!
//! J. R. Bunch, L. Kaufman, *Some stable methods for calculating inertia and solving symmetric linear systems*, Math.
//! Comp. 31 (1977) 163–179.

use dyn_stack::{MemBuffer, MemStack};
use faer::diag::DiagMut;
use faer::linalg::cholesky::lblt::factor::{cholesky_in_place, cholesky_in_place_scratch};
use faer::linalg::matmul::triangular::{BlockStructure, matmul as triangular_matmul};
use faer::linalg::triangular_solve::solve_unit_lower_triangular_in_place;
use faer::prelude::{Reborrow, ReborrowMut};
use faer::{Accum, ColMut, MatMut, Par};

use super::assembly_tree::{AssemblyTree, Front};
use super::multifrontal::{add, zeros};
use super::{FactorError, Inertia};

/// Pivots of an LBLᵀ factorisation, and the memory to make one.
pub(super) struct Pivots {
    /// Entries of B below its diagonal, by columns.
    pub below: Vec<f64>,
    /// Which column of its front is eliminated at each place.
    pub order: Vec<usize>,
    inverse: Vec<usize>,
    /// What waits to be added to a parent.
    stack: Vec<f64>,
    /// L₂₁ B of the front at work.
    product: Vec<f64>,
    dense: MemBuffer,
}

impl Pivots {
    /// Memory for the fronts of a tree.
    pub fn new(tree: &AssemblyTree) -> Result<Self, FactorError> {
        let n = tree.order.len();
        let widest = tree.fronts.iter().map(|f| f.width).max().unwrap_or(0);
        let largest = tree.fronts.iter().map(|f| f.width * f.rows.len()).max().unwrap_or(0);
        let request = cholesky_in_place_scratch::<usize, f64>(widest, Par::Seq, Default::default());
        let (mut held, mut most) = (0_usize, 0);
        for (f, front) in tree.fronts.iter().enumerate() {
            let own = front.rows.len().pow(2);
            most = most.max(held + own);
            held = held + own - tree.passed_by_children(f);
        }
        Ok(Self {
            below: zeros(n)?,
            order: vec![0; n],
            inverse: vec![0; n],
            stack: zeros(most)?,
            product: zeros(largest)?,
            dense: MemBuffer::try_new(request).map_err(|_| FactorError::TooLarge)?,
        })
    }

    /// Factors the matrix with the given values into the panels `factor`.
    pub fn factor(
        &mut self,
        tree: &AssemblyTree,
        values: &[f64],
        factor: &mut [f64],
    ) -> Result<Inertia, FactorError> {
        let mut inertia = Inertia::default();
        let mut top = 0;
        for (f, front) in tree.fronts.iter().enumerate() {
            let own = front.rows.len().pow(2);
            let children = tree.passed_by_children(f);
            let panel = &mut factor[front.panel..front.panel + front.height() * front.width];
            let (held, free) = self.stack.split_at_mut(top);
            let next = &mut free[..own];
            panel.fill(0.0);
            next.fill(0.0);
            tree.enter(f, values, panel);
            let mut at = top - children;
            for &c in &tree.children[f] {
                let child = &tree.fronts[c as usize];
                let size = child.rows.len().pow(2);
                add(front, child, &held[at..at + size], panel, next);
                at += size;
            }
            let columns = front.first..front.first + front.width;
            let (below, order) = (&mut self.below[columns.clone()], &mut self.order[columns.clone()]);
            below.fill(0.0);
            let matrix = MatMut::from_column_major_slice_with_stride_mut(
                panel,
                front.height(),
                front.width,
                front.height(),
            );
            let (mut first, mut second) = matrix.split_at_row_mut(front.width);
            cholesky_in_place(
                first.rb_mut(),
                DiagMut::from_slice_mut(below),
                order,
                &mut self.inverse[columns],
                Par::Seq,
                MemStack::new(&mut self.dense),
                Default::default(),
            );
            count(&mut inertia, first.rb().diagonal().column_vector().iter().copied(), below)?;
            if own > 0 {
                let product = &mut self.product[..front.rows.len() * front.width];
                let mut product = MatMut::from_column_major_slice_mut(product, front.rows.len(), front.width);
                for (j, &from) in order.iter().enumerate() {
                    product.rb_mut().col_mut(j).copy_from(second.rb().col(from));
                }
                solve_unit_lower_triangular_in_place(first.rb(), product.rb_mut().transpose_mut(), Par::Seq);
                for j in 0..front.width {
                    second.rb_mut().col_mut(j).copy_from(product.rb().col(j));
                }
                let diagonal: Vec<f64> = (0..front.width).map(|j| first[(j, j)]).collect();
                divide_columns(&diagonal, below, second.rb_mut());
                triangular_matmul(
                    MatMut::from_column_major_slice_mut(next, front.rows.len(), front.rows.len()),
                    BlockStructure::TriangularLower,
                    Accum::Add,
                    second.rb(),
                    BlockStructure::Rectangular,
                    product.rb().transpose(),
                    BlockStructure::Rectangular,
                    -1.0,
                    Par::Seq,
                );
            }
            self.stack.copy_within(top..top + own, top - children);
            top = top - children + own;
        }
        Ok(inertia)
    }

    /// `B⁻¹` on the columns of a front.
    pub fn divide(&self, front: &Front, diagonal: impl Fn(usize) -> f64, x: &mut [f64]) {
        let below = &self.below[front.first..front.first + front.width];
        let mut j = 0;
        while j < x.len() {
            if below[j] == 0.0 || j + 1 == x.len() {
                x[j] /= diagonal(j);
                j += 1;
            } else {
                [x[j], x[j + 1]] = solve_pair([diagonal(j), below[j], diagonal(j + 1)], [x[j], x[j + 1]]);
                j += 2;
            }
        }
    }
}

/// `[[a, b], [b, c]]⁻¹ [x, y]`, divided by b first so that nothing overflows.
fn solve_pair([a, b, c]: [f64; 3], [x, y]: [f64; 2]) -> [f64; 2] {
    let (a, c, x, y) = (a / b, c / b, x / b, y / b);
    let determinant = a * c - 1.0;
    [(c * x - y) / determinant, (a * y - x) / determinant]
}

/// Columns times `B⁻¹`.
fn divide_columns(diagonal: &[f64], below: &[f64], mut m: MatMut<'_, f64>) {
    let mut j = 0;
    let scale = |column: ColMut<'_, f64>, d: f64| column.iter_mut().for_each(|x| *x /= d);
    while j < diagonal.len() {
        if below[j] == 0.0 || j + 1 == diagonal.len() {
            scale(m.rb_mut().col_mut(j), diagonal[j]);
            j += 1;
        } else {
            let block = [diagonal[j], below[j], diagonal[j + 1]];
            for i in 0..m.nrows() {
                [m[(i, j)], m[(i, j + 1)]] = solve_pair(block, [m[(i, j)], m[(i, j + 1)]]);
            }
            j += 2;
        }
    }
}

/// Counts the signs of the eigenvalues of B.
fn count(
    inertia: &mut Inertia,
    diagonal: impl Iterator<Item = f64>,
    below: &[f64],
) -> Result<(), FactorError> {
    let diagonal: Vec<f64> = diagonal.collect();
    let mut add = |d: f64| {
        if d > 0.0 {
            inertia.positive += 1;
        } else if d < 0.0 {
            inertia.negative += 1;
        } else {
            return Err(FactorError::Singular);
        }
        Ok(())
    };
    let mut j = 0;
    while j < diagonal.len() {
        if below[j] == 0.0 || j + 1 == diagonal.len() {
            add(diagonal[j])?;
            j += 1;
        } else {
            let (a, b, c) = (diagonal[j], below[j], diagonal[j + 1]);
            let (mean, radius) = (0.5 * (a + c), (0.5 * (a - c)).hypot(b));
            add(mean - radius)?;
            add(mean + radius)?;
            j += 2;
        }
    }
    Ok(())
}
