//! The factorisation on a zoo of matrices: solutions, inertia, refusals, the same bits on any number of threads.
#![allow(clippy::unwrap_used)]

mod common;

use common::{Matrix, Random, constrained, grid};
use proptest::prelude::*;
use tegula_sparse::{Factor, FactorError, Inertia, SparseLdlt};

#[test]
fn definite_matrices_are_solved_to_rounding() {
    let n = 400;
    let arrow: Vec<_> = (0..n).flat_map(|i| [(i, i, 4.0), (n - 1, i, 0.01)]).collect();
    let dense: Vec<_> =
        (0..60).flat_map(|i| (0..=i).map(move |j| (i, j, if i == j { 70.0 } else { 1.0 }))).collect();
    let apart: Vec<_> = (0..n).map(|i| (i, i, 1.0 + i as f64)).collect();
    let chain: Vec<_> = (0..n).flat_map(|i| [(i, i, 2.0), ((i + 1).min(n - 1), i, -1.0)]).collect();
    for (name, m) in [
        ("arrow", Matrix::new(n, &arrow)),
        ("dense", Matrix::new(60, &dense)),
        ("no couplings", Matrix::new(n, &apart)),
        ("chain", Matrix::new(n, &chain)),
        ("one unknown", Matrix::new(1, &[(0, 0, 3.0)])),
        ("grid", grid(30, 30, 6, 1e-3)),
        ("long grid", grid(200, 3, 6, 1e-3)),
        ("two unknowns a node", grid(40, 25, 2, 1e-6)),
    ] {
        let (inertia, residual) = m.solve().unwrap();
        assert_eq!((inertia.positive, inertia.negative), (m.pointers.len() - 1, 0), "{name}");
        assert!(residual < 1e-13, "{name}: {residual:e}");
    }
}

#[test]
fn badly_scaled_matrices_are_solved_row_by_row() {
    // Director and position unknowns of a thin shell differ by the square of the thickness.
    let mut m = grid(20, 20, 6, 1e-2);
    let n = m.pointers.len() - 1;
    let scale = |i: usize| if i % 6 < 3 { 1.0 } else { 1e-5 };
    for j in 0..n {
        for k in m.pointers[j]..m.pointers[j + 1] {
            m.values[k] *= scale(j) * scale(m.rows[k] as usize);
        }
    }
    let (inertia, residual) = m.solve().unwrap();
    assert!(inertia.negative == 0 && residual < 1e-13, "{inertia:?} {residual:e}");
}

#[test]
fn indefinite_matrices_tell_their_inertia() {
    // Pairs [[1, 2], [2, 1]] have one eigenvalue of each sign.
    let n = 50;
    let pairs: Vec<_> = (0..n)
        .flat_map(|i| [(2 * i, 2 * i, 1.0), (2 * i + 1, 2 * i + 1, 1.0), (2 * i + 1, 2 * i, 2.0)])
        .collect();
    let (inertia, residual) = Matrix::new(2 * n, &pairs).solve().unwrap();
    assert_eq!(inertia, Inertia { positive: n, negative: n, zero: 0 });
    assert!(residual < 1e-13, "{residual:e}");
    // A grid with one unknown pushed below zero.
    let mut m = grid(12, 12, 3, 1e-3);
    m.values[m.pointers[200]] -= 1e3;
    let (inertia, residual) = m.solve().unwrap();
    assert_eq!((inertia.negative, inertia.zero), (1, 0));
    assert!(residual < 1e-12, "{residual:e}");
}

/// Grids of springs whose softest motions have become unstable.
#[test]
fn few_negative_eigenvalues_are_counted_and_cost_no_digits() {
    // Negative eigenvalues of a grid with as many unknowns a node come in the number of unknowns for each eigenvalue
    // 2 − 2 cos(iπ/(n+1)) + 2 − 2 cos(jπ/(n+1)) below the shift.
    let n = 56;
    let node = |i: usize, j: usize| i * n + j;
    let eigenvalue = |k: usize| 2.0 - 2.0 * (k as f64 * std::f64::consts::PI / (n as f64 + 1.0)).cos();
    for shift in [0.5 * (2.0 * eigenvalue(1) + eigenvalue(1) + eigenvalue(2)), 0.02, 0.3] {
        let expected = (1..=n)
            .flat_map(|i| (1..=n).map(move |j| (i, j)))
            .filter(|&(i, j)| eigenvalue(i) + eigenvalue(j) < shift)
            .count();
        let per_node = 5;
        let mut entries = Vec::new();
        for i in 0..n {
            for j in 0..n {
                for a in 0..per_node {
                    let p = node(i, j) * per_node + a;
                    entries.push((p, p, 4.0 - shift));
                    for (k, l) in [(i + 1, j), (i, j + 1)] {
                        if k < n && l < n {
                            entries.push((node(k, l) * per_node + a, p, -1.0));
                        }
                        // The unknowns of neighbours share their pattern, so fronts are wide.
                        for b in (0..per_node).filter(|_| k < n && l < n) {
                            entries.push((node(k, l) * per_node + b, p, 0.0));
                        }
                    }
                }
            }
        }
        let m = Matrix::new(n * n * per_node, &entries);
        let run = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| {
                let (inertia, residual) = m.solve().unwrap();
                let mut factor = SparseLdlt::new(&m.pattern()).unwrap();
                factor.factor(&m.values).unwrap();
                let mut x: Vec<f64> = (0..m.pointers.len() - 1).map(|i| (i as f64).cos()).collect();
                factor.solve(&mut x);
                assert_eq!(factor.factorizations(), 1);
                (inertia, residual, x)
            })
        };
        let one = run(1);
        assert!(expected > 0);
        assert_eq!(one.0.negative, per_node * expected, "{shift}");
        assert_eq!(one.0.positive, (n * n - expected) * per_node, "{shift}");
        assert!(one.1 <= 1e-13, "{shift}: {:e}", one.1);
        for threads in [2, 3] {
            assert!(run(threads) == one, "{threads} threads");
        }
    }
}

