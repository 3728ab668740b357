//! Complex modes: of models that turn, and under follower loads without a potential.
//!
//! Small motions about an equilibrium satisfy
//!
//! ```text
//! M ü + G u̇ + (K + N) u = 0
//! ```
//!
//! with the skew gyroscopic matrix G of a model that [turns](super::spinning) and the skew [circulatory](super::circulatory) stiffness N. The
//! eigenvalues λ of `λ² M + λ G + K + N` come in pairs ±iω, or in such with a growth: vibrations that grow (flutter), or, with ω = 0, motions
//! away from the equilibrium (divergence). They are found by Davidson's method (E. R. Davidson,
//! J. Comput. Phys. 17 (1975) 87–94): the problem is projected onto a real basis, of the modes without G and N at first, which grows by
//! the residuals `P⁻¹ (λ² M + λ G + K + N) u`, with the positive definite `P = K − σM` that the shift-and-invert of these modes factors. The
//! projected problem keeps the symmetries; its eigenvalues are those of the inverse of its linearisation next to a real λ₀.
//! F. Tisseur, K. Meerbergen, *The quadratic eigenvalue problem*, SIAM Review 43 (2001) 235–286.

use nalgebra::{Complex, DMatrix, DVector};

use super::problem::{Problem, go_on};
use super::spinning::{Spin, fixed_frame, gyroscopic};
use super::{ModalOutcome, Mode, dot, isotropy, lowest_modes};
use crate::analysis::{Observer, Statistics, Step};
use crate::element::Nodal;
use crate::norm::larger;
use crate::system::CirculatoryStiffness;
use crate::{Error, Result};
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
/// Most doublings of the shift of the preconditioner.
const MOST_DOUBLINGS: u32 = 12;
/// Most growths of the basis.
const MOST_ROUNDS: usize = 200;
/// Most growths of the basis one after another that do not halve the largest residual.
const MOST_STAGNATIONS: u32 = 20;
/// Eigenvalue over the real shift λ₀ below which it is zero: that of the free rotation is double, and known to the root of round-off.
const ZERO: f64 = 1e-6;
/// Difference of eigenvalues over their size below which they belong to one space.
const CLUSTER: f64 = 1e-6;
/// Complex part of a mode of a model that turns or has follower loads without a potential, beyond its real shape. The motion is
/// `Re[(shape + i quadrature) e^{(growth + iω) t}]`, in the frame that turns with the model.
#[derive(Debug, Clone, PartialEq)]
pub struct ComplexPart {
    /// Angular velocity of the model [rad/time]; 0 for a model that does not turn.
    pub speed: f64,
    /// Growth rate [1/time]; 0 for a motion that stays bounded.
    pub growth: f64,
    /// Shape a quarter period earlier.
    pub quadrature: Vec<Nodal>,
    /// Circular frequency in the fixed frame [rad/time], negative for backward whirl, against the rotation; `None` for motions that are no whirl in
    /// one sense, and of models that do not turn.
    pub fixed_frame: Option<f64>,
}

/// Skew matrices beside mass and stiffness.
#[derive(Debug)]
pub(super) struct SkewParts {
    /// Rotation of the model, which makes the gyroscopic matrix.
    pub spin: Option<Spin>,
    /// Circulatory stiffness of the follower loads.
    pub circulatory: Option<CirculatoryStiffness>,
}

impl SkewParts {
    /// Angular velocity of the model [rad/time].
    fn speed(&self) -> f64 {
        self.spin.map_or(0.0, |spin| spin.omega)
    }

    /// `[(K + N) x, M x, G x]` in the free degrees of freedom.
    fn products(&self, problem: &Problem, x: &[f64]) -> [Vec<f64>; 3] {
        let mut stiffness = times(problem, &problem.stiffness, x);
        if let Some(circulatory) = &self.circulatory {
            let mut product = vec![0.0; x.len()];
            circulatory.product(&problem.newton.assembly.frames, x, &mut product);
            stiffness.iter_mut().zip(product).for_each(|(sum, x)| *sum += x);
        }
        let gyroscopic =
            self.spin.as_ref().map_or_else(|| vec![0.0; x.len()], |spin| gyroscopic(problem, spin, x));
        [stiffness, times(problem, &problem.mass, x), gyroscopic]
    }
}

