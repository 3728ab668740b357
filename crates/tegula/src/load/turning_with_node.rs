//! Forces and moments that turn with a node: with the directors of its body, or with director and edge of its shell.
//!
//! They are `f = Σ c_i e_i` with components `c` that stay constant in a triad `e` that moves with the node. Such loads have no potential;
//! their load stiffness is exact.

use super::edge_couple::{EdgeForces, edge_derivative, edge_forces};
use super::follower::turn_directors;
use crate::model::{LoadStiffness, NodalLoad};
use crate::{Mat3, Vec3};

/// Force at a point of a rigid body or at a node of a beam, constant in the axes of the body: `f = Σ c_i d_i` with its directors d.
#[derive(Debug, Clone, PartialEq)]
pub struct ForceOnBody {
    /// Nodal vectors: the position on which the force acts, and the three directors.
    pub vectors: [u32; 4],
    /// Components along the directors (force).
    pub components: Vec3,
}

impl NodalLoad for ForceOnBody {
    fn vectors(&self) -> &[u32] {
        &self.vectors
    }

    fn forces(&self, x: &[Vec3], out: &mut [[f64; 3]]) {
        out.fill([0.0; 3]);
        out[0] = along(&self.components, [x[1], x[2], x[3]]).into();
    }

    fn stiffness(&self, _: &[Vec3]) -> LoadStiffness {
        let mut k = [[Mat3::zeros(); 4]; 4];
        for i in 0..3 {
            k[0][i + 1] = Mat3::identity() * -self.components[i];
        }
        k
    }
}

/// Moment on a rigid body or on a node of a beam, constant in the axes of the body, `m = Σ c_i d_i`, with the forces on the directors of a
/// [moment on a body](super::FollowerLoad::BodyMoment) that is constant in space.
#[derive(Debug, Clone, PartialEq)]
pub struct MomentOnBody {
    /// Nodal vectors of the directors.
    pub directors: [u32; 3],
    /// Components along the directors (force·length).
    pub components: Vec3,
}

impl NodalLoad for MomentOnBody {
    fn vectors(&self) -> &[u32] {
        &self.directors
    }

    fn forces(&self, x: &[Vec3], out: &mut [[f64; 3]]) {
        turn_directors(&along(&self.components, [x[0], x[1], x[2]]), x, out);
    }

    /// Derivative along rotations, which change neither `D Dᵀ` nor the components of w: `w = ½ m`.
    fn stiffness(&self, x: &[Vec3]) -> LoadStiffness {
        let mut k = [[Mat3::zeros(); 4]; 4];
        let moment = along(&self.components, [x[0], x[1], x[2]]);
        for i in 0..3 {
            for j in 0..3 {
                k[i][j] = x[i].cross_matrix() * (0.5 * self.components[j]);
            }
            k[i][i] -= moment.cross_matrix() * 0.5;
        }
        k
    }
}

/// Force at a node of a shell, constant in the triad of its director and of a mesh edge: `f = Σ c_i e_i`.
#[derive(Debug, Clone, PartialEq)]
pub struct ForceOnShell {
    /// Nodal vectors: the position of the node, that of the other end of the edge, and the director.
    pub vectors: [u32; 3],
    /// Components in the triad (force).
    pub components: Vec3,
}

impl NodalLoad for ForceOnShell {
    fn vectors(&self) -> &[u32] {
        &self.vectors
    }

    fn forces(&self, x: &[Vec3], out: &mut [[f64; 3]]) {
        out.fill([0.0; 3]);
        out[0] = along(&self.components, SurfaceTriad::new(x).axes).into();
    }

    fn stiffness(&self, x: &[Vec3]) -> LoadStiffness {
        let [by_edge, by_director] = SurfaceTriad::new(x).derivatives(&self.components);
        let mut k = [[Mat3::zeros(); 4]; 4];
        k[0][..3].copy_from_slice(&[by_edge, -by_edge, -by_director]);
        k
    }
}

/// Moment at a node of a shell, constant in the triad of its director and of a mesh edge: `m = Σ c_i e_i`. The director takes the components
/// across it, and a couple of forces on the ends of the edge the drilling component, as for
/// [edge moments](super::FollowerLoad::EdgeMoment).
#[derive(Debug, Clone, PartialEq)]
pub struct MomentOnShell {
    /// Nodal vectors: the position of the node, that of the other end of the edge, and the director.
    pub vectors: [u32; 3],
    /// Components in the triad (force·length).
    pub components: Vec3,
}

