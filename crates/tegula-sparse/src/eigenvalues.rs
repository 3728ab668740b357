//! Eigenvalues of small dense matrices without symmetry, by the implicit double-shift QR algorithm (J. G. F. Francis, *Computer Journal* 4 (1961–62) 265–271,
//! 332–345).

use nalgebra::{Complex, DMatrix, Schur};

/// Sizes, relative to the diagonal entries beside it, of the subdiagonal entry that is taken as zero. The first is the usual one. Of matrices with many nearly
/// equal eigenvalues the entries may stay above it by round-off for ever, and the next ones decide.
const NEGLIGIBLE: [f64; 4] = [f64::EPSILON, 1e-15, 1e-14, 1e-12];
/// Iterations per row that are allowed for each of these; two or three are usual.
const ITERATIONS_PER_ROW: usize = 40;

/// Eigenvalues of a square matrix, conjugate ones side by side; `None` where an entry is not finite or the iteration does not end.
pub fn eigenvalues(matrix: &DMatrix<f64>) -> Option<Vec<Complex<f64>>> {
    if !matrix.iter().all(|entry| entry.is_finite()) {
        return None;
    }
    let most = ITERATIONS_PER_ROW * matrix.nrows() + 1;
    let schur = NEGLIGIBLE.iter().find_map(|negligible| Schur::try_new(matrix.clone(), *negligible, most))?;
    let (_, t) = schur.unpack();
    let mut values = Vec::with_capacity(t.nrows());
    let mut m = 0;
    while m < t.nrows() {
        if m + 1 == t.nrows() || t[(m + 1, m)] == 0.0 {
            values.push(Complex::new(t[(m, m)], 0.0));
            m += 1;
            continue;
        }
        // Later rotations may move the discriminant of a block with a double eigenvalue across zero.
        let half = 0.5 * (t[(m, m)] - t[(m + 1, m + 1)]);
        let root = Complex::new(half * half + t[(m + 1, m)] * t[(m, m + 1)], 0.0).sqrt();
        let mean = Complex::new(0.5 * (t[(m, m)] + t[(m + 1, m + 1)]), 0.0);
        values.extend([mean + root, mean - root]);
        m += 2;
    }
    Some(values)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Orthogonal matrix with columns that follow a fixed formula.
    fn orthogonal(n: usize, number: usize) -> DMatrix<f64> {
        DMatrix::from_fn(n, n, |i, j| ((i * i + 3 * j + 7 * i * j + number) as f64).sin()).qr().q()
    }

    /// Matrix with `copies` of this block of two, as an orthogonal transformation leaves it.
    fn of_copies(copies: usize, block: [[f64; 2]; 2], number: usize) -> DMatrix<f64> {
        let entry = |i: usize, j: usize| if i / 2 == j / 2 { block[i % 2][j % 2] } else { 0.0 };
        let n = 2 * copies;
        let q = orthogonal(n, number);
        &q * DMatrix::from_fn(n, n, entry) * q.transpose()
    }

    /// Sum of the errors of eigenvalues, in whatever order, of copies of a block with the eigenvalues `mean ± root`.
    fn error(values: &[Complex<f64>], mean: f64, root: Complex<f64>) -> f64 {
        let nearest = |value: &Complex<f64>| {
            let [one, other] = [1.0, -1.0].map(|sign| (value - mean - root * sign).norm());
            if one < other { one } else { other }
        };
        values.iter().map(nearest).sum()
    }

    #[test]
    fn many_equal_eigenvalues_are_found() {
        let block = [[1.0, -0.01], [0.01, 2.0]];
        let a = of_copies(5, block, 164);
        // With the usual bound alone, the iteration of this matrix does not end.
        assert!(Schur::try_new(a.clone(), f64::EPSILON, 100_000).is_none());
        for number in 0..200 {
            let values = eigenvalues(&of_copies(5, block, number)).unwrap();
            assert_eq!(values.len(), 10);
            let error = error(&values, 1.5, Complex::new((0.25_f64 - 1e-4).sqrt(), 0.0));
            assert!(error < 1e-11, "{number} {error:e}");
        }
    }

    /// Eigenvalues that meet are found to the square root of round-off, and are never not a number.
    #[test]
    fn double_eigenvalues_and_conjugate_ones_are_found() {
        for number in 0..200 {
            for (apart, limit) in [(2e-2, 1e-6), (1e-2, 1e-11)] {
                let values = eigenvalues(&of_copies(3, [[1.0, -0.01], [0.01, 1.0 + apart]], number)).unwrap();
                let root = Complex::new(0.25 * apart * apart - 1e-4, 0.0).sqrt();
                let error = error(&values, 1.0 + 0.5 * apart, root);
                assert!(error < limit, "{number} {apart} {error:e}");
            }
        }
    }

    #[test]
    fn matrices_that_are_not_finite_have_none() {
        assert!(eigenvalues(&DMatrix::from_element(3, 3, f64::NAN)).is_none());
        assert!(eigenvalues(&DMatrix::zeros(0, 0)).is_some_and(|values| values.is_empty()));
        assert_eq!(eigenvalues(&DMatrix::from_element(1, 1, 3.0)), Some(vec![Complex::new(3.0, 0.0)]));
    }
}
