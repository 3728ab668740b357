//! Strains, forces and tangent of bilinear shells in vector registers: the arithmetic of
//! [`BilinearGroup`](super::bilinear::BilinearGroup), one element per lane.
//!
//! Macros unroll the loops over the terms of the forms, so that all indices are known at compile time and intermediate
//! values stay in registers.

use pulp::{Simd, bytemuck};

use super::bilinear::{BLOCKS, BilinearGroup, COORDINATES, Coupled, ROWS, lower};
use super::forms::{BASIS, D0, D1, D2, D3, MOST, R1, R2, R3, VECTORS, quadratic_terms, surface_terms};
use super::group::{GroupPoint, Motion, Nodal, TangentWeights};
use super::lanes::{BATCH, Lanes};
use super::quadratic::{add_curvature, multiply_blocks};

/// Number of 3×3 blocks in the lower triangle of the element matrix in the basis.
const BASIS_BLOCKS: usize = BASIS * (BASIS + 1) / 2;

/// Three-dimensional vector per lane.
pub type Triple<S> = [<S as Simd>::f64s; 3];
/// Basis vectors r₁ r₂ r₃ d₀ d₁ d₂ d₃ per lane.
pub type Basis<S> = [Triple<S>; BASIS];
/// One number per form and lane.
pub type PerForm<S> = [<S as Simd>::f64s; MOST];

/// Workspace for strains and generalised stresses; it is reused, since clearing it would take time.
pub type StrainAndStress<S> = [PerForm<S>; 2];

/// New workspace for strains and generalised stresses.
#[inline(always)]
pub fn strain_and_stress<S: Simd>(simd: S) -> StrainAndStress<S> {
    [[simd.splat_f64s(0.0); MOST]; 2]
}

/// Strain measure of a motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Measure {
    /// Strain from which the stress follows with Kelvin–Voigt damping: mean strain plus the retardation time times its
    /// rate.
    Effective,
    /// Strain at the end of the motion.
    End,
    /// Strain rate.
    Rate,
}

/// Workspace for the tangents of the elements of a register.
pub struct Workspace<S: Simd> {
    forms: StrainAndStress<S>,
    /// Rows of H B.
    hs: [Triple<S>; MOST + ROWS],
    /// Lower-triangle blocks in the basis.
    basis: [[S::f64s; 9]; BASIS_BLOCKS],
    /// Lower-triangle blocks of the nodal vectors.
    nodal: [[S::f64s; 9]; BLOCKS],
}

impl<S: Simd> Workspace<S> {
    #[inline(always)]
    /// Memory for the registers of an instruction set.
    pub fn new(simd: S) -> Self {
        let zero = simd.splat_f64s(0.0);
        let forms = strain_and_stress(simd);
        Self {
            forms,
            hs: [[zero; 3]; MOST + ROWS],
            basis: [[zero; 9]; BASIS_BLOCKS],
            nodal: [[zero; 9]; BLOCKS],
        }
    }
}

