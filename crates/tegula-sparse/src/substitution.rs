//! Forward and backward substitution with a multifrontal factor, independent subtrees in parallel.
//!
//! The sweeps are the same for one right side and for a group of them, whose values at an unknown are one entry of the
//! vectors.

use pulp::Arch;

use super::assembly_tree::{AssemblyTree, Front};
use super::block_column::{Backward, BlockColumn, Forward};
use super::multifrontal::panel;
use super::partial_factorization::{FrontPivots, PivotedBlocks};
use super::right_sides::{BackwardGroup, ForwardGroup};
use super::rook_pivoting::BlockPivots;

/// Sweep over a subtree, given its last front and the vectors of its columns and of its rows.
type Sweep<S, T> = fn(&S, usize, &mut [T], &mut [T]);

/// Entry of the vectors of a solution: the value of one right side, or the values of a group of right sides.
pub(super) trait RightSides: Copy + Send {
    /// Entry of the zero vector.
    const ZERO: Self;

    /// Adds another entry.
    fn add(&mut self, other: &Self);

    /// Forward substitution with a block column; `x` are the entries from its columns on, `y` the sums of the rows.
    fn forward(arch: Arch, block: BlockColumn<'_>, x: &mut [Self], y: &mut [Self]);

    /// Backward substitution with a block column; `y` is the solution at the rows.
    fn backward(arch: Arch, block: BlockColumn<'_>, x: &mut [Self], y: &[Self]);

    /// Solves with the pivots, `x := B⁻¹ x`.
    fn divide(pivots: &BlockPivots, x: &mut [Self]);
}

impl RightSides for f64 {
    const ZERO: Self = 0.0;

    #[inline(always)]
    fn add(&mut self, other: &Self) {
        *self += other;
    }

    fn forward(arch: Arch, block: BlockColumn<'_>, x: &mut [Self], y: &mut [Self]) {
        arch.dispatch(Forward { block, x, y });
    }

    fn backward(arch: Arch, block: BlockColumn<'_>, x: &mut [Self], y: &[Self]) {
        arch.dispatch(Backward { block, x, y });
    }

    fn divide(pivots: &BlockPivots, x: &mut [Self]) {
        pivots.divide(x.as_chunks_mut::<1>().0);
    }
}

impl<const K: usize> RightSides for [f64; K] {
    const ZERO: Self = [0.0; K];

    #[inline(always)]
    fn add(&mut self, other: &Self) {
        for (t, s) in self.iter_mut().zip(other) {
            *t += s;
        }
    }

    fn forward(arch: Arch, block: BlockColumn<'_>, x: &mut [Self], y: &mut [Self]) {
        arch.dispatch(ForwardGroup { block, x, y });
    }

    fn backward(arch: Arch, block: BlockColumn<'_>, x: &mut [Self], y: &[Self]) {
        arch.dispatch(BackwardGroup { block, x, y });
    }

    fn divide(pivots: &BlockPivots, x: &mut [Self]) {
        pivots.divide(x);
    }
}

/// Data of the substitutions: assembly tree, factor and pivots.
pub(super) struct Solver<'a> {
    pub tree: &'a AssemblyTree,
    pub factor: &'a [f64],
    /// Panels of the fronts stored in place of the values.
    pub in_place: &'a [f64],
    /// Node-level fronts: fronts whose subtree is divided among threads.
    pub node_level: &'a [bool],
    pub pivots: &'a [FrontPivots],
    pub arch: Arch,
}

impl Solver<'_> {
    /// Block column of a front, and its pivots if the diagonal block is not positive definite.
    fn block(&self, f: usize, block: usize) -> (BlockColumn<'_>, Option<&PivotedBlocks>) {
        let front = &self.tree.fronts[f];
        let layout = front.layout();
        let values =
            &panel(self.factor, self.in_place, front.panel)[layout.start(block)..layout.start(block + 1)];
        let pivots = self.pivots[f].of(block);
        (BlockColumn { values, width: layout.columns_of(block).len(), unit: pivots.is_some() }, pivots)
    }

    /// Solves `L Lᵀ x = b` in place of `x`, in elimination order. `y` is workspace for the rows of all fronts.
    pub fn solve<T: RightSides>(&self, x: &mut [T], y: &mut [T]) {
        self.each_root(x, y, |solver, f, x, y| {
            solver.forward(f, x, y);
            solver.backward(f, x, y);
        });
    }

    /// Forward substitution `L y = b` in place of `x`; the columns of the interface get their Schur update.
    pub fn condense<T: RightSides>(&self, x: &mut [T], y: &mut [T]) {
        self.each_root(x, y, Self::forward);
    }

