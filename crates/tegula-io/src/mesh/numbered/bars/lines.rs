//! Lines of bars: those that continue each other become one beam.
//!
//! Two bars continue each other at a node where both are held, if they have one property, meet in a point and lie nearly along one
//! direction. Where more than two meet, the straightest pair does.

use std::collections::BTreeMap;

use tegula::Vec3;

use super::{Bar, Release};

/// Largest angle (degrees) between bars of a line: the bending stiffness of a beam falls with the square of the angle in an element.
const LARGEST_ANGLE: f64 = 5.0;
/// Distance of two points over the length of a bar, below which they are one.
const SAME_POINT: f64 = 1e-9;
/// Angle (radians) between the axes y of a bar and of the line, below which they are one.
const SAME_AXIS: f64 = 1e-5;
/// Sine of the angle between the orientation vector of a line and a bar, below which the vector does not orient the bar.
const ALONG: f64 = 0.05;
/// Most ends in a node among which lines are looked for.
const MOST_ENDS: usize = 32;

/// Bars that are one beam.
#[derive(Debug, Clone, PartialEq)]
pub struct Line {
    /// Name of the beam, after its first bar.
    pub name: String,
    /// Number of the property.
    pub property: u64,
    /// Numbers of the nodes.
    pub nodes: Vec<u64>,
    /// Places of the cross-sections.
    pub points: Vec<Vec3>,
    /// Orientation vector, in the plane of the axes x and y of all bars.
    pub direction: Vec3,
    /// Releases of both ends.
    pub releases: [Release; 2],
    /// Line of the file with the first bar.
    pub line: usize,
}

impl Line {
    /// Name of a cross-section, counted from 0.
    pub fn section(&self, at: usize) -> String {
        match at {
            0 => format!("{}.start", self.name),
            n if n + 1 == self.nodes.len() => format!("{}.end", self.name),
            n => format!("{}.{n}", self.name),
        }
    }

    /// Name of the set of the nodes of shells that move with it.
    pub fn set(&self) -> String {
        format!("nodes of {}", self.name)
    }

    /// Release of the bars of a cross-section, counted from 0.
    pub fn release(&self, at: usize) -> Release {
        match at {
            0 => self.releases[0],
            n if n + 1 == self.nodes.len() => self.releases[1],
            _ => Release::Nothing,
        }
    }
}

/// A bar of a line, and whether the line runs from its end B to A.
type Link = (usize, bool);
/// An end of a bar: index of the bar, and 0 for A or 1 for B.
type BarEnd = (usize, usize);

/// Lines of bars, in the order of their first bars.
pub fn lines(bars: &[Bar]) -> Vec<Line> {
    let partners = partners(bars);
    let mut seen = vec![false; bars.len()];
    let mut out = Vec::new();
    for first in 0..bars.len() {
        if seen[first] {
            continue;
        }
        let chain = chain(first, &partners);
        chain.iter().for_each(|(bar, _)| seen[*bar] = true);
        out.extend(split(bars, &chain).iter().filter_map(|links| line(bars, links)));
    }
    out.sort_by_key(|line| line.line);
    out
}

/// The end of another bar that continues each end.
fn partners(bars: &[Bar]) -> Vec<[Option<BarEnd>; 2]> {
    let mut at_node: BTreeMap<u64, Vec<BarEnd>> = BTreeMap::new();
    for (i, bar) in bars.iter().enumerate() {
        for (k, end) in bar.ends.iter().enumerate().filter(|(_, end)| end.release == Release::Nothing) {
            at_node.entry(end.node).or_default().push((i, k));
        }
    }
    let mut out = vec![[None; 2]; bars.len()];
    for ends in at_node.values().filter(|ends| ends.len() <= MOST_ENDS) {
        let mut pairs: Vec<(f64, BarEnd, BarEnd)> = Vec::new();
        for (n, &first) in ends.iter().enumerate() {
            let others = ends.iter().skip(n + 1).copied();
            pairs.extend(others.filter_map(|other| Some((angle(bars, first, other)?, first, other))));
        }
        pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
        for (_, first, other) in pairs {
            if out[first.0][first.1].is_none() && out[other.0][other.1].is_none() {
                out[first.0][first.1] = Some(other);
                out[other.0][other.1] = Some(first);
            }
        }
    }
    out
}

/// Angle (radians) between two bars of which one may continue the other.
fn angle(bars: &[Bar], first: BarEnd, other: BarEnd) -> Option<f64> {
    let (a, b) = (&bars[first.0], &bars[other.0]);
    // Axis of each bar out of the node.
    let out = |bar: &Bar, end: usize| if end == 0 { bar.axes[0] } else { -bar.axes[0] };
    let length = (a.ends[1].point - a.ends[0].point).norm();
    let apart = (a.ends[first.1].point - b.ends[other.1].point).norm();
    let angle = (-out(a, first.1)).angle(&out(b, other.1));
    let one = first.0 != other.0 && a.property == b.property && apart <= SAME_POINT * length;
    (one && angle <= LARGEST_ANGLE.to_radians()).then_some(angle)
}

/// Bars that continue each other on both sides of one, from one end of the chain to the other; a ring begins with this bar.
fn chain(first: usize, partners: &[[Option<BarEnd>; 2]]) -> Vec<Link> {
    let (mut bar, mut end) = (first, 0);
    while let Some((other, entered)) = partners[bar][end] {
        (bar, end) = (other, 1 - entered);
        if bar == first {
            break;
        }
    }
    if bar == first {
        end = 0;
    }
    let start = bar;
    let mut out = vec![(bar, end == 1)];
    while let Some((other, entered)) = partners[bar][1 - end] {
        if other == start {
            break;
        }
        (bar, end) = (other, entered);
        out.push((bar, end == 1));
    }
    out
}

/// Parts of a chain that one direction orients.
fn split(bars: &[Bar], chain: &[Link]) -> Vec<Vec<Link>> {
    let mut out: Vec<Vec<Link>> = Vec::new();
    for &link in chain {
        match out.last_mut() {
            Some(part) if continues(bars, part, link) => part.push(link),
            _ => out.push(vec![link]),
        }
    }
    out
}

/// Whether the orientation vector of the first bar of a part gives the axis y of a further one.
fn continues(bars: &[Bar], part: &[Link], (next, _): Link) -> bool {
    let (Some((first, _)), Some((last, _))) = (part.first(), part.last()) else { return false };
    let vector = bars[*first].orientation;
    let across = |bar: usize| {
        let axis = bars[bar].axes[0];
        (vector - axis * axis.dot(&vector)).try_normalize(ALONG * vector.norm())
    };
    let (Some(before), Some(own)) = (across(*last), across(next)) else { return false };
    own.cross(&bars[next].axes[1]).norm() <= SAME_AXIS && own.dot(&before) > 0.5
}

fn line(bars: &[Bar], links: &[Link]) -> Option<Line> {
    let (first, _) = *links.first()?;
    let bar = &bars[first];
    let ends = |(i, reversed): Link| {
        let [a, b] = bars[i].ends;
        if reversed { [b, a] } else { [a, b] }
    };
    let [start, _] = ends(*links.first()?);
    let [_, end] = ends(*links.last()?);
    let all = || std::iter::once(start).chain(links.iter().map(|link| ends(*link)[1]));
    Some(Line {
        name: bar.name(),
        property: bar.property,
        nodes: all().map(|end| end.node).collect(),
        points: all().map(|end| end.point).collect(),
        direction: bar.orientation,
        releases: [start.release, end.release],
        line: bar.line,
    })
}