impl BilinearGroup {
    /// Batch for the shapes of these lanes in an array of `per_shape` values per shape.
    #[inline(always)]
    fn of_shape<'a, S: Simd>(&self, l: Lanes<S>, values: &'a [f64], per_shape: usize) -> &'a [S::f64s] {
        l.batch_at(values, per_shape, self.of_batch[l.first / BATCH] as usize)
    }

    /// Basis vectors of a nodal field.
    #[inline(always)]
    pub fn basis<S: Simd>(&self, l: Lanes<S>, field: &[Nodal]) -> Basis<S> {
        // Lanes without an element repeat the last one.
        let last = self.vectors.len() - 1;
        let vectors: [&[u32; VECTORS]; BATCH] =
            std::array::from_fn(|lane| &self.vectors[(l.first + lane.min(Lanes::<S>::LANES - 1)).min(last)]);
        let nodal: [Triple<S>; VECTORS] = std::array::from_fn(|a| {
            let values: [&Nodal; BATCH] = std::array::from_fn(|lane| &field[vectors[lane][a] as usize]);
            std::array::from_fn(|i| l.gather(|lane| values[lane][i]))
        });
        let mut out = [[l.splat(0.0); 3]; BASIS];
        for i in 0..3 {
            let (a, b, c, d) = (nodal[0][i], nodal[1][i], nodal[2][i], nodal[3][i]);
            let (right, left) = (l.sub(b, a), l.sub(c, d));
            out[0][i] = l.add(right, left);
            out[1][i] = l.add(l.sub(d, a), l.sub(c, b));
            out[2][i] = l.sub(left, right);
            let (a, b, c, d) = (nodal[4][i], nodal[5][i], nodal[6][i], nodal[7][i]);
            let (right, left) = (l.sub(b, a), l.sub(c, d));
            out[3][i] = l.add(l.add(a, b), l.add(c, d));
            out[4][i] = l.add(right, left);
            out[5][i] = l.add(l.sub(d, a), l.sub(c, b));
            out[6][i] = l.sub(left, right);
        }
        out
    }

    /// `Σ a·b` of the terms of each form, with a of `left` and b of `right`.
    #[inline(always)]
    pub fn products<S: Simd>(&self, l: Lanes<S>, left: &Basis<S>, right: &Basis<S>) -> PerForm<S> {
        let mut out = [l.splat(0.0); MOST];
        macro_rules! add {
            ($form:literal, $a:ident, $b:ident) => {
                for i in 0..3 {
                    out[$form] = l.mul_add(left[$a][i], right[$b][i], out[$form]);
                }
            };
        }
        surface_terms!(add);
        if self.quadratic {
            quadratic_terms!(add);
        }
        out
    }

    /// Computes the strains of a motion; returns the basis vectors of the configuration in which its stress acts.
    #[inline(always)]
    pub fn strained<S: Simd>(
        &self,
        l: Lanes<S>,
        k: &GroupPoint,
        wanted: Measure,
        strain: &mut PerForm<S>,
    ) -> Basis<S> {
        let tau = self.retardation_time;
        // Fields, their weight in the configuration in which the stress acts, and in the result. The last field of a
        // state is a velocity.
        let (fields, share, weights, rate) = match (k.motion, wanted) {
            (Motion::State { u, .. }, Measure::End) => ([Some(u), None], 1.0, [1.0, 0.0], false),
            (Motion::State { u, velocity }, Measure::Rate) => ([Some(u), velocity], 1.0, [0.0, 1.0], true),
            (Motion::State { u, velocity }, Measure::Effective) => {
                ([Some(u), velocity.filter(|_| tau != 0.0)], 1.0, [1.0, tau], true)
            }
            (Motion::Step { new, .. }, Measure::End) => ([Some(new), None], 1.0, [1.0, 0.0], false),
            (Motion::Step { old, new, dt }, Measure::Rate) => {
                ([Some(old), Some(new)], 0.5, [-1.0 / dt, 1.0 / dt], false)
            }
            (Motion::Step { old, new, dt }, Measure::Effective) => {
                ([Some(old), Some(new)], 0.5, [0.5 - tau / dt, 0.5 + tau / dt], false)
            }
        };
        let nonlinear = if k.linear { 0.0 } else { 1.0 };
        let reference = l.batch(&self.reference, 3 * BASIS);
        let mut p0 = [[l.splat(0.0); 3]; BASIS];
        for v in 0..BASIS {
            for i in 0..3 {
                p0[v][i] = reference[l.part(3 * v + i)];
            }
        }
        let mut acting = p0;
        for (at, field) in fields.into_iter().enumerate() {
            let Some(field) = field else { continue };
            let p = self.basis(l, field);
            // The change of P·Q from the reference is p·(Q₀ + q/2) + q·(P₀ + p/2): no difference of large numbers.
            let other = if rate && at == 1 { acting } else { advanced(l, p0, &p, 0.5 * nonlinear) };
            let (products, weight) = (self.products(l, &p, &other), l.splat(weights[at]));
            for (s, product) in strain.iter_mut().zip(products) {
                *s = if at == 0 { l.mul(weight, product) } else { l.mul_add(weight, product, *s) };
            }
            if !(rate && at == 1) {
                acting = advanced(l, acting, &p, share * nonlinear);
            }
        }
        acting
    }

    /// `H s`.
    #[inline(always)]
    pub fn multiply<S: Simd>(&self, l: Lanes<S>, s: &PerForm<S>) -> PerForm<S> {
        let h = self.of_shape(l, &self.h, self.entries);
        let mut out = [l.splat(0.0); MOST];
        for c in &self.coupled {
            multiply_large(l, c, h, s, &mut out);
        }
        out
    }

    /// `H s` with the loops over the usual block sizes unrolled.
    #[inline(always)]
    fn multiply_fast<S: Simd>(&self, l: Lanes<S>, s: &PerForm<S>, out: &mut PerForm<S>) {
        let h = self.of_shape(l, &self.h, self.entries);
        for c in &self.coupled {
            macro_rules! by_size {
                ($($n:literal)*) => {
                    match c.forms.len() {
                        $($n => multiply_block::<S, $n>(l, c, h, s, out),)*
                        _ => multiply_large(l, c, h, s, out),
                    }
                };
            }
            by_size!(1 2 3 4 6 8 14);
        }
    }

    /// Generalised stresses of strains under the prescribed strains; entries of forms that the elements do not need
    /// stay unchanged.
    #[inline(always)]
    pub fn stress<S: Simd>(&self, l: Lanes<S>, strain: &PerForm<S>, factors: &[f64], n: &mut PerForm<S>) {
        self.multiply_fast(l, strain, n);
        if self.fields != 0 {
            let fields = self.of_shape(l, &self.prescribed, self.fields * MOST);
            for (field, &factor) in factors.iter().enumerate() {
                let factor = l.splat(-factor);
                for k in 0..MOST {
                    n[k] = l.mul_add(factor, fields[l.part(field * MOST + k)], n[k]);
                }
            }
        }
    }

    /// Potential of the prescribed strains, −Σ f n₀·s.
    #[inline(always)]
    pub fn potential<S: Simd>(&self, l: Lanes<S>, s: &PerForm<S>, factors: &[f64]) -> S::f64s {
        let mut sum = l.splat(0.0);
        if self.fields != 0 {
            let fields = self.of_shape(l, &self.prescribed, self.fields * MOST);
            for (field, &factor) in factors.iter().enumerate() {
                let factor = l.splat(-factor);
                for k in 0..MOST {
                    sum = l.mul_add(l.mul(factor, s[k]), fields[l.part(field * MOST + k)], sum);
                }
            }
        }
        sum
    }

    /// Basis vectors of the configuration with the displacements `u`.
    #[inline(always)]
    pub fn current_basis<S: Simd>(&self, l: Lanes<S>, u: &[Nodal]) -> Basis<S> {
        let reference = l.batch(&self.reference, 3 * BASIS);
        let mut x = self.basis(l, u);
        for v in 0..BASIS {
            for i in 0..3 {
                x[v][i] = l.add(x[v][i], reference[l.part(3 * v + i)]);
            }
        }
        x
    }

    /// Nodal forces of the generalised stresses `n` in the configuration `x`.
    #[inline(always)]
    fn forces<S: Simd>(&self, l: Lanes<S>, x: &Basis<S>, n: &PerForm<S>) -> [Triple<S>; VECTORS] {
        let mut f = [[l.splat(0.0); 3]; BASIS];
        self.add_basis_forces(l, x, n, &mut f);
        self.nodal_forces(l, &f)
    }

    /// Adds the forces, conjugate to the basis vectors, of the generalised stresses `n` in the configuration `x`.
    #[inline(always)]
    pub fn add_basis_forces<S: Simd>(&self, l: Lanes<S>, x: &Basis<S>, n: &PerForm<S>, f: &mut Basis<S>) {
        macro_rules! add {
            ($form:literal, $a:ident, $b:ident) => {
                for i in 0..3 {
                    f[$a][i] = l.mul_add(n[$form], x[$b][i], f[$a][i]);
                }
            };
        }
        surface_terms!(add);
        if self.quadratic {
            quadratic_terms!(add);
        }
    }

    /// Nodal forces of forces that are conjugate to the basis vectors.
    #[inline(always)]
    pub fn nodal_forces<S: Simd>(&self, l: Lanes<S>, f: &Basis<S>) -> [Triple<S>; VECTORS] {
        let mut out = [[l.splat(0.0); 3]; VECTORS];
        for i in 0..3 {
            let r = from_three(l, [f[0][i], f[1][i], f[2][i]]);
            let d = from_four(l, [f[3][i], f[4][i], f[5][i], f[6][i]]);
            for a in 0..4 {
                out[a][i] = r[a];
                out[4 + a][i] = d[a];
            }
        }
        out
    }

    /// Adds the material part `factor · Bᵀ H B` of the tangent in the basis.
    #[inline(always)]
    fn add_material<S: Simd>(&self, l: Lanes<S>, x: &Basis<S>, factor: f64, work: &mut Workspace<S>) {
        let zero = l.splat(0.0);
        let factor = l.splat(factor);
        let mut scaled = *x;
        for x in &mut scaled {
            for x in x {
                *x = l.mul(factor, *x);
            }
        }
        let h = self.of_shape(l, &self.h, self.entries);
        for c in &self.coupled {
            let rows = c.forms.len().next_multiple_of(ROWS);
            for b in 0..BASIS {
                let own = &c.derivatives[b];
                if own.is_empty() {
                    continue;
                }
                for row in (0..rows).step_by(ROWS) {
                    let mut sum = [[zero; 3]; ROWS];
                    for &(m, v) in own {
                        let places = &c.places[m * rows + row..m * rows + row + ROWS];
                        let v = &scaled[v];
                        for r in 0..ROWS {
                            let h = h[l.part(places[r])];
                            for i in 0..3 {
                                sum[r][i] = l.mul_add(h, v[i], sum[r][i]);
                            }
                        }
                    }
                    work.hs[row..row + ROWS].copy_from_slice(&sum);
                }
                for a in b..BASIS {
                    let others = &c.derivatives[a];
                    if others.is_empty() {
                        continue;
                    }
                    let block = &mut work.basis[lower(a, b)];
                    let mut sum = *block;
                    for &(m, v) in others {
                        let (s, hs) = (&x[v], &work.hs[m]);
                        for i in 0..3 {
                            for j in 0..3 {
                                sum[3 * i + j] = l.mul_add(s[i], hs[j], sum[3 * i + j]);
                            }
                        }
                    }
                    *block = sum;
                }
            }
        }
    }

    /// Adds the geometric part of the tangent in the basis: second derivatives of the forms times generalised stresses.
    #[inline(always)]
    fn add_geometric<S: Simd>(&self, l: Lanes<S>, n: &PerForm<S>, factor: f64, work: &mut Workspace<S>) {
        let factor = l.splat(factor);
        macro_rules! add {
            ($form:literal, $a:ident, $b:ident) => {
                if $a >= $b {
                    let n = l.mul(factor, n[$form]);
                    let block = &mut work.basis[lower($a, $b)];
                    block[0] = l.add(block[0], n);
                    block[4] = l.add(block[4], n);
                    block[8] = l.add(block[8], n);
                }
            };
        }
        surface_terms!(add);
        if self.quadratic {
            quadratic_terms!(add);
        }
    }

    /// Internal forces of the elements of a register.
    #[inline(always)]
    pub fn force_lanes<S: Simd>(
        &self,
        l: Lanes<S>,
        k: &GroupPoint,
        forces: &mut [f64],
        [strain, n]: &mut StrainAndStress<S>,
    ) {
        let acting = self.strained(l, k, Measure::Effective, strain);
        self.stress(l, strain, k.interior.factors, n);
        l.write(self.forces(l, &acting, n).as_flattened(), COORDINATES, forces);
    }

    /// Internal forces and tangent of the elements of a register.
    #[inline(always)]
    pub fn tangent_lanes<S: Simd>(
        &self,
        l: Lanes<S>,
        k: &GroupPoint,
        forces: &mut [f64],
        tangent: LanesTangent,
        work: &mut Workspace<S>,
    ) {
        let [strain, n] = &mut work.forms;
        let acting = self.strained(l, k, Measure::Effective, strain);
        self.stress(l, strain, k.interior.factors, n);
        l.write(self.forces(l, &acting, n).as_flattened(), COORDINATES, forces);
        // A copy, since the stored stresses read below must not stay in the workspace.
        let mut n = *n;
        let LanesTangent { weights: w, stress, prescribed, blocks } = tangent;
        if let Some(stored) = stress {
            l.read(stored, self.stored, &mut n);
        }
        let material = w.force * (w.stress + self.retardation_time * w.rate);
        let geometric = if k.linear { 0.0 } else { w.force * w.direction };
        work.basis.fill([l.splat(0.0); 9]);
        self.add_material(l, &acting, material, work);
        if geometric != 0.0 {
            self.add_geometric(l, &n, geometric, work);
        }
        to_nodes(l, &work.basis, &mut work.nodal);
        l.write(work.nodal.as_flattened(), 9 * BLOCKS, blocks);
        let elements = blocks.chunks_exact_mut(9 * BLOCKS).enumerate();
        if !k.linear && !k.inextensible.is_empty() {
            let f = self.forces(l, &acting, &n);
            let f: &[f64] = bytemuck::cast_slice(f.as_flattened());
            for (lane, blocks) in elements {
                let mut own = [[0.0; 3]; VECTORS];
                for (i, own) in own.as_flattened_mut().iter_mut().enumerate() {
                    *own = f[i * Lanes::<S>::LANES + lane];
                }
                add_curvature(k, &self.vectors[l.first + lane], &own, geometric, blocks);
            }
        }
        if let Some(increment) = prescribed {
            let elements = forces.chunks_exact_mut(COORDINATES).zip(blocks.chunks_exact(9 * BLOCKS));
            for (lane, (force, blocks)) in elements.enumerate() {
                let d = self.vectors[l.first + lane].map(|v| increment[v as usize]);
                if d.iter().any(|v| *v != [0.0; 3]) {
                    multiply_blocks(blocks, &d, 1.0 / w.force, force);
                }
            }
        }
    }
}

