//! Folded sheet: checks of the polyline, and the division of the elements among its segments.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};

use super::grid::{Lines, Progression, nearest_line};
use super::input::{Input, TINY};
use super::surfaces::Extrusion;
use crate::Vec3;
use crate::model::ExtrusionMesh;

/// Surface of a swept polyline and the lines of its grid.
///
/// A graded polyline is graded as a whole: elements and nodes lie where the
/// progression puts them on the unfolded sheet, but for the small shift that
/// brings a node to every vertex.
///
/// Returns `None` where `input` has gained issues.
pub(super) fn extrusion(source: &ExtrusionMesh, input: &mut Input) -> Option<(Extrusion, Lines)> {
    let before = input.issues.len();
    input.grid(&source.grid);
    let along = input.direction("mesh.sweep", "the sweep", source.sweep);
    let (vertices, closed) = vertices(source, input)?;
    let normals = normals(&vertices, along?, closed, input);
    let lengths: Vec<f64> = vertices.windows(2).map(|ends| (ends[1] - ends[0]).norm()).collect();
    let segments = lengths.len();
    let total = (source.grid.elements[0] as usize).max(segments);
    input.element_count(total as u64 * u64::from(source.grid.elements[1]));
    if input.issues.len() > before {
        return None;
    }
    let lines = lines(&lengths, total, source, closed);
    Some((Extrusion { vertices, sweep: Vec3::from(source.sweep), normals }, lines))
}

/// Vertices, and whether the last one is the first again; `None` if there is no usable polyline.
fn vertices(source: &ExtrusionMesh, input: &mut Input) -> Option<(Vec<Vec3>, bool)> {
    let key = |i: usize| format!("mesh.vertices[{i}]");
    let given = &source.vertices;
    let mut vertices: Vec<Vec3> = Vec::with_capacity(given.len());
    for (i, &vertex) in given.iter().enumerate() {
        vertices.extend(input.point(&key(i), &format!("vertex {i}"), vertex));
    }
    if given.len() < 2 {
        let message = format!("the polyline has {} vertices", given.len());
        input.wrong("mesh.vertices", message, "give at least two");
    }
    if given.len() < 2 || vertices.len() < given.len() {
        return None;
    }
    let length: f64 = vertices.windows(2).map(|ends| (ends[1] - ends[0]).norm()).sum();
    let near = |a: usize, b: usize| (vertices[a] - vertices[b]).norm() <= TINY * length;
    let last = vertices.len() - 1;
    let mut distinct = true;
    for i in 1..=last {
        if near(i - 1, i) {
            distinct = false;
            let message = format!("vertices {} and {i} coincide at {:?}", i - 1, given[i]);
            input.wrong(&key(i), message, "remove one of them");
        }
    }
    if !distinct {
        return None;
    }
    let closed = near(0, last);
    if closed && last < 3 {
        let message = "the closed polyline has only two segments, one on the other";
        input.wrong("mesh.vertices", message, "give at least three segments, or leave the last vertex out");
        return None;
    }
    if closed {
        vertices[last] = vertices[0];
    }
    // Sheets that meet elsewhere than at the ends would not be connected there.
    let mut seen = BTreeMap::new();
    let cell = TINY * length;
    for (i, vertex) in vertices.iter().enumerate().take(last + usize::from(!closed)) {
        let place = [0, 1, 2].map(|k| ((vertex[k] - vertices[0][k]) / cell).round() as i64);
        if let Some(other) = seen.insert(place, i) {
            input.wrong(
                &key(i),
                format!("vertices {other} and {i} coincide at {:?}, but only the two ends of a polyline are joined", given[i]),
                "give junctions as a mesh file, or move one of the vertices",
            );
        }
    }
    Some((vertices, closed))
}

