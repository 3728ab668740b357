//! Partition of a shell mesh into connected subdomains of about equal size, by recursive bisection.
//!
//! A set of elements is bisected across the direction in which it is longest. The sides of the element in its middle
//! are tried first, then the principal axis of the centres of its elements. The cut goes where there is a gap between
//! the centres, so that on regular meshes it follows the lines of the mesh.

use std::collections::{BTreeMap, HashMap};

use super::Quads;
use crate::lists::Lists;
use crate::{Mat3, Vec3};

/// Share of the elements around the desired position of a cut in which a gap is searched.
const WINDOW: f64 = 0.12;
/// Factor by which the extent along the principal axis must exceed that along the element sides for the axis to be
/// used.
const LONGER: f64 = 1.5;

/// Partitions the elements into subdomains of about `size`; returns the subdomain of each element, and their number.
pub(super) fn partition(quads: &Quads<'_>, size: usize) -> (Vec<u32>, usize) {
    let mut order: Vec<u32> = (0..quads.len() as u32).collect();
    let count = (quads.len() as f64 / size as f64).round().max(1.0) as usize;
    let mut sizes = Vec::with_capacity(count);
    cut(quads, &mut order, count, &mut sizes);
    let mut subdomain = vec![0; quads.len()];
    let mut at = 0;
    for (p, &n) in sizes.iter().enumerate() {
        for &q in &order[at..at + n] {
            subdomain[q as usize] = p as u32;
        }
        at += n;
    }
    connect(quads, &mut subdomain, sizes.len(), size)
}

fn cut(quads: &Quads<'_>, order: &mut [u32], count: usize, sizes: &mut Vec<usize>) {
    if count < 2 || order.len() < 2 {
        sizes.push(order.len());
        return;
    }
    let left = count / 2;
    let at = split(quads, order, left as f64 / count as f64);
    let (a, b) = order.split_at_mut(at);
    if order_is_large(a.len() + b.len()) {
        let (mut of_a, mut of_b) = (Vec::new(), Vec::new());
        rayon::join(|| cut(quads, a, left, &mut of_a), || cut(quads, b, count - left, &mut of_b));
        sizes.append(&mut of_a);
        sizes.append(&mut of_b);
    } else {
        cut(quads, a, left, sizes);
        cut(quads, b, count - left, sizes);
    }
}

fn order_is_large(n: usize) -> bool {
    n > 10_000
}

/// Sorts elements along the direction in which they extend most and returns where to cut them, near `share` of them.
fn split(quads: &Quads<'_>, order: &mut [u32], share: f64) -> usize {
    let n = order.len();
    let mean = order.iter().map(|&q| quads.centre(q)).sum::<Vec3>() / n as f64;
    let extent = |d: &Vec3| {
        let (low, high) = order.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), &q| {
            let x = d.dot(&(quads.centre(q) - mean));
            (l.min(x), h.max(x))
        });
        high - low
    };
    let middle = order
        .iter()
        .copied()
        .min_by(|&a, &b| {
            let from = |q: u32| (quads.centre(q) - mean).norm_squared();
            from(a).total_cmp(&from(b)).then(a.cmp(&b))
        })
        .unwrap_or(0);
    let mut best = (Vec3::x(), -1.0);
    for d in quads.directions(middle) {
        let e = extent(&d);
        if e > 1.0001 * best.1 {
            best = (d, e);
        }
    }
    let mut inertia = Mat3::zeros();
    for &q in order.iter() {
        let x = quads.centre(q) - mean;
        inertia += x * x.transpose();
    }
    let eigen = inertia.symmetric_eigen();
    let axis: Vec3 = eigen.eigenvectors.column(eigen.eigenvalues.imax()).into();
    if extent(&axis) > LONGER * best.1 {
        best.0 = axis;
    }
    let mut keys: Vec<(f64, u32)> =
        order.iter().map(|&q| (best.0.dot(&(quads.centre(q) - mean)), q)).collect();
    keys.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    for (o, k) in order.iter_mut().zip(&keys) {
        *o = k.1;
    }
    let wanted = share * n as f64;
    let reach = (WINDOW * n as f64).max(1.0);
    let low = ((wanted - reach).floor() as usize).clamp(1, n - 1);
    let high = ((wanted + reach).ceil() as usize).clamp(low, n - 1);
    let gap = |k: usize| keys[k].0 - keys[k - 1].0;
    let widest = (low..=high).map(gap).fold(0.0, crate::norm::larger);
    (low..=high)
        .filter(|&k| gap(k) >= 0.5 * widest)
        .min_by(|&a, &b| (a as f64 - wanted).abs().total_cmp(&(b as f64 - wanted).abs()))
        .unwrap_or(n / 2)
        .clamp(1, n - 1)
}