/// [`TangentRequest`](super::TangentRequest) with the blocks of one register of elements.
pub struct LanesTangent<'a> {
    /// Weights of the parts of the tangent.
    pub weights: &'a TangentWeights,
    /// Generalised stresses of the geometric part, for all elements of the group; `None`: stress of the motion.
    pub stress: Option<&'a [f64]>,
    /// Increment of the prescribed degrees of freedom, zero elsewhere.
    pub prescribed: Option<&'a [Nodal]>,
    /// Output: lower-triangle blocks of these elements.
    pub blocks: &'a mut [f64],
}

/// Product with a diagonal block of H of known size, written to `out`; the lower triangle stands for both.
#[inline(always)]
fn multiply_block<S: Simd, const N: usize>(
    l: Lanes<S>,
    c: &Coupled,
    h: &[S::f64s],
    s: &PerForm<S>,
    out: &mut PerForm<S>,
) {
    let mut own = [l.splat(0.0); N];
    for i in 0..N {
        own[i] = s[c.forms[i]];
    }
    let mut product = [l.splat(0.0); N];
    let size = N * (N + 1) / 2;
    let first = l.part(c.first);
    let h = &h[first..first + (size - 1) * Lanes::<S>::PARTS + 1];
    // Two rows at a time: two sums in registers, and each product of a column is updated once for both.
    let place = |i, j| lower(i, j) * Lanes::<S>::PARTS;
    for i in (1..N).step_by(2) {
        let mut sums = [l.splat(0.0); 2];
        for j in 0..i - 1 {
            let (h0, h1) = (h[place(i - 1, j)], h[place(i, j)]);
            sums[0] = l.mul_add(h0, own[j], sums[0]);
            sums[1] = l.mul_add(h1, own[j], sums[1]);
            product[j] = l.mul_add(h0, own[i - 1], l.mul_add(h1, own[i], product[j]));
        }
        let (h00, h10, h11) = (h[place(i - 1, i - 1)], h[place(i, i - 1)], h[place(i, i)]);
        product[i - 1] = l.mul_add(h00, own[i - 1], l.mul_add(h10, own[i], sums[0]));
        product[i] = l.mul_add(h10, own[i - 1], l.mul_add(h11, own[i], sums[1]));
    }
    if N % 2 == 1 {
        let i = N - 1;
        let mut sum = l.splat(0.0);
        for j in 0..i {
            let h = h[place(i, j)];
            sum = l.mul_add(h, own[j], sum);
            product[j] = l.mul_add(h, own[i], product[j]);
        }
        product[i] = l.mul_add(h[place(i, i)], own[i], sum);
    }
    for i in 0..N {
        out[c.forms[i]] = product[i];
    }
}

