//! Block-column storage of the lower triangle of a dense symmetric matrix, or of its first columns.
//!
//! A block column of [`BLOCK`] columns is stored column by column from its first diagonal entry down to the last row.
//! The dense kernels therefore see ordinary column-major matrices, and only the diagonal blocks store their upper
//! triangle, too.

use std::ops::Range;

/// Number of columns of a block column; the last block column may have fewer.
pub(super) const BLOCK: usize = 128;

/// Trapezoid: the first `columns` columns of the lower triangle of a matrix with `rows` rows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Trapezoid {
    pub rows: usize,
    pub columns: usize,
}

impl Trapezoid {
    /// Layout of the lower triangle of a square matrix of order `n`.
    pub fn triangle(n: usize) -> Self {
        Self { rows: n, columns: n }
    }

    /// Number of block columns.
    pub fn blocks(&self) -> usize {
        self.columns.div_ceil(BLOCK)
    }

    /// Range of the columns of a block column.
    pub fn columns_of(&self, block: usize) -> Range<usize> {
        block * BLOCK..((block + 1) * BLOCK).min(self.columns)
    }

    /// Index of the first entry of a block column; for the block column past the last, the number of all entries.
    pub fn start(&self, block: usize) -> usize {
        let whole = block.min(self.columns / BLOCK);
        let before = BLOCK * whole * self.rows - BLOCK * BLOCK * (whole * whole.saturating_sub(1) / 2);
        let rest = if block > whole { self.columns % BLOCK } else { 0 };
        before + rest * (self.rows - whole * BLOCK)
    }

    /// Row and column of the entry with a storage index.
    pub fn place(&self, at: usize) -> (usize, usize) {
        let (mut low, mut high) = (0, self.blocks());
        while high - low > 1 {
            let middle = (low + high) / 2;
            if self.start(middle) <= at { low = middle } else { high = middle }
        }
        let (first, within) = (low * BLOCK, at - self.start(low));
        let height = self.rows - first;
        (first + within % height, first + within / height)
    }

    /// Number of stored entries.
    pub fn size(&self) -> usize {
        self.start(self.blocks())
    }

    /// Index of the diagonal entry of a column; the entries below it follow.
    #[inline]
    pub fn diagonal(&self, column: usize) -> usize {
        let block = column / BLOCK;
        let within = column - block * BLOCK;
        self.start(block) + within * (self.rows - block * BLOCK) + within
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_of_columns_follow_one_another() {
        for (rows, columns) in [(1, 1), (5, 3), (BLOCK, BLOCK), (700, 300), (257, 256), (400, 129), (3, 0)] {
            let t = Trapezoid { rows, columns };
            let mut end = 0;
            for j in 0..columns {
                let first = j / BLOCK * BLOCK;
                assert_eq!(t.diagonal(j), end + j - first, "{rows} {columns} {j}");
                assert_eq!(t.place(t.diagonal(j)), (j, j));
                assert_eq!(t.place(t.diagonal(j) + rows - 1 - j), (rows - 1, j));
                end += rows - first;
            }
            assert_eq!(t.size(), end);
        }
    }
}
