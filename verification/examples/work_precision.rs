//! Work and precision of the integrators: cost of each over its error, as tables and pictures.
//!
//! ```text
//! cargo run --release --example work_precision -- [KEY=VALUE...]
//! ```
//!
//! | key | is | unless given |
//! |---|---|---|
//! | `out` | folder for `work_precision.md`, `work_precision.csv` and two pictures of each motion | `work_precision` |
//! | `motions` | of `pendulum`, `plate`, `tumbling`, with commas | all |
//! | `elements` | along a side | those of the motion |
//! | `repetitions` | of each run; the least processor time counts | 3 |
//! | `reference` | how many times shorter its steps are than the shortest constant ones | 4 |
//! | `coarse` | `yes`: every other step length and tolerance | `no` |
#![allow(missing_docs, clippy::print_stdout)]

use std::path::PathBuf;
use std::process::ExitCode;

use tegula_io::out::write_whole;
use tegula_verify::precision::{Cost, Study, Transient, csv, markdown, picture};

fn main() -> ExitCode {
    match arguments().and_then(|(study, out)| run(&study, &out)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("error: {message}");
            ExitCode::FAILURE
        }
    }
}

fn arguments() -> Result<(Study, PathBuf), String> {
    let mut study = Study {
        transients: Transient::EVERY.to_vec(),
        elements: None,
        repetitions: 3,
        reference: 4.0,
        coarse: false,
    };
    let mut out = PathBuf::from("work_precision");
    for argument in std::env::args().skip(1) {
        let (key, value) =
            argument.split_once('=').ok_or_else(|| format!("\"{argument}\" is not KEY=VALUE"))?;
        let number = || value.parse::<u32>().ok().filter(|&n| n > 0);
        let positive = || number().ok_or_else(|| format!("{key}: \"{value}\" is no positive number"));
        match key {
            "out" => out = value.into(),
            "motions" => study.transients = value.split(',').map(motion).collect::<Result<_, _>>()?,
            "elements" => study.elements = Some(positive()?),
            "repetitions" => study.repetitions = positive()?,
            "reference" => study.reference = f64::from(positive()?),
            "coarse" => study.coarse = value == "yes",
            _ => return Err(format!("there is no key \"{key}\"")),
        }
    }
    Ok((study, out))
}

fn motion(name: &str) -> Result<Transient, String> {
    let known = Transient::EVERY.map(Transient::name).join(", ");
    Transient::EVERY
        .into_iter()
        .find(|t| t.name() == name)
        .ok_or_else(|| format!("there is no motion \"{name}\"; there are: {known}"))
}

fn run(study: &Study, out: &std::path::Path) -> Result<(), String> {
    std::fs::create_dir_all(out).map_err(|e| format!("the folder {} cannot be made: {e}", out.display()))?;
    let (references, rows) = study
        .run(&mut |row| {
            eprintln!(
                "{} {} {:?}: {} steps, work {:.0}, {:.2} s, error {:.1e} {}",
                row.transient.name(),
                row.scheme.name(),
                row.stepping,
                row.statistics.steps,
                row.work,
                row.seconds,
                row.error,
                row.failure
            );
        })
        .map_err(|e| e.to_string())?;
    let tables = markdown(&references, &rows);
    for (name, text) in [("work_precision.md", &tables), ("work_precision.csv", &csv(&rows))] {
        write_whole(&out.join(name), |w| w.write_all(text.as_bytes())).map_err(|e| e.to_string())?;
    }
    for &transient in &study.transients {
        for (cost, name) in [(Cost::Seconds, "seconds"), (Cost::Work, "work")] {
            let path = out.join(format!("{}_{name}.png", transient.name()));
            picture(&path, transient, &rows, cost).map_err(|e| e.to_string())?;
        }
    }
    println!("{tables}");
    Ok(())
}