/// Signs of the eigenvalues by a dense solver.
fn dense_inertia(m: &Matrix) -> (usize, usize) {
    let eigenvalues = m.eigenvalues();
    let negative = eigenvalues.iter().filter(|e| **e < 0.0).count();
    (eigenvalues.len() - negative, negative)
}

/// Two full saddle points `[[D, 0, 0], [0, 0, M], [0, Mᵀ, 0]]`, each one front that is wider than a block and has no
/// pivots in its first columns behind D alone, and unknowns between them.
#[test]
#[ignore = "long"]
fn wide_fronts_find_pivots_outside_of_their_blocks() {
    for (definite, small) in [(0_usize, 0.0), (0, 1e-9), (140, 0.0), (300, 1e-12)] {
        let (half, between) = (150_usize, 40_usize);
        let size = definite + 2 * half;
        let n = 2 * size + between;
        let mut entries = Vec::new();
        for body in 0..2 {
            let first = body * size;
            for i in 0..size {
                for j in 0..=i {
                    let wave = ((7 * i + 3 * j + body) as f64).sin();
                    let value = match (i.checked_sub(definite), j.checked_sub(definite)) {
                        _ if i < definite && i == j => 2.0 + wave,
                        (Some(i), Some(j)) if i >= half && j < half => {
                            if i - half == j {
                                3.0
                            } else {
                                0.1 * wave
                            }
                        }
                        (Some(i), Some(j)) if i == j => small * (1.0 + wave),
                        _ => 0.0,
                    };
                    entries.push((first + i, first + j, value));
                }
                for k in 0..between {
                    entries.push((2 * size + k, first + i, 0.02 * ((5 * i + 11 * k + body) as f64).cos()));
                }
            }
        }
        for i in 0..between {
            for j in 0..=i {
                entries.push((2 * size + i, 2 * size + j, if i == j { 4.0 } else { 0.0 }));
            }
        }
        let m = Matrix::new(n, &entries);
        let (inertia, residual) = m.solve().unwrap();
        assert_eq!((inertia.positive, inertia.negative), dense_inertia(&m), "{definite} {small}");
        assert!(residual < 1e-12, "{definite} {small}: {residual:e}");
    }
}

#[test]
fn what_cannot_be_factored_is_refused_and_leaves_no_solution() {
    let m = Matrix::new(3, &[(0, 0, 1.0), (1, 1, 0.0), (2, 2, 1.0)]);
    let mut factor = SparseLdlt::new(&m.pattern()).unwrap();
    assert_eq!(factor.factor(&m.values), Err(FactorError::Singular));
    let mut x = [1.0; 3];
    factor.solve(&mut x);
    assert!(x.iter().all(|x| x.is_nan()));
    assert_eq!(factor.factor(&[1.0, f64::NAN, 1.0]), Err(FactorError::NotFinite));
    // And it works again with values that can.
    assert_eq!(factor.factor(&[1.0, 4.0, 16.0]).unwrap().positive, 3);
    let solves = |factor: &mut SparseLdlt| {
        let mut x = [1.0, 4.0, 16.0];
        factor.solve(&mut x);
        x == [1.0; 3]
    };
    assert!(solves(&mut factor));
    // The same after its memory was given back.
    factor.release();
    assert!(!solves(&mut factor));
    factor.factor(&[1.0, 4.0, 16.0]).unwrap();
    assert!(solves(&mut factor));
}

