//! Placement of the labels of snapshots: on empty paper, near a visible point of the snapshot.
//!
//! Every snapshot tries places around its visible nodes; the place that is free, near and outside wins. Labels
//! are set one after the other, so the result depends on the data alone.

use super::canvas::{Anchor, Canvas, Point, text_width};
use super::colour::Rgb;
use super::facets::Owners;
use super::legend::crosses;

/// Em of the letters, pixels.
const SIZE: f64 = 16.0;
const HEIGHT: f64 = 0.76 * SIZE;
const DIRECTIONS: usize = 16;
const DISTANCES: [f64; 7] = [9.0, 16.0, 26.0, 40.0, 60.0, 90.0, 130.0];
/// Visible nodes tried per snapshot, about.
const NODES: usize = 240;

/// Label of a snapshot, and positions of its nodes on the sheet.
pub(super) struct Request<'a> {
    pub(super) text: &'a str,
    /// Number of the snapshot plus one.
    pub(super) owner: u16,
    pub(super) nodes: Vec<Point>,
}

/// A rectangle by its lower and upper corner coordinates.
type Box2 = [Point; 2];

struct Choice {
    score: f64,
    node: Point,
    centre: Point,
    distance: f64,
}

/// All that a place is judged by.
struct Sheet<'a> {
    room: Box2,
    owners: &'a Owners,
    crowd: Crowd,
    middle: Point,
    /// Labels that are set, and what else must stay clear.
    taken: Vec<Box2>,
    /// Lines from labels to their nodes.
    leaders: Vec<[Point; 2]>,
}

