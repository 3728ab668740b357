//! Factorisations by MUMPS against those of the program, on as many ranks as `mpirun` starts.
#![cfg(feature = "link")]

use tegula_petsc::{Communicator, Mumps};
use tegula_sparse::{DirectMethod as _, Factor as _, FactorError, SparseLdlt, SymmetricPattern};

/// Pattern and values of the five-point Laplacian of a grid with `shift` on its diagonal.
fn grid(n: usize, shift: f64) -> (SymmetricPattern, Vec<f64>) {
    let (mut pointers, mut rows, mut values) = (vec![0], Vec::new(), Vec::new());
    for i in 0..n * n {
        rows.push(i as u32);
        values.push(4.0 + shift);
        if i % n + 1 < n {
            rows.push(i as u32 + 1);
            values.push(-1.0);
        }
        if i + n < n * n {
            rows.push((i + n) as u32);
            values.push(-1.0);
        }
        pointers.push(rows.len());
    }
    (SymmetricPattern::new(pointers, rows), values)
}

fn right_side(size: usize) -> Vec<f64> {
    (0..size).map(|i| (0.7 * i as f64 + 0.3).sin()).collect()
}

/// Definite, indefinite, singular and no numbers; MPI is started once in a process, so that all is one test.
#[test]
fn factorisations_are_those_of_the_program() {
    let ranks = Communicator::start().unwrap();
    let wanted = std::env::var("OMPI_COMM_WORLD_SIZE").map_or(1, |size| size.parse().unwrap());
    assert_eq!(ranks.size(), wanted);
    assert_eq!(tegula_petsc::is_launched(), std::env::var("OMPI_COMM_WORLD_SIZE").is_ok());
    assert!(Communicator::start().is_err());
    let method = Mumps(ranks);
    for n in [1, 2, 3, 17] {
        let (pattern, _) = grid(n, 0.0);
        let mut other = method.analyse(&pattern).unwrap();
        let mut own = SparseLdlt::new(&pattern).unwrap();
        let mut x = right_side(n * n);
        other.solve(&mut x);
        assert!(x.iter().all(|x| x.is_nan()), "there is no factor yet");
        // The eigenvalues of the grid lie between 0 and 8.
        for (k, shift) in [0.0, -0.9, -3.3, -7.9, 2.0].into_iter().enumerate() {
            let (_, values) = grid(n, shift);
            let inertia = other.factor(&values).unwrap();
            assert_eq!(inertia, own.factor(&values).unwrap(), "{n} {shift}");
            assert_eq!(other.factorizations(), k + 1);
            let (mut x, mut y) = (right_side(n * n), right_side(n * n));
            other.solve(&mut x);
            own.solve(&mut y);
            let size = y.iter().fold(0.0_f64, |size, y| if y.abs() > size { y.abs() } else { size });
            assert!(x.iter().zip(&y).all(|(x, y)| (x - y).abs() < 1e-12 * size), "{n} {shift}");
            // All ranks have one solution, to the last bit.
            for x in &x {
                assert_eq!(ranks.of_first(x.to_bits()).unwrap(), x.to_bits());
            }
        }
        let (_, mut values) = grid(n, 0.0);
        values[0] = f64::NAN;
        assert_eq!(other.factor(&values), Err(FactorError::NotFinite));
        let mut x = right_side(n * n);
        other.solve(&mut x);
        assert!(x.iter().all(|x| x.is_nan()), "a failed factorisation leaves no factor");
    }
    // A free chain, whose rigid motion nothing holds; then one of its ends is held.
    let pattern = SymmetricPattern::new(vec![0_usize, 2, 4, 5], vec![0, 1, 1, 2, 2]);
    let mut other = method.analyse(&pattern).unwrap();
    assert_eq!(other.factor(&[1.0, -1.0, 2.0, -1.0, 1.0]), Err(FactorError::Singular));
    let inertia = other.factor(&[2.0, -1.0, 2.0, -1.0, 1.0]).unwrap();
    assert_eq!((inertia.positive, inertia.negative, inertia.zero), (3, 0, 0));
    let mut x = [0.0, 0.0, 1.0];
    other.solve(&mut x);
    assert!((x[2] - 3.0).abs() < 1e-14, "{x:?}");

    assert!(ranks.any(ranks.rank() + 1 == ranks.size()).unwrap());
    assert!(!ranks.any(false).unwrap());
    assert_eq!(ranks.largest(ranks.rank() as i64 - 5).unwrap(), ranks.size() as i64 - 6);
    assert_eq!(ranks.of_first(7 + ranks.rank() as u64).unwrap(), 7);
    drop(other);
    ranks.end().unwrap();
}
