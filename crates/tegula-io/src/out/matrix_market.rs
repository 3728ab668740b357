//! Matrices in the format Matrix Market (R. F. Boisvert, R. Pozo, K. A. Remington, *The Matrix Market exchange formats*, NISTIR 5935,
//! 1996), which Python, MATLAB, Julia and Octave read.

use std::path::Path;

use nalgebra::DMatrix;

use super::{OutputError, write_whole};

/// Writes a dense matrix, column by column, with a comment.
///
/// # Errors
/// The file cannot be written.
pub fn write(path: &Path, comment: &str, matrix: &DMatrix<f64>) -> Result<(), OutputError> {
    write_whole(path, |file| {
        writeln!(file, "%%MatrixMarket matrix array real general")?;
        writeln!(file, "% {}", comment.replace(['\n', '\r'], " "))?;
        writeln!(file, "{} {}", matrix.nrows(), matrix.ncols())?;
        matrix.iter().try_for_each(|value| writeln!(file, "{value:?}"))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn matrices_are_written_by_columns() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.mtx");
        write(&path, "two lines\nin one", &DMatrix::from_row_slice(2, 3, &[1.0, 2.5, -3.0, 4.0, 1e-30, 6.0]))
            .unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines[..3], ["%%MatrixMarket matrix array real general", "% two lines in one", "2 3"]);
        assert_eq!(lines[3..], ["1.0", "4.0", "2.5", "1e-30", "-3.0", "6.0"]);
    }
}
