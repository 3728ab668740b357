//! Bushings: linear stiffness and damping of the six relative motions of two bodies.
//!
//! The six strains ε of a bushing are the displacement `uᵢ = eᵢᴬ·(x_B − x_A)` of the point of the second side relative to that of the
//! first one along the axes e of the first side, and the rotation vector φ of the second side relative to the first one along the same
//! axes. Both are functions of quadratic forms of nodal vectors, u itself, `w₁ = ½ (e₃ᴬ·e₂ᴮ − e₂ᴬ·e₃ᴮ)` …, and `c = ½ (Σ eᵢᴬ·eᵢᴮ − 1)`:
//! `φ = κ(c) w` ([`rotation_vector`](super::rotation_vector)). The energy is `V = ½ (ε − ε₀)·K (ε − ε₀)` with the free deformation
//! ε₀, the forces are `n = K (ε − ε₀) + D ε̇`, work-conjugate to ε. Rigid motions do not change the forms.
//!
//! In the energy–momentum scheme `n = K (½ (ε₀ + ε₁) − ε₀₀) + D Δε/Δt` acts with the discrete gradient of the strains,
//!
//! ```text
//! Δφ = ½ (κ₀ + κ₁) Δw + ½ (w₀ + w₁) κ[c₀, c₁] Δc,   κ[c₀, c₁] = (κ₁ − κ₀)/(c₁ − c₀)
//! ```
//!
//! with the gradients of the forms in the middle of the step, by which forms change exactly: the force does the work
//! `V₁ − V₀ + Δε·D Δε/Δt`, and momenta are conserved (O. Gonzalez, *Time integration and discrete Hamiltonian systems*, J. Nonlinear
//! Sci. 6 (1996) 449–467).

use nalgebra::{Matrix6, Vector6};

use super::joint::{Few, MOST_VECTORS, few};
use super::joints::{End, LARGEST_TURN};
use super::rotation_vector;
use super::{Attachment, Row};
use crate::element::{GroupPoint, Motion, Nodal};
use crate::{Mat3, Vec3};

/// Largest relative rotation of a bushing (degrees): at half a turn the rotation vector jumps.
pub const LARGEST_ROTATION: f64 = 150.0;
/// Number of forms of a bushing: u, w and c.
const FORMS: usize = 7;

/// Bushing of the compiled model.
#[derive(Debug, Clone, PartialEq)]
pub struct Bushing {
    /// Name of the bushing in the model.
    pub name: String,
    /// Whether it has stiffness or damping of rotations; without, the second side may have no axes.
    pub turns: bool,
    /// Nodal vectors of the forms.
    pub(super) vectors: Vec<u32>,
    /// Whether one of the sides is the ground.
    pub(super) grounded: bool,
    /// Displacement u, axial vector w and cosine c.
    forms: [Row; FORMS],
    /// Stiffness K, symmetric.
    pub(super) stiffness: Matrix6<f64>,
    /// Damping D, symmetric.
    pub(super) damping: Matrix6<f64>,
    /// Displacement and rotation vector without force.
    free: Vector6<f64>,
}

/// Displacement, rotation, force and moment of a bushing, along its axes, which move with its first side.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BushingResponse {
    /// Displacement of the second side relative to the first one (length).
    pub displacement: Vec3,
    /// Rotation vector of the second side relative to the first one (rad).
    pub rotation: Vec3,
    /// Force on the first side; the opposite one acts on the second side.
    pub force: Vec3,
    /// Moment on the first side about the point of the second side; the opposite one acts on the second side.
    pub moment: Vec3,
}

/// Deformation of a bushing in a motion.
pub(super) struct Deformation {
    /// Strains at the start and at the end of the motion; equal for a state.
    pub strains: [Vector6<f64>; 2],
    /// Rates of the strains.
    pub rate: Vector6<f64>,
    /// Rotation by which the forces act.
    turn: Turn,
}

/// Parts of the rotation vector `κ(c) w`.
struct Turn {
    /// Factor κ.
    factor: f64,
    /// Derivative of κ by c, or its divided difference.
    slope: f64,
    /// Second derivative of κ.
    curvature: f64,
    /// Axial vector w.
    axial: Vec3,
}

