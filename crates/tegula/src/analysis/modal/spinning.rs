//! Modes of a model that turns at a constant angular velocity, about its relative equilibrium.
//!
//! In the frame that turns with the model, with the generator A of the rotation ([`crate::load::CentrifugalLoad`]), small motions satisfy
//!
//! ```text
//! M ü + 2 M A u̇ + (K + M A²) u = 0,
//! ```
//!
//! where K is the tangent at the equilibrium under centrifugal forces, whose stiffness is M A². The gyroscopic matrix `G = 2 M A` is skew: the
//! eigenvalues λ of `λ² M + λ G + K` come in pairs ±iω, or in such with a growth. They are found by Davidson's method (E. R. Davidson,
//! J. Comput. Phys. 17 (1975) 87–94): the problem is projected onto a real basis, of the modes without G at first, which grows by
//! the residuals `P⁻¹ (λ² M + λ G + K) u`, with the positive definite `P = K − σM` that the shift-and-invert of these modes factors. The
//! projected problem keeps the symmetries; its eigenvalues are those of the inverse of its linearisation next to a real λ₀.
//! F. Tisseur, K. Meerbergen, *The quadratic eigenvalue problem*, SIAM Review 43 (2001) 235–286.

use nalgebra::{Complex, DMatrix, DVector, Schur};

use super::problem::{Problem, go_on};
use super::{ModalOutcome, Mode, isotropy, lowest_modes};
use crate::analysis::{Observer, State, Statistics, Step};
use crate::element::Nodal;
use crate::norm::larger;
use crate::system::{System, VectorKind};
use crate::{Error, Result, Vec3};
use tegula_sparse::Factor as _;

/// Size of a preconditioned residual over that of its mode at which the mode is found.
const FOUND: f64 = 1e-8;
/// Residual at which a mode is taken where round-off stops the iteration; its eigenvalue has the square of this error.
const TAKEN: f64 = 1e-6;
/// Size of a new vector behind its projection, over that before, below which the basis has it.
const DEPENDENT: f64 = 1e-10;
/// Modes of the first basis beyond twice the wanted ones; vectors of the basis, over the wanted modes, beyond which it starts anew.
const MORE: usize = 6;
const MOST_VECTORS: usize = 16;
/// Most growths of the basis.
const MOST_ROUNDS: usize = 200;
/// Most growths of the basis one after another that do not halve the largest residual.
const MOST_STAGNATIONS: u32 = 20;
/// Eigenvalue over the real shift λ₀ below which it is zero: that of the free rotation is double, and known to the root of round-off.
const ZERO: f64 = 1e-6;
/// Difference of eigenvalues over their size below which they belong to one space.
const CLUSTER: f64 = 1e-6;
/// Part of the motion across the axis that turns in one sense, from which on the mode whirls in this sense; and least part of the
/// motion across the axis in the whole one.
const PURE: f64 = 0.99;
const ACROSS: f64 = 1e-6;
/// Distance from the axis over the size of the model from which on a point is beside it.
const BESIDE: f64 = 1e-3;

/// Rotation of the model about an axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Spin {
    /// Direction of the axis, of length 1.
    pub axis: Vec3,
    /// Point of the axis (length).
    pub at: Vec3,
    /// Angular velocity [rad/time].
    pub omega: f64,
    /// Whether the ground turns with the model.
    pub with_ground: bool,
}

impl Spin {
    /// Rotation of a model with centrifugal loads at a time.
    pub fn of(system: &System, time: f64) -> Option<Self> {
        let first = system.centrifugal.first()?;
        let square =
            |load: &crate::load::CentrifugalLoad| system.factor(&load.factor, time) * load.velocity.powi(2);
        let sum: f64 = system.centrifugal.iter().map(square).sum();
        let omega = sum.max(0.0).sqrt() * first.velocity.signum();
        Some(Self { axis: first.axis, at: first.at, omega, with_ground: first.with_ground })
    }
}

