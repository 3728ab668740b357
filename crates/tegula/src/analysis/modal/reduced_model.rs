//! Modal reduction with residual vectors, for the response to loads.
//!
//! Small motions about a state satisfy `M ẍ + C ẋ + K x = F u(t)` with one column of F for each input. Reduced to the modes found,
//! `x = Φ q`, they lack the share of all higher modes, which follows loads nearly statically: displacements at loaded points
//! and anti-resonances are wrong however exact the modes are. The static response to what the modes leave of the loads,
//! `A⁻¹ (F − M Φ Φᵀ F)`, is therefore added to the basis (residual vectors; J. M. Dickens, J. M. Nakagawa, M. J. Wittbrodt, *A critique
//! of mode acceleration and modal truncation augmentation methods for modal response analysis*, Comput. Struct. 62 (1997) 985–998), made
//! orthogonal to the modes and diagonal by a small eigenvalue problem. Residual vectors then look like modes of high frequency. All
//! vectors are orthonormal with M.

use nalgebra::{Complex, DMatrix, DVector};
use tegula_sparse::Factor as _;
use tegula_sparse::norm::larger;

use super::problem::Problem;
use super::{Mode, dot};
use crate::element::{Nodal, TangentWeights};
use crate::model::ModalAnalysis;
use crate::system::assembly::TangentCoefficients;
use crate::{Error, Result, Vec3};

/// Part of a vector that must be left when its share of the basis is taken away.
const INDEPENDENT: f64 = 1e-8;
/// Part of the strain energy of the static response, that without joints included, below which a residual vector is round-off: joints
/// may balance all that the modes leave of a load.
const NEGLIGIBLE: f64 = 1e-12;

/// Model reduced to its modes and residual vectors: `q̈ + D q̇ + Λ q = B u`, with the displacements `x = Σ qⱼ φⱼ`.
#[derive(Debug, Clone, PartialEq)]
pub struct ReducedModel {
    /// Squares λ of the circular frequencies of the coordinates, those of rigid modes 0 [1/time²].
    pub lambdas: Vec<f64>,
    /// Number of modes; the coordinates behind them belong to residual vectors.
    pub modes: usize,
    /// Damping matrix D [1/time].
    pub damping: DMatrix<f64>,
    /// Input matrix B: a column for each input.
    pub input: DMatrix<f64>,
    /// Names of the inputs.
    pub names: Vec<String>,
    /// Displacements φ of all nodal vectors for a coordinate of 1.
    pub shapes: Vec<Vec<Nodal>>,
}

impl ReducedModel {
    /// Complex amplitudes of the coordinates under an input `cos ωt` in the steady state, `q(t) = Re(q exp(iωt))`; they are not finite
    /// at a resonance without damping.
    pub fn response(&self, omega: f64, input: usize) -> DVector<Complex<f64>> {
        let n = self.lambdas.len();
        let entry = |i: usize, j: usize| {
            let stiffness = if i == j { self.lambdas[i] - omega * omega } else { 0.0 };
            Complex::new(stiffness, omega * self.damping[(i, j)])
        };
        let force = DVector::from_fn(n, |i, _| Complex::from(self.input[(i, input)]));
        let none = || DVector::from_element(n, Complex::from(f64::NAN));
        DMatrix::from_fn(n, n, entry).lu().solve(&force).unwrap_or_else(none)
    }

    /// Damping ratio of a coordinate; 0 for rigid modes.
    pub fn damping_ratio(&self, coordinate: usize) -> f64 {
        let lambda = self.lambdas[coordinate];
        if lambda > 0.0 { self.damping[(coordinate, coordinate)] / (2.0 * lambda.sqrt()) } else { 0.0 }
    }
}

/// Vector of the basis in the free degrees of freedom, with its products.
struct BasisVector {
    x: Vec<f64>,
    /// M x
    m_x: Vec<f64>,
    /// C x
    c_x: Vec<f64>,
    /// K x; of a mode λ M x.
    k_x: Vec<f64>,
    lambda: f64,
}

/// Reduction of a model that is under way.
pub(super) struct Reduction<'p, 'a> {
    pub problem: &'p mut Problem<'a>,
    basis: Vec<BasisVector>,
    modes: usize,
    /// Damping matrix C: values in the pattern of the tangent.
    damping: Vec<f64>,
    damping_ratio: f64,
    /// Loads of the inputs in the free degrees of freedom.
    forces: Vec<Vec<f64>>,
    names: Vec<String>,
}

