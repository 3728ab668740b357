//! Schur complements against dense elimination: any interface, definite and indefinite interiors, refusals, equal bits
//! for any number of threads.
#![allow(clippy::unwrap_used)]

mod common;

use common::{Matrix, Random, constrained, grid};
use nalgebra::{DMatrix, DVector};
use proptest::prelude::*;
use tegula_sparse::norm::max_norm;
use tegula_sparse::{FactorError, Inertia, SchurComplement, SymmetricPattern, Workspace};

/// Interior: all unknowns but those of the interface.
fn interior(n: usize, interface: &[u32]) -> Vec<usize> {
    (0..n).filter(|i| !interface.contains(&(*i as u32))).collect()
}

fn block(a: &DMatrix<f64>, rows: &[usize], columns: &[usize]) -> DMatrix<f64> {
    DMatrix::from_fn(rows.len(), columns.len(), |i, j| a[(rows[i], columns[j])])
}

/// Maximum norm of values that may be none; NaN if one is NaN.
fn largest<'a>(values: impl IntoIterator<Item = &'a f64>) -> f64 {
    max_norm(std::iter::once(&0.0).chain(values))
}

/// Eigenvalues of the interior.
fn interior_eigenvalues(m: &Matrix, interface: &[u32]) -> Vec<f64> {
    let inner = interior(m.size(), interface);
    if inner.is_empty() {
        return Vec::new();
    }
    block(&m.dense(), &inner, &inner).symmetric_eigenvalues().iter().copied().collect()
}

/// Largest deviations of the Schur complement, relative to the largest entry of its two terms, and of a solution by
/// condensation and expansion, relative to the largest entry of that.
fn deviations(m: &Matrix, schur: &mut SchurComplement, interface: &[u32]) -> (f64, f64) {
    let (n, size) = (m.size(), interface.len());
    let a = m.dense();
    let gamma: Vec<usize> = interface.iter().map(|&i| i as usize).collect();
    let inner = interior(n, interface);
    let a_ig = block(&a, &inner, &gamma);
    let solved =
        if inner.is_empty() { a_ig.clone() } else { block(&a, &inner, &inner).lu().solve(&a_ig).unwrap() };
    let update = a_ig.transpose() * solved;
    let own = block(&a, &gamma, &gamma);
    let scale = largest(a.iter().chain(update.iter()).chain(&[1e-300]));
    let found = DMatrix::from_column_slice(size, size, schur.matrix());
    let of_matrix = largest((&own - &update - &found).iter()) / scale;

    // A right side and the values that its solution has at the interface.
    let exact = DVector::from_fn(n, |i, _| (1.0 + i as f64).sin());
    let b = &a * &exact;
    let mut x: Vec<f64> = b.iter().copied().collect();
    schur.condense(&mut x);
    let g = DVector::from_fn(size, |i, _| x[gamma[i]]);
    let u = DVector::from_fn(size, |i, _| exact[gamma[i]]);
    let of_condensed = largest((&found * &u - g).iter()) / scale;
    gamma.iter().for_each(|&i| x[i] = exact[i]);
    schur.expand(&mut x);
    let of_solution = max_norm(x.iter().zip(exact.iter()).map(|(a, b)| a - b));
    (of_matrix, max_norm([of_condensed, of_solution]))
}

/// Signs of the eigenvalues of the interior.
fn interior_inertia(m: &Matrix, interface: &[u32]) -> (usize, usize) {
    let eigenvalues = interior_eigenvalues(m, interface);
    let negative = eigenvalues.iter().filter(|e| **e < 0.0).count();
    (eigenvalues.len() - negative, negative)
}

/// Unknowns of the nodes on the boundary of a grid.
fn boundary(nx: usize, ny: usize, per_node: usize) -> Vec<u32> {
    let on = |i: usize, j: usize| i == 0 || j == 0 || i + 1 == nx || j + 1 == ny;
    let nodes = (0..nx).flat_map(|i| (0..ny).map(move |j| (i, j))).filter(|&(i, j)| on(i, j));
    nodes.flat_map(|(i, j)| (0..per_node).map(move |a| ((i * ny + j) * per_node + a) as u32)).collect()
}