/// Complex part of a mode of a turning model, beyond its real shape. The motion is `Re[(shape + i quadrature) e^{(growth + iω) t}]` in the frame that
/// turns with the model.
#[derive(Debug, Clone, PartialEq)]
pub struct Whirl {
    /// Angular velocity of the model [rad/time].
    pub speed: f64,
    /// Growth rate [1/time]; 0 for a motion that stays bounded.
    pub growth: f64,
    /// Shape a quarter period earlier.
    pub quadrature: Vec<Nodal>,
    /// Circular frequency in the fixed frame [rad/time], negative for backward whirl, against the rotation; `None` for motions that are no whirl in
    /// one sense.
    pub fixed_frame: Option<f64>,
}

/// A complex vector of free degrees of freedom.
type Pair = [Vec<f64>; 2];

/// The basis, with the products of its vectors with K, M and G.
struct Basis {
    vectors: Vec<Vec<f64>>,
    products: [Vec<Vec<f64>>; 3],
}

/// An eigenvalue with its vector.
struct Found {
    lambda: Complex<f64>,
    vector: Pair,
    residual: f64,
}

/// Finds the `wanted` lowest modes about a relative equilibrium.
///
/// # Errors
/// As for [`super::run`], or the iteration does not find the modes.
pub(super) fn modes(
    problem: &mut Problem,
    (wanted, spin): (usize, Spin),
    equilibrium: Option<&State>,
    observer: &mut dyn Observer,
) -> Result<ModalOutcome> {
    let system = problem.system;
    if system.mass_damping != 0.0 || system.has_rate_damping() {
        observer.on_warning(
            "modes about a relative equilibrium leave dampers and the damping of materials out: growth and stability are those without them",
        );
    }
    // Centrifugal forces soften by no more than Ω² M.
    problem.softening = spin.omega * spin.omega;
    let (real, _) = lowest_modes(problem, 2 * wanted + MORE, equilibrium, &mut Quiet(observer))?;
    if wanted > real.modes.len() {
        observer.on_event(&format!(
            "{wanted} modes are wanted, but supports and joints leave the model {} only",
            real.modes.len()
        ));
    }
    let wanted = wanted.min(real.modes.len());
    let lowest =
        real.modes.iter().map(|mode| mode.omega).filter(|omega| *omega > 0.0).fold(f64::INFINITY, f64::min);
    let scale = if lowest.is_finite() { lowest.hypot(spin.omega) } else { spin.omega.abs() };
    if problem.factor(|_| -scale * scale) != Some(0) {
        return Err(Error::Singular {
            what: "The stiffness of the turning model is not positive definite beside its inertia.".into(),
            help: "Check loads, supports and the angular velocity.".into(),
        });
    }
    if !spin.with_ground {
        isotropy::refuse(problem, &spin)?;
    }
    let mut basis = Basis::new();
    let mut free = vec![0.0; problem.pattern.size()];
    for mode in &real.modes {
        problem.newton.assembly.frames.components(&mode.shape, &mut free);
        basis.add(problem, &spin, free.clone());
    }
    let found = iterate(problem, basis, &spin, (wanted, scale), observer)?;
    let modes: Vec<Mode> = found.iter().map(|mode| whirl(problem, &spin, mode, scale)).collect();
    let grows = |mode: &&Mode| mode.whirl.as_ref().is_some_and(|whirl| whirl.growth > 0.0);
    if let Some(unstable) = modes.iter().find(grows) {
        observer.on_warning(&format!(
            "the model that turns at {} is unstable: a motion of the circular frequency {} grows, see `growth` in the table of modes",
            spin.omega, unstable.omega
        ));
    }
    let statistics = Statistics {
        steps: wanted as u64,
        iterations: problem.applications,
        factorizations: problem.newton.solver.factorizations() as u64,
        ..Statistics::default()
    };
    Ok(ModalOutcome { modes, statistics, sturm_checked: false })
}

