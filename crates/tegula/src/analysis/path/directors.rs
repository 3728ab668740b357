//! Inextensible directors, and directors of rigid bodies and of nodes of beams, in the power series of a path.
//!
//! Newton's method moves them by rotations. In a series they are nodal vectors with quadratic constraints, `d·d = 1` and `DᵀD = I` for the
//! three directors D (columns) of a body, and with multipliers μ and M (symmetric) of the constraint forces `μ d` and `D M`. At order p the
//! constraints give the part of the coefficient across the motions that they leave,
//!
//! ```text
//! w_p = −½ Σ_{r=1}^{p−1} (d_r·d_{p−r}) d₀/|d₀|²,     W_p = −½ D₀ Σ_{r=1}^{p−1} D_rᵀ D_{p−r}
//! ```
//!
//! and the other part v_p − w_p solves the equation of the tangent that Newton's method has,
//!
//! ```text
//! K (v_p − w_p) = λ_p F − f_p − K w_p − Σ_{r=0}^{p−1} μ_r d_{p−r}      (d_p = w_p),
//! ```
//!
//! projected onto the rotations at v₀. Its part across them gives the multipliers of order p:
//! `μ_p = −d₀·(K v_p + f_p − λ_p F + Σ_{r=0}^{p−1} μ_r d_{p−r})/|d₀|²`, and with `D₀ᵀ` and the symmetric part for M_p. So neither unknowns nor
//! factorisations are added. A director that is supported in one direction has its component across it in the place of d₀.
//!
//! Quadratic constraints in asymptotic numerical methods: B. Cochelin, N. Damil, M. Potier-Ferry, *Méthode asymptotique numérique*,
//! Hermes-Lavoisier, 2007.

use crate::element::Nodal;
use crate::system::System;
use crate::{Mat3, Vec3};

/// Multipliers of the directors of a model in a series, from order 0 on.
#[derive(Debug, Clone, Default)]
pub struct DirectorSeries {
    units: Vec<Unit>,
    triads: Vec<Triad>,
}

/// Inextensible director.
#[derive(Debug, Clone)]
struct Unit {
    vector: usize,
    /// Direction in which it is supported.
    fixed: Option<Vec3>,
    /// The director at the expansion point, without its component in the supported direction.
    origin: Vec3,
    multipliers: Vec<f64>,
}

/// Three orthonormal directors, and the vectors that are attached to them, each with its coordinates along them.
#[derive(Debug, Clone)]
struct Triad {
    vectors: [usize; 3],
    attached: Vec<(usize, Vec3)>,
    origin: Mat3,
    multipliers: Vec<Mat3>,
}

impl DirectorSeries {
    /// Directors at an expansion point, without multipliers.
    pub fn new(system: &System, u: &[Nodal]) -> Self {
        let at = |v: u32| Vec3::from(system.coordinates.reference[v as usize]) + Vec3::from(u[v as usize]);
        let dofs = system.dofs();
        let units = dofs.unit.iter().map(|unit| {
            let origin = across(at(unit.vector), unit.fixed);
            Unit { vector: unit.vector as usize, fixed: unit.fixed, origin, multipliers: Vec::new() }
        });
        let triads = dofs.triads.iter().enumerate().map(|(number, triad)| {
            let attached = dofs.attached.iter().filter(|attached| attached.triad as usize == number);
            Triad {
                vectors: triad.map(|v| v as usize),
                attached: attached.map(|a| (a.vector as usize, a.coordinates)).collect(),
                origin: Mat3::from_columns(&triad.map(at)),
                multipliers: Vec::new(),
            }
        });
        Self { units: units.collect(), triads: triads.collect() }
    }

    /// Whether the model has no such directors.
    pub fn is_empty(&self) -> bool {
        self.units.is_empty() && self.triads.is_empty()
    }

    /// Part w of the next coefficient that the constraints give, from the lower ones.
    pub fn part_across(&self, system: &System, coefficients: &[Vec<Nodal>]) -> Vec<Nodal> {
        let mut out = vec![[0.0; 3]; system.vectors()];
        let pairs = || coefficients.iter().zip(coefficients.iter().rev());
        for unit in &self.units {
            let products = pairs().map(|(a, b)| Vec3::from(a[unit.vector]).dot(&Vec3::from(b[unit.vector])));
            let share = -0.5 * products.sum::<f64>() / unit.origin.norm_squared();
            out[unit.vector] = (unit.origin * share).into();
        }
        for triad in &self.triads {
            let products = pairs().map(|(a, b)| triad.of(a).transpose() * triad.of(b));
            let part = triad.origin * symmetric(&products.sum()) * -0.5;
            triad.vectors.iter().enumerate().for_each(|(i, &v)| out[v] = part.column(i).into_owned().into());
        }
        system.dofs().carry(&mut out);
        out
    }

    /// Adds the constraint forces of the order of `last`, the highest coefficient of the nodal vectors that is known, without those of the
    /// multipliers of this order. `coefficients` are the lower ones.
    pub fn add_forces(&self, coefficients: &[Vec<Nodal>], last: &[Nodal], out: &mut [Nodal]) {
        let highest_first = || std::iter::once(last).chain(coefficients.iter().rev().map(Vec::as_slice));
        for unit in &self.units {
            let parts = unit.multipliers.iter().zip(highest_first());
            let force: Vec3 = parts.map(|(multiplier, d)| Vec3::from(d[unit.vector]) * *multiplier).sum();
            out[unit.vector] = (Vec3::from(out[unit.vector]) + force).into();
        }
        for triad in &self.triads {
            let parts = triad.multipliers.iter().zip(highest_first());
            let force: Mat3 = parts.map(|(multiplier, d)| triad.of(d) * multiplier).sum();
            for (i, &v) in triad.vectors.iter().enumerate() {
                out[v] = (Vec3::from(out[v]) + force.column(i)).into();
            }
        }
    }

    /// Takes the multipliers of the next order from all other forces of this order, of which they balance the part across the rotations.
    pub fn take_multipliers(&mut self, forces: &[Nodal]) {
        for unit in &mut self.units {
            let force = across(Vec3::from(forces[unit.vector]), unit.fixed);
            unit.multipliers.push(-unit.origin.dot(&force) / unit.origin.norm_squared());
        }
        for triad in &mut self.triads {
            let mut sum = triad.of(forces);
            for (v, coordinates) in &triad.attached {
                sum += Vec3::from(forces[*v]) * coordinates.transpose();
            }
            triad.multipliers.push(-symmetric(&(triad.origin.transpose() * sum)));
        }
    }
}

impl Triad {
    /// Values of a field at the directors, as columns.
    fn of(&self, field: &[Nodal]) -> Mat3 {
        Mat3::from_columns(&self.vectors.map(|v| Vec3::from(field[v])))
    }
}

fn across(x: Vec3, fixed: Option<Vec3>) -> Vec3 {
    fixed.map_or(x, |axis| x - axis * axis.dot(&x))
}

fn symmetric(m: &Mat3) -> Mat3 {
    (m + m.transpose()) * 0.5
}
