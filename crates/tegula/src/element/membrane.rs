//! Membrane part of the bilinear shells: in-plane strains from the sampled strains, with enhanced assumed strains (EAS)
//! and other remedies against locking and hourglassing.
//!
//! With `r = r₀ + ξ r₁ + η r₂ + ξη r₃` the in-plane covariant strains are combinations of six forms,
//!
//! ```text
//! ε̃_xx = a + b η + c η²,   ε̃_yy = a′ + b′ ξ + c ξ²,   2ε̃_xy = e + b ξ + b′ η + 2 c ξη
//! a = ½ r₁·r₁,  a′ = ½ r₂·r₂,  c = ½ r₃·r₃,  e = r₁·r₂,  b = r₁·r₃,  b′ = r₂·r₃     (less the reference)
//! ```
//!
//! Curvatures follow with `r_i·d_j + r_j·d_i` in place of `r_i·r_j`.
//!
//! **Hourglass metric.** With `R₃ = c_r R₁ + c_s R₂ + W` at the reference, W perpendicular to R₁ and R₂, the vector
//! `w = r₃ − c_r r₁ − c_s r₂` vanishes wherever the motion is affine. Then
//!
//! ```text
//! q = ½ (w·w − W·W) = c − c_r b − c_s b′ + c_r² a + c_s² a′ + c_r c_s e
//! ```
//!
//! is the part of c that the other forms do not determine. On a flat element q has no linear part: it acts by the
//! geometric stiffness alone. In an element that is narrow along ξ, a compressive stress n_xx drives the hourglass mode
//! u_η = ±c η of node lines through q, and a moment m_xx drives it together with the hourglass mode of the directors;
//! these modes have no stiffness, because the enhanced strains remove their shear. The critical strain of a fibre is
//! 1.2 over the aspect ratio (T. Sussman, K.-J. Bathe, *Spurious modes in geometrically nonlinear small displacement
//! finite elements with incompatible modes*, Comput. Struct. 140 (2014) 14–22). [`Membrane::StableEas`] weights q of
//! ε̃_xx and κ̃_xx by `min(1, (2 l_ξ/l_η)²)`, and of ε̃_yy and κ̃_yy the other way round: this leaves elements up to an
//! aspect ratio of 2 unchanged, and also the linear stiffness of every flat element.
//!
//! [`Membrane::Mitc4Plus`] samples the membrane strains at the edges and at the centre in place of the integration
//! points (Y. Ko, P.-S. Lee, K.-J. Bathe, *A new MITC4+ shell element*, Comput. Struct. 182 (2017) 404–418). In terms
//! of the forms above this is a weight of q, too: `3 + 2κ/(1−κ)` in the normal strains and `−κ/(1−κ)` in the shear, κ =
//! c_r² + c_s², at the 2×2 Gauss points.
//!
//! **Assumed shear.** The equations of the enhanced parameters contain the material tangent in Green–Lagrange strain.
//! For rubber it is indefinite from moderate stretches on, although the material is stable: the geometric stiffness,
//! which compensates, does not act on the parameters. [`Membrane::AssumedShear`] has no such parameters: it projects
//! the two enhanced shear modes out of the in-plane strains, by least squares over the element. On a rectangle this is
//! the shear at the centre. Elements with three-dimensional stresses add three enhanced thickness strains, uniform over
//! the thickness and proportional to ξ, η and ξη, with a stabilisation stiffness of their own: without them a nearly
//! incompressible sheet of 5 × 5 elements between hinges loses stability under a seventieth of the pressure that it
//! carries.

use nalgebra::{DMatrix, DVector};

use super::geometry::{GAUSS, GAUSS_POINTS, NODES, ShellGeometry};
use crate::Vec3;
pub use crate::model::Membrane;

/// Indices of the first sampled in-plane strains of one power of z: ε̃_xx at η = ±g, ε̃_yy at ξ = ±g, 2ε̃_xy at the
/// Gauss points.
#[derive(Debug, Clone, Copy)]
pub(super) struct InPlaneSamples {
    pub xx: usize,
    pub yy: usize,
    pub xy: usize,
}

/// Weights of the hourglass metric in the in-plane strains of an element.
#[derive(Debug, Clone, Copy)]
pub(super) struct HourglassWeights {
    /// c_r, c_s: components of R₃ along R₁ and R₂.
    distortion: [f64; 2],
    /// Weights of q in ε̃_xx, ε̃_yy, 2ε̃_xy.
    membrane: [f64; 3],
    /// Weights of q in the strains linear and quadratic in z.
    bending: [f64; 3],
}

/// Aspect ratio up to which [`Membrane::StableEas`] equals [`Membrane::Eas`].
const UNTOUCHED_ASPECT: f64 = 2.0;

/// Slenderness weights of q, `min(1, (2 l_ξ/l_η)²)` and `min(1, (2 l_η/l_ξ)²)`.
fn slenderness_weights([r1, r2, _]: &[Vec3; 3]) -> [f64; 2] {
    let ratio = r1.norm_squared() / r2.norm_squared();
    let limit = UNTOUCHED_ASPECT * UNTOUCHED_ASPECT;
    [(limit * ratio).min(1.0), (limit / ratio).min(1.0)]
}