/// Enlarges the basis by the residuals of its lowest eigenvectors until these are found; `scale` is a circular frequency of their size.
///
/// # Errors
/// The residuals stay, or the user interrupts.
fn iterate(
    problem: &mut Problem,
    mut basis: Basis,
    spin: &Spin,
    (wanted, scale): (usize, f64),
    observer: &mut dyn Observer,
) -> Result<Vec<Found>> {
    let mut found = Vec::new();
    let (mut least, mut stagnates) = (f64::INFINITY, 0);
    for _ in 0..MOST_ROUNDS {
        go_on(observer)?;
        found = basis.eigenvectors(wanted, scale);
        let mut residuals = Vec::new();
        for mode in &mut found {
            let residual = basis.residual(problem, mode);
            if !(mode.residual <= FOUND) {
                residuals.push(residual);
            }
        }
        if residuals.is_empty() {
            break;
        }
        if basis.vectors.len() > MOST_VECTORS * wanted {
            basis = Basis::new();
            for vector in found.iter().flat_map(|mode| &mode.vector) {
                basis.add(problem, spin, vector.clone());
            }
        }
        let before = basis.vectors.len();
        for vector in residuals.into_iter().flatten() {
            basis.add(problem, spin, vector);
        }
        let worst = found.iter().map(|mode| mode.residual).fold(0.0, larger);
        stagnates = if worst < 0.5 * least { 0 } else { stagnates + 1 };
        least = if worst < least { worst } else { least };
        if basis.vectors.len() == before || stagnates > MOST_STAGNATIONS {
            break;
        }
    }
    if let Some(worst) =
        found.iter().map(|mode| mode.residual).reduce(larger).filter(|worst| !(*worst <= TAKEN))
    {
        return Err(Error::NotConverged {
            at: format!("an angular velocity of {}", spin.omega),
            reason: format!("the residual of a mode is {worst:.1e}"),
            help: "Ask for a few modes more or less. A model that may move freely across the axis has double eigenvalues, which are not found: \
                   support it."
                .into(),
        });
    }
    Ok(found)
}

/// Observer of the modes without Coriolis forces, whose number is not the one that is wanted.
struct Quiet<'a>(&'a mut dyn Observer);

impl Observer for Quiet<'_> {
    fn on_step(&mut self, _: &Step) -> Result<()> {
        Ok(())
    }

    fn on_warning(&mut self, message: &str) {
        self.0.on_warning(message);
    }

    fn interrupted(&self) -> bool {
        self.0.interrupted()
    }
}

impl Basis {
    fn new() -> Self {
        Self { vectors: Vec::new(), products: Default::default() }
    }

    /// Adds a vector, orthogonal in the mass to all others, unless these contain it.
    fn add(&mut self, problem: &mut Problem, spin: &Spin, mut x: Vec<f64>) {
        let norm = |problem: &Problem, x: &[f64]| dot(x, &times(problem, &problem.mass, x)).max(0.0).sqrt();
        for _ in 0..2 {
            let before = norm(problem, &x);
            for (v, m) in self.vectors.iter().zip(&self.products[1]) {
                let part = dot(m, &x);
                x.iter_mut().zip(v).for_each(|(x, v)| *x -= part * v);
            }
            let size = norm(problem, &x);
            if !(size > DEPENDENT * before) {
                return;
            }
            x.iter_mut().for_each(|x| *x /= size);
        }
        self.products[0].push(times(problem, &problem.stiffness, &x));
        self.products[1].push(times(problem, &problem.mass, &x));
        self.products[2].push(gyroscopic(problem, spin, &x));
        self.vectors.push(x);
    }

