//! Analysis, factorisation and solution of a matrix like the tangent of a shell, beside the supernodal LLᵀ and LDLᵀ of
//! faer: a square grid of nodes with six unknowns each, all unknowns of neighbouring nodes coupled, also across
//! diagonals. The number of threads is that of rayon's global pool, `RAYON_NUM_THREADS`.
#![allow(missing_docs, clippy::unwrap_used)]

use std::hint::black_box;

use criterion::measurement::WallTime;
use criterion::{BatchSize, BenchmarkGroup, Criterion, criterion_group, criterion_main};
use dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::ldlt::factor::LdltRegularization;
use faer::linalg::cholesky::llt::factor::LltRegularization;
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, LdltRef, LltRef, SymbolicCholesky, SymmetricOrdering, factorize_symbolic_cholesky,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMat, SymbolicSparseColMatRef};
use faer::{Conj, MatMut, Par, Side};
use tegula_sparse::{Factor, SparseLdlt, SymmetricPattern};

/// Number of right sides of a solution with many.
const MANY: usize = 16;

/// Unknowns of a node.
const PER_NODE: usize = 6;

/// Lower triangle of a positive definite matrix in compressed columns.
struct Matrix {
    pointers: Vec<usize>,
    rows: Vec<u32>,
    values: Vec<f64>,
}

impl Matrix {
    /// Grid of `n` × `n` nodes. The diagonal dominates.
    fn shell(n: usize) -> Self {
        let mut out = Self { pointers: vec![0], rows: Vec::new(), values: Vec::new() };
        for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
            let later = [(i, j), (i, j + 1), (i + 1, j.wrapping_sub(1)), (i + 1, j), (i + 1, j + 1)];
            let nodes: Vec<usize> =
                later.into_iter().filter(|&(k, l)| k < n && l < n).map(|(k, l)| k * n + l).collect();
            for a in 0..PER_NODE {
                let column = PER_NODE * (i * n + j) + a;
                let rows = nodes.iter().flat_map(|node| PER_NODE * node..PER_NODE * (node + 1));
                for row in rows.filter(|&row| row >= column) {
                    let wave = ((7 * row + 3 * column) as f64).sin();
                    out.rows.push(row as u32);
                    out.values.push(if row == column { 60.0 + wave } else { wave });
                }
                out.pointers.push(out.rows.len());
            }
        }
        out
    }

    fn size(&self) -> usize {
        self.pointers.len() - 1
    }

    fn right_sides(&self, count: usize) -> Vec<f64> {
        (0..self.size() * count).map(|i| (i as f64).cos()).collect()
    }
}

fn own(group: &mut BenchmarkGroup<'_, WallTime>, matrix: &Matrix) {
    let pattern = SymmetricPattern::new(matrix.pointers.clone(), matrix.rows.clone());
    group.bench_function("analyse/tegula", |b| b.iter(|| SparseLdlt::new(black_box(&pattern)).unwrap()));
    let mut ldlt = SparseLdlt::new(&pattern).unwrap();
    group.bench_function("factor/tegula", |b| b.iter(|| ldlt.factor(black_box(&matrix.values)).unwrap()));
    ldlt.factor(&matrix.values).unwrap();
    let right_sides = matrix.right_sides(MANY);
    let one = &right_sides[..matrix.size()];
    group.bench_function("solve/tegula", |b| {
        b.iter_batched_ref(|| one.to_vec(), |x| ldlt.solve(x), BatchSize::LargeInput);
    });
    group.bench_function("solve_many_16/tegula", |b| {
        b.iter_batched_ref(|| right_sides.clone(), |x| ldlt.solve_many(x, MANY), BatchSize::LargeInput);
    });
}

