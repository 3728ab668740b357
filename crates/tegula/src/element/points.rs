//! Generalised constitutive law by numerical integration: energy summed over integration points, whose materials may be
//! nonlinear and have history variables.
//!
//! ```text
//! ψ(s) = min over α of  ½ xᵀKx + Σ_p w_p W_p(L_p x − Σ f ε₀),    x = (s, α)
//! ```
//!
//! Every evaluation solves for the enhanced parameters α by Newton's method, starting from the committed ones of the
//! last step, and condenses them statically: `H = K_ss − K_sα K_αα⁻¹ K_αs`. Stress and tangent are therefore functions
//! of the sampled strains and of the committed history variables alone.

use std::sync::Arc;

use nalgebra::{DMatrix, Matrix6, Vector6};

use super::collected_law::Collector;
use super::enhanced_newton::{Correction, MAX_PARAMETERS, ParameterMatrix, Parameters, factor, solve};
use super::generalized_law::{GeneralizedLaw, energy_of_fields};
use super::group::InternalVariables;
use super::shell::{IntegrationPoint, PointResponse};
use crate::material::{Law, Response};

/// Largest number of internal variables at an integration point.
const MAX_HISTORY: usize = 16;
/// Newton iterations for the enhanced parameters before an evaluation fails.
const MAX_ITERATIONS: usize = 200;

/// Integration points of one element, sorted into linear and nonlinear ones.
#[derive(Debug, Clone)]
pub struct PointElement {
    /// K: summed stiffness of the linear integration points for x = (s, α).
    linear: DMatrix<f64>,
    /// Generalised stress, conjugate to x, of each prescribed strain field in the linear integration points, field by
    /// field.
    linear_prescribed: Vec<f64>,
    /// Energy of pairs of prescribed strains at the linear integration points, when fully restrained.
    linear_energy: Vec<f64>,
    /// Law, weight, L (6 rows of x), prescribed strains (6 per field) of the nonlinear integration points.
    points: Vec<(usize, f64, Vec<f64>, Vec<f64>)>,
}

impl PointElement {
    /// Sorts integration points and sums the linear ones.
    pub fn new(
        integration_points: Vec<IntegrationPoint>,
        samples: usize,
        parameters: usize,
        fields: usize,
    ) -> Self {
        let n = samples + parameters;
        let mut linear = DMatrix::zeros(n, n);
        let mut linear_prescribed = vec![0.0; n * fields];
        let mut linear_energy = vec![0.0; fields * fields];
        let mut points = Vec::new();
        for s in integration_points {
            let rows = s.samples.nrows();
            let l = DMatrix::from_fn(rows, n, |i, j| {
                if j < samples { s.samples[(i, j)] } else { s.enhanced[(i, j - samples)] }
            });
            match s.response {
                PointResponse::Linear(c) => {
                    let cl = &c * &l * s.weight;
                    for (field, e0) in s.prescribed.iter().enumerate() {
                        for (j, value) in (cl.transpose() * e0).iter().enumerate() {
                            linear_prescribed[n * field + j] += value;
                        }
                        for (other, e1) in s.prescribed.iter().enumerate() {
                            linear_energy[fields * field + other] += s.weight * (&c * e0).dot(e1);
                        }
                    }
                    linear += l.transpose() * cl;
                }
                PointResponse::Law(law) => {
                    let e0 = s.prescribed.iter().flat_map(|e| e.iter().copied()).collect();
                    points.push((law, s.weight, l.transpose().as_slice().to_vec(), e0));
                }
            }
        }
        Self { linear, linear_prescribed, linear_energy, points }
    }
}

/// Generalised constitutive law of a group, integrated point by point.
#[derive(Debug, Clone, Default)]
pub struct PointLaw<const S: usize> {
    laws: Vec<Law>,
    /// Number of enhanced parameters.
    parameters: usize,
    /// Nonlinear integration points per element.
    points: usize,
    law: Vec<u32>,
    weight: Vec<f64>,
    /// L by rows, `6 × (S + parameters)` per point.
    strain: Vec<f64>,
    /// Prescribed strains, 6 per field and point.
    prescribed: Vec<f64>,
    /// K of the linear integration points by rows per element; empty if there are none.
    linear: Vec<f64>,
    linear_prescribed: Vec<f64>,
    /// Energy of pairs of prescribed strains at the linear integration points, when fully restrained.
    linear_energy: Vec<f64>,
    /// Number of prescribed strain fields.
    fields: usize,
    /// History variables per element: enhanced parameters and internal variables.
    history: usize,
    /// H of the reference configuration, `S × S` per element.
    reference: Vec<f64>,
    /// Responses of laws that are evaluated at many points in one call; `None`: there are no such laws.
    collector: Option<Arc<Collector>>,
}

