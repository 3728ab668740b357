//! Products of dense matrices (GEMM, SYRK): `C := C − A Bᵀ`, for all of C or for its lower triangle.
//!
//! The micro-kernel sums a tile of C of R registers by C columns in vector registers. The rows of B are packed once
//! for [`DEPTH`] columns, in strips of C rows; the rows of A are packed chunk by chunk of R registers, which stay in the
//! first-level cache while all strips of B pass. The order of the sums depends on the number of columns of A alone.
//!
//! K. Goto, R. A. van de Geijn, *Anatomy of high-performance matrix multiplication*, ACM Trans. Math. Softw. 34 (2008)
//! article 12.

use std::cell::RefCell;

use nalgebra::{DMatrixView, DMatrixViewMut};
use pulp::{Arch, Simd, WithSimd, bytemuck};

use super::{piece, piece_mut};

/// Number of products that are summed at a time, and number of columns of C for which B is packed.
const DEPTH: usize = 128;

/// Entries of C that are computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// All entries.
    All,
    /// Entries on and below the diagonal; those above are neither read nor written.
    Lower,
}

/// Whether a product is added to the target or takes its place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Target {
    /// `C := C − A Bᵀ`.
    Add,
    /// `C := −A Bᵀ`; C is not read.
    Replace,
}

/// Packed rows of B and one packed chunk of rows of A.
#[derive(Default)]
struct Packed {
    b: Vec<f64>,
    a: Vec<f64>,
}

thread_local! {
    static PACKED: RefCell<Packed> = RefCell::default();
}

/// Subtracts a product: `C := C − A Bᵀ` or `C := −A Bᵀ`.
///
/// # Panics
/// The sizes do not agree.
pub fn subtract_product(
    mut c: DMatrixViewMut<'_, f64>,
    a: DMatrixView<'_, f64>,
    b: DMatrixView<'_, f64>,
    part: Part,
    target: Target,
) {
    assert!(a.nrows() == c.nrows() && b.nrows() == c.ncols() && a.ncols() == b.ncols());
    let (n, depth) = (c.ncols(), a.ncols());
    if depth == 0 && target == Target::Replace {
        for j in 0..n {
            let (first, rows) = (if part == Part::Lower { j.min(c.nrows()) } else { 0 }, c.nrows());
            piece_mut(&mut c, first..rows, j).fill(0.0);
        }
    }
    let arch = Arch::new();
    PACKED.with_borrow_mut(|packed| {
        for first in (0..n).step_by(DEPTH) {
            let skipped = if part == Part::Lower { first.min(c.nrows()) } else { 0 };
            let (rows, columns) = (c.nrows() - skipped, DEPTH.min(n - first));
            for start in (0..depth).step_by(DEPTH) {
                let count = DEPTH.min(depth - start);
                arch.dispatch(Product {
                    c: c.view_mut((skipped, first), (rows, columns)),
                    a: a.view((skipped, start), (rows, count)),
                    b: b.view((first, start), (columns, count)),
                    part,
                    replace: target == Target::Replace && start == 0,
                    packed,
                });
            }
        }
    });
}

/// Product of at most [`DEPTH`] columns of A with at most [`DEPTH`] rows of B.
struct Product<'a> {
    c: DMatrixViewMut<'a, f64>,
    a: DMatrixView<'a, f64>,
    b: DMatrixView<'a, f64>,
    part: Part,
    replace: bool,
    packed: &'a mut Packed,
}

impl WithSimd for Product<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        if S::F64_LANES >= 8 {
            Kernel::<S, 2, 12> { simd }.run(self);
        } else if S::F64_LANES == 4 {
            Kernel::<S, 2, 6> { simd }.run(self);
        } else {
            Kernel::<S, 4, 4> { simd }.run(self);
        }
    }
}

/// Sums of a tile of R registers by C columns.
type Sums<S, const R: usize, const C: usize> = [[<S as Simd>::f64s; R]; C];

