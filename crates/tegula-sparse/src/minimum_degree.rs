//! Approximate minimum degree ordering of a graph (AMD).
//!
//! The elimination is simulated on the quotient graph. A node of it is a variable, which is still to be eliminated, or an
//! element, the clique that an eliminated variable leaves behind. A variable has a list of its elements and of its
//! other neighbours; an element has a list of its variables. Elements that lie within a new one are absorbed, also those
//! that have no variable outside of it (aggressive absorption). Variables that have become indistinguishable are merged,
//! and those that are adjacent to the new element alone are eliminated with it (mass elimination).
//!
//! P. R. Amestoy, T. A. Davis, I. S. Duff, *An approximate minimum degree ordering algorithm*, SIAM J. Matrix Anal. Appl.
//! 17 (1996) 886–905; *Algorithm 837: AMD*, ACM Trans. Math. Softw. 30 (2004) 381–388. Ties are broken as there.

/// No node.
const NONE: u32 = u32::MAX;

/// A node with more neighbours than this multiple of `√n` is ordered last.
const DENSE: f64 = 10.0;

/// Least number of neighbours of a node that is ordered last because of them.
const FEWEST: usize = 16;

/// Elimination order of a graph. Node j has the neighbours `lists[pointers[j]..pointers[j + 1]]`, without itself.
pub(super) fn minimum_degree(pointers: &[usize], lists: Vec<u32>) -> Vec<u32> {
    let mut graph = QuotientGraph::new(pointers, lists);
    graph.start();
    while graph.eliminated < graph.n {
        let pivot = graph.next_pivot();
        graph.eliminate(pivot);
    }
    graph.order()
}

struct QuotientGraph {
    n: usize,
    /// Number of variables that are eliminated or ordered last.
    eliminated: usize,
    /// Lists of all nodes. Those of new elements are appended.
    lists: Vec<u32>,
    /// Start and length of the list of each node.
    start: Vec<usize>,
    length: Vec<u32>,
    /// Number of elements at the beginning of the list of a variable.
    elements: Vec<u32>,
    /// Number of variables that a node stands for; 0 if it is merged into another one. It is negative while the node
    /// belongs to the new element.
    weight: Vec<i32>,
    /// Approximate degree of a variable, weight of the variables of an element.
    degree: Vec<u32>,
    /// Order of the front of an element.
    front: Vec<u32>,
    /// Node that absorbed this one.
    parent: Vec<u32>,
    /// Marks relative to `flag`; 0 for an absorbed element.
    mark: Vec<u64>,
    flag: u64,
    /// Largest weight of the variables of an element so far.
    largest: u32,
    /// Lists of the variables of each degree, doubly linked. The links serve the hash buckets, too.
    head: Vec<u32>,
    next: Vec<u32>,
    last: Vec<u32>,
    least_degree: usize,
    /// Variables of the new element by the hash of their lists.
    buckets: Vec<u32>,
}

impl QuotientGraph {
    fn new(pointers: &[usize], lists: Vec<u32>) -> Self {
        let n = pointers.len() - 1;
        let length: Vec<u32> = pointers.windows(2).map(|p| (p[1] - p[0]) as u32).collect();
        Self {
            n,
            eliminated: 0,
            lists,
            start: pointers[..n].to_vec(),
            degree: length.clone(),
            length,
            elements: vec![0; n],
            weight: vec![1; n],
            front: vec![1; n],
            parent: vec![NONE; n],
            mark: vec![1; n],
            flag: 2,
            largest: 0,
            head: vec![NONE; n],
            next: vec![NONE; n],
            last: vec![NONE; n],
            least_degree: 0,
            buckets: vec![NONE; n],
        }
    }

    /// Puts the variables into the lists of their degrees. Those without neighbours are eliminated.
    fn start(&mut self) {
        let dense = ((DENSE * (self.n as f64).sqrt()) as usize).max(FEWEST).min(self.n);
        for i in 0..self.n {
            let degree = self.degree[i] as usize;
            if degree == 0 {
                self.mark[i] = 0;
                self.eliminated += 1;
            } else if degree > dense {
                self.weight[i] = 0;
                self.eliminated += 1;
            } else {
                self.insert(i as u32);
            }
        }
    }

    /// Puts a variable at the head of the list of its degree.
    fn insert(&mut self, i: u32) {
        let degree = self.degree[i as usize] as usize;
        let next = self.head[degree];
        if next != NONE {
            self.last[next as usize] = i;
        }
        self.next[i as usize] = next;
        self.last[i as usize] = NONE;
        self.head[degree] = i;
    }

