//! `tegula schema`

use tegula_io::deck;

use crate::report::Failure;

/// Prints the JSON Schema of the model file.
pub fn run() -> Result<(), Failure> {
    let text = serde_json::to_string_pretty(&deck::schema()).map_err(|e| Failure::Usage(e.to_string()))?;
    say!("{text}");
    Ok(())
}
