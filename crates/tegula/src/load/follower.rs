//! Loads that follow the motion: pressure and moments.
//!
//! Their tangents are not symmetric in general. The symmetric part enters the tangent of the
//! model (it is the whole of it for conservative cases: pressure on closed or supported edges,
//! moments in the plane of bending); the rest only costs iterations, never accuracy.

use crate::element::Nodal;
use crate::element::geometry::{GAUSS_POINTS, shape, shape_eta, shape_xi};
use crate::{Mat3, Vec3};

/// A load that depends on the positions and directors it acts on.
#[derive(Debug, Clone, PartialEq)]
pub enum FollowerLoad {
    /// Pressure on a quad (positions of its nodes): `f_a = −p ∫N_a r,ξ × r,η dξdη`.
    Pressure {
        /// Nodal vectors.
        vectors: [u32; 4],
        /// Pressure at amplitude 1 [force/area].
        pressure: f64,
        /// Amplitude.
        amplitude: Option<usize>,
    },
    /// A moment constant in space that turns a director: `f = m × d / |d|²`, from
    /// `δW = m·δθ`, `δθ = d × δd / |d|²`.
    Moment {
        /// The director.
        vector: u32,
        /// Moment at amplitude 1 [force·length].
        moment: Vec3,
        /// Amplitude.
        amplitude: Option<usize>,
    },
}

impl FollowerLoad {
    /// Nodal vectors on which it acts.
    pub fn vectors(&self) -> &[u32] {
        match self {
            Self::Pressure { vectors, .. } => vectors,
            Self::Moment { vector, .. } => std::slice::from_ref(vector),
        }
    }

    /// Amplitude that it follows.
    pub fn amplitude(&self) -> Option<usize> {
        match self {
            Self::Pressure { amplitude, .. } | Self::Moment { amplitude, .. } => *amplitude,
        }
    }

    /// Forces at amplitude 1 and nodal vectors `x` (current ones).
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
        }
    }

    /// Lower blocks of the symmetric part of −∂f/∂x at amplitude 1.
    pub fn stiffness(&self, x: &[Vec3], blocks: &mut [f64]) {
        match self {
            Self::Pressure { pressure, .. } => {
                let mut k = [[Mat3::zeros(); 4]; 4];
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
                let mut out = blocks.chunks_exact_mut(9);
                for a in 0..4 {
                    for b in 0..=a {
                        let symmetric = (k[a][b] + k[b][a].transpose()) * 0.5;
                        if let Some(block) = out.next() {
                            block.copy_from_slice(symmetric.transpose().as_slice());
                        }
                    }
                }
            }
            Self::Moment { moment, .. } => {
                let d = x[0];
                let md = moment.cross(&d);
                let k = (md * d.transpose() + d * md.transpose()) / d.norm_squared().powi(2);
                blocks.copy_from_slice(k.as_slice());
            }
        }
    }
}

fn tangent(x: &[Vec3], weights: [f64; 4]) -> Vec3 {
    x.iter().zip(weights).map(|(x, w)| x * w).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(load: &FollowerLoad, x: &[Vec3]) {
        let n = x.len();
        let mut blocks = vec![0.0; 9 * n * (n + 1) / 2];
        load.stiffness(x, &mut blocks);
        let h = 1e-6;
        let column = |b: usize, j: usize| {
            let at = |s: f64| {
                let mut y = x.to_vec();
                y[b][j] += s;
                let mut f = vec![[0.0; 3]; n];
                load.forces(&y, &mut f);
                f
            };
            let (p, m) = (at(h), at(-h));
            p.iter()
                .zip(m)
                .map(|(p, m)| std::array::from_fn(|i| -(p[i] - m[i]) / (2.0 * h)))
                .collect::<Vec<[f64; 3]>>()
        };
        for a in 0..n {
            for b in 0..=a {
                for i in 0..3 {
                    for j in 0..3 {
                        let expected = 0.5 * (column(b, j)[a][i] + column(a, i)[b][j]);
                        let found = blocks[9 * (a * (a + 1) / 2 + b) + 3 * i + j];
                        approx::assert_abs_diff_eq!(found, expected, epsilon = 1e-7);
                    }
                }
            }
        }
    }

    #[test]
    fn stiffness_is_the_symmetric_part_of_the_derivative() {
        let x = [
            Vec3::new(0.0, 0.0, 0.0),
            Vec3::new(1.0, 0.1, 0.2),
            Vec3::new(1.1, 0.9, -0.1),
            Vec3::new(-0.1, 1.0, 0.3),
        ];
        check(&FollowerLoad::Pressure { vectors: [0, 1, 2, 3], pressure: 2.0, amplitude: None }, &x);
        let moment = Vec3::new(0.3, -1.0, 0.5);
        check(&FollowerLoad::Moment { vector: 0, moment, amplitude: None }, &[Vec3::new(0.2, 0.3, 1.1)]);
    }

    #[test]
    fn pressure_on_a_flat_quad_is_pressure_times_area() {
        let x = [[0.0, 0.0], [2.0, 0.0], [2.0, 3.0], [0.0, 3.0]].map(|[a, b]| Vec3::new(a, b, 0.0));
        let mut f = [[0.0; 3]; 4];
        FollowerLoad::Pressure { vectors: [0; 4], pressure: 5.0, amplitude: None }.forces(&x, &mut f);
        approx::assert_relative_eq!(f.iter().map(|f| f[2]).sum::<f64>(), -30.0, epsilon = 1e-13);
    }
}
