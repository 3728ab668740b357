//! Numeric factorisation: extend-add and elimination of fronts, one after another in a subtree or one front by all
//! threads.

use pulp::Arch;
use std::ops::Range;

use super::FactorError;
use super::assembly_tree::{AssemblyTree, Front};
use super::dense::DiagonalBlock;
use super::partial_factorization::{FrontPivots, PartialFactorization, half};
use super::trapezoid::{BLOCK, Trapezoid};
use super::workspace::{Buffer, Workspace};

/// Original entries of the matrix.
pub(super) enum Entries<'a> {
    /// Values of the whole matrix.
    All(&'a [f64]),
    /// Copy of the original entries of the last fronts: number of the first of these fronts, start of each front's
    /// entries, and the entries.
    Collected(usize, &'a [usize], &'a [f64]),
}

/// Storage of consecutive fronts: panels and pivots.
#[derive(Default)]
pub(super) struct Part<'a> {
    pub panels: &'a mut [f64],
    pub pivots: &'a mut [FrontPivots],
    /// Panel of the interface if it is the last of the fronts and its panel is not among `panels`.
    pub interface: &'a mut [f64],
}

/// Shared data of the numeric factorisation of all fronts.
pub(super) struct Numeric<'a> {
    pub tree: &'a AssemblyTree,
    pub workspace: &'a Workspace,
    pub entries: Entries<'a>,
    /// Equilibration scales of the unknowns; they switch on threshold pivoting.
    pub scales: Option<&'a [f64]>,
    pub arch: Arch,
}

