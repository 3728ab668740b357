//! Sampled strains, the generalised strains of an element, as quadratic forms of nodal vectors.
//!
//! An element of `M` nodal vectors `v_a` has `S` sampled strains
//!
//! ```text
//! s_k(v) = Σ_t w_t (P_t · Q_t) − (value at the reference),   P = Σ_a p_a v_a,  Q = Σ_a q_a v_a
//! ```
//!
//! that is `s_k = Σ_ab A_k[a,b] v_a·v_b − s_k⁰` with `A_k = Σ_t w_t ½ (p qᵀ + q pᵀ)`. `P` and `Q` are *base vectors* of
//! the element ([`Directions`]): a tangent of the mid-surface at a sampling point, the director there, its derivative.
//! With the generalised stresses `n = ∂ψ/∂s`, work-conjugate to the sampled strains, follow
//!
//! ```text
//! B = ∂s/∂v          strain–displacement matrix, rows 2 Σ_b A_k[a,b] v_bᵀ
//! f = Bᵀ n           internal force
//! K = Bᵀ H B + Σ_k 2 n_k A_k ⊗ I₃       exact tangent, symmetric
//! ```
//!
//! Strains are computed from displacements, `s = P₀·q + p·Q₀ + p·q`, not as a difference of two metrics, in which thin
//! shells under small loads would lose digits.

use super::scalar::{Scalar, Triple, dot};

/// Base vectors of one element, `D` of them.
pub type Directions<T, const D: usize> = [Triple<T>; D];

/// Term `weight · (left · right)` of a sampled strain.
#[derive(Debug, Clone, Copy)]
struct Term {
    sample: usize,
    weight: f64,
    left: usize,
    right: usize,
}

/// Sampled strains of an element type: `M` nodal vectors, `N = 3 M` coordinates, `S` sampled strains, at most `D` base
/// vectors.
#[derive(Debug, Clone)]
pub struct SampledStrains<const M: usize, const N: usize, const S: usize, const D: usize> {
    directions: Vec<[f64; M]>,
    terms: Vec<Term>,
    /// `2 A_k`, lower triangle by rows, for the geometric part of the tangent.
    geometric: Vec<Vec<f64>>,
}

impl<const M: usize, const N: usize, const S: usize, const D: usize> Default for SampledStrains<M, N, S, D> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const M: usize, const N: usize, const S: usize, const D: usize> SampledStrains<M, N, S, D> {
    /// Blocks in the lower triangle of the element matrix.
    pub const BLOCKS: usize = M * (M + 1) / 2;

    /// Empty table, without base vectors and terms.
    pub fn new() -> Self {
        const { assert!(N == 3 * M) };
        Self { directions: Vec::new(), terms: Vec::new(), geometric: vec![vec![0.0; Self::BLOCKS]; S] }
    }

    /// Adds a base vector `Σ_a coefficients[a] v_a` and returns its index.
    pub fn direction(&mut self, coefficients: [f64; M]) -> usize {
        debug_assert!(self.directions.len() < D);
        self.directions.push(coefficients);
        self.directions.len() - 1
    }

    /// Adds the term `weight · (left · right)` to a sampled strain.
    pub fn product(&mut self, sample: usize, weight: f64, left: usize, right: usize) {
        self.terms.push(Term { sample, weight, left, right });
        let (p, q) = (self.directions[left], self.directions[right]);
        let mut block = 0;
        for a in 0..M {
            for b in 0..=a {
                self.geometric[sample][block] += weight * (p[a] * q[b] + q[a] * p[b]);
                block += 1;
            }
        }
    }

    /// `2 A_k` of a sampled strain, lower triangle by rows.
    pub fn form(&self, sample: usize) -> &[f64] {
        &self.geometric[sample]
    }

    /// Base vectors for the nodal vectors `v`.
    #[inline(always)]
    pub fn directions<T: Scalar>(&self, v: &[Triple<T>; M]) -> Directions<T, D> {
        let mut out = [[T::from(0.0); 3]; D];
        for (value, coefficients) in out.iter_mut().zip(&self.directions) {
            for a in 0..M {
                let c = coefficients[a];
                if c != 0.0 {
                    let c = T::from(c);
                    for i in 0..3 {
                        value[i] += c * v[a][i];
                    }
                }
            }
        }
        out
    }

