//! Pictures and films of results: shapes coloured by a field, drawn from the field files of a run without a display.

// Tests may unwrap; the code they test may not.
#![cfg_attr(test, allow(clippy::unwrap_used))]

mod film;
mod source;
mod stills;

use std::path::Path;

use crate::out::OutputError;
use crate::out::numbers::significant;
use crate::plot::{Snapshot, SurfacePlot, View, surfaces};
pub use film::Encoding;
use source::{Instant, Source};
pub use stills::stills;

/// Digits of the numbers beside a picture.
const DIGITS: usize = 4;
/// Frames of a film of a mode, which is one period of its vibration.
const FRAMES_OF_A_PERIOD: usize = 48;
/// Part of the size of the model that the shape of a mode is drawn with.
const SIZE_OF_A_MODE: f64 = 0.1;

/// Instants that are drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum At {
    /// The last state, or the first mode that is no rigid motion.
    Default,
    /// The state nearest to a time, load factor or position on the path.
    Value(f64),
    /// The mode with this number.
    Mode(usize),
}

/// How a result is drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct Drawing {
    /// Name of a field, with its component after a point: `von_mises`, `stress_top.1`, `velocity.x`; the size of a vector without component.
    /// `none` is one colour. Without a name it is the von Mises stress where the files have one, else the size of the displacement.
    pub field: Option<String>,
    /// Instant of a picture.
    pub at: At,
    /// From where to look.
    pub view: View,
    /// Factor on the displacements; 1 unless given, of modes a tenth of the size of the model over the largest displacement.
    pub scale: Option<f64>,
    /// Values at both ends of the colours; the smallest and the largest value in the picture or film unless given.
    pub range: Option<[f64; 2]>,
    /// Width and height in pixels.
    pub size: (u32, u32),
}

impl Default for Drawing {
    fn default() -> Self {
        Self {
            field: None,
            at: At::Default,
            view: View::default(),
            scale: None,
            range: None,
            size: (1200, 800),
        }
    }
}

/// Draws one instant of a result folder as a PNG file, or as an SVG file if its name ends so.
///
/// # Errors
/// The folder holds no field files, they are damaged, the field or the instant does not exist, or the file cannot be written.
pub fn still(folder: &Path, drawing: &Drawing, file: &Path) -> Result<(), OutputError> {
    let source = Source::open(folder, drawing)?;
    let number = source.nearest(drawing.at)?;
    let instant = source.instant(number)?;
    let scale = source.scale(drawing, &instant);
    let plot = plot(&source, drawing, &instant, scale);
    surfaces(file, &plot)
}

/// Draws a film of a result folder: all states, one a frame, or a period of a mode. All frames have one scale, one place and one range of colours.
///
/// # Errors
/// As for [`still`]; or the rate is no rate, or the program that encodes the film is missing or fails.
pub fn film(
    folder: &Path,
    drawing: &Drawing,
    (encoding, rate): (Encoding, f64),
    file: &Path,
) -> Result<usize, OutputError> {
    let source = Source::open(folder, drawing)?;
    if !source.is_modes() {
        return states(&source, drawing, (encoding, rate), file);
    }
    let instant = source.instant(source.nearest(drawing.at)?)?;
    let scale = source.scale(drawing, &instant);
    let room = [-scale, scale].into_iter().flat_map(|scale| instant.positions(scale)).collect::<Vec<_>>();
    let range = drawing.range.or(range_of_a_vibration(&instant));
    let frame = |number: usize| {
        let phase = (std::f64::consts::TAU * number as f64 / FRAMES_OF_A_PERIOD as f64).cos();
        let plot = plot(&source, drawing, &source.vibrating(&instant, phase), scale * phase);
        Ok(SurfacePlot { room: room.clone(), range, ..plot })
    };
    film::write(file, (encoding, rate), FRAMES_OF_A_PERIOD, frame)
}

/// Range of the values in the course of a vibration: on both sides of 0 where some are negative.
fn range_of_a_vibration(instant: &Instant) -> Option<[f64; 2]> {
    let mut range = Range::default();
    instant.values.iter().flatten().for_each(|value| range.add(*value));
    let [low, high] = range.0?;
    let largest = low.abs().max(high.abs());
    Some([if low < 0.0 { -largest } else { 0.0 }, largest])
}

fn states(
    source: &Source,
    drawing: &Drawing,
    (encoding, rate): (Encoding, f64),
    file: &Path,
) -> Result<usize, OutputError> {
    let scale = drawing.scale.unwrap_or(1.0);
    let (mut bounds, mut range) = (Bounds::default(), Range::default());
    for number in 0..source.len() {
        let instant = source.instant(number)?;
        instant.positions(scale).iter().for_each(|x| bounds.add(x));
        instant.values.iter().flatten().for_each(|value| range.add(*value));
    }
    let frame = |number: usize| {
        let plot = plot(source, drawing, &source.instant(number)?, scale);
        Ok(SurfacePlot { room: bounds.corners(), range: drawing.range.or(range.0), ..plot })
    };
    film::write(file, (encoding, rate), source.len(), frame)
}

fn plot(source: &Source, drawing: &Drawing, instant: &Instant, scale: f64) -> SurfacePlot {
    let at_nodes = source.is_at_nodes();
    let (values, nodal) =
        if at_nodes { (None, instant.values.clone()) } else { (instant.values.clone(), None) };
    SurfacePlot {
        title: source.summary().title.clone(),
        state: state(source, instant, scale, drawing),
        snapshots: vec![Snapshot {
            positions: instant.positions(scale),
            values,
            nodal,
            label: String::new(),
            opacity: 1.0,
        }],
        quads: source.quads().to_vec(),
        bodies: source.bodies().to_vec(),
        view: drawing.view,
        color_label: source.label(),
        range: drawing.range,
        size: drawing.size,
        ..SurfacePlot::default()
    }
}

/// Instant and, where it is not 1, the factor on the displacements.
fn state(source: &Source, instant: &Instant, scale: f64, drawing: &Drawing) -> String {
    let summary = source.summary();
    let mut parts = vec![instant.label.clone()];
    if drawing.scale.is_some_and(|given| given != 1.0) {
        parts.push(format!("displacements × {}", significant(scale, DIGITS)));
    }
    if !source.has_displacements() && !summary.deformed {
        parts.push("undeformed shape".into());
    }
    let state = parts.join(", ");
    if summary.title.is_empty() { state } else { format!(", {state}") }
}

/// Box around points.
struct Bounds([[f64; 3]; 2]);

impl Default for Bounds {
    fn default() -> Self {
        Self([[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]])
    }
}

impl Bounds {
    fn add(&mut self, x: &[f64; 3]) {
        for i in 0..3 {
            if x[i].is_finite() {
                self.0[0][i] = self.0[0][i].min(x[i]);
                self.0[1][i] = self.0[1][i].max(x[i]);
            }
        }
    }

    fn corners(&self) -> Vec<[f64; 3]> {
        (0..8).map(|corner| std::array::from_fn(|i| self.0[(corner >> i) & 1][i])).collect()
    }
}

/// Smallest and largest of finite values.
#[derive(Default)]
struct Range(Option<[f64; 2]>);

impl Range {
    fn add(&mut self, value: f64) {
        if value.is_finite() {
            let [low, high] = self.0.unwrap_or([value; 2]);
            self.0 = Some([low.min(value), high.max(value)]);
        }
    }
}

#[cfg(test)]
mod tests;
