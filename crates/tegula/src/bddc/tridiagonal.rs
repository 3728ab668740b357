//! Condition number of the preconditioned matrix, from the tridiagonal Lanczos matrix T of the conjugate gradients.
//!
//! With the step lengths `α_k` and the ratios `β_k` of the iteration, T has `1/α_k + β_{k−1}/α_{k−1}` on its diagonal
//! and `√β_k/α_k` beside it. Its largest and its smallest eigenvalue are found by bisection: as many eigenvalues are
//! below `x` as pivots of `T − x` are negative (Sturm sequence). The time is proportional to the number of iterations.
//!
//! Y. Saad, *Iterative Methods for Sparse Linear Systems*, 2nd ed., SIAM (2003), section 6.7.3; G. H. Golub,
//! C. F. Van Loan, *Matrix Computations*, 4th ed. (2013), section 8.4.1.

/// Relative width of the bisection interval at which an eigenvalue is accurate enough.
const WIDTH: f64 = 1e-6;

/// Condition number from the `(α, β)` of all iterations; 1 without any.
pub(super) fn condition(coefficients: &[(f64, f64)]) -> f64 {
    // Gershgorin bound: no eigenvalue is larger.
    let mut top = 0.0_f64;
    let mut before = 0.0;
    rows(coefficients).for_each(|(diagonal, beside)| {
        top = top.max(diagonal + before + beside);
        before = beside;
    });
    let n = coefficients.len();
    if n == 0 || !(top.is_finite() && top > 0.0) {
        return 1.0;
    }
    let largest = eigenvalue(coefficients, top, n);
    let smallest = eigenvalue(coefficients, top, 1);
    largest / smallest
}

/// Diagonal entry of each row and the entry to the right of it, zero in the last row.
fn rows(coefficients: &[(f64, f64)]) -> impl Iterator<Item = (f64, f64)> + '_ {
    let mut passed = 0.0;
    coefficients.iter().enumerate().map(move |(k, &(alpha, beta))| {
        let diagonal = 1.0 / alpha + passed;
        passed = beta / alpha;
        (diagonal, if k + 1 < coefficients.len() { beta.sqrt() / alpha } else { 0.0 })
    })
}

/// Eigenvalue number `count` in ascending order; all eigenvalues are positive and at most `top`.
fn eigenvalue(coefficients: &[(f64, f64)], top: f64, count: usize) -> f64 {
    let (mut low, mut high) = (0.0, top);
    // Eigenvalues smaller than the rounding of the largest one are not known.
    while high - low > WIDTH * high && high > f64::EPSILON * top {
        let middle = 0.5 * (low + high);
        if below(coefficients, middle) >= count {
            high = middle;
        } else {
            low = middle;
        }
    }
    high
}

/// Number of eigenvalues below `x`.
fn below(coefficients: &[(f64, f64)], x: f64) -> usize {
    let (mut pivot, mut before, mut count) = (1.0, 0.0, 0);
    for (diagonal, beside) in rows(coefficients) {
        pivot = diagonal - x - before * before / pivot;
        if pivot == 0.0 {
            pivot = f64::EPSILON * diagonal;
        }
        count += usize::from(pivot < 0.0);
        before = beside;
    }
    count
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_condition_is_that_of_all_eigenvalues() {
        let mut seed = 1_u64;
        let mut next = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 11) as f64 / (1_u64 << 53) as f64
        };
        for n in [1, 2, 3, 17, 60] {
            for scale in [1e-9, 1.0, 1e12] {
                let coefficients: Vec<(f64, f64)> =
                    (0..n).map(|_| (scale * (0.2 + next()), 0.05 + 0.6 * next())).collect();
                let mut t = nalgebra::DMatrix::zeros(n, n);
                for (k, &(alpha, beta)) in coefficients.iter().enumerate() {
                    t[(k, k)] += 1.0 / alpha;
                    if k + 1 < n {
                        t[(k + 1, k + 1)] += beta / alpha;
                        t[(k, k + 1)] = beta.sqrt() / alpha;
                        t[(k + 1, k)] = t[(k, k + 1)];
                    }
                }
                let all = t.symmetric_eigenvalues();
                let (found, wanted) = (condition(&coefficients), all.max() / all.min());
                assert!((found / wanted - 1.0).abs() < 1e-5, "{n}, {scale:e}: {found} for {wanted}");
            }
        }
        assert_eq!(condition(&[]), 1.0);
    }
}
