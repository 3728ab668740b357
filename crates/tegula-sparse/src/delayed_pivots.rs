//! Delayed pivots: fully summed columns that fail threshold pivoting in their front are eliminated in its parent.
//!
//! Saddle-point matrices need them: the multiplier of a constraint has a zero on the diagonal until an unknown of the
//! constraint is eliminated. The delayed columns are found from the values and then become part of the structure: they
//! are moved to the parent of their front, whose structure contains them already, and the matrix is factored once more.
//! Later matrices of the pattern, which mostly delay these columns, too, are factored in the new structure at once.
//!
//! I. S. Duff, J. K. Reid, *The multifrontal solution of indefinite sparse symmetric linear equations*, ACM Trans.
//! Math. Softw. 9 (1983) 302–325, delay columns in the course of one factorisation, whose structure is then never known
//! in advance.

use nalgebra::DMatrix;

use super::FactorError;
use super::assembly_tree::AssemblyTree;
use super::ordering::CompressedGraph;
use super::supernodes::{Supernode, postorder_minimizing_stack, without_empty};

/// Growth bound: largest change, over the scale of the row, that a pivot may cause on the diagonal of a row.
pub(super) const GROWTH: f64 = 1e3;

/// Bunch–Parlett constant: a 2×2 pivot is chosen where the largest diagonal entry is smaller than this multiple of the
/// largest off-diagonal entry. J. R. Bunch, B. N. Parlett, *Direct methods for solving symmetric indefinite systems of
/// linear equations*, SIAM J. Numer. Anal. 8 (1971) 639–655.
const ALPHA: f64 = 0.640_388_203_202_208_5;

/// Delayed columns of a front: those without a stable pivot among its fully summed columns, ascending. `matrix` is the
/// lower triangle of all fully summed columns that are to be eliminated, with all their rows; `scale` has the scale of
/// each row.
///
/// Complete pivoting chooses the pivots by size among all remaining entries, in units of the scales. Pivots that would
/// let an entry below grow beyond [`GROWTH`] are refused.
///
/// # Errors
/// Nothing is left of a column: no later front has a pivot for it either.
pub(super) fn columns_without_pivots(
    mut matrix: DMatrix<f64>,
    scale: &[f64],
) -> Result<Vec<u32>, FactorError> {
    let (rows, columns) = (matrix.nrows(), matrix.ncols());
    for j in 0..columns {
        for i in j..rows {
            matrix[(i, j)] /= scale[i] * scale[j];
        }
    }
    let entry = |m: &DMatrix<f64>, i: usize, j: usize| m[(i.max(j), i.min(j))];
    let mut left: Vec<usize> = (0..columns).collect();
    let mut delayed = Vec::new();
    while let Some(pivot) = largest(&matrix, &left) {
        let pivot: &[usize] = if pivot[0] == pivot[1] { &pivot[..1] } else { &pivot };
        left.retain(|k| !pivot.contains(k));
        // For each row that is not eliminated: its entries in the columns of the pivot, and its row of L.
        let others = || left.iter().chain(&delayed).copied().chain(columns..rows);
        let inverse = inverse(pivot, |i, j| entry(&matrix, i, j));
        let mut lower: Vec<(usize, [f64; 2], [f64; 2])> = Vec::with_capacity(rows);
        let (mut largest_l, mut largest_w) = ([0.0_f64; 2], [0.0_f64; 2]);
        for i in others() {
            let w = [entry(&matrix, i, pivot[0]), pivot.get(1).map_or(0.0, |&p| entry(&matrix, i, p))];
            let l = [0, 1].map(|k| inverse[k][0] * w[0] + inverse[k][1] * w[1]);
            for k in 0..2 {
                largest_l[k] = largest_l[k].max(l[k].abs());
                largest_w[k] = largest_w[k].max(w[k].abs());
            }
            lower.push((i, w, l));
        }
        let growth = largest_l[0] * largest_w[0] + largest_l[1] * largest_w[1];
        let finite = lower.iter().all(|(_, w, l)| w.iter().chain(l).all(|x| x.is_finite()));
        if !finite || growth > GROWTH {
            let own = entry(&matrix, pivot[0], pivot[0]).abs();
            if pivot.len() == 1 && own.max(largest_w[0]) <= f64::EPSILON {
                return Err(FactorError::Singular);
            }
            delayed.extend_from_slice(pivot);
            continue;
        }
        for &(j, w, _) in &lower {
            if j >= columns {
                break;
            }
            for &(i, _, l) in lower.iter().filter(|(i, ..)| *i >= j) {
                matrix[(i, j)] -= l[0] * w[0] + l[1] * w[1];
            }
        }
    }
    delayed.sort_unstable();
    Ok(delayed.into_iter().map(|j| j as u32).collect())
}

