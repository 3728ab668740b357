//! Histories and convergence plots: lines and markers over two axes.

use std::path::Path;

use super::canvas::{Anchor, Canvas, Point, fitted, text_width};
use super::colour::{Rgb, palette};
use super::legend::{self, Entry};
use super::strokes;
use super::ticks::{Axis, Ticks, shown};
use crate::out::OutputError;

/// Size of the picture in pixels.
const SIZE: (u32, u32) = (1000, 640);
const TITLE: f64 = 20.0;
const LABEL: f64 = 16.0;
const TICK: f64 = 14.0;
const NOTE: f64 = 13.0;

/// How a series is drawn.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Style {
    /// A line through the points.
    #[default]
    Line,
    /// A dashed line, for references and for slopes.
    Dashed,
    /// A line in the colour of the series of this number.
    LineLike(usize),
    /// A dashed line in the colour of the series of this number.
    DashedLike(usize),
    /// A marker at each point.
    Markers,
    /// A line and markers.
    Both,
}

impl Style {
    /// Number of the series whose colour a series has; `None` where it has its own.
    fn like(self) -> Option<usize> {
        if let Self::LineLike(other) | Self::DashedLike(other) = self { Some(other) } else { None }
    }

    /// Whether points get markers.
    pub fn has_markers(self) -> bool {
        matches!(self, Self::Markers | Self::Both)
    }
}

/// One curve.
#[derive(Debug, Clone, Default)]
pub struct Series {
    /// Name in the legend; a plot with a single unnamed series has none.
    pub name: String,
    /// Points in the order in which they are joined. A value that is not finite interrupts the line.
    pub points: Vec<(f64, f64)>,
    /// How it is drawn.
    pub style: Style,
}

impl LinePlot {
    /// Number of the colour and the marker of a series: those with a colour of their own are counted.
    fn look(&self, series: usize) -> usize {
        let owner = self.series.get(series).and_then(|s| s.style.like()).unwrap_or(series);
        self.series.iter().take(owner).filter(|s| s.style.like().is_none()).count()
    }
}

/// A plot of curves over two axes.
#[derive(Debug, Clone, Default)]
pub struct LinePlot {
    /// Title above the plot.
    pub title: String,
    /// Quantity of the horizontal axis, with its unit.
    pub x_label: String,
    /// Quantity of the vertical axis, with its unit.
    pub y_label: String,
    /// The curves, drawn in this order.
    pub series: Vec<Series>,
    /// Whether the horizontal axis is logarithmic; values that are not positive are left out.
    pub x_log: bool,
    /// Whether the vertical axis is logarithmic; values that are not positive are left out.
    pub y_log: bool,
    /// A remark below the plot, empty for none.
    pub note: String,
}

impl LinePlot {
    fn shows(&self, point: (f64, f64)) -> bool {
        shown(point.0, self.x_log) && shown(point.1, self.y_log)
    }

    /// The remark, with what had to be left out.
    fn remarks(&self) -> String {
        let points = || self.series.iter().flat_map(|s| &s.points);
        let odd = points().filter(|(x, y)| !x.is_finite() || !y.is_finite()).count();
        let left_out = points().filter(|&&p| !self.shows(p)).count() - odd;
        let mut remarks: Vec<String> = Vec::new();
        if !self.note.is_empty() {
            remarks.push(self.note.clone());
        }
        let plural = |n: usize, what: &str| {
            if n == 1 { format!("1 point {what}") } else { format!("{n} points {what}") }
        };
        if odd > 0 {
            remarks.push(plural(odd, "not finite, left out."));
        }
        if left_out > 0 {
            remarks.push(plural(left_out, "not positive, left out on the logarithmic axis."));
        }
        remarks.join("  ")
    }
}

/// The plot's rectangle on the sheet and its axes.
struct Frame {
    low: Point,
    high: Point,
    x: Axis,
    y: Axis,
}

impl Frame {
    fn at(&self, (x, y): (f64, f64)) -> Option<Point> {
        let (x, y) = (self.x.place(x)?, self.y.place(y)?);
        let ([left, top], [right, bottom]) = (self.low, self.high);
        Some([left + x * (right - left), bottom - y * (bottom - top)])
    }

    /// The series as chains on the sheet, interrupted where a point cannot be shown.
    fn chains(&self, plot: &LinePlot, series: &Series) -> Vec<Vec<Point>> {
        let mut chains = vec![Vec::new()];
        for &point in &series.points {
            let place = if plot.shows(point) { self.at(point) } else { None };
            match (place, chains.last_mut()) {
                (Some(place), Some(chain)) => chain.push(place),
                _ => chains.push(Vec::new()),
            }
        }
        chains.retain(|chain| !chain.is_empty());
        chains
    }
}

