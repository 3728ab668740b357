//! Factoring a definite matrix again and solving with any factor, for one or many right sides, take no memory.
//!
//! One test only, so that no other one allocates meanwhile.

#![allow(clippy::unwrap_used)]

use std::alloc::System as Allocator;

use stats_alloc::{INSTRUMENTED_SYSTEM, StatsAlloc};
use tegula_sparse::{Factor, SparseLdlt, SymmetricPattern};

#[global_allocator]
static ALLOCATOR: &StatsAlloc<Allocator> = &INSTRUMENTED_SYSTEM;

/// Stiffness of a square grid of springs, `shift` off the diagonal, by its lower triangle.
fn grid(n: usize, shift: f64) -> (SymmetricPattern, Vec<f64>) {
    let (mut pointers, mut rows, mut values) = (vec![0], Vec::new(), Vec::new());
    for i in 0..n {
        for j in 0..n {
            let here = i * n + j;
            rows.push(here as u32);
            values.push(4.0 - shift);
            if j + 1 < n {
                rows.push(here as u32 + 1);
                values.push(-1.0);
            }
            if i + 1 < n {
                rows.push((here + n) as u32);
                values.push(-1.0);
            }
            pointers.push(rows.len());
        }
    }
    (SymmetricPattern::new(pointers, rows), values)
}

#[test]
fn solving_allocates_nothing() {
    let allocated = || {
        let stats = ALLOCATOR.stats();
        stats.allocations + stats.reallocations
    };
    // Eigenvalues 4 − 2 cos(iπ/(n+1)) − 2 cos(jπ/(n+1)): the second matrix has negative ones.
    for (shift, negative) in [(0.0, false), (0.5, true)] {
        let (pattern, values) = grid(40, shift);
        let mut factor = SparseLdlt::new(&pattern).unwrap();
        assert_eq!(factor.factor(&values).unwrap().negative > 0, negative);
        let mut x = vec![1.0; pattern.size()];
        let mut many = vec![1.0; 21 * pattern.size()];
        // The harness has a thread of its own that may allocate meanwhile, but not every time.
        let least = (0..5)
            .map(|_| {
                let before = allocated();
                if !negative {
                    factor.factor(&values).unwrap();
                }
                factor.solve(&mut x);
                factor.solve(&mut x);
                factor.solve_many(&mut many, 21);
                factor.solve_many(&mut many, 21);
                allocated() - before
            })
            .min();
        assert_eq!(least, Some(0), "shift {shift}");
    }
}