/// Symbolic factorisation by faer, which takes approximate minimum degree as `SparseLdlt` does.
fn analyse(pattern: SymbolicSparseColMatRef<'_, usize>) -> SymbolicCholesky<usize> {
    let parameters = CholeskySymbolicParams {
        supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SUPERNODAL,
        ..CholeskySymbolicParams::default()
    };
    factorize_symbolic_cholesky(pattern, Side::Lower, SymmetricOrdering::Amd, parameters).unwrap()
}

fn of_faer(group: &mut BenchmarkGroup<'_, WallTime>, matrix: &Matrix) {
    let n = matrix.size();
    let par = if rayon::current_num_threads() > 1 { Par::rayon(0) } else { Par::Seq };
    let rows: Vec<usize> = matrix.rows.iter().map(|&i| i as usize).collect();
    let pattern = SymbolicSparseColMat::new_checked(n, n, matrix.pointers.clone(), None, rows);
    let a = SparseColMatRef::new(pattern.as_ref(), &matrix.values);
    group.bench_function("analyse/faer", |b| b.iter(|| analyse(black_box(pattern.as_ref()))));
    let symbolic = analyse(pattern.as_ref());
    let mut l = vec![0.0; symbolic.len_val()];
    let mut memory = MemBuffer::new(symbolic.factorize_numeric_llt_scratch::<f64>(par, Default::default()));
    let mut llt = || {
        let (stack, rule) = (MemStack::new(&mut memory), LltRegularization::default());
        let done =
            symbolic.factorize_numeric_llt(&mut l, a, Side::Lower, rule, par, stack, Default::default());
        black_box(done.unwrap());
    };
    group.bench_function("factor/faer-llt", |b| b.iter(&mut llt));
    llt();
    let llt = LltRef::<usize, f64>::new(&symbolic, &l);
    for (name, count) in [("solve/faer-llt", 1), ("solve_many_16/faer-llt", MANY)] {
        let right_sides = matrix.right_sides(count);
        let mut memory = MemBuffer::new(symbolic.solve_in_place_scratch::<f64>(count, par));
        group.bench_function(name, |b| {
            let solve = |x: &mut Vec<f64>| {
                let x = MatMut::from_column_major_slice_mut(x, n, count);
                llt.solve_in_place_with_conj(Conj::No, x, par, MemStack::new(&mut memory));
            };
            b.iter_batched_ref(|| right_sides.clone(), solve, BatchSize::LargeInput);
        });
    }
    let mut l = vec![0.0; symbolic.len_val()];
    let mut memory = MemBuffer::new(symbolic.factorize_numeric_ldlt_scratch::<f64>(par, Default::default()));
    let mut ldlt = || {
        let (stack, rule) = (MemStack::new(&mut memory), LdltRegularization::default());
        let done =
            symbolic.factorize_numeric_ldlt(&mut l, a, Side::Lower, rule, par, stack, Default::default());
        black_box(done.unwrap());
    };
    group.bench_function("factor/faer-ldlt", |b| b.iter(&mut ldlt));
    ldlt();
    let ldlt = LdltRef::<usize, f64>::new(&symbolic, &l);
    let right_side = matrix.right_sides(1);
    let mut memory = MemBuffer::new(symbolic.solve_in_place_scratch::<f64>(1, par));
    group.bench_function("solve/faer-ldlt", |b| {
        let solve = |x: &mut Vec<f64>| {
            let x = MatMut::from_column_major_slice_mut(x, n, 1);
            ldlt.solve_in_place_with_conj(Conj::No, x, par, MemStack::new(&mut memory));
        };
        b.iter_batched_ref(|| right_side.clone(), solve, BatchSize::LargeInput);
    });
}

fn shells(c: &mut Criterion) {
    for n in [40, 100] {
        let matrix = Matrix::shell(n);
        let mut group = c.benchmark_group(format!("shell-{n}x{n}"));
        group.sample_size(10);
        own(&mut group, &matrix);
        of_faer(&mut group, &matrix);
        group.finish();
    }
}

criterion_group!(benches, shells);
criterion_main!(benches);