impl NodalLoad for MomentOnShell {
    fn vectors(&self) -> &[u32] {
        &self.vectors
    }

    fn forces(&self, x: &[Vec3], out: &mut [[f64; 3]]) {
        let moment = along(&self.components, SurfaceTriad::new(x).axes);
        let edge = x[1] - x[0];
        let EdgeForces { couple, director } = edge_forces(&moment, &edge, &x[2]);
        out.copy_from_slice(&[(-couple).into(), couple.into(), director.into()]);
    }

    fn stiffness(&self, x: &[Vec3]) -> LoadStiffness {
        let triad = SurfaceTriad::new(x);
        let (moment, edge, d) = (along(&self.components, triad.axes), x[1] - x[0], x[2]);
        let [moment_t, moment_d] = triad.derivatives(&self.components);
        let [[couple_t, couple_d], [director_t, director_d]] = edge_derivative(&moment, &edge, &d);
        // The forces are linear in the moment: F = w (m·d)/|w|², f = (m × d − (d·t) F)/|d|².
        let w = d.cross(&edge);
        let couple_m = w * d.transpose() / w.norm_squared();
        let director_m = -(d.cross_matrix() + couple_m * d.dot(&edge)) / d.norm_squared();
        let couple = [couple_t + couple_m * moment_t, couple_d + couple_m * moment_d];
        let director = [director_t + director_m * moment_t, director_d + director_m * moment_d];
        let mut k = [[Mat3::zeros(); 4]; 4];
        k[0][..3].copy_from_slice(&[-couple[0], couple[0], couple[1]]);
        k[1][..3].copy_from_slice(&[couple[0], -couple[0], -couple[1]]);
        k[2][..3].copy_from_slice(&[director[0], -director[0], -director[1]]);
        k
    }
}

/// Orthonormal triad of a director d and of an edge t from a node: `e₃ = d/|d|`, e₁ along the part of t across d, `e₂ = e₃ × e₁`. It turns
/// with every rigid rotation of the surface.
pub struct SurfaceTriad {
    /// Axes e₁, e₂, e₃.
    pub axes: [Vec3; 3],
    edge: Vec3,
    /// Length of the part of the edge across the director.
    across: f64,
    director_length: f64,
}

impl SurfaceTriad {
    /// Triad at present vectors: position of the node, position of the other end of the edge, director.
    pub fn new(x: &[Vec3]) -> Self {
        let (edge, director) = (x[1] - x[0], x[2]);
        let director_length = director.norm();
        let normal = director / director_length;
        let part = edge - normal * edge.dot(&normal);
        let across = part.norm();
        let first = part / across;
        Self { axes: [first, normal.cross(&first), normal], edge, across, director_length }
    }

    /// Derivatives of `Σ c_i e_i` with respect to edge and director.
    fn derivatives(&self, c: &Vec3) -> [Mat3; 2] {
        let [first, _, normal] = self.axes;
        let across = |e: &Vec3| Mat3::identity() - e * e.transpose();
        let normal_d = across(&normal) / self.director_length;
        // The part of the edge across the director: δs = (I − e₃ e₃ᵀ) δt − (e₃ tᵀ + (t·e₃) I) δe₃.
        let part_d = -(normal * self.edge.transpose() + Mat3::identity() * self.edge.dot(&normal)) * normal_d;
        let turned = across(&first) / self.across;
        let (first_t, first_d) = (turned * across(&normal), turned * part_d);
        let second_t = normal.cross_matrix() * first_t;
        let second_d = normal.cross_matrix() * first_d - first.cross_matrix() * normal_d;
        [first_t * c[0] + second_t * c[1], first_d * c[0] + second_d * c[1] + normal_d * c[2]]
    }
}

