//! Legend of a line plot: in a corner without data, otherwise beside the plot.

use super::canvas::{Anchor, Canvas, Point, text_width};
use super::colour::Rgb;
use super::lines::Style;
use super::strokes;

/// Em of the legend's letters, pixels.
const SIZE: f64 = 14.0;
const ROW: f64 = 22.0;
const SAMPLE: f64 = 30.0;
const PADDING: f64 = 10.0;
const MARGIN: f64 = 10.0;

/// One line of the legend.
#[derive(Debug)]
pub(super) struct Entry {
    pub(super) name: String,
    pub(super) index: usize,
    pub(super) colour: Rgb,
    pub(super) style: Style,
}

/// Width and height of the legend.
pub(super) fn size(entries: &[Entry]) -> (f64, f64) {
    let widest = entries.iter().map(|e| text_width(&e.name, SIZE)).fold(0.0, tegula::norm::larger);
    (widest + SAMPLE + 8.0 + 2.0 * PADDING, ROW * entries.len() as f64 + PADDING)
}

/// Upper left corner of a legend of that size in the first corner of the frame that covers no drawn line.
pub(super) fn free_corner(
    (width, height): (f64, f64),
    [left, top]: Point,
    [right, bottom]: Point,
    drawn: &[Vec<Point>],
) -> Option<Point> {
    if width > 0.55 * (right - left) || height > 0.6 * (bottom - top) {
        return None;
    }
    let (x0, x1) = (left + MARGIN, right - MARGIN - width);
    let (y0, y1) = (top + MARGIN, bottom - MARGIN - height);
    let centre = (x0 + x1) / 2.0;
    let places = [[x1, y0], [x0, y0], [x1, y1], [x0, y1], [centre, y0], [centre, y1]];
    places.into_iter().find(|&[x, y]| {
        let (low, high) = ([x - 8.0, y - 8.0], [x + width + 8.0, y + height + 8.0]);
        !drawn.iter().any(|line| crosses(line, low, high))
    })
}

/// Whether a chain of lines, or its only point, meets a rectangle.
pub(super) fn crosses(line: &[Point], low: Point, high: Point) -> bool {
    let only = line.first().filter(|_| line.len() == 1).map(|&p| (p, p));
    line.windows(2).map(|pair| (pair[0], pair[1])).chain(only).any(|(a, b)| {
        // The part of the segment within the slab of each direction (Liang and Barsky).
        let (mut start, mut end) = (0.0_f64, 1.0_f64);
        for axis in 0..2 {
            let step = b[axis] - a[axis];
            if step == 0.0 {
                if a[axis] < low[axis] || a[axis] > high[axis] {
                    return false;
                }
                continue;
            }
            let (s, t) = ((low[axis] - a[axis]) / step, (high[axis] - a[axis]) / step);
            start = start.max(s.min(t));
            end = end.min(s.max(t));
        }
        start <= end
    })
}

/// Draws the legend with its upper left corner at the given place.
pub(super) fn draw(canvas: &mut Canvas, [x, y]: Point, entries: &[Entry]) {
    let (width, height) = size(entries);
    canvas.rectangle([x, y], [x + width, y + height], Rgb::GRID);
    canvas.rectangle([x + 1.0, y + 1.0], [x + width - 1.0, y + height - 1.0], Rgb::WHITE);
    for (row, entry) in entries.iter().enumerate() {
        let middle = y + PADDING / 2.0 + ROW * (row as f64 + 0.5);
        let (start, end) = (x + PADDING, x + PADDING + SAMPLE);
        strokes::line(canvas, &[[start, middle], [end, middle]], entry.style, entry.colour);
        if entry.style.has_markers() {
            strokes::marker(canvas, [(start + end) / 2.0, middle], entry.index, entry.colour);
        }
        canvas.text([end + 8.0, middle + 0.36 * SIZE], Anchor::Start, SIZE, Rgb::INK, &entry.name);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_legend_keeps_clear_of_the_data() {
        let (low, high) = ([0.0, 0.0], [400.0, 300.0]);
        let size = (100.0, 50.0);
        assert_eq!(free_corner(size, low, high, &[]), Some([290.0, 10.0]));
        let falling = vec![vec![[0.0, 0.0], [400.0, 300.0]]];
        assert_eq!(free_corner(size, low, high, &falling), Some([290.0, 10.0]));
        let rising = vec![vec![[0.0, 300.0], [400.0, 0.0]]];
        assert_eq!(free_corner(size, low, high, &rising), Some([10.0, 10.0]));
        let comb: Vec<Vec<Point>> =
            (0..40).map(|i| vec![[10.0 * f64::from(i), 0.0], [10.0 * f64::from(i), 300.0]]).collect();
        assert_eq!(free_corner(size, low, high, &comb), None);
        assert!(free_corner((390.0, 50.0), low, high, &[]).is_none());
        let lonely = vec![vec![[300.0, 20.0]]];
        assert_eq!(free_corner(size, low, high, &lonely), Some([10.0, 10.0]));
    }
}