/// K_ss and K_sα of an element.
type Blocks<'a, const S: usize> = (&'a mut [[f64; S]; S], &'a mut [[f64; MAX_PARAMETERS]; S]);

/// Stress, energy and dissipation, summed over the integration points of an element.
struct Pass<const S: usize> {
    stress: [f64; S],
    energy: f64,
    dissipation: f64,
}

impl<const S: usize> PointLaw<S> {
    /// Law of a group from its elements.
    pub fn new(laws: Vec<Law>, elements: Vec<PointElement>, parameters: usize) -> Self {
        let n = S + parameters;
        let points = elements.first().map_or(0, |e| e.points.len());
        let fields = elements.first().map_or(0, |e| e.linear_prescribed.len() / n.max(1));
        let history = elements
            .first()
            .map_or(0, |e| parameters + e.points.iter().map(|p| laws[p.0].history()).sum::<usize>());
        let any_linear = elements.iter().any(|e| e.linear.iter().any(|k| *k != 0.0));
        let collector = laws.iter().any(Law::is_collected).then(Arc::default);
        let mut out = Self { laws, parameters, points, fields, history, collector, ..Self::default() };
        for e in elements {
            if any_linear {
                // Symmetric: columns serve as rows.
                out.linear.extend_from_slice(e.linear.as_slice());
                out.linear_prescribed.extend_from_slice(&e.linear_prescribed);
                out.linear_energy.extend_from_slice(&e.linear_energy);
            }
            for (law, weight, strain, prescribed) in e.points {
                out.law.push(law as u32);
                out.weight.push(weight);
                out.strain.extend(strain);
                out.prescribed.extend(prescribed);
            }
        }
        let elements = out.weight.len() / points.max(1);
        let zero = vec![0.0; history];
        let interior = InternalVariables { history: &zero, factors: &[] };
        let mut reference = vec![0.0; elements * S * S];
        out.evaluated(&mut || {
            for (e, block) in reference.chunks_exact_mut(S * S).enumerate() {
                out.with_tangent(e, &[0.0; S], &interior, |h| block.copy_from_slice(h));
            }
        });
        out.reference = reference;
        out
    }

    /// Strain at an integration point for x = (s, α).
    fn strain_at(
        &self,
        point: usize,
        s: &[f64; S],
        alpha: &Parameters,
        interior: &InternalVariables,
    ) -> Vector6<f64> {
        let n = S + self.parameters;
        let l = &self.strain[point * 6 * n..(point + 1) * 6 * n];
        let mut strain = Vector6::zeros();
        for (i, row) in l.chunks_exact(n).enumerate() {
            let (of_samples, of_parameters) = row.split_at(S);
            let mut sum = 0.0;
            for (a, b) in of_samples.iter().zip(s) {
                sum += a * b;
            }
            for (a, b) in of_parameters.iter().zip(alpha) {
                sum += a * b;
            }
            strain[i] = sum;
        }
        if self.fields != 0 {
            strain -= self.prescribed_at(point, interior);
        }
        strain
    }

    /// Prescribed strain at an integration point.
    fn prescribed_at(&self, point: usize, interior: &InternalVariables) -> Vector6<f64> {
        let fields = &self.prescribed[point * 6 * self.fields..(point + 1) * 6 * self.fields];
        let mut sum = Vector6::zeros();
        for (factor, e0) in interior.factors.iter().zip(fields.chunks_exact(6)) {
            for i in 0..6 {
                sum[i] += factor * e0[i];
            }
        }
        sum
    }

    /// Calls `f(point, law, strain, committed variables, their index range)` for the integration points of an element.
    fn for_each_point(
        &self,
        element: usize,
        s: &[f64; S],
        alpha: &Parameters,
        interior: &InternalVariables,
        mut f: impl FnMut(usize, &Law, &Vector6<f64>, &[f64], std::ops::Range<usize>) -> Option<()>,
    ) -> Option<()> {
        let mut at = self.parameters;
        for point in element * self.points..(element + 1) * self.points {
            let law = &self.laws[self.law[point] as usize];
            let place = at..at + law.history();
            at = place.end;
            let strain = self.strain_at(point, s, alpha, interior);
            f(point, law, &strain, &interior.history[place.clone()], place)?;
        }
        Some(())
    }