/// Sum `Σ c_i e_i`.
fn along(components: &Vec3, axes: [Vec3; 3]) -> Vec3 {
    axes.iter().zip(components.iter()).map(|(axis, c)| axis * *c).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    const COMPONENTS: Vec3 = Vec3::new(0.3, -1.0, 0.5);

    /// Load on a shell of each kind, and vectors on which it acts: they are not at right angles.
    fn on_shell() -> ([Box<dyn NodalLoad>; 2], [Vec3; 3]) {
        let (vectors, components) = ([0, 1, 2], COMPONENTS);
        let x = [Vec3::new(0.1, 0.2, 0.3), Vec3::new(0.9, -0.3, 0.7), Vec3::new(0.3, 0.4, 1.1)];
        ([Box::new(ForceOnShell { vectors, components }), Box::new(MomentOnShell { vectors, components })], x)
    }

    fn forces(load: &dyn NodalLoad, x: &[Vec3]) -> Vec<Vec3> {
        let mut out = vec![[f64::NAN; 3]; x.len()];
        load.forces(x, &mut out);
        out.into_iter().map(Vec3::from).collect()
    }

    fn rotation() -> Mat3 {
        nalgebra::Rotation3::new(Vec3::new(0.4, -1.7, 0.9)).into_inner()
    }

    /// −∂f_a/∂x_b by central differences.
    fn differences(load: &dyn NodalLoad, x: &[Vec3], a: usize, b: usize) -> Mat3 {
        let h = 1e-6;
        let at = |j: usize, s: f64| {
            let mut y = x.to_vec();
            y[b][j] += s;
            forces(load, &y)[a]
        };
        Mat3::from_columns(&std::array::from_fn::<Vec3, 3, _>(|j| (at(j, -h) - at(j, h)) / (2.0 * h)))
    }

    #[test]
    fn stiffness_on_shells_is_the_derivative_of_the_forces() {
        let (loads, x) = on_shell();
        for load in loads {
            let k = load.stiffness(&x);
            for a in 0..3 {
                for b in 0..3 {
                    let error = (k[a][b] - differences(load.as_ref(), &x, a, b)).norm();
                    assert!(error < 1e-8, "{load:?}, block {a} {b}: {error:e}");
                }
            }
        }
    }

    #[test]
    fn stiffness_of_a_force_on_a_body_is_the_derivative() {
        let load = ForceOnBody { vectors: [0, 1, 2, 3], components: COMPONENTS };
        let x = [Vec3::new(0.1, 0.2, 0.3), Vec3::x(), Vec3::y(), Vec3::z()];
        let k = load.stiffness(&x);
        for a in 0..4 {
            for b in 0..4 {
                assert!((k[a][b] - differences(&load, &x, a, b)).norm() < 1e-8, "block {a} {b}");
            }
        }
    }

    /// Directors that turn by δθ change by δθ × d_i; the forces of a moment on them turn with them.
    #[test]
    fn stiffness_of_a_moment_on_a_body_is_the_derivative_along_rotations() {
        let load = MomentOnBody { directors: [0, 1, 2], components: COMPONENTS };
        let directors = rotation();
        let columns: Vec<Vec3> = directors.column_iter().map(Into::into).collect();
        let (k, f) = (load.stiffness(&columns), forces(&load, &columns));
        let axis = Vec3::new(0.2, 0.5, -0.9);
        for i in 0..3 {
            let change: Vec3 = (0..3).map(|j| k[i][j] * axis.cross(&columns[j])).sum();
            assert!((change + axis.cross(&f[i])).norm() < 1e-14, "director {i}");
        }
    }

    #[test]
    fn loads_turn_with_the_surface() {
        let (loads, x) = on_shell();
        let turned = x.map(|x| rotation() * x);
        for load in loads {
            for (a, b) in forces(load.as_ref(), &x).iter().zip(forces(load.as_ref(), &turned)) {
                assert!((rotation() * a - b).norm() < 1e-14, "{load:?}");
            }
        }
    }

    /// The resultant is the force or the moment itself, in the triad of the surface or of the body.
    #[test]
    fn resultants_are_the_components_in_the_triad() {
        let ([force, moment], x) = on_shell();
        let whole = along(&COMPONENTS, SurfaceTriad::new(&x).axes);
        let sum = |f: &[Vec3]| f[0] + f[1];
        assert!((forces(force.as_ref(), &x)[0] - whole).norm() < 1e-15);
        let f = forces(moment.as_ref(), &x);
        assert!(sum(&f).norm() < 1e-15);
        let of_director_and_couple = x[2].cross(&f[2]) + x[0].cross(&f[0]) + x[1].cross(&f[1]);
        assert!((of_director_and_couple - whole).norm() < 1e-14, "{of_director_and_couple}");
        // Directors in the middle of a step are no rotation.
        let load = MomentOnBody { directors: [0, 1, 2], components: COMPONENTS };
        let d = [Vec3::new(0.9, 0.1, 0.0), Vec3::new(-0.1, 0.8, 0.2), Vec3::new(0.1, -0.2, 0.95)];
        let resultant: Vec3 = d.iter().zip(forces(&load, &d)).map(|(d, f)| d.cross(&f)).sum();
        assert!((resultant - along(&COMPONENTS, d)).norm() < 1e-14, "{resultant}");
    }
}
