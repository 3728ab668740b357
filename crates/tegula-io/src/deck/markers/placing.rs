//! Placing of markers: their frames in space, from what they are on.

use std::collections::BTreeMap;
use std::ops::Range;

use serde::Deserialize as _;
use toml::Spanned;
use toml::de::{DeValue, ValueDeserializer};

use super::super::Diagnostic;
use super::super::diagnostic::Source;
use super::super::syntax::shorten;
use super::super::unknown::similar;
use super::frame::{Defect, Frame};
use super::order;
use super::reference::{Kind, Names, Reference};
use super::{KEY, Marker};

/// Largest number of markers and bodies of a circle that a message names.
const LISTED: usize = 8;

/// Three coordinates, or a reference to a marker by its number.
#[derive(Debug, Clone, Copy)]
enum Part {
    Given([f64; 3]),
    Named(Reference),
}

/// A marker, or a body on which markers are.
struct Node {
    name: String,
    /// Path of the marker or body, and place of it in the text.
    key: String,
    span: Range<usize>,
    /// Point and two directions; none where they are mistaken.
    parts: Option<(Part, Option<[Part; 2]>)>,
    /// Node in whose frame the parts are given, and the place of its name in the text.
    on: Option<(usize, Range<usize>)>,
}

impl Node {
    /// Nodes on whose frame this one depends.
    fn needs(&self) -> impl Iterator<Item = usize> {
        let named = |part: &Part| match part {
            Part::Named(reference) => Some(reference.marker),
            Part::Given(_) => None,
        };
        let (at, axes) = self.parts.map_or((None, None), |(at, axes)| (named(&at), axes));
        let of_axes = axes.into_iter().flatten().filter_map(move |part| named(&part));
        self.on.iter().map(|(on, _)| *on).chain(at).chain(of_axes).collect::<Vec<_>>().into_iter()
    }
}

/// Markers with their places.
pub(super) struct Placed {
    pub names: Names,
    /// Frame of each marker in space; none where a mistake hides it.
    pub frames: Vec<Option<Frame>>,
    /// Whether another marker is on the marker.
    pub used: Vec<bool>,
    pub found: Vec<Diagnostic>,
}

