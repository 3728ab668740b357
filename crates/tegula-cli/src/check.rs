//! `tegula check`

use std::path::PathBuf;

use clap::Args;
use tegula::mesh::quality::quality;
use tegula_io::deck::Deck;
use tegula_io::job;

use crate::report::{Failure, warn};

/// Arguments of `tegula check`.
#[derive(Debug, Args)]
pub struct Arguments {
    /// Model file (TOML)
    model: PathBuf,
}

/// Checks the model and prints what it is.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let deck = Deck::read(&arguments.model).map_err(Failure::Model)?;
    print(&deck)
}

/// Prints what a model is.
pub fn print(deck: &Deck) -> Result<(), Failure> {
    let prepared = job::prepare(deck)?;
    let (mesh, system) = (&prepared.mesh, &prepared.system);
    let supported = 3 * system.vectors() - system.unknowns();
    let q = quality(mesh);
    if !deck.model.title.is_empty() {
        say!("{}", deck.model.title);
    }
    if let Some(labels) = &mesh.labels {
        say!("mesh file  {}", labels.file);
    }
    say!("elements   {}", system.elements());
    say!("nodes      {}", mesh.positions.len());
    say!("unknowns   {}", system.unknowns());
    say!("supported  {supported} coordinates");
    say!("mass       {:.6e}", system.total_mass());
    say!("size       {:.6e}", system.length);
    say!(
        "quality    aspect ratio to {:.3}, angles {:.1} to {:.1} degrees, warp to {:.2e}",
        q.max_aspect,
        q.min_angle_deg,
        q.max_angle_deg,
        q.max_warp
    );
    say!("sets       {}", mesh.set_names().join(", "));
    for warning in &prepared.warnings {
        warn(&warning.to_string());
    }
    match prepared.warnings.len() {
        0 => say!("no errors"),
        1 => say!("no errors, 1 warning"),
        n => say!("no errors, {n} warnings"),
    }
    Ok(())
}
