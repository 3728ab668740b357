//! Forward and backward substitution with one block column of a factor for several right sides side by side.
//!
//! With one right side a solution takes as long as the reading of the factor (memory bandwidth). Here every entry of the
//! factor is read once for all right sides of a group. These are interleaved, unknown by unknown, so that one entry of
//! the factor multiplies whole vector registers. Every right side has the operations of its own, in an order that
//! depends on the factor alone; its solution therefore depends neither on the right sides beside it nor on the size of
//! the group.

use pulp::{Simd, WithSimd};

use super::block_column::BlockColumn;

/// Calls a method of the kernel with as many registers as K right sides fill.
macro_rules! with_registers {
    ($simd:expr, $S:ident, $K:expr, $method:ident($($argument:expr),*)) => {
        match $K / $S::F64_LANES {
            0 | 1 => Kernel::<$S, 1> { simd: $simd }.$method($($argument),*),
            2 => Kernel::<$S, 2> { simd: $simd }.$method($($argument),*),
            4 => Kernel::<$S, 4> { simd: $simd }.$method($($argument),*),
            8 => Kernel::<$S, 8> { simd: $simd }.$method($($argument),*),
            _ => Kernel::<$S, 16> { simd: $simd }.$method($($argument),*),
        }
    };
}

/// Forward substitution `L X = B` for K right sides, 8 or 16: `x` holds the right sides of the columns and of those
/// after them in the front, `y` the sums of the rows.
pub(super) struct ForwardGroup<'a, const K: usize> {
    pub block: BlockColumn<'a>,
    pub x: &'a mut [[f64; K]],
    pub y: &'a mut [[f64; K]],
}

impl<const K: usize> WithSimd for ForwardGroup<'_, K> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { block, x, y } = self;
        let (x, y) =
            (S::as_mut_simd_f64s(x.as_flattened_mut()).0, S::as_mut_simd_f64s(y.as_flattened_mut()).0);
        with_registers!(simd, S, K, forward_all(block, x, y));
    }
}

/// Backward substitution `Lᵀ X = B` for K right sides, 8 or 16: `x` holds the right sides of the columns and the
/// solutions at those after them in the front, `y` the solutions at the rows.
pub(super) struct BackwardGroup<'a, const K: usize> {
    pub block: BlockColumn<'a>,
    pub x: &'a mut [[f64; K]],
    pub y: &'a [[f64; K]],
}

impl<const K: usize> WithSimd for BackwardGroup<'_, K> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { block, x, y } = self;
        let (x, y) = (S::as_mut_simd_f64s(x.as_flattened_mut()).0, S::as_simd_f64s(y.as_flattened()).0);
        with_registers!(simd, S, K, backward_all(block, x, y));
    }
}

/// Vector kernel for right sides that fill R registers.
struct Kernel<S, const R: usize> {
    simd: S,
}

impl<S: Simd, const R: usize> Kernel<S, R> {
    /// Forward substitution with all columns, in groups of 8, 4, 2 and 1.
    #[inline(always)]
    fn forward_all(&self, block: BlockColumn<'_>, x: &mut [S::f64s], y: &mut [S::f64s]) {
        let (x, y) = (x.as_chunks_mut::<R>().0, y.as_chunks_mut::<R>().0);
        let mut first = 0;
        while first < block.width {
            first += match block.width - first {
                8.. => self.forward::<8>(block, first, x, y),
                4.. => self.forward::<4>(block, first, x, y),
                2.. => self.forward::<2>(block, first, x, y),
                _ => self.forward::<1>(block, first, x, y),
            };
        }
    }

