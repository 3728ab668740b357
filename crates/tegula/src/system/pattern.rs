//! Sparsity pattern of the tangent and the gather lists that fill it.
//!
//! The unit is the 3×3 block of a pair of nodal vectors. Elements are worked off in portions of [`PORTION`]: they write
//! their blocks to a buffer that holds one portion, and every block of the matrix takes its contributions from there in
//! a fixed order. Nothing is locked, and the result does not depend on the number of threads.

use std::ops::Range;
use std::sync::Arc;

use rayon::prelude::*;

use super::numbering::{CONSTRAINED, Numbering};
use crate::element::Nodal;
use crate::linear::SymmetricPattern;

/// Elements of a portion: their blocks (10 MB) stay in the last cache of a processor until they are summed. With 1024, in a
/// nearer one, a thread takes 3 % less time, but two take 23 % more, as they wait for each other after every portion. A
/// multiple of [`ALIGNMENT`](crate::element::group::ALIGNMENT).
pub const PORTION: usize = 4096;
/// Blocks below which a task is not split further.
const GRAIN: usize = 1024;

/// Blocks of the lower triangle, by block column, and where their parts come from.
#[derive(Debug)]
pub struct Pattern {
    /// First block of each block column.
    column_start: Vec<u32>,
    /// Block row of each block; rows ascend within a column, the first is the diagonal.
    row: Vec<u32>,
    /// Values of a column from a block on to its end; the same for all free columns of a block column.
    tail: Vec<u32>,
    /// Scalar mass of each block.
    mass: Vec<f64>,
    /// Blocks without an element.
    alone: Vec<u32>,
    /// What each portion of the elements contributes.
    portions: Vec<Portion>,
    /// First value of each block column in the compressed columns.
    value_start: Vec<usize>,
    /// Column pointers of the free coordinates.
    pub column_pointers: Arc<Vec<usize>>,
}

/// Contributions of a portion of the elements.
#[derive(Debug, Default)]
struct Portion {
    /// Blocks of the matrix, ascending: block column and number.
    targets: Vec<Target>,
    /// First source of each.
    source_start: Vec<u32>,
    /// Number of a block in the buffer of the portion, times two, plus one if it is to be transposed.
    sources: Vec<u32>,
}

#[derive(Debug, Clone, Copy)]
struct Target {
    column: u32,
    block: u32,
    /// No earlier portion contributes.
    first: bool,
    /// Off the diagonal, all coordinates free, along the global axes.
    plain: bool,
}

/// Adds up the pattern from elements.
#[derive(Debug, Default)]
pub struct PatternBuilder {
    /// Finished portions without their targets, and the blocks that are to be those.
    portions: Vec<(Portion, Vec<u64>)>,
    /// Block and number in the buffer, of the last portion.
    entries: Vec<(u64, u32)>,
    masses: Vec<(u64, f64)>,
    /// Elements and blocks in the last portion.
    elements: usize,
    blocks: u32,
    /// Whether the tangent is wanted, not only the mass.
    tangent: bool,
}

fn key(a: u32, b: u32) -> u64 {
    (u64::from(a.min(b)) << 32) | u64::from(a.max(b))
}

impl PatternBuilder {
    /// For the tangent and the mass, or for the mass alone.
    pub fn new(tangent: bool) -> Self {
        Self { tangent, ..Self::default() }
    }

    /// The elements that come next are not of the same portion as those before.
    pub fn end_portion(&mut self) {
        (self.elements, self.blocks) = (0, 0);
        if self.entries.is_empty() {
            return;
        }
        // Stable order of contributions: by block, then by element.
        self.entries.sort_unstable();
        let mut keys: Vec<u64> = self.entries.iter().map(|e| e.0).collect();
        keys.dedup();
        keys.shrink_to_fit();
        let mut portion = Portion {
            targets: Vec::new(),
            source_start: Vec::with_capacity(keys.len() + 1),
            sources: self.entries.iter().map(|e| e.1).collect(),
        };
        let mut last = None;
        for (source, &(key, _)) in self.entries.iter().enumerate() {
            if last != Some(key) {
                last = Some(key);
                portion.source_start.push(source as u32);
            }
        }
        portion.source_start.push(self.entries.len() as u32);
        self.portions.push((portion, keys));
        self.entries.clear();
    }

