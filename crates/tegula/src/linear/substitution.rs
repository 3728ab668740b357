//! Solution with a multifrontal factor: forward through the tree, backward again, independent subtrees in parallel.

use faer::linalg::matmul::matmul;
use faer::linalg::triangular_solve::{
    solve_lower_triangular_in_place, solve_unit_lower_triangular_in_place,
    solve_unit_upper_triangular_in_place, solve_upper_triangular_in_place,
};
use faer::prelude::{Reborrow, ReborrowMut};
use faer::{Accum, MatMut, MatRef, Par};

use super::assembly_tree::{AssemblyTree, Front};
use super::elimination::{FrontPivots, PivotedBlocks};
use super::multifrontal::halves;

/// Work on a subtree: its front, its columns, its rows.
type Sweep<'a> = fn(&Solver<'a>, usize, &mut [f64], &mut [f64]);

/// Parts of a block column, and what it is pivoted with.
type Block<'a> = (MatRef<'a, f64>, MatRef<'a, f64>, MatRef<'a, f64>, Option<&'a PivotedBlocks>);

/// What the solution with the factor needs.
pub(super) struct Solver<'a> {
    pub tree: &'a AssemblyTree,
    pub factor: &'a [f64],
    /// Whether the subtree of a front is split between threads.
    pub split: &'a [bool],
    pub pivots: &'a [FrontPivots],
}