impl<'p, 'a> Reduction<'p, 'a> {
    /// Reduces a model to its modes and the residual vectors of its inputs.
    ///
    /// # Errors
    /// A mode is unstable, or the shifted matrix cannot be factored again.
    pub fn new(problem: &'p mut Problem<'a>, analysis: &ModalAnalysis, modes: &[Mode]) -> Result<Self> {
        if let Some(unstable) = modes.iter().find(|mode| mode.omega < 0.0) {
            return Err(Error::Singular {
                what: format!(
                    "The equilibrium is unstable (a mode has ω² = −{:.4e}): there is no steady response about it.",
                    unstable.omega * unstable.omega
                ),
                help: "Check loads and supports.".into(),
            });
        }
        if !problem.factor_shifted() {
            return Err(Error::Outside("the shifted matrix changed between two factorisations".into()));
        }
        let damping = damping_matrix(problem);
        let forces = (0..problem.system.inputs.len()).map(|input| force(problem, input)).collect();
        let mut out = Self {
            basis: Vec::new(),
            modes: modes.len(),
            damping,
            damping_ratio: analysis.damping_ratio,
            forces,
            names: analysis.inputs.iter().map(|input| input.name.clone()).collect(),
            problem,
        };
        for mode in modes {
            let mut x = vec![0.0; out.problem.pattern.size()];
            out.problem.newton.assembly.frames.components(&mode.shape, &mut x);
            let lambda = mode.omega * mode.omega;
            let vector = out.vector(x, Some(lambda));
            out.basis.push(vector);
        }
        for input in 0..out.forces.len() {
            out.add_residual_vector(input);
        }
        out.diagonalize();
        Ok(out)
    }

    /// Vector with its products; `lambda` is given for modes.
    fn vector(&self, x: Vec<f64>, lambda: Option<f64>) -> BasisVector {
        let product = |matrix: &[f64]| {
            let mut out = vec![0.0; x.len()];
            self.problem.pattern.add_product(matrix, &x, &mut out);
            out
        };
        let m_x = product(&self.problem.mass);
        let k_x = match lambda {
            Some(lambda) => m_x.iter().map(|m| lambda * m).collect(),
            None => product(&self.problem.stiffness),
        };
        BasisVector { c_x: product(&self.damping), lambda: lambda.unwrap_or(f64::NAN), x, m_x, k_x }
    }

    /// Static response to the part of a load that the basis leaves, unless it is round-off.
    fn add_residual_vector(&mut self, input: usize) {
        if self.is_complete() {
            return;
        }
        let mut rest = self.forces[input].clone();
        let mut energy = 0.0;
        for vector in &self.basis {
            let share = dot(&vector.x, &self.forces[input]);
            // A rigid motion counts as one of the softest degree of freedom.
            let lowest = self.problem.groups.iter().map(|group| group.lowest).reduce(f64::min).unwrap_or(0.0);
            energy += share * share / larger(vector.lambda, lowest);
            add(-share, &vector.m_x, &mut rest);
        }
        let mut without_joints = rest.clone();
        self.problem.newton.solver.solve(&mut without_joints);
        let response = self.inverse(&rest);
        let whole = energy + dot(&rest, &without_joints).abs();
        if dot(&rest, &response) > NEGLIGIBLE * whole {
            self.add(response);
        }
    }

    /// Static response `A⁻¹ f` that keeps the joints closed, without its share of the rigid modes.
    pub fn inverse(&mut self, force: &[f64]) -> Vec<f64> {
        let mut out = force.to_vec();
        self.problem.newton.solver.solve(&mut out);
        self.problem.constrain(&mut out);
        self.problem.groups.iter().for_each(|group| group.project(&mut out));
        self.problem.applications += 1;
        out
    }

    /// Whether the basis spans all motions that supports and joints leave.
    pub fn is_complete(&self) -> bool {
        let groups = &self.problem.groups;
        let all: usize = (0..groups.len()).map(|group| self.problem.modes_of(group)).sum();
        self.basis.len() >= all + groups.iter().map(|group| group.rigid.len()).sum::<usize>()
    }

    /// Adds what a vector has beyond the basis; false where that is nothing. [`diagonalize`](Self::diagonalize) has to follow.
    pub fn add(&mut self, mut x: Vec<f64>) -> bool {
        let others = self.basis.iter().map(|vector| (vector.x.as_slice(), vector.m_x.as_slice()));
        if !self.problem.orthonormalize(&mut x, others, INDEPENDENT) {
            return false;
        }
        let vector = self.vector(x, None);
        self.basis.push(vector);
        true
    }

    /// Makes the stiffness of the residual vectors diagonal.
    pub fn diagonalize(&mut self) {
        let residual = &self.basis[self.modes..];
        let n = residual.len();
        if n == 0 {
            return;
        }
        let stiffness = DMatrix::from_fn(n, n, |i, j| {
            0.5 * (dot(&residual[i].x, &residual[j].k_x) + dot(&residual[j].x, &residual[i].k_x))
        });
        let eigen = stiffness.symmetric_eigen();
        let mut order: Vec<usize> = (0..n).collect();
        order.sort_by(|&a, &b| eigen.eigenvalues[a].total_cmp(&eigen.eigenvalues[b]));
        let turned = order.iter().map(|&column| {
            let sum = |part: fn(&BasisVector) -> &[f64]| {
                let mut out = vec![0.0; part(&residual[0]).len()];
                for (i, vector) in residual.iter().enumerate() {
                    add(eigen.eigenvectors[(i, column)], part(vector), &mut out);
                }
                out
            };
            BasisVector {
                x: sum(|v| &v.x),
                m_x: sum(|v| &v.m_x),
                c_x: sum(|v| &v.c_x),
                k_x: sum(|v| &v.k_x),
                lambda: eigen.eigenvalues[column],
            }
        });
        let turned: Vec<BasisVector> = turned.collect();
        self.basis.truncate(self.modes);
        self.basis.extend(turned);
    }

