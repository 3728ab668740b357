//! Mesh topology: quads that meet at an edge, and connected parts.

use super::Mesh;

/// One side of one quad, as a use of the edge between two nodes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct EdgeUse {
    /// The edge's smaller node.
    pub low: u32,
    /// The edge's larger node.
    pub high: u32,
    /// The quad.
    pub quad: u32,
    /// The quad's side: from its corner `side` to the next.
    pub side: u8,
    /// Whether the quad runs from `low` to `high`.
    pub forward: bool,
}

impl EdgeUse {
    /// The edge in the direction in which the quad runs through it.
    pub fn nodes(&self) -> [u32; 2] {
        if self.forward { [self.low, self.high] } else { [self.high, self.low] }
    }

    /// The quad's corner at one of the edge's nodes.
    pub fn corner_at(&self, node: u32) -> usize {
        let side = usize::from(self.side);
        if (node == self.low) == self.forward { side } else { (side + 1) % 4 }
    }
}

/// Sides of all quads, sorted so that those of one edge follow one another.
pub(super) struct Edges(Vec<EdgeUse>);

impl Edges {
    /// Edges of `quads`, sorted by node and quad; sides of no length (a node repeated in a quad) are left out.
    pub fn of(quads: &[[u32; 4]]) -> Self {
        let mut uses = Vec::with_capacity(4 * quads.len());
        for (number, quad) in (0u32..).zip(quads) {
            for side in 0..4u8 {
                let (a, b) = (quad[usize::from(side)], quad[usize::from((side + 1) % 4)]);
                if a != b {
                    uses.push(EdgeUse { low: a.min(b), high: a.max(b), quad: number, side, forward: a < b });
                }
            }
        }
        uses.sort_unstable();
        Self(uses)
    }

    /// Uses of each edge, edge by edge: one on the boundary, two inside a sheet,
    /// three or more where sheets join.
    pub fn iter(&self) -> impl Iterator<Item = &[EdgeUse]> {
        self.0.chunk_by(|a, b| a.low == b.low && a.high == b.high)
    }

    /// Pairs of neighbours that run through their common edge in the same
    /// direction, so that one has its director on the other side: the pair's
    /// uses of that edge. Junctions of three or more quads may be oriented
    /// freely; a quad given twice is no neighbour of its own.
    pub fn opposite_neighbours(&self, quads: &[[u32; 4]]) -> Vec<[EdgeUse; 2]> {
        let sorted = |edge: &EdgeUse| {
            quads.get(edge.quad as usize).map(|quad| {
                let mut nodes = *quad;
                nodes.sort_unstable();
                nodes
            })
        };
        self.iter()
            .filter_map(|uses| match uses {
                [a, b] if a.forward == b.forward && sorted(a) != sorted(b) => Some([*a, *b]),
                _ => None,
            })
            .collect()
    }
}

/// Disjoint sets of numbers (union–find with path halving); the smallest number represents its set.
pub(super) struct Disjoint(Vec<u32>);

impl Disjoint {
    /// Sets of one number each.
    pub fn new(count: usize) -> Self {
        Self((0u32..).take(count).collect())
    }

    /// Number that represents the set of another.
    pub fn root(&mut self, number: usize) -> usize {
        let parents = &mut self.0;
        let mut number = number;
        while parents[number] as usize != number {
            parents[number] = parents[parents[number] as usize];
            number = parents[number] as usize;
        }
        number
    }

    /// Unites the sets of two numbers.
    pub fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.root(a), self.root(b));
        self.0[a.max(b)] = a.min(b) as u32;
    }
}

impl Mesh {
    /// Number of the connected part that each node belongs to, in the order of their first nodes; `u32::MAX` for nodes
    /// without quads.
    pub fn parts(&self) -> Vec<u32> {
        let nodes = self.positions.len();
        let mut joined = Disjoint::new(nodes);
        let mut number = vec![u32::MAX; nodes];
        let mut used = vec![false; nodes];
        for quad in &self.quads {
            for &n in quad {
                used[n as usize] = true;
                joined.join(quad[0] as usize, n as usize);
            }
        }
        let mut count = 0;
        for n in (0..nodes).filter(|&n| used[n]) {
            // The root has the smallest number of its part: it comes first.
            let root = joined.root(n);
            if root == n {
                number[n] = count;
                count += 1;
            } else {
                number[n] = number[root];
            }
        }
        number
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_quads_share_one_edge() {
        //  3---4---5
        //  | 0 | 1 |
        //  0---1---2
        let quads = [[0, 1, 4, 3], [1, 2, 5, 4]];
        let edges = Edges::of(&quads);
        let shared: Vec<_> = edges.iter().filter(|uses| uses.len() == 2).collect();
        assert_eq!(shared.len(), 1);
        assert_eq!(edges.iter().count(), 7);
        let [a, b] = [shared[0][0], shared[0][1]];
        assert_eq!((a.nodes(), b.nodes()), ([1, 4], [4, 1]));
        for edge in [a, b] {
            for node in [1, 4] {
                assert_eq!(quads[edge.quad as usize][edge.corner_at(node)], node);
            }
        }
        assert!(edges.opposite_neighbours(&quads).is_empty());
        let flipped = [[0, 1, 4, 3], [1, 4, 5, 2]];
        assert_eq!(Edges::of(&flipped).opposite_neighbours(&flipped).len(), 1);
        let twice = [[0, 1, 4, 3], [0, 1, 4, 3]];
        assert!(Edges::of(&twice).opposite_neighbours(&twice).is_empty());
    }
}