/// Draws all labels within the rectangle `room`, clear of the rectangles in `taken`. Gives the rectangles and lines of the
/// labels.
pub(super) fn place(
    canvas: &mut Canvas,
    owners: &Owners,
    room: Box2,
    taken: Vec<Box2>,
    requests: &[Request<'_>],
) -> (Vec<Box2>, Vec<[Point; 2]>) {
    let all: Vec<Point> = requests.iter().flat_map(|r| r.nodes.iter().copied()).collect();
    let count = all.len().max(1) as f64;
    let middle = [0, 1].map(|k| all.iter().map(|p| p[k]).sum::<f64>() / count);
    let (crowd, before) = (Crowd::new(owners, canvas.size()), taken.len());
    let mut sheet = Sheet { room, owners, crowd, middle, taken, leaders: Vec::new() };
    for request in requests.iter().filter(|r| !r.text.is_empty()) {
        let width = text_width(request.text, SIZE);
        let visible: Vec<Point> =
            request.nodes.iter().copied().filter(|&p| seen_near(owners, p, request.owner)).collect();
        let stride = visible.len().div_ceil(NODES).max(1);
        let mut best: Option<Choice> = None;
        for &node in visible.iter().step_by(stride) {
            for choice in choices(node, width) {
                let score = sheet.rate(&choice, width, request.owner);
                if best.as_ref().is_none_or(|b| score < b.score) {
                    best = Some(Choice { score, ..choice });
                }
            }
        }
        let Some(choice) = best else { continue };
        let [low, high] = outline(choice.centre, width, 3.0);
        if choice.distance > DISTANCES[0] {
            let end = [choice.node[0].clamp(low[0], high[0]), choice.node[1].clamp(low[1], high[1])];
            canvas.line(choice.node, end, 0.9, Rgb::QUIET);
            sheet.leaders.push([choice.node, end]);
            canvas.disc(choice.node, 2.1, Rgb::QUIET);
        }
        let baseline = [choice.centre[0], choice.centre[1] + HEIGHT / 2.0];
        canvas.text(baseline, Anchor::Middle, SIZE, Rgb::INK, request.text);
        sheet.taken.push([low, high]);
    }
    (sheet.taken.split_off(before), sheet.leaders)
}

fn seen_near(owners: &Owners, [x, y]: Point, owner: u16) -> bool {
    [[0.0, 0.0], [1.5, 0.0], [-1.5, 0.0], [0.0, 1.5], [0.0, -1.5]]
        .iter()
        .any(|[dx, dy]| owners.at([x + dx, y + dy]) == owner)
}

/// Centres of labels at all distances in all directions from a node.
fn choices(node: Point, width: f64) -> impl Iterator<Item = Choice> {
    (0..DIRECTIONS).flat_map(move |i| {
        let angle = std::f64::consts::TAU * i as f64 / DIRECTIONS as f64;
        let (sin, cos) = angle.sin_cos();
        // From the centre of the label to its border, towards the node.
        let inside = (width / 2.0 / cos.abs().max(1e-9)).min(HEIGHT / 2.0 / sin.abs().max(1e-9));
        DISTANCES.into_iter().map(move |distance| {
            let reach = distance + inside;
            Choice { score: 0.0, node, centre: [node[0] + reach * cos, node[1] + reach * sin], distance }
        })
    })
}

/// The label's rectangle with a margin.
fn outline(centre: Point, width: f64, margin: f64) -> Box2 {
    let (w, h) = (width / 2.0 + margin, HEIGHT / 2.0 + margin);
    [[centre[0] - w, centre[1] - h], [centre[0] + w, centre[1] + h]]
}

impl Sheet<'_> {
    /// Score of a place for the label of a snapshot; the lowest is best.
    fn rate(&self, choice: &Choice, width: f64, owner: u16) -> f64 {
        let bounds = outline(choice.centre, width, 5.0);
        let outside = (0..2).any(|k| bounds[0][k] < self.room[0][k] || bounds[1][k] > self.room[1][k]);
        let leader = [choice.node, choice.centre];
        let hits = self.taken.iter().filter(|other| overlap(&bounds, other)).count()
            + self.taken.iter().filter(|other| crosses(&leader, other[0], other[1])).count()
            + self.leaders.iter().filter(|other| crosses(&other[..], bounds[0], bounds[1])).count();
        let covered = self.crowd.count(bounds);
        // Others that the leader crosses on its way cost more than the snapshot itself.
        let (mut own, mut others) = (0.0, 0.0);
        let steps = (choice.distance / 2.0).ceil().max(1.0);
        for i in 1..=steps as usize {
            let share = i as f64 / steps;
            let at = [0, 1].map(|k| choice.node[k] + (choice.centre[k] - choice.node[k]) * share);
            match self.owners.at(at) {
                0 => {}
                number if number == owner => own += 1.0,
                _ => others += 1.0,
            }
        }
        let direction = [choice.centre[0] - choice.node[0], choice.centre[1] - choice.node[1]];
        let outward = [choice.node[0] - self.middle[0], choice.node[1] - self.middle[1]];
        let lengths = direction[0].hypot(direction[1]) * outward[0].hypot(outward[1]);
        let along = direction[0] * outward[0] + direction[1] * outward[1];
        let cosine = if lengths > 0.0 { along / lengths } else { 0.0 };
        1e6 * f64::from(u8::from(outside))
            + 1e5 * hits as f64
            + 4.0 * covered
            + 2.0 * choice.distance
            + 4.0 * own
            + 14.0 * others
            - 18.0 * cosine
            - 0.03 * outward[0].hypot(outward[1])
    }
}

fn overlap(a: &Box2, b: &Box2) -> bool {
    (0..2).all(|k| a[0][k] < b[1][k] && b[0][k] < a[1][k])
}

/// Sums of painted pixels, to count those in any rectangle at once.
struct Crowd {
    width: usize,
    height: usize,
    sums: Vec<u32>,
}

impl Crowd {
    fn new(owners: &Owners, (width, height): (f64, f64)) -> Self {
        let (width, height) = (width as usize, height as usize);
        let mut sums = vec![0; (width + 1) * (height + 1)];
        for y in 0..height {
            let mut row = 0;
            for x in 0..width {
                row += u32::from(owners.at([x as f64, y as f64]) != 0);
                sums[(y + 1) * (width + 1) + x + 1] = sums[y * (width + 1) + x + 1] + row;
            }
        }
        Self { width, height, sums }
    }

    fn count(&self, [low, high]: Box2) -> f64 {
        let column = |x: f64| (x.max(0.0) as usize).min(self.width);
        let row = |y: f64| (y.max(0.0) as usize).min(self.height);
        let sum = |x: f64, y: f64| f64::from(self.sums[row(y) * (self.width + 1) + column(x)]);
        sum(high[0], high[1]) - sum(low[0], high[1]) - sum(high[0], low[1]) + sum(low[0], low[1])
    }
}
