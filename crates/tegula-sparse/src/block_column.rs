//! Forward and backward substitution with one block column of a factor, in one pass over its columns.
//!
//! A solution reads every entry of the factor twice and does hardly any arithmetic with it, so it takes as long as the
//! reading (memory bandwidth). A few neighbouring columns are read at once, from the diagonal down to the last row; the
//! vector entries that they update, or are multiplied by, are read and written once for all of them.

use pulp::{Simd, WithSimd};

/// Number of columns that are read at once.
const TOGETHER: usize = 8;

/// Block column of a front, from its diagonal block down to the last row.
#[derive(Clone, Copy)]
pub(super) struct BlockColumn<'a> {
    /// Entries, column by column.
    pub values: &'a [f64],
    pub width: usize,
    /// Whether ones on the diagonal take the place of the stored entries.
    pub unit: bool,
}

impl<'a> BlockColumn<'a> {
    /// Neighbouring columns from column `first` on, each from row `row` down.
    #[inline(always)]
    pub fn columns<const C: usize>(&self, first: usize, row: usize) -> [&'a [f64]; C] {
        let height = self.values.len() / self.width;
        std::array::from_fn(|c| &self.values[(first + c) * height + row..(first + c + 1) * height])
    }

    /// Number of columns that are read in groups; the remaining ones are read one by one.
    fn whole(&self) -> usize {
        self.width / TOGETHER * TOGETHER
    }
}

/// Forward substitution `L x = b`: `x` holds the right sides of the columns and of those after them in the front, `y`
/// the sums of the rows.
pub(super) struct Forward<'a> {
    pub block: BlockColumn<'a>,
    pub x: &'a mut [f64],
    pub y: &'a mut [f64],
}

impl WithSimd for Forward<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { block, x, y } = self;
        for first in (0..block.whole()).step_by(TOGETHER) {
            forward::<S, TOGETHER>(simd, block, first, x, y);
        }
        for first in block.whole()..block.width {
            forward::<S, 1>(simd, block, first, x, y);
        }
    }
}

#[inline(always)]
fn forward<S: Simd, const C: usize>(
    simd: S,
    block: BlockColumn<'_>,
    first: usize,
    x: &mut [f64],
    y: &mut [f64],
) {
    let columns: [&[f64]; C] = block.columns(first, first);
    let (own, below) = x[first..].split_at_mut(C);
    for c in 0..C {
        if !block.unit {
            own[c] /= columns[c][c];
        }
        for r in c + 1..C {
            own[r] -= columns[c][r] * own[c];
        }
    }
    let factors = std::array::from_fn(|c| own[c]);
    let end = C + below.len();
    subtract_products(simd, columns.map(|column| &column[C..end]), factors, below);
    subtract_products(simd, columns.map(|column| &column[end..]), factors, y);
}

/// Update `y −= Σ f_c a_c` by the columns `a_c`.
#[inline(always)]
fn subtract_products<S: Simd, const C: usize>(
    simd: S,
    columns: [&[f64]; C],
    factors: [f64; C],
    y: &mut [f64],
) {
    let parts = columns.map(|column| S::as_simd_f64s(&column[..y.len()]));
    let (head, tail) = S::as_mut_simd_f64s(y);
    let heads = parts.map(|p| &p.0[..head.len()]);
    let minus = factors.map(|f| simd.splat_f64s(-f));
    for (i, y) in head.iter_mut().enumerate() {
        // Two independent sums, so that one need not wait for the other.
        let (mut even, mut odd) = (*y, simd.splat_f64s(0.0));
        for c in 0..C {
            let sum = if c % 2 == 0 { &mut even } else { &mut odd };
            *sum = simd.mul_add_e_f64s(heads[c][i], minus[c], *sum);
        }
        *y = simd.add_f64s(even, odd);
    }
    let tails = parts.map(|p| &p.1[..tail.len()]);
    for (i, y) in tail.iter_mut().enumerate() {
        for c in 0..C {
            *y -= tails[c][i] * factors[c];
        }
    }
}

/// Backward substitution `Lᵀ x = b`: `x` holds the right sides of the columns and the solution at those after them in
/// the front, `y` the solution at the rows.
pub(super) struct Backward<'a> {
    pub block: BlockColumn<'a>,
    pub x: &'a mut [f64],
    pub y: &'a [f64],
}

