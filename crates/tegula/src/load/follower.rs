//! Follower loads and their load stiffness: pressure and moments.
//!
//! Such loads have no potential in general, so their load stiffness `−∂f/∂x` is not symmetric. Its symmetric part
//! enters the tangent of the model. The skew part, the *circulatory* stiffness of
//! [`CirculatoryStiffness`](crate::system::CirculatoryStiffness), is added in the solution of the linear systems. It
//! vanishes for conservative cases: pressure on closed or supported edges, moments in the plane of bending.

use std::sync::Arc;

use super::edge_couple::{EdgeForces, edge_derivative, edge_forces};
use super::{Dependence, LoadFactor, LoadOnNodes, OwnLoad};
use crate::element::Nodal;
use crate::element::geometry::{GAUSS_POINTS, shape, shape_eta, shape_xi};
use crate::{Mat3, Vec3};

pub use crate::model::LoadStiffness;

/// Follower load: it depends on the positions and directors on which it acts.
#[derive(Debug, Clone)]
pub enum FollowerLoad {
    /// Pressure on a quad (positions of its nodes): `f_a = −p ∫N_a r,ξ × r,η dξdη`.
    Pressure {
        /// Nodal vectors: positions of the four nodes.
        vectors: [u32; 4],
        /// Pressure at factor 1 [force/area].
        pressure: f64,
        /// Factor over the analysis step.
        factor: LoadFactor,
    },
    /// Spatially constant moment on a director: `f = m × d / |d|²`, from `δW = m·δθ`, `δθ = d × δd / |d|²`. The
    /// drilling component `m·d` does no work.
    Moment {
        /// Nodal vector of the director.
        vector: u32,
        /// Moment at factor 1 [force·length].
        moment: Vec3,
        /// Factor over the analysis step.
        factor: LoadFactor,
    },
    /// Spatially constant moment at one end of a mesh edge, with all its components: the director takes those that
    /// rotate it, and a couple of forces on the ends of the edge takes the drilling component.
    ///
    /// With the edge `t = r_b − r_a`, `w = d × t` and the work `m·δθ` of the rotation of director and edge,
    /// `δθ = d × δd/|d|² + d w·(δt − (d·t) δd/|d|²)/|w|²`, which is the rotation itself for every rigid motion:
    ///
    /// ```text
    /// F = (m·d) w/|w|²        on r_b, −F on r_a
    /// f = (m × d − (d·t) F)/|d|²     on d
    /// ```
    EdgeMoment {
        /// Positions of both ends of the edge, and the director at one of them.
        vectors: [u32; 3],
        /// Moment at factor 1 [force·length].
        moment: Vec3,
        /// Factor over the analysis step.
        factor: LoadFactor,
    },
    /// Spatially constant moment m on a rigid body: `f_i = w × d_i` on its directors, whose moment `Σ d_i × f_i` is m with
    /// `(tr(D Dᵀ) I − D Dᵀ) w = m`, also for the directors D in the middle of a step, which are no rotation; `w = ½ m` for
    /// orthonormal ones.
    BodyMoment {
        /// Nodal vectors of the directors.
        directors: [u32; 3],
        /// Moment at factor 1 [force·length].
        moment: Vec3,
        /// Factor over the analysis step.
        factor: LoadFactor,
    },
    /// Load that is neither of these, also of a caller.
    Own {
        /// Forces and their derivatives.
        load: OwnLoad,
        /// Factor over the analysis step.
        factor: LoadFactor,
    },
    /// One node of a load that is evaluated for all its nodes together, by the [`System`](crate::System): alone it has neither forces nor stiffness.
    Field {
        /// Load on all nodes.
        load: Arc<LoadOnNodes>,
        /// Number of the node among those of the load.
        place: usize,
        /// Factor over the analysis step.
        factor: LoadFactor,
    },
}

impl FollowerLoad {
    /// Whether it is zero at every factor; a load of a caller never counts as that.
    pub fn is_zero(&self) -> bool {
        match self {
            Self::Pressure { pressure, .. } => *pressure == 0.0,
            Self::Moment { moment, .. }
            | Self::EdgeMoment { moment, .. }
            | Self::BodyMoment { moment, .. } => *moment == Vec3::zeros(),
            Self::Own { .. } | Self::Field { .. } => false,
        }
    }

