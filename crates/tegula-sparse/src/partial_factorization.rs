//! Partial factorisation of a front: elimination of its fully summed columns, block column by block column, and Schur
//! update of the contribution block.
//!
//! The block columns are halved recursively: the left half is eliminated, its Schur update is applied to the right
//! half, then the right half is eliminated. The Schur update is cut into tiles whose bounds depend on the sizes alone,
//! so the result is bitwise identical whether tiles run in sequence or in parallel. A diagonal block that is not
//! positive definite is factored [with rook pivoting](super::rook_pivoting) within itself; if it is singular, all
//! columns of the front from there on are eliminated at once, with pivots chosen among all of them. Columns that fail
//! the threshold test there, too, are [delayed](super::delayed_pivots).

use std::ops::Range;

use nalgebra::{DMatrix, DMatrixView, DMatrixViewMut};

use super::FactorError;
use super::delayed_pivots::{GROWTH, columns_without_pivots};
use super::dense::{DiagonalBlock, Part, Target, piece, piece_mut, subtract_product};
use super::rook_pivoting::BlockPivots;
use super::trapezoid::{BLOCK, Trapezoid};

/// Largest number of rows of a tile; taller tiles are cut in two.
const TILE: usize = 512;

/// Pivots of a front.
#[derive(Default)]
pub(super) struct FrontPivots {
    /// Pivots of the diagonal blocks that are not positive definite, ascending.
    pub blocks: Vec<PivotedBlocks>,
    /// Delayed columns: those that fail the threshold test. The front is not eliminated if there are any.
    pub delayed: Vec<u32>,
    /// Whether, in threshold pivoting, a column has no pivot in any later front either. This is not an error yet: the
    /// values above a front that was not eliminated are meaningless.
    pub singular: bool,
}

impl FrontPivots {
    /// Discards all pivots.
    pub fn clear(&mut self) {
        self.blocks.clear();
        self.delayed.clear();
        self.singular = false;
    }

    /// Whether the front is eliminated, without delayed columns.
    pub fn complete(&self) -> bool {
        self.delayed.is_empty() && !self.singular
    }

    /// Pivots of a block, if it is not positive definite.
    pub fn of(&self, block: usize) -> Option<&PivotedBlocks> {
        self.blocks.iter().find(|p| p.blocks.contains(&block))
    }
}

/// Consecutive diagonal blocks that are factored with common pivots.
pub(super) struct PivotedBlocks {
    pub blocks: Range<usize>,
    pub pivots: BlockPivots,
}

impl PivotedBlocks {
    /// Columns of the blocks in a front of `width` columns.
    pub fn columns(&self, width: usize) -> Range<usize> {
        self.blocks.start * BLOCK..(self.blocks.end * BLOCK).min(width)
    }
}

/// Reason why the elimination of blocks ended early.
enum Stop {
    /// The block with this number is singular and was left unchanged.
    Singular(usize),
    Failed(FactorError),
}

/// Runs `a` and `b`, in parallel if `parallel` is set.
pub(super) fn both<A: Send, B: Send>(
    parallel: bool,
    a: impl FnOnce() -> A + Send,
    b: impl FnOnce() -> B + Send,
) -> (A, B) {
    if parallel { rayon::join(a, b) } else { (a(), b()) }
}

/// Partial factorisation of one front.
pub(super) struct PartialFactorization<'a> {
    /// Layout of the fully summed columns.
    pub layout: Trapezoid,
    /// Pivots of the front.
    pub pivots: &'a mut FrontPivots,
    /// Workspace for a diagonal block.
    pub diagonal_block: &'a mut DiagonalBlock,
    /// Node-level parallelism: tiles run in parallel.
    pub parallel: bool,
    /// Equilibration scales of the rows. They switch on threshold pivoting: pivots are chosen among all fully summed
    /// columns, even if these are positive definite, and columns whose pivots would let entries grow beyond the scales
    /// are reported as delayed.
    pub scales: Option<Vec<f64>>,
    /// Whether the parent may eliminate delayed columns. The interface does not: its children accept all pivots that are
    /// larger than rounding, because the rows below them are those of the Schur complement, which may be large.
    pub may_delay: bool,
}