/// Draws the plot as a PNG file of 1000 by 640 pixels.
///
/// A plot without anything to show is a picture that says so.
pub fn lines(path: &Path, plot: &LinePlot) -> Result<(), OutputError> {
    draw(plot).save(path)
}

fn draw(plot: &LinePlot) -> Canvas {
    let mut canvas = Canvas::new(SIZE.0, SIZE.1);
    let (width, height) = canvas.size();
    let remarks = plot.remarks();
    let top = if plot.title.is_empty() { 28.0 } else { 62.0 };
    let bottom = height - 66.0 - if remarks.is_empty() { 0.0 } else { 26.0 };
    let visible = || plot.series.iter().flat_map(|s| &s.points).copied().filter(|&p| plot.shows(p));
    let markers = plot.series.iter().any(|s| s.style.has_markers());
    let x = Axis::around(visible().map(|p| p.0), plot.x_log, if markers { 0.04 } else { 0.0 });
    let y = Axis::around(visible().map(|p| p.1), plot.y_log, 0.06);
    let empty = x.is_none() || y.is_none();
    let unit = || Axis::around([0.0, 1.0].into_iter(), false, 0.0);
    let (Some(x), Some(y)) = (if empty { unit() } else { x }, if empty { unit() } else { y }) else {
        return canvas;
    };

    let (x_ticks, y_ticks) = if empty { Default::default() } else { (x.ticks(8), y.ticks(7)) };
    let widest = y_ticks.major.iter().map(|t| text_width(&t.1, TICK)).fold(0.0, tegula::norm::larger);
    let overhang = x_ticks.major.last().map_or(0.0, |t| text_width(&t.1, TICK) / 2.0);
    let left = 30.0 + LABEL + widest;
    let right = width - overhang.max(14.0) - 14.0;
    let mut frame = Frame { low: [left, top], high: [right, bottom], x, y };

    let entries = entries(plot);
    let legend = legend::size(&entries);
    let drawn = |frame: &Frame| -> Vec<Vec<Point>> {
        plot.series.iter().flat_map(|s| occupied(s.style, frame.chains(plot, s))).collect()
    };
    let corner = if entries.is_empty() {
        None
    } else {
        legend::free_corner(legend, frame.low, frame.high, &drawn(&frame)).or_else(|| {
            let room = (right - left) * 0.5;
            frame.high[0] = right - legend.0.min(room) - 6.0;
            Some([frame.high[0] + 14.0, top])
        })
    };

    draw_grid(&mut canvas, &frame, &x_ticks, &y_ticks);
    for (index, series) in plot.series.iter().enumerate() {
        strokes::series(&mut canvas, plot.look(index), series, &frame.chains(plot, series));
    }
    draw_words(&mut canvas, &frame, plot, &remarks);
    if let Some(corner) = corner {
        legend::draw(&mut canvas, corner, &entries);
    }
    if empty {
        let middle = [(frame.low[0] + frame.high[0]) / 2.0, (frame.low[1] + frame.high[1]) / 2.0];
        canvas.text(middle, Anchor::Middle, LABEL, Rgb::QUIET, "There are no values to show.");
    }
    canvas
}

/// Lines that a legend must not cover: the chains, or their points alone.
fn occupied(style: Style, chains: Vec<Vec<Point>>) -> Vec<Vec<Point>> {
    match style {
        Style::Markers => chains.into_iter().flatten().map(|p| vec![p]).collect(),
        _ => chains,
    }
}

fn entries(plot: &LinePlot) -> Vec<Entry> {
    let named = plot.series.iter().enumerate().filter(|(_, s)| !s.name.is_empty());
    let entries = named.map(|(index, series)| {
        let any = series.points.iter().any(|&p| plot.shows(p));
        let name = if any { series.name.clone() } else { format!("{} (no values)", series.name) };
        let (name, _) = fitted(&name, TICK, 0.35 * f64::from(SIZE.0));
        let look = plot.look(index);
        Entry { name, index: look, colour: palette(look), style: series.style }
    });
    entries.collect()
}