/// A complex vector of free degrees of freedom.
type Pair = [Vec<f64>; 2];

/// The basis, with the products of its vectors with K + N, M and G.
#[derive(Clone)]
struct Basis {
    /// Number of motions that the model has: further vectors would be round-off across its joints.
    most: usize,
    vectors: Vec<Vec<f64>>,
    products: [Vec<Vec<f64>>; 3],
}

/// An eigenvalue with its vector.
struct Found {
    lambda: Complex<f64>,
    vector: Pair,
    residual: f64,
}

/// Finds the `wanted` lowest modes and those of some `more` that are found, too, from real modes without the skew matrices where they are `known`. A warning tells of growing
/// ones among all of them.
///
/// # Errors
/// As for [`super::run`], or the iteration does not find the modes.
pub(super) fn modes(
    problem: &mut Problem,
    (wanted, more, skew): (usize, usize, &SkewParts),
    known: Option<Vec<Mode>>,
    observer: &mut dyn Observer,
) -> Result<ModalOutcome> {
    let system = problem.system;
    if system.mass_damping != 0.0 || system.has_rate_damping() {
        observer.on_warning(
            "complex modes leave dampers and the damping of materials out: growth and stability are those without them",
        );
    }
    let speed = skew.speed();
    // Centrifugal forces soften by no more than Ω² M.
    problem.softening = speed * speed;
    let real = match known {
        Some(modes) => modes,
        None => {
            // Above a critical speed, the lowest real modes are motions that the inertia of the turning frame drives away, which may not couple with the modes
            // of the smallest absolute values.
            let below = problem.negative_eigenvalues();
            lowest_modes(problem, (2 * wanted + MORE + below, 0), &mut Quiet(observer))?.0.modes
        }
    };
    if wanted > real.len() {
        observer.on_event(&format!(
            "{wanted} modes are wanted, but supports and joints leave the model {} only",
            real.len()
        ));
    }
    let wanted = wanted.min(real.len());
    let scale = precondition(problem, skew, &real)?;
    if let Some(spin) = skew.spin.as_ref().filter(|spin| !spin.with_ground) {
        isotropy::refuse(problem, spin)?;
    }
    let mut basis = Basis::new(problem.number_of_modes());
    let mut free = vec![0.0; problem.pattern.size()];
    for mode in &real {
        problem.newton.assembly.frames.components(&mode.shape, &mut free);
        basis.add(problem, skew, free.clone());
    }
    let all = (wanted + more).min(real.len());
    let found = match iterate(problem, basis.clone(), skew, (all, scale), observer) {
        Err(Error::NotConverged { .. }) if all > wanted => {
            iterate(problem, basis, skew, (wanted, scale), observer)?
        }
        found => found?,
    };
    let modes: Vec<Mode> = found.iter().map(|mode| mode_of(problem, skew, mode, scale)).collect();
    warn_of_growth((&modes, wanted), speed, observer);
    let statistics = Statistics {
        steps: wanted as u64,
        iterations: problem.applications,
        factorizations: problem.newton.solver.factorizations() as u64,
        ..Statistics::default()
    };
    Ok(ModalOutcome { modes, statistics, sturm_checked: false })
}