    /// Eigenvalues next to zero of the projected problem, with non-negative imaginary parts, and their vectors.
    fn eigenvectors(&self, wanted: usize, scale: f64) -> Vec<Found> {
        let n = self.vectors.len();
        let projected =
            |products: &[Vec<f64>]| DMatrix::from_fn(n, n, |i, j| dot(&self.vectors[i], &products[j]));
        let [k, m, g] = [&self.products[0], &self.products[1], &self.products[2]].map(|list| projected(list));
        let k = (&k + k.transpose()) * (0.5 / (scale * scale));
        let g = (&g - g.transpose()) * (0.5 / scale);
        let shifted = (&m + &g + &k).lu();
        let solved = |a: &DMatrix<f64>| shifted.solve(a).unwrap_or_else(|| a * f64::NAN);
        let mut inverse = DMatrix::zeros(2 * n, 2 * n);
        inverse.view_mut((0, 0), (n, n)).copy_from(&-solved(&(&m * 2.0 + &g)));
        inverse.view_mut((0, n), (n, n)).copy_from(&-solved(&m));
        inverse.view_mut((n, 0), (n, n)).fill_with_identity();
        let Some(schur) = Schur::try_new(inverse, f64::EPSILON, 10_000) else { return Vec::new() };
        let mut values: Vec<Complex<f64>> = schur
            .complex_eigenvalues()
            .iter()
            .map(|theta| theta.inv() + 1.0)
            .map(|mu| if mu.im.abs() <= ZERO * mu.norm() { mu.re.into() } else { mu })
            .filter(|mu| if mu.im == 0.0 { mu.re > 0.0 } else { mu.im > 0.0 })
            .collect();
        values.sort_by(|a, b| a.norm().total_cmp(&b.norm()));
        values.truncate(wanted);
        let quadratic = |mu: Complex<f64>| {
            DMatrix::from_fn(n, n, |i, j| mu * mu * m[(i, j)] + mu * g[(i, j)] + k[(i, j)])
        };
        let mut found: Vec<(Complex<f64>, DVector<Complex<f64>>)> = Vec::new();
        for (number, mu) in values.into_iter().enumerate() {
            let near = quadratic(mu + Complex::new(1e-10, 1e-10) * larger(mu.norm(), ZERO)).lu();
            let start = |i: usize| ((i + 1) * (number + 1)) as f64;
            let mut x = DVector::from_fn(n, |i, _| Complex::new(start(i).sin(), (2.0 * start(i)).cos()));
            for _ in 0..3 {
                for (_, y) in
                    found.iter().filter(|(other, _)| (other - mu).norm() <= CLUSTER * larger(mu.norm(), ZERO))
                {
                    let part = y.dotc(&x);
                    x.axpy(-part, y, Complex::new(1.0, 0.0));
                }
                x = near.solve(&x).unwrap_or_else(|| x.clone() * Complex::new(f64::NAN, 0.0));
                x.unscale_mut(x.norm());
            }
            found.push((refined(mu, &x, [&k, &m, &g]), x));
        }
        let combined = |part: &dyn Fn(&Complex<f64>) -> f64, x: &DVector<Complex<f64>>| {
            let mut out = vec![0.0; self.vectors[0].len()];
            for (v, y) in self.vectors.iter().zip(x.iter()) {
                out.iter_mut().zip(v).for_each(|(out, v)| *out += part(y) * v);
            }
            out
        };
        let of = |(mu, x): (Complex<f64>, DVector<Complex<f64>>)| Found {
            lambda: mu * scale,
            vector: [combined(&|y| y.re, &x), combined(&|y| y.im, &x)],
            residual: f64::NAN,
        };
        found.into_iter().map(of).collect()
    }

