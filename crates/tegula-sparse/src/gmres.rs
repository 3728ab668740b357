//! GMRES (generalised minimal residual method) for small dense vectors: solutions and eigenvalues of an operator
//! `I + B`.
//!
//! Y. Saad, M. H. Schultz, *GMRES: a generalized minimal residual algorithm for solving nonsymmetric linear systems*,
//! SIAM J. Sci. Stat. Comput. 7 (1986) 856–869. The Arnoldi process orthogonalises every vector twice.

use nalgebra::DMatrix;

/// Pseudo-random numbers between −½ and ½, identical in every run: a start vector of the Arnoldi process without
/// symmetry.
pub fn noise() -> impl Iterator<Item = f64> {
    let mut seed = 0x9e37_79b9_7f4a_7c15_u64;
    std::iter::repeat_with(move || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 11) as f64 / (1u64 << 53) as f64 - 0.5
    })
}

/// GMRES workspace of fixed size: Krylov basis and Hessenberg matrix of the Arnoldi process.
#[derive(Debug, Clone)]
pub struct Gmres {
    /// Length of the vectors.
    size: usize,
    /// Largest number of Arnoldi steps before a restart.
    most: usize,
    /// Orthonormal basis vectors, one after another.
    basis: Vec<f64>,
    /// Hessenberg matrix by columns of `most + 1` entries; triangular after the rotations of a solution.
    hessenberg: Vec<f64>,
    /// Cosines and sines of the Givens rotations.
    rotations: Vec<[f64; 2]>,
    /// Rotated right side of the least-squares problem.
    right: Vec<f64>,
    work: Vec<f64>,
}

/// Statistics of the solution of a linear system.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Outcome {
    /// Number of applications of the operator.
    pub applications: usize,
    /// Norm of the residual over the norm of the right side.
    pub residual: f64,
}

impl Gmres {
    /// Allocates the workspace for vectors of length `size`, with at most `most` Arnoldi steps between restarts.
    pub fn new(size: usize, most: usize) -> Self {
        let most = most.min(size);
        Self {
            size,
            most,
            basis: vec![0.0; size * (most + 1)],
            hessenberg: vec![0.0; (most + 1) * most],
            rotations: vec![[1.0, 0.0]; most],
            right: vec![0.0; most + 1],
            work: vec![0.0; size],
        }
    }

    /// Solves `A x = b` from the start `x` with the residual `b − A x = residual`. `apply(v, out)` writes `A v`; it is
    /// called about `limit` times at most. Residuals are relative to the norm of `b`.
    ///
    /// # Errors
    /// The errors of `apply`.
    pub fn solve<E>(
        &mut self,
        b: &[f64],
        (x, residual): (&mut [f64], &[f64]),
        (tolerance, limit): (f64, usize),
        mut apply: impl FnMut(&[f64], &mut [f64]) -> Result<(), E>,
    ) -> Result<Outcome, E> {
        let scale = norm(b);
        let mut applications = 0;
        self.work.copy_from_slice(residual);
        loop {
            let start = norm(&self.work);
            let residual = start / scale;
            // NaN also ends the iteration: the caller judges the residual.
            if !(start > tolerance * scale) || applications >= limit || self.most == 0 {
                return Ok(Outcome { applications, residual });
            }
            for (v, w) in self.basis[..self.size].iter_mut().zip(&self.work) {
                *v = w / start;
            }
            self.right.fill(0.0);
            self.right[0] = start;
            let mut steps = 0;
            while steps < self.most && applications < limit {
                let next = self.arnoldi(steps, &mut apply)?;
                applications += 1;
                steps += 1;
                self.rotate(steps - 1);
                // The new vector vanishes: the Krylov space contains the solution.
                if self.right[steps].abs() <= tolerance * scale || !(next > 0.0) {
                    break;
                }
            }
            self.update(steps, x);
            if self.right[steps].abs() <= tolerance * scale {
                return Ok(Outcome { applications, residual: self.right[steps].abs() / scale });
            }
            apply(x, &mut self.work)?;
            applications += 1;
            for (w, b) in self.work.iter_mut().zip(b) {
                *w = b - *w;
            }
        }
    }

    /// Ritz values (real and imaginary parts) of the operator, by the Arnoldi process from the start vector `b`;
    /// eigenvalues far from the others become accurate first. Every `interval` steps and at the end they are shown to
    /// `enough`, which may end the process; its second argument tells whether they are exact because the Krylov space
    /// is invariant.
    ///
    /// # Errors
    /// The errors of `apply`.
    pub fn ritz_values<E>(
        &mut self,
        b: &[f64],
        interval: usize,
        mut enough: impl FnMut(&[[f64; 2]], bool) -> bool,
        mut apply: impl FnMut(&[f64], &mut [f64]) -> Result<(), E>,
    ) -> Result<Vec<[f64; 2]>, E> {
        let start = norm(b);
        if !(start > 0.0) {
            return Ok(Vec::new());
        }
        for (v, b) in self.basis[..self.size].iter_mut().zip(b) {
            *v = b / start;
        }
        let (mut scale, mut values) = (0.0_f64, Vec::new());
        for steps in 1..=self.most {
            let next = self.arnoldi(steps - 1, &mut apply)?;
            scale = scale.max(norm(&self.hessenberg[(steps - 1) * (self.most + 1)..][..steps]));
            // The Krylov space is invariant to rounding.
            let invariant = !(next > 1e-13 * scale);
            let last = steps == self.most || invariant;
            if last || steps % interval == 0 {
                values = self.eigenvalues(steps);
                if enough(&values, invariant) || last {
                    break;
                }
            }
        }
        Ok(values)
    }

