//! Sparsity pattern of the matrix of a subdomain, and assembly of its values from the blocks of its terms.

use std::collections::HashMap;
use std::ops::Range;
use std::sync::Arc;

use super::Terms;
use crate::system::LocalFrames;
use tegula_sparse::{FactorError, SymmetricPattern};

/// Marks a constrained degree of freedom.
pub(super) const NONE: u32 = u32::MAX;

/// Nodal vector of a subdomain.
#[derive(Debug, Clone, Copy)]
pub(super) struct LocalVector {
    /// Number of the nodal vector in the mesh.
    pub vector: u32,
    /// Unknowns of the subdomain at its degrees of freedom: consecutive numbers, or [`NONE`].
    pub unknowns: [u32; 3],
}

impl LocalVector {
    /// Vector that stands for all vectors without free degrees of freedom.
    const CONSTRAINED: Self = Self { vector: 0, unknowns: [NONE; 3] };

    /// First of its unknowns.
    fn first(&self) -> u32 {
        let [a, b, c] = self.unknowns;
        a.min(b).min(c)
    }

    /// Its unknowns as a range.
    fn range(&self) -> Range<u32> {
        let count = self.unknowns.iter().filter(|&&u| u != NONE).count() as u32;
        self.first()..self.first().saturating_add(count)
    }
}

/// Assembly of the lower triangle of a subdomain's matrix, in compressed columns.
#[derive(Debug, Default)]
pub(super) struct LocalAssembly {
    /// Start of the blocks and start of the vectors of each term; then the ends.
    terms: Vec<[u32; 2]>,
    /// Vectors of the terms, as indices of `vectors`.
    term_vectors: Vec<u32>,
    /// Vectors in the order of their unknowns, and one more for all vectors without free degrees of freedom.
    vectors: Vec<LocalVector>,
    /// Index of the first value of each block of the terms.
    starts: Vec<u32>,
    /// Column pointers of the matrix.
    pointers: Arc<Vec<usize>>,
}

impl LocalAssembly {
    /// Sparsity pattern and assembly of the terms `order` of a subdomain; `vectors` are sorted by their unknowns.
    ///
    /// # Errors
    /// The blocks or the entries of the matrix are too many to be indexed.
    pub fn new(
        terms: &Terms,
        order: &[u32],
        mut vectors: Vec<LocalVector>,
    ) -> Result<(Self, SymmetricPattern), FactorError> {
        let number: HashMap<u32, u32> = vectors.iter().map(|v| v.vector).zip(0..).collect();
        let without = vectors.len() as u32;
        let (mut starts_of_terms, mut term_vectors) = (Vec::with_capacity(order.len() + 1), Vec::new());
        let mut blocks = 0;
        for &t in order {
            let of = terms.vectors(t as usize);
            starts_of_terms.push([index(blocks)?, index(term_vectors.len())?]);
            term_vectors.extend(of.iter().map(|v| number.get(v).copied().unwrap_or(without)));
            blocks += 9 * of.len() * (of.len() + 1) / 2;
        }
        starts_of_terms.push([index(blocks)?, index(term_vectors.len())?]);
        let mut columns = vec![Vec::new(); vectors.len()];
        for members in members(&starts_of_terms, &term_vectors) {
            each_pair(members, |a, b| {
                if a != b && a.max(b) < without {
                    columns[a.min(b) as usize].push(a.max(b));
                }
            });
        }
        columns.iter_mut().for_each(|column| {
            column.sort_unstable();
            column.dedup();
        });
        let (pattern, pointers, first_values) = sparsity_pattern(&vectors, &columns)?;
        let mut starts = Vec::with_capacity(blocks / 9);
        for members in members(&starts_of_terms, &term_vectors) {
            each_pair(members, |a, b| {
                let (row, column) = (a.max(b), a.min(b) as usize);
                starts.push(match columns.get(column).map(|rows| rows.partition_point(|&r| r < row)) {
                    Some(k) if row as usize != column && row < without => first_values[column][k],
                    Some(_) if row < without => pointers[vectors[column].first() as usize] as u32,
                    _ => 0,
                });
            });
        }
        vectors.push(LocalVector::CONSTRAINED);
        Ok((Self { terms: starts_of_terms, term_vectors, vectors, starts, pointers }, pattern))
    }

    /// Number of entries in the blocks of all terms.
    pub fn blocks(&self) -> usize {
        self.terms.last().map_or(0, |end| end[0] as usize)
    }

