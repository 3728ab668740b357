//! Critical points of steps under loads without a potential.
//!
//! The tangent `K + N` is unsymmetric, and the inertia of its symmetric part tells no critical points. The sign of its determinant does:
//! it changes where a real eigenvalue passes through zero, at limit points and at bifurcations (R. Seydel, *Practical bifurcation and
//! stability analysis*, 2010, Sect. 5.2). Two eigenvalues that pass through zero in one step do not change it; the numbers of negative eigenvalues of the symmetric
//! part and of eigenvalues that pass through zero while the circulatory part grows tell them, and the step is divided.
//!
//! At a critical point the left eigenvector ψ, `(K − N) ψ = 0`, tells both kinds apart: the loads F do work on it at limit points, and none
//! at bifurcations. The eigenvalue μ passes through zero as `dμ/da = (d²λ/da²) ψᵀF / ψᵀφ` there.

use super::inside_step::Known;
use super::{ArcLengthSteps, ArcStart, End};
use crate::analysis::Observer;
use crate::analysis::newton::TangentPart;
use crate::analysis::path::critical_points::{Curve, Found, INVERSE_ITERATIONS, Trial, bifurcations};
use crate::element::Nodal;
use crate::norm::larger;
use crate::system::System;

/// Eigenvalue next to zero over the largest one of the trials below which it tells the sign of the determinant better than the count.
const NEXT_TO_ZERO: f64 = 1e-2;
/// Cosine between two modes above which they are the same one.
const SAME_MODE: f64 = 0.9;

/// Least of these works of the loads on the left eigenvector that may be round-off at a bifurcation.
const WORK: f64 = 1e-7;

impl ArcLengthSteps<'_> {
    /// Work of the loads on the left eigenvector of the tangent factored last, at an equilibrium next to a limit point, divided by the
    /// product of this vector with the direction of the path there.
    ///
    /// # Errors
    /// The linear solver failed; the text gives the reason.
    pub(super) fn work_on_left_eigenvector(&mut self, end: &End) -> std::result::Result<f64, String> {
        let Self { newton, system, response, .. } = self;
        let transposed = (TangentPart::Transposed, INVERSE_ITERATIONS);
        let (_, left) = newton.eigenvalue_next_to_zero(system, &end.equation, transposed)?;
        Ok(response.work_on(&left) / system.inner_product(&left, &end.tangent.direction))
    }

    /// Bifurcations of a step without limit points, where the sign of the determinant at its end is another one than the `first`.
    ///
    /// # Errors
    /// No eigenvalue passes through zero: the step has gone over to another path.
    pub(super) fn changes_of_sign(
        &mut self,
        first: i8,
        (arc, known): (&ArcStart, &mut Known),
        end: &End,
        observer: &mut dyn Observer,
    ) -> std::result::Result<Vec<Found>, String> {
        if first == end.tangent.determinant_sign {
            return Ok(Vec::new());
        }
        let size = larger(arc.tangent.work.abs(), end.tangent.work.abs());
        let mut curve = SignCurve { steps: self, known, observer, first, size, trials: Vec::new() };
        let mut found = bifurcations(&mut curve, end.a, (0, 1), &[])?;
        for Found { a, point } in &mut found {
            point.change = curve.change_at(*a, &point.mode);
        }
        Ok(found)
    }
}

/// Path of an arc-length step, on which the sign of the determinant is watched.
struct SignCurve<'s, 'a, 'o> {
    steps: &'s mut ArcLengthSteps<'a>,
    known: &'s mut Known,
    observer: &'o mut dyn Observer,
    /// Sign of the determinant at the start of the step.
    first: i8,
    /// Work of the loads on the direction of the path.
    size: f64,
    trials: Vec<SignTrial>,
}

/// Equilibrium at which the sign of the determinant is known.
struct SignTrial {
    a: f64,
    sign: i8,
    /// Eigenvalue next to zero, and its eigenvector.
    eigenvalue: f64,
    /// Sign of this eigenvalue with the mass matrix in the place of the metric: that of the product of left and right eigenvector with the one over that with the
    /// other.
    by_mass: f64,
    mode: Vec<Nodal>,
    /// Work of the loads on its left eigenvector over that on the direction of the path.
    work: f64,
}

