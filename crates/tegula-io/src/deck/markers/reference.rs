//! References to markers: `"NAME"` for the point, `"NAME.x"` and `"-NAME.x"` for a direction.

use std::collections::BTreeMap;

use serde_json::Value;

use super::super::syntax::shorten;
use super::super::unknown::{list, similar};
use super::frame::Frame;

/// Keyword of the schema that says which keys may name a marker.
pub(in super::super) const KEYWORD: &str = "x-marker";
/// Largest number of markers that a message lists.
const LISTED: usize = 20;

/// Kind of a value that a marker can give.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in super::super) enum Kind {
    /// Point of the reference configuration.
    Point,
    /// Direction in the reference configuration.
    Direction,
}

impl Kind {
    /// Kind of the values of a key, from its schema.
    pub fn of(schema: &Value) -> Option<Self> {
        Self::named(schema.get(KEYWORD)?)
    }

    /// Kind with this name in the schema.
    pub fn named(name: &Value) -> Option<Self> {
        match name.as_str()? {
            "point" => Some(Self::Point),
            "direction" => Some(Self::Direction),
            _ => None,
        }
    }

    /// Regular expression of the strings that refer to a marker.
    pub fn pattern(self) -> &'static str {
        match self {
            Self::Point => "^[^.-][^.]*$",
            Self::Direction => "^-?[^.-][^.]*\\.[xyz]$",
        }
    }

    /// Sentence for the documentation of a key.
    pub fn sentence(self) -> &'static str {
        match self {
            Self::Point => "Or the name of a marker.",
            Self::Direction => "Or an axis of a marker, such as \"NAME.z\" or \"-NAME.z\".",
        }
    }
}

/// Point or axis of a marker.
#[derive(Debug, Clone, Copy)]
pub(super) struct Reference {
    /// Number of the marker.
    pub marker: usize,
    /// Axis 0, 1 or 2, and whether its opposite is meant; none for the point.
    pub axis: Option<(usize, bool)>,
}

impl Reference {
    /// Coordinates, given the frame of the marker.
    pub fn of(self, frame: &Frame) -> [f64; 3] {
        self.axis.map_or(frame.origin(), |(axis, opposite)| frame.axis(axis, opposite))
    }
}

/// Names of markers and bodies with their numbers; of several with the same name that of one.
#[derive(Debug, Clone)]
pub(super) struct Names {
    pub markers: BTreeMap<String, usize>,
    pub bodies: BTreeMap<String, usize>,
}

impl Names {
    /// Reference that `text` means where a value of this kind is needed; on failure message and help.
    pub fn find(&self, text: &str, kind: Kind) -> Result<Reference, (String, String)> {
        let shown = shorten(text);
        let (opposite, bare) = text.strip_prefix('-').map_or((false, text), |bare| (true, bare));
        let (name, axis) = bare.rsplit_once('.').map_or((bare, None), |(name, axis)| (name, Some(axis)));
        let Some(&marker) = self.markers.get(name) else { return Err(self.unknown(name, kind)) };
        let number = axis.map(|axis| ["x", "y", "z"].iter().position(|&known| known == axis));
        match (kind, number) {
            (Kind::Point, None) if !opposite => Ok(Reference { marker, axis: None }),
            (Kind::Point, _) => Err((
                format!("expected a point, found \"{shown}\""),
                format!("the point of the marker is \"{name}\", without sign and axis"),
            )),
            (Kind::Direction, Some(Some(axis))) => Ok(Reference { marker, axis: Some((axis, opposite)) }),
            (Kind::Direction, None) => Err((
                format!("expected a direction, found the point \"{shown}\""),
                format!("name an axis of the marker: \"{name}.x\", \"{name}.y\" or \"{name}.z\""),
            )),
            (Kind::Direction, Some(None)) => Err((
                format!("a marker has no axis \"{}\"", shorten(axis.unwrap_or_default())),
                format!("its axes are \"{name}.x\", \"{name}.y\" and \"{name}.z\""),
            )),
        }
    }

    /// Message and help for a name that no marker has.
    fn unknown(&self, name: &str, kind: Kind) -> (String, String) {
        let message = format!("there is no marker \"{}\"", shorten(name));
        let coordinates = match kind {
            Kind::Point => "give three coordinates, or a marker by its name",
            Kind::Direction => "give three components, or an axis of a marker such as \"NAME.x\"",
        };
        let known = self.markers.keys().map(String::as_str);
        let help = match similar(name, known.clone()) {
            Some(meant) => format!("did you mean \"{meant}\"?"),
            None if self.bodies.contains_key(name) => {
                format!("this is a body; a marker has its place with `on = \"{name}\"`")
            }
            None if self.markers.is_empty() => format!("{coordinates}; the model has no [[markers]]"),
            None if self.markers.len() > LISTED => {
                let more = self.markers.len() - LISTED;
                format!("{coordinates}; the markers are {} and {more} more", list(known.take(LISTED)))
            }
            None => format!("{coordinates}; the markers are {}", list(known)),
        };
        (message, help)
    }
}
