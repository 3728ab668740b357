//! Unknowns that subdomains share, and selection of the primal nodes on the interface Γ.
//!
//! Primal nodes of an interface edge between two subdomains are its ends, where it meets other edges or the boundary of
//! the model, and nodes in between such that no node is farther than a given number of elements from a primal one. All
//! unknowns of a primal node are primal: its position and director leave a subdomain no motion but rotation about the
//! director, which a second primal node prevents.

use std::collections::hash_map::Entry;
use std::collections::{BTreeMap, BTreeSet, HashMap, VecDeque};

use super::partition::node_graph;
use super::{Quads, Terms};
use crate::system::LocalFrames;
use crate::system::dof_map::CONSTRAINED;

/// Minimum number of primal nodes of a subdomain, where it has so many nodes on the interface. Two prevent all rigid
/// motions; three also where they lie close together.
const FEWEST: usize = 3;

/// Subdomains of the nodal vectors.
pub(super) struct Sharing {
    /// Subdomains of the vectors that lie in several, ascending.
    pub shared: BTreeMap<u32, Vec<u32>>,
}

impl Sharing {
    /// Finds the shared vectors from the subdomains of the terms.
    pub fn new(terms: &Terms, subdomain_of_term: impl Fn(usize) -> u32, vectors: usize) -> Self {
        let mut first = vec![u32::MAX; vectors];
        let mut more = Vec::new();
        for t in 0..terms.len() {
            let subdomain = subdomain_of_term(t);
            for &v in terms.vectors(t) {
                let known = &mut first[v as usize];
                if *known == u32::MAX {
                    *known = subdomain;
                } else if *known != subdomain {
                    more.push((v, subdomain));
                }
            }
        }
        more.sort_unstable();
        more.dedup();
        let mut shared: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        for (v, subdomain) in more {
            shared.entry(v).or_insert_with(|| vec![first[v as usize]]).push(subdomain);
        }
        shared.values_mut().for_each(|subdomains| subdomains.sort_unstable());
        Self { shared }
    }
}

/// Classification of the interface nodes.
pub(super) struct PrimalNodes {
    /// Primal nodes, at which the subdomains are coupled.
    pub primal: BTreeSet<u32>,
    /// Interface edge of each other node: a connected set of nodes between the same subdomains.
    pub edges: HashMap<u32, u32>,
}

/// Selects the primal nodes; no node is farther than `reach` elements from one along its interface edge. Nodes of `dangling`
/// vectors, of which a subdomain holds no elements but a director-angle constraint, are primal.
pub(super) fn select_primal_nodes(
    quads: &Quads<'_>,
    (sharing, dangling): (&Sharing, &BTreeSet<u32>),
    node_of: &[u32],
    frames: &LocalFrames,
    reach: usize,
) -> PrimalNodes {
    let (sets, free) = interface_nodes(sharing, node_of, frames);
    let graph = node_graph(quads, |n| sets.contains_key(&n));
    let none = Vec::new();
    let around = |n: u32| graph.get(&n).unwrap_or(&none).iter().copied();
    let (parts, part_of) = connected_parts(&sets, &around);
    let same = |a: u32, b: u32| part_of.get(&a) == part_of.get(&b);
    let is_end = |n: u32| around(n).filter(|&m| same(n, m)).count() < 2;
    // Fully constrained nodes act as primal nodes, too.
    let mut primal: BTreeSet<u32> = sets.keys().copied().filter(|n| !free.contains(n)).collect();
    primal.extend(dangling.iter().map(|&v| node_of[v as usize]));
    for many in [true, false] {
        for (number, members) in parts.iter().enumerate() {
            if (sets[&members[0]].len() > 2) != many {
                continue;
            }
            let mut ends: Vec<u32> = members.iter().copied().filter(|&n| is_end(n)).collect();
            ends.sort_unstable();
            for n in ends {
                if many || !around(n).any(|m| primal.contains(&m)) {
                    primal.insert(n);
                }
            }
            fill(members, &around, |n| part_of.get(&n) == Some(&number), reach, &mut primal);
        }
    }
    hold(quads, &sets, &mut primal);
    let mut edges = HashMap::new();
    let mut count = 0;
    for &node in sets.keys().filter(|n| !primal.contains(n)) {
        if edges.contains_key(&node) {
            continue;
        }
        edges.insert(node, count);
        let mut waiting = vec![node];
        while let Some(n) = waiting.pop() {
            for m in around(n).filter(|&m| same(n, m) && !primal.contains(&m)) {
                if let Entry::Vacant(place) = edges.entry(m) {
                    place.insert(count);
                    waiting.push(m);
                }
            }
        }
        count += 1;
    }
    PrimalNodes { primal: primal.intersection(&free).copied().collect(), edges }
}