/// Unit normals segment × sweep of the sheets, `along` being the sweep's direction.
fn normals(vertices: &[Vec3], along: Vec3, closed: bool, input: &mut Input) -> Vec<Vec3> {
    let tangents: Vec<Vec3> = vertices.windows(2).map(|ends| (ends[1] - ends[0]).normalize()).collect();
    let mut normals = Vec::with_capacity(tangents.len());
    for (i, tangent) in tangents.iter().enumerate() {
        let normal = tangent.cross(&along);
        if normal.norm() <= TINY {
            input.wrong(
                "mesh.sweep",
                format!("the sweep is parallel to the segment from vertex {i} to {}", i + 1),
                "turn the sweep out of the segment's direction",
            );
        }
        normals.push(normal.normalize());
        let next = if i + 1 < tangents.len() { Some(i + 1) } else { closed.then_some(0) };
        if let Some(next) = next.filter(|&next| (tangent + tangents[next]).norm() <= TINY) {
            input.wrong(
                &format!("mesh.vertices[{}]", i + 1),
                format!("the polyline turns back on itself: segments {i} and {next} lie on one another"),
                "move a vertex so that the two sheets part",
            );
        }
    }
    normals
}

/// Lines of the grid; u counts segments, so that vertices are whole numbers.
fn lines(lengths: &[f64], total: usize, source: &ExtrusionMesh, closed: bool) -> Lines {
    let whole: f64 = lengths.iter().sum();
    let progression = Progression::new(total, source.grid.grading[0]);
    // bounds of the segments as parts of the length, and of the elements
    let mut places = vec![0.0];
    let mut sum = 0.0;
    for length in lengths {
        sum += length;
        places.push(sum / whole);
    }
    let parts: Vec<f64> = places.iter().map(|&s| progression.inverse(s.min(1.0))).collect();
    let counts = share_out(&parts.windows(2).map(|ends| ends[1] - ends[0]).collect::<Vec<_>>(), total);
    let (mut u, mut straight, mut along) = (Vec::new(), Vec::new(), Vec::new());
    for (segment, &count) in counts.iter().enumerate() {
        let piece = progression.piece(parts[segment], parts[segment + 1]);
        for (k, local) in piece.lines(count).into_iter().take(count).enumerate() {
            u.push(segment as f64 + local);
            straight.push(k == 0);
            along.push(places[segment] + local * (places[segment + 1] - places[segment]));
        }
    }
    u.push(counts.len() as f64);
    straight.push(true);
    along.push(1.0);
    let rows = source.grid.elements[1] as usize;
    let v = Progression::new(rows, source.grid.grading[1]).lines(rows);
    let middle = [nearest_line(&along), nearest_line(&v)];
    Lines { u, v, straight, joined: closed, middle }
}

/// Shares `total` elements out in proportion to `parts` (which sum to 1), at least
/// one each; `total` is at least their number. What rounding down leaves goes to
/// the segments with the longest elements.
fn share_out(parts: &[f64], total: usize) -> Vec<usize> {
    let free = total.saturating_sub(parts.len());
    let mut counts: Vec<usize> = parts.iter().map(|part| 1 + (part * free as f64).floor() as usize).collect();
    let given: usize = counts.iter().sum();
    // bits of positive numbers are ordered as the numbers are
    let key = |part: f64, count: usize| (part.max(0.0) / count as f64).to_bits();
    let mut longest: BinaryHeap<_> =
        parts.iter().enumerate().map(|(i, &part)| (key(part, counts[i]), Reverse(i))).collect();
    for _ in given..total {
        if let Some((_, Reverse(i))) = longest.pop() {
            counts[i] += 1;
            longest.push((key(parts[i], counts[i]), Reverse(i)));
        }
    }
    counts
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn elements_go_by_length() {
        assert_eq!(share_out(&[0.25; 4], 8), [2, 2, 2, 2]);
        assert_eq!(share_out(&[0.75, 0.25], 8), [6, 2]);
        assert_eq!(share_out(&[0.5, 0.125, 0.125, 0.125, 0.125], 16), [8, 2, 2, 2, 2]);
        assert_eq!(share_out(&[0.99, 0.01], 2), [1, 1]);
        assert_eq!(share_out(&[0.5, 0.5], 5), [3, 2]);
    }

    proptest! {
        #[test]
        fn all_elements_are_shared_out(lengths in prop::collection::vec(0.01f64..10.0, 1..30), more in 0usize..100) {
            let sum: f64 = lengths.iter().sum();
            let parts: Vec<f64> = lengths.iter().map(|l| l / sum).collect();
            let total = parts.len() + more;
            let counts = share_out(&parts, total);
            prop_assert_eq!(counts.iter().sum::<usize>(), total);
            prop_assert!(counts.iter().all(|&count| count >= 1));
        }
    }
}