impl SignCurve<'_, '_, '_> {
    /// Change of the number of negative real eigenvalues at a bifurcation with this mode, by the eigenvalue beside it.
    fn change_at(&self, a: f64, mode: &[Nodal]) -> i32 {
        // Next to another bifurcation the eigenvalue may be that of the other one, and all of them round-off: the largest one of the same mode counts.
        let system = self.steps.system;
        let own = self.trials.iter().filter(|trial| {
            let sizes = system.norm(&trial.mode) * system.norm(mode);
            system.inner_product(&trial.mode, mode).abs() >= SAME_MODE * sizes
        });
        let rises = own
            .max_by(|p, q| p.eigenvalue.abs().total_cmp(&q.eigenvalue.abs()))
            .is_some_and(|trial| (trial.eigenvalue > 0.0) == (trial.a > a));
        // Far from the place the product of the eigenvectors may have another sign.
        let nearest = self.trials.iter().min_by(|p, q| (p.a - a).abs().total_cmp(&(q.a - a).abs()));
        let is_reversed = nearest.is_some_and(|trial| trial.by_mass < 0.0);
        if rises == is_reversed { 1 } else { -1 }
    }

    /// Sign of the determinant at a place with this eigenvalue next to zero. Next to a zero the sign that was `found` is round-off: there it
    /// follows from the eigenvalue and the last trial.
    fn sign(&self, found: i8, eigenvalue: f64) -> i8 {
        let size = self.trials.iter().map(|trial| trial.eigenvalue.abs()).fold(0.0, larger);
        match self.trials.last() {
            Some(last) if eigenvalue.abs() <= NEXT_TO_ZERO * size => {
                if (last.eigenvalue > 0.0) == (eigenvalue > 0.0) { last.sign } else { -last.sign }
            }
            _ => found,
        }
    }
}

impl Curve for SignCurve<'_, '_, '_> {
    fn trial(&mut self, a: f64) -> std::result::Result<Trial, String> {
        let end = self.steps.equilibrium_near(self.known, a, self.observer)?;
        let ArcLengthSteps { newton, system, response, .. } = &mut *self.steps;
        let of = |tangent| (tangent, INVERSE_ITERATIONS);
        let (_, left) = newton.eigenvalue_next_to_zero(system, &end.equation, of(TangentPart::Transposed))?;
        let mut softest = newton.eigenvalue_next_to_zero(system, &end.equation, of(TangentPart::Whole))?;
        system.orient(&mut softest.1);
        let work = response.work_on(&left).abs() / self.size;
        let sign = self.sign(end.tangent.determinant_sign, softest.0);
        if sign == 0 {
            return Err("the sign of the determinant of the tangent was not found".into());
        }
        let by_mass = sign_by_mass(self.steps.system, &left, &softest.1);
        self.trials.push(SignTrial {
            a,
            sign,
            eigenvalue: softest.0,
            by_mass,
            mode: softest.1.clone(),
            work,
        });
        // The round-off grows towards the bifurcation.
        let work = -self.trials.iter().map(|trial| -trial.work).fold(f64::NEG_INFINITY, larger);
        let (u, load) = (end.equation.u.clone(), end.equation.time);
        self.known.add(end);
        Ok(Trial {
            u,
            load,
            negative: usize::from(sign != self.first),
            softest,
            work: [work, WORK],
            is_alone: false,
        })
    }
}

/// Sign of the product `ψᵀ M φ` of a left and a right eigenvector over that with the metric of [`System::norm`]: 1 or −1; 1 without mass. A simple eigenvalue
/// passes through zero with any such matrix at the same place, but the direction is that of this product.
fn sign_by_mass(system: &System, left: &[Nodal], right: &[Nodal]) -> f64 {
    let mut inertia = vec![[0.0; 3]; system.vectors()];
    system.pattern.add_mass_product(1.0, right, &mut inertia);
    let by_mass = crate::system::dot(left, &inertia);
    if by_mass * system.inner_product(left, right) < 0.0 { -1.0 } else { 1.0 }
}
