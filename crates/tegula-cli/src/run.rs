//! `tegula run`

use std::path::{Path, PathBuf};

use clap::Args;
use tegula_io::deck::{Deck, STANDARD_INPUT};
use tegula_io::job::{self, JobError, JobOptions, StopResult, Summary};
use tegula_io::out::numbers::{counted, duration, significant};
use tegula_io::render;

use crate::progress::{Detail, ProgressLine};
use crate::ranks::Ranks;
use crate::report::Failure;
use crate::watched::{self, Watched};
use crate::{html_report, interrupt, threads};

/// Arguments of `tegula run`.
#[derive(Debug, Args)]
pub struct Arguments {
    /// Model file (TOML), or input file of Abaqus, CalculiX (.inp) or Nastran (.bdf, .nas); `-` reads a model file from standard input
    model: PathBuf,
    /// Result folder [default: results/<name of the model file>]
    #[arg(short, long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Threads [default: one for each processor]
    #[arg(short = 'j', long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    threads: Option<u32>,
    /// Restart from the checkpoint of an interrupted run
    #[arg(long, conflicts_with = "force")]
    resume: bool,
    /// Replace the results of another model in the result folder
    #[arg(long)]
    force: bool,
    /// Write `report.html` into the result folder: the run in a browser, with moving shapes and curves
    #[arg(long)]
    report: bool,
    /// Print the address of a page on this computer that shows the run while it goes on: shape, curves, progress, and a button to stop it
    #[arg(long)]
    watch: bool,
    /// Print errors only
    #[arg(short, long, conflicts_with = "verbose")]
    quiet: bool,
    /// Print every step and every event
    #[arg(short, long)]
    verbose: bool,
    /// Print the summary, or what went wrong, as JSON on standard output
    #[arg(long)]
    pub json: bool,
}

/// Runs the model.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let mut ranks = Ranks::start()?;
    let prepared = prepare(arguments, &mut ranks);
    if prepared.is_err() {
        ranks.leave_the_word_to_the_first();
    }
    let (deck, options) = prepared?;
    let folder = options.folder.clone();
    interrupt::listen();
    let first = ranks.is_first();
    let page = if arguments.watch && first { Some(watched::serve()?) } else { None };
    let line = ProgressLine::new(match (arguments.quiet || !first, arguments.verbose) {
        (true, _) => Detail::Nothing,
        (_, true) => Detail::Everything,
        _ => Detail::Progress,
    });
    let mut watched = Watched { line, page, ranks };
    let outcome = job::run(&deck, &options, &mut watched);
    // What follows is the work of rank 0 alone.
    let ranks = std::mem::take(&mut watched.ranks);
    let outcome = ranks.settle(outcome);
    ranks.end()?;
    if !first {
        return Ok(());
    }
    render::stills(&deck, &folder, &outcome, &mut watched);
    watched.line.close();
    if let Some(page) = &mut watched.page {
        page.end(&outcome);
    }
    let told = conclude(arguments, &folder, outcome);
    watched.close();
    told
}

/// Reads the model, and gives each rank a folder.
fn prepare(arguments: &Arguments, ranks: &mut Ranks) -> Result<(Deck, JobOptions), Failure> {
    threads::start(ranks.threads(arguments.threads)?)?;
    let deck = Deck::read(&arguments.model);
    ranks.agree(deck.as_ref().map(|deck| (deck.path.as_path(), deck.text.as_str())).map_err(|_| ()))?;
    let deck = deck.map_err(Failure::Model)?;
    let folder = arguments.out.clone().unwrap_or_else(|| default_folder(&deck.path));
    let options = ranks.options(JobOptions { folder, resume: arguments.resume, force: arguments.force })?;
    Ok((deck, options))
}

/// Writes the report, and prints the findings of a run.
fn conclude(arguments: &Arguments, folder: &Path, outcome: Result<Summary, JobError>) -> Result<(), Failure> {
    let reported = if arguments.report && folder.join("summary.json").is_file() && reportable(&outcome) {
        html_report::write(folder, &folder.join("report.html"))
    } else {
        Ok(())
    };
    // Why a run has failed is more than why it has no report.
    let summary = outcome?;
    if arguments.json {
        say!("{}", as_json(&summary)?);
    } else if !arguments.quiet {
        print(&summary, folder);
    }
    reported
}

/// Whether a run has left results of its own: also one that has failed on its way has a report.
fn reportable(outcome: &Result<Summary, JobError>) -> bool {
    matches!(outcome, Ok(_) | Err(JobError::Analysis { .. } | JobError::Interrupted { .. }))
}

fn default_folder(model: &Path) -> PathBuf {
    Path::new("results").join(name_of(model))
}

