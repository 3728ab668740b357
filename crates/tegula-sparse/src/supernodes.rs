//! Supernodes: elimination tree, fundamental supernodes, relaxed amalgamation and the postorder of the assembly tree.

use super::ordering::CompressedGraph;

/// Relaxed-amalgamation thresholds: largest share of explicit zeros in the merged supernode, by its number of columns.
const AMALGAMATION_THRESHOLDS: [(usize, f64); 3] = [(24, 0.8), (64, 0.15), (usize::MAX, 0.04)];
/// Thresholds with an interface: the factors of many subdomains are held at a time, so that memory counts. On a square
/// of 17 × 17 nodes with six unknowns each and its boundary as interface, these save 8 % of the factor of the interior;
/// a factorisation takes 3 % longer.
const THRESHOLDS_WITH_INTERFACE: [(usize, f64); 3] = [(12, 0.8), (64, 0.1), (usize::MAX, 0.04)];

/// Supernode in terms of supervariables: columns of (nearly) equal structure that are eliminated in one front.
#[derive(Debug, Clone, Default)]
pub(super) struct Supernode {
    pub columns: Vec<u32>,
    pub rows: Vec<u32>,
    pub parent: Option<u32>,
    /// Number of unknowns in `columns`; `below` is the number of unknowns in `rows`.
    pub width: usize,
    pub below: usize,
    /// Number of explicit zeros in the trapezoid of the factor.
    pub zeros: f64,
}

fn trapezoid(width: usize, below: usize) -> f64 {
    let (w, m) = (width as f64, below as f64);
    w * (w + 1.0) / 2.0 + w * m
}

/// Elimination tree by Liu's algorithm with path compression: the parent of each of `n` nodes, `u32::MAX` for a root.
/// `position` is the node of each supervariable; all those of the interface are the last node.
fn elimination_tree(graph: &CompressedGraph, order: &[u32], position: &[u32], n: usize) -> Vec<u32> {
    const NONE: u32 = u32::MAX;
    // Compressed paths.
    let (mut parent, mut ancestor) = (vec![NONE; n], vec![NONE; n]);
    for (i, &g) in order.iter().enumerate() {
        let i = i.min(n - 1);
        for &h in &graph.neighbours[g as usize] {
            let mut r = position[h as usize];
            if r as usize >= i {
                continue;
            }
            loop {
                let next = ancestor[r as usize];
                if next == i as u32 {
                    break;
                }
                ancestor[r as usize] = i as u32;
                if next == NONE {
                    parent[r as usize] = i as u32;
                    break;
                }
                r = next;
            }
        }
    }
    parent
}

