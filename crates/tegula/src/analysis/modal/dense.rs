//! Dense eigensolver: all modes of a small group of parts at once.
//!
//! With M = L Lᵀ the eigenvalues of L⁻¹ K L⁻ᵀ are those of the problem, the high ones to all digits. In the low ones
//! round-off leaves an error of the size of the largest times the machine precision: a Rayleigh–Ritz step with the
//! inverse, whose largest eigenvalues they are, refines them in the space of their vectors.

use nalgebra::{Cholesky, DMatrix};

use super::problem::{Problem, go_on};
use crate::analysis::Observer;
use crate::{Error, Result};
use tegula_sparse::lanczos::{RitzPair, SymmetricOperator as _};

/// Part of the largest eigenvalue of the round below which modes are refined.
const LOW: f64 = 1e-6;
/// Largest number of refinements: for eigenvalues over this many times six decades.
const ROUNDS: usize = 4;

/// All elastic modes of a group, in ascending order, with the factor of its shift already computed.
///
/// # Errors
/// The mass is not positive definite, or the observer has asked to stop.
pub(super) fn all(problem: &mut Problem, group: usize, observer: &dyn Observer) -> Result<Vec<RitzPair>> {
    go_on(observer)?;
    let (k, m) = matrices(problem, group);
    let count = k.nrows();
    let Some(factor) = Cholesky::new(m.clone()) else {
        return Err(Error::Singular {
            what: "The mass matrix is singular: some degrees of freedom have no mass.".into(),
            help: "Give every material a density, or the section a `total_mass`.".into(),
        });
    };
    let l = factor.l();
    let solved = |a: &DMatrix<f64>| l.solve_lower_triangular(a).unwrap_or_else(|| a * f64::NAN);
    let half = solved(&k);
    let mut standard = solved(&half.transpose());
    standard = (&standard + standard.transpose()) * 0.5;
    // Rigid modes are known: their eigenvalues are moved behind all others (deflation).
    let beyond = 4.0 * standard.iter().map(|x| x * x).sum::<f64>().sqrt();
    let rigid = rigid_vectors(problem, group);
    if rigid.ncols() > 0 {
        let moved = l.transpose() * &rigid;
        standard += &moved * moved.transpose() * beyond;
    }
    let eigen = standard.symmetric_eigen();
    let mut order: Vec<usize> = (0..count).collect();
    order.sort_by(|&a, &b| eigen.eigenvalues[a].total_cmp(&eigen.eigenvalues[b]));
    order.truncate(count - rigid.ncols());
    let lambdas: Vec<f64> = order.iter().map(|&i| eigen.eigenvalues[i]).collect();
    let vectors = DMatrix::from_fn(count, order.len(), |i, j| eigen.eigenvectors[(i, order[j])]);
    let vectors = l.tr_solve_lower_triangular(&vectors).unwrap_or_else(|| vectors * f64::NAN);
    let mut found = Spectrum { lambdas, vectors };
    found.refine(problem, (group, &m), observer)?;
    Ok(found.pairs(problem, group, (&k, &m)))
}

/// Stiffness K and mass M of a group.
fn matrices(problem: &Problem, group: usize) -> (DMatrix<f64>, DMatrix<f64>) {
    let unknowns = &problem.groups[group].unknowns;
    let mut place = vec![usize::MAX; problem.pattern.size()];
    unknowns.iter().enumerate().for_each(|(at, &i)| place[i as usize] = at);
    let n = unknowns.len();
    let (mut k, mut m) = (DMatrix::zeros(n, n), DMatrix::zeros(n, n));
    let (pointers, rows) = problem.pattern.columns();
    for &j in unknowns {
        let j = j as usize;
        for at in pointers[j]..pointers[j + 1] {
            let (a, b) = (place[rows[at] as usize], place[j]);
            for (matrix, values) in [(&mut k, &problem.stiffness), (&mut m, &problem.mass)] {
                matrix[(a, b)] = values[at];
                matrix[(b, a)] = values[at];
            }
        }
    }
    (k, m)
}

/// Rigid modes of a group, one per column.
fn rigid_vectors(problem: &Problem, group: usize) -> DMatrix<f64> {
    let Problem { groups, rigid, parts, newton, .. } = problem;
    let group = &groups[group];
    let mut out = DMatrix::zeros(group.unknowns.len(), group.rigid.len());
    let mut free = vec![0.0; problem.pattern.size()];
    for (column, &mode) in group.rigid.iter().enumerate() {
        newton.assembly.frames.components(&rigid.shape(mode, parts), &mut free);
        for (row, &i) in group.unknowns.iter().enumerate() {
            out[(row, column)] = free[i as usize];
        }
    }
    out
}

/// Eigenvalues in ascending order and their vectors.
struct Spectrum {
    lambdas: Vec<f64>,
    vectors: DMatrix<f64>,
}

