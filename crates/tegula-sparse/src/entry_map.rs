//! Entry-to-front map: places of the original entries of the matrix in the panels of the fronts.
//!
//! The unknowns of a node have the same neighbours, so consecutive columns of the matrix mostly have the same rows, and
//! their entries are adjacent in a panel. A run holds such a block of entries: several columns at equal distances in
//! the panel. The matrix has far more columns than such blocks.

use super::FactorError;
use super::assembly_tree::Front;
use super::trapezoid::BLOCK;

/// Exclusive upper bound of the strides in a panel, so that a stride and a length fit one 32-bit number.
const MOST_STEP: usize = 1 << 24;

/// Arrangement of the entries of a run in a panel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
enum Shape {
    /// Columns of the matrix are columns of the panel; the entries of a column are adjacent.
    Columns,
    /// Columns of the matrix are columns of the panel, from the diagonal on: each column begins one row further down
    /// and has one entry less than the one before.
    DiagonalBlock,
    /// Columns of the matrix are rows of the panel, or there is only one column.
    Rows,
}

/// Run of original entries: entries of consecutive columns of the matrix at equal distances in a panel.
#[derive(Debug, Clone, Copy)]
struct EntryRun {
    /// Index of the first value of the first column.
    value: u32,
    /// Place of the first value in the panel.
    at: u32,
    /// Stride in the panel times 256, plus the number of entries of the first column. The stride of [`Shape::Rows`] is
    /// the distance between the entries of a column, otherwise it is the distance between columns.
    step_and_length: u32,
    /// Distance of the values from the first column to the second; it decreases by one from each column to the next.
    next: u16,
    columns: u8,
    shape: Shape,
}

impl EntryRun {
    /// Number of entries of the first column.
    fn length(self) -> u32 {
        self.step_and_length & 255
    }

    /// Strides in the panel: between the entries of a column, and between columns.
    #[inline]
    fn steps(self) -> (usize, usize) {
        let step = (self.step_and_length >> 8) as usize;
        if self.shape == Shape::Rows { (step, 1) } else { (1, step) }
    }

    /// Segment of each column: index of its first value, place of that value in the panel, number of entries.
    #[inline]
    fn pieces(self) -> impl Iterator<Item = (usize, usize, usize)> {
        let (mut value, mut at) = (self.value as usize, self.at as usize);
        let (length, next, stride) = (self.length() as usize, self.next as usize, self.steps().1);
        let less = usize::from(self.shape == Shape::DiagonalBlock);
        (0..self.columns as usize).map(move |q| {
            let piece = (value, at, length - q * less);
            value += next - q;
            at += stride;
            piece
        })
    }

    /// Number of entries of the run.
    fn entries(self) -> usize {
        self.pieces().map(|(_, _, length)| length).sum()
    }

    /// Adds the entries to a panel. `values` returns the values of a column, given the index of the first and their
    /// number.
    #[inline]
    fn add<'a>(self, mut values: impl FnMut(usize, usize) -> &'a [f64], panel: &mut [f64]) {
        let (step, _) = self.steps();
        if step == 1 {
            for (first, at, length) in self.pieces() {
                for (to, value) in panel[at..][..length].iter_mut().zip(values(first, length)) {
                    *to += value;
                }
            }
        } else {
            for (first, mut at, length) in self.pieces() {
                for value in values(first, length) {
                    panel[at] += value;
                    at += step;
                }
            }
        }
    }

    /// Extends the run by the next entry of the first column, at place `at` of the panel, if it fits; returns whether
    /// it does.
    fn take(&mut self, at: u32, shape: Shape) -> bool {
        let length = self.length();
        let rows = self.shape == Shape::Rows;
        if length == 255 || rows != (shape == Shape::Rows) || at <= self.at {
            return false;
        }
        let distance = (at - self.at) as usize;
        let step = if rows && length == 1 { distance } else { self.steps().0 };
        let fits = step < MOST_STEP && distance == step * length as usize;
        if fits {
            let stored = if rows { step as u32 } else { self.step_and_length >> 8 };
            self.step_and_length = (stored << 8) | (length + 1);
        }
        fits
    }
}

/// Entry-to-front map: runs of original entries, sorted by front.
#[derive(Debug, Default)]
pub(super) struct EntryMap {
    runs: Vec<EntryRun>,
    /// First run of each front, then the number of runs.
    starts: Vec<u32>,
}

impl EntryMap {
    /// Maps each original entry of the matrix to its place in a front.
    ///
    /// # Errors
    /// A front is too large to be indexed.
    pub fn new(numbering: &FrontNumbering) -> Result<Self, FactorError> {
        let mut starts = vec![0_u32; numbering.fronts.len() + 1];
        // Runs in matrix order, with the front of each, which is later replaced by the run's position in front order.
        let (mut runs, mut places): (Vec<EntryRun>, Vec<u32>) = (Vec::new(), Vec::new());
        let mut j = 0;
        while j < numbering.place.len() {
            let columns = numbering.alike(j);
            numbering.each_run(j, columns, |front, run| {
                starts[front + 1] += 1;
                places.push(front as u32);
                runs.push(run);
            })?;
            j += columns as usize;
        }
        for f in 1..starts.len() {
            starts[f] += starts[f - 1];
        }
        let mut next = starts.clone();
        for place in &mut places {
            let next = &mut next[*place as usize];
            *place = *next;
            *next += 1;
        }
        // Sorting in place keeps only one copy of the runs in memory.
        for k in 0..runs.len() {
            while places[k] as usize != k {
                let to = places[k] as usize;
                runs.swap(k, to);
                places.swap(k, to);
            }
        }
        runs.shrink_to_fit();
        Ok(Self { runs, starts })
    }