#[test]
fn solutions_do_not_depend_on_where_threads_meet() {
    // Large enough that subtrees are split between threads.
    let m = grid(64, 64, 6, 1e-2);
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut factor = SparseLdlt::new(&m.pattern()).unwrap();
            let mut out = Vec::new();
            for _ in 0..3 {
                factor.factor(&m.values).unwrap();
                let mut x: Vec<f64> = (0..m.pointers.len() - 1).map(|i| (i as f64).cos()).collect();
                factor.solve(&mut x);
                out.push(x);
            }
            out
        })
    };
    let one = run(1);
    for threads in [1, 2, 3] {
        let out = run(threads);
        assert!(out[0] == out[1] && out[1] == out[2], "{threads} threads repeat themselves to the bit");
        assert!(out[0] == one[0], "{threads} threads give the same as one");
    }
}

/// The elimination tree of a long strip is as deep as the strip is long.
#[test]
fn long_strips_do_not_exhaust_the_stack() {
    let m = grid(4000, 3, 6, 1.0);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).stack_size(1 << 18).build().unwrap();
    let (inertia, residual) = pool.install(|| m.solve()).unwrap();
    assert_eq!(inertia.positive, m.pointers.len() - 1);
    assert!(residual < 1e-12, "{residual:e}");
}

/// Multipliers have zeros on the diagonal, and few neighbours: they are eliminated early if nothing is done about it.
#[test]
fn constraints_delay_their_pivots() {
    let mut random = Random::new(3);
    for (n, constraints, ground, small) in [
        (12, 60, 1e-2, 0.0),
        (12, 200, 1e-2, 0.0),
        (10, 40, 0.0, 0.0),
        (10, 90, 1e-6, 1e-13),
        (10, 90, 1e-2, -1e-9),
    ] {
        let mut m = constrained(n, constraints, ground, &mut random);
        let unknowns = 3 * n * n;
        for c in 0..constraints {
            m.values[m.pointers[unknowns + c]] = small;
        }
        let (inertia, residual) = m.solve().unwrap();
        let what = format!("{n} {constraints} {ground} {small}");
        assert_eq!((inertia.positive, inertia.negative), (unknowns, constraints), "{what}");
        assert_eq!((inertia.positive, inertia.negative), dense_inertia(&m), "{what}");
        assert!(residual < 1e-12, "{what}: {residual:e}");
    }
}

/// The structure that was found serves on, on any number of threads.
#[test]
#[ignore = "long"]
fn later_matrices_find_their_pivots_at_once() {
    let n = 45;
    let m = constrained(n, 280, 1e-2, &mut Random::new(5));
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut factor = SparseLdlt::new(&m.pattern()).unwrap();
            let inertia = factor.factor(&m.values).unwrap();
            assert_eq!((inertia.positive, inertia.negative), (3 * n * n, 280));
            let first = factor.factorizations();
            assert!((3..=12).contains(&first), "{first} factorisations");
            assert_eq!(factor.factor(&m.values).unwrap(), inertia);
            assert_eq!(factor.factorizations(), first + 1);
            let mut x: Vec<f64> = (0..m.pointers.len() - 1).map(|i| (i as f64).cos()).collect();
            factor.solve(&mut x);
            x
        })
    };
    let one = run(1);
    assert!([2, 3].map(run).iter().all(|x| *x == one));
}

/// Matrices without any entries on the diagonal: chains, and pairs of unknowns that hold each other.
#[test]
fn matrices_without_diagonal_are_factored() {
    for n in [2, 40, 398] {
        let chain: Vec<_> = (1..n).map(|i| (i, i - 1, 1.0 + 0.3 * (i as f64).sin())).collect();
        let (inertia, residual) = Matrix::new(n, &chain).solve().unwrap();
        assert_eq!((inertia.positive, inertia.negative), (n / 2, n / 2));
        assert!(residual < 1e-13, "{n}: {residual:e}");
        // An odd number has an eigenvalue of zero.
        assert_eq!(
            Matrix::new(n + 1, &[&chain[..], &[(n, n - 1, 2.0)]].concat()).solve().err(),
            Some(FactorError::Singular)
        );
    }
    // [[0, S], [S, 0]] with a grid S.
    let springs = grid(8, 8, 2, 1e-2);
    let half = springs.pointers.len() - 1;
    let mut entries = Vec::new();
    for j in 0..half {
        for k in springs.pointers[j]..springs.pointers[j + 1] {
            let (i, v) = (springs.rows[k] as usize, springs.values[k]);
            entries.push((half + i, j, v));
            if i != j {
                entries.push((half + j, i, v));
            }
        }
    }
    let m = Matrix::new(2 * half, &entries);
    let (inertia, residual) = m.solve().unwrap();
    assert_eq!((inertia.positive, inertia.negative), (half, half));
    assert!(residual < 1e-12, "{residual:e}");
}

