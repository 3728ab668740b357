//! `tegula convert`

use std::path::{Path, PathBuf};

use clap::Args;
use tegula_io::deck::Deck;

use crate::new;
use crate::report::{Failure, warn};

/// Arguments of `tegula convert`.
#[derive(Debug, Args)]
pub struct Arguments {
    /// Input file of Abaqus, CalculiX (.inp) or Nastran (.bdf, .nas); the model file reads the mesh from it
    input: PathBuf,
    /// Model file to write (TOML)
    model: PathBuf,
}

/// Writes the model file; never over a file.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let Arguments { input, model } = arguments;
    let deck = Deck::convert(input, &mesh_file(input, model)).map_err(Failure::Model)?;
    new::write(model, &deck.text)?;
    deck.locate(&deck.warnings).iter().for_each(warn);
    say!("{}", model.display());
    say!("next: tegula run {}", model.display());
    Ok(())
}

/// Name of the input file for the model file: relative where both lie in one folder, else absolute.
fn mesh_file(input: &Path, model: &Path) -> String {
    let folder = |path: &Path| {
        let parent = path.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
        parent.canonicalize().ok()
    };
    let name = input.file_name().map(Path::new).unwrap_or(input);
    let path = match (folder(input), folder(model)) {
        (Some(of_input), Some(of_model)) if of_input != of_model => of_input.join(name),
        _ => name.to_owned(),
    };
    path.to_string_lossy().into_owned()
}
