//! Force laws of springs: linear with a linear damper, or a formula in the elongation x, its rate v and the time t.
//!
//! Statics and the generalised-α method take `F(x, v, t)` of a state. The energy–momentum scheme takes the mean force over a step from x₀
//! to x₁, with the mean rate `v̄ = (x₁ − x₀)/Δt` and the time t in its middle,
//!
//! ```text
//! F̄ = ∫₀¹ F(x₀ + ξ (x₁ − x₀), v̄, t) dξ
//! ```
//!
//! by Gauss quadrature with five points on each smooth piece, so that `F̄ (x₁ − x₀)` is the work `∫ F dx`: exactly for polynomials up to the
//! degree 9 in x. A law without the time stores `V(x) = ∫ F(s, 0) ds` and dissipates the rest of its power. One with the time is an
//! actuator: it stores nothing, and its whole power is supplied from outside.

use super::quadrature::{self, Sides};
use crate::load::{ForceFormula, Partials};

/// Force law of a spring in its length, or of a torsion spring in its angle.
#[derive(Debug, Clone, PartialEq)]
pub struct SpringLaw {
    /// Length or angle from which the elongation counts.
    free: f64,
    kind: Kind,
}

#[derive(Debug, Clone, PartialEq)]
enum Kind {
    Linear { stiffness: f64, damping: f64 },
    Formula(Box<Formula>),
}

#[derive(Debug, Clone, PartialEq)]
struct Formula {
    formula: ForceFormula,
    /// The spring, for messages.
    spring: String,
    /// Elongation at which the stored energy is zero.
    base: f64,
    has_kinks: bool,
    has_rate: bool,
    has_time: bool,
}

impl SpringLaw {
    /// Force `k (s − s₀) + d ṡ`.
    pub fn linear([stiffness, damping]: [f64; 2], free: f64) -> Self {
        Self { free, kind: Kind::Linear { stiffness, damping } }
    }

    /// Stiffness and free length of a linear law.
    pub fn linear_constants(&self) -> Option<[f64; 2]> {
        match self.kind {
            Kind::Linear { stiffness, .. } => Some([stiffness, self.free]),
            Kind::Formula(_) => None,
        }
    }

    /// Force by a formula, for a spring that messages call by a name and that has the length or angle `start` at the start.
    ///
    /// # Errors
    /// The formula is invalid, or has no finite value or slope at the start: description of the mistake, and remedy.
    pub fn formula(spring: &str, text: &str, [free, start]: [f64; 2]) -> Result<Self, (String, String)> {
        let named =
            |(problem, help): (String, String)| (format!("the force law of {spring}: {problem}"), help);
        let formula = ForceFormula::read(text).map_err(named)?;
        let x = start - free;
        let first = formula.partials([x, 0.0, 0.0]);
        let place = format!("at the start, where x = {x:.6}, v = 0 and t = 0");
        if !first.value.is_finite() {
            return Err(named((
                format!("the expression {} has no finite value {place}", formula.quoted()),
                "look for a division by 0, a root or logarithm of a negative number, and numbers above 1e308"
                    .into(),
            )));
        }
        if !(first.by_position.is_finite() && first.by_rate.is_finite()) {
            return Err(named((
                format!("the expression {} has no finite derivatives {place}", formula.quoted()),
                "smooth the force there, such as sqrt(x^2 + 1e-12) in place of abs(x) below a root or a power".into(),
            )));
        }
        let mut out = Formula {
            spring: spring.into(),
            base: 0.0,
            has_kinks: formula.has_kinks(),
            has_rate: formula.depends_on_rate(),
            has_time: formula.depends_on_time(),
            formula,
        };
        if !(out.formula.value([0.0; 3]).is_finite() && out.potential(x).is_finite()) {
            out.base = x;
        }
        Ok(Self { free, kind: Kind::Formula(Box::new(out)) })
    }

    /// Length or angle from which the elongation counts.
    pub fn free(&self) -> f64 {
        self.free
    }

    /// Whether the force depends on the rate.
    pub fn depends_on_rate(&self) -> bool {
        match &self.kind {
            Kind::Linear { damping, .. } => *damping != 0.0,
            Kind::Formula(formula) => formula.has_rate,
        }
    }

    /// Whether the force depends on the time: the spring is an actuator.
    pub fn depends_on_time(&self) -> bool {
        matches!(&self.kind, Kind::Formula(formula) if formula.has_time)
    }