impl Turn {
    /// Parts in a state with these forms.
    fn new(forms: &[f64; FORMS]) -> Self {
        let [factor, slope, curvature] = rotation_vector::factor(forms[6]);
        Self { factor, slope, curvature, axial: Vec3::new(forms[3], forms[4], forms[5]) }
    }
}

impl Bushing {
    /// Bushing between two ends at a place of the reference configuration, with these axes (columns), stiffness and damping, and
    /// displacement and rotation vector without force; `None` where an end lacks axes.
    pub fn new(
        name: &str,
        ends: &[End; 2],
        (at, axes): (&Vec3, &Mat3),
        [stiffness, damping]: [Matrix6<f64>; 2],
        free: Vector6<f64>,
    ) -> Option<Self> {
        let turns =
            [&stiffness, &damping].iter().any(|matrix| matrix.columns(3, 3).iter().any(|x| *x != 0.0));
        let axes_of = |end: &End| -> Option<[Attachment; 3]> {
            let [x, y, z] = [0, 1, 2].map(|i| end.axis(&axes.column(i).into_owned()));
            Some([x?, y?, z?])
        };
        let first = axes_of(&ends[0])?;
        let points = [0, 1].map(|i| ends[i].point(at));
        let (mut vectors, mut forms) = (Vec::new(), std::array::from_fn(|_| Row::default()));
        for (form, axis) in forms.iter_mut().zip(&first) {
            form.add_product(&mut vectors, 1.0, axis, &points[1]);
            form.add_product(&mut vectors, -1.0, axis, &points[0]);
        }
        if turns {
            let second = axes_of(&ends[1])?;
            for i in 0..3 {
                let (j, k) = ((i + 1) % 3, (i + 2) % 3);
                forms[3 + i].add_product(&mut vectors, 0.5, &first[k], &second[j]);
                forms[3 + i].add_product(&mut vectors, -0.5, &first[j], &second[k]);
                forms[6].add_product(&mut vectors, 0.5, &first[i], &second[i]);
            }
            forms[6].add_constant(-0.5);
        } else {
            forms[6].add_constant(1.0);
        }
        let grounded = ends.contains(&End::Ground);
        Some(Self { name: name.to_owned(), turns, vectors, grounded, forms, stiffness, damping, free })
    }

    /// Displacement, rotation and forces for given nodal vectors and their rates.
    pub fn response(&self, value: impl Fn(u32) -> Vec3, rate: impl Fn(u32) -> Vec3) -> BushingResponse {
        let v = few(&self.vectors, value);
        let forms = self.forms(&v);
        let turn = Turn::new(&forms);
        let rate = self.rate(&turn, &v, &few(&self.vectors, rate));
        self.response_at(&forms, &turn, &rate)
    }

    /// Displacement, rotation and forces at the mean rate of a step of this length, for given nodal vectors at its start and its end.
    pub fn response_of_step(&self, [start, end]: [&dyn Fn(u32) -> Vec3; 2], dt: f64) -> BushingResponse {
        let [before, forms] = [start, end].map(|value| self.forms(&few(&self.vectors, value)));
        let turn = Turn::new(&forms);
        let rate = (strain(&forms, &turn) - strain(&before, &Turn::new(&before))) / dt;
        self.response_at(&forms, &turn, &rate)
    }

    fn response_at(&self, forms: &[f64; FORMS], turn: &Turn, rate: &Vector6<f64>) -> BushingResponse {
        let strain = strain(forms, turn);
        let force = self.stiffness * (strain - self.free) + self.damping * rate;
        let [displacement, rotation] = halves(&strain);
        let [force, conjugate] = halves(&force);
        BushingResponse { displacement, rotation, force, moment: moment(&conjugate, turn, forms[6]) }
    }