/// Subdomains of each interface node, ascending, and the interface nodes with free degrees of freedom.
fn interface_nodes(
    sharing: &Sharing,
    node_of: &[u32],
    frames: &LocalFrames,
) -> (BTreeMap<u32, Vec<u32>>, BTreeSet<u32>) {
    let mut sets: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    let mut free = BTreeSet::new();
    for (&v, subdomains) in &sharing.shared {
        let node = node_of[v as usize];
        let set = sets.entry(node).or_default();
        set.extend(subdomains);
        set.sort_unstable();
        set.dedup();
        if frames.of(v as usize).iter().any(|&n| n != CONSTRAINED) {
            free.insert(node);
        }
    }
    (sets, free)
}

/// Connected parts of the interface between the same subdomains, and the part of each node.
fn connected_parts<I: Iterator<Item = u32>>(
    sets: &BTreeMap<u32, Vec<u32>>,
    around: &impl Fn(u32) -> I,
) -> (Vec<Vec<u32>>, HashMap<u32, usize>) {
    let mut part_of: HashMap<u32, usize> = HashMap::new();
    let mut parts: Vec<Vec<u32>> = Vec::new();
    for (&node, set) in sets {
        if part_of.contains_key(&node) {
            continue;
        }
        let mut members = vec![node];
        part_of.insert(node, parts.len());
        let mut at = 0;
        while at < members.len() {
            for n in around(members[at]) {
                if !part_of.contains_key(&n) && sets.get(&n) == Some(set) {
                    part_of.insert(n, parts.len());
                    members.push(n);
                }
            }
            at += 1;
        }
        parts.push(members);
    }
    (parts, part_of)
}

/// Adds primal nodes to subdomains with fewer than [`FEWEST`], far from those that there are.
fn hold(quads: &Quads<'_>, sets: &BTreeMap<u32, Vec<u32>>, primal: &mut BTreeSet<u32>) {
    let mut nodes: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for (&node, set) in sets {
        set.iter().for_each(|&subdomain| nodes.entry(subdomain).or_default().push(node));
    }
    let at = |n: u32| quads.positions[n as usize];
    for nodes in nodes.values() {
        let mut held: Vec<u32> = nodes.iter().copied().filter(|n| primal.contains(n)).collect();
        while held.len() < FEWEST.min(nodes.len()) {
            let distance =
                |n: u32| held.iter().map(|&h| (at(n) - at(h)).norm()).fold(f64::INFINITY, f64::min);
            let free = nodes.iter().copied().filter(|n| !held.contains(n));
            let Some(farthest) = free.max_by(|&a, &b| distance(a).total_cmp(&distance(b)).then(b.cmp(&a)))
            else {
                break;
            };
            held.push(farthest);
            primal.insert(farthest);
        }
    }
}

/// Adds primal nodes to an interface edge until no node is farther than `reach` from one.
fn fill<I: Iterator<Item = u32>>(
    members: &[u32],
    around: &impl Fn(u32) -> I,
    within: impl Fn(u32) -> bool,
    reach: usize,
    primal: &mut BTreeSet<u32>,
) {
    let mut added = 0;
    loop {
        let mut distance: HashMap<u32, usize> = HashMap::new();
        let mut queue = VecDeque::new();
        for &n in members {
            let start = if primal.contains(&n) {
                0
            } else if around(n).any(|m| !within(m) && primal.contains(&m)) {
                1
            } else {
                continue;
            };
            distance.insert(n, start);
            queue.push_back((n, start));
        }
        // Nodes at distance 0 come first.
        queue.make_contiguous().sort_by_key(|&(n, d)| (d, n));
        while let Some((n, d)) = queue.pop_front() {
            for m in around(n).filter(|&m| within(m)) {
                if let Entry::Vacant(place) = distance.entry(m) {
                    place.insert(d + 1);
                    queue.push_back((m, d + 1));
                }
            }
        }
        let far = |n: u32| distance.get(&n).copied().unwrap_or(usize::MAX);
        let Some(&farthest) = members.iter().max_by(|&&a, &&b| far(a).cmp(&far(b)).then(b.cmp(&a))) else {
            return;
        };
        // An interface edge that meets nothing is a ring: three primal nodes hold it.
        let ring = added > 0 && added < 3 && far(farthest) > 1;
        if far(farthest) == usize::MAX || far(farthest) > reach || ring {
            added += usize::from(far(farthest) == usize::MAX || added > 0);
            primal.insert(farthest);
        } else {
            return;
        }
    }
}