    /// Leading square part of the Hessenberg matrix, of order `steps`.
    fn leading_part(&self, steps: usize) -> DMatrix<f64> {
        let entry =
            |i: usize, j: usize| if i <= j + 1 { self.hessenberg[j * (self.most + 1) + i] } else { 0.0 };
        DMatrix::from_fn(steps, steps, entry)
    }

    /// Ritz vector of unit length for a real Ritz value of the last Arnoldi process, which took `steps` steps.
    pub fn ritz_vector(&self, steps: usize, value: f64) -> Vec<f64> {
        let shifted = self.leading_part(steps) - DMatrix::identity(steps, steps) * value;
        let mut vector = vec![0.0; self.size];
        if let Some(right) = shifted.svd(false, true).v_t {
            // The last right singular vector belongs to the smallest singular value.
            for (factor, v) in right.row(steps - 1).iter().zip(self.basis.chunks_exact(self.size)) {
                vector.iter_mut().zip(v).for_each(|(x, v)| *x += factor * v);
            }
        }
        vector
    }

    /// Eigenvalues of the leading part of the Hessenberg matrix; none where they are not found.
    fn eigenvalues(&self, steps: usize) -> Vec<[f64; 2]> {
        let found = crate::eigenvalues(&self.leading_part(steps)).unwrap_or_default();
        found.iter().map(|value| [value.re, value.im]).collect()
    }

    /// Arnoldi step: adds a vector to the basis and a column to the Hessenberg matrix; returns the entry below its
    /// diagonal.
    fn arnoldi<E>(
        &mut self,
        step: usize,
        apply: &mut impl FnMut(&[f64], &mut [f64]) -> Result<(), E>,
    ) -> Result<f64, E> {
        let n = self.size;
        let (old, new) = self.basis.split_at_mut((step + 1) * n);
        let new = &mut new[..n];
        apply(&old[step * n..], new)?;
        let column = &mut self.hessenberg[step * (self.most + 1)..][..self.most + 1];
        column.fill(0.0);
        let before = norm(new);
        for _ in 0..2 {
            for (h, v) in column.iter_mut().zip(old.chunks_exact(n)) {
                let product = dot(v, new);
                *h += product;
                new.iter_mut().zip(v).for_each(|(w, v)| *w -= product * v);
            }
        }
        let mut left = norm(new);
        // A remainder as small as rounding means that the vector lies in the space spanned before.
        if left <= 1e-15 * before {
            left = 0.0;
        }
        column[step + 1] = left;
        let inverse = if left > 0.0 { 1.0 / left } else { 0.0 };
        new.iter_mut().for_each(|w| *w *= inverse);
        Ok(left)
    }

    /// Makes column `k` of the Hessenberg matrix triangular by Givens rotations.
    fn rotate(&mut self, k: usize) {
        let column = &mut self.hessenberg[k * (self.most + 1)..][..self.most + 1];
        for (i, [c, s]) in self.rotations[..k].iter().enumerate() {
            let (a, b) = (column[i], column[i + 1]);
            (column[i], column[i + 1]) = (c * a + s * b, c * b - s * a);
        }
        let (a, b) = (column[k], column[k + 1]);
        let r = a.hypot(b);
        let [c, s] = if r > 0.0 { [a / r, b / r] } else { [1.0, 0.0] };
        self.rotations[k] = [c, s];
        (column[k], column[k + 1]) = (r, 0.0);
        let g = self.right[k];
        (self.right[k], self.right[k + 1]) = (c * g, -s * g);
    }