    /// Nodal vectors on which the load acts.
    pub fn vectors(&self) -> &[u32] {
        match self {
            Self::Pressure { vectors, .. } => vectors,
            Self::Moment { vector, .. } => std::slice::from_ref(vector),
            Self::EdgeMoment { vectors, .. } => vectors,
            Self::BodyMoment { directors, .. } => directors,
            Self::Own { load, .. } => load.0.vectors(),
            Self::Field { load, place, .. } => std::slice::from_ref(&load.vectors()[*place]),
        }
    }

    /// Factor of the load over the analysis step.
    pub fn factor(&self) -> &LoadFactor {
        match self {
            Self::Pressure { factor, .. }
            | Self::Moment { factor, .. }
            | Self::EdgeMoment { factor, .. }
            | Self::BodyMoment { factor, .. }
            | Self::Own { factor, .. }
            | Self::Field { factor, .. } => factor,
        }
    }

    /// Forces at factor 1 and nodal vectors `x` (current ones).
    pub fn forces(&self, x: &[Vec3], out: &mut [Nodal]) {
        match self {
            Self::Pressure { pressure, .. } => {
                out.fill([0.0; 3]);
                for [xi, eta] in GAUSS_POINTS {
                    let normal = tangent(x, shape_xi(eta)).cross(&tangent(x, shape_eta(xi)));
                    for (f, n) in out.iter_mut().zip(shape(xi, eta)) {
                        for i in 0..3 {
                            f[i] -= pressure * n * normal[i];
                        }
                    }
                }
            }
            Self::Moment { moment, .. } => out[0] = (moment.cross(&x[0]) / x[0].norm_squared()).into(),
            Self::EdgeMoment { moment, .. } => {
                let EdgeForces { couple, director } = edge_forces(moment, &(x[1] - x[0]), &x[2]);
                out[0] = (-couple).into();
                out[1] = couple.into();
                out[2] = director.into();
            }
            Self::BodyMoment { moment, .. } => turn_directors(moment, x, out),
            Self::Own { load, .. } => load.0.forces(x, out),
            Self::Field { .. } => out.fill([0.0; 3]),
        }
    }

    /// Sum `Σ P(x_j, x_{n−j})` of the quadratic form of a pressure, `f(x) = P(x, x)`, over coefficients `x_0 … x_n` of the positions of its nodes; zero for
    /// other loads.
    pub fn convolution(&self, x: &[[Vec3; 4]]) -> [Nodal; 4] {
        let mut out = [[0.0; 3]; 4];
        let Self::Pressure { pressure, .. } = self else { return out };
        for [xi, eta] in GAUSS_POINTS {
            let (along_xi, along_eta) = (shape_xi(eta), shape_eta(xi));
            let pairs = x.iter().zip(x.iter().rev());
            let normal: Vec3 = pairs.map(|(a, b)| tangent(a, along_xi).cross(&tangent(b, along_eta))).sum();
            for (f, n) in out.iter_mut().zip(shape(xi, eta)) {
                (0..3).for_each(|i| f[i] -= pressure * n * normal[i]);
            }
        }
        out
    }

    /// Load stiffness −∂f/∂x at factor 1, all blocks; of a moment on a body along its rotations.
    pub fn derivative(&self, x: &[Vec3]) -> LoadStiffness {
        let mut k = [[Mat3::zeros(); 4]; 4];
        match self {
            Self::Pressure { pressure, .. } => {
                for [xi, eta] in GAUSS_POINTS {
                    let (n, n_xi, n_eta) = (shape(xi, eta), shape_xi(eta), shape_eta(xi));
                    let r_xi = tangent(x, n_xi).cross_matrix();
                    let r_eta = tangent(x, n_eta).cross_matrix();
                    for a in 0..4 {
                        for b in 0..4 {
                            k[a][b] += (r_xi * n_eta[b] - r_eta * n_xi[b]) * (pressure * n[a]);
                        }
                    }
                }
            }
            Self::Moment { moment, .. } => {
                let d = x[0];
                let n2 = d.norm_squared();
                k[0][0] = (moment.cross(&d) * d.transpose() * (2.0 / n2) - moment.cross_matrix()) / n2;
            }
            Self::EdgeMoment { moment, .. } => {
                let [[couple_t, couple_d], [director_t, director_d]] =
                    edge_derivative(moment, &(x[1] - x[0]), &x[2]);
                (k[0][0], k[0][1], k[0][2]) = (-couple_t, couple_t, couple_d);
                (k[1][0], k[1][1], k[1][2]) = (couple_t, -couple_t, -couple_d);
                (k[2][0], k[2][1], k[2][2]) = (director_t, -director_t, -director_d);
            }
            // A rotation does not change `D Dᵀ`, nor w.
            Self::BodyMoment { moment, .. } => {
                (0..3).for_each(|i| k[i][i] = moment.cross_matrix() * -0.5);
            }
            Self::Own { load, .. } => k = load.0.stiffness(x),
            Self::Field { .. } => {}
        }
        k
    }