    /// Strains and their rates in a motion, which began at the rotation vector `committed`; NaN where the rotation is too large, or
    /// changes by too much.
    pub(super) fn deformation(&self, k: &GroupPoint, committed: &[f64]) -> Deformation {
        let at = |u: &[Nodal]| {
            few(&self.vectors, |v| Vec3::from(k.reference[v as usize]) + Vec3::from(u[v as usize]))
        };
        let before = Vec3::from_column_slice(committed);
        match k.motion {
            Motion::State { u, velocity } => {
                let v = at(u);
                let forms = self.forms(&v);
                let turn = Turn::new(&forms);
                let strain = strain(&forms, &turn) * self.in_range(&forms, &turn, &before);
                let rate = velocity.map_or_else(Vector6::zeros, |rates| {
                    self.rate(&turn, &v, &few(&self.vectors, |v| Vec3::from(rates[v as usize])))
                });
                Deformation { strains: [strain; 2], rate, turn }
            }
            Motion::Step { old, new, dt } => {
                let [first, last] = [old, new].map(|u| self.forms(&at(u)));
                let [start, end] = [&first, &last].map(Turn::new);
                let turn = Turn {
                    factor: 0.5 * (start.factor + end.factor),
                    slope: rotation_vector::divided_difference([first[6], last[6]]),
                    curvature: 0.5 * (start.curvature + end.curvature),
                    axial: (start.axial + end.axial) * 0.5,
                };
                let before = start.axial * start.factor;
                let range = self.in_range(&last, &end, &before);
                let strains = [strain(&first, &start), strain(&last, &end) * range];
                Deformation { strains, rate: (strains[1] - strains[0]) / dt, turn }
            }
        }
    }

    /// One where a rotation is within the range of the bushing and has not changed by too much; otherwise NaN.
    fn in_range(&self, forms: &[f64; FORMS], turn: &Turn, before: &Vec3) -> f64 {
        let change = (turn.axial * turn.factor - before).norm();
        let within = forms[6] >= LARGEST_ROTATION.to_radians().cos() && change <= LARGEST_TURN;
        if within || !self.turns { 1.0 } else { f64::NAN }
    }

    /// Rotation vector at the end of a motion.
    pub(super) fn rotation(&self, k: &GroupPoint) -> Vec3 {
        let (Motion::State { u, .. } | Motion::Step { new: u, .. }) = k.motion;
        let at = |v: u32| Vec3::from(k.reference[v as usize]) + Vec3::from(u[v as usize]);
        let forms = self.forms(&few(&self.vectors, at));
        let turn = Turn::new(&forms);
        turn.axial * turn.factor
    }

    /// Forces conjugate to the strains, with this part of those in the reference configuration.
    pub(super) fn force(&self, d: &Deformation, preload: f64) -> Vector6<f64> {
        self.stiffness * ((d.strains[0] + d.strains[1]) * 0.5 - self.free * preload) + self.damping * d.rate
    }

    /// Energy at the end of a motion whose derivatives the forces with this part of those in the reference configuration are.
    pub(super) fn energy(&self, d: &Deformation, preload: f64) -> f64 {
        let strain = d.strains[1] - self.free;
        let missing = (1.0 - preload) * d.strains[1].dot(&(self.stiffness * self.free));
        0.5 * strain.dot(&(self.stiffness * strain)) + missing
    }

    /// Factors of the gradients of the forms in the forces `n·∂ε`.
    pub(super) fn factors(n: &Vector6<f64>, d: &Deformation) -> [f64; FORMS] {
        let [force, moment] = halves(n);
        let m = moment * d.turn.factor;
        [force.x, force.y, force.z, m.x, m.y, m.z, moment.dot(&d.turn.axial) * d.turn.slope]
    }

    /// Sum of the gradients of the forms with factors, at the nodal vectors v.
    pub(super) fn gradient(&self, v: &Few, factors: &[f64; FORMS]) -> Few {
        let mut out = [Vec3::zeros(); MOST_VECTORS];
        for (form, factor) in self.forms.iter().zip(factors).filter(|(_, factor)| **factor != 0.0) {
            form.add_gradient(*factor, v, 0.0, &mut out);
        }
        out
    }

