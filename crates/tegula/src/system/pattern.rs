//! Sparsity pattern of the tangent and the gather lists that fill it.
//!
//! The unit is the 3×3 block of a pair of nodal vectors. Elements write their blocks to a
//! buffer; every block of the matrix sums its contributions in a fixed order. Nothing is
//! locked, and the result does not depend on the number of threads.

use std::ops::Range;

use super::numbering::{CONSTRAINED, Numbering};
use crate::element::Nodal;

/// Block columns below which a task is not split further.
const GRAIN: usize = 128;

/// Blocks of the lower triangle, by block column, and where their parts come from.
#[derive(Debug)]
pub struct Pattern {
    /// First block of each block column.
    column_start: Vec<usize>,
    /// Block row of each block; rows ascend within a column, the first is the diagonal.
    row: Vec<u32>,
    /// First source of each block.
    source_start: Vec<usize>,
    /// Number of a block in the element buffer, times two, plus one if it is to be transposed.
    sources: Vec<u32>,
    /// Scalar mass of each block.
    pub mass: Vec<f64>,
    /// First value of each block column in the compressed columns.
    value_start: Vec<usize>,
    /// Column pointers of the free coordinates.
    pub column_pointers: Vec<usize>,
    /// Row numbers of the free coordinates.
    pub row_indices: Vec<usize>,
}

/// Adds up the pattern from elements.
#[derive(Debug, Default)]
pub struct PatternBuilder {
    entries: Vec<(u64, u32)>,
    masses: Vec<(u64, f64)>,
    blocks: u32,
}

fn key(a: u32, b: u32) -> u64 {
    (u64::from(a.min(b)) << 32) | u64::from(a.max(b))
}

impl PatternBuilder {
    /// Adds an element whose lower blocks come next in the buffer.
    pub fn element(&mut self, vectors: &[u32], mass: &[f64]) {
        let mut pair = 0;
        for (a, &va) in vectors.iter().enumerate() {
            for &vb in &vectors[..=a] {
                self.entries.push((key(va, vb), 2 * self.blocks + u32::from(va < vb)));
                if let Some(&m) = mass.get(pair)
                    && m != 0.0
                {
                    self.masses.push((key(va, vb), m));
                }
                self.blocks += 1;
                pair += 1;
            }
        }
    }

    /// Adds mass of a pair of vectors.
    pub fn mass(&mut self, a: u32, b: u32, mass: f64) {
        self.masses.push((key(a, b), mass));
    }

    /// Number of blocks in the element buffer.
    pub fn buffer_blocks(&self) -> usize {
        self.blocks as usize
    }

    /// The pattern of the free coordinates.
    pub fn build(mut self, vectors: usize, numbering: &Numbering) -> Pattern {
        // Stable order of contributions: by block, then by element.
        self.entries.sort_unstable();
        self.masses.sort_by_key(|m| m.0);
        let mut keys: Vec<u64> = self.entries.iter().map(|e| e.0).collect();
        keys.extend(self.masses.iter().map(|m| m.0));
        keys.extend((0..vectors as u32).map(|v| key(v, v)));
        keys.sort_unstable();
        keys.dedup();

        let mut column_start = vec![0; vectors + 1];
        let mut row = Vec::with_capacity(keys.len());
        let mut source_start = Vec::with_capacity(keys.len() + 1);
        let mut mass = vec![0.0; keys.len()];
        let (mut e, mut m) = (0, 0);
        for (block, &k) in keys.iter().enumerate() {
            column_start[(k >> 32) as usize + 1] = block + 1;
            row.push(k as u32);
            source_start.push(e);
            while e < self.entries.len() && self.entries[e].0 == k {
                e += 1;
            }
            while m < self.masses.len() && self.masses[m].0 == k {
                mass[block] += self.masses[m].1;
                m += 1;
            }
        }
        source_start.push(e);
        let sources = self.entries.into_iter().map(|e| e.1).collect();

        let mut column_pointers = Vec::with_capacity(numbering.unknowns + 1);
        column_pointers.push(0);
        let mut row_indices = Vec::new();
        let mut value_start = Vec::with_capacity(vectors + 1);
        for j in 0..vectors {
            value_start.push(row_indices.len());
            for number in numbering.of(j).into_iter().filter(|&n| n != CONSTRAINED) {
                for &i in &row[column_start[j]..column_start[j + 1]] {
                    let rows = numbering.of(i as usize);
                    row_indices.extend(
                        rows.iter().filter(|&&r| r != CONSTRAINED && r >= number).map(|&r| r as usize),
                    );
                }
                column_pointers.push(row_indices.len());
            }
        }
        value_start.push(row_indices.len());
        Pattern { column_start, row, source_start, sources, mass, value_start, column_pointers, row_indices }
    }
}

