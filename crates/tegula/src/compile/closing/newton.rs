//! Newton's method for the position in which a function of it is least while joints are closed.
//!
//! In displacements `y = W^½ δ` in the norm of the mass the constraints have the gradients `A = G W^−½`. A QR decomposition of Aᵀ with column
//! pivoting decides which of them are independent and gives a basis Z of the motions that keep them; with the multipliers λ of least residual
//! `∇f + Aᵀ λ` the bodies move by
//!
//! ```text
//! δ = −W^−½ Z (Zᵀ H Z)⁻¹ Zᵀ ∇f,   H = ∇²(f + λᵀ g)
//! ```
//!
//! and the gaps that the curvature of the constraints leaves are closed again. Where `Zᵀ H Z` is not positive definite, its eigenvalues are replaced by
//! their absolute values, so that f decreases: J. Nocedal, S. J. Wright, *Numerical Optimization* (2006), Sects. 3.4 and 18.3.

use nalgebra::{DMatrix, DVector};

use super::{Aim, Closing, ITERATIONS, LARGEST_TURN, ROUND_OFF, Twist};
use crate::norm::max_norm;
use crate::{Mat3, Vec3};

/// Part of the model's size by which bodies are still off the nearest position.
const NEAREST: f64 = 1e-13;
/// Part of the model's size off the nearest position within which only whole steps are taken: what they do not reach is round-off.
const NEAR: f64 = 1e-9;
/// Smallest part of a step.
const SHORTEST: f64 = 1e-6;
/// Diagonal entry of the triangular factor over the largest one, below which a constraint depends on others.
const DEPENDENT: f64 = 1e-10;
/// Least eigenvalue of the reduced Hessian over the largest one.
const FLAT: f64 = 1e-10;

/// Scales that take displacements in the norm of the mass to those of a body: of its mass centre, and of its rotation.
type Scales = Vec<(f64, Mat3)>;

/// Step of Newton's method.
struct Step {
    direction: Vec<Twist>,
    /// Norm of the part of the gradient that keeps the constraints.
    slope: f64,
}

