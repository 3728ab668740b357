//! Power series of pressures that follow their faces.
//!
//! The force of a pressure on a bilinear face is a quadratic form of the positions of its nodes, `f(x) = P(x, x)`, times a factor
//! `φ(λ) = φ₀ + φ' (λ − λ₀)`. With the coefficients C_m of `P(x, x)`, order p of the force is
//!
//! ```text
//! φ' λ_p C₀ + 2 φ₀ P(x₀, x_p) + φ₀ Σ_{j=1}^{p−1} P(x_j, x_{p−j}) + φ' Σ_{i=1}^{p−1} λ_i C_{p−i}
//! ```
//!
//! The first term belongs to the load per load factor and the second one to the tangent; the others are known.

use super::series::Series;
use crate::Vec3;
use crate::element::Nodal;
use crate::load::FollowerLoad;
use crate::system::System;

/// Nodes of a face.
const NODES: usize = 4;

/// Pressures of a series.
pub struct PressureSeries {
    faces: Vec<Face>,
    /// Positions of the nodes of a face and their coefficients.
    positions: Vec<[Vec3; NODES]>,
}

struct Face {
    /// Factor at the start of the series, and its rate over the load factor.
    factor: f64,
    rate: f64,
    /// C₁, C₂, …
    forces: Vec<[Nodal; NODES]>,
}

impl PressureSeries {
    /// Pressures of a system at the load factor at which a series starts.
    pub fn new(system: &System, load: f64) -> Self {
        let face = |follower: &FollowerLoad| {
            let at = |load| system.factor(follower.factor(), load);
            Face { factor: at(load), rate: at(1.0) - at(0.0), forces: Vec::new() }
        };
        Self { faces: system.followers.iter().map(face).collect(), positions: Vec::new() }
    }

    /// Subtracts the known part of the forces of the next order of a series from internal forces.
    pub fn subtract_known(&mut self, system: &System, series: &Series, out: &mut [Nodal]) {
        let Self { faces, positions } = self;
        for (face, follower) in faces.iter_mut().zip(&system.followers) {
            let nodes = follower.vectors();
            let gather = |field: &[Nodal]| std::array::from_fn(|n| Vec3::from(field[nodes[n] as usize]));
            let [start, reference]: [[Vec3; NODES]; 2] =
                [&series.u, &system.coordinates.reference].map(|field| gather(field));
            positions.clear();
            positions.push(std::array::from_fn(|n| reference[n] + start[n]));
            positions.extend(series.coefficients.iter().map(|coefficient| gather(coefficient)));
            face.forces.push(follower.convolution(positions));
            let mut add = |factor: f64, forces: &[Nodal; NODES]| {
                for (&node, force) in nodes.iter().zip(forces) {
                    (0..3).for_each(|i| out[node as usize][i] -= factor * force[i]);
                }
            };
            add(face.factor, &follower.convolution(&positions[1..]));
            for (load, forces) in series.loads[1..].iter().zip(face.forces.iter().rev()) {
                add(face.rate * load, forces);
            }
        }
    }
}