    /// Takes a variable out of the list of its degree.
    fn remove(&mut self, i: usize) {
        let (last, next) = (self.last[i], self.next[i]);
        if next != NONE {
            self.last[next as usize] = last;
        }
        if last != NONE {
            self.next[last as usize] = next;
        } else {
            self.head[self.degree[i] as usize] = next;
        }
    }

    /// Takes a variable of least approximate degree out of its list.
    fn next_pivot(&mut self) -> usize {
        while self.head[self.least_degree] == NONE {
            self.least_degree += 1;
        }
        let pivot = self.head[self.least_degree] as usize;
        self.remove(pivot);
        pivot
    }

    /// Entry range of the list of a node.
    fn list(&self, node: usize) -> std::ops::Range<usize> {
        self.start[node]..self.start[node] + self.length[node] as usize
    }

    fn eliminate(&mut self, pivot: usize) {
        let in_place = self.elements[pivot] == 0;
        let mut pivots = self.weight[pivot];
        self.eliminated += pivots as usize;
        self.weight[pivot] = -pivots;
        let mut size = self.new_element(pivot);
        self.degree[pivot] = size;
        self.front[pivot] = pivots as u32 + size;
        self.outside_weights(pivot);
        for p in self.list(pivot) {
            let i = self.lists[p] as usize;
            if !self.update_variable(i, pivot) {
                // Mass elimination: the variable is adjacent to the new element alone.
                let weight = -self.weight[i];
                self.parent[i] = pivot as u32;
                self.weight[i] = 0;
                size -= weight as u32;
                pivots += weight;
                self.eliminated += weight as usize;
            }
        }
        self.degree[pivot] = size;
        self.largest = self.largest.max(size);
        self.flag += u64::from(self.largest);
        self.merge_indistinguishable(pivot);
        self.finish_element(pivot, size, in_place);
        self.weight[pivot] = pivots;
    }

    /// Makes the pivot an element: the union of its neighbours and of the variables of its elements, which it absorbs.
    /// Returns the weight of its variables.
    fn new_element(&mut self, pivot: usize) -> u32 {
        let list = self.list(pivot);
        let elements = self.elements[pivot] as usize;
        let mut size = 0;
        if elements == 0 {
            let mut end = list.start;
            for p in list.clone() {
                if let Some(i) = self.take(p, &mut size) {
                    self.lists[end] = i;
                    end += 1;
                }
            }
            self.length[pivot] = (end - list.start) as u32;
            return size;
        }
        let start = self.lists.len();
        for p in list.start..list.start + elements {
            let e = self.lists[p] as usize;
            self.append(self.list(e), &mut size);
            self.parent[e] = pivot as u32;
            self.mark[e] = 0;
        }
        self.append(list.start + elements..list.end, &mut size);
        self.start[pivot] = start;
        self.length[pivot] = (self.lists.len() - start) as u32;
        size
    }

    /// Appends the variables in a part of the lists that are not yet in the new element.
    fn append(&mut self, part: std::ops::Range<usize>, size: &mut u32) {
        for p in part {
            if let Some(i) = self.take(p, size) {
                self.lists.push(i);
            }
        }
    }

    /// Takes the variable at a place of the lists into the new element, unless it belongs to it or is gone.
    fn take(&mut self, place: usize, size: &mut u32) -> Option<u32> {
        let i = self.lists[place];
        let weight = self.weight[i as usize];
        if weight <= 0 {
            return None;
        }
        *size += weight as u32;
        self.weight[i as usize] = -weight;
        self.remove(i as usize);
        Some(i)
    }

    /// Finds, for all elements of the variables of the new element, the weight of their variables outside of it:
    /// `mark − flag`.
    fn outside_weights(&mut self, pivot: usize) {
        for p in self.list(pivot) {
            let i = self.lists[p] as usize;
            let weight = u64::from(self.weight[i].unsigned_abs());
            let first = self.start[i];
            for &e in &self.lists[first..first + self.elements[i] as usize] {
                let e = e as usize;
                let mark = self.mark[e];
                if mark >= self.flag {
                    self.mark[e] = mark - weight;
                } else if mark != 0 {
                    self.mark[e] = u64::from(self.degree[e]) + self.flag - weight;
                }
            }
        }
    }

