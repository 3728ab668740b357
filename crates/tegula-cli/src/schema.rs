//! `tegula schema`

use tegula_io::deck;

use crate::report::Failure;

/// Prints the JSON Schema of the model file.
pub fn run() -> Result<(), Failure> {
    say!("{}", deck::schema_text().trim_end());
    Ok(())
}
