//! Sparsity pattern of the tangent and the gather lists that fill it.
//!
//! The unit is the 3×3 block of a pair of nodal vectors. Elements are processed in batches of equal size: they write
//! their blocks to a buffer that holds one batch, and every block of the matrix gathers its contributions from there in
//! a fixed order. Nothing is locked, and the result does not depend on the number of threads.

mod body_mass;
mod builder;
#[cfg(test)]
mod tests;

use std::ops::Range;
use std::slice::Iter;
use std::sync::Arc;

use super::LocalFrames;
use super::dof_map::CONSTRAINED;
use crate::Mat3;
use crate::element::Nodal;
use body_mass::BodyMass;
pub use builder::PatternBuilder;
use tegula_sparse::SymmetricPattern;

/// Elements of a batch: their blocks (10 MB) stay in the last cache of a processor until they are summed. With 1024, in
/// a nearer one, a thread takes 3 % less time, but two take 23 % more, as they wait for each other after every batch. A
/// multiple of [`ALIGNMENT`](crate::element::group::ALIGNMENT).
pub const BATCH: usize = 4096;

/// Block pattern of the lower triangle, by block column, and the sources of the contributions to each block.
#[derive(Debug)]
pub struct Pattern {
    /// First block of each block column.
    column_start: Vec<u32>,
    /// Block row of each block; rows ascend within a column, the first is the diagonal.
    row: Vec<u32>,
    /// First entry of `tail` for each block column.
    tail_start: Vec<u32>,
    /// Number of values of a column from a block on to its end; equal for all free columns of a block column. Left out
    /// where all rows of the block column are free: there it is three for each block.
    tail: Vec<u32>,
    /// Scalar mass of each block; empty: none has any.
    mass: Vec<f64>,
    /// Blocks without an element.
    alone: Vec<u32>,
    /// Contributions of each batch of elements.
    batches: Vec<Batch>,
    /// Column pointers of the free degrees of freedom.
    pub column_pointers: Arc<Vec<usize>>,
    /// Masses of the directors of rigid bodies, with each other and with other nodal vectors.
    of_bodies: Vec<BodyMass>,
}

/// Contributions of a batch of elements.
#[derive(Debug, Default)]
struct Batch {
    /// Blocks of the matrix, ascending.
    targets: Vec<Target>,
    /// Sources of all targets, one after another.
    sources: Vec<Source>,
    /// Division of the targets into tasks.
    tasks: Vec<Task>,
}

/// Target block of the matrix: its number times four, with flags.
#[derive(Debug, Clone, Copy)]
struct Target(u32);

impl Target {
    /// Flag: no earlier batch contributes.
    const FIRST: u32 = 1;
    /// Flag: all degrees of freedom are free, along the global axes.
    const PLAIN: u32 = 2;

    fn new(block: usize, first: bool, plain: bool) -> Self {
        Self((block as u32) << 2 | if first { Self::FIRST } else { 0 } | if plain { Self::PLAIN } else { 0 })
    }

    fn block(self) -> usize {
        (self.0 >> 2) as usize
    }

    fn is(self, flag: u32) -> bool {
        self.0 & flag != 0
    }
}

/// Source block in the buffer of the batch: its number times four, with flags.
#[derive(Debug, Clone, Copy)]
struct Source(u32);

impl Source {
    /// Flag: the block is to be transposed.
    const TRANSPOSED: u32 = 1;
    /// Flag: the last source of its target.
    const LAST: u32 = 2;
}

/// Task for one thread: whole block columns of the targets.
#[derive(Debug, Clone, Copy)]
struct Task {
    /// First target, and first of its sources.
    target: u32,
    source: u32,
    /// Block column of the first target.
    column: u32,
    /// First value of that block column.
    value: usize,
}

/// Block column that is being summed.
#[derive(Debug, Clone, Copy)]
struct Column<'a> {
    number: usize,
    /// First block of the column, and the one after the last.
    start: usize,
    end: usize,
    /// Number of values from each block on; empty: three for each.
    tail: &'a [u32],
    /// Ends of the columns of its degrees of freedom; zero for constrained ones.
    ends: [usize; 3],
}