impl Pattern {
    /// Number of stored values: lower triangle of the free coordinates.
    pub fn values(&self) -> usize {
        self.row_indices.len()
    }

    /// Number of nodal vectors.
    fn vectors(&self) -> usize {
        self.column_start.len() - 1
    }

    /// Sums the blocks of the element buffer and `mass_factor · M` into the values of the free coordinates;
    /// `shift` (empty, or a number per nodal vector) is added to the diagonal.
    pub fn gather(
        &self,
        buffer: &[f64],
        mass_factor: f64,
        shift: &[f64],
        numbering: &Numbering,
        values: &mut [f64],
    ) {
        self.gather_columns(0..self.vectors(), (buffer, mass_factor, shift), numbering, values);
    }

    fn gather_columns(
        &self,
        columns: Range<usize>,
        parts: (&[f64], f64, &[f64]),
        numbering: &Numbering,
        values: &mut [f64],
    ) {
        let (buffer, mass_factor, shift) = parts;
        if columns.len() > GRAIN {
            let middle = columns.start + columns.len() / 2;
            let (left, right) =
                values.split_at_mut(self.value_start[middle] - self.value_start[columns.start]);
            rayon::join(
                || self.gather_columns(columns.start..middle, parts, numbering, left),
                || self.gather_columns(middle..columns.end, parts, numbering, right),
            );
            return;
        }
        let mut at = 0;
        for j in columns {
            let numbers = numbering.of(j);
            let length = self.value_start[j + 1] - self.value_start[j];
            let out = &mut values[at..at + length];
            at += length;
            if length == 0 {
                continue;
            }
            // Where the next row of each of the (up to three) columns goes.
            let mut next = [0; 3];
            let mut start = 0;
            for (c, &n) in numbers.iter().enumerate() {
                next[c] = start;
                if n != CONSTRAINED {
                    start += self.column_pointers[n as usize + 1] - self.column_pointers[n as usize];
                }
            }
            for block in self.column_start[j]..self.column_start[j + 1] {
                let i = self.row[block] as usize;
                let rows = numbering.of(i);
                let mut k = self.sum(block, buffer);
                let mut m = mass_factor * self.mass[block];
                if i == j {
                    m += shift.get(j).copied().unwrap_or(0.0);
                }
                k[0] += m;
                k[4] += m;
                k[8] += m;
                rotate(&mut k, i, j, numbering);
                for (c, &number) in numbers.iter().enumerate().filter(|(_, n)| **n != CONSTRAINED) {
                    for (r, &row) in rows.iter().enumerate() {
                        if row != CONSTRAINED && row >= number {
                            out[next[c]] = k[3 * r + c];
                            next[c] += 1;
                        }
                    }
                }
            }
        }
    }

    #[inline]
    fn sum(&self, block: usize, buffer: &[f64]) -> [f64; 9] {
        let mut k = [0.0; 9];
        for &source in &self.sources[self.source_start[block]..self.source_start[block + 1]] {
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

    /// `out += factor · M x` for all nodal vectors.
    pub fn add_mass_product(&self, factor: f64, x: &[Nodal], out: &mut [Nodal]) {
        for j in 0..self.vectors() {
            for block in self.column_start[j]..self.column_start[j + 1] {
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
            for block in self.column_start[j]..self.column_start[j + 1] {
                if self.mass[block] != 0.0 {
                    f(self.row[block] as usize, j, self.mass[block]);
                }
            }
        }
    }

    /// Replaces the mass of every pair `i ≥ j` of nodal vectors by `f(i, j)`.
    pub fn set_mass(&mut self, f: impl Fn(usize, usize) -> f64) {
        for j in 0..self.vectors() {
            for block in self.column_start[j]..self.column_start[j + 1] {
                self.mass[block] = f(self.row[block] as usize, j);
            }
        }
    }

    /// Multiplies the mass of all blocks.
    pub fn scale_mass(&mut self, factor: f64) {
        self.mass.iter_mut().for_each(|m| *m *= factor);
    }
}

/// Turns a block to the axes of its vectors: `Qᵢᵀ K Qⱼ`.
fn rotate(k: &mut [f64; 9], i: usize, j: usize, numbering: &Numbering) {
    if numbering.frames[i].is_none() && numbering.frames[j].is_none() {
        return;
    }
    let mut m = crate::Mat3::from_row_slice(k);
    if let Some(q) = &numbering.frames[i] {
        m = q.transpose() * m;
    }
    if let Some(q) = &numbering.frames[j] {
        m *= q;
    }
    for r in 0..3 {
        for c in 0..3 {
            k[3 * r + c] = m[(r, c)];
        }
    }
}