/// Places the entries `markers` of a text on each other and on `bodies`.
pub(super) fn placed(
    source: &Source,
    markers: &[Spanned<DeValue<'_>>],
    bodies: &[Spanned<DeValue<'_>>],
) -> Placed {
    let numbered = bodies.iter().enumerate().filter_map(|(i, body)| Some((name_of(body)?, i)));
    let names = Names { markers: BTreeMap::new(), bodies: numbered.collect() };
    let mut reader = Reader { source, names, nodes: Vec::new(), ons: Vec::new(), found: Vec::new() };
    for (i, marker) in markers.iter().enumerate() {
        reader.marker(i, marker);
    }
    reader.place_on(bodies);
    let mut frames = reader.frames();
    frames.truncate(markers.len());
    let mut used = vec![false; markers.len()];
    for (on, _) in reader.nodes[..markers.len()].iter().filter_map(|node| node.on.as_ref()) {
        used.iter_mut().skip(*on).take(1).for_each(|used| *used = true);
    }
    Placed { names: reader.names, frames, used, found: reader.found }
}

/// Reads markers and places them.
struct Reader<'a> {
    source: &'a Source,
    names: Names,
    /// Markers, and behind them the bodies that carry some.
    nodes: Vec<Node>,
    /// Name of the carrier of each marker, with its place in the text.
    ons: Vec<Option<(String, Range<usize>)>>,
    found: Vec<Diagnostic>,
}

impl Reader<'_> {
    fn report(&mut self, span: Range<usize>, key: String, message: String, help: impl Into<String>) {
        self.found.push(self.source.at(span, key, message, help));
    }

    fn marker(&mut self, i: usize, value: &Spanned<DeValue<'_>>) {
        let key = format!("{KEY}[{i}]");
        let span_of = |name: &str| value.get_ref().get(name).map_or(value.span(), Spanned::span);
        let marker = Marker::deserialize(ValueDeserializer::from(value.clone())).ok();
        let name = name_of(value).unwrap_or_default();
        if let Some(marker) = &marker {
            self.name(i, &marker.name, span_of("name"));
            self.axes(marker, &key, span_of("axes"));
        }
        self.ons.push(marker.as_ref().and_then(|m| Some((m.on.clone()?, span_of("on")))));
        let finite = |x: &[f64; 3]| x.iter().all(|x| x.is_finite());
        let marker = marker.filter(|m| finite(&m.at) && m.axes.iter().flatten().all(finite));
        let parts = marker.map(|m| (Part::Given(m.at), m.axes.map(|axes| axes.map(Part::Given))));
        if !name.is_empty() {
            self.names.markers.entry(name.clone()).or_insert(i);
        }
        self.nodes.push(Node { name, key, span: value.span(), parts, on: None });
    }

    /// Enters the name of marker number `i`; refuses names that a reference cannot hold, and one that is taken already.
    fn name(&mut self, i: usize, name: &str, span: Range<usize>) {
        let inside = |c: char| c.is_alphanumeric() || "_- ".contains(c);
        let fits = name.chars().all(inside)
            && name.starts_with(|c: char| c.is_alphanumeric() || c == '_')
            && !name.ends_with(' ');
        let key = format!("{KEY}[{i}].name");
        if !fits {
            let message = format!("\"{}\" cannot name a marker", shorten(name));
            self.report(
                span,
                key,
                message,
                "use letters, digits, blanks, '_' and '-', and begin with a letter, a digit or '_'",
            );
        } else if self.names.markers.contains_key(name) {
            let message = format!("two markers are named \"{}\"", shorten(name));
            self.report(span, key, message, "give each marker its own name");
        }
    }

    /// Refuses axes that do not span a plane.
    fn axes(&mut self, marker: &Marker, key: &str, span: Range<usize>) {
        let Some(axes) = marker.axes.filter(|axes| axes.iter().flatten().all(|x| x.is_finite())) else {
            return;
        };
        match Frame::new([0.0; 3], Some(axes)) {
            Ok(_) => {}
            Err(Defect::Zero(i)) => {
                let key = format!("{key}.axes[{i}]");
                self.report(
                    span,
                    key,
                    "the direction has length 0".into(),
                    "give a direction of any length above 0",
                );
            }
            Err(Defect::Parallel) => {
                let message = "the two directions are parallel".into();
                self.report(span, format!("{key}.axes"), message, "give two directions that span a plane");
            }
        }
    }

    /// Finds the carriers of markers, and adds the bodies among them to the nodes.
    fn place_on(&mut self, bodies: &[Spanned<DeValue<'_>>]) {
        let names = self.names.clone();
        let mut carriers: BTreeMap<usize, usize> = BTreeMap::new();
        for (i, on) in std::mem::take(&mut self.ons).into_iter().enumerate() {
            let Some((name, span)) = on else { continue };
            let carrier = match (names.markers.get(&name), names.bodies.get(&name)) {
                (Some(_), Some(_)) => {
                    Err(format!("both a marker and a body are named \"{}\"", shorten(&name)))
                }
                (Some(&marker), None) => Ok(marker),
                (None, Some(&body)) => Ok(*carriers.entry(body).or_insert_with(|| {
                    self.nodes.push(of_body(body, &bodies[body], &names));
                    self.nodes.len() - 1
                })),
                (None, None) => Err(format!("there is no marker or body \"{}\"", shorten(&name))),
            };
            match carrier {
                Ok(carrier) => self.nodes[i].on = Some((carrier, span)),
                Err(message) => {
                    let help = if names.markers.contains_key(&name) {
                        "rename one of them".to_owned()
                    } else {
                        let all = names.markers.keys().chain(names.bodies.keys()).map(String::as_str);
                        match similar(&name, all) {
                            Some(meant) => format!("did you mean \"{meant}\"?"),
                            None => "name another marker or a body, or leave `on` out to give coordinates along the axes of space".into(),
                        }
                    };
                    self.report(span, format!("{KEY}[{i}].on"), message, help);
                    self.nodes[i].parts = None;
                }
            }
        }
    }

    /// Frames of all nodes in space, each after those on which it depends.
    fn frames(&mut self) -> Vec<Option<Frame>> {
        let needs: Vec<Vec<usize>> = self.nodes.iter().map(|node| node.needs().collect()).collect();
        let (order, circles) = order::sorted(&needs);
        for circle in circles {
            self.circle(&circle);
        }
        let mut frames: Vec<Option<Frame>> = vec![None; self.nodes.len()];
        for i in order {
            frames[i] = self.frame(i, &frames);
        }
        frames
    }

    /// Frame of a node in space, from those it depends on.
    fn frame(&mut self, i: usize, frames: &[Option<Frame>]) -> Option<Frame> {
        let node = &self.nodes[i];
        let (at, axes) = node.parts?;
        let carrier = match &node.on {
            Some((on, span)) => match frames[*on] {
                Some(frame) => frame,
                None => {
                    let (on, span, key) = (&self.nodes[*on], span.clone(), format!("{}.on", node.key));
                    // A mistake of a marker is reported there, one of a body is not.
                    if on.key.starts_with("bodies") && on.parts.is_some() && on.needs().next().is_none() {
                        let message = format!("the body \"{}\" has no axes for a marker", shorten(&on.name));
                        self.report(
                            span,
                            key,
                            message,
                            "give its `axes` as two directions that span a plane",
                        );
                    }
                    return None;
                }
            },
            None => Frame::SPACE,
        };
        let value = |part: Part| match part {
            Part::Given(value) => Some(value),
            Part::Named(reference) => Some(reference.of(&frames[reference.marker]?)),
        };
        let axes = match axes {
            Some([first, second]) => Some([value(first)?, value(second)?]),
            None => None,
        };
        let frame = carrier.carry(&Frame::new(value(at)?, axes).ok()?);
        if !frame.is_finite() {
            let (span, key) = (node.span.clone(), format!("{}.at", node.key));
            self.report(span, key, "the coordinates in space are too large".into(), "check the units");
            return None;
        }
        Some(frame)
    }

    /// Reports markers that depend on themselves, at the first one of them that is on something.
    fn circle(&mut self, circle: &[usize]) {
        let first = circle.iter().position(|&i| self.nodes[i].on.is_some()).unwrap_or(0);
        let turned = circle[first..].iter().chain(&circle[..=first]);
        let mut names: Vec<&str> = turned.map(|&i| self.nodes[i].name.as_str()).collect();
        if names.len() > LISTED {
            names.splice(LISTED - 2..names.len() - 1, ["…"]);
        }
        let (message, node) =
            (format!("the place depends on itself: {}", names.join(" → ")), &self.nodes[circle[first]]);
        let span = node.on.as_ref().map_or(node.span.clone(), |(_, span)| span.clone());
        let key = format!("{}.on", node.key);
        self.report(span, key, message, "give one of them by coordinates along the axes of space");
    }
}

/// Body number `i` as a node; a body whose keys are mistaken has no parts.
fn of_body(i: usize, value: &Spanned<DeValue<'_>>, names: &Names) -> Node {
    let table = value.get_ref();
    let part = |value: &Spanned<DeValue<'_>>, kind| match value.get_ref() {
        DeValue::String(text) => names.find(text, kind).ok().map(Part::Named),
        _ => {
            let given = <[f64; 3]>::deserialize(ValueDeserializer::from(value.clone())).ok();
            given.filter(|x| x.iter().all(|x| x.is_finite())).map(Part::Given)
        }
    };
    let parts = || {
        let at = part(table.get("at")?, Kind::Point)?;
        let axes = match table.get("axes").map(|axes| axes.get_ref().as_array().map(|a| a.as_ref())) {
            None => None,
            Some(Some([first, second])) => {
                Some([part(first, Kind::Direction)?, part(second, Kind::Direction)?])
            }
            Some(_) => return None,
        };
        Some((at, axes))
    };
    let name = name_of(value).unwrap_or_default();
    Node { name, key: format!("bodies[{i}]"), span: value.span(), parts: parts(), on: None }
}

/// Name of a table.
fn name_of(value: &Spanned<DeValue<'_>>) -> Option<String> {
    Some(value.get_ref().get("name")?.get_ref().as_str()?.to_owned())
}