    /// Symmetric part of the load stiffness −∂f/∂x at factor 1, blocks of the lower triangle.
    pub fn stiffness(&self, x: &[Vec3], blocks: &mut [f64]) {
        let k = self.derivative(x);
        let mut out = blocks.chunks_exact_mut(9);
        for a in 0..self.vectors().len() {
            for b in 0..=a {
                let symmetric = (k[a][b] + k[b][a].transpose()) * 0.5;
                if let Some(block) = out.next() {
                    block.copy_from_slice(symmetric.transpose().as_slice());
                }
            }
        }
    }

    /// Whether forces depend on velocities.
    pub fn depends_on_velocities(&self) -> bool {
        matches!(self, Self::Field { load, .. } if load.dependence() == Dependence::Velocities)
    }

    /// Ratio of the drilling component of a moment, which does no work, to the moment, at the nodal vectors `x`.
    pub fn lost_share(&self, x: &[Vec3]) -> f64 {
        match self {
            Self::Moment { moment, .. } if moment.norm() > 0.0 => {
                moment.dot(&x[0]).abs() / (moment.norm() * x[0].norm())
            }
            _ => 0.0,
        }
    }
}

/// Forces `f_i = w × d_i` of a moment m on the directors of a body, `(tr(D Dᵀ) I − D Dᵀ) w = m`.
pub(super) fn turn_directors(moment: &Vec3, x: &[Vec3], out: &mut [Nodal]) {
    let product: Mat3 = x.iter().map(|d| d * d.transpose()).sum();
    let arms = Mat3::identity() * product.trace() - product;
    let w = arms.try_inverse().map_or_else(|| moment * 0.5, |inverse| inverse * moment);
    for (f, d) in out.iter_mut().zip(x) {
        *f = w.cross(d).into();
    }
}

