//! A white sheet to draw on.
//!
//! Coordinates are pixels of the finished picture, x to the right and y down, and need not be whole. The sheet
//! holds several samples a pixel in each direction and is averaged at the end, which smooths everything.
//!
//! A sample belongs to a polygon if its centre is inside, with ties broken one way, and edges are evaluated the
//! same way from both sides. Polygons that share an edge therefore leave no gap and never overlap, so that even
//! transparent surfaces show no seams.

use std::ops::Range;
use std::path::Path;

use super::colour::Rgb;
use super::vector::Elements;
use super::{font, png};
use crate::out::{OutputError, write_whole};

/// A point on the sheet.
pub type Point = [f64; 2];

/// Which part of a text stands at the given position.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Anchor {
    /// Its beginning.
    Start,
    /// Its middle.
    Middle,
    /// Its end.
    End,
}

/// Samples that a sheet may have at most; larger pictures get fewer samples a pixel.
const MOST_SAMPLES: u64 = 40_000_000;
/// Pixels of the largest picture in either direction.
const LARGEST: u32 = 8000;

/// A picture in the making.
#[derive(Debug)]
pub struct Canvas {
    width: u32,
    height: u32,
    /// Samples per pixel in each direction.
    scale: u32,
    samples: Vec<u8>,
    /// Lines, areas of one colour and letters, where they are elements of a vector graphic and no samples.
    elements: Option<Elements>,
}

impl Canvas {
    /// A white sheet; sizes are brought between 16 and 8000 pixels.
    pub fn new(width: u32, height: u32) -> Self {
        let (width, height) = (width.clamp(16, LARGEST), height.clamp(16, LARGEST));
        let pixels = u64::from(width) * u64::from(height);
        let scale = (2..=4).rev().find(|&s| pixels * u64::from(s * s) <= MOST_SAMPLES).unwrap_or(1);
        let samples = vec![255; (pixels * u64::from(scale * scale)) as usize * 3];
        Self { width, height, scale, samples, elements: None }
    }