    /// Preconditioned residual of a mode, whose size over that of the mode is kept.
    fn residual(&self, problem: &mut Problem, mode: &mut Found) -> Pair {
        let Complex { re, im } = mode.lambda;
        let square = mode.lambda * mode.lambda;
        // Products of the mode are combined from those of the basis.
        let weights = |x: &[f64]| -> Vec<f64> { self.products[1].iter().map(|m| dot(m, x)).collect() };
        let [real, imaginary] = [weights(&mode.vector[0]), weights(&mode.vector[1])];
        let product = |list: &[Vec<f64>], weights: &[f64]| {
            let mut out = vec![0.0; mode.vector[0].len()];
            for (p, w) in list.iter().zip(weights) {
                out.iter_mut().zip(p).for_each(|(out, p)| *out += w * p);
            }
            out
        };
        let [k, m, g] = [0, 1, 2].map(|i| [&real, &imaginary].map(|w| product(&self.products[i], w)));
        let mut out: Pair = [k[0].clone(), k[1].clone()];
        for i in 0..out[0].len() {
            out[0][i] += square.re * m[0][i] - square.im * m[1][i] + re * g[0][i] - im * g[1][i];
            out[1][i] += square.re * m[1][i] + square.im * m[0][i] + re * g[1][i] + im * g[0][i];
        }
        for part in &mut out {
            problem.newton.solver.solve(part);
            problem.constrain(part);
            problem.applications += 1;
        }
        let size = |x: &Pair| {
            x.iter().map(|x| dot(x, &times(problem, &problem.mass, x))).sum::<f64>().max(0.0).sqrt()
        };
        mode.residual = size(&out) / size(&mode.vector);
        out
    }
}

/// Root of `uᴴ(μ² M + μ G + K)u` next to an eigenvalue of a bounded motion, which is purely imaginary: in its vector it is stationary.
fn refined(mu: Complex<f64>, u: &DVector<Complex<f64>>, [k, m, g]: [&DMatrix<f64>; 3]) -> Complex<f64> {
    if mu.im == 0.0 || mu.re.abs() > ZERO * mu.norm() {
        return mu;
    }
    let form = |a: &DMatrix<f64>| {
        let complex = a.map(|x| Complex::new(x, 0.0));
        u.dotc(&(complex * u))
    };
    let (k, m, g) = (form(k).re, form(m).re, form(g).im);
    // With μ = iν: m ν² + g ν − k = 0.
    let discriminant = Complex::new(g * g + 4.0 * m * k, 0.0).sqrt();
    let root = |sign: f64| Complex::new(0.0, 1.0) * (discriminant * sign - g) / (2.0 * m);
    let [first, second] = [root(1.0), root(-1.0)];
    if (first - mu).norm() <= (second - mu).norm() { first } else { second }
}

/// `G x = 2 M A x` in the free degrees of freedom.
fn gyroscopic(problem: &Problem, spin: &Spin, x: &[f64]) -> Vec<f64> {
    let Problem { system, newton, .. } = problem;
    let frames = &newton.assembly.frames;
    let mut field = vec![[0.0; 3]; system.vectors()];
    frames.expand(x, &mut field);
    for v in &mut field {
        *v = (spin.axis.cross(&Vec3::from(*v)) * spin.omega).into();
    }
    let (mut forces, mut out) = (vec![[0.0; 3]; field.len()], vec![0.0; x.len()]);
    system.pattern.add_mass_product(2.0, &field, &mut forces);
    frames.reduce(&forces, &mut out);
    out
}