impl PartialFactorization<'_> {
    /// Eliminates the fully summed columns block by block: `L₁₁ L₁₁ᵀ = A₁₁`, `L₂₁ = A₂₁ L₁₁⁻ᵀ`.
    ///
    /// # Errors
    /// The columns are singular, or there is no memory for pivots.
    pub fn eliminate(&mut self, panel: &mut [f64]) -> Result<(), FactorError> {
        if self.scales.is_some() {
            return self.eliminate_with_pivoting(0, panel);
        }
        match self.blocks(0..self.layout.blocks(), panel) {
            Ok(()) => Ok(()),
            Err(Stop::Failed(error)) => Err(error),
            Err(Stop::Singular(block)) => self.eliminate_with_pivoting(block, panel),
        }
    }

    /// Schur update (contribution block) of this front, `out := −L₂₁ L₂₁ᵀ`; `out` is overwritten. The children's
    /// contribution blocks are added afterwards (extend-add).
    pub fn contribution(&self, panel: &[f64], out: &mut [f64]) {
        let to = Trapezoid::triangle(self.layout.rows - self.layout.columns);
        let from = Source { first: 0, blocks: 0..self.layout.blocks(), values: panel, overwrite: true };
        self.schur_update(&from, to, self.layout.columns, 0..to.blocks(), out);
    }

    fn blocks(&mut self, blocks: Range<usize>, values: &mut [f64]) -> Result<(), Stop> {
        if blocks.len() <= 1 {
            return if blocks.is_empty() { Ok(()) } else { self.block(blocks.start, values) };
        }
        let middle = blocks.start + blocks.len() / 2;
        let (left, right) = values.split_at_mut(self.layout.start(middle) - self.layout.start(blocks.start));
        let done = self.blocks(blocks.start..middle, left);
        let last = match done {
            Ok(()) => middle,
            Err(Stop::Singular(block)) => block,
            Err(Stop::Failed(_)) => return done,
        };
        let from = Source { first: blocks.start, blocks: blocks.start..last, values: left, overwrite: false };
        self.schur_update(&from, self.layout, 0, middle..blocks.end, right);
        done?;
        self.blocks(middle..blocks.end, right)
    }

    /// Eliminates all columns from a block on with rook pivoting among all of them. Earlier Schur updates are already
    /// applied.
    fn eliminate_with_pivoting(&mut self, first: usize, panel: &mut [f64]) -> Result<(), FactorError> {
        let layout = self.layout;
        let blocks = first..layout.blocks();
        let start = first * BLOCK;
        let (rows, columns) = (layout.rows - start, layout.columns - start);
        let mut matrix = self.matrix(first, panel);
        let (upper, lower) = matrix.rows_range_pair_mut(..columns, columns..);
        let mut pivots = BlockPivots::new(upper, lower);
        if let Some(scale) = &self.scales {
            let below = matrix.rows(columns, rows - columns);
            let stable = pivots.as_ref().is_ok_and(|p| {
                if self.may_delay {
                    p.growth(&below, &scale[columns..]) <= GROWTH
                } else {
                    p.exceed_rounding(scale)
                }
            });
            if !stable && pivots.as_ref().err() != Some(&FactorError::TooLarge) {
                if !self.may_delay {
                    self.pivots.singular = true;
                    return Ok(());
                }
                match columns_without_pivots(self.matrix(first, panel), scale) {
                    Ok(delayed) => self.pivots.delayed = delayed,
                    Err(error) => pivots = Err(error),
                }
                self.pivots.singular = self.pivots.delayed.is_empty() && pivots.is_err();
                if !self.pivots.complete() {
                    return Ok(());
                }
            }
        }
        let pivots = pivots?;
        for j in 0..columns {
            let at = layout.diagonal(start + j);
            panel[at..at + rows - j].copy_from_slice(piece(&matrix.as_view(), j..rows, j));
        }
        self.pivots.blocks.push(PivotedBlocks { blocks, pivots });
        Ok(())
    }

    /// Copy of the lower triangle of the columns from a block on.
    fn matrix(&self, first: usize, panel: &[f64]) -> DMatrix<f64> {
        let start = first * BLOCK;
        let (rows, columns) = (self.layout.rows - start, self.layout.columns - start);
        let mut matrix = DMatrix::zeros(rows, columns);
        for j in 0..columns {
            let at = self.layout.diagonal(start + j);
            piece_mut(&mut matrix.as_view_mut(), j..rows, j).copy_from_slice(&panel[at..at + rows - j]);
        }
        matrix
    }

    /// Eliminates one block column: Cholesky or rook pivoting of its diagonal block, triangular solve of the rows
    /// below.
    fn block(&mut self, block: usize, values: &mut [f64]) -> Result<(), Stop> {
        let width = self.layout.columns_of(block).len();
        let height = self.layout.rows - block * BLOCK;
        let mut matrix = DMatrixViewMut::from_slice(values, height, width);
        let (mut first, second) = matrix.rows_range_pair_mut(..width, width..);
        if self.diagonal_block.factor(first.as_view_mut()) {
            solve_rows(self.diagonal_block, second, self.parallel);
            return Ok(());
        }
        let kept = first.clone_owned();
        match BlockPivots::new(first.as_view_mut(), second) {
            Ok(pivots) => {
                self.pivots.blocks.push(PivotedBlocks { blocks: block..block + 1, pivots });
                Ok(())
            }
            // The rows below the block are unchanged.
            Err(FactorError::Singular) if block + 1 < self.layout.blocks() => {
                first.copy_from(&kept);
                Err(Stop::Singular(block))
            }
            Err(error) => Err(Stop::Failed(error)),
        }
    }

    /// Schur update of block columns of a trapezoid by eliminated blocks; its first column has the number `offset` in
    /// the front.
    fn schur_update(
        &self,
        from: &Source,
        to: Trapezoid,
        offset: usize,
        blocks: Range<usize>,
        values: &mut [f64],
    ) {
        if blocks.is_empty() {
            return;
        }
        if blocks.len() == 1 {
            let columns = to.columns_of(blocks.start);
            let rows = to.rows - columns.start;
            let tile = DMatrixViewMut::from_slice(values, rows, columns.len());
            let column = offset + columns.start;
            return self.tile(from, tile, column, column);
        }
        let middle = half(to, &blocks);
        let (left, right) = values.split_at_mut(to.start(middle) - to.start(blocks.start));
        both(
            self.parallel,
            || self.schur_update(from, to, offset, blocks.start..middle, left),
            || self.schur_update(from, to, offset, middle..blocks.end, right),
        );
    }

    /// Schur update (SYRK, GEMM) of a tile whose first entry has the numbers `row` and `column` in the front.
    fn tile(&self, from: &Source, mut tile: DMatrixViewMut<'_, f64>, row: usize, column: usize) {
        if tile.nrows() > TILE {
            let middle = tile.nrows() / 2;
            let (upper, lower) = tile.rows_range_pair_mut(..middle, middle..);
            both(
                self.parallel,
                || self.tile(from, upper, row, column),
                || self.tile(from, lower, row + middle, column),
            );
            return;
        }
        let (rows, width) = (tile.nrows(), tile.ncols());
        let part = if row == column { Part::Lower } else { Part::All };
        for block in from.blocks.clone() {
            let target =
                if from.overwrite && block == from.blocks.start { Target::Replace } else { Target::Add };
            let source = from.block(self.layout, block);
            let first = block * BLOCK;
            let left = source.rows(row - first, rows);
            let right = source.rows(column - first, width);
            let Some(pivoted) = self.pivots.of(block) else {
                subtract_product(tile.as_view_mut(), left, right, part, target);
                continue;
            };
            let start = pivoted.blocks.start * BLOCK;
            let columns = first - start..first - start + source.ncols();
            let scaled = pivoted.pivots.multiply(width, columns, |i, j| {
                let of = (start + j) / BLOCK;
                from.block(self.layout, of)[(column + i - of * BLOCK, start + j - of * BLOCK)]
            });
            subtract_product(tile.as_view_mut(), left, scaled.as_view(), part, target);
        }
    }
}