/// Fundamental supernodes in postorder: a column joins the supernode of its last child in the elimination tree if the
/// rows of the child are the column itself and the column's rows. The columns of the interface, which end the order, are
/// one node of the elimination tree and the last supernode.
pub(super) fn fundamental_supernodes(graph: &CompressedGraph, order: &[u32]) -> Vec<Supernode> {
    const NONE: u32 = u32::MAX;
    let interior = graph.len() - graph.interface.len();
    let n = interior + usize::from(!graph.interface.is_empty());
    let mut position = vec![0_u32; graph.len()];
    for (k, &g) in order.iter().enumerate() {
        position[g as usize] = k.min(interior) as u32;
    }
    let parent = elimination_tree(graph, order, &position, n);
    let postorder = postorder(&parent);
    let mut rank = vec![0_u32; n];
    for (k, &node) in postorder.iter().enumerate() {
        rank[node as usize] = k as u32;
    }
    let weight = |g: u32| graph.supervariables[g as usize].len();
    let mut mark = vec![NONE; graph.len()];
    let mut structure: Vec<Vec<u32>> = vec![Vec::new(); n];
    let mut children: Vec<Vec<u32>> = vec![Vec::new(); n];
    let mut supernodes: Vec<Supernode> = Vec::new();
    // Supernode of each node of the elimination tree, by postorder number.
    let mut supernode_of = vec![0_u32; n];
    for (k, &node) in postorder.iter().enumerate() {
        if node as usize == interior {
            supernode_of[k] = supernodes.len() as u32;
            let columns = order[interior..].to_vec();
            let width = columns.iter().map(|&g| weight(g)).sum();
            supernodes.push(Supernode { columns, width, ..Supernode::default() });
            continue;
        }
        let g = order[node as usize];
        let mut rows = Vec::new();
        mark[g as usize] = k as u32;
        let later = graph.neighbours[g as usize].iter().copied().filter(|&h| position[h as usize] > node);
        for h in later.chain(children[k].iter().flat_map(|&c| structure[c as usize].iter().copied())) {
            if mark[h as usize] != k as u32 {
                mark[h as usize] = k as u32;
                rows.push(h);
            }
        }
        let only = children[k].last().copied();
        let below: usize = rows.iter().map(|&h| weight(h)).sum();
        for &c in &children[k] {
            structure[c as usize] = Vec::new();
        }
        let same = only.filter(|&c| {
            c as usize + 1 == k && supernodes[supernode_of[c as usize] as usize].below == below + weight(g)
        });
        let supernode = if let Some(c) = same {
            let f = supernode_of[c as usize];
            supernodes[f as usize].columns.push(g);
            f
        } else {
            supernodes.push(Supernode { columns: vec![g], ..Supernode::default() });
            supernodes.len() as u32 - 1
        };
        supernode_of[k] = supernode;
        let supernode = &mut supernodes[supernode as usize];
        supernode.width += weight(g);
        supernode.below = below;
        supernode.rows.clone_from(&rows);
        structure[k] = rows;
        if parent[node as usize] != NONE {
            children[rank[parent[node as usize] as usize] as usize].push(k as u32);
        }
    }
    for (k, &node) in postorder.iter().enumerate() {
        let p = parent[node as usize];
        if p != NONE {
            let up = supernode_of[rank[p as usize] as usize];
            if up != supernode_of[k] {
                supernodes[supernode_of[k] as usize].parent = Some(up);
            }
        }
    }
    supernodes
}

/// Postorder of a forest: children before parents.
fn postorder(parent: &[u32]) -> Vec<u32> {
    const NONE: u32 = u32::MAX;
    let n = parent.len();
    let (mut first, mut next) = (vec![NONE; n], vec![NONE; n]);
    let mut roots = Vec::new();
    for v in (0..n).rev() {
        match parent[v] {
            NONE => roots.push(v as u32),
            p => {
                next[v] = first[p as usize];
                first[p as usize] = v as u32;
            }
        }
    }
    let mut out = Vec::with_capacity(n);
    let mut stack = Vec::new();
    for root in roots.into_iter().rev() {
        stack.push(root);
        while let Some(&v) = stack.last() {
            let child = first[v as usize];
            if child == NONE {
                out.push(v);
                stack.pop();
            } else {
                first[v as usize] = next[child as usize];
                stack.push(child);
            }
        }
    }
    out
}

