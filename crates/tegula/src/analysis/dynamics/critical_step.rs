//! The critical step of central differences, `2/ω` with the highest circular frequency ω.
//!
//! ω² is the largest eigenvalue of `K x = ω² M x`, found by Lanczos' method in the inner product of M. It converges to
//! this end of the spectrum first, from below; a safety factor belongs to what it finds.
//! C. Lanczos, J. Res. Nat. Bur. Standards 45 (1950) 255–282.

use crate::analysis::State;
use crate::element::TangentWeights;
use crate::system::assembly::{TangentParts, add_follower_loads};
use crate::system::{Assembly, System};
use crate::{analysis::statics::state_kinematics, element::Nodal};

/// Steps of Lanczos' method at most.
const STEPS: usize = 80;
/// Relative change of the eigenvalue over one step at which it is found, thrice in a row.
const CHANGE: f64 = 1e-4;

/// Buffers for estimates; nothing is allocated after they are made.
pub struct CriticalStep {
    /// Mass of each free coordinate.
    mass: Vec<f64>,
    /// M q, M q of the step before, q, K q.
    vectors: [Vec<f64>; 4],
    forces: Vec<Nodal>,
    retardation: f64,
}

impl CriticalStep {
    /// For a system with mass `mass` per nodal vector.
    pub fn new(system: &System, mass: &[f64]) -> Self {
        let mut free = vec![0.0; system.unknowns()];
        let field: Vec<Nodal> = mass.iter().map(|&m| [m; 3]).collect();
        for (v, m) in field.iter().enumerate() {
            for (number, m) in system.numbering.of(v).into_iter().zip(m) {
                if let Some(f) = free.get_mut(number as usize) {
                    *f = *m;
                }
            }
        }
        let zero = vec![0.0; free.len()];
        Self {
            mass: free,
            vectors: [zero.clone(), zero.clone(), zero.clone(), zero],
            forces: vec![[0.0; 3]; system.vectors()],
            retardation: system.groups.iter().map(|g| g.retardation_time()).fold(0.0, f64::max),
        }
    }

    /// The critical step at a state, with damping of strain rates by forces of the last half step,
    /// `2/ω (√(1 + ξ²) − ξ)`, `ξ = τ ω/2`.
    pub fn estimate(&mut self, system: &System, assembly: &mut Assembly, state: &State) -> f64 {
        let weights = TangentWeights { stress: 1.0, direction: 1.0, force: 1.0, rate: 0.0 };
        let parts = TangentParts { weights, mass: 0.0, time: state.time };
        let k = state_kinematics(system, &state.u, state.time);
        assembly.forces_and_tangent(system, &k, &parts, false, None, &mut self.forces);
        self.forces.fill([0.0; 3]);
        add_follower_loads(system, &k, state.time, 1.0, &mut self.forces);
        let omega = self.largest(system, &assembly.values).max(0.0).sqrt();
        let xi = 0.5 * self.retardation * omega;
        2.0 / omega / ((1.0 + xi * xi).sqrt() + xi)
    }

    /// Largest eigenvalue of `K x = λ M x`.
    fn largest(&mut self, system: &System, values: &[f64]) -> f64 {
        let [p, old, q, kq] = &mut self.vectors;
        // A start that no symmetry makes orthogonal to the mode; always the same one.
        let mut seed = 0x9e37_79b9_7f4a_7c15_u64;
        for (q, m) in q.iter_mut().zip(&self.mass) {
            seed ^= seed << 13;
            seed ^= seed >> 7;
            seed ^= seed << 17;
            *q = ((seed >> 11) as f64 / (1_u64 << 53) as f64 - 0.5) / m.sqrt();
        }
        let norm = q.iter().zip(&self.mass).map(|(q, m)| m * q * q).sum::<f64>().sqrt();
        for ((q, p), m) in q.iter_mut().zip(p.iter_mut()).zip(&self.mass) {
            *q /= norm;
            *p = m * *q;
        }
        old.fill(0.0);
        let (mut a, mut b) = ([0.0; STEPS], [0.0; STEPS]);
        let (mut found, mut settled) = (0.0_f64, 0);
        for step in 0..STEPS {
            kq.fill(0.0);
            for j in 0..q.len() {
                for at in system.pattern.column_pointers[j]..system.pattern.column_pointers[j + 1] {
                    let i = system.pattern.row_indices[at];
                    kq[i] += values[at] * q[j];
                    if i != j {
                        kq[j] += values[at] * q[i];
                    }
                }
            }
            a[step] = q.iter().zip(kq.iter()).map(|(q, k)| q * k).sum();
            let before = if step == 0 { 0.0 } else { b[step - 1] };
            let mut square = 0.0;
            for i in 0..q.len() {
                let next = kq[i] - a[step] * p[i] - before * old[i];
                (old[i], p[i]) = (p[i], next);
                square += next * next / self.mass[i];
            }
            b[step] = square.sqrt();
            let value = largest_of_tridiagonal(&a[..=step], &b[..step]);
            settled = if (value - found).abs() <= CHANGE * value.abs() { settled + 1 } else { 0 };
            found = value;
            if settled == 3 || b[step] <= f64::EPSILON * value.abs() {
                break;
            }
            for i in 0..q.len() {
                p[i] /= b[step];
                q[i] = p[i] / self.mass[i];
            }
        }
        found
    }
}

/// Largest eigenvalue of a symmetric tridiagonal matrix, by bisection with Sturm counts.
fn largest_of_tridiagonal(a: &[f64], b: &[f64]) -> f64 {
    let off = |i: usize| b.get(i).copied().unwrap_or(0.0);
    let reach = |i: usize| off(i) + if i > 0 { off(i - 1) } else { 0.0 };
    let mut high = (0..a.len()).map(|i| a[i] + reach(i)).fold(f64::NEG_INFINITY, f64::max);
    let mut low = a.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    for _ in 0..60 {
        let x = 0.5 * (low + high);
        // All eigenvalues lie below x where no pivot of T − x is positive.
        let mut pivot = a[0] - x;
        let mut above = pivot > 0.0;
        for i in 1..a.len() {
            pivot = a[i] - x - b[i - 1] * b[i - 1] / pivot;
            above |= pivot > 0.0;
        }
        if above { low = x } else { high = x }
    }
    high
}

#[cfg(test)]
mod tests {
    use super::*;

    /// −1, 2, −1 has the eigenvalues 2 − 2 cos(kπ/(n+1)).
    #[test]
    fn the_largest_eigenvalue_of_a_chain() {
        let exact = 2.0 + 2.0 * (std::f64::consts::PI / 11.0).cos();
        assert!((largest_of_tridiagonal(&[2.0; 10], &[1.0; 9]) - exact).abs() < 1e-13);
    }
}
