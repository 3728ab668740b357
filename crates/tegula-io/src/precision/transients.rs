//! Motions of different character.

use tegula::Result;
use tegula::model::{Model, Scheme};

use super::Stepping;
use crate::verify::model::{read, refine};

const PENDULUM: &str = include_str!("../../../../examples/quarter_cylinder_pendulum.toml");
const PLATE: &str = include_str!("../../../../verification/models/vibrating_plate.toml");
const TUMBLING: &str = include_str!("../../../../verification/models/tumbling_plate.toml");

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

    /// For people.
    pub fn title(self) -> &'static str {
        match self {
            Self::Pendulum => "quarter-cylinder pendulum",
            Self::Plate => "clamped plate under a sudden pressure",
            Self::Tumbling => "free plate that tumbles and bends",
        }
    }

    /// End of the motion (s).
    pub fn end(self) -> f64 {
        match self {
            Self::Pendulum => 0.5,
            Self::Plate => 0.04,
            Self::Tumbling => 1.0,
        }
    }

    /// Elements along its sides where `side` are wanted along the longer one.
    pub fn elements(self, side: Option<u32>) -> [u32; 2] {
        match self {
            Self::Pendulum => [side.unwrap_or(16); 2],
            Self::Plate => [side.unwrap_or(16); 2],
            Self::Tumbling => {
                let n = side.unwrap_or(20).max(2);
                [n, (3 * n).div_ceil(5)]
            }
        }
    }

    /// The model, but for its analysis.
    ///
    /// # Errors
    /// It cannot be read.
    pub(super) fn model(self, side: Option<u32>) -> Result<Model> {
        let mut model = read(match self {
            Self::Pendulum => PENDULUM,
            Self::Plate => PLATE,
            Self::Tumbling => TUMBLING,
        })?;
        refine(&mut model, self.elements(side));
        Ok(model)
    }

    /// Constant steps: parts of the end time, the longest first.
    fn divisions(self) -> &'static [u32] {
        match self {
            Self::Pendulum => &[25, 50, 100, 200, 400, 800],
            Self::Plate => &[50, 100, 200, 400, 800, 1600],
            Self::Tumbling => &[50, 100, 200, 400, 800, 1600],
        }
    }

    /// Tolerances of automatic steps, the largest first.
    fn tolerances(self) -> &'static [f64] {
        match self {
            Self::Pendulum => &[1e-4, 3e-5, 1e-5, 3e-6, 1e-6, 3e-7],
            Self::Plate => &[1e-5, 3e-6, 1e-6, 3e-7, 1e-7, 3e-8],
            Self::Tumbling => &[1e-4, 3e-5, 1e-5, 3e-6, 1e-6, 3e-7],
        }
    }

    /// Shortest constant step (s).
    pub(super) fn shortest(self) -> f64 {
        self.end() / f64::from(self.divisions().last().copied().unwrap_or(1))
    }

    /// The steps of a scheme; every other one where `coarse`.
    pub(super) fn steppings(self, scheme: Scheme, coarse: bool) -> Vec<Stepping> {
        if matches!(scheme, Scheme::Explicit(_)) {
            return CRITICAL.map(Stepping::Critical).to_vec();
        }
        let fixed = self.divisions().iter().map(|&n| Stepping::Fixed(self.end() / f64::from(n)));
        let automatic = self.tolerances().iter().map(|&t| Stepping::Tolerance(t));
        let every = if coarse { 2 } else { 1 };
        fixed.step_by(every).chain(automatic.step_by(every)).collect()
    }
}
