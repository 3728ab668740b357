//! Assembly and elimination of fronts: one after another in a subtree, or one by all threads.

use std::ops::Range;
use std::sync::{Mutex, MutexGuard};

use pulp::Arch;

use super::FactorError;
use super::assembly_tree::{AssemblyTree, Front};
use super::elimination::{Elimination, FrontPivots, half};
use super::pool::{Piece, Pool};
use super::schedule::locked;
use super::trapezoid::{BLOCK, Trapezoid};
use super::triangle::Triangle;

/// Entries of the matrix.
pub(super) enum Entries<'a> {
    /// All of them.
    All(&'a [f64]),
    /// Those of the fronts from a number on: where those of each begin, and the entries.
    Collected(usize, &'a [usize], &'a [f64]),
}

/// What belongs to consecutive fronts: panels and pivots.
#[derive(Default)]
pub(super) struct Part<'a> {
    pub panels: &'a mut [f64],
    pub pivots: &'a mut [FrontPivots],
}

/// What all fronts need to be factored.
pub(super) struct Numeric<'a> {
    pub tree: &'a AssemblyTree,
    pub pool: &'a Pool,
    /// Memory for a block, one for each thread.
    pub triangles: &'a [Mutex<Triangle>],
    pub entries: Entries<'a>,
    /// Scales of the unknowns, where pivots are chosen with care.
    pub wary: Option<&'a [f64]>,
    pub arch: Arch,
}

impl Numeric<'_> {
    /// Factors a front, threads together. `from` is what its children pass on; returns what it passes on itself.
    pub fn together(&self, f: usize, part: Part<'_>, from: Vec<Piece>) -> Result<Piece, FactorError> {
        let front = &self.tree.fronts[f];
        let (layout, passed) = (front.layout(), front.passed());
        let Part { panels: panel, pivots } = part;
        self.assemble(f, &from, (layout, 0), 0..layout.blocks(), panel);
        self.enter(f, panel);
        let (pivots, triangle) = (&mut pivots[0], &mut Triangle::new());
        let mut work = Elimination { layout, pivots, triangle, parallel: true, wary: self.scales(f) };
        work.columns(panel)?;
        let mut memory = self.pool.take(passed.size())?;
        let out = &mut memory[..passed.size()];
        work.rest(panel, out);
        self.assemble(f, &from, (passed, front.width), 0..passed.blocks(), out);
        from.into_iter().for_each(|piece| self.pool.put(piece));
        Ok(memory)
    }

    /// Adds what the children of a front pass on to some of its block columns, halves of them in parallel.
    fn assemble(
        &self,
        f: usize,
        from: &[Piece],
        (to, offset): (Trapezoid, usize),
        blocks: Range<usize>,
        values: &mut [f64],
    ) {
        if blocks.len() > 1 {
            let middle = half(to, &blocks);
            let (left, right) = values.split_at_mut(to.start(middle) - to.start(blocks.start));
            rayon::join(
                || self.assemble(f, from, (to, offset), blocks.start..middle, left),
                || self.assemble(f, from, (to, offset), middle..blocks.end, right),
            );
            return;
        }
        if offset == 0 {
            values.fill(0.0);
        }
        for (&c, from) in self.tree.children[f].iter().zip(from) {
            self.add(&self.tree.fronts[c as usize], from, (to, offset), &blocks, values);
        }
    }

    /// Factors a subtree front by front. `size` is what waits at most; returns what the last front passes on.
    pub fn one_after_another(
        &self,
        subtree: Range<usize>,
        size: usize,
        part: Part<'_>,
    ) -> Result<Piece, FactorError> {
        let fronts = &self.tree.fronts;
        let leaf = subtree.start;
        let start = fronts[leaf].panel;
        let mut stack = self.pool.take(size)?;
        let mut out = Piece::default();
        let triangle = &mut *self.triangle();
        let mut top = 0;
        for s in subtree.clone() {
            let front = &fronts[s];
            let last = s + 1 == subtree.end;
            let (layout, passed) = (front.layout(), front.passed());
            let own = passed.size();
            let panel = &mut part.panels[front.panel - start..][..layout.size()];
            let children = self.tree.passed_by_children(s);
            let (held, free) = stack.split_at_mut(top);
            let next = if last {
                out = self.pool.take(own)?;
                &mut out[..own]
            } else {
                &mut free[..own]
            };
            let from_children = |to: Trapezoid, offset, values: &mut [f64]| {
                let mut at = top - children;
                for &c in &self.tree.children[s] {
                    let child = &fronts[c as usize];
                    self.add(child, &held[at..], (to, offset), &(0..to.blocks()), values);
                    at += child.passed().size();
                }
            };
            panel.fill(0.0);
            from_children(layout, 0, panel);
            self.enter(s, panel);
            let mut work = Elimination {
                layout,
                pivots: &mut part.pivots[s - leaf],
                triangle,
                parallel: false,
                wary: self.scales(s),
            };
            work.columns(panel)?;
            work.rest(panel, next);
            from_children(passed, front.width, next);
            if !last && children > 0 {
                stack.copy_within(top..top + own, top - children);
            }
            top = top - children + own;
        }
        self.pool.put(stack);
        Ok(out)
    }

    /// Adds the entries of the matrix to the panel of a front.
    fn enter(&self, f: usize, panel: &mut [f64]) {
        match self.entries {
            Entries::All(values) => self.tree.entries.enter(f, values, panel),
            Entries::Collected(from, starts, values) => {
                self.tree.entries.enter_collected(f, &values[starts[f - from]..], panel);
            }
        }
    }

    /// Scales of the rows of a front, where pivots are chosen with care.
    fn scales(&self, f: usize) -> Option<Vec<f64>> {
        let front = &self.tree.fronts[f];
        let scale = |place: usize| Some(self.wary?[self.tree.order[place] as usize]);
        let columns = front.first..front.first + front.width;
        columns.chain(front.rows.iter().map(|&row| row as usize)).map(scale).collect()
    }

    /// As [`add`], with the registers of this machine.
    fn add(
        &self,
        child: &Front,
        from: &[f64],
        to: (Trapezoid, usize),
        blocks: &Range<usize>,
        values: &mut [f64],
    ) {
        self.arch.dispatch(|| add(child, from, to, blocks, values));
    }

    /// Memory of this thread for a block. While it is held no other work is waited for.
    fn triangle(&self) -> MutexGuard<'_, Triangle> {
        let own = rayon::current_thread_index().unwrap_or(0);
        locked(&self.triangles[own % self.triangles.len()])
    }
}

/// Adds what a child passes on to block columns of its parent: of a trapezoid whose first column has the number `offset`
/// there. `values` are those block columns.
#[inline(always)]
fn add(
    child: &Front,
    from: &[f64],
    (to, offset): (Trapezoid, usize),
    blocks: &Range<usize>,
    values: &mut [f64],
) {
    let source = child.passed();
    let start = to.start(blocks.start);
    let first = offset + blocks.start * BLOCK;
    let end = offset + (blocks.end * BLOCK).min(to.columns);
    for (k, &[here, there, length]) in child.runs.iter().enumerate() {
        let (here, there, length) = (here as usize, there as usize, length as usize);
        for place in there.max(first)..(there + length).min(end) {
            let column = here + place - there;
            let source = &from[source.diagonal(column)..];
            let target = &mut values[to.diagonal(place - offset) - start..];
            // The rest of this run, then the runs below.
            let rest = there + length - place;
            add_run(&mut target[..rest], &source[..rest]);
            for &[here, there, length] in &child.runs[k + 1..] {
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