impl Numeric<'_> {
    /// Factors a front with node-level parallelism. `from` holds the contribution blocks of its children; returns its
    /// own.
    pub fn factor_front(&self, f: usize, part: Part<'_>, from: Vec<Buffer>) -> Result<Buffer, FactorError> {
        let front = &self.tree.fronts[f];
        let (layout, contribution) = (front.layout(), front.contribution());
        let Part { panels: panel, pivots, .. } = part;
        self.extend_add_children(f, &from, (layout, 0), 0..layout.blocks(), panel);
        self.add_entries(f, panel);
        let (pivots, diagonal_block) = (&mut pivots[0], &mut DiagonalBlock::new());
        let mut work = PartialFactorization {
            layout,
            pivots,
            diagonal_block,
            parallel: true,
            scales: self.scales(f),
            may_delay: !self.tree.is_below_interface(f),
        };
        if !self.tree.is_interface(f) {
            work.eliminate(panel)?;
        }
        let mut memory = self.workspace.pool.take(contribution.size())?;
        let out = &mut memory[..contribution.size()];
        work.contribution(panel, out);
        self.extend_add_children(f, &from, (contribution, front.width), 0..contribution.blocks(), out);
        from.into_iter().for_each(|piece| self.workspace.pool.put(piece));
        Ok(memory)
    }

    /// Extend-add of all children's contribution blocks to some block columns of a front, halves of them in parallel.
    fn extend_add_children(
        &self,
        f: usize,
        from: &[Buffer],
        (to, offset): (Trapezoid, usize),
        blocks: Range<usize>,
        values: &mut [f64],
    ) {
        if blocks.len() > 1 {
            let middle = half(to, &blocks);
            let (left, right) = values.split_at_mut(to.start(middle) - to.start(blocks.start));
            rayon::join(
                || self.extend_add_children(f, from, (to, offset), blocks.start..middle, left),
                || self.extend_add_children(f, from, (to, offset), middle..blocks.end, right),
            );
            return;
        }
        if offset == 0 {
            values.fill(0.0);
        }
        for (&c, from) in self.tree.children[f].iter().zip(from) {
            self.extend_add(&self.tree.fronts[c as usize], from, (to, offset), &blocks, values);
        }
    }

    /// Factors a subtree front by front. `size` is the largest size of its contribution-block stack; returns the
    /// contribution block of the last front.
    pub fn factor_subtree(
        &self,
        subtree: Range<usize>,
        size: usize,
        part: Part<'_>,
    ) -> Result<Buffer, FactorError> {
        let fronts = &self.tree.fronts;
        let leaf = subtree.start;
        let start = fronts[leaf].panel;
        let mut stack = self.workspace.pool.take(size)?;
        let mut out = Buffer::default();
        let diagonal_block = &mut *self.workspace.diagonal_block();
        let mut top = 0;
        for s in subtree.clone() {
            let front = &fronts[s];
            let last = s + 1 == subtree.end;
            let (layout, contribution) = (front.layout(), front.contribution());
            let own = contribution.size();
            let panel = if self.tree.is_interface(s) && !part.interface.is_empty() {
                &mut *part.interface
            } else {
                &mut part.panels[front.panel - start..][..layout.size()]
            };
            let children = self.tree.contributions_of_children(s);
            let (held, free) = stack.split_at_mut(top);
            let next = if last {
                out = self.workspace.pool.take(own)?;
                &mut out[..own]
            } else {
                &mut free[..own]
            };
            let from_children = |to: Trapezoid, offset, values: &mut [f64]| {
                let mut at = top - children;
                for &c in &self.tree.children[s] {
                    let child = &fronts[c as usize];
                    self.extend_add(child, &held[at..], (to, offset), &(0..to.blocks()), values);
                    at += child.contribution().size();
                }
            };
            panel.fill(0.0);
            from_children(layout, 0, panel);
            self.add_entries(s, panel);
            let mut work = PartialFactorization {
                layout,
                pivots: &mut part.pivots[s - leaf],
                diagonal_block,
                parallel: false,
                scales: self.scales(s),
                may_delay: !self.tree.is_below_interface(s),
            };
            if !self.tree.is_interface(s) {
                work.eliminate(panel)?;
            }
            work.contribution(panel, next);
            from_children(contribution, front.width, next);
            if !last && children > 0 {
                stack.copy_within(top..top + own, top - children);
            }
            top = top - children + own;
        }
        self.workspace.pool.put(stack);
        Ok(out)
    }

    /// Adds the original entries of a front to its panel.
    fn add_entries(&self, f: usize, panel: &mut [f64]) {
        match self.entries {
            Entries::All(values) => self.tree.entries.add_entries(f, values, panel),
            Entries::Collected(from, starts, values) => {
                self.tree.entries.add_collected(f, &values[starts[f - from]..], panel);
            }
        }
    }

    /// Equilibration scales of the rows of a front, for threshold pivoting only.
    fn scales(&self, f: usize) -> Option<Vec<f64>> {
        let front = &self.tree.fronts[f];
        let scale = |place: usize| Some(self.scales?[self.tree.order[place] as usize]);
        let columns = front.first..front.first + front.width;
        columns.chain(front.rows.iter().map(|&row| row as usize)).map(scale).collect()
    }

    /// Extend-add of one child by [`extend_add`], compiled for the SIMD registers of this machine.
    fn extend_add(
        &self,
        child: &Front,
        from: &[f64],
        to: (Trapezoid, usize),
        blocks: &Range<usize>,
        values: &mut [f64],
    ) {
        self.arch.dispatch(|| extend_add(child, from, to, blocks, values));
    }
}

/// Extend-add: adds a child's contribution block, by its relative indices, to block columns of the parent's front. They
/// belong to the trapezoid `to`, whose first column has the number `offset` in that front; `values` are the block
/// columns.
#[inline(always)]
fn extend_add(
    child: &Front,
    from: &[f64],
    (to, offset): (Trapezoid, usize),
    blocks: &Range<usize>,
    values: &mut [f64],
) {
    let source = child.contribution();
    let start = to.start(blocks.start);
    let first = offset + blocks.start * BLOCK;
    let end = offset + (blocks.end * BLOCK).min(to.columns);
    for (k, &[here, there, length]) in child.relative_indices.iter().enumerate() {
        let (here, there, length) = (here as usize, there as usize, length as usize);
        for place in there.max(first)..(there + length).min(end) {
            let column = here + place - there;
            let source = &from[source.diagonal(column)..];
            let target = &mut values[to.diagonal(place - offset) - start..];
            // The remainder of this run is added first, then the runs below it.
            let rest = there + length - place;
            add_run(&mut target[..rest], &source[..rest]);
            for &[here, there, length] in &child.relative_indices[k + 1..] {
                let (here, there, length) = (here as usize, there as usize, length as usize);
                add_run(&mut target[there - place..][..length], &source[here - column..][..length]);
            }
        }
    }
}

#[inline(always)]
fn add_run(target: &mut [f64], source: &[f64]) {
    for (t, s) in target.iter_mut().zip(source) {
        *t += s;
    }
}
