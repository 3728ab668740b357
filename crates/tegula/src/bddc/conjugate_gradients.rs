//! Preconditioned conjugate gradients on the interface Γ.

use std::sync::Mutex;

use rayon::prelude::*;
use tegula_sparse::Workspace;

use super::tridiagonal::condition;
use super::{Bddc, BddcError, Convergence, locked};

/// Number of vector entries that one task sums.
const CHUNK: usize = 8192;
/// Largest true residual, as a share of the first one (both squared, in the energy norm), that is attributed to
/// rounding of the factors once the recurrence takes it to be smaller and a restart does not remove it. The caller
/// knows the forces better, and corrects.
const ROUNDING: f64 = 1e-10;
/// Largest true residual, as a share of the first one (both squared), that is accepted without a restart. Rounding
/// leaves this much in shells of a slenderness of about 1000; a restart there takes a fifth more iterations and gains
/// less than a digit.
const FINE: f64 = f64::EPSILON;
/// Largest ratio of the squared residuals of successive restarts; above it, further restarts have no use.
const PROGRESS: f64 = 0.3;

/// Vectors of the interface unknowns.
pub(super) struct Vectors {
    right: Vec<f64>,
    solution: Vec<f64>,
    r: Vec<f64>,
    z: Vec<f64>,
    p: Vec<f64>,
    sp: Vec<f64>,
    sums: Vec<f64>,
}

impl Vectors {
    pub fn new(n: usize) -> Self {
        let zero = || vec![0.0; n];
        Self {
            right: zero(),
            solution: zero(),
            r: zero(),
            z: zero(),
            p: zero(),
            sp: zero(),
            sums: vec![0.0; n.div_ceil(CHUNK)],
        }
    }
}

/// Stopping criterion of the conjugate gradients.
///
/// Both the recurrence of the iteration and the true residual of the solution have to reach it; the iteration restarts
/// from the true residual as long as that helps. Rounding of the factors can keep the true residual of thin shells
/// above the criterion. Once the recurrence has reached it, a true residual of 1.5e-8 of the first one in the energy
/// norm is therefore accepted, and after a restart one of 1e-5, however small `relative` is. [`Convergence::error`]
/// tells the error that was reached; corrections with forces that are computed anew, as in Newton's method, remove the
/// rest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StoppingCriterion {
    /// Tolerated error relative to the solution, both in the energy norm.
    pub relative: f64,
    /// Tolerated absolute error in the energy norm, as far as it is at most `share` of the solution.
    pub absolute: f64,
    /// Largest share of the solution that the error may have to be accepted by `absolute`.
    pub share: f64,
    /// Maximum number of iterations.
    pub iterations: usize,
}

impl Bddc {
    /// Solves a system with the last factors, in place of the right side `x`.
    ///
    /// # Errors
    /// No matrix is factored, `x` has another length than the mesh has unknowns or holds values that are not finite,
    /// the matrix is not positive definite, or the iterations did not suffice; `x` is unchanged then.
    pub fn solve(&mut self, x: &mut [f64], wanted: &StoppingCriterion) -> Result<Convergence, BddcError> {
        if !self.ready {
            return Err(BddcError::NotFactored);
        }
        if x.len() != self.unknowns {
            let (found, expected) = (x.len(), self.unknowns);
            return Err(BddcError::WrongSize { what: "the right side", found, expected });
        }
        if !x.iter().all(|v| v.is_finite()) {
            return Err(BddcError::NotFinite);
        }
        let mut vectors = std::mem::replace(&mut self.vectors, Vectors::new(0));
        let result = self.solve_with(x, wanted, &mut vectors);
        self.vectors = vectors;
        result
    }

