//! Symbolic analysis for the multifrontal method: fronts, what they hold, and the tree in which they are assembled.
//!
//! J. W. H. Liu, *The multifrontal method for sparse matrix solution*, SIAM Review 34 (1992) 82–109. Columns of
//! equal structure are one front; small fronts are joined with their parents where that adds few zeros.

use super::FactorError;
use super::entry_map::{EntryMap, FrontNumbering};
use super::ordering::CompressedGraph;
use super::supernodes::{Supernode, amalgamate, fundamental_supernodes, postorder_minimizing_stack};
use super::trapezoid::Trapezoid;

/// A front: a dense symmetric matrix of columns that are eliminated in it and of rows that it passes on.
#[derive(Debug, Clone, Default)]
pub(super) struct Front {
    /// First of the columns that are eliminated in it, in the order of elimination.
    pub first: usize,
    /// Number of columns.
    pub width: usize,
    /// Rows below them: numbers of later columns, ascending.
    pub rows: Vec<u32>,
    /// The front that takes what is passed on; none: nothing is.
    pub parent: Option<u32>,
    /// Where the rows lie in the parent: runs (first row here, first place there, length). Places count the parent's
    /// columns first, then its rows.
    pub relative_indices: Vec<[u32; 3]>,
    /// First front of its subtree; the fronts of a subtree are numbered one after another, itself last.
    pub leaf: usize,
    /// Where its panel begins in the factor.
    pub panel: usize,
    /// Where its rows begin in vectors of all rows.
    pub row_start: usize,
    /// Operations of its subtree.
    pub flops: f64,
}

impl Front {
    /// Order of the dense matrix.
    pub fn height(&self) -> usize {
        self.width + self.rows.len()
    }

    /// Its columns, as they are stored in the factor.
    pub fn layout(&self) -> Trapezoid {
        Trapezoid { rows: self.height(), columns: self.width }
    }

    /// What it passes on.
    pub fn contribution(&self) -> Trapezoid {
        Trapezoid::triangle(self.rows.len())
    }
}

/// Fronts in the order of elimination, and where the entries of the matrix go.
#[derive(Debug, Default)]
pub(super) struct AssemblyTree {
    pub fronts: Vec<Front>,
    /// Children of each front, ascending.
    pub children: Vec<Vec<u32>>,
    /// Unknown eliminated at each place.
    pub order: Vec<u32>,
    /// Entries of the matrix by front.
    pub entries: EntryMap,
    /// Entries of the factor.
    pub size: usize,
    /// Rows of all fronts together.
    pub rows: usize,
}

impl AssemblyTree {
    /// Analyses a lower triangle in compressed columns for an order of its groups.
    ///
    /// # Errors
    /// The factor is too large to be indexed.
    pub fn new(
        graph: &CompressedGraph,
        order: &[u32],
        pointers: &[usize],
        rows: &[u32],
    ) -> Result<Self, FactorError> {
        let mut fronts = amalgamate(fundamental_supernodes(graph, order));
        postorder_minimizing_stack(&mut fronts);
        Self::number(graph, fronts, pointers, rows)
    }

    /// Operations of a factorisation.
    pub fn operations(&self) -> f64 {
        self.fronts.iter().filter(|f| f.parent.is_none()).map(|f| f.flops).sum()
    }

    /// Entries that the children of a front pass on.
    pub fn contributions_of_children(&self, f: usize) -> usize {
        self.children[f].iter().map(|&c| self.fronts[c as usize].contribution().size()).sum()
    }

    /// Calls `f` with the number of each value of the matrix, its row and its column; which is which does not matter.
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

    /// Numbers the columns in the order of the fronts, and finds where everything goes.
    pub fn number(
        graph: &CompressedGraph,
        supernodes: Vec<Supernode>,
        pointers: &[usize],
        rows: &[u32],
    ) -> Result<Self, FactorError> {
        let n = pointers.len() - 1;
        let mut tree = Self { order: Vec::with_capacity(n), ..Self::default() };
        // Columns of the groups, in the order of the fronts.
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
            let front = &mut tree.fronts[f];
            let (w, m) = (front.width as f64, front.rows.len() as f64);
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

/// Runs of consecutive rows that are consecutive in the parent, too.
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
        // A run lies in the columns or in the rows, not in both.
        match out.last_mut() {
            Some([_, at, length]) if *at + *length == there && there != parent.width as u32 => *length += 1,
            _ => out.push([here, there, 1]),
        }
    }
    out
}