    /// Removes from the list of a variable of the new element what this element covers, computes its approximate
    /// degree without the new element, and puts it into a hash bucket. Returns false if nothing is left of the list.
    fn update_variable(&mut self, i: usize, pivot: usize) -> bool {
        let list = self.list(i);
        let (first, end_of_elements) = (list.start, list.start + self.elements[i] as usize);
        let (mut end, mut hash, mut degree) = (first, 0_usize, 0);
        for p in first..end_of_elements {
            let e = self.lists[p] as usize;
            let mark = self.mark[e];
            if mark > self.flag {
                degree += mark - self.flag;
                self.lists[end] = e as u32;
                end += 1;
                hash = hash.wrapping_add(e);
            } else if mark != 0 {
                // Aggressive absorption: the element has no variable outside of the new one.
                self.parent[e] = pivot as u32;
                self.mark[e] = 0;
            }
        }
        let elements = end;
        for p in end_of_elements..list.end {
            let j = self.lists[p] as usize;
            if self.weight[j] > 0 {
                degree += self.weight[j] as u64;
                self.lists[end] = j as u32;
                end += 1;
                hash = hash.wrapping_add(j);
            }
        }
        if end == first {
            return false;
        }
        self.degree[i] = u64::from(self.degree[i]).min(degree) as u32;
        // The new element comes first; the entry in its place moves behind the elements. The pivot or an element of its
        // has left the list, so there is room.
        self.lists[end] = self.lists[elements];
        self.lists[elements] = self.lists[first];
        self.lists[first] = pivot as u32;
        self.elements[i] = (elements - first) as u32 + 1;
        self.length[i] = (end - first) as u32 + 1;
        let bucket = hash % self.n;
        self.next[i] = self.buckets[bucket];
        self.last[i] = bucket as u32;
        self.buckets[bucket] = i as u32;
        true
    }

    /// Merges the variables of the new element that have equal lists.
    fn merge_indistinguishable(&mut self, pivot: usize) {
        for p in self.list(pivot) {
            let i = self.lists[p] as usize;
            if self.weight[i] >= 0 {
                continue;
            }
            let bucket = self.last[i] as usize;
            let mut i = std::mem::replace(&mut self.buckets[bucket], NONE);
            while i != NONE && self.next[i as usize] != NONE {
                self.merge_with(i as usize);
                self.flag += 1;
                i = self.next[i as usize];
            }
        }
    }

    /// Merges those variables into `i` that follow it in its bucket and have the same list.
    fn merge_with(&mut self, i: usize) {
        for p in self.list(i).skip(1) {
            self.mark[self.lists[p] as usize] = self.flag;
        }
        let (mut before, mut j) = (i, self.next[i]);
        while j != NONE {
            let at = j as usize;
            j = self.next[at];
            let equal = self.length[at] == self.length[i]
                && self.elements[at] == self.elements[i]
                && self.list(at).skip(1).all(|p| self.mark[self.lists[p] as usize] == self.flag);
            if equal {
                self.parent[at] = i as u32;
                self.weight[i] += self.weight[at];
                self.weight[at] = 0;
                self.next[before] = j;
            } else {
                before = at;
            }
        }
    }

    /// Removes merged and eliminated variables from the new element and puts the others into the lists of their degrees.
    fn finish_element(&mut self, pivot: usize, size: u32, in_place: bool) {
        let list = self.list(pivot);
        let mut end = list.start;
        let left = (self.n - self.eliminated) as u32;
        for p in list.clone() {
            let i = self.lists[p];
            let at = i as usize;
            if self.weight[at] >= 0 {
                continue;
            }
            let weight = self.weight[at].unsigned_abs();
            self.weight[at] = weight as i32;
            self.degree[at] = (self.degree[at] + size - weight).min(left - weight);
            self.insert(i);
            self.least_degree = self.least_degree.min(self.degree[at] as usize);
            self.lists[end] = i;
            end += 1;
        }
        self.length[pivot] = (end - list.start) as u32;
        if end == list.start {
            self.mark[pivot] = 0;
        }
        if !in_place {
            self.lists.truncate(end);
        }
    }

    /// Elimination order: postorder of the elements, each with the variables that it stands for.
    fn order(mut self) -> Vec<u32> {
        for i in 0..self.n {
            if self.weight[i] == 0 && self.parent[i] != NONE {
                let mut j = self.parent[i] as usize;
                while self.weight[j] == 0 {
                    j = self.parent[j] as usize;
                }
                self.parent[i] = j as u32;
            }
        }
        let mut place = vec![0; self.n];
        let mut count = 0;
        for e in self.postorder() {
            place[e as usize] = count;
            count += self.weight[e as usize] as usize;
        }
        for i in 0..self.n {
            if self.weight[i] == 0 {
                let parent = self.parent[i] as usize;
                let at = if self.parent[i] == NONE { &mut count } else { &mut place[parent] };
                let own = *at;
                *at += 1;
                place[i] = own;
            }
        }
        let mut order = vec![0; self.n];
        place.into_iter().enumerate().for_each(|(i, at)| order[at] = i as u32);
        order
    }