    /// A white sheet for a file: its lines and letters are vector graphics if the name ends in `.svg`.
    pub fn for_file(path: &Path, (width, height): (u32, u32)) -> Self {
        let is_vector = path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("svg"));
        Self { elements: is_vector.then(Elements::default), ..Self::new(width, height) }
    }

    /// Width and height in pixels.
    pub fn size(&self) -> (f64, f64) {
        (f64::from(self.width), f64::from(self.height))
    }

    /// Grid of the samples.
    pub fn grid(&self) -> Grid {
        Grid { scale: self.scale, columns: self.width * self.scale, rows: self.height * self.scale }
    }

    /// Fills a convex polygon. `paint` gives the colour at each position; `opacity` goes from 0 to 1.
    pub fn fill_with(&mut self, corners: &[Point], opacity: f64, mut paint: impl FnMut(Point) -> Rgb) {
        let grid = self.grid();
        grid.each_within(corners, 0..grid.rows, |at, sample| self.blend(sample, paint(at), opacity));
    }

    /// Mixes a colour into a sample, given by its number.
    pub fn blend(&mut self, sample: usize, colour: Rgb, opacity: f64) {
        for (sample, channel) in self.samples[3 * sample..3 * sample + 3].iter_mut().zip(colour.0) {
            let below = f64::from(*sample) / 255.0;
            *sample = ((below + (channel - below) * opacity) * 255.0 + 0.5) as u8;
        }
    }

    /// Fills a convex polygon with one colour.
    pub fn fill(&mut self, corners: &[Point], colour: Rgb) {
        match &mut self.elements {
            Some(elements) => elements.polygon(corners, colour),
            None => self.fill_with(corners, 1.0, |_| colour),
        }
    }

    /// Fills the rectangle between two opposite corners.
    pub fn rectangle(&mut self, [x0, y0]: Point, [x1, y1]: Point, colour: Rgb) {
        self.fill(&[[x0, y0], [x1, y0], [x1, y1], [x0, y1]], colour);
    }

    /// Fills a circle.
    pub fn disc(&mut self, centre: Point, radius: f64, colour: Rgb) {
        match &mut self.elements {
            Some(elements) => elements.circle(centre, radius, colour),
            None => self.fill(&regular(centre, radius, 20, 0.0), colour),
        }
    }

    /// A straight line with flat ends.
    pub fn line(&mut self, a: Point, b: Point, width: f64, colour: Rgb) {
        if let Some(elements) = &mut self.elements {
            return elements.chain(&[a, b], (width, false), None, colour);
        }
        let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
        let length = dx.hypot(dy);
        if length > 0.0 {
            let (nx, ny) = (-dy / length * width / 2.0, dx / length * width / 2.0);
            let corners = [
                [a[0] + nx, a[1] + ny],
                [b[0] + nx, b[1] + ny],
                [b[0] - nx, b[1] - ny],
                [a[0] - nx, a[1] - ny],
            ];
            self.fill(&corners, colour);
        }
    }

    /// A chain of lines with round corners; `dash` is the length of strokes and of the gaps between them.
    pub fn polyline(&mut self, points: &[Point], width: f64, dash: Option<(f64, f64)>, colour: Rgb) {
        if let Some(elements) = &mut self.elements {
            return elements.chain(points, (width, dash.is_none()), dash, colour);
        }
        let Some((stroke, gap)) = dash else {
            for pair in points.windows(2) {
                self.line(pair[0], pair[1], width, colour);
            }
            for &point in points {
                self.fill(&regular(point, width / 2.0, 10, 0.0), colour);
            }
            return;
        };
        let period = stroke + gap;
        let mut travelled = 0.0_f64;
        for pair in points.windows(2) {
            let (a, b) = (pair[0], pair[1]);
            let length = (b[0] - a[0]).hypot(b[1] - a[1]);
            let at = |s: f64| [a[0] + (b[0] - a[0]) * s / length, a[1] + (b[1] - a[1]) * s / length];
            let mut s = 0.0;
            while s < length && period > 0.0 {
                let phase = (travelled + s) % period;
                let (drawn, rest) =
                    if phase < stroke { (true, stroke - phase) } else { (false, period - phase) };
                let end = (s + rest.max(1e-3)).min(length);
                if drawn {
                    self.line(at(s), at(end), width, colour);
                }
                s = end;
            }
            travelled += length;
        }
    }

    /// A line of text; `y` is its baseline and `size` its em in pixels.
    pub fn text(&mut self, [x, y]: Point, anchor: Anchor, size: f64, colour: Rgb, text: &str) {
        let start = x - share(anchor) * text_width(text, size);
        self.put_text([start, y], size, false, colour, text);
    }

    /// A line of text that runs upwards; `x` is its baseline.
    pub fn upright_text(&mut self, [x, y]: Point, anchor: Anchor, size: f64, colour: Rgb, text: &str) {
        let start = y + share(anchor) * text_width(text, size);
        self.put_text([x, start], size, true, colour, text);
    }

    fn put_text(&mut self, [x, y]: Point, size: f64, upright: bool, colour: Rgb, text: &str) {
        if let Some(elements) = &mut self.elements {
            return elements.text([x, y], size, upright, colour, text);
        }
        let scale = f64::from(self.scale);
        let sheet = (self.width * self.scale, self.height * self.scale);
        font::draw(&mut self.samples, sheet, text, size * scale, (x * scale, y * scale), upright, colour);
    }

    /// The finished picture: three bytes a pixel, row by row from the top. Of a vector graphic it has the shaded surfaces alone.
    pub fn pixels(&self) -> Vec<u8> {
        self.averaged(self.scale)
    }

    /// Means of squares of samples of this side, three bytes each, row by row from the top.
    fn averaged(&self, side: u32) -> Vec<u8> {
        let scale = side as usize;
        let row_bytes = (self.width * self.scale) as usize * 3;
        let area = side * side;
        let mut pixels = Vec::with_capacity(self.samples.len() / (scale * scale));
        // Rows first: their bytes lie in a line. Sums of 4 × 4 samples need 12 bits.
        let mut sums = vec![0_u16; row_bytes];
        for band in self.samples.chunks_exact(row_bytes * scale) {
            sums.fill(0);
            for row in band.chunks_exact(row_bytes) {
                sums.iter_mut().zip(row).for_each(|(sum, &sample)| *sum += u16::from(sample));
            }
            for pixel in sums.chunks_exact(3 * scale) {
                let channel = |c: usize| pixel[c..].iter().step_by(3).map(|&sum| u32::from(sum)).sum::<u32>();
                pixels.extend([0, 1, 2].map(|c| ((channel(c) + area / 2) / area) as u8));
            }
        }
        pixels
    }

    /// Writes the finished picture as PNG, or as SVG where it is a vector graphic, whole or not at all.
    pub fn save(&self, path: &Path) -> Result<(), OutputError> {
        let Some(elements) = &self.elements else {
            let pixels = self.pixels();
            return write_whole(path, |w| png::write(w, self.width, self.height, &pixels));
        };
        // Surfaces in a vector graphic have twice as many pixels in each direction where there are enough samples.
        let side = if self.scale.is_multiple_of(2) { self.scale / 2 } else { self.scale };
        let size = [self.width, self.height].map(|pixels| pixels * self.scale / side);
        let pixels = self.averaged(side);
        write_whole(path, |w| {
            let mut image = Vec::new();
            png::write(&mut image, size[0], size[1], &pixels)?;
            w.write_all(elements.document([self.width, self.height].map(f64::from), &image).as_bytes())
        })
    }
}

