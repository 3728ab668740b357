//! Motions of different character.

use tegula::model::{Analysis, Model, Scheme};
use tegula::{Error, Result};

use super::Stepping;
use crate::verify::model::{grid, read};

const PENDULUM: &str = include_str!("../../models/examples/quarter_cylinder_pendulum.toml");
const PLATE: &str = include_str!("../../models/vibrating_plate.toml");
const TUMBLING: &str = include_str!("../../models/tumbling_plate.toml");

/// The part of the pendulum's motion that is looked at (s).
const PENDULUM_END: f64 = 0.5;
/// Parts of the critical step that the explicit scheme takes.
const CRITICAL: [f64; 2] = [0.9, 0.45];

/// A motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Transient {
    /// The quarter-cylinder pendulum: soft, large rotations and large changes of shape.
    Pendulum,
    /// A clamped plate under a sudden pressure: stiff, many modes, small rotations, membrane against bending.
    Plate,
    /// A free plate that tumbles and bends: large rotations, little change of shape.
    Tumbling,
}

impl Transient {
    /// All of them.
    pub const EVERY: [Self; 3] = [Self::Pendulum, Self::Plate, Self::Tumbling];

    /// Name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Pendulum => "pendulum",
            Self::Plate => "plate",
            Self::Tumbling => "tumbling",
        }
    }

    /// Title for tables and pictures.
    pub fn title(self) -> &'static str {
        match self {
            Self::Pendulum => "quarter-cylinder pendulum",
            Self::Plate => "clamped plate under a sudden pressure",
            Self::Tumbling => "free plate that tumbles and bends",
        }
    }

    /// The model, and the end of its motion (s). `side` elements are along the first side, and along the other one as
    /// many more or less as in the model file; those of the file where it is not given.
    ///
    /// # Errors
    /// The model file cannot be read, or is not a transient on a generated mesh.
    pub(super) fn model(self, side: Option<u32>) -> Result<(Model, f64)> {
        let mut model = read(match self {
            Self::Pendulum => PENDULUM,
            Self::Plate => PLATE,
            Self::Tumbling => TUMBLING,
        })?;
        let unfit = || Error::Outside(format!("the model of {} is no transient on a grid", self.name()));
        let end = match &model.analysis {
            Analysis::Transient(_) if self == Self::Pendulum => PENDULUM_END,
            Analysis::Transient(options) => options.end_time,
            _ => return Err(unfit()),
        };
        let grid = grid(&mut model.mesh).ok_or_else(unfit)?;
        if let Some(n) = side {
            let [u, v] = grid.elements;
            grid.elements = [n, (v * n).div_ceil(u)];
        }
        Ok((model, end))
    }

    /// Constant steps: parts of the end time, the longest first.
    fn divisions(self) -> &'static [u32] {
        match self {
            Self::Pendulum => &[25, 50, 100, 200, 400, 800],
            Self::Plate | Self::Tumbling => &[50, 100, 200, 400, 800, 1600],
        }
    }

    /// Tolerances of automatic steps, the largest first.
    fn tolerances(self) -> &'static [f64] {
        match self {
            Self::Pendulum | Self::Tumbling => &[1e-4, 3e-5, 1e-5, 3e-6, 1e-6, 3e-7],
            Self::Plate => &[1e-5, 3e-6, 1e-6, 3e-7, 1e-7, 3e-8],
        }
    }

    /// Shortest constant step (s) of a motion up to `end`.
    pub(super) fn shortest(self, end: f64) -> f64 {
        end / f64::from(self.divisions().last().copied().unwrap_or(1))
    }

    /// The steps of a scheme in a motion up to `end`; every other one where `coarse`.
    pub(super) fn steppings(self, scheme: Scheme, end: f64, coarse: bool) -> Vec<Stepping> {
        if matches!(scheme, Scheme::Explicit(_)) {
            return CRITICAL.map(Stepping::Critical).to_vec();
        }
        let fixed = self.divisions().iter().map(|&n| Stepping::Fixed(end / f64::from(n)));
        let automatic = self.tolerances().iter().map(|&t| Stepping::Tolerance(t));
        let every = if coarse { 2 } else { 1 };
        fixed.step_by(every).chain(automatic.step_by(every)).collect()
    }
}