    /// Postorder of the elements; the child with the largest front comes last.
    fn postorder(&self) -> Vec<u32> {
        let mut children = vec![Vec::new(); self.n];
        let mut roots = Vec::new();
        for e in (0..self.n).filter(|&e| self.weight[e] > 0) {
            match self.parent[e] {
                NONE => roots.push(e as u32),
                parent => children[parent as usize].push(e as u32),
            }
        }
        for of in children.iter_mut().filter(|of| of.len() > 1) {
            let largest = (0..of.len()).max_by_key(|&k| self.front[of[k] as usize]).unwrap_or(0);
            let child = of.remove(largest);
            of.push(child);
        }
        let mut out = Vec::with_capacity(self.n);
        let mut stack: Vec<(u32, usize)> = Vec::new();
        for root in roots {
            stack.push((root, 0));
            while let Some((e, done)) = stack.pop() {
                match children[e as usize].get(done) {
                    Some(&child) => stack.extend([(e, done + 1), (child, 0)]),
                    None => out.push(e),
                }
            }
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    /// Order of a graph given by its edges.
    fn order(n: usize, edges: &[(usize, usize)]) -> Vec<u32> {
        let mut neighbours = vec![BTreeSet::new(); n];
        for &(i, j) in edges.iter().filter(|(i, j)| i != j) {
            neighbours[i].insert(j as u32);
            neighbours[j].insert(i as u32);
        }
        let (mut pointers, mut lists) = (vec![0], Vec::new());
        for of in neighbours {
            lists.extend(of);
            pointers.push(lists.len());
        }
        minimum_degree(&pointers, lists)
    }

    /// Number of edges that elimination in an order adds to a graph.
    fn fill(n: usize, edges: &[(usize, usize)], order: &[u32]) -> usize {
        let mut place = vec![0; n];
        order.iter().enumerate().for_each(|(at, &i)| place[i as usize] = at);
        let mut later = vec![BTreeSet::new(); n];
        for &(i, j) in edges.iter().filter(|(i, j)| i != j) {
            later[place[i].min(place[j])].insert(place[i].max(place[j]));
        }
        let before: usize = later.iter().map(BTreeSet::len).sum();
        for k in 0..n {
            let mut front = later[k].clone();
            if let Some(parent) = front.pop_first() {
                later[parent].extend(front);
            }
        }
        later.iter().map(BTreeSet::len).sum::<usize>() - before
    }

    fn random_edges(n: usize, count: usize) -> Vec<(usize, usize)> {
        let mut state = 1_u64;
        let mut random = move || {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            (state >> 33) as usize % n
        };
        (0..count).map(|_| (random(), random())).collect()
    }

    #[test]
    fn every_node_comes_once() {
        for n in [1, 2, 3, 10, 100, 1000] {
            for count in [0, n / 2, 2 * n, 20 * n] {
                let mut order = order(n, &random_edges(n, count));
                order.sort_unstable();
                assert!(order.into_iter().eq(0..n as u32), "{n} {count}");
            }
        }
    }

    /// Trees, and cycles but for their last triangles, are eliminated from their ends.
    #[test]
    fn trees_have_no_fill_and_cycles_the_least() {
        for n in [3, 10, 97] {
            let tree: Vec<_> = (1..n).map(|i| ((i - 1) / 3, i)).collect();
            assert_eq!(fill(n, &tree, &order(n, &tree)), 0, "{n}");
            let cycle: Vec<_> = (0..n).map(|i| (i, (i + 1) % n)).collect();
            assert_eq!(fill(n, &cycle, &order(n, &cycle)), n - 3, "{n}");
        }
    }

    /// A node that is adjacent to all others of a large graph is eliminated last.
    #[test]
    fn a_dense_node_comes_last() {
        let n = 1000;
        let edges: Vec<_> = (1..n).map(|i| (0, i)).chain((2..n).map(|i| (i - 1, i))).collect();
        assert_eq!(order(n, &edges).last(), Some(&0));
    }

    /// Grids of m × m nodes by nested dissection have about `7.75 m² log₂ m` entries in the factor (A. George, J. W. H.
    /// Liu, *Computer Solution of Large Sparse Positive Definite Systems*, 1981); minimum degree has fewer up to this size.
    #[test]
    fn grids_have_less_fill_than_by_nested_dissection() {
        for m in [16, 32, 64] {
            let n = m * m;
            let at = |i: usize, j: usize| i * m + j;
            let across = (0..m).flat_map(|i| (1..m).map(move |j| (at(i, j - 1), at(i, j))));
            let along = (1..m).flat_map(|i| (0..m).map(move |j| (at(i - 1, j), at(i, j))));
            let edges: Vec<_> = across.chain(along).collect();
            let entries = fill(n, &edges, &order(n, &edges)) + edges.len() + n;
            let dissection = 7.75 * n as f64 * (m as f64).log2();
            assert!((entries as f64) < dissection, "{m}: {entries} {dissection}");
        }
    }
}
