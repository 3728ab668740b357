//! Cholesky factorisation of a diagonal block and triangular solve (TRSM) of the rows below it, in vector registers.
//!
//! Rows are processed in chunks of a few registers, columns in strips of a few: a chunk of rows of a strip stays in
//! registers while the products with all columns before it are subtracted. The triangle is stored strip by strip, in
//! the order in which it is read. The result of a row does not depend on the rows beside it, so rows may be divided
//! among threads in any way. At the widths of fronts, 20 to 128 columns, this is faster than the recursive kernels for
//! large matrices.

use nalgebra::{DMatrixView, DMatrixViewMut};
use pulp::{Arch, Simd, WithSimd, bytemuck};

use super::triangular::Diagonal;
use super::{piece, piece_mut};
use crate::trapezoid::BLOCK;

/// Number of columns of the widest strip.
const WIDEST: usize = 8;

/// Cholesky factor `L₁₁` of a diagonal block of up to [`BLOCK`] columns, prepared for triangular solves with `L₁₁⁻ᵀ`.
pub(crate) struct DiagonalBlock {
    arch: Arch,
    width: usize,
    /// Strips of columns: first the entries of their rows in the columns before them, then their own triangle, with
    /// reciprocals on the diagonal. A unit matrix pads the last strip beyond the block.
    strips: Vec<f64>,
}

impl DiagonalBlock {
    /// Creates an empty factor with memory for the largest block.
    pub fn new() -> Self {
        let blocks = BLOCK / 4 + 1;
        Self { arch: Arch::new(), width: 0, strips: Vec::with_capacity(8 * blocks * (blocks + 1)) }
    }

    /// Factors the lower triangle of a block in place. Returns false if it is not positive definite; the block is
    /// unchanged then.
    pub fn factor(&mut self, block: DMatrixViewMut<'_, f64>) -> bool {
        self.width = block.nrows();
        self.strips.clear();
        self.arch.dispatch(Factorization { strips: &mut self.strips, block })
    }

    /// Takes the lower triangle of a block as the factor.
    pub fn load(&mut self, block: DMatrixView<'_, f64>, diagonal: Diagonal) {
        self.width = block.nrows();
        self.strips.clear();
        self.arch.dispatch(Loading { strips: &mut self.strips, block, diagonal });
    }

    /// Triangular solve (TRSM) `A L₁₁⁻ᵀ` in place of the rows `A`.
    pub fn solve_rows(&self, rows: DMatrixViewMut<'_, f64>) {
        debug_assert_eq!(rows.ncols(), self.width);
        if rows.nrows() > 0 {
            self.arch.dispatch(Division { strips: &self.strips, rows });
        }
    }
}

/// Chunk of R · lanes rows: R vector registers for each column.
type Chunk<S, const R: usize> = [[<S as Simd>::f64s; R]; BLOCK + WIDEST];

/// Vector kernel for strips of C columns and chunks of R registers.
struct Kernel<S, const R: usize, const C: usize> {
    simd: S,
}

impl<S: Simd, const R: usize, const C: usize> Kernel<S, R, C> {
    /// Number of rows of a chunk.
    const ROWS: usize = R * S::F64_LANES;

    #[inline(always)]
    fn chunk(&self) -> Chunk<S, R> {
        [[self.simd.splat_f64s(0.0); R]; BLOCK + WIDEST]
    }

    /// Update of a strip, which begins at column `at`, by the columns before it: `A − X L₂₁ᵀ`.
    #[inline(always)]
    fn update(&self, chunk: &mut [[S::f64s; R]], before: &[f64], at: usize) {
        let mut sum = [[self.simd.splat_f64s(0.0); R]; C];
        for (x, l) in chunk[..at].iter().zip(before.chunks_exact(C)) {
            for c in 0..C {
                let l = self.simd.splat_f64s(l[c]);
                for r in 0..R {
                    sum[c][r] = self.simd.mul_add_e_f64s(x[r], l, sum[c][r]);
                }
            }
        }
        for (column, sum) in chunk[at..at + C].iter_mut().zip(&sum) {
            for r in 0..R {
                column[r] = self.simd.sub_f64s(column[r], sum[r]);
            }
        }
    }

