//! Position of a mechanism nearest to its reference configuration: the least motion of its rigid bodies that closes their joints.
//!
//! The motion from the reference configuration X of the bodies to their place x makes the mean square displacement, weighted by the mass,
//!
//! ```text
//! f = ½ ∫ρ |x − X|² dV = ½ Σ m |Δr|² + ½ Σ E_ij (d_i − D_i)·(d_j − D_j)
//! ```
//!
//! (mass m, Euler tensor E, mass centre r, directors d and D) a minimum on `g = 0`. With the mass matrix W of displacements and rotations about
//! the present place and the gradients G of the constraints
//!
//! 1. gaps are closed by the least increments `δ = −W⁻¹ Gᵀ (G W⁻¹ Gᵀ + μ)⁻¹ g` (Gauss and Newton; with the damping μ of Levenberg and Marquardt,
//!    which also decides between redundant constraints; bodies that are much lighter than others count as heavier ones there): J. J. Moré, *The Levenberg–Marquardt algorithm*, Lecture Notes in Mathematics 630
//!    (1978) 105–116;
//! 2. from there the bodies move by [Newton's method](newton) to the minimum of f.
//!
//! Mechanisms have several positions in which the joints are closed, and f several minima: the search begins at [several places](starts).
//!
//! The position problem of multibody systems: J. García de Jalón, E. Bayo, *Kinematic and dynamic simulation of multibody systems* (1994),
//! Sect. 3.1.

mod newton;
mod starts;

use nalgebra::{DMatrix, DVector, Matrix3};

use crate::constraint::{Joint, Row};
use crate::norm::{larger, max_norm};
use crate::system::coordinates::Body;
use crate::{Mat3, Vec3};

/// Value of a constraint over its size, below which a joint is closed; and that at which round-off is near.
const CLOSED: f64 = 1e-10;
const ROUND_OFF: f64 = 1e-13;
/// Damping over the largest entry of the scaled Schur complement: at first, least, most.
const DAMPING: [f64; 3] = [1e-6, 1e-15, 1e6];
/// Largest rotation of a body in an iteration (rad).
const LARGEST_TURN: f64 = 0.5;
/// Iterations that close gaps, and those of the way to the nearest position.
const ITERATIONS: usize = 200;
/// Mass and moment of inertia over the largest ones that a body has at least while gaps are closed: products of much smaller and of much larger ones would
/// be lost in round-off.
const LIGHTEST: f64 = 1e-6;
/// Smallest moment of the Euler tensor beside the largest one, and what a body without inertia about an axis has in its place.
const WITHOUT_INERTIA: f64 = 1e-12;
const SUBSTITUTE: f64 = 1e-3;

/// Displacement of a mass centre and rotation of a body.
type Twist = [Vec3; 2];

/// Rigid body that may move.
#[derive(Debug, Clone)]
pub(super) struct Movable {
    centre: usize,
    directors: Option<[usize; 3]>,
    mass: f64,
    euler: Mat3,
    /// Euler tensor of the norm in which increments are least.
    of_norm: Mat3,
}

impl Movable {
    /// A body of a model of this size (length); one without mass has the mass `substitute` in a ball of that size.
    pub(super) fn new(body: &Body, length: f64, substitute: f64) -> Self {
        let (mass, euler) = if body.mass > 0.0 {
            (body.mass, body.euler)
        } else {
            (substitute, Mat3::identity() * (substitute * length * length))
        };
        let mut moments: Vec<f64> = euler.symmetric_eigenvalues().iter().copied().collect();
        moments.sort_by(f64::total_cmp);
        // A body turns about an axis without inertia where two of the three moments vanish.
        let rod = moments[1] <= WITHOUT_INERTIA * moments[2];
        let of_norm = if rod { euler + Mat3::identity() * (SUBSTITUTE * euler.trace()) } else { euler };
        let directors = body.directors.map(|directors| directors.map(|d| d as usize));
        Self { centre: body.centre as usize, directors, mass, euler, of_norm }
    }