    /// Adds an element whose lower blocks come next in the buffer.
    pub fn element(&mut self, vectors: &[u32], mass: &[f64]) {
        if self.elements == PORTION {
            self.end_portion();
        }
        let mut pair = 0;
        for (a, &va) in vectors.iter().enumerate() {
            for &vb in &vectors[..=a] {
                if self.tangent {
                    self.entries.push((key(va, vb), 2 * self.blocks + u32::from(va < vb)));
                }
                if let Some(&m) = mass.get(pair)
                    && m != 0.0
                {
                    self.masses.push((key(va, vb), m));
                }
                self.blocks += 1;
                pair += 1;
            }
        }
        self.elements += 1;
    }

    /// Adds mass of a pair of vectors.
    pub fn mass(&mut self, a: u32, b: u32, mass: f64) {
        self.masses.push((key(a, b), mass));
    }

    /// The pattern of the free coordinates.
    pub fn build(mut self, vectors: usize, numbering: &Numbering) -> Pattern {
        self.end_portion();
        self.entries = Vec::new();
        self.masses.sort_by_key(|m| m.0);
        let mut keys: Vec<u64> = (0..vectors as u32).map(|v| key(v, v)).collect();
        for (_, of_portion) in &self.portions {
            keys.extend(of_portion);
        }
        keys.extend(self.masses.iter().map(|m| m.0));
        keys.par_sort_unstable();
        keys.dedup();

        let mut column_start = vec![0; vectors + 1];
        let mut row = Vec::with_capacity(keys.len());
        let mut mass = vec![0.0; keys.len()];
        let mut m = 0;
        for (block, &k) in keys.iter().enumerate() {
            column_start[(k >> 32) as usize + 1] = block as u32 + 1;
            row.push(k as u32);
            while m < self.masses.len() && self.masses[m].0 == k {
                mass[block] += self.masses[m].1;
                m += 1;
            }
        }
        let mut met = vec![false; keys.len()];
        let mut portions = Vec::with_capacity(self.portions.len());
        for (mut portion, of_portion) in self.portions {
            portion.aim(&of_portion, (&keys, &column_start, numbering), &mut met);
            portions.push(portion);
        }
        let alone = (0..keys.len() as u32).filter(|&b| !met[b as usize]).collect();

        let mut tail = vec![0; keys.len()];
        let mut column_pointers = Vec::with_capacity(numbering.unknowns + 1);
        column_pointers.push(0);
        let mut values = 0;
        let mut value_start = Vec::with_capacity(vectors + 1);
        for j in (0..vectors).filter(|_| self.tangent) {
            value_start.push(values);
            let blocks = column_start[j] as usize..column_start[j + 1] as usize;
            let mut below = 0;
            for block in blocks.clone().rev() {
                let rows = numbering.of(row[block] as usize);
                below += rows.iter().filter(|&&r| r != CONSTRAINED).count() as u32;
                tail[block] = below;
            }
            for number in numbering.of(j).into_iter().filter(|&n| n != CONSTRAINED) {
                values += rows_below(&row[blocks.clone()], numbering, number).count();
                column_pointers.push(values);
            }
        }
        value_start.push(values);
        Pattern {
            column_start,
            row,
            tail,
            mass,
            alone,
            portions,
            value_start,
            column_pointers: column_pointers.into(),
        }
    }
}

/// Rows of a column of the free coordinates, from its diagonal on: those of the blocks with these block rows.
fn rows_below<'a>(
    rows: &'a [u32],
    numbering: &'a Numbering,
    column: u32,
) -> impl Iterator<Item = u32> + use<'a> {
    let numbers = rows.iter().flat_map(|&i| numbering.of(i as usize));
    numbers.filter(move |&r| r != CONSTRAINED && r >= column)
}

