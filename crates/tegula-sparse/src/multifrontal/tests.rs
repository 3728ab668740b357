use super::*;

/// Matrix of a square grid of nodes with six unknowns each, those of neighbours coupled: column pointers, rows, values.
fn grid(n: usize, diagonal: f64) -> (Vec<usize>, Vec<u32>, Vec<f64>) {
    let (mut pointers, mut rows, mut values) = (vec![0], Vec::new(), Vec::new());
    for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
        let neighbours = [(i, j), (i, j + 1), (i + 1, j.wrapping_sub(1)), (i + 1, j), (i + 1, j + 1)];
        let neighbours = neighbours.into_iter().filter(|&(k, l)| k < n && l < n).map(|(k, l)| k * n + l);
        for a in 0..6 {
            let column = 6 * (i * n + j) + a;
            let below =
                neighbours.clone().flat_map(|node| 6 * node..6 * node + 6).filter(|&row| row >= column);
            for row in below {
                rows.push(row as u32);
                let wave = ((7 * row + 3 * column) as f64).sin();
                values.push(if row == column { diagonal + wave } else { wave });
            }
            pointers.push(rows.len());
        }
    }
    (pointers, rows, values)
}

/// Number of negative pivots, and a solution.
fn solve(fronts: &mut Multifrontal, pointers: &[usize], values: &[f64], given: bool) -> (usize, Vec<f64>) {
    loop {
        let own = if given { Values::Owned(values.to_vec()) } else { Values::Borrowed(values) };
        if let (Attempt::Done(inertia), _) = fronts.factor(pointers, own).unwrap() {
            let mut x: Vec<f64> = (0..pointers.len() - 1).map(|i| (i as f64).cos()).collect();
            fronts.solve(&mut x).unwrap();
            return (inertia.negative, x);
        }
    }
}

/// Covers a definite matrix, and an indefinite one whose pivots need the growth check.
#[test]
#[ignore = "long"]
fn memory_is_spared_without_a_change_of_a_bit() {
    for diagonal in [60.0, 1e-3] {
        let (pointers, rows, values) = grid(36, diagonal);
        let run = |low_memory: bool, threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| {
                let graph = CompressedGraph::new(&pointers, &rows, &[]);
                let order = graph.minimum_degree();
                let tree = AssemblyTree::new(&graph, &order, &pointers, &rows).unwrap();
                let mut fronts =
                    Multifrontal::of_tree(tree, values.len(), Mode { low_memory, sequential: false })
                        .unwrap();
                assert_eq!(fronts.in_place.is_some(), low_memory);
                let in_place =
                    fronts.in_place.as_ref().map_or(0, |in_place| fronts.tasks.len() - in_place.task);
                assert!(!low_memory || (in_place > 1 && in_place < fronts.tasks.len()), "{in_place}");
                let first = solve(&mut fronts, &pointers, &values, true);
                for given in [true, false] {
                    assert!(solve(&mut fronts, &pointers, &values, given) == first, "the same once more");
                }
                first
            })
        };
        let usual = run(false, 1);
        assert_eq!(usual.0 > 0, diagonal < 60.0, "{diagonal}");
        for (low_memory, threads) in [(true, 1), (true, 2), (true, 3), (false, 2)] {
            assert!(run(low_memory, threads) == usual, "{diagonal} {low_memory} {threads}");
        }
    }
}

/// Covers the front of the interface in place of the values, on one thread and on several.
#[test]
#[ignore = "long"]
fn schur_complements_do_not_depend_on_the_memory_mode() {
    for diagonal in [60.0, 1e-3] {
        let (pointers, rows, values) = grid(36, diagonal);
        // Two lines of nodes.
        let interface: Vec<u32> = (0..6 * 36).chain(6 * 36 * 15..6 * 36 * 16).collect();
        let run = |low_memory: bool, threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| {
                let graph = CompressedGraph::new(&pointers, &rows, &interface);
                let order = graph.minimum_degree();
                let tree = AssemblyTree::new(&graph, &order, &pointers, &rows).unwrap();
                let mode = Mode { low_memory, sequential: false };
                let mut fronts = Multifrontal::of_tree(tree, values.len(), mode).unwrap();
                assert_eq!(fronts.in_place.is_some(), low_memory);
                while !matches!(
                    fronts.factor(&pointers, Values::Borrowed(&values)).unwrap().0,
                    Attempt::Done(_)
                ) {}
                // Only the lower triangle is written.
                let m = interface.len();
                let mut schur: Vec<f64> =
                    (0..m * m).map(|k| if k % m < k / m { 0.0 } else { f64::NAN }).collect();
                fronts.copy_schur_complement(&mut schur, |i| interface.binary_search(&i).unwrap());
                let mut x: Vec<f64> = (0..pointers.len() - 1).map(|i| (i as f64).cos()).collect();
                fronts.condense(&mut x).unwrap();
                fronts.expand(&mut x).unwrap();
                assert!(schur.iter().chain(&x).all(|x| x.is_finite()));
                (schur, x)
            })
        };
        let usual = run(false, 1);
        for (low_memory, threads) in [(true, 1), (true, 2), (false, 2)] {
            assert!(run(low_memory, threads) == usual, "{diagonal} {low_memory} {threads}");
        }
    }
}