/// Rows and columns of samples, numbered row by row.
#[derive(Debug, Clone, Copy)]
pub struct Grid {
    /// Samples per pixel in each direction.
    pub scale: u32,
    /// Samples in a row.
    pub columns: u32,
    /// Number of rows.
    pub rows: u32,
}

impl Grid {
    /// Calls `take` with position and number of the samples in some rows of a convex polygon.
    pub fn each_within(self, corners: &[Point], rows: Range<u32>, mut take: impl FnMut(Point, usize)) {
        if corners.len() < 3 || corners.iter().flatten().any(|x| !x.is_finite()) {
            return;
        }
        let (scale, columns) = (f64::from(self.scale), self.columns);
        let lowest = corners.iter().map(|p| p[1]).fold(f64::INFINITY, f64::min) * scale;
        let highest = corners.iter().map(|p| p[1]).fold(f64::NEG_INFINITY, f64::max) * scale;
        // Casts from floats saturate, which clips to the sheet.
        let first = ((lowest - 0.5).ceil().max(0.0) as u32).max(rows.start);
        let last = ((highest - 0.5).ceil().max(0.0) as u32).min(rows.end);
        for row in first..last {
            let y = f64::from(row) + 0.5;
            let (mut left, mut right) = (f64::INFINITY, f64::NEG_INFINITY);
            for (i, &corner) in corners.iter().enumerate() {
                let next = corners[(i + 1) % corners.len()];
                let (a, b) = if corner[1] <= next[1] { (corner, next) } else { (next, corner) };
                let (ya, yb) = (a[1] * scale, b[1] * scale);
                if ya <= y && y < yb {
                    let x = (a[0] + (b[0] - a[0]) * ((y - ya) / (yb - ya))) * scale;
                    left = left.min(x);
                    right = right.max(x);
                }
            }
            let (start, end) =
                ((left - 0.5).ceil().max(0.0) as u32, ((right - 0.5).ceil().max(0.0) as u32).min(columns));
            for column in start..end {
                let number = row as usize * columns as usize + column as usize;
                take([(f64::from(column) + 0.5) / scale, y / scale], number);
            }
        }
    }
}

fn share(anchor: Anchor) -> f64 {
    match anchor {
        Anchor::Start => 0.0,
        Anchor::Middle => 0.5,
        Anchor::End => 1.0,
    }
}

/// Width of a text in pixels at a size in pixels per em.
pub fn text_width(text: &str, size: f64) -> f64 {
    font::width(text) * size
}