/// Product with a diagonal block of H of any size, written to `out`.
#[inline(always)]
fn multiply_large<S: Simd>(l: Lanes<S>, c: &Coupled, h: &[S::f64s], s: &PerForm<S>, out: &mut PerForm<S>) {
    let n = c.forms.len();
    let rows = n.next_multiple_of(ROWS);
    for row in (0..n).step_by(ROWS) {
        let mut sum = [l.splat(0.0); ROWS];
        for (m, &form) in c.forms.iter().enumerate() {
            let places = &c.places[m * rows + row..m * rows + row + ROWS];
            for r in 0..ROWS {
                sum[r] = l.mul_add(h[l.part(places[r])], s[form], sum[r]);
            }
        }
        for (&form, &sum) in c.forms[row..].iter().zip(&sum) {
            out[form] = sum;
        }
    }
}

/// Scalar product `a·b` over the forms.
#[inline(always)]
pub fn dot<S: Simd>(l: Lanes<S>, a: &PerForm<S>, b: &PerForm<S>) -> S::f64s {
    let mut sum = l.splat(0.0);
    for (a, b) in a.iter().zip(b) {
        sum = l.mul_add(*a, *b, sum);
    }
    sum
}

/// `x + factor · p`.
#[inline(always)]
fn advanced<S: Simd>(l: Lanes<S>, mut x: Basis<S>, p: &Basis<S>, factor: f64) -> Basis<S> {
    let factor = l.splat(factor);
    for (x, p) in x.iter_mut().zip(p) {
        for i in 0..3 {
            x[i] = l.mul_add(factor, p[i], x[i]);
        }
    }
    x
}