fn checked(name: &str, m: &Matrix, interface: &[u32]) {
    for sequential in [false, true] {
        let pattern = m.pattern();
        let mut schur = if sequential {
            SchurComplement::sequential(&pattern, interface).unwrap()
        } else {
            SchurComplement::new(&pattern, interface).unwrap()
        };
        assert_eq!(schur.size(), interface.len());
        for _ in 0..2 {
            let inertia = schur.factor(&m.values).unwrap();
            assert_eq!((inertia.positive, inertia.negative), interior_inertia(m, interface), "{name}");
            let (of_matrix, of_solution) = deviations(m, &mut schur, interface);
            assert!(of_matrix < 1e-11, "{name}: {of_matrix:e}");
            assert!(of_solution < 1e-8, "{name}: {of_solution:e}");
        }
    }
}

#[test]
#[ignore = "long"]
fn schur_complements_are_those_of_dense_elimination() {
    let shell = grid(9, 8, 6, 1e-2);
    let n = shell.size() as u32;
    let chain: Vec<_> = (0..40).flat_map(|i| [(i, i, 2.5), ((i + 1).min(39), i, -1.0)]).collect();
    let apart: Vec<_> = (0..30).map(|i| (i, i, 1.0 + i as f64)).collect();
    for (name, m, interface) in [
        ("boundary", &shell, boundary(9, 8, 6)),
        ("descending", &shell, boundary(9, 8, 6).into_iter().rev().collect()),
        ("empty", &shell, vec![]),
        ("all", &shell, (0..n).collect()),
        ("all but one", &shell, (1..n).collect()),
        ("one", &shell, vec![200]),
        ("parts of nodes", &shell, (0..n).filter(|i| i % 7 == 3).collect()),
        ("nodes far apart", &shell, (0..6).chain(200..204).chain(n - 3..n).collect()),
        ("ends of a chain", &Matrix::new(40, &chain), vec![0, 39]),
        ("every other", &Matrix::new(40, &chain), (0..20).map(|i| 2 * i).collect()),
        ("no couplings", &Matrix::new(30, &apart), vec![29, 3, 11]),
        // An interface of several block columns.
        ("wide", &grid(6, 40, 6, 1e-1), boundary(6, 40, 6)),
    ] {
        checked(name, m, &interface);
    }
}

#[test]
#[ignore = "long"]
fn indefinite_interiors_are_eliminated_with_pivoting() {
    let mut unstable = grid(12, 12, 3, 1e-3);
    unstable.values[unstable.pointers[200]] -= 1e3;
    checked("unstable", &unstable, &boundary(12, 12, 3));
    checked("unstable at the interface", &unstable, &[200, 17]);
    // Constraints with zeros on the diagonal: columns are delayed, but never to the interface.
    for constraints in [20, 60, 150] {
        let m = constrained(10, constraints, 1e-2, &mut Random::new(3));
        for every in [2, 5, 30] {
            let interface: Vec<u32> = (0..300).filter(|i| i % every == 0).collect();
            if interior_is_regular(&m, &interface) {
                checked("constrained", &m, &interface);
            }
        }
        // Constraints on the interface.
        let multipliers: Vec<u32> = (300..300 + constraints as u32).collect();
        checked("multipliers", &m, &multipliers);
    }
}

fn interior_is_regular(m: &Matrix, interface: &[u32]) -> bool {
    interior_eigenvalues(m, interface).iter().all(|e| e.abs() > 1e-4)
}