    /// Forward substitution with C columns; returns their number.
    #[inline(always)]
    fn forward<const C: usize>(
        &self,
        block: BlockColumn<'_>,
        first: usize,
        x: &mut [[S::f64s; R]],
        y: &mut [[S::f64s; R]],
    ) -> usize {
        let simd = self.simd;
        let columns: [&[f64]; C] = block.columns(first, first);
        let (own, below) = x[first..].split_at_mut(C);
        // Values of the columns, then their negatives.
        let mut factors = [[simd.splat_f64s(0.0); R]; C];
        factors.copy_from_slice(own);
        for c in 0..C {
            if !block.unit {
                let reciprocal = simd.splat_f64s(columns[c][c].recip());
                factors[c] = factors[c].map(|x| simd.mul_f64s(x, reciprocal));
            }
            own[c] = factors[c];
            factors[c] = factors[c].map(|x| simd.neg_f64s(x));
            for r in c + 1..C {
                let l = simd.splat_f64s(columns[c][r]);
                for k in 0..R {
                    factors[r][k] = simd.mul_add_e_f64s(factors[c][k], l, factors[r][k]);
                }
            }
        }
        let end = C + below.len();
        self.add_multiples(columns.map(|column| &column[C..end]), &factors, below);
        self.add_multiples(columns.map(|column| &column[end..]), &factors, y);
        C
    }

    /// Update `Y += Σ a_c f_cᵀ` by the columns `a_c`.
    #[inline(always)]
    fn add_multiples<const C: usize>(
        &self,
        columns: [&[f64]; C],
        factors: &[[S::f64s; R]; C],
        y: &mut [[S::f64s; R]],
    ) {
        let columns = columns.map(|column| &column[..y.len()]);
        for (i, y) in y.iter_mut().enumerate() {
            let mut sum = *y;
            for c in 0..C {
                let l = self.simd.splat_f64s(columns[c][i]);
                for k in 0..R {
                    sum[k] = self.simd.mul_add_e_f64s(factors[c][k], l, sum[k]);
                }
            }
            *y = sum;
        }
    }

    /// Backward substitution with all columns, in the groups of [`forward_all`](Self::forward_all), last ones first.
    #[inline(always)]
    fn backward_all(&self, block: BlockColumn<'_>, x: &mut [S::f64s], y: &[S::f64s]) {
        let (x, y) = (x.as_chunks_mut::<R>().0, y.as_chunks::<R>().0);
        let mut end = block.width;
        while end > 0 {
            end -= match end % 8 {
                0 => self.backward::<8>(block, end - 8, x, y),
                odd if odd % 2 == 1 => self.backward::<1>(block, end - 1, x, y),
                4 => self.backward::<4>(block, end - 4, x, y),
                _ => self.backward::<2>(block, end - 2, x, y),
            };
        }
    }

    /// Backward substitution with C columns; returns their number.
    #[inline(always)]
    fn backward<const C: usize>(
        &self,
        block: BlockColumn<'_>,
        first: usize,
        x: &mut [[S::f64s; R]],
        y: &[[S::f64s; R]],
    ) -> usize {
        let simd = self.simd;
        let columns: [&[f64]; C] = block.columns(first, first);
        let (own, below) = x[first..].split_at_mut(C);
        let end = C + below.len();
        let mut sums = [[simd.splat_f64s(0.0); R]; C];
        self.add_products(columns.map(|column| &column[C..end]), below, &mut sums);
        self.add_products(columns.map(|column| &column[end..]), y, &mut sums);
        for c in (0..C).rev() {
            for r in c + 1..C {
                let l = simd.splat_f64s(columns[c][r]);
                for k in 0..R {
                    sums[c][k] = simd.mul_add_e_f64s(own[r][k], l, sums[c][k]);
                }
            }
            for k in 0..R {
                own[c][k] = simd.sub_f64s(own[c][k], sums[c][k]);
            }
            if !block.unit {
                let reciprocal = simd.splat_f64s(columns[c][c].recip());
                own[c] = own[c].map(|x| simd.mul_f64s(x, reciprocal));
            }
        }
        C
    }