    fn of(&self, f: usize) -> &[EntryRun] {
        &self.runs[self.starts[f] as usize..self.starts[f + 1] as usize]
    }

    /// Adds the original entries of a front to its panel.
    pub fn add_entries(&self, f: usize, values: &[f64], panel: &mut [f64]) {
        for run in self.of(f) {
            run.add(|first, length| &values[first..][..length], panel);
        }
    }

    /// Number of original entries in a front.
    pub fn number(&self, f: usize) -> usize {
        self.of(f).iter().map(|run| run.entries()).sum()
    }

    /// Copies the original entries of a front to `out`, in the order of its runs.
    pub fn collect(&self, f: usize, values: &[f64], mut out: &mut [f64]) {
        for (value, _, length) in self.of(f).iter().flat_map(|run| run.pieces()) {
            out.split_off_mut(..length).unwrap_or_default().copy_from_slice(&values[value..][..length]);
        }
    }

    /// Adds the original entries of a front to its panel, as [`add_entries`](Self::add_entries) does, from the copy
    /// made by [`collect`](Self::collect).
    pub fn add_collected(&self, f: usize, mut collected: &[f64], panel: &mut [f64]) {
        for run in self.of(f) {
            let next = |_, length| collected.split_off(..length).unwrap_or_default();
            run.add(next, panel);
        }
    }

    /// Calls `take` with the index of each original entry of a front and its place in the panel.
    pub fn each(&self, f: usize, mut take: impl FnMut(usize, usize)) {
        for run in self.of(f) {
            let (step, _) = run.steps();
            for (value, at, length) in run.pieces() {
                (0..length).for_each(|k| take(value + k, at + k * step));
            }
        }
    }
}

/// Lower triangle of a matrix in compressed columns, and the fronts in which its unknowns are eliminated.
pub(super) struct FrontNumbering<'a> {
    pub fronts: &'a [Front],
    /// Position of each unknown in the elimination order.
    pub place: &'a [u32],
    /// Front of each position of the elimination order.
    pub front_of: &'a [u32],
    pub pointers: &'a [usize],
    pub rows: &'a [u32],
}

impl FrontNumbering<'_> {
    fn column(&self, j: usize) -> &[u32] {
        &self.rows[self.pointers[j]..self.pointers[j + 1]]
    }

    /// Number of columns from `j` on that have the same rows below them and are consecutive in one block column of a
    /// panel.
    fn alike(&self, j: usize) -> u8 {
        let rows = self.column(j);
        let place = self.place[j];
        let front = &self.fronts[self.front_of[place as usize] as usize];
        if rows.len() > usize::from(u16::MAX) || front.height() + 1 >= MOST_STEP {
            return 1;
        }
        let column = place as usize - front.first;
        let end = ((column / BLOCK + 1) * BLOCK).min(front.width);
        let most = (end - column).min(rows.len()).min(usize::from(u8::MAX)) as u8;
        let differs = |q: &u8| {
            let (q, next) = (usize::from(*q), place + u32::from(*q));
            rows[q] as usize != j + q || self.place[j + q] != next || *self.column(j + q) != rows[q..]
        };
        (1..most).find(differs).unwrap_or(most.max(1))
    }

    /// Calls `take` with the front and each run of the entries of `columns` columns of equal rows, beginning with
    /// column `j`.
    fn each_run(
        &self,
        j: usize,
        columns: u8,
        mut take: impl FnMut(usize, EntryRun),
    ) -> Result<(), FactorError> {
        let first = self.pointers[j];
        let rows = self.column(j);
        let mut run: Option<(usize, EntryRun)> = None;
        let mut below = 0;
        for (k, &i) in (first..).zip(rows) {
            let (a, b) = (self.place[i as usize], self.place[j]);
            let (column, row) = (a.min(b) as usize, a.max(b));
            let f = self.front_of[column] as usize;
            let front = &self.fronts[f];
            let column = column - front.first;
            let shape = if columns == 1 || a < b {
                Shape::Rows
            } else if k == first {
                Shape::DiagonalBlock
            } else {
                Shape::Columns
            };
            let local = if (row as usize) < front.first + front.width {
                row as usize - front.first
            } else {
                // The row is mostly the one after the last, or the last one again in another column of the panel.
                if front.rows.get(below) != Some(&row) {
                    below = front.rows.binary_search(&row).map_err(|_| FactorError::TooLarge)?;
                }
                // Rows of the panel that correspond to columns of equal rows are consecutive.
                let more = if shape == Shape::Rows { u32::from(columns - 1) } else { 0 };
                if front.rows.get(below + more as usize) != Some(&(row + more)) {
                    return Err(FactorError::TooLarge);
                }
                let local = front.width + below;
                below += usize::from(a > b);
                local
            };
            let layout = front.layout();
            let at =
                u32::try_from(layout.diagonal(column) + local - column).map_err(|_| FactorError::TooLarge)?;
            if let Some((of, run)) = &mut run
                && *of == f
                && run.take(at, shape)
            {
                continue;
            }
            let value = u32::try_from(k).map_err(|_| FactorError::TooLarge)?;
            let height = (layout.rows - column / BLOCK * BLOCK) as u32;
            // Stride of the columns and distance of their values; columns on the diagonal go one row further down. Both
            // fit their types where there are several columns.
            let (step, next) = match shape {
                Shape::DiagonalBlock => (height + 1, rows.len()),
                Shape::Columns => (height, rows.len() - 1),
                Shape::Rows => (0, rows.len() - 1),
            };
            let new =
                EntryRun { value, at, step_and_length: (step << 8) | 1, next: next as u16, columns, shape };
            if let Some((f, done)) = run.replace((f, new)) {
                take(f, done);
            }
        }
        if let Some((f, done)) = run {
            take(f, done);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