/// A pivot of the interior that is small only beside its couplings to the interface is accepted: nothing else can
/// eliminate it.
#[test]
fn small_pivots_next_to_the_interface_are_accepted() {
    for small in [1e-5, -1e-5, 1e-9] {
        let entries =
            [(0, 0, small), (1, 0, 1.0), (1, 1, 2.0), (2, 0, -1.0), (2, 2, 3.0), (3, 3, 1.0), (3, 1, 0.5)];
        let m = Matrix::new(4, &entries);
        let mut schur = SchurComplement::new(&m.pattern(), &[1, 2]).unwrap();
        let inertia = schur.factor(&m.values).unwrap();
        assert_eq!(inertia.negative, usize::from(small < 0.0));
        let (of_matrix, of_solution) = deviations(&m, &mut schur, &[1, 2]);
        assert!(of_matrix < 1e-14 && of_solution < 1e-6, "{small}: {of_matrix:e} {of_solution:e}");
    }
}

#[test]
fn singular_interiors_are_refused() {
    let all_nan = |schur: &mut SchurComplement, n: usize| {
        let (mut f, mut u) = (vec![1.0; n], vec![1.0; n]);
        schur.condense(&mut f);
        schur.expand(&mut u);
        schur.matrix().iter().chain(&f).chain(&u).all(|x| x.is_nan())
    };
    // Unknown 1 hangs on the interface alone; A is regular.
    let m = Matrix::new(4, &[(0, 0, 1.0), (1, 0, 1.0), (1, 1, 0.0), (2, 2, 1.0), (3, 2, 0.5), (3, 3, 1.0)]);
    let mut schur = SchurComplement::new(&m.pattern(), &[0]).unwrap();
    assert!(all_nan(&mut schur, 4), "there is no factor yet");
    assert_eq!(schur.factor(&m.values), Err(FactorError::Singular));
    assert!(all_nan(&mut schur, 4));
    // It is factored with other values, or with another interface.
    let mut held = m.values.clone();
    held[m.pointers[1]] = 2.0;
    assert_eq!(schur.factor(&held).unwrap(), Inertia { positive: 3, negative: 0, zero: 0 });
    assert!((schur.matrix()[0] - 0.5).abs() < 1e-15);
    assert!(SchurComplement::new(&m.pattern(), &[0, 1]).unwrap().factor(&m.values).is_ok());
    // A constraint among unknowns of the interface: a multiplier without any entry in the interior.
    let m = constrained(6, 30, 1e-2, &mut Random::new(1));
    let last = m.size() - 1;
    let bound: Vec<u32> = (0..last).filter(|&j| m.dense()[(last, j)] != 0.0).map(|j| j as u32).collect();
    let mut schur = SchurComplement::new(&m.pattern(), &bound).unwrap();
    assert_eq!(schur.factor(&m.values), Err(FactorError::Singular));
    // Two equal rows of the interior, singular only to rounding.
    let entries = [(0, 0, 0.1), (1, 0, 0.1), (1, 1, 0.1 + 1e-17), (2, 0, 1.0), (2, 1, 0.7), (2, 2, 1.0)];
    let m = Matrix::new(3, &entries);
    let mut schur = SchurComplement::new(&m.pattern(), &[2]).unwrap();
    assert_eq!(schur.factor(&m.values), Err(FactorError::Singular));
}

#[test]
fn values_that_are_not_numbers_are_refused() {
    let m = grid(6, 6, 3, 1e-2);
    let mut schur = SchurComplement::new(&m.pattern(), &boundary(6, 6, 3)).unwrap();
    schur.factor(&m.values).unwrap();
    for bad in [f64::NAN, f64::INFINITY] {
        // In the interior, at the interface.
        for column in [50, 0] {
            let mut values = m.values.clone();
            values[m.pointers[column]] = bad;
            assert_eq!(schur.factor(&values), Err(FactorError::NotFinite));
            assert!(schur.matrix().iter().all(|x| x.is_nan()));
        }
    }
    schur.factor(&m.values).unwrap();
    assert!(schur.matrix().iter().all(|x| x.is_finite()));
}

#[test]
#[should_panic(expected = "given twice")]
fn unknowns_given_twice_are_refused() {
    let _ = SchurComplement::new(&grid(3, 3, 1, 1.0).pattern(), &[4, 2, 4]);
}

#[test]
#[should_panic(expected = "no unknown")]
fn unknowns_beyond_the_pattern_are_refused() {
    let _ = SchurComplement::new(&grid(3, 3, 1, 1.0).pattern(), &[9]);
}

