//! Storage of the lower triangle of a dense symmetric matrix, or of its first columns, by block columns.
//!
//! A block column of [`BLOCK`] columns is kept from its first diagonal entry down to the last row, by columns. So the
//! dense kernels see ordinary matrices, and of the upper triangle only that of the blocks on the diagonal is stored.

use std::ops::Range;

/// Columns of a block column. The last one may have fewer.
pub(super) const BLOCK: usize = 128;

/// The first `columns` columns of the lower triangle of a matrix of `rows` rows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Trapezoid {
    pub rows: usize,
    pub columns: usize,
}

impl Trapezoid {
    /// Lower triangle of a square matrix.
    pub fn triangle(n: usize) -> Self {
        Self { rows: n, columns: n }
    }

    /// Number of block columns.
    pub fn blocks(&self) -> usize {
        self.columns.div_ceil(BLOCK)
    }

    /// Columns of a block column.
    pub fn columns_of(&self, block: usize) -> Range<usize> {
        block * BLOCK..((block + 1) * BLOCK).min(self.columns)
    }

    /// First entry of a block column; of the one past the last, the number of all entries.
    pub fn start(&self, block: usize) -> usize {
        let whole = block.min(self.columns / BLOCK);
        let before = BLOCK * whole * self.rows - BLOCK * BLOCK * (whole * whole.saturating_sub(1) / 2);
        let rest = if block > whole { self.columns % BLOCK } else { 0 };
        before + rest * (self.rows - whole * BLOCK)
    }

    /// Row and column of an entry.
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

    /// Stored entries.
    pub fn size(&self) -> usize {
        self.start(self.blocks())
    }

    /// Where the diagonal entry of a column is; those below follow.
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