/// Columns of the next pivot, one column twice for a 1×1 pivot; none if no columns are left.
fn largest(matrix: &DMatrix<f64>, left: &[usize]) -> Option<[usize; 2]> {
    let (mut single, mut pair) = ((-1.0, [0, 0]), (-1.0, [0, 0]));
    for (k, &j) in left.iter().enumerate() {
        for &i in &left[k..] {
            let best = if i == j { &mut single } else { &mut pair };
            let size = matrix[(i.max(j), i.min(j))].abs();
            if size > best.0 {
                *best = (size, [j, i]);
            }
        }
    }
    if left.is_empty() {
        None
    } else if pair.0 > 0.0 && single.0 < ALPHA * pair.0 {
        Some(pair.1)
    } else if single.0 >= 0.0 {
        Some(single.1)
    } else {
        // All remaining entries are NaN.
        Some([left[0], left[0]])
    }
}

/// Inverse of a 1×1 or 2×2 pivot; not finite if it is singular.
fn inverse(pivot: &[usize], at: impl Fn(usize, usize) -> f64) -> [[f64; 2]; 2] {
    let a = at(pivot[0], pivot[0]);
    let Some(&second) = pivot.get(1) else { return [[1.0 / a, 0.0], [0.0, 0.0]] };
    let (b, c) = (at(second, pivot[0]), at(second, second));
    let determinant = (a / b) * (c / b) - 1.0;
    let [a, b, c] = [a / b, 1.0, c / b].map(|x| x / (determinant * b));
    [[c, -b], [-b, a]]
}

impl AssemblyTree {
    /// Assembly tree in which the `delayed` columns, numbered in elimination order, are eliminated in the parents of
    /// their fronts. `pointers` are the column pointers of the matrix.
    ///
    /// # Errors
    /// A root front has no pivot for one of the columns, so the matrix is singular; or the factor is too large.
    pub fn delay(&self, delayed: &[u32], pointers: &[usize]) -> Result<Self, FactorError> {
        let unknown = |place: u32| self.order[place as usize];
        let mut fronts: Vec<Supernode> = self
            .fronts
            .iter()
            .map(|front| Supernode {
                columns: self.order[front.first..front.first + front.width].to_vec(),
                rows: front.rows.iter().map(|&place| unknown(place)).collect(),
                parent: front.parent,
                ..Supernode::default()
            })
            .collect();
        for &place in delayed {
            let f = self.fronts.partition_point(|front| front.first + front.width <= place as usize);
            let parent = self.fronts[f].parent.ok_or(FactorError::Singular)?;
            let column = unknown(place);
            fronts[f].columns.retain(|&c| c != column);
            fronts[f].rows.push(column);
            // The column goes behind the columns of the parent, whose elimination may give it a pivot.
            fronts[parent as usize].columns.push(column);
        }
        // Fronts left without columns would only forward the contribution blocks of their children and are removed.
        let gone: Vec<bool> = fronts.iter().map(|front| front.columns.is_empty()).collect();
        for f in (0..fronts.len()).rev() {
            if let Some(parent) = fronts[f].parent.filter(|&p| gone[p as usize]) {
                fronts[f].parent = fronts[parent as usize].parent;
            }
        }
        let mut fronts = without_empty(fronts, &gone);
        for front in &mut fronts {
            (front.width, front.below) = (front.columns.len(), front.rows.len());
        }
        postorder_minimizing_stack(&mut fronts);
        let unknowns = pointers.len() - 1;
        let single = CompressedGraph {
            supervariables: (0..unknowns as u32).map(|i| vec![i]).collect(),
            neighbours: Vec::new(),
            interface: Vec::new(),
        };
        Self::number(&single, fronts, self.interface, pointers, &self.row_numbers(pointers))
    }

    /// Row number of each value of the matrix.
    fn row_numbers(&self, pointers: &[usize]) -> Vec<u32> {
        let mut rows = vec![0; pointers.last().copied().unwrap_or_default()];
        self.each_entry(|k, i, j| {
            // The column is the one in which the value is stored.
            rows[k] = if (pointers[j]..pointers[j + 1]).contains(&k) { i as u32 } else { j as u32 };
        });
        rows
    }
}
