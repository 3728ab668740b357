//! Solutions with many right sides: equal to single ones to rounding, and bitwise independent of threads and neighbours.
#![allow(clippy::unwrap_used)]

mod common;

use common::{Matrix, Random, constrained, grid};
use proptest::prelude::*;
use tegula_sparse::norm::max_norm;
use tegula_sparse::{Factor, SparseLdlt};

/// Right sides at random, column by column.
fn random_columns(n: usize, count: usize, seed: u64) -> Vec<f64> {
    let mut random = Random::new(seed);
    (0..n * count).map(|_| random.next()).collect()
}

/// Largest difference between the solutions together and the single ones, relative to the largest entry.
fn difference(m: &Matrix, factor: &mut SparseLdlt, count: usize) -> f64 {
    let n = m.size();
    let right_sides = random_columns(n, count, 7);
    let mut together = right_sides.clone();
    factor.solve_many(&mut together, count);
    let mut single = right_sides;
    single.chunks_exact_mut(n).for_each(|x| factor.solve(x));
    let size = max_norm(single.iter().copied());
    max_norm(together.iter().zip(&single).map(|(a, b)| a - b)) / size
}

#[test]
fn solutions_together_are_the_single_ones_to_rounding() {
    for (name, m, negative) in [
        ("definite", grid(30, 30, 6, 1e-2), 0),
        // A few 2×2 and negative pivots within the blocks.
        ("one unstable", unstable(grid(12, 12, 3, 1e-3)), 1),
        // Multipliers, whose columns are delayed.
        ("constrained", constrained(12, 60, 1e-2, &mut Random::new(3)), 60),
        ("one unknown", Matrix::new(1, &[(0, 0, 3.0)]), 0),
    ] {
        let mut factor = SparseLdlt::new(&m.pattern()).unwrap();
        assert_eq!(factor.factor(&m.values).unwrap().negative, negative, "{name}");
        for count in [1, 2, 7, 8, 9, 15, 16, 17, 24, 25, 40] {
            let error = difference(&m, &mut factor, count);
            assert!(error < 1e-9, "{name} {count}: {error:e}");
        }
    }
}

/// The matrix with one unknown pushed below zero.
fn unstable(mut m: Matrix) -> Matrix {
    m.values[m.pointers[200]] -= 1e3;
    m
}

#[test]
fn no_columns_are_solved_at_once() {
    let m = grid(4, 4, 2, 1.0);
    let mut factor = SparseLdlt::new(&m.pattern()).unwrap();
    factor.factor(&m.values).unwrap();
    factor.solve_many(&mut [], 0);
}

#[test]
fn without_a_factor_all_solutions_are_nan() {
    let m = grid(4, 4, 2, 1.0);
    let mut factor = SparseLdlt::new(&m.pattern()).unwrap();
    let mut x = vec![1.0; 3 * m.size()];
    factor.solve_many(&mut x, 3);
    assert!(x.iter().all(|x| x.is_nan()));
}

#[test]
#[should_panic(expected = "another size")]
fn columns_of_another_length_are_refused() {
    let m = grid(4, 4, 2, 1.0);
    let mut factor = SparseLdlt::new(&m.pattern()).unwrap();
    factor.factor(&m.values).unwrap();
    factor.solve_many(&mut [0.0; 33], 2);
}

/// Infinite entries of one right side leave those beside it alone.
#[test]
fn solutions_depend_on_nothing_beside_them() {
    let m = constrained(12, 60, 1e-2, &mut Random::new(3));
    let n = m.size();
    let mut factor = SparseLdlt::new(&m.pattern()).unwrap();
    factor.factor(&m.values).unwrap();
    let right_sides = random_columns(n, 20, 5);
    let mut all = right_sides.clone();
    factor.solve_many(&mut all, 20);
    for (first, count) in [(0, 1), (3, 8), (2, 16), (1, 17), (19, 1)] {
        let part = first * n..(first + count) * n;
        let mut x = right_sides[part.clone()].to_vec();
        factor.solve_many(&mut x, count);
        assert!(x == all[part], "{first} {count}");
    }
    let mut spoilt = right_sides;
    spoilt[4 * n..5 * n].fill(f64::INFINITY);
    factor.solve_many(&mut spoilt, 20);
    assert!(spoilt[..4 * n] == all[..4 * n] && spoilt[5 * n..] == all[5 * n..]);
    assert!(spoilt[4 * n..5 * n].iter().all(|x| !x.is_finite()));
}

/// Large enough that subtrees are split between threads; definite, indefinite, and with delayed columns.
#[test]
#[ignore = "long"]
fn solutions_do_not_depend_on_the_number_of_threads() {
    for m in [
        grid(64, 64, 6, 1e-2),
        unstable(grid(45, 45, 6, 1e-2)),
        constrained(45, 280, 1e-2, &mut Random::new(5)),
    ] {
        let run = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| {
                let mut factor = SparseLdlt::new(&m.pattern()).unwrap();
                factor.factor(&m.values).unwrap();
                let mut x = random_columns(m.size(), 19, 11);
                factor.solve_many(&mut x, 19);
                x
            })
        };
        let one = run(1);
        assert!([2, 3].map(run).iter().all(|x| *x == one));
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 40, ..ProptestConfig::default() })]

    /// Any saddle point and any number of right sides.
    #[test]
    fn any_number_of_right_sides_is_solved(
        seed in 0_u64..1000, constraints in 0_usize..60, count in 1_usize..40,
    ) {
        let m = constrained(6, constraints, 1e-1, &mut Random::new(seed));
        prop_assume!(m.eigenvalues().iter().all(|e| e.abs() > 1e-6));
        let mut factor = SparseLdlt::new(&m.pattern()).unwrap();
        factor.factor(&m.values).unwrap();
        let error = difference(&m, &mut factor, count);
        prop_assert!(error < 1e-8, "{:e}", error);
    }
}