    /// Sampled strains from the base vectors `p0` of the reference configuration and their displacements `p`;
    /// `quadratic = false` leaves out the products of displacements (geometrically linear).
    #[inline(always)]
    pub fn strains<T: Scalar>(&self, p0: &Directions<T, D>, p: &Directions<T, D>, quadratic: bool) -> [T; S] {
        let mut s = [T::from(0.0); S];
        for t in &self.terms {
            let mut value = dot(p0[t.left], p[t.right]) + dot(p[t.left], p0[t.right]);
            if quadratic {
                value += dot(p[t.left], p[t.right]);
            }
            s[t.sample] += T::from(t.weight) * value;
        }
        s
    }

    /// `B(x) v`: change of the sampled strains at the base vectors `x` with the base vectors `v` of a velocity or
    /// increment.
    #[inline(always)]
    pub fn rates<T: Scalar>(&self, x: &Directions<T, D>, v: &Directions<T, D>) -> [T; S] {
        let mut s = [T::from(0.0); S];
        for t in &self.terms {
            s[t.sample] += T::from(t.weight) * (dot(x[t.left], v[t.right]) + dot(v[t.left], x[t.right]));
        }
        s
    }

    /// `Bᵀ(x) n`: nodal forces of the generalised stresses `n` at the base vectors `x`.
    #[inline(always)]
    pub fn force<T: Scalar>(&self, x: &Directions<T, D>, n: &[T; S]) -> [Triple<T>; M] {
        let mut on_direction = [[T::from(0.0); 3]; D];
        for t in &self.terms {
            let w = T::from(t.weight) * n[t.sample];
            for i in 0..3 {
                on_direction[t.left][i] += w * x[t.right][i];
                on_direction[t.right][i] += w * x[t.left][i];
            }
        }
        let mut f = [[T::from(0.0); 3]; M];
        for (force, coefficients) in on_direction.iter().zip(&self.directions) {
            for a in 0..M {
                let c = coefficients[a];
                if c != 0.0 {
                    let c = T::from(c);
                    for i in 0..3 {
                        f[a][i] += c * force[i];
                    }
                }
            }
        }
        f
    }

    /// Strain–displacement matrix `B(x)`: derivatives of the sampled strains with respect to the coordinates.
    #[inline(always)]
    pub fn gradient(&self, x: &Directions<f64, D>) -> [[f64; N]; S] {
        let mut s = [[0.0; N]; S];
        for t in &self.terms {
            let (p, q) = (&self.directions[t.left], &self.directions[t.right]);
            let row = &mut s[t.sample];
            for a in 0..M {
                let (wp, wq) = (t.weight * p[a], t.weight * q[a]);
                if wp == 0.0 && wq == 0.0 {
                    continue;
                }
                for i in 0..3 {
                    row[3 * a + i] += wp * x[t.right][i] + wq * x[t.left][i];
                }
            }
        }
        s
    }

    /// Tangent `material · BᵀHB + geometric · Σ_k 2 n_k A_k ⊗ I₃`, written to the blocks of the lower triangle of an
    /// element matrix: block (a, b ≤ a) at `9 (a (a+1)/2 + b)`, by rows.
    #[inline(always)]
    pub fn tangent(
        &self,
        h: &[f64],
        gradient: &[[f64; N]; S],
        n: &[f64; S],
        material: f64,
        geometric: f64,
        blocks: &mut [f64],
    ) {
        let mut hs = [[0.0; N]; S];
        for (row, h_row) in hs.iter_mut().zip(h.chunks_exact(S)) {
            for (s_row, &h_kl) in gradient.iter().zip(h_row) {
                if h_kl != 0.0 {
                    for j in 0..N {
                        row[j] += h_kl * s_row[j];
                    }
                }
            }
        }
        let mut first = 0;
        for a in 0..M {
            for i in 0..3 {
                let mut row = [0.0; N];
                for (s_row, hs_row) in gradient.iter().zip(&hs) {
                    let s = material * s_row[3 * a + i];
                    if s != 0.0 {
                        for j in 0..N {
                            row[j] += s * hs_row[j];
                        }
                    }
                }
                let rows = blocks[9 * first..].chunks_exact_mut(9).zip(row.as_chunks::<3>().0);
                for (block, values) in rows.take(a + 1) {
                    // A loop: a copy of so few numbers would be a call.
                    for (to, from) in block[3 * i..3 * i + 3].iter_mut().zip(values) {
                        *to = *from;
                    }
                }
            }
            first += a + 1;
        }
        if geometric != 0.0 {
            for (block, values) in blocks.chunks_exact_mut(9).enumerate() {
                let mut g = 0.0;
                for (a_k, &n_k) in self.geometric.iter().zip(n) {
                    g += a_k[block] * n_k;
                }
                g *= geometric;
                values[0] += g;
                values[4] += g;
                values[8] += g;
            }
        }
    }
}