/// Name of a model file without its ending.
pub fn name_of(model: &Path) -> PathBuf {
    let name = if model == Path::new(STANDARD_INPUT) { "stdin".as_ref() } else { model.as_os_str() };
    Path::new(name).file_stem().unwrap_or(name).into()
}

/// Summary, as in `summary.json`.
pub fn as_json(summary: &Summary) -> Result<String, Failure> {
    serde_json::to_string_pretty(summary).map_err(|e| Failure::File(e.to_string()))
}

/// Stop condition at which an analysis has ended, in words.
fn ended(stop: &StopResult, analysis: &str) -> String {
    let parameter = if analysis == "transient" { "time" } else { "load factor" };
    format!(
        "ended by a stop condition at {parameter} {}: `{}` has crossed {}",
        significant(stop.time, 9),
        stop.column,
        significant(stop.value, 9)
    )
}

/// Prints the findings of a run.
pub fn print(summary: &Summary, folder: &Path) {
    let s = summary;
    let status = format!("{:?}", s.status).to_lowercase();
    let (iterations, time) = (counted(s.iterations, "iteration"), duration(s.wall_s));
    match s.frequencies_hz.as_ref().or(s.load_factors.as_ref()) {
        Some(found) => say!(
            "{status}: {}, {iterations}, {}, {time}",
            counted(found.len() as u64, "mode"),
            counted(s.factorizations, "factorisation")
        ),
        None => say!(
            "{status}: {}, {iterations}, {}, {time}",
            counted(s.steps, "step"),
            counted(s.cutbacks, "cut-back")
        ),
    }
    for step in &s.analyses {
        let status =
            step.status.map_or("not begun".to_owned(), |status| format!("{status:?}").to_lowercase());
        let stop = step.stop.as_ref().map(|stop| format!(", {}", ended(stop, &step.analysis)));
        say!("  {}: {} analysis, {status}{}", step.folder, step.analysis, stop.unwrap_or_default());
    }
    if let Some(stop) = s.stop.as_ref().filter(|_| s.analyses.is_empty()) {
        say!("  {}", ended(stop, &s.analysis));
    }
    if let Some(error) = s.energy_error {
        say!("  energy balance kept to {} of the largest energy", significant(error, 2));
    }
    if let Some(n) = s.linear_iterations {
        say!("  {} of the linear solver for {} tangents", counted(n, "iteration"), s.factorizations);
    }
    for point in s.critical_points.iter().flatten() {
        say!("  {} at load factor {}", point.kind.name(), significant(point.load_factor, 9));
    }
    if s.critical_points.is_some() {
        say!("  {}", counted(s.factorizations, "factorisation"));
    }
    if let Some(n) = s.negative_pivots {
        say!("  {n} negative pivot(s) of the tangent at the end: the equilibrium may be unstable");
    }
    for (name, point) in &s.points {
        let [x, y, z] = point.displacement.map(|u| significant(u, 7));
        say!("  {name}: displacement ({x}, {y}, {z})");
    }
    for (kind, sets) in [("reaction on", &s.supports), ("load", &s.loads)] {
        for (name, r) in sets {
            let ([x, y, z], [mx, my, mz], [a, b, c]) = (r.force, r.moment, r.about);
            say!("  {kind} {name}: force ({x:.6e}, {y:.6e}, {z:.6e})");
            say!("    moment about ({a}, {b}, {c}): ({mx:.6e}, {my:.6e}, {mz:.6e})");
        }
    }
    if let Some(found) = &s.acceleration {
        let [x, y, z] = found.linear;
        let [rx, ry, rz] = found.angular;
        say!("  inertia relief: acceleration ({x:.6e}, {y:.6e}, {z:.6e}) of the centre of mass");
        say!("    angular acceleration ({rx:.6e}, {ry:.6e}, {rz:.6e})");
    }
    if let Some(balance) = &s.balance {
        say!(
            "  balance of loads, reactions and inertia: {:.1e} of the forces, {:.1e} of the moments",
            balance.force,
            balance.moment
        );
    }
    if s.frequencies_hz.is_some() {
        say!("  natural frequencies in cycles per unit of time (Hz, if that is the second):");
    }
    for (i, frequency) in s.frequencies_hz.iter().flatten().enumerate() {
        say!("  mode {:3}: {}", i + 1, significant(*frequency, 7));
    }
    if s.load_factors.is_some() {
        say!("  load factors of buckling:");
    }
    for (i, factor) in s.load_factors.iter().flatten().enumerate() {
        say!("  mode {:3}: {}", i + 1, significant(*factor, 7));
    }
    say!("results: {}", folder.display());
}
