//! Symbolic factorisation for the multifrontal method: the fronts, their structure and the assembly tree.
//!
//! J. W. H. Liu, *The multifrontal method for sparse matrix solution*, SIAM Review 34 (1992) 82–109. Columns of equal
//! structure are one supernode and share a front; relaxed amalgamation merges small supernodes with their parents where
//! that adds few explicit zeros.

use super::FactorError;
use super::entry_map::{EntryMap, FrontNumbering};
use super::ordering::CompressedGraph;
use super::supernodes::{Supernode, amalgamate, fundamental_supernodes, postorder_minimizing_stack};
use super::trapezoid::Trapezoid;

/// Front (frontal matrix): dense symmetric matrix of the fully summed columns that are eliminated in it and of the rows
/// of its contribution block.
#[derive(Debug, Clone, Default)]
pub(super) struct Front {
    /// First fully summed column, in elimination order.
    pub first: usize,
    /// Number of fully summed columns.
    pub width: usize,
    /// Rows below the fully summed columns: elimination positions of later columns, ascending.
    pub rows: Vec<u32>,
    /// Parent in the assembly tree, which assembles the contribution block; none for a root.
    pub parent: Option<u32>,
    /// Relative indices: positions of the rows in the parent's front, as runs (first row here, first index there,
    /// length). Indices count the parent's fully summed columns first, then its rows.
    pub relative_indices: Vec<[u32; 3]>,
    /// First front of its subtree; the fronts of a subtree are numbered consecutively, its root last.
    pub leaf: usize,
    /// Start of the front's panel (its columns of L) in the factor.
    pub panel: usize,
    /// Start of its rows in vectors over the rows of all fronts.
    pub row_start: usize,
    /// Number of floating-point operations of its subtree.
    pub flops: f64,
}

impl Front {
    /// Order of the frontal matrix.
    pub fn height(&self) -> usize {
        self.width + self.rows.len()
    }

    /// Layout of the panel: the fully summed columns as they are stored in the factor.
    pub fn layout(&self) -> Trapezoid {
        Trapezoid { rows: self.height(), columns: self.width }
    }

    /// Layout of the contribution block.
    pub fn contribution(&self) -> Trapezoid {
        Trapezoid::triangle(self.rows.len())
    }
}

/// Assembly tree: the fronts in elimination order, and the entry-to-front map of the original entries.
#[derive(Debug, Default)]
pub(super) struct AssemblyTree {
    pub fronts: Vec<Front>,
    /// Children of each front, ascending.
    pub children: Vec<Vec<u32>>,
    /// Unknown eliminated at each position of the elimination order.
    pub order: Vec<u32>,
    /// Entry-to-front map of the original entries.
    pub entries: EntryMap,
    /// Number of entries of the factor.
    pub size: usize,
    /// Number of rows of all fronts together.
    pub rows: usize,
    /// Number of unknowns of the interface. If there are any, they are the columns of the last front, which is assembled
    /// and not eliminated: its panel holds the Schur complement of the interior.
    pub interface: usize,
}

impl AssemblyTree {
    /// Symbolic factorisation of a lower triangle in compressed columns, for an elimination order of its
    /// supervariables.
    ///
    /// # Errors
    /// The factor is too large to be indexed.
    pub fn new(
        graph: &CompressedGraph,
        order: &[u32],
        pointers: &[usize],
        rows: &[u32],
    ) -> Result<Self, FactorError> {
        let has_interface = !graph.interface.is_empty();
        let mut fronts = amalgamate(fundamental_supernodes(graph, order), has_interface);
        postorder_minimizing_stack(&mut fronts);
        let interface = if has_interface { fronts.last().map_or(0, |front| front.width) } else { 0 };
        Self::number(graph, fronts, interface, pointers, rows)
    }

    /// Whether a front is that of the interface, which is not eliminated.
    pub fn is_interface(&self, f: usize) -> bool {
        self.interface > 0 && f + 1 == self.fronts.len()
    }

    /// Whether the interface is the parent of a front, so that no later front can eliminate a delayed column.
    pub fn is_below_interface(&self, f: usize) -> bool {
        self.fronts[f].parent.is_some_and(|p| self.is_interface(p as usize))
    }

    /// Number of unknowns that are eliminated.
    pub fn eliminated(&self) -> usize {
        self.order.len() - self.interface
    }

    /// Number of floating-point operations of a factorisation.
    pub fn operations(&self) -> f64 {
        self.fronts.iter().filter(|f| f.parent.is_none()).map(|f| f.flops).sum()
    }

    /// Number of entries of the contribution blocks of a front's children.
    pub fn contributions_of_children(&self, f: usize) -> usize {
        self.children[f].iter().map(|&c| self.fronts[c as usize].contribution().size()).sum()
    }