fn tangent(x: &[Vec3], weights: [f64; 4]) -> Vec3 {
    x.iter().zip(weights).map(|(x, w)| x * w).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn quad() -> [Vec3; 4] {
        [
            Vec3::new(0.0, 0.0, 0.0),
            Vec3::new(1.0, 0.1, 0.2),
            Vec3::new(1.1, 0.9, -0.1),
            Vec3::new(-0.1, 1.0, 0.3),
        ]
    }

    /// Every kind of load with nodal vectors on which it acts.
    fn loads() -> [(FollowerLoad, Vec<Vec3>); 3] {
        let moment = Vec3::new(0.3, -1.0, 0.5);
        let edge = vec![Vec3::new(0.1, 0.2, 0.3), Vec3::new(0.9, -0.3, 0.7), Vec3::new(0.3, 0.4, 1.1)];
        [
            (
                FollowerLoad::Pressure {
                    vectors: [0, 1, 2, 3],
                    pressure: 2.0,
                    factor: LoadFactor::default(),
                },
                quad().to_vec(),
            ),
            (
                FollowerLoad::Moment { vector: 0, moment, factor: LoadFactor::default() },
                vec![Vec3::new(0.2, 0.3, 1.1)],
            ),
            (FollowerLoad::EdgeMoment { vectors: [0, 1, 2], moment, factor: LoadFactor::default() }, edge),
        ]
    }

    /// −∂f/∂x by central differences: block (a, b).
    fn differences(load: &FollowerLoad, x: &[Vec3], a: usize, b: usize) -> Mat3 {
        let h = 1e-6;
        let at = |j: usize, s: f64| {
            let mut y = x.to_vec();
            y[b][j] += s;
            let mut f = vec![[0.0; 3]; x.len()];
            load.forces(&y, &mut f);
            Vec3::from(f[a])
        };
        Mat3::from_columns(&std::array::from_fn::<Vec3, 3, _>(|j| (at(j, -h) - at(j, h)) / (2.0 * h)))
    }

    #[test]
    fn derivative_is_that_of_the_forces() {
        for (load, x) in loads() {
            let k = load.derivative(&x);
            let mut skew = 0.0;
            for a in 0..x.len() {
                for b in 0..x.len() {
                    let error = (k[a][b] - differences(&load, &x, a, b)).norm();
                    assert!(error < 1e-7, "{load:?}, block {a} {b}: {error:e}");
                    skew += (k[a][b] - k[b][a].transpose()).norm();
                }
            }
            assert!(skew > 0.1, "the case must have a skew part: {load:?}");
        }
    }

    /// The moment of the forces on the directors of a body does not change as the body turns. A change δθ × d_i of the directors in the forces alone
    /// changes it by half of what the turn of their arms takes away again.
    #[test]
    fn derivative_of_a_moment_on_a_body_is_that_of_its_forces_along_rotations() {
        let moment = Vec3::new(0.3, -1.0, 0.5);
        let load = FollowerLoad::BodyMoment { directors: [0, 1, 2], moment, factor: LoadFactor::default() };
        let directors = nalgebra::Rotation3::new(Vec3::new(0.4, -0.7, 0.2)).into_inner();
        let columns = |d: &Mat3| -> Vec<Vec3> { d.column_iter().map(Into::into).collect() };
        let forces = |d: &Mat3| {
            let mut f = [[0.0; 3]; 3];
            load.forces(&columns(d), &mut f);
            f.map(Vec3::from)
        };
        let k = load.derivative(&columns(&directors));
        let (axis, h) = (Vec3::new(0.2, 0.5, -0.9), 1e-6);
        let turned = |angle: f64| nalgebra::Rotation3::new(axis * angle).into_inner() * directors;
        let [after, before] = [h, -h].map(|angle| forces(&turned(angle)));
        for i in 0..3 {
            let change = axis.cross(&columns(&directors)[i]);
            let difference = (before[i] - after[i]) / (2.0 * h);
            assert!((k[i][i] * change - difference).norm() < 1e-9, "director {i}");
        }
    }

    #[test]
    fn stiffness_is_the_symmetric_part_of_the_derivative() {
        for (load, x) in loads() {
            let n = x.len();
            let mut blocks = vec![f64::NAN; 9 * n * (n + 1) / 2];
            load.stiffness(&x, &mut blocks);
            for a in 0..n {
                for b in 0..=a {
                    let expected =
                        (differences(&load, &x, a, b) + differences(&load, &x, b, a).transpose()) * 0.5;
                    let found = Mat3::from_row_slice(&blocks[9 * (a * (a + 1) / 2 + b)..][..9]);
                    assert!((found - expected).norm() < 1e-7, "{load:?}, block {a} {b}");
                }
            }
        }
    }

    #[test]
    fn pressure_on_a_flat_quad_is_pressure_times_area() {
        let x = [[0.0, 0.0], [2.0, 0.0], [2.0, 3.0], [0.0, 3.0]].map(|[a, b]| Vec3::new(a, b, 0.0));
        let mut f = [[0.0; 3]; 4];
        FollowerLoad::Pressure { vectors: [0; 4], pressure: 5.0, factor: LoadFactor::default() }
            .forces(&x, &mut f);
        approx::assert_relative_eq!(f.iter().map(|f| f[2]).sum::<f64>(), -30.0, epsilon = 1e-13);
    }

    #[test]
    fn moment_at_an_edge_has_the_whole_moment_and_no_force() {
        let [_, _, (load, x)] = loads();
        let FollowerLoad::EdgeMoment { moment, .. } = load else { panic!("an edge moment") };
        let mut f = [[0.0; 3]; 3];
        load.forces(&x, &mut f);
        let [a, b, d] = f.map(Vec3::from);
        assert!((a + b).norm() < 1e-15);
        let total = x[0].cross(&a) + x[1].cross(&b) + x[2].cross(&d);
        assert!((total - moment).norm() < 1e-14 * moment.norm(), "{total:?}");
        assert!(d.dot(&x[2]).abs() < 1e-14, "stretching a director does no work");
    }

    #[test]
    fn moment_on_a_director_tells_its_drilling_share() {
        let moment = FollowerLoad::Moment {
            vector: 0,
            moment: Vec3::new(3.0, 0.0, 4.0),
            factor: LoadFactor::default(),
        };
        approx::assert_relative_eq!(moment.lost_share(&[Vec3::new(0.0, 0.0, 2.0)]), 0.8, epsilon = 1e-15);
        let [(pressure, x), _, (edge, y)] = loads();
        assert_eq!((pressure.lost_share(&x), edge.lost_share(&y)), (0.0, 0.0));
    }
}
