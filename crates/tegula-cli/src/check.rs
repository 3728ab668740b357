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
        println!("{}", deck.model.title);
    }
    if let Some(labels) = &mesh.labels {
        println!("mesh file  {}", labels.file);
    }
    println!("elements   {}", system.elements());
    println!("nodes      {}", mesh.positions.len());
    println!("unknowns   {}", system.unknowns());
    println!("supported  {supported} coordinates");
    println!("mass       {:.6e}", system.total_mass());
    println!("size       {:.6e}", system.length);
    println!(
        "quality    aspect ratio to {:.3}, angles {:.1} to {:.1} degrees, warp to {:.2e}",
        q.max_aspect, q.min_angle_deg, q.max_angle_deg, q.max_warp
    );
    println!("sets       {}", mesh.set_names().join(", "));
    for warning in &prepared.warnings {
        warn(&warning.to_string());
    }
    match prepared.warnings.len() {
        0 => println!("no errors"),
        1 => println!("no errors, 1 warning"),
        n => println!("no errors, {n} warnings"),
    }
    Ok(())
}