impl Column<'_> {
    /// Number of values of a column from a block on to its end, with those above the diagonal.
    #[inline]
    fn below(&self, block: usize) -> usize {
        if self.tail.is_empty() { 3 * (self.end - block) } else { self.tail[block - self.start] as usize }
    }
}

/// Rows of a column of the free degrees of freedom, from its diagonal on, in the blocks with these block rows.
fn rows_below<'a>(
    rows: &'a [u32],
    frames: &'a LocalFrames,
    column: u32,
) -> impl Iterator<Item = u32> + use<'a> {
    let numbers = rows.iter().flat_map(|&i| frames.of(i as usize));
    numbers.filter(move |&r| r != CONSTRAINED && r >= column)
}

/// Sum of the contributions to the target whose sources come next.
#[inline]
fn sum(sources: &mut Iter<Source>, buffer: &[f64]) -> [f64; 9] {
    let mut k = [0.0; 9];
    for &Source(source) in sources {
        let at = 9 * (source >> 2) as usize;
        let b = &buffer[at..at + 9];
        if source & Source::TRANSPOSED == 0 {
            for i in 0..9 {
                k[i] += b[i];
            }
        } else {
            for i in 0..3 {
                for j in 0..3 {
                    k[3 * i + j] += b[3 * j + i];
                }
            }
        }
        if source & Source::LAST != 0 {
            break;
        }
    }
    k
}

impl Pattern {
    /// Number of stored values: lower triangle of the free degrees of freedom.
    pub fn values(&self) -> usize {
        self.column_pointers.last().copied().unwrap_or(0)
    }

    /// Pattern in compressed columns. Its row numbers are computed again in each call: few callers need them for long.
    pub fn compressed(&self, frames: &LocalFrames) -> SymmetricPattern {
        let mut rows = Vec::with_capacity(self.values());
        for j in 0..self.vectors() {
            for number in frames.of(j).into_iter().filter(|&n| n != CONSTRAINED) {
                rows.extend(rows_below(&self.row[self.blocks(j)], frames, number));
            }
        }
        SymmetricPattern::new(self.column_pointers.clone(), rows)
    }

    /// Number of nodal vectors.
    fn vectors(&self) -> usize {
        self.column_start.len() - 1
    }

    /// Blocks of a block column.
    fn blocks(&self, column: usize) -> Range<usize> {
        self.column_start[column] as usize..self.column_start[column + 1] as usize
    }

    /// Block column of a block that lies in the column `from` (most often) or behind it.
    #[inline]
    fn column_of(&self, block: usize, from: usize) -> usize {
        if block < self.column_start[from + 1] as usize {
            return from;
        }
        from + 1 + self.column_start[from + 2..].partition_point(|&start| start as usize <= block)
    }