    /// Range of the blocks of one term.
    pub fn term(&self, term: usize) -> Range<usize> {
        self.terms[term][0] as usize..self.terms[term + 1][0] as usize
    }

    /// Nodal vectors with free degrees of freedom.
    pub fn vectors(&self) -> &[LocalVector] {
        &self.vectors[..self.vectors.len() - 1]
    }

    /// Assembles the values of the matrix from the blocks of all terms, along the axes of the frames, and from shifts of
    /// the diagonal, which may be empty.
    pub fn assemble(&self, blocks: &[f64], frames: &LocalFrames, shifts: &[f64], values: &mut Vec<f64>) {
        values.clear();
        values.resize(self.pointers.last().copied().unwrap_or(0), 0.0);
        let mut blocks = blocks.as_chunks::<9>().0.iter().zip(&self.starts);
        for members in members(&self.terms, &self.term_vectors) {
            each_pair(members, |a, b| {
                if let Some((block, &start)) = blocks.next() {
                    self.add_block(block, (a as usize, b as usize), start as usize, frames, values);
                }
            });
        }
        for (&at, shift) in self.pointers.iter().zip(shifts) {
            values[at] += shift;
        }
    }

    /// Adds the block of the vectors `a` (rows) and `b` (columns), whose first value has the index `start`.
    fn add_block(
        &self,
        block: &[f64; 9],
        (a, b): (usize, usize),
        start: usize,
        frames: &LocalFrames,
        values: &mut [f64],
    ) {
        let (of_a, of_b) = (self.vectors[a], self.vectors[b]);
        if of_a.first() == NONE || of_b.first() == NONE {
            return;
        }
        let mut k = *block;
        frames.rotate(&mut k, of_a.vector as usize, of_b.vector as usize);
        // Rows of the lower triangle belong to the later vector.
        let (row_vector, column_vector, [row_step, column_step]) =
            if a < b { (of_b, of_a, [1, 3]) } else { (of_a, of_b, [3, 1]) };
        let (first_row, first_column) = (row_vector.first(), column_vector.first());
        for (c, &column) in column_vector.unknowns.iter().enumerate().filter(|(_, u)| **u != NONE) {
            // Each column of the vector has one entry less than the one before, at the top.
            let shift = self.pointers[column as usize] - self.pointers[first_column as usize];
            let first = start + shift - (column - first_column) as usize;
            for (r, &row) in row_vector.unknowns.iter().enumerate() {
                if row != NONE && row >= column {
                    values[first + (row - first_row) as usize] += k[row_step * r + column_step * c];
                }
            }
        }
    }
}

fn index(n: usize) -> Result<u32, FactorError> {
    u32::try_from(n).map_err(|_| FactorError::TooLarge)
}

/// Vectors of each term.
fn members<'a>(terms: &'a [[u32; 2]], vectors: &'a [u32]) -> impl Iterator<Item = &'a [u32]> {
    terms.windows(2).map(|term| &vectors[term[0][1] as usize..term[1][1] as usize])
}

/// Calls `take` with the vectors of each lower block of a term.
fn each_pair(members: &[u32], mut take: impl FnMut(u32, u32)) {
    for (k, &a) in members.iter().enumerate() {
        members[..=k].iter().for_each(|&b| take(a, b));
    }
}

/// Index of the first value of each block below the diagonal, by column and row of the blocks.
type FirstValues = Vec<Vec<u32>>;

/// Sparsity pattern of blocks: `columns` are the later vectors that each vector is coupled to. Returns the column
/// pointers, too, and where each block begins among the values.
fn sparsity_pattern(
    vectors: &[LocalVector],
    columns: &[Vec<u32>],
) -> Result<(SymmetricPattern, Arc<Vec<usize>>, FirstValues), FactorError> {
    let (mut pointers, mut rows, mut first_values) = (vec![0], Vec::new(), Vec::new());
    for (vector, later) in vectors.iter().zip(columns) {
        let own = vector.range();
        let mut at = index(rows.len())? + own.len() as u32;
        let first_value = |&a: &u32| {
            let first = at;
            at += vectors[a as usize].range().len() as u32;
            first
        };
        first_values.push(later.iter().map(first_value).collect());
        for column in own.clone() {
            rows.extend(column..own.end);
            later.iter().for_each(|&a| rows.extend(vectors[a as usize].range()));
            pointers.push(rows.len());
        }
    }
    index(rows.len())?;
    let pointers = Arc::new(pointers);
    Ok((SymmetricPattern::new(pointers.clone(), rows), pointers, first_values))
}