impl WithSimd for Backward<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { block, x, y } = self;
        for first in (block.whole()..block.width).rev() {
            backward::<S, 1>(simd, block, first, x, y);
        }
        for first in (0..block.whole()).step_by(TOGETHER).rev() {
            backward::<S, TOGETHER>(simd, block, first, x, y);
        }
    }
}

#[inline(always)]
fn backward<S: Simd, const C: usize>(
    simd: S,
    block: BlockColumn<'_>,
    first: usize,
    x: &mut [f64],
    y: &[f64],
) {
    let columns: [&[f64]; C] = block.columns(first, first);
    let (own, below) = x[first..].split_at_mut(C);
    let end = C + below.len();
    let mut sums = [simd.splat_f64s(0.0); C];
    let mut rest = [0.0; C];
    add_products(simd, columns.map(|column| &column[C..end]), below, &mut sums, &mut rest);
    add_products(simd, columns.map(|column| &column[end..]), y, &mut sums, &mut rest);
    for c in (0..C).rev() {
        own[c] -= rest[c] + simd.reduce_sum_f64s(sums[c]);
        for r in c + 1..C {
            own[c] -= columns[c][r] * own[r];
        }
        if !block.unit {
            own[c] /= columns[c][c];
        }
    }
}

/// Adds the products `a_c · x` to `sums`, those of the last few entries to `rest`.
#[inline(always)]
fn add_products<S: Simd, const C: usize>(
    simd: S,
    columns: [&[f64]; C],
    x: &[f64],
    sums: &mut [S::f64s; C],
    rest: &mut [f64; C],
) {
    let parts = columns.map(|column| S::as_simd_f64s(&column[..x.len()]));
    let (head, tail) = S::as_simd_f64s(x);
    let heads = parts.map(|p| &p.0[..head.len()]);
    for (i, x) in head.iter().enumerate() {
        for c in 0..C {
            sums[c] = simd.mul_add_e_f64s(heads[c][i], *x, sums[c]);
        }
    }
    let tails = parts.map(|p| &p.1[..tail.len()]);
    for (i, x) in tail.iter().enumerate() {
        for c in 0..C {
            rest[c] += tails[c][i] * x;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pulp::Arch;

    /// Compares with sums entry by entry, for widths and heights with and without remainders.
    #[test]
    fn solutions_are_those_of_the_columns() {
        let entry = |i: usize, j: usize| {
            if i == j { 2.0 + (i as f64).sin() } else { ((3 * i + 7 * j) as f64).cos() / 40.0 }
        };
        for (width, later, rows) in [(1, 0, 0), (3, 2, 5), (8, 0, 1), (21, 9, 40), (128, 37, 203)] {
            for unit in [false, true] {
                let height = width + later + rows;
                let values: Vec<f64> =
                    (0..width).flat_map(|j| (0..height).map(move |i| entry(i, j))).collect();
                let l = |i: usize, j: usize| if i == j && unit { 1.0 } else { entry(i, j) };
                let block = BlockColumn { values: &values, width, unit };
                let start: Vec<f64> = (0..height).map(|i| (5.0 + i as f64).sin()).collect();

                let mut expected = start.clone();
                for j in 0..width {
                    expected[j] /= l(j, j);
                    (j + 1..height).for_each(|i| expected[i] -= l(i, j) * expected[j]);
                }
                let mut found = start.clone();
                let (x, y) = found.split_at_mut(width + later);
                Arch::new().dispatch(Forward { block, x, y });
                close(&found, &expected);

                let mut expected = start.clone();
                for j in (0..width).rev() {
                    let sum: f64 = (j + 1..height).map(|i| l(i, j) * expected[i]).sum();
                    expected[j] = (expected[j] - sum) / l(j, j);
                }
                let mut found = start.clone();
                let (x, y) = found.split_at_mut(width + later);
                Arch::new().dispatch(Backward { block, x, y });
                close(&found, &expected);
            }
        }
    }

    fn close(found: &[f64], expected: &[f64]) {
        for (a, b) in found.iter().zip(expected) {
            assert!((a - b).abs() < 1e-12 * (1.0 + b.abs()), "{a} {b}");
        }
    }
}
