//! Heat map: table of ratios as coloured cells, light at 1 and dark far below 1.

use std::path::Path;

use super::canvas::{Anchor, Canvas, text_width};
use super::colour::Rgb;
use crate::out::OutputError;

const TITLE: f64 = 20.0;
const LABEL: f64 = 15.0;
const CELL: [f64; 2] = [74.0, 30.0];
const GAP: f64 = 16.0;
const MARGIN: f64 = 26.0;

/// Rows or columns under a common head.
#[derive(Debug, Clone, Default)]
pub struct Group {
    /// The head.
    pub head: String,
    /// Names of its members.
    pub members: Vec<String>,
}

impl Group {
    /// Adds a member to the last group if that has the same head, else to a new one.
    pub fn add(groups: &mut Vec<Self>, head: &str, member: &str) {
        match groups.last_mut().filter(|g| g.head == head) {
            Some(group) => group.members.push(member.into()),
            None => groups.push(Self { head: head.into(), members: vec![member.into()] }),
        }
    }
}

/// A table of ratios to what is right.
#[derive(Debug, Clone, Default)]
pub struct HeatMap {
    /// Title.
    pub title: String,
    /// Rows.
    pub rows: Vec<Group>,
    /// Columns.
    pub columns: Vec<Group>,
    /// Values by rows; what is not a number stays empty.
    pub values: Vec<Vec<f64>>,
    /// A remark below, empty for none.
    pub note: String,
}

/// Middle of each member along an axis, beginning at `start`, and the end of the last.
fn middles(groups: &[Group], start: f64, size: f64) -> (Vec<Vec<f64>>, f64) {
    let mut at = start;
    let mut out = Vec::new();
    for group in groups {
        out.push((0..group.members.len()).map(|k| at + (k as f64 + 0.5) * size).collect::<Vec<_>>());
        at += group.members.len() as f64 * size + GAP;
    }
    (out, at - GAP)
}

/// Dark violet at 0 over orange to near white at 1; grey-blue beyond. Light and dark alone tell it, too.
fn colour(ratio: f64) -> Rgb {
    const STOPS: [(f64, u32); 5] =
        [(0.0, 0x2d_1160), (0.3, 0x8c_2981), (0.6, 0xde_4968), (0.85, 0xfe_9f6d), (1.0, 0xff_f9e8)];
    if ratio > 1.0 {
        return Rgb::hex(STOPS[4].1).mix(Rgb::hex(0x7a_9cc6), ((ratio - 1.0) / 0.25).min(1.0));
    }
    let ratio = ratio.max(0.0);
    for pair in STOPS.windows(2) {
        let [(a, from), (b, to)] = [pair[0], pair[1]];
        if ratio <= b {
            return Rgb::hex(from).mix(Rgb::hex(to), (ratio - a) / (b - a));
        }
    }
    Rgb::hex(STOPS[4].1)
}

/// Draws the table as a PNG file.
///
/// # Errors
/// The file cannot be written.
pub fn heat_map(path: &Path, map: &HeatMap) -> Result<(), OutputError> {
    let widest = |texts: &mut dyn Iterator<Item = &String>| {
        texts.map(|t| text_width(t, LABEL)).fold(0.0, tegula::norm::larger)
    };
    let heads = widest(&mut map.rows.iter().map(|g| &g.head));
    let names = widest(&mut map.rows.iter().flat_map(|g| &g.members));
    // A head must fit over its columns.
    let fit = map.columns.iter().map(|g| (text_width(&g.head, LABEL) + 8.0) / g.members.len().max(1) as f64);
    let cell = [fit.fold(CELL[0], f64::max), CELL[1]];
    let (left, top) = (MARGIN + heads + GAP + names + 12.0, 118.0);
    let (xs, right) = middles(&map.columns, left, cell[0]);
    let (ys, bottom) = middles(&map.rows, top, cell[1]);
    let width = (right + MARGIN)
        .max(MARGIN * 2.0 + text_width(&map.note, LABEL - 2.0))
        .max(MARGIN * 2.0 + text_width(&map.title, TITLE));
    let mut canvas = Canvas::new(width.ceil() as u32, (bottom + 52.0).ceil() as u32);
    canvas.text([MARGIN, 40.0], Anchor::Start, TITLE, Rgb::INK, &map.title);
    for (group, xs) in map.columns.iter().zip(&xs) {
        let (Some(first), Some(last)) = (xs.first(), xs.last()) else { continue };
        canvas.text([(first + last) / 2.0, 80.0], Anchor::Middle, LABEL, Rgb::INK, &group.head);
        let ends = [first - cell[0] / 2.0 + 6.0, last + cell[0] / 2.0 - 6.0];
        canvas.line([ends[0], 88.0], [ends[1], 88.0], 1.0, Rgb::MISSING);
        for (name, x) in group.members.iter().zip(xs) {
            canvas.text([*x, 107.0], Anchor::Middle, LABEL, Rgb::QUIET, name);
        }
    }
    for (group, ys) in map.rows.iter().zip(&ys) {
        let Some(first) = ys.first() else { continue };
        canvas.text([MARGIN, first + 5.0], Anchor::Start, LABEL, Rgb::INK, &group.head);
        for (name, y) in group.members.iter().zip(ys) {
            canvas.text([left - 12.0, y + 5.0], Anchor::End, LABEL, Rgb::INK, name);
        }
    }
    for (values, y) in map.values.iter().zip(ys.iter().flatten()) {
        for (value, x) in values.iter().zip(xs.iter().flatten()) {
            if !value.is_finite() {
                continue;
            }
            let half = [cell[0] / 2.0 - 1.0, cell[1] / 2.0 - 1.0];
            let paint = colour(*value);
            canvas.rectangle([x - half[0], y - half[1]], [x + half[0], y + half[1]], paint);
            let Rgb([r, g, b]) = paint;
            let ink = if 0.30 * r + 0.59 * g + 0.11 * b > 0.55 { Rgb::INK } else { Rgb::WHITE };
            let text = if value.abs() < 0.005 { format!("{value:.0e}") } else { format!("{value:.2}") };
            canvas.text([*x, y + 5.0], Anchor::Middle, LABEL, ink, &text);
        }
    }
    canvas.text([MARGIN, bottom + 32.0], Anchor::Start, LABEL - 2.0, Rgb::QUIET, &map.note);
    canvas.save(path)
}
