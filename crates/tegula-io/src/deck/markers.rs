//! Markers: named points with axes, by which a model file gives points and directions.
//!
//! The model has coordinates only. A string in place of the three coordinates of a point or of a direction is replaced in the
//! syntax tree, before that is validated and read: everything behind this module sees coordinates. The types of the model say in
//! the schema (`x-marker`) which of their keys are points or directions of the reference configuration.

mod frame;
mod order;
mod placing;
mod reference;
mod substitute;

use schemars::JsonSchema;
use serde::Deserialize;
use serde_json::{Value, json};
use tegula::Issue;
use toml::de::DeTable;

use super::Diagnostic;
use super::diagnostic::Source;
use frame::Frame;
use placing::Placed;
use reference::Names;
pub(super) use reference::{KEYWORD, Kind};

/// Key of the model file.
pub(super) const KEY: &str = "markers";

/// Point with a name, and with axes x, y, z. Keys take the point as `"NAME"`, the directions of its axes as `"NAME.x"`, `"NAME.y"`,
/// `"NAME.z"`, and the opposite ones as `"-NAME.x"`.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Marker {
    /// Name of the marker: letters, digits, blanks, `_` and `-`; it begins with a letter, a digit or `_`.
    name: String,
    /// Point in the reference configuration, along the axes of space, or of `on` from its origin (length).
    at: [f64; 3],
    /// Direction of the axis x, and a second direction in the plane of the axes x and y, along the axes of space or of `on`;
    /// these axes unless given. The axis z completes a right-handed base.
    #[serde(default)]
    axes: Option<[[f64; 3]; 2]>,
    /// Name of another marker or of a body, in whose frame `at` and `axes` are given.
    #[serde(default)]
    on: Option<String>,
}

/// Schema of the list of markers.
pub(super) fn schema() -> Value {
    let mut marker = schemars::schema_for!(Marker).to_value();
    if let Some(marker) = marker.as_object_mut() {
        marker.remove("$schema");
        marker.remove("title");
    }
    json!({
        "description": "Points and axes with names, by which other keys give points and directions.",
        "type": "array",
        "items": marker,
    })
}

/// Markers of a model file, placed in the reference configuration.
#[derive(Debug)]
pub(super) struct Markers {
    names: Names,
    /// Coordinates of each marker as text, in the order of the file; none where a mistake hides them.
    places: Vec<Option<PlaceTexts>>,
    /// Whether something refers to the marker.
    used: Vec<bool>,
    /// Mistakes in markers.
    found: Vec<Diagnostic>,
}

/// Coordinates of a marker as values of the model file: the point, the axes, and their opposites.
#[derive(Debug)]
struct PlaceTexts {
    origin: String,
    axes: [[String; 2]; 3],
}

/// Replacements in a syntax tree.
#[derive(Debug, Default)]
pub(super) struct Replaced {
    /// Mistakes in markers and in references to them.
    pub found: Vec<Diagnostic>,
    /// Keys whose marker has no place because of a mistake elsewhere.
    pub undetermined: Vec<String>,
    /// Warnings: markers that nothing uses.
    pub unused: Vec<Issue>,
}

impl Markers {
    /// Markers of the tree `root` of a text. What the schema forbids is left to the validator.
    pub fn read(source: &Source, root: &DeTable<'_>) -> Self {
        let list =
            |key: &str| root.get(key).and_then(|v| v.get_ref().as_array()).map_or(&[][..], |a| a.as_ref());
        let Placed { names, frames, used, found } = placing::placed(source, list(KEY), list("bodies"));
        let places = frames.iter().map(|frame| frame.as_ref().map(PlaceTexts::new)).collect();
        Self { names, places, used, found }
    }
}

impl PlaceTexts {
    fn new(frame: &Frame) -> Self {
        let text = |[x, y, z]: [f64; 3]| format!("[{x:?}, {y:?}, {z:?}]");
        let axis = |i: usize| [text(frame.axis(i, false)), text(frame.axis(i, true))];
        Self { origin: text(frame.origin()), axes: [axis(0), axis(1), axis(2)] }
    }
}
