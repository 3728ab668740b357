//! Sparse matrices for `scipy.sparse`: compressed columns and rows.

use numpy::{IntoPyArray, PyArray1};
use pyo3::prelude::*;
use tegula_sparse::SymmetricPattern;

/// Pointers, numbers and values of a matrix in compressed columns or rows. Pointers and numbers have 32 bits where these suffice, as SciPy
/// wants them: else it would copy them.
pub type Arrays<'py> = (Bound<'py, PyAny>, Bound<'py, PyAny>, Bound<'py, PyArray1<f64>>);

/// Sparse matrix in compressed columns, or in compressed rows.
#[derive(Debug, Default, PartialEq)]
pub struct Compressed {
    /// Ends of the columns (rows) among the entries; the first one is 0.
    pointers: Vec<usize>,
    /// Row (column) of each entry.
    numbers: Vec<u32>,
    /// Values of the entries.
    pub values: Vec<f64>,
}

impl Compressed {
    /// Matrix without columns (rows).
    pub fn new() -> Self {
        Self { pointers: vec![0], ..Self::default() }
    }

    /// Adds an entry to the last column (row).
    pub fn push(&mut self, number: u32, value: f64) {
        self.numbers.push(number);
        self.values.push(value);
    }

    /// Ends the last column (row).
    pub fn end(&mut self) {
        self.pointers.push(self.numbers.len());
    }

    /// Whole symmetric matrix of its lower triangle, whose columns begin with their diagonal: rows ascend in each column.
    pub fn symmetric(pattern: &SymmetricPattern, lower: &[f64]) -> Self {
        let (starts, rows) = pattern.columns();
        let n = pattern.size();
        let mut pointers = vec![0; n + 1];
        let columns = || (0..n).map(|j| (j, starts[j]..starts[j + 1]));
        for (j, entries) in columns() {
            pointers[j + 1] += entries.len();
            rows[entries].iter().skip(1).for_each(|&i| pointers[i as usize + 1] += 1);
        }
        (0..n).for_each(|j| pointers[j + 1] += pointers[j]);
        let (mut numbers, mut values) = (vec![0; pointers[n]], vec![0.0; pointers[n]]);
        let mut next = pointers[..n].to_vec();
        let mut put = |column: usize, row: u32, value: f64| {
            let at = next[column];
            (numbers[at], values[at]) = (row, value);
            next[column] += 1;
        };
        // All entries above the diagonal of a column are those of columns before it.
        for (j, entries) in columns() {
            for (&i, &value) in rows[entries.clone()].iter().zip(&lower[entries]) {
                put(j, i, value);
                if i as usize != j {
                    put(i as usize, j as u32, value);
                }
            }
        }
        Self { pointers, numbers, values }
    }

    /// Arrays of NumPy, which own the values.
    pub fn into_arrays(self, py: Python<'_>) -> Arrays<'_> {
        let Self { pointers, numbers, values } = self;
        let (pointers, numbers) = if i32::try_from(numbers.len().max(pointers.len())).is_ok() {
            (integers(py, pointers, |p| p as i32), integers(py, numbers, |r| r as i32))
        } else {
            (integers(py, pointers, |p| p as i64), integers(py, numbers, i64::from))
        };
        (pointers, numbers, values.into_pyarray(py))
    }
}

/// Array of integers; where both types have the same size the conversion reuses the memory of the list.
fn integers<'py, T, I: numpy::Element>(
    py: Python<'py>,
    values: Vec<T>,
    integer: impl Fn(T) -> I,
) -> Bound<'py, PyAny> {
    values.into_iter().map(integer).collect::<Vec<_>>().into_pyarray(py).into_any()
}