    /// Response of the law of an integration point.
    #[inline]
    fn respond(
        &self,
        point: usize,
        law: &Law,
        strain: &Vector6<f64>,
        committed: &[f64],
        updated: &mut [f64],
    ) -> Option<Response> {
        let collector = self.collector.as_ref().filter(|_| law.is_collected());
        match collector.and_then(|collector| collector.respond(self.law[point], strain)) {
            Some(response) => response,
            None => law.respond(strain, committed, updated),
        }
    }

    /// Row `i` of K x − Σ f σ₀ of the linear integration points.
    fn linear_row(
        &self,
        element: usize,
        i: usize,
        s: &[f64; S],
        alpha: &Parameters,
        interior: &InternalVariables,
    ) -> f64 {
        if self.linear.is_empty() {
            return 0.0;
        }
        let n = S + self.parameters;
        let row = &self.linear[(element * n + i) * n..(element * n + i + 1) * n];
        let mut sum: f64 = row[..S].iter().zip(s).map(|(a, b)| a * b).sum();
        sum += row[S..].iter().zip(alpha).map(|(a, b)| a * b).sum::<f64>();
        if self.fields != 0 {
            let fields = &self.linear_prescribed[element * n * self.fields..(element + 1) * n * self.fields];
            for (factor, field) in interior.factors.iter().zip(fields.chunks_exact(n)) {
                sum -= factor * field[i];
            }
        }
        sum
    }

    fn linear_entry(&self, element: usize, i: usize, j: usize) -> f64 {
        let n = S + self.parameters;
        self.linear.get((element * n + i) * n + j).copied().unwrap_or(0.0)
    }

    /// Enhanced parameters that make the energy stationary, and the factored K_αα there; `None` if a material law
    /// cannot be evaluated or Newton's method does not converge.
    fn parameters(
        &self,
        element: usize,
        s: &[f64; S],
        interior: &InternalVariables,
    ) -> Option<(Parameters, ParameterMatrix)> {
        let a = self.parameters;
        let mut alpha = [0.0; MAX_PARAMETERS];
        for (x, h) in alpha.iter_mut().zip(interior.history.iter().take(a)) {
            *x = *h;
        }
        let mut k = [[0.0; MAX_PARAMETERS]; MAX_PARAMETERS];
        if a == 0 {
            return Some((alpha, k));
        }
        let mut close = false;
        let mut last: Option<Correction> = None;
        for _ in 0..MAX_ITERATIONS {
            let (r, scale) = self.residual(element, s, &alpha, interior, &mut k)?;
            if let Some(last) = last.as_mut().filter(|_| !close)
                && let Some(back) = last.shortened(&r, a)
            {
                last.add(back, &mut alpha);
                continue;
            }
            factor(&mut k, a)?;
            if close {
                return Some((alpha, k));
            }
            let mut delta = r;
            solve(&k, a, &mut delta);
            let slope: f64 = (0..a).map(|i| delta[i] * r[i]).sum();
            if !slope.is_finite() {
                return None;
            }
            // Quadratic convergence: after the correction just made the error is below round-off.
            close = slope.abs() <= 1e-16 * scale;
            let correction = Correction::whole(delta, slope);
            correction.add(-1.0, &mut alpha);
            last = Some(correction);
        }
        None
    }

    /// Residual of the enhanced parameters, the energy of its terms, and the tangent K_αα, whose matrix is given.
    fn residual(
        &self,
        element: usize,
        s: &[f64; S],
        alpha: &Parameters,
        interior: &InternalVariables,
        k: &mut ParameterMatrix,
    ) -> Option<(Parameters, f64)> {
        let (a, n) = (self.parameters, S + self.parameters);
        let mut r = [0.0; MAX_PARAMETERS];
        let mut scale = 0.0;
        for i in 0..a {
            r[i] = self.linear_row(element, S + i, s, alpha, interior);
            for j in 0..a {
                k[i][j] = self.linear_entry(element, S + i, S + j);
            }
        }
        self.for_each_point(element, s, alpha, interior, |point, law, strain, committed, _| {
            let mut updated = [0.0; MAX_HISTORY];
            let response = self.respond(point, law, strain, committed, &mut updated[..committed.len()])?;
            let w = self.weight[point];
            let l = &self.strain[point * 6 * n..(point + 1) * 6 * n];
            scale += w * (response.tangent * strain).dot(strain).abs();
            if self.fields != 0 {
                // Free heating leaves no stress; round-off is that of the prescribed strain then.
                let prescribed = self.prescribed_at(point, interior);
                scale += w * (response.tangent * prescribed).dot(&prescribed).abs();
            }
            for j in 0..a {
                let g = Vector6::from_fn(|row, _| l[row * n + S + j]);
                r[j] += w * g.dot(&response.stress);
                let cg = response.tangent * g * w;
                for i in 0..=j {
                    let value: f64 = (0..6).map(|row| l[row * n + S + i] * cg[row]).sum();
                    k[i][j] += value;
                    if i != j {
                        k[j][i] += value;
                    }
                }
            }
            Some(())
        })?;
        Some((r, scale))
    }

