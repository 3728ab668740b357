//! Motion of one node over a transient analysis.

use tegula::analysis::{Observer, Step};
use tegula::model::{Analysis, Model};
use tegula::norm::larger;
use tegula::{Error, Result, Vec3};

use super::model::Compiled;
use super::statistics::run_transient;

/// Displacement and velocity of a node at every step.
pub struct History {
    vector: usize,
    rows: Vec<(f64, Vec3, Vec3)>,
}

impl Observer for History {
    fn on_step(&mut self, step: &Step) -> Result<()> {
        let (u, v) = (step.state.u[self.vector].into(), step.state.v[self.vector].into());
        self.rows.push((step.state.time, u, v));
        Ok(())
    }
}

impl History {
    /// Runs a transient model and watches the only node of a set.
    pub fn of(model: &Model, set: &str) -> Result<Self> {
        let compiled = Compiled::new(model)?;
        let Analysis::Transient(options) = &model.analysis else {
            return Err(Error::Outside("the model is not transient".into()));
        };
        let mut history = Self { vector: compiled.point(set)?, rows: Vec::new() };
        run_transient(&compiled.system, options, &mut history)?;
        Ok(history)
    }

    /// Displacement at a time, cubic in each step.
    pub fn at(&self, t: f64) -> Vec3 {
        let i = self.rows.partition_point(|r| r.0 < t).clamp(1, self.rows.len() - 1);
        let ((t0, x0, v0), (t1, x1, v1)) = (self.rows[i - 1], self.rows[i]);
        cubic(t1 - t0, (t - t0) / (t1 - t0), (x0, v0), (x1, v1))
    }

    /// Times of the steps.
    pub fn times(&self) -> impl Iterator<Item = f64> + '_ {
        self.rows.iter().map(|r| r.0)
    }
}

/// The cubic that has these positions and velocities at the ends of a step of length `h`, at the part `s` of it.
pub fn cubic(h: f64, s: f64, (x0, v0): (Vec3, Vec3), (x1, v1): (Vec3, Vec3)) -> Vec3 {
    let a = s * s * (3.0 - 2.0 * s);
    x0 * (1.0 - a) + x1 * a + (v0 * (1.0 - s) - v1 * s) * (h * s * (1.0 - s))
}

/// Difference of the largest and the least of some values; NaN if one of them is NaN, or if there is none.
pub fn range(values: impl Iterator<Item = f64> + Clone) -> f64 {
    let [high, low] = [1.0, -1.0].map(|sign| values.clone().map(|x| sign * x).reduce(larger));
    high.zip(low).map_or(f64::NAN, |(high, low)| high + low)
}