impl<'a> Solver<'a> {
    /// Block on the diagonal, rows below it that are columns of the front, rows that it passes on, and pivots.
    fn block(&self, f: usize, block: usize) -> Block<'_> {
        let front = &self.tree.fronts[f];
        let layout = front.layout();
        let columns = layout.columns_of(block);
        let values = &self.factor[front.panel..][layout.start(block)..layout.start(block + 1)];
        let matrix = MatRef::from_column_major_slice(values, layout.rows - columns.start, columns.len());
        let (first, rest) = matrix.split_at_row(columns.len());
        let (later, below) = rest.split_at_row(front.width - columns.end);
        (first, later, below, self.pivots[f].iter().find(|p| p.blocks.contains(&block)))
    }

    /// `L y = b` in a subtree; `x` are its columns, `y` the sums of its rows.
    pub fn forward(&self, f: usize, x: &mut [f64], y: &mut [f64]) {
        let fronts = &self.tree.fronts;
        let begin = &fronts[fronts[f].leaf];
        if self.split[f] {
            let front = &fronts[f];
            let (x_below, x_own) = x.split_at_mut(front.first - begin.first);
            let (y_below, y_own) = y.split_at_mut(front.row_start - begin.row_start);
            self.each(&self.tree.children[f], x_below, y_below, Self::forward);
            self.forward_front(f, x_own, y_own, y_below, begin.row_start);
        } else {
            for s in fronts[f].leaf..=f {
                let front = &fronts[s];
                let x_own = &mut x[front.first - begin.first..][..front.width];
                let (y_below, y_own) = y.split_at_mut(front.row_start - begin.row_start);
                self.forward_front(s, x_own, &mut y_own[..front.rows.len()], y_below, begin.row_start);
            }
        }
    }

    fn forward_front(&self, f: usize, x: &mut [f64], y: &mut [f64], below: &[f64], start: usize) {
        let front = &self.tree.fronts[f];
        y.fill(0.0);
        for &c in &self.tree.children[f] {
            let child = &self.tree.fronts[c as usize];
            let from = &below[child.row_start - start..][..child.rows.len()];
            for &[here, there, length] in &child.runs {
                let (here, length) = (here as usize, length as usize);
                let target = place(front, x, y, there as usize, length);
                for (t, s) in target.iter_mut().zip(&from[here..here + length]) {
                    *t += s;
                }
            }
        }
        let layout = front.layout();
        for block in 0..layout.blocks() {
            let (first, later, rows, pivots) = self.block(f, block);
            let columns = layout.columns_of(block);
            if let Some(p) = pivots
                && p.blocks.start == block
            {
                p.pivots.permute(&mut x[p.columns(front.width)]);
            }
            let (done, rest) = x.split_at_mut(columns.end);
            let own = &mut done[columns.start..];
            let mut own = column_mut(own);
            match pivots {
                None => solve_lower_triangular_in_place(first, own.rb_mut(), Par::Seq),
                Some(_) => solve_unit_lower_triangular_in_place(first, own.rb_mut(), Par::Seq),
            }
            let own = own.rb();
            if !rest.is_empty() {
                matmul(column_mut(rest), Accum::Add, later, own, -1.0, Par::Seq);
            }
            if !y.is_empty() {
                matmul(column_mut(y), Accum::Add, rows, own, -1.0, Par::Seq);
            }
        }
    }

    /// `Lᵀ x = y` in a subtree whose `y` holds the solution at the rows of its last front.
    pub fn backward(&self, f: usize, x: &mut [f64], y: &mut [f64]) {
        let fronts = &self.tree.fronts;
        let begin = &fronts[fronts[f].leaf];
        if self.split[f] {
            let front = &fronts[f];
            let (x_below, x_own) = x.split_at_mut(front.first - begin.first);
            let (y_below, y_own) = y.split_at_mut(front.row_start - begin.row_start);
            self.backward_front(f, x_own, y_own, y_below, begin.row_start);
            self.each(&self.tree.children[f], x_below, y_below, Self::backward);
        } else {
            for s in (fronts[f].leaf..=f).rev() {
                let front = &fronts[s];
                let x_own = &mut x[front.first - begin.first..][..front.width];
                let (y_below, y_own) = y.split_at_mut(front.row_start - begin.row_start);
                self.backward_front(s, x_own, &mut y_own[..front.rows.len()], y_below, begin.row_start);
            }
        }
    }

    fn backward_front(&self, f: usize, x: &mut [f64], y: &mut [f64], below: &mut [f64], start: usize) {
        let front = &self.tree.fronts[f];
        let layout = front.layout();
        for block in (0..layout.blocks()).rev() {
            let (first, later, rows, pivots) = self.block(f, block);
            let columns = layout.columns_of(block);
            if let Some(p) = pivots
                && p.blocks.end == block + 1
            {
                p.pivots.divide(&mut x[p.columns(front.width)]);
            }
            let (done, rest) = x.split_at_mut(columns.end);
            let own = &mut done[columns.start..];
            let mut matrix = column_mut(own);
            if !rest.is_empty() {
                matmul(matrix.rb_mut(), Accum::Add, later.transpose(), column(rest), -1.0, Par::Seq);
            }
            if !y.is_empty() {
                matmul(matrix.rb_mut(), Accum::Add, rows.transpose(), column(y), -1.0, Par::Seq);
            }
            match pivots {
                None => solve_upper_triangular_in_place(first.transpose(), matrix, Par::Seq),
                Some(_) => solve_unit_upper_triangular_in_place(first.transpose(), matrix, Par::Seq),
            }
            if let Some(p) = pivots
                && p.blocks.start == block
            {
                p.pivots.restore(&mut x[p.columns(front.width)]);
            }
        }
        for &c in &self.tree.children[f] {
            let child = &self.tree.fronts[c as usize];
            let to = &mut below[child.row_start - start..][..child.rows.len()];
            for &[here, there, length] in &child.runs {
                let (here, length) = (here as usize, length as usize);
                to[here..here + length].copy_from_slice(place(front, x, y, there as usize, length));
            }
        }
    }

    /// Works on the subtrees of one parent, halves of them in parallel.
    fn each(&self, children: &[u32], x: &mut [f64], y: &mut [f64], work: Sweep<'a>) {
        match children {
            [] => {}
            &[c] => work(self, c as usize, x, y),
            _ => {
                let (a, b) = children.split_at(halves(self.tree, children));
                let (Some(&begin), Some(&middle)) = (a.first(), b.first()) else { return };
                let leaf = |c: u32| &self.tree.fronts[self.tree.fronts[c as usize].leaf];
                let (begin, middle) = (leaf(begin), leaf(middle));
                let (x_a, x_b) = x.split_at_mut(middle.first - begin.first);
                let (y_a, y_b) = y.split_at_mut(middle.row_start - begin.row_start);
                rayon::join(|| self.each(a, x_a, y_a, work), || self.each(b, x_b, y_b, work));
            }
        }
    }
}

/// Where a run of places of a front is: among its columns or among its rows.
fn place<'a>(front: &Front, x: &'a mut [f64], y: &'a mut [f64], at: usize, length: usize) -> &'a mut [f64] {
    if at < front.width {
        &mut x[at..at + length]
    } else {
        &mut y[at - front.width..at - front.width + length]
    }
}

fn column(x: &[f64]) -> MatRef<'_, f64> {
    MatRef::from_column_major_slice(x, x.len(), 1)
}

fn column_mut(x: &mut [f64]) -> MatMut<'_, f64> {
    let n = x.len();
    MatMut::from_column_major_slice_mut(x, n, 1)
}