    /// Backward substitution `Lᵀ x = y` in place of `x`, whose columns of the interface hold the solution.
    pub fn expand<T: RightSides>(&self, x: &mut [T], y: &mut [T]) {
        self.each_root(x, y, Self::backward);
    }

    /// Sweeps over the trees of all roots, one after another.
    fn each_root<T>(
        &self,
        mut x: &mut [T],
        mut y: &mut [T],
        sweep: impl Fn(&Self, usize, &mut [T], &mut [T]),
    ) {
        let fronts = &self.tree.fronts;
        for (f, front) in fronts.iter().enumerate().filter(|(_, front)| front.parent.is_none()) {
            let (x_own, x_rest) = x.split_at_mut(front.first + front.width - fronts[front.leaf].first);
            let (y_own, y_rest) =
                y.split_at_mut(front.row_start + front.rows.len() - fronts[front.leaf].row_start);
            sweep(self, f, x_own, y_own);
            (x, y) = (x_rest, y_rest);
        }
    }

    /// Only node-level child of a node-level front, if it has exactly one. Assembly trees of long strips are chains of
    /// such fronts; a loop walks them, since the call stack of a thread does not suffice for a recursion. Branches off
    /// the chain are small, or lie below its end, where the work divides.
    fn only_node_level_child(&self, f: usize) -> Option<usize> {
        let mut node_level =
            self.tree.children[f].iter().map(|&c| c as usize).filter(|&c| self.node_level[c]);
        node_level.next().filter(|_| node_level.next().is_none())
    }