/// Kernel for tiles of R registers by C columns.
struct Kernel<S, const R: usize, const C: usize> {
    simd: S,
}

/// Number of columns of a narrow tile. Narrow tiles at the end of a row of tiles waste less of it.
const NARROW: usize = 4;

/// Numbers of strips of `wide` and of [`NARROW`] rows that hold all rows of B with the fewest rows of zeros.
#[inline(always)]
fn strips(rows: usize, wide: usize) -> (usize, usize) {
    let size = |narrow: usize| (rows.saturating_sub(NARROW * narrow).div_ceil(wide), narrow);
    let padded = |(a, b): (usize, usize)| wide * a + NARROW * b;
    [1, 2]
        .into_iter()
        .map(size)
        .fold(size(0), |best, next| if padded(next) < padded(best) { next } else { best })
}

/// Tile of C at the crossing of a chunk of rows and a strip of columns.
#[derive(Clone, Copy)]
struct Tile {
    row: usize,
    rows: usize,
    column: usize,
    columns: usize,
}

impl<S: Simd, const R: usize, const C: usize> Kernel<S, R, C> {
    const ROWS: usize = R * S::F64_LANES;

    #[inline(always)]
    fn run(&self, mut of: Product<'_>) {
        let (rows, columns, depth) = (of.c.nrows(), of.c.ncols(), of.a.ncols());
        let Packed { b, a } = std::mem::take(of.packed);
        let (mut b, mut a) = (b, a);
        let (wide, narrow) = strips(columns, C);
        b.resize(b.len().max((DEPTH + C + NARROW) * DEPTH), 0.0);
        a.resize(a.len().max(DEPTH * Self::ROWS), 0.0);
        let (of_wide, of_narrow) = b[..(wide * C + narrow * NARROW) * depth].split_at_mut(wide * C * depth);
        let split = columns.min(wide * C);
        pack_strips::<C>(&of.b.rows(0, split), of_wide);
        pack_strips::<NARROW>(&of.b.rows(split, columns - split), of_narrow);
        let chunk = &mut a[..depth * Self::ROWS];
        for row in (0..rows).step_by(Self::ROWS) {
            let count = Self::ROWS.min(rows - row);
            self.pack_left(&of.a, row, count, chunk);
            let chunk: &[S::f64s] = bytemuck::cast_slice(chunk);
            let chunk = chunk.as_chunks::<R>().0;
            for (s, strip) in of_wide.chunks_exact(depth * C).enumerate() {
                let tile = Tile { row, rows: count, column: s * C, columns: C.min(split - s * C) };
                self.tile::<C>(&mut of, tile, chunk, strip);
            }
            for (s, strip) in of_narrow.chunks_exact(depth * NARROW).enumerate() {
                let column = split + s * NARROW;
                let tile = Tile { row, rows: count, column, columns: NARROW.min(columns - column) };
                self.tile::<NARROW>(&mut of, tile, chunk, strip);
            }
        }
        *of.packed = Packed { b, a };
    }

    /// Computes one tile of N columns.
    #[inline(always)]
    fn tile<const N: usize>(&self, of: &mut Product<'_>, tile: Tile, a: &[[S::f64s; R]], b: &[f64]) {
        if of.part == Part::Lower && tile.column >= tile.row + tile.rows {
            return;
        }
        let sums = self.sums::<N>(a, b);
        let inside = tile.rows == Self::ROWS && tile.columns == N;
        if inside && (of.part == Part::All || tile.column + N <= tile.row + 1) {
            self.write(of, tile, sums);
        } else {
            self.write_edge(of, tile, sums);
        }
    }