    fn solve_with(
        &mut self,
        x: &mut [f64],
        wanted: &StoppingCriterion,
        vectors: &mut Vectors,
    ) -> Result<Convergence, BddcError> {
        let right_side: &[f64] = x;
        let workspaces = &self.workspaces;
        let own = self.distribution.own();
        self.data[own.clone()].par_iter_mut().with_max_len(4).zip(&self.subdomains[own.clone()]).for_each(
            |(datum, subdomain)| {
                let Some(interior) = &mut datum.interior else { return };
                for (x, &u) in datum.x.iter_mut().zip(&subdomain.unknowns[..subdomain.inner]) {
                    *x = right_side[u as usize];
                }
                datum.x[subdomain.inner..].fill(0.0);
                with_workspace(workspaces, |workspace| interior.condense_with(&mut datum.x, workspace));
                datum.y.copy_from_slice(&datum.x[subdomain.inner..]);
            },
        );
        self.distribution.exchange(&mut self.data, |_, datum| &mut datum.y)?;
        for (g, &u) in vectors.right.iter_mut().zip(&self.interface.unknowns) {
            *g = x[u as usize];
        }
        self.interface.add(&self.data, 0, &mut vectors.right);
        let convergence = self.iterate(wanted, vectors)?;
        let (solution, workspaces) = (&vectors.solution, &self.workspaces);
        self.data[own.clone()]
            .par_iter_mut()
            .with_max_len(4)
            .zip(&self.subdomains[own.clone()])
            .zip(&self.interface.of_subdomain[own])
            .for_each(|((datum, subdomain), of)| {
                for (x, &n) in datum.x[subdomain.inner..].iter_mut().zip(of) {
                    *x = solution[n as usize];
                }
                let Some(interior) = &mut datum.interior else { return };
                with_workspace(workspaces, |workspace| interior.expand_with(&mut datum.x, workspace));
            });
        let subdomains = &self.subdomains;
        self.distribution.exchange(&mut self.data, |p, datum| &mut datum.x[..subdomains[p].inner])?;
        for (datum, subdomain) in self.data.iter().zip(&self.subdomains) {
            for (value, &u) in datum.x.iter().zip(&subdomain.unknowns[..subdomain.inner]) {
                x[u as usize] = *value;
            }
        }
        for (value, &u) in vectors.solution.iter().zip(&self.interface.unknowns) {
            x[u as usize] = *value;
        }
        Ok(convergence)
    }

    fn iterate(
        &mut self,
        wanted: &StoppingCriterion,
        vectors: &mut Vectors,
    ) -> Result<Convergence, BddcError> {
        let Vectors { right, solution, r, z, p, sp, sums } = vectors;
        solution.fill(0.0);
        r.copy_from_slice(right);
        let mut iterations = 0;
        let mut coefficients = Vec::new();
        let mut start = None;
        let mut last = f64::INFINITY;
        // Number of runs from a true residual, and whether the recurrence of one of them reached its goal.
        let mut runs = 0;
        let mut converged = false;
        loop {
            // Start, or restart, from the true residual.
            self.precondition(r, z)?;
            let mut rz = positive(dot(r, z, sums))?;
            let first = *start.get_or_insert(rz);
            let enough = wanted.absolute.powi(2).min(wanted.share.powi(2) * first);
            let goal = (wanted.relative.powi(2) * first).max(enough);
            // Further runs are useless or not allowed.
            let over = rz > PROGRESS * last || iterations >= wanted.iterations;
            let accepted = if runs > 1 || over { ROUNDING } else { FINE };
            let rounding = converged && rz <= accepted * first;
            let small = rz <= goal || rounding;
            if small || over {
                if small {
                    let condition = condition(&coefficients);
                    return Ok(Convergence { iterations, error: rz.sqrt(), start: first.sqrt(), condition });
                }
                let residual = (rz / first).sqrt();
                let tolerance = (goal / first).sqrt();
                return Err(BddcError::NotConverged { iterations, residual, tolerance });
            }
            last = rz;
            p.copy_from_slice(z);
            runs += 1;
            while iterations < wanted.iterations {
                self.product(p, sp)?;
                let curvature = dot(p, sp, sums);
                if !curvature.is_finite() {
                    return Err(BddcError::NotFinite);
                }
                if curvature <= 0.0 {
                    return Err(BddcError::Indefinite(
                        "a search direction p of the conjugate gradients has p·S p ≤ 0 (S: Schur complement on the \
                         interface)",
                    ));
                }
                let alpha = rz / curvature;
                add(alpha, p, solution);
                add(-alpha, sp, r);
                iterations += 1;
                self.precondition(r, z)?;
                let old = rz;
                rz = positive(dot(r, z, sums))?;
                let beta = rz / old;
                if runs == 1 {
                    coefficients.push((alpha, beta));
                }
                if rz <= goal {
                    converged = true;
                    break;
                }
                p.par_iter_mut().with_min_len(CHUNK).zip(z.as_slice()).for_each(|(p, z)| *p = z + beta * *p);
            }
            self.product(solution, sp)?;
            for ((r, b), s) in r.iter_mut().zip(right.iter()).zip(sp.iter()) {
                *r = b - s;
            }
        }
    }