    /// The reduced model of the present basis, without shapes.
    pub fn reduced(&self) -> ReducedModel {
        let n = self.basis.len();
        let lambdas: Vec<f64> = self.basis.iter().map(|vector| vector.lambda).collect();
        let modal = |i: usize| 2.0 * self.damping_ratio * lambdas[i].max(0.0).sqrt();
        let damping = DMatrix::from_fn(n, n, |i, j| {
            let own = if i == j { modal(i) } else { 0.0 };
            own + 0.5
                * (dot(&self.basis[i].x, &self.basis[j].c_x) + dot(&self.basis[j].x, &self.basis[i].c_x))
        });
        let input = DMatrix::from_fn(n, self.forces.len(), |i, j| dot(&self.basis[i].x, &self.forces[j]));
        ReducedModel {
            modes: self.modes,
            damping,
            input,
            names: self.names.clone(),
            shapes: Vec::new(),
            lambdas,
        }
    }

    /// The reduced model with its shapes.
    pub fn finish(self) -> ReducedModel {
        let frames = &self.problem.newton.assembly.frames;
        let shape = |vector: &BasisVector| {
            let mut shape = vec![[0.0; 3]; self.problem.system.vectors()];
            frames.expand(&vector.x, &mut shape);
            shape
        };
        let shapes = self.basis.iter().map(shape).collect();
        ReducedModel { shapes, ..self.reduced() }
    }

    /// Real and imaginary part of the forces that the response q to an input leaves unbalanced,
    /// `F − (K + iωC − ω²M) Σ qⱼ φⱼ`.
    pub fn unbalanced(&self, omega: f64, input: usize, q: &DVector<Complex<f64>>) -> [Vec<f64>; 2] {
        let mut re = self.forces[input].clone();
        let mut im = vec![0.0; re.len()];
        for (vector, q) in self.basis.iter().zip(q.iter()) {
            let modal = 2.0 * self.damping_ratio * vector.lambda.max(0.0).sqrt();
            let of_mass = q * Complex::new(-omega * omega, omega * modal);
            let of_damping = q * Complex::new(0.0, omega);
            for (factor, product) in [(*q, &vector.k_x), (of_mass, &vector.m_x), (of_damping, &vector.c_x)] {
                add(-factor.re, product, &mut re);
                add(-factor.im, product, &mut im);
            }
        }
        [re, im]
    }
}

/// Damping matrix C about the state: of materials, springs and foundations, and in proportion to the mass.
fn damping_matrix(problem: &mut Problem) -> Vec<f64> {
    let system = problem.system;
    let rates =
        TangentWeights { stress: 0.0, direction: 0.0, rate: 1.0, multiplier: 0.0, ..TangentWeights::STATIC };
    let state = problem.state.clone();
    let parts = TangentCoefficients { weights: rates, mass: system.mass_damping, time: state.time };
    let mut internal = vec![[0.0; 3]; system.vectors()];
    let assembly = &mut problem.newton.assembly;
    assembly.forces_and_tangent(system, &state.point(system), &parts, false, None, &mut internal);
    assembly.values.clone()
}

/// Loads of an input at the state, in the free degrees of freedom.
fn force(problem: &Problem, input: usize) -> Vec<f64> {
    let system = problem.system;
    let mut field = vec![[0.0; 3]; system.vectors()];
    let range = &system.inputs[input];
    let dead = system.dead_loads.iter().zip(&system.load_of_dead);
    for (load, _) in dead.filter(|(_, of)| range.contains(of)) {
        for (out, f) in field.as_flattened_mut().iter_mut().zip(load.force.as_flattened()) {
            *out += f;
        }
    }
    let at = |v: u32| {
        let v = v as usize;
        Vec3::from(system.coordinates.reference[v]) + Vec3::from(problem.state.u[v])
    };
    let followers = system.followers.iter().zip(&system.load_of_follower);
    for (load, _) in followers.filter(|(_, of)| range.contains(of)) {
        let x: Vec<Vec3> = load.vectors().iter().map(|&v| at(v)).collect();
        let mut f = vec![[0.0; 3]; x.len()];
        load.forces(&x, &mut f);
        for (&v, f) in load.vectors().iter().zip(f) {
            (0..3).for_each(|i| field[v as usize][i] += f[i]);
        }
    }
    let mut out = vec![0.0; problem.pattern.size()];
    problem.newton.assembly.frames.reduce(&field, &mut out);
    out
}

fn add(factor: f64, x: &[f64], out: &mut [f64]) {
    out.iter_mut().zip(x).for_each(|(out, x)| *out += factor * x);
}