    /// Adds `factor · n·∂²ε` at the nodal vectors v to the lower blocks of the tangent.
    pub(super) fn add_second_derivative(
        &self,
        factor: f64,
        (n, d, v): (&Vector6<f64>, &Deformation, &Few),
        blocks: &mut [f64],
    ) {
        for (form, of_form) in self.forms.iter().zip(Self::factors(n, d)) {
            form.add_second_derivative(factor * of_form, 0.0, blocks);
        }
        let [_, moment] = halves(n);
        let mut unit = [0.0; FORMS];
        unit[6] = 1.0;
        let of_cosine = self.gradient(v, &unit);
        let of_axial = self.gradient(v, &[0.0, 0.0, 0.0, moment.x, moment.y, moment.z, 0.0]);
        let (mixed, pure) = (factor * d.turn.slope, factor * moment.dot(&d.turn.axial) * d.turn.curvature);
        for (out, (a, b)) in blocks.chunks_exact_mut(9).zip(pairs(self.vectors.len())) {
            let block = (of_axial[a] * of_cosine[b].transpose() + of_cosine[a] * of_axial[b].transpose())
                * mixed
                + of_cosine[a] * of_cosine[b].transpose() * pure;
            out.iter_mut().enumerate().for_each(|(i, out)| *out += block[(i / 3, i % 3)]);
        }
    }

    /// Gradients of the strains at the nodal vectors v.
    pub(super) fn strain_gradients(&self, v: &Few, d: &Deformation) -> [Few; 6] {
        std::array::from_fn(|i| {
            let mut unit = Vector6::zeros();
            unit[i] = 1.0;
            self.gradient(v, &Self::factors(&unit, d))
        })
    }

    /// Strains of a small motion from the nodal vectors v.
    pub(super) fn strains_of(&self, v: &Few, d: &Deformation, motion: impl Fn(u32) -> Vec3) -> Vector6<f64> {
        let along = |gradient: &Few| self.vectors.iter().zip(gradient).map(|(&v, g)| g.dot(&motion(v))).sum();
        self.strain_gradients(v, d).map(|gradient| along(&gradient)).into()
    }

    /// Cosine of the relative rotation at the end of a motion.
    pub(super) fn cosine(&self, k: &GroupPoint) -> f64 {
        let (Motion::State { u, .. } | Motion::Step { new: u, .. }) = k.motion;
        let at = |v: u32| Vec3::from(k.reference[v as usize]) + Vec3::from(u[v as usize]);
        self.forms[6].form(&few(&self.vectors, at))
    }

    fn forms(&self, v: &Few) -> [f64; FORMS] {
        std::array::from_fn(|i| self.forms[i].form(v))
    }

    /// Rates of the strains with the rates of the nodal vectors v.
    fn rate(&self, turn: &Turn, v: &Few, rates: &Few) -> Vector6<f64> {
        let of_form: [f64; FORMS] = std::array::from_fn(|i| self.forms[i].form_rate(v, rates));
        let [u1, u2, u3, w1, w2, w3, c] = of_form;
        let rotation = Vec3::new(w1, w2, w3) * turn.factor + turn.axial * (turn.slope * c);
        Vector6::new(u1, u2, u3, rotation.x, rotation.y, rotation.z)
    }
}

/// Pairs of nodal vectors in the order of the lower blocks.
pub(super) fn pairs(n: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..n).flat_map(|a| (0..=a).map(move |b| (a, b)))
}

fn strain([u1, u2, u3, ..]: &[f64; FORMS], turn: &Turn) -> Vector6<f64> {
    let rotation = turn.axial * turn.factor;
    Vector6::new(*u1, *u2, *u3, rotation.x, rotation.y, rotation.z)
}

fn halves(six: &Vector6<f64>) -> [Vec3; 2] {
    [six.fixed_rows::<3>(0).into_owned(), six.fixed_rows::<3>(3).into_owned()]
}

/// Moment of a force n conjugate to the rotation vector, `m·δθ = n·δφ` for rotations δθ of the second side, along the axes of the
/// first one: with the rotation matrix `R = c 1 + [w] + w wᵀ/(1 + c)` rotations change the forms by `δw = ½ (tr R 1 − R) δθ`,
/// `δc = −w·δθ`.
fn moment(n: &Vec3, turn: &Turn, c: f64) -> Vec3 {
    let w = turn.axial;
    let turned_back = n * c - w.cross(n) + w * (w.dot(n) / (1.0 + c));
    (n * (1.0 + 2.0 * c) - turned_back) * (0.5 * turn.factor) - w * (n.dot(&w) * turn.slope)
}
