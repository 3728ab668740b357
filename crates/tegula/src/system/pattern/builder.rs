//! Builder of the sparsity pattern, from the nodal vectors that elements couple.

use rayon::prelude::*;

use super::body_mass::{BodyMass, condense};
use super::{BATCH, Batch, Pattern, Source, Target, Task, rows_below};
use crate::system::LocalFrames;
use crate::system::assembly::pairs;
use crate::system::dof_map::CONSTRAINED;
use crate::{Error, Mat3, Result};

/// Smallest number of blocks of a task: it ends with the block column in which it reaches as many.
const GRAIN: usize = 512;
/// Largest number of blocks of a tangent: their numbers share 32 bits with two flags.
const MOST_BLOCKS: usize = 1 << 30;

/// Builder of the sparsity pattern, element by element.
#[derive(Debug, Default)]
pub struct PatternBuilder {
    /// Finished batches without their targets, each with the keys of the blocks that become its targets.
    batches: Vec<(Batch, Vec<u64>)>,
    /// Block keys and sources of the last batch.
    entries: Vec<(u64, u32)>,
    /// Masses that are not zero.
    masses: Vec<(u64, f64)>,
    /// Numbers of elements and blocks in the last batch.
    elements: usize,
    blocks: u32,
    /// Whether the tangent is wanted, not only the mass.
    tangent: bool,
}

/// Key of the block of two nodal vectors, in the order of the blocks.
pub(super) fn key(a: u32, b: u32) -> u64 {
    (u64::from(a.min(b)) << 32) | u64::from(a.max(b))
}

impl PatternBuilder {
    /// Builder for the tangent and the mass, or for the mass alone.
    pub fn new(tangent: bool) -> Self {
        Self { tangent, ..Self::default() }
    }

    /// Ends a batch: the next elements belong to another one.
    pub fn end_batch(&mut self) {
        (self.elements, self.blocks) = (0, 0);
        if self.entries.is_empty() {
            return;
        }
        // Stable order of contributions: by block, then by element.
        self.entries.sort_unstable();
        let mut keys: Vec<u64> = self.entries.iter().map(|e| e.0).collect();
        keys.dedup();
        keys.shrink_to_fit();
        let ends = self.entries.iter().skip(1).map(|e| Some(e.0)).chain([None]);
        let sources = self.entries.iter().zip(ends).map(|(&(key, source), next)| {
            Source(if next == Some(key) { source } else { source | Source::LAST })
        });
        self.batches.push((Batch { sources: sources.collect(), ..Batch::default() }, keys));
        self.entries.clear();
    }

    /// Adds an element, whose lower blocks come next in the buffer.
    pub fn element(&mut self, vectors: &[u32], mass: &[f64]) {
        self.count(vectors, mass);
        self.reduced(vectors);
    }

    /// Passes over an element whose lower blocks come next in the buffer, but are [reduced](Self::reduced) to others; its
    /// mass is added.
    pub fn pass_over(&mut self, vectors: &[u32], mass: &[f64]) {
        self.count(vectors, mass);
        self.blocks += pairs(vectors.len()) as u32;
    }

    /// Adds the lower blocks of an element that come next in the buffer, behind those of all elements of the batch.
    pub fn reduced(&mut self, vectors: &[u32]) {
        for (a, &va) in vectors.iter().enumerate() {
            for &vb in &vectors[..=a] {
                if self.tangent {
                    let transposed = if va < vb { Source::TRANSPOSED } else { 0 };
                    self.entries.push((key(va, vb), self.blocks << 2 | transposed));
                }
                self.blocks += 1;
            }
        }
    }

    /// Counts an element and adds its mass.
    fn count(&mut self, vectors: &[u32], mass: &[f64]) {
        if self.elements == BATCH {
            self.end_batch();
        }
        let pairs =
            vectors.iter().enumerate().flat_map(|(a, &va)| vectors[..=a].iter().map(move |&vb| (va, vb)));
        for ((a, b), &mass) in pairs.zip(mass) {
            self.mass(a, b, mass);
        }
        self.elements += 1;
    }

    /// Adds mass of a pair of vectors.
    pub fn mass(&mut self, a: u32, b: u32, mass: f64) {
        if mass != 0.0 {
            self.masses.push((key(a, b), mass));
        }
    }

    /// Adds a rigid body with these directors and Euler tensor.
    pub fn body(&mut self, directors: [u32; 3], euler: &Mat3) {
        for i in 0..3 {
            (0..=i).for_each(|j| self.mass(directors[i], directors[j], euler[(i, j)]));
        }
    }

    /// Builds the pattern of the free degrees of freedom.
    ///
    /// # Errors
    /// The elements couple more pairs of nodal vectors than can be numbered.
    pub fn build(mut self, vectors: usize, frames: &LocalFrames) -> Result<Pattern> {
        self.end_batch();
        self.entries = Vec::new();
        let (masses, mut of_bodies) = condense(std::mem::take(&mut self.masses), frames.dofs());
        self.masses = masses;
        self.masses.sort_by_key(|m| m.0);
        let keys = self.keys(vectors, &of_bodies)?;
        let (column_start, row) = block_columns(&keys, vectors);
        let mass = self.masses_of_blocks(&keys);
        for mass in &mut of_bodies {
            mass.block = keys.partition_point(|&k| k < mass.key());
        }
        let columns = if self.tangent { vectors } else { 0 };
        let layout = ValueLayout::new((&column_start[..=columns], &row), frames);

        let mut met = vec![false; keys.len()];
        let mut batches = Vec::with_capacity(self.batches.len());
        for (mut batch, of_batch) in self.batches {
            batch.aim(&of_batch, (&keys, &column_start, frames), &mut met);
            batch.divide(&of_batch, &layout.value_start);
            batches.push(batch);
        }
        let mut alone: Vec<u32> = (0..keys.len() as u32).filter(|&b| !met[b as usize]).collect();
        alone.shrink_to_fit();
        Ok(Pattern {
            column_start,
            row,
            tail_start: layout.tail_start,
            tail: layout.tail,
            mass,
            alone,
            batches,
            column_pointers: layout.column_pointers.into(),
            of_bodies,
        })
    }