/// Makes every subdomain connected through sides of elements: a disconnected part becomes a subdomain of its own or, if
/// it is small, joins the neighbour with which it shares most sides.
fn connect(quads: &Quads<'_>, subdomain: &mut [u32], count: usize, size: usize) -> (Vec<u32>, usize) {
    let neighbours = neighbours(quads);
    // Connected parts of the subdomains.
    let mut part = vec![u32::MAX; subdomain.len()];
    let mut parts: Vec<Vec<u32>> = Vec::new();
    let mut largest: Vec<Option<usize>> = vec![None; count];
    for first in 0..subdomain.len() as u32 {
        if part[first as usize] != u32::MAX {
            continue;
        }
        let number = parts.len();
        let mut members = vec![first];
        part[first as usize] = number as u32;
        let mut at = 0;
        while at < members.len() {
            for &q in neighbours.of(members[at] as usize) {
                if part[q as usize] == u32::MAX && subdomain[q as usize] == subdomain[first as usize] {
                    part[q as usize] = number as u32;
                    members.push(q);
                }
            }
            at += 1;
        }
        let best = &mut largest[subdomain[first as usize] as usize];
        if best.is_none_or(|b| parts[b].len() < members.len()) {
            *best = Some(number);
        }
        parts.push(members);
    }
    let mut main: Vec<bool> = vec![false; parts.len()];
    largest.iter().flatten().for_each(|&p| main[p] = true);
    for (p, members) in parts.iter().enumerate() {
        main[p] |= 4 * members.len() >= size;
    }
    let mut next = 0;
    let mut number = vec![u32::MAX; parts.len()];
    for p in 0..parts.len() {
        if main[p] {
            number[p] = next;
            next += 1;
        }
    }
    // Small parts join neighbours that have a number, until none is left that has such a neighbour.
    loop {
        let mut changed = false;
        for p in 0..parts.len() {
            if number[p] != u32::MAX {
                continue;
            }
            let mut shared: BTreeMap<u32, usize> = BTreeMap::new();
            for &q in &parts[p] {
                for &other in neighbours.of(q as usize) {
                    let n = number[part[other as usize] as usize];
                    if n != u32::MAX {
                        *shared.entry(n).or_default() += 1;
                    }
                }
            }
            if let Some((&n, _)) = shared.iter().max_by_key(|(_, sides)| **sides) {
                number[p] = n;
                changed = true;
            }
        }
        if !changed {
            match number.iter_mut().find(|n| **n == u32::MAX) {
                Some(n) => {
                    *n = next;
                    next += 1;
                }
                None => break,
            }
        }
    }
    (part.iter().map(|&p| number[p as usize]).collect(), next as usize)
}

/// Adjacency of the elements: those that share a side with each element.
fn neighbours(quads: &Quads<'_>) -> Lists<u32> {
    let mut sides: Vec<(u32, u32, u32)> = Vec::with_capacity(4 * quads.len());
    for q in 0..quads.len() as u32 {
        for (a, b) in quads.sides(q) {
            sides.push((a.min(b), a.max(b), q));
        }
    }
    sides.sort_unstable();
    let mut pairs = Vec::with_capacity(2 * sides.len());
    for group in sides.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
        for a in group {
            pairs.extend(group.iter().filter(|b| b.2 != a.2).map(|b| (a.2, b.2)));
        }
    }
    pairs.sort_unstable();
    pairs.dedup();
    Lists::by_key(quads.len(), pairs.into_iter())
}

/// Graph of the nodes that `keep` selects: their neighbours along sides of elements.
pub(super) fn node_graph(quads: &Quads<'_>, keep: impl Fn(u32) -> bool) -> HashMap<u32, Vec<u32>> {
    let mut out: HashMap<u32, Vec<u32>> = HashMap::new();
    for q in 0..quads.len() as u32 {
        for (a, b) in quads.sides(q) {
            if keep(a) && keep(b) {
                out.entry(a).or_default().push(b);
                out.entry(b).or_default().push(a);
            }
        }
    }
    for list in out.values_mut() {
        list.sort_unstable();
        list.dedup();
    }
    out
}