/// Values `Σ_m ξ_m k_m` at the four nodes, m = 1 … 3: without the constant.
#[inline(always)]
fn from_three<S: Simd>(l: Lanes<S>, [k1, k2, k3]: [S::f64s; 3]) -> [S::f64s; 4] {
    let (u, v) = (l.add(k1, k2), l.sub(k1, k2));
    [l.sub(k3, u), l.sub(v, k3), l.add(k3, u), l.sub(l.sub(k2, k1), k3)]
}

/// Values `Σ_m ξ_m k_m` at the four nodes, m = 0 … 3: with the constant.
#[inline(always)]
fn from_four<S: Simd>(l: Lanes<S>, [k0, k1, k2, k3]: [S::f64s; 4]) -> [S::f64s; 4] {
    let (u, v) = (l.add(k1, k2), l.sub(k1, k2));
    let (p, q) = (l.add(k0, k3), l.sub(k0, k3));
    [l.sub(p, u), l.add(q, v), l.add(p, u), l.sub(q, v)]
}

/// Blocks of the lower triangle of the element matrix from those in the basis.
#[inline(always)]
fn to_nodes<S: Simd>(l: Lanes<S>, k: &[[S::f64s; 9]; BASIS_BLOCKS], out: &mut [[S::f64s; 9]; BLOCKS]) {
    let zero = l.splat(0.0);
    for i in 0..3 {
        for j in 0..3 {
            let (at, turned) = (3 * i + j, 3 * j + i);
            // All pairs of vectors of the basis, both triangles.
            let mut full = [[zero; BASIS]; BASIS];
            for m in 0..BASIS {
                for n in 0..m {
                    full[m][n] = k[lower(m, n)][at];
                    full[n][m] = k[lower(m, n)][turned];
                }
                full[m][m] = k[lower(m, m)][at];
            }
            // Positions first, over the rows, then over the columns; then directors with positions and directors.
            let mut columns = [[zero; 4]; BASIS];
            for n in 0..3 {
                columns[n] = from_three(l, [full[0][n], full[1][n], full[2][n]]);
            }
            for a in 0..4 {
                let row = from_three(l, [columns[0][a], columns[1][a], columns[2][a]]);
                for b in 0..=a {
                    out[lower(a, b)][at] = row[b];
                }
            }
            for n in 0..BASIS {
                columns[n] = from_four(l, [full[3][n], full[4][n], full[5][n], full[6][n]]);
            }
            for a in 0..4 {
                let row = from_three(l, [columns[0][a], columns[1][a], columns[2][a]]);
                for b in 0..4 {
                    out[lower(4 + a, b)][at] = row[b];
                }
                let row = from_four(l, [columns[3][a], columns[4][a], columns[5][a], columns[6][a]]);
                for b in 0..=a {
                    out[lower(4 + a, 4 + b)][at] = row[b];
                }
            }
        }
    }
}