/// The text and size that fit into `room` pixels: first smaller letters, then an ellipsis.
pub fn fitted(text: &str, size: f64, room: f64) -> (String, f64) {
    let width = text_width(text, size);
    if width <= room {
        return (text.to_owned(), size);
    }
    let smaller = (size * room / width).max(0.75 * size);
    (cut(text, smaller, room), smaller)
}

/// The text, or as much of it as fits into `room` pixels before an ellipsis.
fn cut(text: &str, size: f64, room: f64) -> String {
    let mut kept: Vec<char> = text.chars().collect();
    let mut shown = text.to_owned();
    while text_width(&shown, size) > room && kept.pop().is_some() {
        shown = kept.iter().chain(&['…']).collect();
    }
    shown
}

/// The text and size that fit into `room` pixels with an `end` that stays whole: smaller letters first, then an ellipsis before the end.
pub fn fitted_before(text: &str, end: &str, size: f64, room: f64) -> (String, f64) {
    let whole = format!("{text}{end}");
    if text_width(&whole, size) <= room {
        return (whole, size);
    }
    let smaller = 0.75 * size;
    if text_width(&whole, smaller) <= room {
        return fitted(&whole, size, room);
    }
    (format!("{}{end}", cut(text, smaller, room - text_width(end, smaller))), smaller)
}

/// A regular polygon of `n` corners, the first at the top turned clockwise by `turn` radians.
pub fn regular(centre: Point, radius: f64, n: usize, turn: f64) -> Vec<Point> {
    (0..n)
        .map(|i| {
            let angle = turn + std::f64::consts::TAU * i as f64 / n as f64;
            [centre[0] + radius * angle.sin(), centre[1] - radius * angle.cos()]
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbours_leave_no_seam_and_no_overlap() {
        let mut canvas = Canvas::new(60, 60);
        let (a, b, c, d) = ([3.3, 4.1], [55.7, 9.9], [49.2, 57.3], [5.9, 50.8]);
        for triangle in [[a, b, c], [c, d, a]] {
            canvas.fill_with(&triangle, 0.5, |_| Rgb::BLACK);
        }
        let mut inside = 0;
        for (i, &sample) in canvas.samples.iter().enumerate() {
            assert!(sample == 255 || sample == 128, "sample {i} is {sample}");
            inside += usize::from(sample == 128);
        }
        // Area by the shoelace formula.
        let corners = [a, b, c, d];
        let area: f64 = (0..4)
            .map(|i| corners[i][0] * corners[(i + 1) % 4][1] - corners[(i + 1) % 4][0] * corners[i][1])
            .sum();
        let drawn = inside as f64 / 3.0 / 16.0;
        assert!((drawn / (area / 2.0) - 1.0).abs() < 0.005, "{drawn} {}", area / 2.0);
    }

    #[test]
    fn what_lies_outside_or_is_not_a_number_is_clipped() {
        let mut canvas = Canvas::new(20, 20);
        canvas.rectangle([-1e9, -1e9], [1e9, 1e9], Rgb::BLACK);
        assert!(canvas.pixels().iter().all(|&b| b == 0));
        canvas.fill(&[[f64::NAN, 0.0], [1.0, 1.0], [0.0, 1.0]], Rgb::WHITE);
        canvas.line([5.0, 5.0], [5.0, 5.0], 3.0, Rgb::WHITE);
        canvas.disc([-50.0, 500.0], 5.0, Rgb::WHITE);
        canvas.text([-500.0, 900.0], Anchor::End, 12.0, Rgb::WHITE, "far");
        assert!(canvas.pixels().iter().all(|&b| b == 0));
    }

    #[test]
    fn long_texts_are_cut() {
        let (text, size) = fitted("short", 16.0, 500.0);
        assert!(text == "short" && size == 16.0);
        let (text, size) = fitted(&"long ".repeat(80), 16.0, 300.0);
        assert!(text.ends_with('…') && text_width(&text, size) <= 300.0 && size >= 12.0);
        let (text, size) = fitted_before(&"long ".repeat(80), ", at 3 s", 16.0, 300.0);
        assert!(
            text.ends_with("…, at 3 s") && text_width(&text, size) <= 300.0 && size >= 8.9,
            "{text} {size}"
        );
    }
}