impl Closing<'_> {
    /// Moves a position in which the joints are closed to one in which the aim is least.
    pub(in crate::compile) fn approach(&self, aim: &Aim, x: &mut Vec<Vec3>) {
        let Some(mut step) = self.newton_step(aim, x) else { return };
        for _ in 0..ITERATIONS {
            if !(step.slope > NEAREST * self.scale) {
                return;
            }
            let turn = max_norm(step.direction.iter().map(|[_, rotation]| rotation.norm()));
            let mut part = f64::min(1.0, LARGEST_TURN / turn);
            let value = self.value(aim, x);
            let is_near = step.slope <= NEAR * self.scale;
            let accepted = loop {
                let mut trial = self.moved(x, part, &step.direction);
                self.close(&mut trial);
                let less = self.value(aim, &trial) - value;
                // Near the minimum f changes by less than its round-off; there the gradient tells how near it is.
                if self.is_closed(&trial)
                    && less <= ROUND_OFF * self.scale * self.scale
                    && let Some(next) = self.newton_step(aim, &trial)
                    && (less < 0.0 && !is_near || next.slope < 0.5 * step.slope)
                {
                    break Some((trial, next));
                }
                part *= 0.5;
                if !(part >= SHORTEST) || is_near {
                    break None;
                }
            };
            let Some((trial, next)) = accepted else { return };
            (*x, step) = (trial, next);
        }
    }

    /// Step of Newton's method; `None` where the position has none.
    fn newton_step(&self, aim: &Aim, x: &[Vec3]) -> Option<Step> {
        let scales = self.scales(x)?;
        let unknowns = 6 * self.bodies.len();
        let (gradient, mut hessian) = self.derivatives(aim, x);
        let mut gradient = scaled(&scales, gradient);
        let mut columns = DMatrix::zeros(unknowns, self.rows.len());
        for (i, mut column) in columns.column_iter_mut().enumerate() {
            let mut of_row = DVector::zeros(unknowns);
            for (body, twist) in self.gradient(i, x) {
                (0..6).for_each(|k| of_row[6 * body + k] = twist[k / 3][k % 3]);
            }
            let of_row = scaled(&scales, of_row);
            // Constraints on heavy bodies count as much as those on light ones.
            let size = of_row.norm();
            column.copy_from(&if size > 0.0 { of_row / size } else { of_row });
        }
        let mut multipliers = DVector::zeros(self.rows.len());
        let mut basis = DMatrix::identity(unknowns, unknowns);
        let mut rank = 0;
        if !self.rows.is_empty() {
            let sizes: Vec<f64> = (0..self.rows.len()).map(|i| self.scaled_size(i, x, &scales)).collect();
            let qr = columns.col_piv_qr();
            let r = qr.r();
            let largest = r[(0, 0)].abs();
            rank =
                (0..r.nrows().min(r.ncols())).take_while(|&i| r[(i, i)].abs() > DEPENDENT * largest).count();
            qr.q_tr_mul(&mut basis);
            let along = &basis * &gradient;
            let triangle = r.view((0, 0), (rank, rank));
            let found = triangle.solve_upper_triangular(&along.rows(0, rank))?;
            multipliers.rows_mut(0, rank).copy_from(&-found);
            qr.p().inv_permute_rows(&mut multipliers);
            for (multiplier, size) in multipliers.iter_mut().zip(sizes) {
                *multiplier = if size > 0.0 { *multiplier / size } else { 0.0 };
            }
        }
        for i in 0..self.rows.len() {
            self.add_hessian_of_row(i, multipliers[i], x, &mut hessian);
        }
        let hessian = scaled_on_both_sides(&scales, &hessian);
        let free = basis.rows(rank, unknowns - rank);
        gradient = free * gradient;
        let reduced = free * hessian * free.transpose();
        let step = minimum(reduced, &gradient);
        let direction = free.transpose() * step;
        let twist = |(body, (of_shift, of_rotation)): (usize, &(f64, Mat3))| -> Twist {
            let y = |first: usize| Vec3::from_fn(|k, _| direction[6 * body + first + k]);
            [y(0) * *of_shift, of_rotation * y(3)]
        };
        let slope = gradient.norm();
        Some(Step { direction: scales.iter().enumerate().map(twist).collect(), slope })
    }

    /// Norm of the gradient of a constraint in the norm of the mass.
    fn scaled_size(&self, i: usize, x: &[Vec3], scales: &Scales) -> f64 {
        let square = |(body, [force, moment]): (usize, Twist)| {
            let (of_shift, of_rotation) = &scales[body];
            (force * *of_shift).norm_squared() + (of_rotation.transpose() * moment).norm_squared()
        };
        self.gradient(i, x).into_iter().map(square).sum::<f64>().sqrt()
    }

    fn scales(&self, x: &[Vec3]) -> Option<Scales> {
        let of_body = |body: &super::Movable| {
            let lower = body.inertia(x).cholesky()?.l();
            Some((1.0 / body.mass.sqrt(), lower.transpose().try_inverse()?))
        };
        self.bodies.iter().map(of_body).collect()
    }

    /// Gradient and second derivative of what is to become least by displacements and rotations of the bodies.
    fn derivatives(&self, aim: &Aim, x: &[Vec3]) -> (DVector<f64>, DMatrix<f64>) {
        let unknowns = 6 * self.bodies.len();
        let (mut gradient, mut hessian) = (DVector::zeros(unknowns), DMatrix::zeros(unknowns, unknowns));
        if let Aim::Gaps(others) = aim {
            for (i, value) in others.values(x).1.iter().enumerate() {
                let mut of_row = DVector::zeros(unknowns);
                for (body, twist) in others.gradient(i, x) {
                    (0..6).for_each(|k| of_row[6 * body + k] = twist[k / 3][k % 3]);
                }
                gradient.axpy(*value, &of_row, 1.0);
                hessian.ger(1.0, &of_row, &of_row, 1.0);
                others.add_hessian_of_row(i, *value, x, &mut hessian);
            }
            return (gradient, hessian);
        }
        for (i, body) in self.bodies.iter().enumerate() {
            let shift = (x[body.centre] - self.reference[body.centre]) * body.mass;
            (0..3).for_each(|k| {
                gradient[6 * i + k] = shift[k];
                hessian[(6 * i + k, 6 * i + k)] = body.mass;
            });
            let Some(d) = body.directors else { continue };
            for a in 0..3 {
                let of_director: Vec3 =
                    (0..3).map(|b| (x[d[b]] - self.reference[d[b]]) * body.euler[(a, b)]).sum();
                let moment = x[d[a]].cross(&of_director);
                (0..3).for_each(|k| gradient[6 * i + 3 + k] += moment[k]);
                let mut block = bending(&of_director, &x[d[a]]);
                for b in 0..3 {
                    block += skew(&x[d[a]]).transpose() * skew(&x[d[b]]) * body.euler[(a, b)];
                }
                add(&mut hessian, [6 * i + 3; 2], &block);
            }
        }
        (gradient, hessian)
    }

    /// Adds a multiple of the second derivative of a constraint by displacements and rotations of the bodies.
    fn add_hessian_of_row(&self, i: usize, factor: f64, x: &[Vec3], out: &mut DMatrix<f64>) {
        let (joint, row) = self.row(i);
        let factor = factor * self.weights[i];
        let v = Self::at(joint, x);
        let mut of_vectors = vec![Vec3::zeros(); v.len()];
        row.add_gradient(factor, &v, 0.0, &mut of_vectors);
        let mut blocks = vec![0.0; 9 * v.len() * (v.len() + 1) / 2];
        row.add_second_derivative(factor, 0.0, &mut blocks);
        row.add_other_second_derivatives(factor, &v, &mut blocks);
        // First unknown that moves a vector, and the derivative of the vector by them.
        let moves = |a: usize| {
            let vector = joint.vectors[a] as usize;
            let body = self.owner[vector]?;
            let is_centre = self.bodies[body].centre == vector;
            Some(if is_centre { (6 * body, Mat3::identity()) } else { (6 * body + 3, -skew(&v[a])) })
        };
        let moves: Vec<Option<(usize, Mat3)>> = (0..v.len()).map(moves).collect();
        let mut block = blocks.chunks_exact(9);
        for a in 0..v.len() {
            for b in 0..=a {
                let Some(block) = block.next() else { break };
                let (Some((at_a, by_a)), Some((at_b, by_b))) = (&moves[a], &moves[b]) else { continue };
                let block = by_a.transpose() * Mat3::from_row_slice(block) * by_b;
                add(out, [*at_a, *at_b], &block);
                if a != b {
                    add(out, [*at_b, *at_a], &block.transpose());
                }
            }
            if let Some((first, _)) = moves[a].filter(|(first, _)| first % 6 == 3) {
                add(out, [first; 2], &bending(&of_vectors[a], &v[a]));
            }
        }
    }
}