/// Schur complement and a vector that is condensed and expanded.
fn results(m: &Matrix, interface: &[u32], sequential: bool) -> (Vec<f64>, Vec<f64>) {
    let pattern: SymmetricPattern = m.pattern();
    let mut schur = if sequential {
        SchurComplement::sequential(&pattern, interface).unwrap()
    } else {
        SchurComplement::new(&pattern, interface).unwrap()
    };
    schur.factor(&m.values).unwrap();
    let mut x: Vec<f64> = (0..m.size()).map(|i| (i as f64).cos()).collect();
    schur.condense(&mut x);
    schur.expand(&mut x);
    (schur.matrix().to_vec(), x)
}

/// Large enough for node-level fronts; the Schur complement is symmetric to the bit.
#[test]
#[ignore = "long"]
fn results_do_not_depend_on_the_number_of_threads() {
    let cut: Vec<u32> = (30 * 60 * 6..31 * 60 * 6).collect();
    let multipliers: Vec<u32> = (10800..11300).collect();
    for (m, interface) in [
        (grid(60, 60, 6, 1e-2), boundary(60, 60, 6)),
        (grid(60, 60, 6, 1e-2), cut),
        (constrained(60, 500, 1e-2, &mut Random::new(5)), (0..90).chain(5000..5040).collect()),
        (constrained(60, 500, 1e-2, &mut Random::new(5)), multipliers),
    ] {
        let run = |threads: usize, sequential: bool| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| results(&m, &interface, sequential))
        };
        let one = run(1, false);
        let size = interface.len();
        assert!((0..size).all(|j| (0..j).all(|i| one.0[j * size + i] == one.0[i * size + j])));
        for (threads, sequential) in [(1, true), (2, false), (3, false), (2, true)] {
            assert!(run(threads, sequential) == one, "{threads} {sequential}");
        }
    }
}

/// Subdomains are factored in parallel tasks, as domain decomposition does.
#[test]
fn many_are_factored_in_parallel_tasks() {
    fn moves_between_threads<T: Send>() {}
    moves_between_threads::<SchurComplement>();
    let subdomains: Vec<(Matrix, Vec<u32>)> =
        (0..24).map(|k| (grid(6 + k % 5, 9, 6, 1e-2), boundary(6 + k % 5, 9, 6))).collect();
    let alone: Vec<_> = subdomains.iter().map(|(m, interface)| results(m, interface, true)).collect();
    let mut together = vec![(Vec::new(), Vec::new()); subdomains.len()];
    let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
    pool.scope(|scope| {
        for ((m, interface), out) in subdomains.iter().zip(&mut together) {
            scope.spawn(move |_| *out = results(m, interface, true));
        }
    });
    assert!(together == alone);
}