    /// Packs a chunk of rows of A by columns; rows beyond the last are zero.
    #[inline(always)]
    fn pack_left(&self, a: &DMatrixView<'_, f64>, first: usize, count: usize, to: &mut [f64]) {
        for (p, to) in to.chunks_exact_mut(Self::ROWS).enumerate() {
            let from = piece(a, first..first + count, p);
            if count == Self::ROWS {
                to.copy_from_slice(from);
            } else {
                to[..count].copy_from_slice(from);
                to[count..].fill(0.0);
            }
        }
    }

    /// Product of a chunk of A with the transpose of a strip of B.
    #[inline(always)]
    fn sums<const N: usize>(&self, a: &[[S::f64s; R]], b: &[f64]) -> Sums<S, R, N> {
        let mut sums = [[self.simd.splat_f64s(0.0); R]; N];
        for (a, b) in a.iter().zip(b.as_chunks::<N>().0) {
            for c in 0..N {
                let b = self.simd.splat_f64s(b[c]);
                for r in 0..R {
                    sums[c][r] = self.simd.mul_add_e_f64s(a[r], b, sums[c][r]);
                }
            }
        }
        sums
    }

    /// Subtracts a whole tile from C.
    #[inline(always)]
    fn write<const N: usize>(&self, of: &mut Product<'_>, tile: Tile, sums: Sums<S, R, N>) {
        for c in 0..N {
            let target = piece_mut(&mut of.c, tile.row..tile.row + Self::ROWS, tile.column + c);
            let target: &mut [S::f64s] = bytemuck::cast_slice_mut(target);
            for r in 0..R {
                target[r] = if of.replace {
                    self.simd.neg_f64s(sums[c][r])
                } else {
                    self.simd.sub_f64s(target[r], sums[c][r])
                };
            }
        }
    }

    /// Subtracts from C those entries of a tile that belong to it.
    #[inline(always)]
    fn write_edge<const N: usize>(&self, of: &mut Product<'_>, tile: Tile, sums: Sums<S, R, N>) {
        for c in 0..N.min(tile.columns) {
            let above = if of.part == Part::Lower { (tile.column + c).saturating_sub(tile.row) } else { 0 };
            if above >= tile.rows {
                break;
            }
            let target = piece_mut(&mut of.c, tile.row..tile.row + tile.rows, tile.column + c);
            for r in 0..R {
                let (first, end) = (r * S::F64_LANES, (r + 1) * S::F64_LANES);
                if above <= first && end <= tile.rows {
                    let target: &mut [S::f64s] = bytemuck::cast_slice_mut(&mut target[first..end]);
                    target[0] = if of.replace {
                        self.simd.neg_f64s(sums[c][r])
                    } else {
                        self.simd.sub_f64s(target[0], sums[c][r])
                    };
                } else if above < end && first < tile.rows {
                    let sums: [S::f64s; 1] = [sums[c][r]];
                    let sums: &[f64] = bytemuck::cast_slice(&sums);
                    for i in above.max(first)..end.min(tile.rows) {
                        let sum = sums[i - first];
                        target[i] = if of.replace { -sum } else { target[i] - sum };
                    }
                }
            }
        }
    }
}