fn draw_grid(canvas: &mut Canvas, frame: &Frame, x_ticks: &Ticks, y_ticks: &Ticks) {
    let ([left, top], [right, bottom]) = (frame.low, frame.high);
    let at_x = |place: f64| left + place * (right - left);
    let at_y = |place: f64| bottom - place * (bottom - top);
    let minor = Rgb::grey(0.95);
    for &place in &x_ticks.minor {
        canvas.line([at_x(place), top], [at_x(place), bottom], 0.7, minor);
    }
    for &place in &y_ticks.minor {
        canvas.line([left, at_y(place)], [right, at_y(place)], 0.7, minor);
    }
    let mut free_from = f64::NEG_INFINITY;
    let mut names: Vec<&(f64, String)> = x_ticks.major.iter().collect();
    names.sort_by(|a, b| a.0.total_cmp(&b.0));
    for (place, label) in names {
        let x = at_x(*place);
        canvas.line([x, top], [x, bottom], 0.9, Rgb::GRID);
        canvas.line([x, bottom], [x, bottom + 5.0], 1.0, Rgb::QUIET);
        let half = text_width(label, TICK) / 2.0;
        if x - half > free_from {
            canvas.text([x, bottom + 21.0], Anchor::Middle, TICK, Rgb::INK, label);
            free_from = x + half + 6.0;
        }
    }
    for (place, label) in &y_ticks.major {
        let y = at_y(*place);
        canvas.line([left, y], [right, y], 0.9, Rgb::GRID);
        canvas.line([left - 5.0, y], [left, y], 1.0, Rgb::QUIET);
        canvas.text([left - 9.0, y + 0.36 * TICK], Anchor::End, TICK, Rgb::INK, label);
    }
    canvas.line([left, top], [left, bottom + 0.5], 1.0, Rgb::QUIET);
    canvas.line([left - 0.5, bottom], [right, bottom], 1.0, Rgb::QUIET);
    canvas.text([right, bottom + 44.0], Anchor::End, TICK, Rgb::INK, &x_ticks.shared);
    canvas.text([left, top - 9.0], Anchor::Start, TICK, Rgb::INK, &y_ticks.shared);
}

