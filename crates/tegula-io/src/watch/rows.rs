//! Rows of a history in bounded memory: each row at first, every second, fourth, … of a long one, and always the last.

/// Number of rows beyond which every second one is dropped.
const MOST_ROWS: usize = 4000;

/// Rows of equal length.
#[derive(Debug, Clone)]
pub(super) struct Rows {
    /// Values of a row.
    width: usize,
    /// Distance of the rows that are kept.
    stride: u64,
    /// Number of rows so far.
    count: u64,
    /// Values of the rows number 0, `stride`, 2 `stride`, …
    kept: Vec<f64>,
    /// Values of the last row.
    last: Vec<f64>,
}

impl Rows {
    /// No row yet.
    pub fn new(width: usize) -> Self {
        Self { width, stride: 1, count: 0, kept: Vec::new(), last: Vec::new() }
    }

    /// Number of rows so far, which those that were dropped count in.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// Appends rows, one behind the other.
    pub fn append(&mut self, values: &[f64]) {
        if self.width == 0 {
            return;
        }
        for row in values.chunks_exact(self.width) {
            if self.count.is_multiple_of(self.stride) {
                self.kept.extend_from_slice(row);
            }
            self.count += 1;
            if self.kept.len() > MOST_ROWS * self.width {
                self.thin_out();
            }
        }
        if let Some(row) = values.rchunks_exact(self.width).next() {
            self.last.clear();
            self.last.extend_from_slice(row);
        }
    }

    fn thin_out(&mut self) {
        let rows = self.kept.chunks_exact(self.width).step_by(2);
        self.kept = rows.flatten().copied().collect();
        self.stride *= 2;
    }

    /// Values of the rows that are kept behind the first `before` ones, and of the last one.
    pub fn behind(&self, before: u64) -> Vec<f64> {
        if before >= self.count {
            return Vec::new();
        }
        let first = usize::try_from(before.div_ceil(self.stride)).unwrap_or(usize::MAX);
        let mut out = self.kept.get(first.saturating_mul(self.width)..).unwrap_or_default().to_vec();
        if !(self.count - 1).is_multiple_of(self.stride) {
            out.extend_from_slice(&self.last);
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_histories_keep_evenly_spaced_rows_and_the_last_one() {
        let mut rows = Rows::new(2);
        let row = |i: usize| [i as f64, -(i as f64)];
        for i in 0..MOST_ROWS {
            rows.append(&row(i));
        }
        assert_eq!(rows.behind(0).len(), 2 * MOST_ROWS);
        assert_eq!(rows.behind(MOST_ROWS as u64 - 1), row(MOST_ROWS - 1));
        assert!(rows.behind(MOST_ROWS as u64).is_empty() && rows.behind(u64::MAX).is_empty());
        let all = 10 * MOST_ROWS + 4;
        rows.append(&(MOST_ROWS..all).flat_map(row).collect::<Vec<f64>>());
        assert_eq!(rows.count(), all as u64);
        let found: Vec<f64> = rows.behind(0).into_iter().step_by(2).collect();
        assert!(found.len() <= MOST_ROWS + 1 && found.len() > MOST_ROWS / 2);
        assert_eq!((found[0], found[1], found[found.len() - 1]), (0.0, 16.0, all as f64 - 1.0));
        assert_eq!(rows.behind(33)[..4], [48.0, -48.0, 64.0, -64.0]);
        assert_eq!(rows.behind(32)[..2], [32.0, -32.0]);
    }

    #[test]
    fn an_analysis_without_history_has_no_rows() {
        let mut rows = Rows::new(0);
        rows.append(&[]);
        assert_eq!((rows.count(), rows.behind(0)), (0, Vec::new()));
    }
}