/// Packs rows of B in strips of C rows, each by columns; rows beyond the last are zero.
#[inline(always)]
fn pack_strips<const C: usize>(b: &DMatrixView<'_, f64>, to: &mut [f64]) {
    let (rows, depth) = b.shape();
    for p in 0..depth {
        let (whole, rest) = piece(b, 0..rows, p).as_chunks::<C>();
        for (s, x) in whole.iter().enumerate() {
            to[(s * depth + p) * C..][..C].copy_from_slice(x);
        }
        if !rest.is_empty() {
            let to = &mut to[(whole.len() * depth + p) * C..][..C];
            to[..rest.len()].copy_from_slice(rest);
            to[rest.len()..].fill(0.0);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::norm::max_norm;
    use nalgebra::DMatrix;

    fn entry(i: usize, j: usize) -> f64 {
        ((i * 7 + j * 13) % 17) as f64 / 17.0 - 0.4
    }

    /// Rows, columns and depth of products with all remainders of tiles.
    fn sizes() -> impl Iterator<Item = [usize; 3]> {
        let each = [1, 2, 4, 5, 7, 8, 13, 17];
        let small = each.into_iter().flat_map(move |m| each.into_iter().map(move |n| [m, n, 3]));
        small.chain([
            [0, 3, 2],
            [3, 0, 2],
            [3, 3, 0],
            [40, 31, 129],
            [300, 260, 130],
            [100, 129, 40],
            [50, 128, 300],
        ])
    }

    #[test]
    fn products_are_those_of_the_definition() {
        for [m, n, depth] in sizes() {
            for (part, target) in [
                (Part::All, Target::Add),
                (Part::All, Target::Replace),
                (Part::Lower, Target::Add),
                (Part::Lower, Target::Replace),
            ] {
                // Rows around the views.
                let (a, b) = (
                    DMatrix::from_fn(m + 3, depth, entry),
                    DMatrix::from_fn(n + 2, depth, |i, j| entry(j, i)),
                );
                let kept = DMatrix::from_fn(m + 5, n, |i, j| entry(i + 1, j + 2));
                let mut c = kept.clone();
                subtract_product(c.rows_mut(2, m), a.rows(1, m), b.rows(2, n), part, target);
                let product = a.rows(1, m) * b.rows(2, n).transpose();
                let errors = (0..m + 5).flat_map(|i| (0..n).map(move |j| (i, j))).map(|(i, j)| {
                    let inside = (2..m + 2).contains(&i) && (part == Part::All || i - 2 >= j);
                    let old = if inside && target == Target::Replace { 0.0 } else { kept[(i, j)] };
                    c[(i, j)] - (old - if inside { product[(i - 2, j)] } else { 0.0 })
                });
                let worst = max_norm(errors.chain([0.0]));
                assert!(
                    worst <= 1e-15 * (depth + 1) as f64,
                    "{m} {n} {depth} {part:?} {target:?}: {worst:e}"
                );
            }
        }
    }

    #[test]
    fn every_instruction_set_gives_the_same_product() {
        for [m, n, depth] in
            sizes().filter(|[m, n, depth]| m.min(n).min(depth) > &0 && m.max(n).max(depth) <= &128)
        {
            let (a, b) = (DMatrix::from_fn(m, depth, entry), DMatrix::from_fn(n, depth, |i, j| entry(j, i)));
            let run = |arch: Arch| {
                let mut c = DMatrix::zeros(m, n);
                let packed = &mut Packed::default();
                let (c_view, part) = (c.as_view_mut(), Part::Lower);
                arch.dispatch(Product {
                    c: c_view,
                    a: a.as_view(),
                    b: b.as_view(),
                    part,
                    replace: false,
                    packed,
                });
                c
            };
            let worst = max_norm((run(Arch::new()) - run(Arch::Scalar)).iter().copied());
            assert!(worst <= 1e-15 * depth as f64, "{m} {n} {depth}: {worst:e}");
        }
    }

    #[test]
    fn numbers_that_are_none_stay_in_their_row() {
        let mut a = DMatrix::from_fn(30, 9, entry);
        a[(11, 3)] = f64::NAN;
        let b = DMatrix::from_fn(20, 9, entry);
        let mut c = DMatrix::zeros(30, 20);
        subtract_product(c.as_view_mut(), a.as_view(), b.as_view(), Part::All, Target::Add);
        assert!((0..30).all(|i| (0..20).all(|j| c[(i, j)].is_nan() == (i == 11))));
    }

    #[test]
    fn strips_waste_little() {
        assert_eq!(
            [128, 6, 7, 9, 4, 1, 0].map(|n| strips(n, 6)),
            [(20, 2), (1, 0), (0, 2), (1, 1), (0, 1), (0, 1), (0, 0)]
        );
    }
}