impl Portion {
    /// Finds the targets; `met` tells which blocks of the matrix have appeared already.
    fn aim(
        &mut self,
        wanted: &[u64],
        (keys, column_start, numbering): (&[u64], &[u32], &Numbering),
        met: &mut [bool],
    ) {
        self.targets = wanted
            .iter()
            .map(|&key| {
                let column = (key >> 32) as u32;
                let start = column_start[column as usize] as usize;
                let end = column_start[column as usize + 1] as usize;
                let block = start + keys[start..end].partition_point(|&k| k < key);
                let first = !std::mem::replace(&mut met[block], true);
                let (i, j) = (key as u32 as usize, column as usize);
                let plain = i != j && numbering.is_plain(i) && numbering.is_plain(j);
                Target { column, block: block as u32, first, plain }
            })
            .collect();
    }

    /// Sum of the contributions to a target.
    #[inline]
    fn sum(&self, target: usize, buffer: &[f64]) -> [f64; 9] {
        let mut k = [0.0; 9];
        let range = self.source_start[target] as usize..self.source_start[target + 1] as usize;
        for &source in &self.sources[range] {
            let at = 9 * (source >> 1) as usize;
            let b = &buffer[at..at + 9];
            if source & 1 == 0 {
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
        }
        k
    }
}

impl Pattern {
    /// Number of stored values: lower triangle of the free coordinates.
    pub fn values(&self) -> usize {
        self.column_pointers.last().copied().unwrap_or(0)
    }