    /// Stress, energy and updated history variables, and with `tangent` the blocks K_ss and K_sα.
    fn pass(
        &self,
        element: usize,
        s: &[f64; S],
        alpha: &Parameters,
        interior: &InternalVariables,
        mut tangent: Option<Blocks<'_, S>>,
        mut history: Option<&mut [f64]>,
    ) -> Option<Pass<S>> {
        let (a, n) = (self.parameters, S + self.parameters);
        let mut out = Pass { stress: [0.0; S], energy: 0.0, dissipation: 0.0 };
        if !self.linear.is_empty() {
            let f = self.fields;
            out.energy += energy_of_fields(&self.linear_energy[element * f * f..][..f * f], interior.factors);
            for i in 0..n {
                let row = self.linear_row(element, i, s, alpha, interior);
                let x = if i < S { s[i] } else { alpha[i - S] };
                // ½ xᵀKx − f·x: the row holds Kx − f.
                let kx: f64 = (0..n)
                    .map(|j| self.linear_entry(element, i, j) * if j < S { s[j] } else { alpha[j - S] })
                    .sum();
                out.energy += x * (row - 0.5 * kx);
                if i < S {
                    out.stress[i] = row;
                    if let Some((ss, sa)) = &mut tangent {
                        for j in 0..n {
                            let value = self.linear_entry(element, i, j);
                            if j < S { ss[i][j] = value } else { sa[i][j - S] = value }
                        }
                    }
                }
            }
        }
        self.for_each_point(element, s, alpha, interior, |point, law, strain, committed, place| {
            let mut updated = [0.0; MAX_HISTORY];
            let r = self.respond(point, law, strain, committed, &mut updated[..committed.len()])?;
            let w = self.weight[point];
            let l = &self.strain[point * 6 * n..(point + 1) * 6 * n];
            out.energy += w * r.energy;
            out.dissipation += w * r.dissipation;
            for (row, stress) in r.stress.iter().enumerate() {
                for (n_i, l_i) in out.stress.iter_mut().zip(&l[row * n..row * n + S]) {
                    *n_i += w * stress * l_i;
                }
            }
            if let Some((ss, sa)) = &mut tangent {
                add_tangent(l, n, &(r.tangent * w), a, ss, sa);
            }
            if let Some(history) = &mut history
                && let Some(out) = history.get_mut(place)
            {
                out.copy_from_slice(&updated[..committed.len()]);
            }
            Some(())
        })?;
        if let Some(history) = history {
            history[..a].copy_from_slice(&alpha[..a]);
        }
        Some(out)
    }

    fn stress_and_tangent(
        &self,
        element: usize,
        s: &[f64; S],
        interior: &InternalVariables,
        h: &mut [[f64; S]; S],
    ) -> Option<()> {
        let a = self.parameters;
        let (alpha, k_aa) = self.parameters(element, s, interior)?;
        let mut k_sa = [[0.0; MAX_PARAMETERS]; S];
        self.pass(element, s, &alpha, interior, Some((h, &mut k_sa)), None)?;
        for j in 0..S {
            let mut x = k_sa[j];
            solve(&k_aa, a, &mut x);
            for i in 0..S {
                let mut sum = 0.0;
                for c in 0..a {
                    sum += k_sa[i][c] * x[c];
                }
                h[i][j] -= sum;
            }
        }
        // Round-off leaves H unsymmetric in the last digit.
        for i in 0..S {
            for j in 0..i {
                let mean = 0.5 * (h[i][j] + h[j][i]);
                h[i][j] = mean;
                h[j][i] = mean;
            }
        }
        Some(())
    }

    fn multiply_reference(&self, element: usize, s: &[f64; S]) -> [f64; S] {
        let h = &self.reference[element * S * S..(element + 1) * S * S];
        std::array::from_fn(|i| h[i * S..(i + 1) * S].iter().zip(s).map(|(a, b)| a * b).sum())
    }
}