impl Spectrum {
    /// Refines low modes by Rayleigh–Ritz steps, those far below the low ones once more. Leaves the factor of the
    /// group's own shift.
    fn refine(
        &mut self,
        problem: &mut Problem,
        (group, m): (usize, &DMatrix<f64>),
        observer: &dyn Observer,
    ) -> Result<()> {
        let shift = problem.groups[group].shift;
        let mut top = self.lambdas.last().copied().unwrap_or(0.0);
        for _ in 0..ROUNDS {
            let low = self.lambdas.iter().take_while(|l| **l < LOW * top).count();
            if low == 0 {
                break;
            }
            top = self.lambdas[low - 1].max(0.0);
            problem.groups[group].shift = -0.05 * top;
            if top > 0.0 && problem.factor_shifted() {
                self.ritz(problem, (group, m), low, observer)?;
            }
        }
        problem.groups[group].shift = shift;
        if problem.factor_shifted() {
            Ok(())
        } else {
            Err(Error::Outside("the shifted matrix changed between two factorisations".into()))
        }
    }

    /// Rayleigh–Ritz step: eigenvalues and vectors in the image of the `low` first vectors under the inverse.
    fn ritz(
        &mut self,
        problem: &mut Problem,
        (group, m): (usize, &DMatrix<f64>),
        low: usize,
        observer: &dyn Observer,
    ) -> Result<()> {
        let unknowns = problem.groups[group].unknowns.clone();
        let shift = problem.groups[group].shift;
        let size = problem.pattern.size();
        let mut operator = problem.operator(group, observer);
        let mut image = |m_x: &DMatrix<f64>| -> Result<DMatrix<f64>> {
            let mut y = DMatrix::zeros(m_x.nrows(), low);
            let (mut right, mut out) = (vec![0.0; size], vec![0.0; size]);
            for column in 0..low {
                go_on(observer)?;
                unknowns.iter().enumerate().for_each(|(row, &i)| right[i as usize] = m_x[(row, column)]);
                operator.apply(&right, &mut out);
                unknowns.iter().enumerate().for_each(|(row, &i)| y[(row, column)] = out[i as usize]);
            }
            Ok(y)
        };
        let mut basis = image(&(m * self.vectors.columns(0, low)))?;
        // M-orthonormalisation, twice, since images of different vectors can be nearly parallel.
        for _ in 0..2 {
            let Some(factor) = Cholesky::new(scaled_gram(&mut basis, m)) else { return Ok(()) };
            let Some(q) = factor.l().solve_lower_triangular(&basis.transpose()) else { return Ok(()) };
            basis = q.transpose();
        }
        let m_basis = m * &basis;
        let projected = m_basis.transpose() * image(&m_basis)?;
        let eigen = ((&projected + projected.transpose()) * 0.5).symmetric_eigen();
        let mut order: Vec<usize> = (0..low).collect();
        order.sort_by(|&a, &b| eigen.eigenvalues[b].total_cmp(&eigen.eigenvalues[a]));
        for (column, &i) in order.iter().enumerate() {
            self.lambdas[column] = shift + 1.0 / eigen.eigenvalues[i];
            self.vectors.set_column(column, &(&basis * eigen.eigenvectors.column(i)));
        }
        Ok(())
    }

    /// Eigenpairs of the inverse with the group's shift, and the residuals of `K φ − λ M φ` over the larger of its two
    /// terms.
    fn pairs(
        &self,
        problem: &Problem,
        group: usize,
        (k, m): (&DMatrix<f64>, &DMatrix<f64>),
    ) -> Vec<RitzPair> {
        let Problem { groups, pattern, .. } = problem;
        let group = &groups[group];
        let (k_x, m_x) = (k * &self.vectors, m * &self.vectors);
        let pair = |column: usize| {
            let lambda = self.lambdas[column];
            let (k_x, m_x) = (k_x.column(column), m_x.column(column) * lambda);
            let mut vector = vec![0.0; pattern.size()];
            let values = self.vectors.column(column);
            group.unknowns.iter().zip(values.iter()).for_each(|(&i, x)| vector[i as usize] = *x);
            let scale = (k.abs() * values.abs()).norm().max(m_x.norm());
            RitzPair { value: 1.0 / (lambda - group.shift), vector, residual: (k_x - m_x).norm() / scale }
        };
        (0..self.lambdas.len()).map(pair).collect()
    }
}

/// Scales columns to length 1 in M and returns their Gram matrix.
fn scaled_gram(basis: &mut DMatrix<f64>, m: &DMatrix<f64>) -> DMatrix<f64> {
    let mut m_basis = m * &*basis;
    for column in 0..basis.ncols() {
        let scale = 1.0 / basis.column(column).dot(&m_basis.column(column)).sqrt();
        basis.column_mut(column).scale_mut(scale);
        m_basis.column_mut(column).scale_mut(scale);
    }
    let gram = basis.transpose() * m_basis;
    (&gram + gram.transpose()) * 0.5
}