    /// Triangular solve of the columns of a strip with the transpose of its own triangle.
    #[inline(always)]
    fn solve(&self, chunk: &mut [[S::f64s; R]], own: &[f64], at: usize) {
        let mut x = [[self.simd.splat_f64s(0.0); R]; C];
        x.copy_from_slice(&chunk[at..at + C]);
        for (c, row) in own.chunks_exact(C).enumerate().take(C) {
            for d in 0..c {
                let l = self.simd.splat_f64s(-row[d]);
                for r in 0..R {
                    x[c][r] = self.simd.mul_add_e_f64s(x[d][r], l, x[c][r]);
                }
            }
            let reciprocal = self.simd.splat_f64s(row[c]);
            for r in 0..R {
                x[c][r] = self.simd.mul_f64s(x[c][r], reciprocal);
            }
        }
        chunk[at..at + C].copy_from_slice(&x);
    }

    /// Triangular solve of a chunk with all strips so far; returns the number of their columns.
    #[inline(always)]
    fn divide(&self, chunk: &mut [[S::f64s; R]], strips: &[f64]) -> usize {
        let (mut at, mut rest) = (0, strips);
        while !rest.is_empty() {
            let (before, own) = rest.split_at(C * at);
            let (own, others) = own.split_at(C * C);
            self.update(chunk, before, at);
            self.solve(chunk, own, at);
            (at, rest) = (at + C, others);
        }
        at
    }

    /// Reads the rows from `first` on into a chunk.
    #[inline(always)]
    fn read(&self, rows: &DMatrixView<'_, f64>, first: usize, chunk: &mut [[S::f64s; R]]) {
        let count = (rows.nrows() - first).min(Self::ROWS);
        for (j, to) in chunk.iter_mut().enumerate().take(rows.ncols()) {
            let to: &mut [f64] = bytemuck::cast_slice_mut(to);
            let column = piece(rows, first..first + count, j);
            if count == Self::ROWS {
                to.copy_from_slice(column);
            } else {
                to[..count].copy_from_slice(column);
            }
        }
    }

    /// Writes a chunk back to the rows from `first` on.
    #[inline(always)]
    fn write(&self, chunk: &[[S::f64s; R]], first: usize, rows: &mut DMatrixViewMut<'_, f64>) {
        let count = (rows.nrows() - first).min(Self::ROWS);
        for (j, from) in chunk.iter().enumerate().take(rows.ncols()) {
            let from: &[f64] = bytemuck::cast_slice(from);
            let column = piece_mut(rows, first..first + count, j);
            if count == Self::ROWS {
                column.copy_from_slice(from);
            } else {
                column.copy_from_slice(&from[..count]);
            }
        }
    }

    /// Factors the triangle of a strip that begins with row `row` of the chunk and column `at` of a block of `width`
    /// columns, and appends it to the strips. Returns false if a pivot is not positive.
    #[inline(always)]
    fn own(
        &self,
        chunk: &[[S::f64s; R]],
        (row, at, width): (usize, usize, usize),
        strips: &mut Vec<f64>,
    ) -> bool {
        let mut l = [[0.0; C]; C];
        for c in 0..C {
            let column: &[f64] = bytemuck::cast_slice(&chunk[at + c]);
            for r in c..C {
                l[r][c] = if at + r < width { column[row + r] } else { f64::from(u8::from(r == c)) };
            }
        }
        for c in 0..C {
            for d in 0..c {
                for r in c..C {
                    l[r][c] -= l[r][d] * l[c][d];
                }
            }
            let pivot = l[c][c];
            if !(pivot > 0.0 && pivot < f64::INFINITY) {
                return false;
            }
            let reciprocal = pivot.sqrt().recip();
            for r in c + 1..C {
                l[r][c] *= reciprocal;
            }
            l[c][c] = reciprocal;
        }
        l.iter().for_each(|row| strips.extend_from_slice(row));
        true
    }