    /// Force between two lengths or angles, the same ones for a state, at a rate and a time: the mean force of a step. Its
    /// derivative by the position is that by the mean position for a linear law, and in general `2 ∂F̄/∂x₁`.
    pub fn force(&self, ends: [f64; 2], rate: f64, time: f64) -> Partials {
        match &self.kind {
            Kind::Linear { stiffness, damping } => Partials {
                value: stiffness * (0.5 * (ends[0] + ends[1]) - self.free) + damping * rate,
                by_position: *stiffness,
                by_rate: *damping,
            },
            Kind::Formula(formula) => formula.mean(ends.map(|s| s - self.free), rate, time),
        }
    }

    /// Stored energy.
    pub fn energy(&self, position: f64) -> f64 {
        match &self.kind {
            Kind::Linear { stiffness, .. } => 0.5 * stiffness * (position - self.free).powi(2),
            Kind::Formula(formula) => formula.potential(position - self.free),
        }
    }

    /// Power that the force dissipates between two lengths or angles, at a rate.
    pub fn dissipation(&self, ends: [f64; 2], rate: f64, time: f64) -> f64 {
        match &self.kind {
            Kind::Linear { damping, .. } => damping * rate * rate,
            Kind::Formula(formula) if formula.has_rate && !formula.has_time => {
                let ends = ends.map(|s| s - self.free);
                let force = |rate: f64| formula.mean(ends, rate, time).value;
                (force(rate) - force(0.0)) * rate
            }
            Kind::Formula(_) => 0.0,
        }
    }

    /// Work that an actuator does on the model between two lengths or angles; 0 for other springs.
    pub fn work(&self, ends: [f64; 2], rate: f64, time: f64) -> f64 {
        if self.depends_on_time() { -self.force(ends, rate, time).value * (ends[1] - ends[0]) } else { 0.0 }
    }

    /// Reason why there is no finite force between two lengths or angles; `None` where there is one, or they are not finite.
    pub fn reason_without_force(&self, ends: [f64; 2], rate: f64, time: f64) -> Option<String> {
        let Kind::Formula(formula) = &self.kind else { return None };
        let [first, last] = ends.map(|s| s - self.free);
        let samples = (0..=SAMPLES).map(|i| first + (last - first) * f64::from(i) / f64::from(SAMPLES));
        let undefined = |x: &f64| {
            let Partials { value, by_position, by_rate } = formula.formula.partials([*x, rate, time]);
            !(value.is_finite() && by_position.is_finite() && by_rate.is_finite())
        };
        if !(first.is_finite() && last.is_finite() && rate.is_finite()) {
            return None;
        }
        let x = samples.into_iter().find(undefined)?;
        Some(format!(
            "the force law {} of {} has no finite value or derivatives at x = {x:.6e}, v = {rate:.6e}, t = {time:.6e}",
            formula.formula.quoted(),
            formula.spring
        ))
    }

    /// Whether a formula has no positive stiffness at a length or angle, as text; `None` where it has.
    pub fn falls(&self, position: f64, time: f64) -> Option<String> {
        let Kind::Formula(formula) = &self.kind else { return None };
        let x = position - self.free;
        let Partials { value, by_position, .. } = formula.formula.partials([x, 0.0, time]);
        // A gas spring has a force at its free length, too.
        let at_rest = formula.formula.partials([0.0, 0.0, time]).value;
        let flat = if x == 0.0 { 0.0 } else { FLAT * ((value - at_rest) / x).abs() };
        (by_position.is_finite() && by_position <= flat).then(|| {
            format!(
                "the force law {} of {} has the stiffness {by_position:.3e} at x = {x:.6e}: its force does not grow there",
                formula.formula.quoted(),
                formula.spring
            )
        })
    }

    /// A pole of the force between two lengths or angles at two times, as text, which a step must not jump over; `None` where there is none.
    pub fn pole(&self, ends: [f64; 2], rate: f64, times: [f64; 2]) -> Option<String> {
        let Kind::Formula(formula) = &self.kind else { return None };
        let places = [0, 1].map(|i| [ends[i] - self.free, rate, times[i]]);
        let [x, v, t] = formula.formula.pole(places)?;
        Some(format!(
            "the force law {} of {} has no finite value within the step, at x = {x:.6e}, v = {v:.6e}, t = {t:.6e}",
            formula.formula.quoted(),
            formula.spring
        ))
    }
}

/// Stiffness over the mean one of the way from the free length below which a force is constant.
const FLAT: f64 = 1e-6;
/// Parts of a step whose ends are looked at for a place without a force.
const SAMPLES: u8 = 64;

