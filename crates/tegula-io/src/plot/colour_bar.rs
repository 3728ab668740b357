//! Colour bar, and triad of the directions.

use super::canvas::{Anchor, Canvas, Point, fitted, text_width};
use super::colour::{Rgb, viridis};
use super::projection::{Camera, Vec3};
use super::ticks::Axis;

const TICK: f64 = 14.0;
const LABEL: f64 = 15.0;
const BAR: f64 = 16.0;

/// Draws the bar with its right end at `right`, between two heights.
pub(super) fn draw(canvas: &mut Canvas, axis: &Axis, label: &str, right: f64, [top, bottom]: [f64; 2]) {
    let ticks = axis.ticks(6);
    let widest = ticks.major.iter().map(|t| text_width(&t.1, TICK)).fold(0.0, tegula::norm::larger);
    let name_room = if label.is_empty() { 0.0 } else { LABEL + 12.0 };
    let x1 = right - widest - name_room - 10.0;
    let x0 = x1 - BAR;
    canvas.fill_with(&[[x0, top], [x1, top], [x1, bottom], [x0, bottom]], 1.0, |[_, y]| {
        viridis((bottom - y) / (bottom - top))
    });
    for (place, text) in &ticks.major {
        let y = bottom - place * (bottom - top);
        canvas.line([x1, y], [x1 + 4.0, y], 1.0, Rgb::QUIET);
        canvas.text([x1 + 8.0, y + 0.36 * TICK], Anchor::Start, TICK, Rgb::INK, text);
    }
    canvas.text([x0, top - 10.0], Anchor::Start, TICK, Rgb::INK, &ticks.shared);
    let (label, size) = fitted(label, LABEL, bottom - top + 60.0);
    canvas.upright_text([right, (top + bottom) / 2.0], Anchor::Middle, size, Rgb::INK, &label);
}

/// Width that the bar and its words need.
pub(super) fn width(axis: &Axis, label: &str) -> f64 {
    let widest = axis.ticks(6).major.iter().map(|t| text_width(&t.1, TICK)).fold(0.0, tegula::norm::larger);
    let name_room = if label.is_empty() { 0.0 } else { LABEL + 12.0 };
    BAR + widest + name_room + 10.0
}

/// Draws the directions of x, y and z from a common foot.
pub(super) fn triad(canvas: &mut Canvas, camera: &Camera, foot: Point) {
    const LENGTH: f64 = 36.0;
    let axes = [
        ("x", Vec3::x(), Rgb::hex(0xb5473c)),
        ("y", Vec3::y(), Rgb::hex(0x3f8f4f)),
        ("z", Vec3::z(), Rgb::hex(0x3866a8)),
    ];
    let mut seen = axes.map(|(name, axis, colour)| (name, camera.see(&axis), colour));
    seen.sort_by(|a, b| a.1.z.total_cmp(&b.1.z));
    for (name, axis, colour) in seen {
        let length = axis.x.hypot(axis.y);
        let tip = [foot[0] + LENGTH * axis.x, foot[1] - LENGTH * axis.y];
        if length < 0.08 {
            // Straight at the viewer or away.
            canvas.disc(foot, 3.5, colour);
            canvas.text([foot[0] - 10.0, foot[1] + 14.0], Anchor::Middle, TICK, colour, name);
            continue;
        }
        let (ux, uy) = (axis.x / length, -axis.y / length);
        let head = 8.0_f64.min(LENGTH * length);
        let neck = [tip[0] - head * ux, tip[1] - head * uy];
        canvas.line(foot, neck, 1.7, colour);
        let wing = 3.4;
        canvas.fill(
            &[tip, [neck[0] - wing * uy, neck[1] + wing * ux], [neck[0] + wing * uy, neck[1] - wing * ux]],
            colour,
        );
        let at = [tip[0] + 9.0 * ux, tip[1] + 9.0 * uy + 0.3 * TICK];
        canvas.text(at, Anchor::Middle, TICK, colour, name);
    }
}