    /// Keys of all blocks in ascending order: the diagonal, the blocks of the batches and those of the masses.
    ///
    /// # Errors
    /// The elements couple more pairs of nodal vectors than can be numbered.
    fn keys(&self, vectors: usize, of_bodies: &[BodyMass]) -> Result<Vec<u64>> {
        let mut keys: Vec<u64> = (0..vectors as u32).map(|v| key(v, v)).collect();
        for (_, of_batch) in &self.batches {
            keys.extend(of_batch);
        }
        keys.extend(self.masses.iter().map(|m| m.0));
        keys.extend(of_bodies.iter().map(BodyMass::key));
        keys.par_sort_unstable();
        keys.dedup();
        if keys.len() > if self.tangent { MOST_BLOCKS } else { u32::MAX as usize } {
            return Err(Error::model(
                "mesh",
                "the elements couple over a thousand million pairs of nodal vectors",
                "use fewer elements, or in statics `linear_solver = \"iterative\"`",
            ));
        }
        Ok(keys)
    }

    /// Sums of the masses, which are in ascending order, by block. Statics without gravity needs no density: then no mass is stored.
    fn masses_of_blocks(&self, keys: &[u64]) -> Vec<f64> {
        let mut mass = if self.masses.is_empty() { Vec::new() } else { vec![0.0; keys.len()] };
        let mut block = 0;
        for (key, value) in &self.masses {
            while keys[block] != *key {
                block += 1;
            }
            mass[block] += value;
        }
        mass
    }
}

/// Start of each block column and the rows of its blocks (compressed block columns), from the keys in ascending order.
fn block_columns(keys: &[u64], vectors: usize) -> (Vec<u32>, Vec<u32>) {
    let mut column_start = vec![0; vectors + 1];
    let mut row = Vec::with_capacity(keys.len());
    for (block, &k) in keys.iter().enumerate() {
        column_start[(k >> 32) as usize + 1] = block as u32 + 1;
        row.push(k as u32);
    }
    (column_start, row)
}

/// Places of the values of block columns in the columns of the free degrees of freedom (compressed sparse columns).
struct ValueLayout {
    /// First value of each block column.
    value_start: Vec<usize>,
    /// First value of each column of a degree of freedom.
    column_pointers: Vec<usize>,
    /// Free rows from each block on to the end of its column, where some are constrained.
    tail: Vec<u32>,
    /// First of these numbers of each block column.
    tail_start: Vec<u32>,
}

impl ValueLayout {
    /// Layout of block columns, from their starts and the rows of their blocks.
    fn new((column_start, row): (&[u32], &[u32]), frames: &LocalFrames) -> Self {
        let columns = column_start.len() - 1;
        let mut tail = Vec::new();
        let mut tail_start = Vec::with_capacity(columns + 1);
        let mut column_pointers = Vec::new();
        let mut value_start = Vec::with_capacity(columns);
        column_pointers.reserve_exact(if columns > 0 { frames.dofs().unknowns + 1 } else { 1 });
        column_pointers.push(0);
        let mut values = 0;
        for (j, ends) in column_start.windows(2).enumerate() {
            value_start.push(values);
            tail_start.push(tail.len() as u32);
            let rows = &row[ends[0] as usize..ends[1] as usize];
            let free =
                |i: u32| frames.of(i as usize).into_iter().filter(|&r| r != CONSTRAINED).count() as u32;
            if rows.iter().any(|&i| free(i) < 3) {
                let mut below: u32 = rows.iter().map(|&i| free(i)).sum();
                for &i in rows {
                    tail.push(below);
                    below -= free(i);
                }
            }
            for number in frames.of(j).into_iter().filter(|&n| n != CONSTRAINED) {
                values += rows_below(rows, frames, number).count();
                column_pointers.push(values);
            }
        }
        tail_start.push(tail.len() as u32);
        tail.shrink_to_fit();
        Self { value_start, column_pointers, tail, tail_start }
    }
}

impl Batch {
    /// Finds the targets of the batch; `met` tells which blocks of the matrix have appeared already.
    fn aim(
        &mut self,
        wanted: &[u64],
        (keys, column_start, frames): (&[u64], &[u32], &LocalFrames),
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
                Target::new(block, first, frames.is_plain(i) && frames.is_plain(j))
            })
            .collect();
    }

    /// Divides the targets, which have these keys, into tasks.
    fn divide(&mut self, keys: &[u64], value_start: &[usize]) {
        let mut ends = self.sources.iter().enumerate().filter(|(_, s)| s.0 & Source::LAST != 0);
        let (mut source, mut last) = (0, None);
        for (target, key) in keys.iter().enumerate() {
            let column = (key >> 32) as u32;
            let full = self.tasks.last().is_none_or(|t| target - t.target as usize >= GRAIN);
            if full && last != Some(column) {
                let value = value_start[column as usize];
                self.tasks.push(Task { target: target as u32, source, column, value });
            }
            last = Some(column);
            source = ends.next().map_or(source, |(at, _)| at as u32 + 1);
        }
        self.tasks.shrink_to_fit();
    }
}