    /// Block column for a slice of values that begins with value number `offset`.
    #[inline]
    fn column(&self, number: usize, frames: &LocalFrames, offset: usize) -> Column<'_> {
        let Range { start, end } = self.blocks(number);
        let tail = &self.tail[self.tail_start[number] as usize..self.tail_start[number + 1] as usize];
        let ends = frames.of(number).map(|n| match n {
            CONSTRAINED => 0,
            n => self.column_pointers[n as usize + 1] - offset,
        });
        Column { number, start, end, tail, ends }
    }

    /// Mass of a block.
    fn mass(&self, block: usize) -> f64 {
        self.mass.get(block).copied().unwrap_or(0.0)
    }

    /// Begins the sum of `mass_factor · M` and element blocks with the blocks that have no element.
    pub fn begin(&self, mass_factor: f64, frames: &LocalFrames, values: &mut [f64]) {
        let mut column = 0;
        for &block in &self.alone {
            column = self.column_of(block as usize, column);
            let m = mass_factor * self.mass(block as usize);
            let target = Target::new(block as usize, true, false);
            self.put(&self.column(column, frames, 0), target, scalar(m), frames, values);
        }
    }

    /// Adds the blocks of a batch of elements. All batches are added, one after another.
    pub fn add(
        &self,
        batch: usize,
        buffer: &[f64],
        mass_factor: f64,
        frames: &LocalFrames,
        values: &mut [f64],
    ) {
        let batch = &self.batches[batch];
        self.add_tasks(batch, 0..batch.tasks.len(), (buffer, mass_factor), frames, values, 0);
    }

    /// Adds the contributions of tasks to `values`, a slice that begins with value number `offset`.
    fn add_tasks(
        &self,
        batch: &Batch,
        tasks: Range<usize>,
        parts: (&[f64], f64),
        frames: &LocalFrames,
        values: &mut [f64],
        offset: usize,
    ) {
        if tasks.len() > 1 {
            let middle = tasks.start + tasks.len() / 2;
            let split = batch.tasks[middle].value;
            let (left, right) = values.split_at_mut(split - offset);
            rayon::join(
                || self.add_tasks(batch, tasks.start..middle, parts, frames, left, offset),
                || self.add_tasks(batch, middle..tasks.end, parts, frames, right, split),
            );
            return;
        }
        let Some(task) = batch.tasks.get(tasks.start) else { return };
        let end = batch.tasks.get(tasks.end).map_or(batch.targets.len(), |next| next.target as usize);
        let (buffer, mass_factor) = parts;
        // In statics the mass is not even read.
        let mass = if mass_factor == 0.0 { &[] } else { self.mass.as_slice() };
        let mut sources = batch.sources[task.source as usize..].iter();
        let mut column = self.column(task.column as usize, frames, offset);
        for &target in &batch.targets[task.target as usize..end] {
            if target.block() >= column.end {
                column = self.column(self.column_of(target.block(), column.number + 1), frames, offset);
            }
            let mut k = sum(&mut sources, buffer);
            if target.is(Target::FIRST)
                && let Some(m) = mass.get(target.block())
            {
                let m = mass_factor * m;
                k[0] += m;
                k[4] += m;
                k[8] += m;
            }
            self.put(&column, target, k, frames, values);
        }
    }

    /// Writes a block where it is the first contribution, else adds it.
    #[inline]
    fn put(
        &self,
        column: &Column,
        target: Target,
        mut k: [f64; 9],
        frames: &LocalFrames,
        values: &mut [f64],
    ) {
        let (block, first) = (target.block(), target.is(Target::FIRST));
        let below = column.below(block);
        if target.is(Target::PLAIN) {
            for c in 0..3 {
                let at = column.ends[c] - below;
                if block != column.start {
                    let values = &mut values[at..at + 3];
                    for r in 0..3 {
                        values[r] = k[3 * r + c] + if first { 0.0 } else { values[r] };
                    }
                } else {
                    // Nothing is stored above the diagonal: the column before ends there.
                    for r in c..3 {
                        values[at + r] = k[3 * r + c] + if first { 0.0 } else { values[at + r] };
                    }
                }
            }
            return;
        }
        let (i, j) = (self.row[block] as usize, column.number);
        frames.rotate(&mut k, i, j);
        let rows = frames.of(i);
        for (c, number) in frames.of(j).into_iter().enumerate() {
            if number == CONSTRAINED {
                continue;
            }
            let mut at = column.ends[c] - below;
            for (r, &row) in rows.iter().enumerate() {
                if row == CONSTRAINED {
                    continue;
                }
                if row >= number {
                    if first {
                        values[at] = k[3 * r + c];
                    } else {
                        values[at] += k[3 * r + c];
                    }
                }
                at += 1;
            }
        }
    }

    /// Adds `factor` times the inertia of rigid bodies to the blocks of their rotations: `Σ E_ij (d_i·d_j I − d_j d_iᵀ)`, from
    /// `δd_i = δθ × d_i`, and the coupling of bodies with the shells that are attached to them.
    pub fn add_body_inertia(&self, factor: f64, frames: &LocalFrames, values: &mut [f64]) {
        if factor == 0.0 {
            return;
        }
        for mass in &self.of_bodies {
            let k = mass.tangent(&(Mat3::identity() * factor), frames);
            let column = self.column(mass.place()[1] as usize, frames, 0);
            self.put(&column, Target::new(mass.block, false, false), by_rows(&k), frames, values);
        }
    }

    /// Adds the mass of every pair of nodal vectors times a symmetric matrix.
    pub fn add_mass_along(&self, matrix: &Mat3, frames: &LocalFrames, values: &mut [f64]) {
        for j in 0..self.vectors() {
            let column = self.column(j, frames, 0);
            for block in self.blocks(j) {
                let m = self.mass(block);
                if m != 0.0 {
                    self.put(
                        &column,
                        Target::new(block, false, false),
                        by_rows(&(matrix * m)),
                        frames,
                        values,
                    );
                }
            }
        }
        for mass in &self.of_bodies {
            let k = mass.tangent(matrix, frames);
            let column = self.column(mass.place()[1] as usize, frames, 0);
            self.put(&column, Target::new(mass.block, false, false), by_rows(&k), frames, values);
        }
    }

    /// Adds a symmetric matrix to the block of a nodal vector with itself.
    pub fn add_to_block(&self, vector: usize, k: &Mat3, frames: &LocalFrames, values: &mut [f64]) {
        let column = self.column(vector, frames, 0);
        self.put(&column, Target::new(column.start, false, false), by_rows(k), frames, values);
    }

    /// Adds a multiple of the unit matrix to the block of a nodal vector with itself.
    pub fn add_to_diagonal(&self, vector: usize, value: f64, frames: &LocalFrames, values: &mut [f64]) {
        for number in frames.of(vector).into_iter().filter(|&n| n != CONSTRAINED) {
            values[self.column_pointers[number as usize]] += value;
        }
    }

    /// Values of the mass matrix of the free degrees of freedom.
    pub fn mass_values(&self, frames: &LocalFrames, values: &mut [f64]) {
        for j in 0..self.vectors() {
            let column = self.column(j, frames, 0);
            for block in self.blocks(j) {
                let k = scalar(self.mass(block));
                self.put(&column, Target::new(block, true, false), k, frames, values);
            }
        }
        self.add_body_inertia(1.0, frames, values);
    }

    /// `out += factor · M x` for all nodal vectors.
    pub fn add_mass_product(&self, factor: f64, x: &[Nodal], out: &mut [Nodal]) {
        for j in 0..self.vectors() {
            for block in self.blocks(j) {
                let m = factor * self.mass(block);
                if m == 0.0 {
                    continue;
                }
                let i = self.row[block] as usize;
                for c in 0..3 {
                    out[i][c] += m * x[j][c];
                    if i != j {
                        out[j][c] += m * x[i][c];
                    }
                }
            }
        }
        for mass in &self.of_bodies {
            mass.for_each(|i, j, m| {
                let (i, j) = (i as usize, j as usize);
                for c in 0..3 {
                    out[i][c] += factor * m * x[j][c];
                    if i != j {
                        out[j][c] += factor * m * x[i][c];
                    }
                }
            });
        }
    }

    /// Calls `f(i, j, m)` for every pair `i ≥ j` of nodal vectors with mass.
    pub fn for_each_mass(&self, mut f: impl FnMut(usize, usize, f64)) {
        for j in 0..self.vectors() {
            for block in self.blocks(j) {
                if self.mass(block) != 0.0 {
                    f(self.row[block] as usize, j, self.mass(block));
                }
            }
        }
        for mass in &self.of_bodies {
            mass.for_each(|i, j, m| f(i.max(j) as usize, i.min(j) as usize, m));
        }
    }

    /// Replaces the mass of every pair `i ≥ j` of nodal vectors by `f(i, j)`.
    pub fn set_mass(&mut self, f: impl Fn(usize, usize) -> f64) {
        self.mass.resize(self.row.len(), 0.0);
        for j in 0..self.vectors() {
            for block in self.blocks(j) {
                self.mass[block] = f(self.row[block] as usize, j);
            }
        }
    }
}

/// Entries of a block by rows.
fn by_rows(k: &Mat3) -> [f64; 9] {
    std::array::from_fn(|i| k[(i / 3, i % 3)])
}

/// A block that is a multiple of the unit matrix.
fn scalar(m: f64) -> [f64; 9] {
    [m, 0.0, 0.0, 0.0, m, 0.0, 0.0, 0.0, m]
}