    /// The pattern in compressed columns. Its row numbers are found anew each time: few need them for long.
    pub fn compressed(&self, numbering: &Numbering) -> SymmetricPattern {
        let mut rows = Vec::with_capacity(self.values());
        for j in 0..self.vectors() {
            for number in numbering.of(j).into_iter().filter(|&n| n != CONSTRAINED) {
                rows.extend(rows_below(&self.row[self.blocks(j)], numbering, number));
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

    /// Begins the sum of `mass_factor · M` and element blocks: what has no element.
    pub fn begin(&self, mass_factor: f64, numbering: &Numbering, values: &mut [f64]) {
        let mut column = 0;
        for &block in &self.alone {
            while self.column_start[column + 1] <= block {
                column += 1;
            }
            let m = mass_factor * self.mass[block as usize];
            let target = Target { column: column as u32, block, first: true, plain: false };
            self.put(target, [m, 0.0, 0.0, 0.0, m, 0.0, 0.0, 0.0, m], numbering, values, 0);
        }
    }

    /// Adds the blocks of a portion of the elements. Portions are added one after another, all of them.
    pub fn add(
        &self,
        portion: usize,
        buffer: &[f64],
        mass_factor: f64,
        numbering: &Numbering,
        values: &mut [f64],
    ) {
        let portion = &self.portions[portion];
        self.add_targets(portion, 0..portion.targets.len(), (buffer, mass_factor), numbering, values, 0);
    }

    /// Adds to `values`, of which the first is that of number `offset`.
    fn add_targets(
        &self,
        portion: &Portion,
        targets: Range<usize>,
        parts: (&[f64], f64),
        numbering: &Numbering,
        values: &mut [f64],
        offset: usize,
    ) {
        if targets.len() > GRAIN {
            let middle = targets.start + targets.len() / 2;
            let column = portion.targets[middle].column;
            let within = &portion.targets[targets.clone()];
            let middle = targets.start + within.partition_point(|t| t.column < column);
            if middle > targets.start {
                let split = self.value_start[column as usize];
                let (left, right) = values.split_at_mut(split - offset);
                rayon::join(
                    || self.add_targets(portion, targets.start..middle, parts, numbering, left, offset),
                    || self.add_targets(portion, middle..targets.end, parts, numbering, right, split),
                );
                return;
            }
        }
        let (buffer, mass_factor) = parts;
        for at in targets {
            let target = portion.targets[at];
            let mut k = portion.sum(at, buffer);
            if target.first {
                let m = mass_factor * self.mass[target.block as usize];
                k[0] += m;
                k[4] += m;
                k[8] += m;
            }
            self.put(target, k, numbering, values, offset);
        }
    }

    /// Writes a block where it is the first contribution, else adds it.
    #[inline]
    fn put(&self, target: Target, mut k: [f64; 9], numbering: &Numbering, values: &mut [f64], offset: usize) {
        let (block, j) = (target.block as usize, target.column as usize);
        if target.plain {
            let number = numbering.free[3 * j] as usize;
            let below = self.tail[block] as usize + offset;
            for c in 0..3 {
                let at = self.column_pointers[number + c + 1] - below;
                let values = &mut values[at..at + 3];
                for r in 0..3 {
                    values[r] = k[3 * r + c] + if target.first { 0.0 } else { values[r] };
                }
            }
            return;
        }
        let i = self.row[block] as usize;
        numbering.rotate(&mut k, i, j);
        let rows = numbering.of(i);
        for (c, number) in numbering.of(j).into_iter().enumerate() {
            if number == CONSTRAINED {
                continue;
            }
            let number_of = number as usize;
            let mut at = if i == j {
                self.column_pointers[number_of]
            } else {
                self.column_pointers[number_of + 1] - self.tail[block] as usize
            } - offset;
            for (r, &row) in rows.iter().enumerate() {
                if row == CONSTRAINED || row < number {
                    continue;
                }
                if target.first {
                    values[at] = k[3 * r + c];
                } else {
                    values[at] += k[3 * r + c];
                }
                at += 1;
            }
        }
    }

    /// Adds a multiple of the unit matrix to the block of a nodal vector with itself.
    pub fn add_to_diagonal(&self, vector: usize, value: f64, numbering: &Numbering, values: &mut [f64]) {
        for number in numbering.of(vector).into_iter().filter(|&n| n != CONSTRAINED) {
            values[self.column_pointers[number as usize]] += value;
        }
    }

    /// Values of the mass matrix of the free coordinates.
    pub fn mass_values(&self, numbering: &Numbering, values: &mut [f64]) {
        for j in 0..self.vectors() {
            for block in self.blocks(j) {
                let m = self.mass[block];
                let target = Target { column: j as u32, block: block as u32, first: true, plain: false };
                self.put(target, [m, 0.0, 0.0, 0.0, m, 0.0, 0.0, 0.0, m], numbering, values, 0);
            }
        }
    }

    /// `out += factor · M x` for all nodal vectors.
    pub fn add_mass_product(&self, factor: f64, x: &[Nodal], out: &mut [Nodal]) {
        for j in 0..self.vectors() {
            for block in self.blocks(j) {
                let m = factor * self.mass[block];
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
    }

    /// Calls `f(i, j, m)` for every pair `i ≥ j` of nodal vectors with mass.
    pub fn for_each_mass(&self, mut f: impl FnMut(usize, usize, f64)) {
        for j in 0..self.vectors() {
            for block in self.blocks(j) {
                if self.mass[block] != 0.0 {
                    f(self.row[block] as usize, j, self.mass[block]);
                }
            }
        }
    }

    /// Replaces the mass of every pair `i ≥ j` of nodal vectors by `f(i, j)`.
    pub fn set_mass(&mut self, f: impl Fn(usize, usize) -> f64) {
        for j in 0..self.vectors() {
            for block in self.blocks(j) {
                self.mass[block] = f(self.row[block] as usize, j);
            }
        }
    }

    /// Multiplies the mass of all blocks.
    pub fn scale_mass(&mut self, factor: f64) {
        self.mass.iter_mut().for_each(|m| *m *= factor);
    }
}
