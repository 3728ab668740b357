//! Solutions with a multifrontal factor: one right side, groups of them, and the two halves that a Schur complement
//! needs.

use pulp::Arch;

use super::super::FactorError;
use super::super::substitution::Solver;
use super::super::workspace::Workspace;
use super::Multifrontal;

/// Number of right sides that are solved together; a last group of few takes the narrow kernel.
const WIDE_GROUP: usize = 16;
const NARROW_GROUP: usize = 8;

impl Multifrontal {
    /// Solves `A x = b` with the factor, in place of `right_side`.
    ///
    /// # Errors
    /// There is no memory for the row sums.
    pub fn solve(&mut self, right_side: &mut [f64]) -> Result<(), FactorError> {
        self.sweep(right_side, |solver, columns, rows| solver.solve(columns, rows))
    }

    /// Forward substitution in place of `right_side`, which subtracts `A_ΓI A_II⁻¹ f_I` at the interface.
    ///
    /// # Errors
    /// There is no memory for the row sums.
    pub fn condense(&mut self, right_side: &mut [f64]) -> Result<(), FactorError> {
        self.sweep(right_side, |solver, columns, rows| solver.condense(columns, rows))
    }

    /// Backward substitution in place of `vector`, which holds the solution at the interface and the result of
    /// [`condense`](Self::condense) elsewhere.
    ///
    /// # Errors
    /// There is no memory for the row sums.
    pub fn expand(&mut self, vector: &mut [f64]) -> Result<(), FactorError> {
        self.sweep(vector, |solver, columns, rows| solver.expand(columns, rows))
    }

    /// Copies the lower triangle of the Schur complement of the interior to `out`, a square matrix by columns. `place`
    /// gives the row there of an unknown of the interface.
    pub fn copy_schur_complement(&self, out: &mut [f64], place: impl Fn(u32) -> usize) {
        let m = self.tree.interface;
        if m == 0 {
            return;
        }
        let f = self.tree.fronts.len() - 1;
        let (front, panel) = (&self.tree.fronts[f], self.panel(f));
        let layout = front.layout();
        let places: Vec<usize> = self.tree.order[front.first..].iter().map(|&old| place(old)).collect();
        let in_order = places.iter().enumerate().all(|(j, &place)| j == place);
        for (j, &column) in places.iter().enumerate() {
            let entries = &panel[layout.diagonal(j)..][..m - j];
            if in_order {
                out[j * m + j..(j + 1) * m].copy_from_slice(entries);
                continue;
            }
            for (&row, value) in places[j..].iter().zip(entries) {
                out[column.min(row) * m + column.max(row)] = *value;
            }
        }
    }

    /// Applies a substitution to a vector, given the solver, the vector in elimination order and workspace for the rows
    /// of all fronts.
    fn sweep(
        &mut self,
        right_side: &mut [f64],
        work: impl FnOnce(&Solver, &mut [f64], &mut [f64]),
    ) -> Result<(), FactorError> {
        let Self { tree, factor, value_memory, node_level, workspace, pivots, .. } = self;
        let Workspace { pool, columns, .. } = workspace;
        let mut rows = pool.take_alone(tree.rows)?;
        columns.clear();
        columns.extend(tree.order.iter().map(|&old| right_side[old as usize]));
        let arch = Arch::new();
        let solver = Solver { tree, factor, in_place: value_memory, node_level, pivots, arch };
        work(&solver, columns, &mut rows[..tree.rows]);
        for (x, &old) in columns.iter().zip(&tree.order) {
            right_side[old as usize] = *x;
        }
        pool.put(rows);
        Ok(())
    }

    /// Solves `A X = B` with the factor, in place of the right sides, which are columns one after another: in groups of
    /// [`WIDE_GROUP`], then one or two of [`NARROW_GROUP`], the last one filled up with zeros.
    ///
    /// # Errors
    /// There is no memory for the workspace of a group.
    pub fn solve_many(&mut self, right_sides: &mut [f64]) -> Result<(), FactorError> {
        let n = self.tree.order.len();
        let mut rest = right_sides;
        while !rest.is_empty() {
            let wide = rest.len() > NARROW_GROUP * n;
            let most = if wide { WIDE_GROUP } else { NARROW_GROUP } * n;
            let group = rest.split_off_mut(..most.min(rest.len())).unwrap_or_default();
            if wide {
                self.solve_group::<WIDE_GROUP>(group)?;
            } else {
                self.solve_group::<NARROW_GROUP>(group)?;
            }
        }
        Ok(())
    }

    /// Solves with a group of up to K right sides.
    fn solve_group<const K: usize>(&mut self, right_sides: &mut [f64]) -> Result<(), FactorError> {
        let Self { tree, factor, value_memory, node_level, workspace, pivots, .. } = self;
        let n = tree.order.len();
        let size = (n + tree.rows).checked_mul(K).ok_or(FactorError::TooLarge)?;
        let mut memory = workspace.pool.take_alone(size)?;
        let (columns, rows) = memory[..size].as_chunks_mut::<K>().0.split_at_mut(n);
        for (x, &old) in columns.iter_mut().zip(&tree.order) {
            *x = [0.0; K];
            for (x, b) in x.iter_mut().zip(right_sides.chunks_exact(n)) {
                *x = b[old as usize];
            }
        }
        Solver { tree, factor, in_place: value_memory, node_level, pivots, arch: Arch::new() }
            .solve(columns, rows);
        for (x, &old) in columns.iter().zip(&tree.order) {
            for (x, b) in x.iter().zip(right_sides.chunks_exact_mut(n)) {
                b[old as usize] = *x;
            }
        }
        workspace.pool.put(memory);
        Ok(())
    }
}