/// One workspace serves matrices and interfaces of all sizes and holds nothing of them. Indefinite interiors, which are
/// factored in between, are recognised and leave no trace.
#[test]
fn a_shared_workspace_gives_equal_bits() {
    let cases = [
        (grid(6, 9, 6, 1e-2), boundary(6, 9, 6)),
        (grid(9, 30, 6, 1e-2), boundary(9, 30, 6).into_iter().rev().collect()),
        (grid(5, 5, 6, 1e-2), vec![]),
        (grid(4, 4, 6, 1e-2), (0..96).collect()),
        (grid(8, 8, 6, 1e-2), boundary(8, 8, 6)),
    ];
    let mut workspace = Workspace::default();
    for (m, interface) in &cases {
        let mut schur = SchurComplement::sequential(&m.pattern(), interface).unwrap();
        let (n, size) = (m.size(), interface.len());
        let (expected, solution) = results(m, interface, true);
        for scale in [1.0, -1.0, 1.0] {
            let values: Vec<f64> = m.values.iter().map(|v| scale * v).collect();
            let mut matrix = vec![0.5; size * size];
            let inertia = schur.factor_definite(&values, &mut matrix, &mut workspace).unwrap();
            assert_eq!(inertia.negative, if scale < 0.0 { n - size } else { 0 });
            assert!(schur.matrix().is_empty());
            if scale < 0.0 {
                continue;
            }
            for j in 0..size {
                assert_eq!(matrix[j * size + j..(j + 1) * size], expected[j * size + j..(j + 1) * size]);
                assert!(matrix[j * size..j * size + j].iter().all(|x| *x == 0.5));
            }
            let mut x: Vec<f64> = (0..n).map(|i| (i as f64).cos()).collect();
            schur.condense_with(&mut x, &mut workspace);
            schur.expand_with(&mut x, &mut workspace);
            assert_eq!(x, solution);
        }
        schur.release();
        let (mut x, mut matrix) = (vec![0.0; n], vec![0.0; size * size]);
        if size < n {
            schur.condense_with(&mut x, &mut workspace);
            assert!(x.iter().all(|x| x.is_nan()));
        }
        let refused = schur.factor_definite(&vec![f64::NAN; m.values.len()], &mut matrix, &mut workspace);
        assert_eq!(refused, Err(FactorError::NotFinite));
        assert!((0..size).all(|j| matrix[j * (size + 1)].is_nan()));
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 80, ..ProptestConfig::default() })]

    /// Any diagonally dominant matrix and any interface.
    #[test]
    fn any_definite_matrix_is_condensed(
        n in 1_usize..80,
        edges in prop::collection::vec((0_usize..80, 0_usize..80, -1.0_f64..1.0), 0..300),
        chosen in prop::collection::vec(any::<bool>(), 80),
    ) {
        let mut entries: Vec<(usize, usize, f64)> = (0..n).map(|i| (i, i, 0.1)).collect();
        for (a, b, v) in edges {
            let (i, j) = (a % n, b % n);
            if i != j {
                entries.extend([(i, j, v), (i, i, v.abs()), (j, j, v.abs())]);
            }
        }
        let m = Matrix::new(n, &entries);
        let interface: Vec<u32> = (0..n).filter(|&i| chosen[i]).map(|i| i as u32).collect();
        let mut schur = SchurComplement::new(&m.pattern(), &interface).unwrap();
        let inertia = schur.factor(&m.values).unwrap();
        prop_assert_eq!(inertia, Inertia { positive: n - interface.len(), negative: 0, zero: 0 });
        let (of_matrix, of_solution) = deviations(&m, &mut schur, &interface);
        prop_assert!(of_matrix < 1e-13 && of_solution < 1e-11, "{:e} {:e}", of_matrix, of_solution);
    }

    /// Any indefinite matrix whose interior is regular: the inertia is that of the interior.
    #[test]
    fn any_indefinite_matrix_is_condensed(
        diagonal in prop::collection::vec(-2.0_f64..2.0, 1..60),
        holes in prop::collection::vec(any::<bool>(), 60),
        edges in prop::collection::vec((0_usize..60, 0_usize..60, -1.0_f64..1.0), 0..200),
        chosen in prop::collection::vec(0_u8..4, 60),
    ) {
        let n = diagonal.len();
        let mut entries: Vec<(usize, usize, f64)> =
            diagonal.into_iter().enumerate().map(|(i, d)| (i, i, if holes[i] { 0.0 } else { d })).collect();
        entries.extend(edges.into_iter().map(|(a, b, v)| (a % n, b % n, v)));
        let m = Matrix::new(n, &entries);
        let interface: Vec<u32> = (0..n).filter(|&i| chosen[i] == 0).map(|i| i as u32).collect();
        prop_assume!(interior_is_regular(&m, &interface));
        let mut schur = SchurComplement::new(&m.pattern(), &interface).unwrap();
        let inertia = schur.factor(&m.values).unwrap();
        prop_assert_eq!((inertia.positive, inertia.negative), interior_inertia(&m, &interface));
        let (of_matrix, of_solution) = deviations(&m, &mut schur, &interface);
        prop_assert!(of_matrix < 1e-9 && of_solution < 1e-7, "{:e} {:e}", of_matrix, of_solution);
    }
}