/// Factors the preconditioner `K + s² M`, and returns the circular frequency s of the size of the lowest modes. Follower loads may make the
/// symmetric part of the stiffness indefinite without an instability: s grows until the matrix is positive definite.
///
/// # Errors
/// It is not.
fn precondition(problem: &mut Problem, skew: &SkewParts, real: &[Mode]) -> Result<f64> {
    let speed = skew.speed();
    let lowest = |sizes: &mut dyn Iterator<Item = f64>| sizes.filter(|size| *size > 0.0).reduce(f64::min);
    // All of the known modes may be motions away from the equilibrium without the circulatory stiffness.
    let lowest = lowest(&mut real.iter().map(|mode| mode.omega))
        .or_else(|| lowest(&mut real.iter().map(|mode| mode.omega.abs())));
    let mut scale = lowest.map_or(speed.abs(), |lowest| lowest.hypot(speed));
    let attempts = if skew.circulatory.is_some() { MOST_DOUBLINGS } else { 0 };
    for _ in 0..=attempts {
        if problem.factor(|_| -scale * scale) == Some(0) {
            return Ok(scale);
        }
        scale *= 2.0;
    }
    Err(Error::Singular {
        what: if speed == 0.0 {
            "The stiffness is not positive definite beside the inertia: the configuration is far from stable."
                .into()
        } else {
            "The stiffness of the turning model is not positive definite beside its inertia.".into()
        },
        help: "Check loads, supports and the angular velocity.".into(),
    })
}

/// Warns of the first mode that grows, which may be beyond those that are `wanted`.
fn warn_of_growth((modes, wanted): (&[Mode], usize), speed: f64, observer: &mut dyn Observer) {
    let growth = |mode: &Mode| mode.complex.as_ref().map_or(0.0, |part| part.growth);
    let Some(number) = modes.iter().position(|mode| growth(mode) > 0.0) else { return };
    let unstable = &modes[number];
    let place = if number < wanted {
        "see `growth` in the table of modes".into()
    } else {
        format!("which is mode {}, beyond the {wanted} that are asked for (`modes`)", number + 1)
    };
    let (omega, growth) = (unstable.omega, growth(unstable));
    observer.on_warning(&if speed != 0.0 {
        format!(
            "the model that turns at {speed} is unstable: a motion of the circular frequency {omega} grows, see `growth` in the table of modes"
        )
    } else if omega == 0.0 {
        format!("the equilibrium is unstable (divergence): a motion grows by e^(t/{:.4e})", 1.0 / growth)
    } else {
        format!(
            "the equilibrium is unstable (flutter): a vibration of the circular frequency {omega:.6e} grows by e^(t/{:.4e}), {place}",
            1.0 / growth
        )
    });
}

/// Enlarges the basis by the residuals of its lowest eigenvectors until these are found; `scale` is a circular frequency of their size.
///
/// # Errors
/// The residuals stay, or the user interrupts.
fn iterate(
    problem: &mut Problem,
    mut basis: Basis,
    skew: &SkewParts,
    (wanted, scale): (usize, f64),
    observer: &mut dyn Observer,
) -> Result<Vec<Found>> {
    let mut found = Vec::new();
    let (mut least, mut stagnates) = (f64::INFINITY, 0);
    for _ in 0..MOST_ROUNDS {
        go_on(observer)?;
        found = basis.eigenvectors(skew, (wanted, scale));
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
            basis = Basis::new(basis.most);
            for vector in found.iter().flat_map(|mode| &mode.vector) {
                basis.add(problem, skew, vector.clone());
            }
        }
        let before = basis.vectors.len();
        for vector in residuals.into_iter().flatten() {
            basis.add(problem, skew, vector);
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
        let (at, help) = match &skew.spin {
            Some(spin) => (
                format!("an angular velocity of {}", spin.omega),
                "Ask for a few modes more or less. A model that may move freely across the axis has double eigenvalues, which are not found: \
                 support it.",
            ),
            None => (
                "the modes".into(),
                "Ask for a few modes more or less, or change the load a little: two modes may just meet.",
            ),
        };
        return Err(Error::NotConverged {
            at,
            reason: format!("the residual of a mode is {worst:.1e}"),
            help: help.into(),
        });
    }
    Ok(found)
}