    /// Calls `f` with the index of each value of the matrix and its two unknowns; which is the row and which is the
    /// column is arbitrary.
    pub fn each_entry(&self, mut f: impl FnMut(usize, usize, usize)) {
        for (number, front) in self.fronts.iter().enumerate() {
            let layout = front.layout();
            let unknown = |local: usize| {
                let below = local.checked_sub(front.width);
                let place = below.map_or(front.first + local, |b| front.rows[b] as usize);
                self.order[place] as usize
            };
            self.entries.each(number, |value, at| {
                let (row, column) = layout.place(at);
                f(value, unknown(row), unknown(column));
            });
        }
    }

    /// Numbers the columns in the order of the supernodes and computes the fronts, their relative indices and the
    /// entry-to-front map. `interface` is the number of unknowns of the interface, the columns of the last supernode.
    pub fn number(
        graph: &CompressedGraph,
        supernodes: Vec<Supernode>,
        interface: usize,
        pointers: &[usize],
        rows: &[u32],
    ) -> Result<Self, FactorError> {
        let n = pointers.len() - 1;
        let mut tree = Self { order: Vec::with_capacity(n), interface, ..Self::default() };
        // Columns of the supervariables, in the order of the fronts.
        let mut first_column = vec![0_u32; graph.len()];
        for supernode in &supernodes {
            for &g in &supernode.columns {
                first_column[g as usize] = tree.order.len() as u32;
                tree.order.extend_from_slice(&graph.supervariables[g as usize]);
            }
        }
        let mut place = vec![0_u32; n];
        let mut front_of = vec![0_u32; n];
        for (new, &old) in tree.order.iter().enumerate() {
            place[old as usize] = new as u32;
        }
        let mut first = 0;
        for (f, supernode) in supernodes.iter().enumerate() {
            let width: usize =
                supernode.columns.iter().map(|&g| graph.supervariables[g as usize].len()).sum();
            front_of[first..first + width].fill(f as u32);
            let mut below: Vec<u32> = Vec::new();
            for &g in &supernode.rows {
                let start = first_column[g as usize];
                below.extend(start..start + graph.supervariables[g as usize].len() as u32);
            }
            below.sort_unstable();
            below.shrink_to_fit();
            tree.fronts.push(Front {
                first,
                width,
                rows: below,
                parent: supernode.parent,
                ..Front::default()
            });
            first += width;
        }
        tree.children = vec![Vec::new(); tree.fronts.len()];
        for f in 0..tree.fronts.len() {
            if let Some(p) = tree.fronts[f].parent {
                tree.children[p as usize].push(f as u32);
                tree.fronts[f].relative_indices =
                    relative_indices(&tree.fronts[f].rows, &tree.fronts[p as usize]);
            }
        }
        for f in 0..tree.fronts.len() {
            let below: f64 = tree.children[f].iter().map(|&c| tree.fronts[c as usize].flops).sum();
            let leaf = tree.children[f].first().map_or(f, |&c| tree.fronts[c as usize].leaf);
            let eliminated = !tree.is_interface(f);
            let front = &mut tree.fronts[f];
            let (w, m) = (if eliminated { front.width as f64 } else { 0.0 }, front.rows.len() as f64);
            front.flops = below + w * w * w / 3.0 + w * w * m + w * m * m;
            front.leaf = leaf;
            (front.panel, front.row_start) = (tree.size, tree.rows);
            let rectangle = front.height().checked_mul(front.height());
            if rectangle.is_none_or(|s| s > isize::MAX as usize / 8) {
                return Err(FactorError::TooLarge);
            }
            tree.size = front
                .layout()
                .size()
                .checked_add(tree.size)
                .filter(|s| *s < isize::MAX as usize / 8)
                .ok_or(FactorError::TooLarge)?;
            tree.rows += front.rows.len();
        }
        let numbering =
            FrontNumbering { fronts: &tree.fronts, place: &place, front_of: &front_of, pointers, rows };
        tree.entries = EntryMap::new(&numbering)?;
        Ok(tree)
    }
}

/// Relative indices of `rows` in the parent's front: runs of consecutive rows that are consecutive there, too.
fn relative_indices(rows: &[u32], parent: &Front) -> Vec<[u32; 3]> {
    let end = (parent.first + parent.width) as u32;
    let mut out: Vec<[u32; 3]> = Vec::new();
    let mut below = 0;
    for (here, &row) in (0_u32..).zip(rows) {
        let there = if row < end {
            row - parent.first as u32
        } else {
            while parent.rows[below] != row {
                below += 1;
            }
            (parent.width + below) as u32
        };
        // A run lies either in the parent's fully summed columns or in its rows, not in both.
        match out.last_mut() {
            Some([_, at, length]) if *at + *length == there && there != parent.width as u32 => *length += 1,
            _ => out.push([here, there, 1]),
        }
    }
    out
}
