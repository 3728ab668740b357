//! Solution with a multifrontal factor: forward through the tree, backward again, independent subtrees in parallel.

use std::ops::Range;
use std::sync::Mutex;

use faer::linalg::matmul::matmul;
use faer::linalg::triangular_solve::{
    solve_lower_triangular_in_place, solve_unit_lower_triangular_in_place,
    solve_unit_upper_triangular_in_place, solve_upper_triangular_in_place,
};
use faer::prelude::{Reborrow, ReborrowMut};
use faer::{Accum, MatMut, MatRef, Par};

use super::assembly_tree::{AssemblyTree, Front};
use super::elimination::{FrontPivots, PivotedBlocks};
use super::schedule::{Direction, Task, locked, run_all};

/// Parts of a block column, and what it is pivoted with.
type Block<'a> = (MatRef<'a, f64>, MatRef<'a, f64>, MatRef<'a, f64>, Option<&'a PivotedBlocks>);

/// What the solution with the factor needs.
pub(super) struct Solver<'a> {
    pub tree: &'a AssemblyTree,
    pub factor: &'a [f64],
    /// What is worked off at a time.
    pub tasks: &'a [Task],
    /// Whether the subtree of a front is split between threads.
    pub split: &'a [bool],
    pub pivots: &'a [FrontPivots],
}

impl Solver<'_> {
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

    /// `L Lᵀ x = b` in place of `x`, by columns in the order of the elimination. `y` is memory for all rows.
    pub fn solve(&self, mut x: &mut [f64], mut y: &mut [f64]) {
        let mut take = |task: &Task| {
            let fronts = &self.tree.fronts[task.fronts.clone()];
            let sizes = fronts.iter().map(|f| (f.width, f.rows.len()));
            let (columns, rows) = sizes.fold((0, 0), |sum, f| (sum.0 + f.0, sum.1 + f.1));
            let (x_own, x_rest) = std::mem::take(&mut x).split_at_mut(columns);
            let (y_own, y_rest) = std::mem::take(&mut y).split_at_mut(rows);
            (x, y) = (x_rest, y_rest);
            (x_own, y_own)
        };
        if !self.split.contains(&true) {
            for task in self.tasks {
                let (x, y) = take(task);
                self.forward(task.fronts.clone(), x, y);
                self.backward(task.fronts.clone(), x, y);
            }
            return;
        }
        let slots: Vec<_> = self.tasks.iter().map(|task| Mutex::new(take(task))).collect();
        let threads = rayon::current_num_threads();
        let up = run_all(self.tasks, threads, Direction::Up, |t| {
            let (task, mut own) = (&self.tasks[t], locked(&slots[t]));
            let (x, y) = &mut *own;
            if self.split[task.fronts.start] {
                let f = task.fronts.start;
                y.fill(0.0);
                for (&c, &child) in task.children.iter().zip(&self.tree.children[f]) {
                    let child = &self.tree.fronts[child as usize];
                    let below = &locked(&slots[c as usize]).1;
                    add_sums(child, &below[below.len() - child.rows.len()..], &self.tree.fronts[f], x, y);
                }
                self.forward_front(f, x, y);
            } else {
                self.forward(task.fronts.clone(), x, y);
            }
            Ok(())
        });
        let down = run_all(self.tasks, threads, Direction::Down, |t| {
            let (task, mut own) = (&self.tasks[t], locked(&slots[t]));
            let (x, y) = &mut *own;
            if self.split[task.fronts.start] {
                let f = task.fronts.start;
                self.backward_front(f, x, y);
                for (&c, &child) in task.children.iter().zip(&self.tree.children[f]) {
                    let child = &self.tree.fronts[child as usize];
                    let below = &mut locked(&slots[c as usize]).1;
                    let rows = below.len() - child.rows.len();
                    pass_on(&self.tree.fronts[f], x, y, child, &mut below[rows..]);
                }
            } else {
                self.backward(task.fronts.clone(), x, y);
            }
            Ok(())
        });
        debug_assert!(up.is_ok() && down.is_ok(), "substitutions do not fail");
    }

    /// `L y = b` in a subtree, front by front; `x` are its columns, `y` the sums of its rows.
    fn forward(&self, subtree: Range<usize>, x: &mut [f64], y: &mut [f64]) {
        let fronts = &self.tree.fronts;
        let begin = &fronts[subtree.start];
        for f in subtree {
            let front = &fronts[f];
            let x = &mut x[front.first - begin.first..][..front.width];
            let (below, y) = y.split_at_mut(front.row_start - begin.row_start);
            let y = &mut y[..front.rows.len()];
            y.fill(0.0);
            for &c in &self.tree.children[f] {
                let child = &fronts[c as usize];
                let sums = &below[child.row_start - begin.row_start..][..child.rows.len()];
                add_sums(child, sums, front, x, y);
            }
            self.forward_front(f, x, y);
        }
    }

    fn forward_front(&self, f: usize, x: &mut [f64], y: &mut [f64]) {
        let front = &self.tree.fronts[f];
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
    fn backward(&self, subtree: Range<usize>, x: &mut [f64], y: &mut [f64]) {
        let fronts = &self.tree.fronts;
        let begin = &fronts[subtree.start];
        for f in subtree.rev() {
            let front = &fronts[f];
            let x = &mut x[front.first - begin.first..][..front.width];
            let (below, y) = y.split_at_mut(front.row_start - begin.row_start);
            let y = &mut y[..front.rows.len()];
            self.backward_front(f, x, y);
            for &c in &self.tree.children[f] {
                let child = &fronts[c as usize];
                let to = &mut below[child.row_start - begin.row_start..][..child.rows.len()];
                pass_on(front, x, y, child, to);
            }
        }
    }

    fn backward_front(&self, f: usize, x: &mut [f64], y: &mut [f64]) {
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
    }
}

/// Adds the sums of a child's rows to those of its parent.
fn add_sums(child: &Front, sums: &[f64], front: &Front, x: &mut [f64], y: &mut [f64]) {
    for &[here, there, length] in &child.runs {
        let (here, length) = (here as usize, length as usize);
        let target = place(front, x, y, there as usize, length);
        for (t, s) in target.iter_mut().zip(&sums[here..here + length]) {
            *t += s;
        }
    }
}

/// Tells a child the solution at its rows.
fn pass_on(front: &Front, x: &mut [f64], y: &mut [f64], child: &Front, to: &mut [f64]) {
    for &[here, there, length] in &child.runs {
        let (here, length) = (here as usize, length as usize);
        to[here..here + length].copy_from_slice(place(front, x, y, there as usize, length));
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