    /// Columns and rows of a front of the subtree that begins with `leaf`, and the rows of the fronts before it.
    fn parts<'b, T>(
        &self,
        f: usize,
        leaf: usize,
        x: &'b mut [T],
        y: &'b mut [T],
    ) -> (&'b mut [T], &'b mut [T], &'b mut [T]) {
        let (front, begin) = (&self.tree.fronts[f], &self.tree.fronts[leaf]);
        let (below, y) = y.split_at_mut(front.row_start - begin.row_start);
        (&mut x[front.first - begin.first..][..front.width], &mut y[..front.rows.len()], below)
    }

    /// Forward substitution `L y = b` in a subtree; `x` holds its columns, `y` the sums of its rows.
    fn forward<T: RightSides>(&self, f: usize, x: &mut [T], y: &mut [T]) {
        let leaf = self.tree.fronts[f].leaf;
        if !self.node_level[f] {
            (leaf..=f).for_each(|s| self.forward_after_children(s, leaf, x, y));
            return;
        }
        let mut at = f;
        while let Some(child) = self.only_node_level_child(at) {
            at = child;
        }
        let mut done = None;
        loop {
            self.each(leaf, &self.tree.children[at], done, x, y, Self::forward);
            self.forward_after_children(at, leaf, x, y);
            let Some(parent) = self.tree.fronts[at].parent.filter(|_| at != f) else { return };
            done = Some(at as u32);
            at = parent as usize;
        }
    }

    /// Forward substitution with one front, after its children, in the subtree that begins with `leaf`.
    fn forward_after_children<T: RightSides>(&self, f: usize, leaf: usize, x: &mut [T], y: &mut [T]) {
        let fronts = &self.tree.fronts;
        let (x, y, below) = self.parts(f, leaf, x, y);
        y.fill(T::ZERO);
        for &c in &self.tree.children[f] {
            let child = &fronts[c as usize];
            let sums = &below[child.row_start - fronts[leaf].row_start..][..child.rows.len()];
            add_sums(child, sums, &fronts[f], x, y);
        }
        self.forward_front(f, x, y);
    }

    fn forward_front<T: RightSides>(&self, f: usize, x: &mut [T], y: &mut [T]) {
        if self.tree.is_interface(f) {
            return;
        }
        let front = &self.tree.fronts[f];
        let layout = front.layout();
        for block in 0..layout.blocks() {
            let (values, pivots) = self.block(f, block);
            if let Some(p) = pivots
                && p.blocks.start == block
            {
                p.pivots.permute(&mut x[p.columns(front.width)]);
            }
            let x = &mut x[layout.columns_of(block).start..];
            T::forward(self.arch, values, x, y);
        }
    }

    /// Backward substitution `Lᵀ x = y` in a subtree whose `y` holds the solution at the rows of its last front.
    fn backward<T: RightSides>(&self, f: usize, x: &mut [T], y: &mut [T]) {
        let leaf = self.tree.fronts[f].leaf;
        if !self.node_level[f] {
            (leaf..=f).rev().for_each(|s| self.backward_before_children(s, leaf, x, y));
            return;
        }
        let mut next = Some(f);
        while let Some(at) = next {
            self.backward_before_children(at, leaf, x, y);
            next = self.only_node_level_child(at);
            self.each(leaf, &self.tree.children[at], next.map(|c| c as u32), x, y, Self::backward);
        }
    }

    /// Backward substitution with one front, before its children, in the subtree that begins with `leaf`.
    fn backward_before_children<T: RightSides>(&self, f: usize, leaf: usize, x: &mut [T], y: &mut [T]) {
        let fronts = &self.tree.fronts;
        let (x, y, below) = self.parts(f, leaf, x, y);
        self.backward_front(f, x, y);
        for &c in &self.tree.children[f] {
            let child = &fronts[c as usize];
            let to = &mut below[child.row_start - fronts[leaf].row_start..][..child.rows.len()];
            copy_solution(&fronts[f], x, y, child, to);
        }
    }

    /// Sweeps over the subtrees of `children` except `but`, halves of them in parallel. `x` and `y` belong to the
    /// subtree that begins with `leaf`.
    fn each<T: RightSides>(
        &self,
        leaf: usize,
        children: &[u32],
        but: Option<u32>,
        x: &mut [T],
        y: &mut [T],
        work: Sweep<Self, T>,
    ) {
        let fronts = &self.tree.fronts;
        match children {
            [] => {}
            &[c] if but == Some(c) => {}
            &[c] => {
                let (front, first, begin) =
                    (&fronts[c as usize], &fronts[fronts[c as usize].leaf], &fronts[leaf]);
                let x = &mut x[first.first - begin.first..front.first + front.width - begin.first];
                let y = &mut y[first.row_start - begin.row_start..]
                    [..front.row_start + front.rows.len() - first.row_start];
                work(self, c as usize, x, y);
            }
            _ => {
                let (a, b) = children.split_at(self.half(children));
                let Some(&middle) = b.first() else { return };
                let (middle, begin) = (fronts[middle as usize].leaf, &fronts[leaf]);
                let (x_a, x_b) = x.split_at_mut(fronts[middle].first - begin.first);
                let (y_a, y_b) = y.split_at_mut(fronts[middle].row_start - begin.row_start);
                rayon::join(
                    || self.each(leaf, a, but, x_a, y_a, work),
                    || self.each(middle, b, but, x_b, y_b, work),
                );
            }
        }
    }

    /// Number of the first children that make up half of the work of all.
    fn half(&self, children: &[u32]) -> usize {
        let work = |c: &u32| self.tree.fronts[*c as usize].flops;
        let total: f64 = children.iter().map(work).sum();
        let mut sum = 0.0;
        for (k, c) in children.iter().enumerate() {
            if sum + 0.5 * work(c) > 0.5 * total {
                return k.clamp(1, children.len() - 1);
            }
            sum += work(c);
        }
        children.len() - 1
    }

    fn backward_front<T: RightSides>(&self, f: usize, x: &mut [T], y: &mut [T]) {
        if self.tree.is_interface(f) {
            return;
        }
        let front = &self.tree.fronts[f];
        let layout = front.layout();
        for block in (0..layout.blocks()).rev() {
            let (values, pivots) = self.block(f, block);
            if let Some(p) = pivots
                && p.blocks.end == block + 1
            {
                T::divide(&p.pivots, &mut x[p.columns(front.width)]);
            }
            let below = &mut x[layout.columns_of(block).start..];
            T::backward(self.arch, values, below, y);
            if let Some(p) = pivots
                && p.blocks.start == block
            {
                p.pivots.restore(&mut x[p.columns(front.width)]);
            }
        }
    }
}

/// Extend-add of a child's row sums to the columns and rows of its parent.
fn add_sums<T: RightSides>(child: &Front, sums: &[T], front: &Front, x: &mut [T], y: &mut [T]) {
    for &[here, there, length] in &child.relative_indices {
        let (here, length) = (here as usize, length as usize);
        let target = place(front, x, y, there as usize, length);
        for (t, s) in target.iter_mut().zip(&sums[here..here + length]) {
            t.add(s);
        }
    }
}

/// Copies the solution from the parent's columns and rows to the rows of a child.
fn copy_solution<T: Copy>(front: &Front, x: &mut [T], y: &mut [T], child: &Front, to: &mut [T]) {
    for &[here, there, length] in &child.relative_indices {
        let (here, length) = (here as usize, length as usize);
        to[here..here + length].copy_from_slice(place(front, x, y, there as usize, length));
    }
}

/// Entries of a run of relative indices of a front, which lie among its columns or among its rows.
fn place<'a, T>(front: &Front, x: &'a mut [T], y: &'a mut [T], at: usize, length: usize) -> &'a mut [T] {
    if at < front.width {
        &mut x[at..at + length]
    } else {
        &mut y[at - front.width..at - front.width + length]
    }
}