#[test]
fn redundant_constraints_are_singular() {
    let mut m = constrained(8, 20, 1e-2, &mut Random::new(9));
    assert_eq!(m.solve().unwrap().0.negative, 20);
    // One that binds nothing.
    let last = m.pointers.len() - 2;
    for j in 0..last {
        for k in m.pointers[j]..m.pointers[j + 1] {
            if m.rows[k] as usize == last {
                m.values[k] = 0.0;
            }
        }
    }
    assert_eq!(m.solve().err(), Some(FactorError::Singular));
}

/// The contribution block of a front that was not eliminated is void: here it would empty the columns of the next front.
#[test]
fn fronts_above_delayed_columns_decide_nothing() {
    let (held, others) = (100, 200);
    let mut entries = Vec::new();
    for k in 0..held {
        entries.push((k, k, 1.0));
        // Couplings without value make the multipliers fronts of their own.
        entries.extend((0..held).map(|c| (held + others + c, k, if c == k { 1.0 } else { 0.0 })));
        entries.extend((0..k).map(|l| (k, l, 0.0)));
        entries.extend((0..others).map(|e| (held + e, k, 0.0)));
    }
    for e in 0..others {
        entries.extend((0..=e).map(|f| (held + e, held + f, if e == f { 2.0 } else { 0.0 })));
    }
    let (inertia, residual) = Matrix::new(2 * held + others, &entries).solve().unwrap();
    assert_eq!((inertia.positive, inertia.negative), (held + others, held));
    assert!(residual < 1e-14, "{residual:e}");
}

/// An unknown that nothing holds is not carried up the whole tree.
#[test]
fn empty_rows_are_refused_at_once() {
    let mut m = grid(60, 60, 3, 1e-2);
    let empty = 5000;
    for j in 0..=empty {
        for k in m.pointers[j]..m.pointers[j + 1] {
            if j == empty || m.rows[k] as usize == empty {
                m.values[k] = 0.0;
            }
        }
    }
    let mut factor = SparseLdlt::new(&m.pattern()).unwrap();
    assert_eq!(factor.factor(&m.values), Err(FactorError::Singular));
    assert!(factor.factorizations() <= 2, "{}", factor.factorizations());
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 60, ..ProptestConfig::default() })]

    /// Any graph: diagonally dominant matrices have positive pivots and small residuals.
    #[test]
    fn any_graph_is_factored(
        n in 1_usize..80,
        edges in prop::collection::vec((0_usize..80, 0_usize..80, -1.0_f64..1.0), 0..300),
    ) {
        let mut entries: Vec<(usize, usize, f64)> = (0..n).map(|i| (i, i, 1e-3)).collect();
        for (a, b, v) in edges {
            let (i, j) = (a % n, b % n);
            if i != j {
                entries.extend([(i, j, v), (i, i, v.abs()), (j, j, v.abs())]);
            }
        }
        let (inertia, residual) = Matrix::new(n, &entries).solve().unwrap();
        prop_assert_eq!(inertia.positive, n);
        prop_assert!(residual < 1e-12, "{:e}", residual);
    }

    /// Any saddle point: as many negative pivots as independent constraints.
    #[test]
    fn saddle_points_have_a_negative_pivot_for_each_constraint(seed in 0_u64..1000, constraints in 1_usize..60) {
        let m = constrained(6, constraints, 1e-1, &mut Random::new(seed));
        let eigenvalues = m.eigenvalues();
        // Constraints at random may depend on each other.
        prop_assume!(eigenvalues.iter().all(|e| e.abs() > 1e-6));
        let (inertia, residual) = m.solve().unwrap();
        prop_assert_eq!((inertia.positive, inertia.negative), (108, constraints));
        prop_assert!(residual < 1e-10, "{:e}", residual);
    }

    /// Any indefinite matrix: the signs of the pivots are those of the eigenvalues.
    #[test]
    fn signs_of_pivots_are_those_of_eigenvalues(
        diagonal in prop::collection::vec(-2.0_f64..2.0, 1..60),
        edges in prop::collection::vec((0_usize..60, 0_usize..60, -1.0_f64..1.0), 0..200),
    ) {
        let n = diagonal.len();
        let mut entries: Vec<(usize, usize, f64)> = diagonal.into_iter().enumerate().map(|(i, d)| (i, i, d)).collect();
        entries.extend(edges.into_iter().map(|(a, b, v)| (a % n, b % n, v)));
        let m = Matrix::new(n, &entries);
        let eigenvalues = m.eigenvalues();
        // Near a singular matrix signs are up to rounding.
        prop_assume!(eigenvalues.iter().all(|e| e.abs() > 1e-3));
        let (inertia, residual) = m.solve().unwrap();
        prop_assert_eq!(inertia.negative, eigenvalues.iter().filter(|e| **e < 0.0).count());
        prop_assert_eq!(inertia.positive + inertia.negative, n);
        prop_assert!(residual < 1e-9, "{:e}", residual);
    }
}
