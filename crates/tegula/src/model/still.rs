//! Stills: pictures of results whose field, view and scale the model gives.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Most and fewest pixels along a side of a still.
pub const PIXELS: [u32; 2] = [200, 4096];

/// Pictures that a run draws by itself, beside those of points (`point_NAME.png`); no still has such a name.
pub const PICTURES: [&str; 8] = [
    "campbell.png",
    "energy.png",
    "frequency_response.png",
    "load_displacement.png",
    "modes.png",
    "render.png",
    "snapshots.png",
    "step_size.png",
];

/// Picture of the shape coloured by a field, drawn when the run is complete, as `tegula render` draws it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Still {
    /// Name of the file in the result folder, which ends with `.png` or `.svg`.
    pub file: String,
    /// Field that gives the colours, such as `von_mises`, `displacement.z` or `stress_top.1`; `none` for one colour. The von Mises stress unless given, or the size of the displacement where field files have no stress.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub field: Option<String>,
    /// State that is drawn: the one nearest to this time, load factor or position on the path; the last one unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub at: Option<f64>,
    /// Number of the mode that is drawn; the first one unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1))]
    pub mode: Option<usize>,
    /// Azimuth and elevation of the viewer (degrees): the angle from the x axis towards the y axis, and the height above the xy plane.
    #[serde(default = "from_the_front", skip_serializing_if = "is_from_the_front")]
    pub view: [f64; 2],
    /// Factor on the displacements; 1 unless given, of modes a tenth of the size of the model over the largest displacement.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scale: Option<f64>,
    /// Values at both ends of the colours; the smallest and the largest one unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub range: Option<[f64; 2]>,
    /// Width and height (pixels).
    #[serde(default = "usual_size", skip_serializing_if = "is_usual_size")]
    pub size: [u32; 2],
}

fn from_the_front() -> [f64; 2] {
    [-60.0, 25.0]
}

fn is_from_the_front(view: &[f64; 2]) -> bool {
    *view == from_the_front()
}

fn usual_size() -> [u32; 2] {
    [1200, 800]
}

fn is_usual_size(size: &[u32; 2]) -> bool {
    *size == usual_size()
}