    #[inline(always)]
    fn factor(&self, strips: &mut Vec<f64>, mut block: DMatrixViewMut<'_, f64>) -> bool {
        let width = block.nrows();
        let mut chunk = self.chunk();
        for first in (0..width).step_by(Self::ROWS) {
            let columns = (first + Self::ROWS).min(width);
            self.read(&block.columns(0, columns), first, &mut chunk);
            self.divide(&mut chunk, strips);
            for row in (0..Self::ROWS).step_by(C) {
                let at = first + row;
                if at >= width {
                    break;
                }
                let before = strips.len();
                for column in &chunk[..at] {
                    let column: &[f64] = bytemuck::cast_slice(column);
                    strips.extend_from_slice(&column[row..row + C]);
                }
                self.update(&mut chunk, &strips[before..], at);
                let own = strips.len();
                if !self.own(&chunk, (row, at, width), strips) {
                    return false;
                }
                self.solve(&mut chunk, &strips[own..], at);
            }
        }
        self.unpack(strips, &mut block);
        true
    }

    /// Writes the factor from its strips to the block.
    #[inline(always)]
    fn unpack(&self, strips: &[f64], block: &mut DMatrixViewMut<'_, f64>) {
        let width = block.nrows();
        for j in 0..width {
            let (first, within, column) = (j / C * C, j % C, piece_mut(block, 0..width, j));
            // The strips before this one hold C, 2C, ... rows of C entries.
            let own = &strips[first * (first + C) / 2 + C * first..][..C * C];
            column[j] = own[C * within + within].recip();
            for r in within + 1..C.min(width - first) {
                column[first + r] = own[C * r + within];
            }
            for at in (first + C..width).step_by(C) {
                let row = &strips[at * (at + C) / 2 + C * j..][..C];
                let count = C.min(width - at);
                column[at..at + count].copy_from_slice(&row[..count]);
            }
        }
    }

    /// Makes strips of a lower triangle.
    #[inline(always)]
    fn load(&self, strips: &mut Vec<f64>, block: &DMatrixView<'_, f64>, diagonal: Diagonal) {
        let width = block.nrows();
        for at in (0..width).step_by(C) {
            let end = width.min(at + C);
            for j in 0..at {
                let column = piece(block, at..end, j);
                strips.extend((0..C).map(|r| column.get(r).copied().unwrap_or(0.0)));
            }
            for i in at..at + C {
                strips.extend((at..at + C).map(|j| {
                    if j > i || (i >= end && j != i) {
                        0.0
                    } else if i == j {
                        if i >= end || diagonal == Diagonal::Unit { 1.0 } else { block[(i, i)].recip() }
                    } else {
                        block[(i, j)]
                    }
                }));
            }
        }
    }

    #[inline(always)]
    fn divide_all(&self, strips: &[f64], mut rows: DMatrixViewMut<'_, f64>) {
        let mut chunk = self.chunk();
        for first in (0..rows.nrows()).step_by(Self::ROWS) {
            self.read(&rows.as_view(), first, &mut chunk);
            self.divide(&mut chunk, strips);
            self.write(&chunk, first, &mut rows);
        }
    }
}

/// Calls a method of the kernel that suits the instruction set: its sums fill the registers, and no more.
macro_rules! with_kernel {
    ($simd:expr, $S:ident, $method:ident($($argument:expr),*)) => {
        if $S::F64_LANES >= 8 {
            Kernel::<$S, 2, 8> { simd: $simd }.$method($($argument),*)
        } else if $S::F64_LANES == 4 {
            Kernel::<$S, 2, 4> { simd: $simd }.$method($($argument),*)
        } else {
            Kernel::<$S, 4, 4> { simd: $simd }.$method($($argument),*)
        }
    };
}