/// Adds LᵀCL, split into its blocks K_ss and K_sα.
fn add_tangent<const S: usize>(
    l: &[f64],
    n: usize,
    c: &Matrix6<f64>,
    a: usize,
    ss: &mut [[f64; S]; S],
    sa: &mut [[f64; MAX_PARAMETERS]; S],
) {
    for row in 0..6 {
        // (C L) by rows, then Lᵀ of it.
        let mut cl_s = [0.0; S];
        let mut cl_a = [0.0; MAX_PARAMETERS];
        for k in 0..6 {
            let value = c[(row, k)];
            if value != 0.0 {
                let l_k = &l[k * n..(k + 1) * n];
                for j in 0..S {
                    cl_s[j] += value * l_k[j];
                }
                for j in 0..a {
                    cl_a[j] += value * l_k[S + j];
                }
            }
        }
        for (i, &li) in l[row * n..row * n + S].iter().enumerate() {
            if li != 0.0 {
                for j in 0..S {
                    ss[i][j] += li * cl_s[j];
                }
                for j in 0..a {
                    sa[i][j] += li * cl_a[j];
                }
            }
        }
    }
}

impl<const S: usize> GeneralizedLaw<S> for PointLaw<S> {
    fn stress(&self, element: usize, s: &[f64; S], interior: &InternalVariables) -> [f64; S] {
        let parameters = self.parameters(element, s, interior);
        parameters
            .and_then(|(alpha, _)| self.pass(element, s, &alpha, interior, None, None))
            .map_or([f64::NAN; S], |p| p.stress)
    }

    /// Discrete gradient of O. Gonzalez, *Time integration and discrete Hamiltonian systems*, J. Nonlinear Sci. 6
    /// (1996) 449–467, in the metric of the reference stiffness.
    fn mean_stress(
        &self,
        element: usize,
        old: &[f64; S],
        new: &[f64; S],
        interior: &InternalVariables,
    ) -> [f64; S] {
        let middle = std::array::from_fn(|i| 0.5 * (old[i] + new[i]));
        let change: [f64; S] = std::array::from_fn(|i| new[i] - old[i]);
        let mut n = self.stress(element, &middle, interior);
        let direction = self.multiply_reference(element, &change);
        let dot = |a: &[f64; S], b: &[f64; S]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let size = dot(&direction, &change);
        let (before, after) = (self.energy(element, old, interior), self.energy(element, new, interior));
        if size > 1e-24 * (before.abs() + after.abs()) {
            let factor = (after - before - dot(&n, &change)) / size;
            for (n, d) in n.iter_mut().zip(&direction) {
                *n += factor * d;
            }
        }
        n
    }

    fn with_tangent<R>(
        &self,
        element: usize,
        s: &[f64; S],
        interior: &InternalVariables,
        f: impl FnOnce(&[f64]) -> R,
    ) -> R {
        let mut h = [[0.0; S]; S];
        if self.stress_and_tangent(element, s, interior, &mut h).is_none() {
            h = [[f64::NAN; S]; S];
        }
        f(h.as_flattened())
    }

    fn tangent_product(
        &self,
        element: usize,
        s: &[f64; S],
        change: &[f64; S],
        interior: &InternalVariables,
    ) -> [f64; S] {
        self.with_tangent(element, s, interior, |h| {
            std::array::from_fn(|i| h[i * S..(i + 1) * S].iter().zip(change).map(|(a, b)| a * b).sum())
        })
    }

    fn viscous(&self, element: usize, rate: &[f64; S]) -> [f64; S] {
        self.multiply_reference(element, rate)
    }

    fn energy(&self, element: usize, s: &[f64; S], interior: &InternalVariables) -> f64 {
        let parameters = self.parameters(element, s, interior);
        parameters
            .and_then(|(alpha, _)| self.pass(element, s, &alpha, interior, None, None))
            .map_or(f64::NAN, |p| p.energy)
    }

    fn evaluated(&self, work: &mut dyn FnMut()) {
        match &self.collector {
            Some(collector) => collector.run(&self.laws, work),
            None => work(),
        }
    }

    fn history(&self) -> usize {
        self.history
    }

    fn update(&self, element: usize, s: &[f64; S], interior: &InternalVariables, history: &mut [f64]) -> f64 {
        let parameters = self.parameters(element, s, interior);
        parameters
            .and_then(|(alpha, _)| self.pass(element, s, &alpha, interior, None, Some(history)))
            .map_or(f64::NAN, |p| p.dissipation)
    }
}