/// Relaxed amalgamation: merges supernodes with their parents where that adds few explicit zeros. With `interface` the
/// last supernode is that of the interface, with which none is merged.
pub(super) fn amalgamate(mut supernodes: Vec<Supernode>, interface: bool) -> Vec<Supernode> {
    let n = supernodes.len();
    let mut children: Vec<Vec<u32>> = vec![Vec::new(); n];
    for (f, supernode) in supernodes.iter().enumerate() {
        if let Some(p) = supernode.parent {
            children[p as usize].push(f as u32);
        }
    }
    let thresholds = if interface { THRESHOLDS_WITH_INTERFACE } else { AMALGAMATION_THRESHOLDS };
    let mut absorbed = vec![false; n];
    for p in 0..n - usize::from(interface) {
        // The child that adds the smallest share of zeros comes first, mostly the one with the largest structure.
        loop {
            let parent = &supernodes[p];
            let joined = |c: u32| {
                let child = &supernodes[c as usize];
                let all = trapezoid(child.width + parent.width, parent.below);
                let zeros = all - trapezoid(child.width, child.below) - trapezoid(parent.width, parent.below)
                    + child.zeros
                    + parent.zeros;
                (zeros, zeros / all)
            };
            let best = children[p].iter().copied().min_by(|&a, &b| joined(a).1.total_cmp(&joined(b).1));
            let Some(c) = best else { break };
            let (zeros, share) = joined(c);
            let width = supernodes[c as usize].width + parent.width;
            let allowed = thresholds.iter().find(|(w, _)| width <= *w).map_or(0.0, |z| z.1);
            if share > allowed {
                break;
            }
            let child = std::mem::take(&mut supernodes[c as usize]);
            absorbed[c as usize] = true;
            let parent = &mut supernodes[p];
            parent.width = width;
            parent.zeros = zeros;
            let mut columns = child.columns;
            columns.append(&mut parent.columns);
            parent.columns = columns;
            children[p].retain(|&x| x != c);
            let grandchildren = std::mem::take(&mut children[c as usize]);
            for &x in &grandchildren {
                supernodes[x as usize].parent = Some(p as u32);
            }
            children[p].extend(grandchildren);
        }
    }
    without_empty(supernodes, &absorbed)
}

/// Removes the absorbed supernodes and renumbers the parents. No remaining supernode has an absorbed parent.
pub(super) fn without_empty(supernodes: Vec<Supernode>, absorbed: &[bool]) -> Vec<Supernode> {
    let mut number = vec![0_u32; supernodes.len()];
    let mut kept = 0;
    for (number, absorbed) in number.iter_mut().zip(absorbed) {
        *number = kept;
        kept += u32::from(!absorbed);
    }
    let mut out: Vec<Supernode> =
        supernodes.into_iter().zip(absorbed).filter(|(_, g)| !**g).map(|(f, _)| f).collect();
    for f in &mut out {
        f.parent = f.parent.map(|p| number[p as usize]);
    }
    out
}

/// Postorder that minimises the contribution-block stack: subtrees are contiguous, and children are sorted by the stack
/// peak of their subtree minus the size of their contribution block, largest first.
///
/// J. W. H. Liu, *On the storage requirement in the out-of-core multifrontal method for sparse factorization*, ACM
/// Trans. Math. Softw. 12 (1986) 249–264.
pub(super) fn postorder_minimizing_stack(supernodes: &mut Vec<Supernode>) {
    let n = supernodes.len();
    let mut children: Vec<Vec<u32>> = vec![Vec::new(); n];
    let mut roots = Vec::new();
    for (f, supernode) in supernodes.iter().enumerate() {
        match supernode.parent {
            Some(p) => children[p as usize].push(f as u32),
            None => roots.push(f as u32),
        }
    }
    let left = |f: u32| (supernodes[f as usize].below as f64).powi(2);
    let mut peak = vec![0.0_f64; n];
    for f in 0..n {
        let mut mine = std::mem::take(&mut children[f]);
        mine.sort_by(|&a, &b| (peak[b as usize] - left(b)).total_cmp(&(peak[a as usize] - left(a))));
        let mut held = 0.0;
        for &c in &mine {
            peak[f] = peak[f].max(held + peak[c as usize]);
            held += left(c);
        }
        peak[f] = peak[f].max(held + left(f as u32));
        children[f] = mine;
    }
    let mut out = Vec::with_capacity(n);
    let mut number = vec![0_u32; n];
    let mut stack: Vec<(u32, usize)> = Vec::new();
    for root in roots {
        stack.push((root, 0));
        while let Some((f, next)) = stack.pop() {
            if let Some(&c) = children[f as usize].get(next) {
                stack.push((f, next + 1));
                stack.push((c, 0));
            } else {
                number[f as usize] = out.len() as u32;
                out.push(std::mem::take(&mut supernodes[f as usize]));
            }
        }
    }
    for f in &mut out {
        f.parent = f.parent.map(|p| number[p as usize]);
    }
    *supernodes = out;
}