struct Factorization<'a> {
    strips: &'a mut Vec<f64>,
    block: DMatrixViewMut<'a, f64>,
}

impl WithSimd for Factorization<'_> {
    type Output = bool;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> bool {
        with_kernel!(simd, S, factor(self.strips, self.block))
    }
}

struct Loading<'a> {
    strips: &'a mut Vec<f64>,
    block: DMatrixView<'a, f64>,
    diagonal: Diagonal,
}

impl WithSimd for Loading<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        with_kernel!(simd, S, load(self.strips, &self.block, self.diagonal))
    }
}

struct Division<'a> {
    strips: &'a [f64],
    rows: DMatrixViewMut<'a, f64>,
}

impl WithSimd for Division<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        with_kernel!(simd, S, divide_all(self.strips, self.rows))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::norm::max_norm;
    use nalgebra::DMatrix;

    fn matrix(n: usize, rows: usize) -> (DMatrix<f64>, DMatrix<f64>) {
        let entry = |i: usize, j: usize| ((i * 7 + j * 13) % 17) as f64 / 17.0 - 0.4;
        let b = DMatrix::from_fn(n, n, entry);
        let a = &b * b.transpose() + DMatrix::<f64>::identity(n, n);
        (a, DMatrix::from_fn(rows, n, |i, j| entry(i + 3, 2 * j)))
    }

    #[test]
    fn factors_and_divides_blocks_of_any_size() {
        let mut triangle = DiagonalBlock::new();
        for n in (1..=40).chain([63, 64, 65, 100, 120, 127, 128]) {
            for rows in [0, 1, 7, 8, 17, 100] {
                let (a, c) = matrix(n, rows);
                let (mut l, mut x) = (a.clone(), c.clone());
                for j in 1..n {
                    (0..j).for_each(|i| l[(i, j)] = f64::NAN);
                }
                assert!(triangle.factor(l.as_view_mut()), "{n}");
                triangle.solve_rows(x.as_view_mut());
                let lower = DMatrix::from_fn(n, n, |i, j| if i >= j { l[(i, j)] } else { 0.0 });
                let scale = max_norm(a.iter().copied());
                assert!(
                    max_norm((&lower * lower.transpose() - &a).iter().copied()) <= 1e-14 * n as f64 * scale,
                    "{n}"
                );
                if rows > 0 {
                    assert!(
                        max_norm((&x * lower.transpose() - &c).iter().copied()) <= 1e-14 * n as f64 * scale,
                        "{n}"
                    );
                }
                assert!(
                    (0..n).all(|j| (0..j).all(|i| l[(i, j)].is_nan())),
                    "the upper triangle is not written"
                );
            }
        }
    }

    #[test]
    fn every_instruction_set_gives_the_same_factor() {
        let (a, c) = matrix(77, 50);
        let run = |arch| {
            let mut triangle = DiagonalBlock { arch, ..DiagonalBlock::new() };
            let (mut l, mut x) = (a.clone(), c.clone());
            assert!(triangle.factor(l.as_view_mut()));
            triangle.solve_rows(x.as_view_mut());
            x
        };
        let (fast, plain) = (run(Arch::new()), run(Arch::Scalar));
        assert!(max_norm((&fast - &plain).iter().copied()) <= 1e-13 * max_norm(plain.iter().copied()));
    }

    #[test]
    fn a_block_that_is_not_positive_definite_is_found_out() {
        let mut triangle = DiagonalBlock::new();
        for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            for at in [0, 7, 8, 30, 44] {
                let (mut a, _) = matrix(45, 0);
                for i in 0..45 {
                    (a[(i, at)], a[(at, i)]) = (0.0, 0.0);
                }
                a[(at, at)] = bad;
                assert!(!triangle.factor(a.as_view_mut()), "{bad} {at}");
            }
        }
    }
}