    /// Solves the triangular system and adds the resulting combination of the basis to `x`.
    fn update(&mut self, steps: usize, x: &mut [f64]) {
        let rows = self.most + 1;
        for k in (0..steps).rev() {
            let diagonal = self.hessenberg[k * rows + k];
            let y = if diagonal == 0.0 { 0.0 } else { self.right[k] / diagonal };
            for i in 0..k {
                self.right[i] -= y * self.hessenberg[k * rows + i];
            }
            let v = &self.basis[k * self.size..][..self.size];
            x.iter_mut().zip(v).for_each(|(x, v)| *x += y * v);
        }
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Projects a vector onto the orthogonal complement of orthonormal `directions`.
pub fn project_out(directions: &[Vec<f64>], vector: &mut [f64]) {
    for direction in directions {
        let product = dot(direction, vector);
        vector.iter_mut().zip(direction).for_each(|(x, d)| *x -= product * d);
    }
}

/// Euclidean norm of a vector.
pub fn norm(a: &[f64]) -> f64 {
    dot(a, a).sqrt()
}

#[cfg(test)]
mod tests {
    use std::convert::Infallible;

    use nalgebra::DVector;

    use super::*;

    /// Unsymmetric matrix: the unit matrix, a skew part of strength `skew`, and one eigenvalue far away.
    fn matrix(n: usize, skew: f64, outlier: f64) -> DMatrix<f64> {
        let entry = |i: usize, j: usize| ((i * 7 + j * 3 + 1) as f64).sin();
        let mut a = DMatrix::identity(n, n);
        a += DMatrix::from_fn(n, n, |i, j| skew * (entry(i, j) - entry(j, i)));
        a[(0, 0)] += outlier;
        a
    }

    fn applied(a: &DMatrix<f64>) -> impl Fn(&[f64], &mut [f64]) -> Result<(), Infallible> + '_ {
        move |v, out| {
            out.copy_from_slice((a * DVector::from_column_slice(v)).as_slice());
            Ok(())
        }
    }

    #[test]
    fn solution_of_an_unsymmetric_system_satisfies_it() {
        for (n, most) in [(1, 5), (12, 12), (40, 40), (40, 7)] {
            let a = matrix(n, 0.3, 4.0);
            let b: Vec<f64> = (0..n).map(|i| (i as f64 + 0.5).cos()).collect();
            let mut x = vec![0.0; n];
            let outcome = Gmres::new(n, most).solve(&b, (&mut x, &b), (1e-12, 1000), applied(&a)).unwrap();
            let rest = (&a * DVector::from_vec(x) - DVector::from_column_slice(&b)).norm() / norm(&b);
            assert!(rest < 2e-12 && outcome.residual < 2e-12, "{n} {most}: {rest:e} {outcome:?}");
        }
    }

    #[test]
    fn operator_of_low_rank_takes_one_step_more_than_its_rank() {
        let n = 50;
        let mut a = DMatrix::identity(n, n);
        (a[(3, 8)], a[(8, 3)], a[(20, 21)], a[(21, 20)]) = (5.0, -2.0, 30.0, 7.0);
        let b: Vec<f64> = (0..n).map(|i| 1.0 + i as f64).collect();
        let mut x = vec![0.0; n];
        let outcome = Gmres::new(n, 20).solve(&b, (&mut x, &b), (1e-12, 100), applied(&a)).unwrap();
        assert!(outcome.residual < 1e-12 && outcome.applications <= 5, "{outcome:?}");
    }

    #[test]
    fn vanishing_and_useless_right_sides_end_at_once() {
        let a = matrix(4, 0.3, 0.0);
        let mut x = vec![0.0; 4];
        let mut solver = Gmres::new(4, 4);
        for (b, nan) in [([0.0; 4], true), ([f64::NAN; 4], true)] {
            let outcome = solver.solve(&b, (&mut x, &b), (1e-9, 50), applied(&a)).unwrap();
            assert!(outcome.residual.is_nan() == nan && outcome.applications == 0, "{b:?}: {outcome:?}");
            assert_eq!(x, [0.0; 4]);
        }
    }

    #[test]
    fn ritz_vectors_are_eigenvectors_where_values_are_eigenvalues() {
        let n = 9;
        let a = matrix(n, 0.0, 6.0);
        let b: Vec<f64> = (0..n).map(|i| 1.0 + (3.1 * i as f64).sin()).collect();
        let mut solver = Gmres::new(n, n);
        let values = solver.ritz_values(&b, n, |_, _| false, applied(&a)).unwrap();
        let real: Vec<f64> = values.iter().filter(|[_, im]| *im == 0.0).map(|[re, _]| *re).collect();
        assert!(!real.is_empty(), "{values:?}");
        for value in real {
            let x = DVector::from_vec(solver.ritz_vector(values.len(), value));
            assert!((x.norm() - 1.0).abs() < 1e-10);
            assert!((&a * &x - &x * value).norm() <= 1e-8 * a.norm(), "{value}");
        }
    }

    #[test]
    fn ritz_values_of_a_whole_space_are_the_eigenvalues() {
        let n = 9;
        let a = matrix(n, 0.4, 6.0);
        let b: Vec<f64> = (0..n).map(|i| 1.0 + (3.1 * i as f64).sin()).collect();
        let found = Gmres::new(n, n).ritz_values(&b, 4, |_, _| false, applied(&a)).unwrap();
        let expected: Vec<[f64; 2]> = a.complex_eigenvalues().iter().map(|z| [z.re, z.im]).collect();
        // Multiple eigenvalues are found once, because the process ends with an invariant space.
        let among =
            |e: &[f64; 2], list: &[[f64; 2]]| list.iter().any(|f| (f[0] - e[0]).hypot(f[1] - e[1]) < 1e-8);
        assert!(expected.iter().all(|e| among(e, &found)), "{found:?} {expected:?}");
        assert!(found.iter().all(|f| among(f, &expected)), "{found:?} {expected:?}");
    }
}