/// Eliminated block columns, the source of a Schur update.
struct Source<'a> {
    /// First block of `values`.
    first: usize,
    blocks: Range<usize>,
    values: &'a [f64],
    /// Whether the Schur update overwrites its target, which has no value yet.
    overwrite: bool,
}

impl Source<'_> {
    fn block(&self, layout: Trapezoid, block: usize) -> DMatrixView<'_, f64> {
        let start = layout.start(self.first);
        let values = &self.values[layout.start(block) - start..layout.start(block + 1) - start];
        let columns = layout.columns_of(block);
        DMatrixView::from_slice(values, layout.rows - columns.start, columns.len())
    }
}

/// Block column at which half of the entries of `blocks` are reached.
pub(super) fn half(layout: Trapezoid, blocks: &Range<usize>) -> usize {
    let (first, last) = (layout.start(blocks.start), layout.start(blocks.end));
    let middle = first + (last - first) / 2;
    (blocks.start + 1..blocks.end - 1).find(|&b| layout.start(b) >= middle).unwrap_or(blocks.end - 1)
}

/// Triangular solve (TRSM) `A₂₁ L₁₁⁻ᵀ` of the rows below a diagonal block, in tiles.
fn solve_rows(diagonal_block: &DiagonalBlock, mut rows: DMatrixViewMut<'_, f64>, parallel: bool) {
    if rows.nrows() > TILE {
        let middle = rows.nrows() / 2;
        let (upper, lower) = rows.rows_range_pair_mut(..middle, middle..);
        both(
            parallel,
            || solve_rows(diagonal_block, upper, parallel),
            || solve_rows(diagonal_block, lower, parallel),
        );
    } else {
        diagonal_block.solve_rows(rows);
    }
}