/// Second derivative of `g·exp(θ) v` by the rotation vector θ at 0.
fn bending(g: &Vec3, v: &Vec3) -> Mat3 {
    (g * v.transpose() + v * g.transpose()) * 0.5 - Mat3::identity() * g.dot(v)
}

fn skew(v: &Vec3) -> Mat3 {
    v.cross_matrix()
}

fn add(out: &mut DMatrix<f64>, [row, column]: [usize; 2], block: &Mat3) {
    let mut view = out.fixed_view_mut::<3, 3>(row, column);
    view += block;
}

/// Gradient by displacements in the norm of the mass.
fn scaled(scales: &Scales, mut gradient: DVector<f64>) -> DVector<f64> {
    for (body, (of_shift, of_rotation)) in scales.iter().enumerate() {
        let mut shift = gradient.fixed_rows_mut::<3>(6 * body);
        shift *= *of_shift;
        let mut rotation = gradient.fixed_rows_mut::<3>(6 * body + 3);
        let turned = of_rotation.transpose() * &rotation;
        rotation.copy_from(&turned);
    }
    gradient
}

fn scaled_on_both_sides(scales: &Scales, matrix: &DMatrix<f64>) -> DMatrix<f64> {
    let once = |matrix: &DMatrix<f64>| {
        let columns: Vec<DVector<f64>> =
            matrix.column_iter().map(|column| scaled(scales, column.into_owned())).collect();
        DMatrix::from_columns(&columns)
    };
    once(&once(matrix).transpose())
}

/// Step to the minimum of a quadratic function with this Hessian and gradient; down its slope where it has none.
fn minimum(hessian: DMatrix<f64>, gradient: &DVector<f64>) -> DVector<f64> {
    if gradient.is_empty() {
        return gradient.clone();
    }
    let largest = max_norm(hessian.diagonal().iter().copied());
    if let Some(cholesky) = hessian.clone().cholesky()
        && cholesky.l_dirty().diagonal().iter().all(|d| d * d > FLAT * largest)
    {
        return -cholesky.solve(gradient);
    }
    let eigen = hessian.symmetric_eigen();
    let largest = max_norm(eigen.eigenvalues.iter().copied());
    let mut along = eigen.eigenvectors.transpose() * gradient;
    for (out, value) in along.iter_mut().zip(eigen.eigenvalues.iter()) {
        *out /= -(FLAT * largest).max(value.abs());
    }
    eigen.eigenvectors * along
}