    /// Product with the assembled Schur complement, `out = S x`.
    fn product(&mut self, x: &[f64], out: &mut [f64]) -> Result<(), BddcError> {
        let own = self.distribution.own();
        self.data[own.clone()]
            .par_iter_mut()
            .with_max_len(4)
            .zip(&self.subdomains[own.clone()])
            .zip(&self.interface.of_subdomain[own])
            .for_each(|((datum, subdomain), of)| {
                let Some(schur) = &datum.schur else { return };
                // The interior unknowns stay in `x` until the end of the iteration; the places of the interface are
                // free.
                let local = &mut datum.x[subdomain.inner..];
                for (l, &n) in local.iter_mut().zip(of) {
                    *l = x[n as usize];
                }
                schur.product(local, &mut datum.y);
            });
        self.distribution.exchange(&mut self.data, |_, datum| &mut datum.y)?;
        out.fill(0.0);
        self.interface.add(&self.data, 0, out);
        Ok(())
    }

    /// Applies the BDDC preconditioner, `z = M⁻¹ r`.
    fn precondition(&mut self, r: &[f64], z: &mut [f64]) -> Result<(), BddcError> {
        self.scaling.share(r);
        let (scaling, subdomains, own) = (&self.scaling, &self.subdomains, self.distribution.own());
        let each = |data: &mut [super::SubdomainData]| {
            data.par_iter_mut()
                .with_max_len(4)
                .zip(&subdomains[own.clone()])
                .zip(&self.interface.of_subdomain[own.clone()])
                .for_each(|((datum, subdomain), of)| {
                    let Some(schur) = &datum.schur else { return };
                    for (k, (y, &n)) in datum.y.iter_mut().zip(of).enumerate() {
                        *y = if k >= subdomain.dual {
                            0.0
                        } else {
                            scaling
                                .part(n, subdomain.number, r)
                                .unwrap_or_else(|| datum.weights[k] * r[n as usize])
                        };
                    }
                    schur.forward(&mut datum.y);
                });
        };
        each(&mut self.data[own.clone()]);
        self.distribution.exchange(&mut self.data, |p, datum| &mut datum.y[subdomains[p].dual..])?;
        let dual = self.interface.dual();
        let (z_dual, z_primal) = z.split_at_mut(dual);
        z_primal.copy_from_slice(&r[dual..]);
        self.interface.add(&self.data, dual, z_primal);
        self.coarse.solve(z_primal);
        let z_primal: &[f64] = z_primal;
        self.data[own.clone()]
            .par_iter_mut()
            .with_max_len(4)
            .zip(&subdomains[own.clone()])
            .zip(&self.interface.of_subdomain[own])
            .for_each(|((datum, subdomain), of)| {
                let Some(schur) = &datum.schur else { return };
                for (y, &n) in datum.y[subdomain.dual..].iter_mut().zip(&of[subdomain.dual..]) {
                    *y = z_primal[n as usize - dual];
                }
                schur.backward(&mut datum.y);
                let grouped = scaling.len();
                for ((y, w), &n) in datum.y.iter_mut().zip(&datum.weights).zip(of) {
                    *y *= if (n as usize) < grouped { 1.0 } else { *w };
                }
            });
        self.distribution.exchange(&mut self.data, |p, datum| &mut datum.y[..subdomains[p].dual])?;
        let (z_groups, z_rest) = z_dual.split_at_mut(scaling.len());
        scaling.average(&self.data, z_groups);
        z_rest.fill(0.0);
        self.interface.add(&self.data, scaling.len(), z_rest);
        Ok(())
    }
}

/// Calls `work` with one of the workspaces that the threads share.
fn with_workspace(workspaces: &Mutex<Vec<Workspace>>, work: impl FnOnce(&mut Workspace)) {
    let mut workspace = locked(workspaces).pop().unwrap_or_default();
    work(&mut workspace);
    locked(workspaces).push(workspace);
}

/// Checks the sign of `r·M⁻¹r`: a positive definite matrix has a positive definite preconditioner.
fn positive(rz: f64) -> Result<f64, BddcError> {
    if !rz.is_finite() {
        Err(BddcError::NotFinite)
    } else if rz < 0.0 {
        Err(BddcError::Indefinite("the preconditioner is not positive definite"))
    } else {
        Ok(rz)
    }
}

/// Scalar product, summed in a fixed order for any number of threads; `sums` is workspace.
fn dot(a: &[f64], b: &[f64], sums: &mut [f64]) -> f64 {
    sums.par_iter_mut().zip(a.par_chunks(CHUNK).zip(b.par_chunks(CHUNK))).for_each(|(sum, (a, b))| {
        *sum = super::schur_complement::dot(a, b);
    });
    sums.iter().sum()
}

/// Vector update `y += a x`.
fn add(a: f64, x: &[f64], y: &mut [f64]) {
    y.par_iter_mut().with_min_len(CHUNK).zip(x).for_each(|(y, x)| *y += a * x);
}