fn times(problem: &Problem, matrix: &[f64], x: &[f64]) -> Vec<f64> {
    let mut out = vec![0.0; x.len()];
    problem.pattern.add_product(matrix, x, &mut out);
    out
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Mode of unit modal mass, whose quadrature is the smallest.
fn whirl(problem: &Problem, spin: &Spin, found: &Found, scale: f64) -> Mode {
    let Problem { system, newton, .. } = problem;
    let [x, y] = &found.vector;
    let m = |a: &[f64], b: &[f64]| dot(a, &times(problem, &problem.mass, b));
    let size = (m(x, x) + m(y, y)).sqrt();
    let phase = -0.5 * (2.0 * m(x, y)).atan2(m(x, x) - m(y, y));
    let turned = |[a, b]: [f64; 2]| -> Vec<Nodal> {
        let free: Vec<f64> = x.iter().zip(y).map(|(x, y)| (a * x + b * y) / size).collect();
        let mut field = vec![[0.0; 3]; system.vectors()];
        newton.assembly.frames.expand(&free, &mut field);
        field
    };
    let (sine, cosine) = phase.sin_cos();
    let (shape, quadrature) = (turned([cosine, -sine]), turned([sine, cosine]));
    let rigid = found.lambda.norm() <= ZERO * scale;
    let lambda = if rigid { Complex::new(0.0, 0.0) } else { found.lambda };
    let fixed_frame = fixed_frame(problem, spin, [&shape, &quadrature], lambda.im);
    Mode {
        frequency_hz: lambda.im / std::f64::consts::TAU,
        omega: lambda.im,
        rigid,
        residual: found.residual,
        shape,
        whirl: Some(Whirl { speed: spin.omega, growth: lambda.re, quadrature, fixed_frame }),
    }
}

/// Circular frequency in the fixed frame of a motion that whirls in one sense. With the axes e₁, e₂ across the axis of rotation the motion
/// is `Z = a e^{iωt} + b e^{−iωt}`, Z = u₁ + i u₂, to which the rotation adds the factor `e^{iΩt}`. Displacements count, and rotations of bodies.
fn fixed_frame(problem: &Problem, spin: &Spin, shape: [&[Nodal]; 2], omega: f64) -> Option<f64> {
    let Problem { system, newton, .. } = problem;
    let first = spin.axis.cross(&Vec3::ith(spin.axis.iamin(), 1.0)).normalize();
    let axes = [first, spin.axis.cross(&first), spin.axis];
    let [mut forward, mut backward, mut along] = [0.0; 3];
    // Motions along the axis of points beside it: sums, sum of squares, number.
    let mut beside = [0.0; 4];
    let mut count = |motion: [Vec3; 2]| {
        let [x, y] = motion.map(|u| axes.map(|e| e.dot(&u)));
        // a = (u₁ + i u₂)/2 and b* = (u₁ − i u₂)/2 with the complex amplitudes u = x + i y.
        forward += (x[0] - y[1]).powi(2) + (y[0] + x[1]).powi(2);
        backward += (x[0] + y[1]).powi(2) + (y[0] - x[1]).powi(2);
        along += x[2].powi(2) + y[2].powi(2);
    };
    for v in (0..system.vectors()).filter(|v| system.coordinates.kinds[*v] == VectorKind::Position) {
        let motion = shape.map(|field| Vec3::from(field[v]));
        count(motion);
        let arm = Vec3::from(system.coordinates.reference[v]) + Vec3::from(problem.state.u[v]) - spin.at;
        if spin.axis.cross(&arm).norm() > BESIDE * system.length {
            let [x, y] = motion.map(|u| spin.axis.dot(&u));
            for (sum, term) in beside.iter_mut().zip([x, y, x * x + y * y, 1.0]) {
                *sum += term;
            }
        }
    }
    for (directors, arms) in newton.assembly.frames.triads() {
        let turned = |field: &[Nodal]| {
            let parts = (0..3).map(|i| arms.column(i).cross(&Vec3::from(field[directors[i] as usize])));
            parts.sum::<Vec3>() * (0.5 * system.length)
        };
        count(shape.map(turned));
    }
    let across = forward + backward;
    let [x, y, squares, number] = beside;
    // Nodal diameters: the pattern around the axis, which turns with the model, decides about the frequency.
    let uniform = x * x + y * y >= PURE * number * squares;
    if squares > (1.0 - PURE) * (across + along) && !uniform {
        return None;
    }
    let whirls = across > ACROSS * (across + along);
    let turn = spin.omega.abs();
    match whirls {
        false => Some(omega),
        true if forward >= PURE * across => Some(turn + spin.omega.signum() * omega),
        true if backward >= PURE * across => Some(turn - spin.omega.signum() * omega),
        true => None,
    }
}