fn draw_words(canvas: &mut Canvas, frame: &Frame, plot: &LinePlot, remarks: &str) {
    let (width, height) = canvas.size();
    let ([left, top], [right, bottom]) = (frame.low, frame.high);
    let (title, size) = fitted(&plot.title, TITLE, width - left - 20.0);
    canvas.text([left, 32.0], Anchor::Start, size, Rgb::INK, &title);
    let (label, size) = fitted(&plot.x_label, LABEL, right - left - 160.0);
    canvas.text([(left + right) / 2.0, bottom + 48.0], Anchor::Middle, size, Rgb::INK, &label);
    let (label, size) = fitted(&plot.y_label, LABEL, bottom - top);
    canvas.upright_text([26.0, (top + bottom) / 2.0], Anchor::Middle, size, Rgb::INK, &label);
    let (note, size) = fitted(remarks, NOTE, width - left - 20.0);
    canvas.text([left, height - 14.0], Anchor::Start, size, Rgb::QUIET, &note);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Saves into the folder named by `TEGULA_PLOTS`, to be looked at, or into a temporary one.
    fn save(name: &str, plot: &LinePlot) -> Vec<u8> {
        let temporary = tempfile::tempdir().unwrap();
        let folder = std::env::var_os("TEGULA_PLOTS").map_or(temporary.path().to_path_buf(), Into::into);
        let path = folder.join(name);
        lines(&path, plot).unwrap();
        std::fs::read(&path).unwrap()
    }

    fn series(name: &str, style: Style, points: impl IntoIterator<Item = (f64, f64)>) -> Series {
        Series { name: name.into(), points: points.into_iter().collect(), style }
    }

    /// Share of pixels that have the colour of series `index`.
    fn ink(plot: &LinePlot, index: usize) -> f64 {
        let pixels = draw(plot).pixels();
        let wanted = palette(index).bytes();
        let near = |p: &[u8]| p.iter().zip(wanted).all(|(a, b)| a.abs_diff(b) < 12);
        let count = pixels.chunks(3).filter(|p| near(p)).count();
        count as f64 / (SIZE.0 * SIZE.1) as f64
    }

    #[test]
    fn a_decaying_oscillation() {
        let wave = |t: f64, phase: f64| 1.0e-3 * (-0.25 * t).exp() * (6.0 * t + phase).cos();
        let time = |i: i32| f64::from(i) * 0.01;
        let plot = LinePlot {
            title: "Deflection of the free corner".into(),
            x_label: "time [s]".into(),
            y_label: "deflection [m]".into(),
            series: vec![
                series("corner A", Style::Line, (0..=1000).map(|i| (time(i), wave(time(i), 0.0)))),
                series("corner B", Style::Line, (0..=1000).map(|i| (time(i), 0.6 * wave(time(i), 1.0)))),
                series(
                    "envelope",
                    Style::Dashed,
                    (0..=100).map(|i| (0.1 * f64::from(i), 1e-3 * (-0.025 * f64::from(i)).exp())),
                ),
            ],
            note: "Generalised-α, spectral radius 0.9, 1000 steps.".into(),
            ..LinePlot::default()
        };
        assert!((0..3).all(|i| ink(&plot, i) > 5e-4));
        let png = save("oscillation.png", &plot);
        assert!(png.starts_with(b"\x89PNG"));
    }

    #[test]
    fn a_convergence_plot() {
        let size = |i: i32| 2.0_f64.powi(-i);
        let plot = LinePlot {
            title: "Pinched cylinder: error of the deflection under the load".into(),
            x_label: "element size / radius".into(),
            y_label: "relative error".into(),
            series: vec![
                series("EMS", Style::Both, (1..8).map(|i| (size(i), 0.8 * size(i).powi(2)))),
                series("MITC4", Style::Both, (1..8).map(|i| (size(i), 1.9 * size(i).powf(1.8)))),
                series(
                    "with a zero and a negative value",
                    Style::Markers,
                    [(0.1, 0.0), (0.2, -1.0), (0.3, 1e-2)],
                ),
                series("slope 2", Style::Dashed, [(size(7), 0.3 * size(7).powi(2)), (0.5, 0.3 * 0.25)]),
            ],
            x_log: true,
            y_log: true,
            note: String::new(),
        };
        assert!(plot.remarks().starts_with("2 points not positive"));
        assert!((0..4).all(|i| ink(&plot, i) > 5e-5));
        save("convergence.png", &plot);
    }

    #[test]
    fn a_plot_without_a_free_corner_has_its_legend_beside() {
        let wave = |k: f64| {
            (0..20_000).map(move |i| (f64::from(i) * 1e-3, 3e7 + 50.0 * (k * f64::from(i) * 0.03).sin()))
        };
        let plot = LinePlot {
            title: "Energy".into(),
            x_label: "time [s]".into(),
            y_label: "energy [J]".into(),
            series: vec![
                series("kinetic energy", Style::Line, wave(1.0)),
                series("strain energy", Style::Line, wave(1.1)),
            ],
            ..LinePlot::default()
        };
        save("crowded.png", &plot);
        // Right of the curves, which end with the frame, there is nothing but the legend: a sample of each line.
        let pixels = draw(&plot).pixels();
        let legend = legend::size(&entries(&plot)).0 as usize;
        for index in 0..2 {
            let wanted = palette(index).bytes();
            let in_column = |x: usize| {
                let places = pixels.chunks(3 * SIZE.0 as usize).map(|row| &row[3 * x..3 * x + 3]);
                places.filter(|p| p.iter().zip(wanted).all(|(a, b)| a.abs_diff(b) < 12)).count()
            };
            let counts: Vec<usize> = (SIZE.0 as usize - legend..SIZE.0 as usize).map(in_column).collect();
            assert!(counts.iter().sum::<usize>() > 10, "{index}: the legend has no sample of the line");
            assert!(counts.iter().all(|n| *n < 6), "{index}: the curve runs under the legend");
        }
    }

    #[test]
    #[ignore = "long"]
    fn odd_data_give_a_picture_that_says_so() {
        let nan = f64::NAN;
        let cases = [
            ("none", vec![]),
            ("empty series", vec![series("a", Style::Line, [])]),
            ("only NaN", vec![series("a", Style::Both, [(nan, 1.0), (1.0, nan)])]),
            ("one point", vec![series("a", Style::Line, [(1.0, 2.0)])]),
            ("constant", vec![series("a", Style::Line, (0..9).map(|i| (f64::from(i), 3.0)))]),
            (
                "gap",
                vec![series(
                    "a",
                    Style::Line,
                    (0..99).map(|i| (f64::from(i), if i == 50 { nan } else { 1e-9 * f64::from(i) })),
                )],
            ),
            (
                "huge",
                vec![series("a", Style::Line, [(f64::MIN, f64::MAX), (f64::MAX, f64::INFINITY), (0.0, 1.0)])],
            ),
        ];
        for (name, series) in cases {
            for log in [false, true] {
                let plot = LinePlot {
                    title: name.into(),
                    series: series.clone(),
                    x_log: log,
                    y_log: log,
                    ..LinePlot::default()
                };
                let dark = draw(&plot).pixels().chunks(3).filter(|p| p[0] < 120).count();
                assert!(dark > 200, "{name} {log}: {dark}");
                if log {
                    continue;
                }
                save(&format!("odd {name}.png"), &plot);
            }
        }
        let lonely = LinePlot {
            series: vec![series("", Style::Line, [(0.0, 0.0), (nan, 0.0), (1.0, 1.0)])],
            ..LinePlot::default()
        };
        assert!(ink(&lonely, 0) > 2e-5 && lonely.remarks() == "1 point not finite, left out.");
    }
}