    /// Adds the products `a_cᵀ X` to `sums`.
    #[inline(always)]
    fn add_products<const C: usize>(
        &self,
        columns: [&[f64]; C],
        x: &[[S::f64s; R]],
        sums: &mut [[S::f64s; R]; C],
    ) {
        let columns = columns.map(|column| &column[..x.len()]);
        let mut all = *sums;
        for (i, x) in x.iter().enumerate() {
            for c in 0..C {
                let l = self.simd.splat_f64s(columns[c][i]);
                for k in 0..R {
                    all[c][k] = self.simd.mul_add_e_f64s(x[k], l, all[c][k]);
                }
            }
        }
        *sums = all;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pulp::Arch;

    fn entry(i: usize, j: usize) -> f64 {
        if i == j { 2.0 + (i as f64).sin() } else { ((3 * i + 7 * j) as f64).cos() / 40.0 }
    }

    fn start<const K: usize>(height: usize) -> Vec<[f64; K]> {
        (0..height).map(|i| std::array::from_fn(|k| (5.0 + (i + 31 * k) as f64).sin())).collect()
    }

    /// Solutions of `L X = B` and `Lᵀ X = B` for one block column.
    fn solved<const K: usize>(
        arch: Arch,
        block: BlockColumn<'_>,
        later: usize,
    ) -> (Vec<[f64; K]>, Vec<[f64; K]>) {
        let height = block.values.len() / block.width;
        let (mut forward, mut backward) = (start::<K>(height), start::<K>(height));
        let (x, y) = forward.split_at_mut(block.width + later);
        arch.dispatch(ForwardGroup { block, x, y });
        let (x, y) = backward.split_at_mut(block.width + later);
        arch.dispatch(BackwardGroup { block, x, y });
        (forward, backward)
    }

    fn close<const K: usize>(found: &[[f64; K]], k: usize, expected: &[f64]) {
        for (a, b) in found.iter().zip(expected) {
            assert!((a[k] - b).abs() < 1e-12 * (1.0 + b.abs()), "{} {b}", a[k]);
        }
    }

    /// Compares with sums entry by entry, for widths and heights with and without remainders.
    #[test]
    fn solutions_are_those_of_the_columns() {
        for (width, later, rows) in [(1, 0, 0), (3, 2, 5), (6, 0, 9), (8, 0, 1), (21, 9, 40), (128, 37, 203)]
        {
            for unit in [false, true] {
                let height = width + later + rows;
                let values: Vec<f64> =
                    (0..width).flat_map(|j| (0..height).map(move |i| entry(i, j))).collect();
                let l = |i: usize, j: usize| if i == j && unit { 1.0 } else { entry(i, j) };
                let block = BlockColumn { values: &values, width, unit };
                let eight = solved::<8>(Arch::new(), block, later);
                let sixteen = solved::<16>(Arch::new(), block, later);
                let scalar = solved::<16>(Arch::Scalar, block, later);
                for k in 0..16 {
                    let start: Vec<f64> = start::<16>(height).iter().map(|b| b[k]).collect();
                    let mut expected = start.clone();
                    for j in 0..width {
                        expected[j] /= l(j, j);
                        (j + 1..height).for_each(|i| expected[i] -= l(i, j) * expected[j]);
                    }
                    close(&sixteen.0, k, &expected);
                    close(&scalar.0, k, &expected);
                    let mut expected = start;
                    for j in (0..width).rev() {
                        let sum: f64 = (j + 1..height).map(|i| l(i, j) * expected[i]).sum();
                        expected[j] = (expected[j] - sum) / l(j, j);
                    }
                    close(&sixteen.1, k, &expected);
                    close(&scalar.1, k, &expected);
                }
                for (eight, sixteen) in [(&eight.0, &sixteen.0), (&eight.1, &sixteen.1)] {
                    assert!(eight.iter().zip(sixteen).all(|(a, b)| *a == b[..8]), "groups give equal bits");
                }
            }
        }
    }
}