/// R₁, R₂, R₃ of the reference mid-surface.
fn vectors(g: &ShellGeometry) -> [Vec3; 3] {
    let sum = |weight: fn([f64; 2]) -> f64| {
        NODES.iter().zip(&g.positions).map(|(n, x)| x * (0.25 * weight(*n))).sum::<Vec3>()
    };
    [sum(|[xi, _]| xi), sum(|[_, eta]| eta), sum(|[xi, eta]| xi * eta)]
}

/// Components of R₃ along R₁ and R₂, by least squares.
fn distortion([r1, r2, r3]: &[Vec3; 3]) -> [f64; 2] {
    let (a, b, c) = (r1.norm_squared(), r1.dot(r2), r2.norm_squared());
    let determinant = a * c - b * b;
    let (x, y) = (r1.dot(r3), r2.dot(r3));
    [(c * x - b * y) / determinant, (a * y - b * x) / determinant]
}

impl HourglassWeights {
    /// Weights of q for an element; `None` where all are one.
    pub fn of(membrane: Membrane, g: &ShellGeometry) -> Option<Self> {
        let r = vectors(g);
        let distortion = distortion(&r);
        let (membrane, bending) = match membrane {
            Membrane::Eas | Membrane::AssumedShear | Membrane::Displacement => return None,
            Membrane::StableEas => {
                let [x, y] = slenderness_weights(&r);
                if x.min(y) >= 1.0 {
                    return None;
                }
                let weights = [x, y, (x * y).sqrt()];
                (weights, weights)
            }
            Membrane::Mitc4Plus => {
                let k = distortion.iter().map(|c| c * c).sum::<f64>();
                let tied = k / (1.0 - k);
                ([3.0 + 2.0 * tied, 3.0 + 2.0 * tied, -tied], [1.0; 3])
            }
        };
        distortion.iter().all(|c| c.is_finite()).then_some(Self { distortion, membrane, bending })
    }

    /// Applies the weights of q to the rows xx, yy, xy, beginning at `row`, of the covariant strains at a Gauss point,
    /// for the sampled strains of the `power` of z; `add(row, sample, value)` adds to their matrix.
    pub fn apply(
        &self,
        samples: InPlaneSamples,
        power: usize,
        point: usize,
        row: usize,
        add: &mut dyn FnMut(usize, usize, f64),
    ) {
        let weights = if power == 0 { self.membrane } else { self.bending };
        let [xi, eta] = GAUSS_POINTS[point];
        let factors = [
            (weights[0] - 1.0) * eta * eta,
            (weights[1] - 1.0) * xi * xi,
            (weights[2] - 1.0) * 2.0 * xi * eta,
        ];
        for (sample, q) in self.metric(samples) {
            for (i, factor) in factors.into_iter().enumerate() {
                add(row + i, sample, factor * q);
            }
        }
    }

    /// Coefficients of q in the sampled strains. At the Gauss points `(s₀ + s₁)/2 = a + c/3` and `s₁ − s₀ = 2 g b`,
    /// likewise in η; the mean of the shears is e, and their part along ξη is 2c/3.
    fn metric(&self, samples: InPlaneSamples) -> impl Iterator<Item = (usize, f64)> {
        let [c_r, c_s] = self.distortion;
        // c enters by itself and through a = (s₀ + s₁)/2 − c/3.
        let of_c = 1.0 - (c_r * c_r + c_s * c_s) / 3.0;
        let normal = [(samples.xx, c_r), (samples.yy, c_s)].into_iter().flat_map(|(first, c)| {
            [-1.0, 1.0]
                .into_iter()
                .enumerate()
                .map(move |(i, side)| (first + i, 0.5 * c * c - side * c / (2.0 * GAUSS)))
        });
        let shear = [1.0, -1.0, -1.0, 1.0]
            .into_iter()
            .enumerate()
            .map(move |(p, sign)| (samples.xy + p, 0.375 * sign * of_c + 0.25 * c_r * c_s));
        normal.chain(shear)
    }
}

/// Strains and enhanced shear modes of the mid-surface at an integration point.
pub(super) struct ShearPoint {
    /// Strains from sampled strains.
    pub strain: DMatrix<f64>,
    /// Two enhanced shear modes, rows as in `strain`.
    pub shear: DMatrix<f64>,
    /// Integration weight of the point.
    pub measure: f64,
}

/// Amplitudes of the enhanced shear modes that the assumed shear projects out, from the sampled strains: least squares
/// `min Σ w |L s + G α|²` in the norm of tensors. In elements longer than `UNTOUCHED_ASPECT` times their width the
/// shear returns with the square of the aspect ratio: otherwise slender elements would be as unstable in bending as
/// those with enhanced strains.
pub(super) fn assumed_shear(g: &ShellGeometry, points: &[ShearPoint]) -> Option<DMatrix<f64>> {
    let samples = points.first()?.strain.ncols();
    let mut gg = DMatrix::zeros(2, 2);
    let mut gl = DMatrix::zeros(2, samples);
    for p in points {
        // Engineering shears count half in the norm of the tensor.
        let half = [1.0, 1.0, 0.5, 1.0, 0.5, 0.5];
        let norm = DMatrix::from_diagonal(&DVector::from_iterator(
            p.strain.nrows(),
            half.into_iter().take(p.strain.nrows()).map(|n| n * p.measure),
        ));
        let weighted = p.shear.transpose() * norm;
        gg += &weighted * &p.shear;
        gl += weighted * &p.strain;
    }
    let [x, y] = slenderness_weights(&vectors(g));
    Some(gg.cholesky()?.solve(&gl) * -(x * y))
}