    /// Inertia about the mass centre along the axes of space.
    fn inertia(&self, x: &[Vec3]) -> Mat3 {
        let Some(directors) = self.directors else { return Mat3::identity() };
        let axes = Mat3::from_columns(&directors.map(|d| x[d]));
        Mat3::identity() * self.of_norm.trace() - axes * self.of_norm * axes.transpose()
    }

    /// Moves the body.
    fn turn(&self, [shift, rotation]: &Twist, x: &mut [Vec3]) {
        x[self.centre] += shift;
        let turned = nalgebra::Rotation3::from_scaled_axis(*rotation);
        self.directors.iter().flatten().for_each(|&d| x[d] = turned * x[d]);
    }
}

/// Constraints of a mechanism whose bodies move from the reference configuration.
pub(super) struct Closing<'a> {
    joints: &'a [Joint],
    bodies: &'a [Movable],
    /// Nodal vectors of the reference configuration.
    reference: &'a [Vec3],
    /// Body of each nodal vector.
    owner: Vec<Option<usize>>,
    /// Constraints that a body can change: joint and row.
    rows: Vec<(usize, usize)>,
    /// Weight of each of them: its value times the weight is a displacement in the norm of the mass.
    weights: Vec<f64>,
    /// Size of the model (length).
    length: f64,
    /// Least mass and least moment of inertia of a body in the norm in which gaps are closed.
    least: [f64; 2],
    /// Scale of displacements in the norm of the mass.
    scale: f64,
}

/// Function of the position that becomes least while the joints are closed.
pub(super) enum Aim<'a> {
    /// Distance from the reference configuration.
    Reference,
    /// Sum of the squares of the gaps of other joints.
    Gaps(&'a Closing<'a>),
}

/// Constraints about a position.
struct Linear {
    /// Products of the inverse mass matrix with the weighted gradients, body by body.
    responses: Vec<Vec<(usize, Twist)>>,
    /// Schur complement.
    schur: DMatrix<f64>,
}