/// Observer of the real modes, whose number is not the one that is wanted.
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
    fn new(most: usize) -> Self {
        Self { most, vectors: Vec::new(), products: Default::default() }
    }

    /// Adds a vector, orthogonal in the mass to all others, unless these contain it.
    fn add(&mut self, problem: &mut Problem, skew: &SkewParts, mut x: Vec<f64>) {
        if self.vectors.len() >= self.most {
            return;
        }
        let others = self.vectors.iter().zip(&self.products[1]).map(|(v, m)| (v.as_slice(), m.as_slice()));
        if !problem.orthonormalize(&mut x, others, DEPENDENT) {
            return;
        }
        for (list, product) in self.products.iter_mut().zip(skew.products(problem, &x)) {
            list.push(product);
        }
        self.vectors.push(x);
    }

    /// Eigenvalues next to zero of the projected problem, with non-negative imaginary parts, and their vectors.
    fn eigenvectors(&self, skew: &SkewParts, (wanted, scale): (usize, f64)) -> Vec<Found> {
        let n = self.vectors.len();
        let projected =
            |products: &[Vec<f64>]| DMatrix::from_fn(n, n, |i, j| dot(&self.vectors[i], &products[j]));
        let [k, m, g] = self.products.each_ref().map(|list| projected(list));
        let circulates = skew.circulatory.is_some();
        let k = if circulates { k } else { (&k + k.transpose()) * 0.5 } / (scale * scale);
        let g = (&g - g.transpose()) * (0.5 / scale);
        let shifted = (&m + &g + &k).lu();
        let solved = |a: &DMatrix<f64>| shifted.solve(a).unwrap_or_else(|| a * f64::NAN);
        let mut inverse = DMatrix::zeros(2 * n, 2 * n);
        inverse.view_mut((0, 0), (n, n)).copy_from(&-solved(&(&m * 2.0 + &g)));
        inverse.view_mut((0, n), (n, n)).copy_from(&-solved(&m));
        inverse.view_mut((n, 0), (n, n)).fill_with_identity();
        let mut values: Vec<Complex<f64>> = tegula_sparse::eigenvalues(&inverse)
            .unwrap_or_default()
            .iter()
            .map(|theta| theta.inv() + 1.0)
            .map(|mu| if mu.im.abs() <= ZERO * mu.norm() { mu.re.into() } else { mu })
            .filter(|mu| if mu.im == 0.0 { mu.re > 0.0 } else { mu.im > 0.0 })
            .collect();
        values.sort_by(|a, b| a.norm().total_cmp(&b.norm()));
        growing_first(&mut values);
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
            let mu = if circulates { without_noise(mu) } else { refined(mu, &x, [&k, &m, &g]) };
            found.push((mu, x));
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

/// Puts those of the eigenvalues whose absolute values differ by round-off in the order of their growth, the most growing one first: motions ±growth + iω of one or
/// of several equal parts, in ascending order of the absolute values.
fn growing_first(values: &mut [Complex<f64>]) {
    let growth = |mu: &Complex<f64>| without_noise(*mu).re;
    for cluster in values.chunk_by_mut(|a, b| (a.norm() - b.norm()).abs() <= CLUSTER * a.norm()) {
        cluster.sort_by(|a, b| growth(b).total_cmp(&growth(a)));
    }
}

/// Eigenvalue without the growth of a bounded motion that is round-off.
fn without_noise(mu: Complex<f64>) -> Complex<f64> {
    if mu.im != 0.0 && mu.re.abs() <= ZERO * mu.norm() { Complex::new(0.0, mu.im) } else { mu }
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

fn times(problem: &Problem, matrix: &[f64], x: &[f64]) -> Vec<f64> {
    let mut out = vec![0.0; x.len()];
    problem.pattern.add_product(matrix, x, &mut out);
    out
}

/// Mode of unit modal mass, whose quadrature is the smallest.
fn mode_of(problem: &Problem, skew: &SkewParts, found: &Found, scale: f64) -> Mode {
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
    let in_fixed_frame = |spin: &Spin| fixed_frame(problem, spin, [&shape, &quadrature], lambda.im);
    let fixed_frame = skew.spin.as_ref().and_then(in_fixed_frame);
    Mode {
        frequency_hz: lambda.im / std::f64::consts::TAU,
        omega: lambda.im,
        rigid,
        residual: found.residual,
        shape,
        complex: Some(ComplexPart { speed: skew.speed(), growth: lambda.re, quadrature, fixed_frame }),
    }
}