impl Formula {
    fn mean(&self, [first, last]: [f64; 2], rate: f64, time: f64) -> Partials {
        if first == last {
            return self.formula.partials([first, rate, time]);
        }
        let at = |part: f64| [first + part * (last - first), rate, time];
        let sides = |part: f64| self.formula.sides(at(part));
        let f = |part: f64| {
            let Partials { value, by_position, by_rate } = self.formula.partials(at(part));
            [value, 2.0 * part * by_position, by_rate]
        };
        let [value, by_position, by_rate] = quadrature::mean(f, self.has_kinks.then_some(&sides));
        Partials { value, by_position, by_rate }
    }

    /// Stored energy `∫ F(s, 0) ds`.
    fn potential(&self, x: f64) -> f64 {
        if self.has_time || x == self.base {
            return 0.0;
        }
        let at = |x: f64| [x, 0.0, 0.0];
        let sides = |x: f64| self.formula.sides(at(x));
        let sides: Sides = if self.has_kinks { Some(&sides) } else { None };
        quadrature::integral(|x| self.formula.value(at(x)), sides, [self.base, x])
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    const LAWS: [&str; 5] = [
        "40*x + 300*x^3 + 5*v*abs(v) - 2*t",
        "7*sin(3*x)*exp(-v) + x^2*v",
        "500*max(x - 0.1, 0) + abs(x + 0.03*v)*v",
        "min(x, 0.2*v)*max(x, min(v, t))",
        "tanh(x/(1 + v^2))/2^x",
    ];

    fn law(text: &str) -> SpringLaw {
        SpringLaw::formula("the spring", text, [1.0, 1.3]).unwrap()
    }

    /// Mean forces and their derivatives against sums of many midpoints and central differences, with kinks inside the step.
    #[test]
    fn mean_forces_have_the_derivatives_that_they_tell() {
        for text in LAWS {
            let (law, formula) = (law(text), ForceFormula::read(text).unwrap());
            for (ends, rate) in [([0.8, 1.4], 0.6), ([1.25, 0.7], -0.9), ([1.15, 1.15], 0.4)] {
                let time = 0.35;
                let found = law.force(ends, rate, time);
                let n = 20_000;
                let at = |i: i32| (f64::from(i) + 0.5) / f64::from(n) * (ends[1] - ends[0]) + ends[0] - 1.0;
                let mean = (0..n).map(|i| formula.value([at(i), rate, time])).sum::<f64>() / f64::from(n);
                assert!((found.value - mean).abs() < 1e-7 * (1.0 + mean.abs()), "{text}");
                let h = 1e-5;
                let moved = |d: f64, of_rate: f64| {
                    let start = if ends[0] == ends[1] { ends[0] + d } else { ends[0] };
                    law.force([start, ends[1] + d], rate + of_rate, time).value
                };
                let twice = if ends[0] == ends[1] { 1.0 } else { 2.0 };
                let by_position = twice * (moved(h, 0.0) - moved(-h, 0.0)) / (2.0 * h);
                let by_rate = (moved(0.0, h) - moved(0.0, -h)) / (2.0 * h);
                let close = |found: f64, exact: f64| (found - exact).abs() < 1e-6 * (1.0 + exact.abs());
                assert!(close(found.by_position, by_position), "{text}: {found:?} {by_position}");
                assert!(close(found.by_rate, by_rate), "{text}: {found:?} {by_rate}");
            }
        }
    }

    /// The work of a step is what is stored and dissipated, to round-off, also across kinks.
    #[test]
    fn work_is_stored_or_dissipated() {
        for text in [
            "40*x + 300*x^9 + 5*v*abs(v)",
            "500*max(x - 0.1, 0) + v*abs(x)",
            "9*max(abs(x) - 0.15, 0)*(1 + v)",
        ] {
            let law = law(text);
            for ends in [[0.8, 1.4], [1.4, 0.7], [0.86, 0.84], [1.2, 1.2]] {
                let dt = 0.2;
                let rate = (ends[1] - ends[0]) / dt;
                let work = law.force(ends, rate, 0.0).value * (ends[1] - ends[0]);
                let stored = law.energy(ends[1]) - law.energy(ends[0]);
                let lost = law.dissipation(ends, rate, 0.0) * dt;
                let size = law.energy(1.4) + lost.abs();
                assert!(
                    (work - stored - lost).abs() < 1e-14 * size,
                    "{text} {ends:?}: {work} {stored} {lost}"
                );
                assert!(law.work(ends, rate, 0.0) == 0.0);
            }
        }
        let actuator = law("3 + x*t + v");
        assert!(actuator.energy(1.4) == 0.0 && actuator.dissipation([1.0, 1.2], 0.4, 2.0) == 0.0);
        // Mean force 3 + 0.1·2 + 0.4 over 0.2.
        assert!((actuator.work([1.0, 1.2], 0.4, 2.0) + 0.2 * 3.6).abs() < 1e-15);
    }
}