impl<'a> Closing<'a> {
    /// Constraints of `joints` between bodies that stand in a reference configuration of this size (length).
    pub(super) fn new(
        (joints, bodies): (&'a [Joint], &'a [Movable]),
        (reference, length): (&'a [Vec3], f64),
    ) -> Self {
        let mut owner = vec![None; reference.len()];
        for (number, body) in bodies.iter().enumerate() {
            owner[body.centre] = Some(number);
            body.directors.iter().flatten().for_each(|&d| owner[d] = Some(number));
        }
        let movable = |joint: &Joint| joint.vectors.iter().any(|&v| owner[v as usize].is_some());
        let own = |(j, joint): (usize, &'a Joint)| (0..joint.rows.len()).map(move |row| (j, row));
        let rows: Vec<_> =
            joints.iter().enumerate().filter(|(_, joint)| movable(joint)).flat_map(own).collect();
        let mass = bodies.iter().map(|body| body.mass).sum::<f64>();
        let weights = vec![1.0; rows.len()];
        let of_bodies =
            |measure: fn(&Movable) -> f64| bodies.iter().map(measure).fold(0.0, larger) * LIGHTEST;
        let least = [of_bodies(|body| body.mass), of_bodies(|body| body.of_norm.trace())];
        let scale = mass.sqrt() * length;
        let mut out = Self { joints, bodies, reference, owner, rows, weights, length, least, scale };
        let at_reference = out.linear(reference);
        for i in 0..out.rows.len() {
            let own = at_reference.schur[(i, i)];
            // The product of two axes that are parallel there has no gradient but for round-off.
            out.weights[i] = f64::min(1.0 / own.sqrt(), out.scale / out.row(i).1.size);
        }
        out
    }

    /// The constraints with weights by which distances count alike, whatever the mass of the bodies, and angles as distances at the end of the
    /// model.
    pub(super) fn by_size(mut self) -> Self {
        for i in 0..self.rows.len() {
            self.weights[i] = self.scale / self.row(i).1.size;
        }
        self
    }

    fn row(&self, i: usize) -> (&'a Joint, &'a Row) {
        let (joint, row) = self.rows[i];
        (&self.joints[joint], &self.joints[joint].rows[row])
    }

    fn at(joint: &Joint, x: &[Vec3]) -> Vec<Vec3> {
        joint.vectors.iter().map(|&v| x[v as usize]).collect()
    }

    /// Values of the constraints over their sizes, and with their weights; drives and gears stand as at the reference.
    fn values(&self, x: &[Vec3]) -> (f64, DVector<f64>) {
        let values: Vec<[f64; 2]> = (0..self.rows.len())
            .map(|i| {
                let (joint, row) = self.row(i);
                let value = row.value(&Self::at(joint, x), 0.0);
                [value / row.size, value * self.weights[i]]
            })
            .collect();
        let largest = if values.is_empty() { 0.0 } else { max_norm(values.iter().map(|v| v[0])) };
        (largest, DVector::from_iterator(values.len(), values.iter().map(|v| v[1])))
    }

    /// Whether all constraints hold as they are meant, and not half a turn away.
    fn is_on_branch(&self, x: &[Vec3]) -> bool {
        self.joints.iter().all(|joint| {
            let v = Self::at(joint, x);
            joint.rows.iter().all(|row| row.is_on_branch(&v, 0.0))
        })
    }

    /// Whether the joints are closed.
    pub(super) fn is_closed(&self, x: &[Vec3]) -> bool {
        self.values(x).0 <= CLOSED && self.is_on_branch(x)
    }

    fn linear(&self, x: &[Vec3]) -> Linear {
        let [mass, moment] = self.least;
        let inverse = |body: &Movable| {
            let inertia = body.inertia(x) + Mat3::identity() * moment;
            (1.0 / larger(body.mass, mass), inertia.try_inverse().unwrap_or_else(Matrix3::zeros))
        };
        let inverse: Vec<(f64, Mat3)> = self.bodies.iter().map(inverse).collect();
        let gradients: Vec<_> = (0..self.rows.len()).map(|i| self.gradient(i, x)).collect();
        let response = |gradient: &Vec<(usize, Twist)>| -> Vec<(usize, Twist)> {
            let of_body = |&(body, [force, moment]): &(usize, Twist)| {
                (body, [force * inverse[body].0, inverse[body].1 * moment])
            };
            gradient.iter().map(of_body).collect()
        };
        let responses: Vec<_> = gradients.iter().map(response).collect();
        let schur = DMatrix::from_fn(gradients.len(), gradients.len(), |i, j| {
            sparse_product(&gradients[i], &responses[j])
        });
        Linear { responses, schur }
    }

    /// Weighted gradient of a constraint.
    fn gradient(&self, i: usize, x: &[Vec3]) -> Vec<(usize, Twist)> {
        let (joint, row) = self.row(i);
        let v = Self::at(joint, x);
        let mut of_vectors = vec![Vec3::zeros(); v.len()];
        row.add_gradient(self.weights[i], &v, 0.0, &mut of_vectors);
        let mut out: Vec<(usize, Twist)> = Vec::new();
        for ((&vector, value), g) in joint.vectors.iter().zip(&v).zip(of_vectors) {
            let Some(body) = self.owner[vector as usize] else { continue };
            let place = out.iter().position(|(other, _)| *other == body).unwrap_or_else(|| {
                out.push((body, [Vec3::zeros(); 2]));
                out.len() - 1
            });
            if self.bodies[body].centre == vector as usize {
                out[place].1[0] += g;
            } else {
                out[place].1[1] += value.cross(&g);
            }
        }
        out
    }

    /// Increment `−W⁻¹ Gᵀ (S + μ)⁻¹ g`; `None` where the matrix is not positive definite.
    fn increment(&self, linear: &Linear, damping: f64, values: &DVector<f64>) -> Option<Vec<Twist>> {
        let largest = max_norm(linear.schur.diagonal().iter().copied());
        let mut matrix = linear.schur.clone();
        (0..matrix.nrows()).for_each(|i| matrix[(i, i)] += damping * largest);
        let mut out = vec![[Vec3::zeros(); 2]; self.bodies.len()];
        let multipliers = matrix.cholesky()?.solve(values);
        for (response, y) in linear.responses.iter().zip(multipliers.iter()) {
            for (body, [shift, rotation]) in response {
                out[*body][0] -= shift * *y;
                out[*body][1] -= rotation * *y;
            }
        }
        Some(out)
    }

    /// Position `x` moved by a part of an increment.
    fn moved(&self, x: &[Vec3], part: f64, increment: &[Twist]) -> Vec<Vec3> {
        let mut out = x.to_vec();
        for (body, twist) in self.bodies.iter().zip(increment) {
            body.turn(&twist.map(|t| t * part), &mut out);
        }
        out
    }

    /// Closes the gaps as far as it can by least increments.
    pub(super) fn close(&self, x: &mut Vec<Vec3>) {
        let [mut damping, least, most] = DAMPING;
        let (mut largest, mut values) = self.values(x);
        for _ in 0..ITERATIONS {
            if largest <= f64::EPSILON {
                return;
            }
            let linear = self.linear(x);
            let accepted = loop {
                let trial = self.increment(&linear, damping, &values).map(|increment| {
                    let turn = max_norm(increment.iter().map(|[_, rotation]| rotation.norm()));
                    self.moved(x, (LARGEST_TURN / turn).min(1.0), &increment)
                });
                if let Some(trial) = trial {
                    let (now, others) = self.values(&trial);
                    if others.norm() < values.norm() {
                        break Some((trial, now, others));
                    }
                    if largest <= ROUND_OFF {
                        return;
                    }
                }
                damping *= 10.0;
                if !(damping <= most) {
                    break None;
                }
            };
            let Some((trial, now, others)) = accepted else { return };
            (*x, largest, values) = (trial, now, others);
            damping = (damping * 0.01).max(least);
        }
    }

    /// Distance f from the reference configuration.
    fn distance(&self, x: &[Vec3]) -> f64 {
        let of_body = |body: &Movable| {
            let moved = |v: usize| x[v] - self.reference[v];
            let mut out = 0.5 * body.mass * moved(body.centre).norm_squared();
            if let Some(d) = body.directors {
                for i in 0..3 {
                    for j in 0..3 {
                        out += 0.5 * body.euler[(i, j)] * moved(d[i]).dot(&moved(d[j]));
                    }
                }
            }
            out
        };
        self.bodies.iter().map(of_body).sum()
    }

    /// Value of what is to become least.
    fn value(&self, aim: &Aim, x: &[Vec3]) -> f64 {
        match aim {
            Aim::Reference => self.distance(x),
            Aim::Gaps(others) => 0.5 * others.values(x).1.norm_squared(),
        }
    }

    /// Whether some body can change the constraints of a joint.
    pub(super) fn moves(&self, joint: usize) -> bool {
        self.rows.iter().any(|(other, _)| *other == joint)
    }
}

fn dot(a: &Twist, b: &Twist) -> f64 {
    a[0].dot(&b[0]) + a[1].dot(&b[1])
}

/// Product of two fields of a few bodies.
fn sparse_product(a: &[(usize, Twist)], b: &[(usize, Twist)]) -> f64 {
    a.iter()
        .map(|(body, x)| b.iter().filter(|(other, _)| other == body).map(|(_, y)| dot(x, y)).sum::<f64>())
        .sum()
}
