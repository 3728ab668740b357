//! Strengths of plies.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Strengths of a ply in its own axes; all of them positive numbers.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Strengths {
    /// Tensile strength along the fibre X_t [force/area], above 0.
    pub xt: f64,
    /// Compressive strength along the fibre X_c [force/area], above 0.
    pub xc: f64,
    /// Tensile strength across the fibre Y_t [force/area], above 0.
    pub yt: f64,
    /// Compressive strength across the fibre Y_c [force/area], above 0.
    pub yc: f64,
    /// Shear strength in the plane S_12 [force/area], above 0.
    pub s12: f64,
    /// Interaction F12* = F12/√(F11 F22) of the Tsai–Wu criterion, above −1 and below 1 (−1/2 unless given).
    #[serde(default = "interaction")]
    pub tsai_wu_interaction: f64,
}

fn interaction() -> f64 {
    -0.5
}

impl Strengths {
    /// Strengths with the usual interaction F12* = −1/2.
    pub fn new(xt: f64, xc: f64, yt: f64, yc: f64, s12: f64) -> Self {
        Self { xt, xc, yt, yc, s12, tsai_wu_interaction: interaction() }
    }

    /// Invalid values: pairs of the key and the condition that it must meet.
    pub fn mistakes(&self) -> Vec<(&'static str, &'static str)> {
        let sizes = [("xt", self.xt), ("xc", self.xc), ("yt", self.yt), ("yc", self.yc), ("s12", self.s12)];
        let mut out: Vec<_> = sizes
            .iter()
            .filter(|(_, v)| !(v.is_finite() && *v > 0.0))
            .map(|(key, _)| (*key, "a strength is a number above 0, also in compression"))
            .collect();
        let interaction = self.tsai_wu_interaction;
        if interaction.is_nan() || interaction.abs() >= 1.0 {
            out.push((
                "tsai_wu_interaction",
                "it must be above -1 and below 1, or the material would be of infinite strength in some \
                 direction",
            ));
        }
        out
    }
}
