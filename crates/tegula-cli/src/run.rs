//! `tegula run`

use std::path::{Path, PathBuf};

use clap::Args;
use tegula_io::deck::Deck;
use tegula_io::job::{self, JobOptions, Summary};

use crate::interrupt;
use crate::progress::ProgressLine;
use crate::report::Failure;

/// Arguments of `tegula run`.
#[derive(Debug, Args)]
pub struct Arguments {
    /// Model file (TOML)
    model: PathBuf,
    /// Result folder [default: results/<name of the model file>]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Threads [default: one for each core]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    threads: Option<u16>,
    /// Go on from the checkpoint of an interrupted run
    #[arg(long)]
    resume: bool,
    /// Print nothing but errors
    #[arg(long)]
    quiet: bool,
}

/// Runs the model.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    if let Some(threads) = arguments.threads {
        rayon::ThreadPoolBuilder::new()
            .num_threads(threads.into())
            .build_global()
            .map_err(|e| Failure::Usage(format!("{threads} threads cannot be started: {e}")))?;
    }
    let deck = Deck::read(&arguments.model).map_err(Failure::Model)?;
    let folder = arguments.out.clone().unwrap_or_else(|| default_folder(&arguments.model));
    interrupt::listen();
    let mut line = ProgressLine::new(arguments.quiet);
    let options = JobOptions { folder: folder.clone(), resume: arguments.resume };
    let outcome = job::run(&deck, &options, &mut line);
    line.close();
    let summary = outcome?;
    if !arguments.quiet {
        print(&summary, &folder);
    }
    Ok(())
}

fn default_folder(model: &Path) -> PathBuf {
    Path::new("results").join(model.file_stem().unwrap_or(model.as_os_str()))
}

/// What was found.
pub fn print(summary: &Summary, folder: &Path) {
    let s = summary;
    let status = format!("{:?}", s.status).to_lowercase();
    match &s.frequencies_hz {
        Some(found) => say!(
            "{status}: {} modes, {} iterations, {} factorisations, {:.2} s",
            found.len(),
            s.iterations,
            s.factorizations,
            s.wall_s
        ),
        None => say!(
            "{status}: {} steps, {} iterations, {} repeated steps, {:.2} s",
            s.steps,
            s.iterations,
            s.cutbacks,
            s.wall_s
        ),
    }
    if let Some(error) = s.energy_error {
        say!("  energy balance kept to {error:.1e} of the largest energy");
    }
    if let Some(n) = s.linear_iterations {
        say!("  {n} iterations of conjugate gradients for {} tangents", s.factorizations);
    }
    for (name, point) in &s.points {
        let [x, y, z] = point.displacement;
        say!("  {name}: displacement ({x:.6e}, {y:.6e}, {z:.6e})");
    }
    if s.frequencies_hz.is_some() {
        say!("  natural frequencies in cycles per unit of time (Hz, if that is the second):");
    }
    for (i, frequency) in s.frequencies_hz.iter().flatten().enumerate() {
        say!("  mode {:3}: {frequency:.6e}", i + 1);
    }
    say!("results: {}", folder.display());
}
