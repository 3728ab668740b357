//! `tegula verify`: the paper's examples and benchmarks, computed and compared.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Args;
use tegula_io::out::write_whole;
use tegula_verify::verify::{Case, Cost, Row, cases, run};

use crate::info::instruction_set;
use crate::ranks::Ranks;
use crate::report::Failure;
use crate::{terminal, threads};

/// Compute the verification cases and compare them with their references
#[derive(Debug, Args)]
pub struct Verify {
    /// Cases to run (`--list` names them), or `paper` for the four examples of the paper; all but the long ones unless given
    cases: Vec<String>,
    /// Name the cases and stop
    #[arg(long)]
    list: bool,
    /// Run the long cases too
    #[arg(long)]
    all: bool,
    /// Write the rows as JSON
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Write the rows as Markdown tables
    #[arg(long, value_name = "FILE")]
    markdown: Option<PathBuf>,
    /// Write the tables that cases make for readers into a folder, a Markdown file each
    #[arg(long, value_name = "DIR")]
    tables: Option<PathBuf>,
    /// Write the run counters of all analyses: steps, iterations, factorisations and cut-backs
    #[arg(long, value_name = "FILE")]
    statistics: Option<PathBuf>,
    /// Draw the figures of the cases into a folder
    #[arg(long, value_name = "DIR")]
    pictures: Option<PathBuf>,
}

const PAPER: [&str; 6] =
    ["plate", "quarter-cylinder", "frequencies", "pendulum", "pendulum-64", "paper-tables"];

impl Verify {
    /// Runs the subcommand.
    pub fn run(&self) -> ExitCode {
        if self.list {
            for case in cases() {
                say!("{:<24} {}", case.name, case.about);
            }
            return ExitCode::SUCCESS;
        }
        let cases = match self.chosen() {
            Ok(cases) => cases,
            Err(message) => {
                terminal::report("error", &message);
                return ExitCode::from(2);
            }
        };
        let ranks = match started() {
            Ok(ranks) => ranks,
            Err(failure) => return failure.report(false),
        };
        let first = ranks.is_first();
        for folder in [&self.pictures, &self.tables].into_iter().flatten() {
            if let Err(e) = std::fs::create_dir_all(folder) {
                terminal::report("error", &format!("the folder {} cannot be made: {e}", folder.display()));
                return ExitCode::from(1);
            }
        }
        say!("{}", Row::heading());
        let pictures = self.pictures.as_deref().filter(|_| first);
        let report = run(&cases, pictures, &mut |row| say!("{}", row.line()));
        if let Err(failure) = ranks.end() {
            return failure.report(false);
        }
        if !first {
            return ExitCode::SUCCESS;
        }
        for table in report.tables() {
            say!("\n{}", table.markdown().trim_end());
        }
        say!("\n{}", report.summary().trim_end());
        if let Some(folder) = &self.tables {
            for table in report.tables() {
                if let Err(message) = write(&folder.join(format!("{}.md", table.name)), &table.markdown()) {
                    terminal::report("error", &message);
                    return ExitCode::from(1);
                }
            }
        }
        let files = [
            (&self.json, format!("{:#}\n", report.json())),
            (&self.markdown, report.markdown()),
            (&self.statistics, format!("processor {}\n{}", instruction_set(), report.statistics())),
        ];
        for (path, text) in files {
            if let Some(path) = path
                && let Err(message) = write(path, &text)
            {
                terminal::report("error", &message);
                return ExitCode::from(1);
            }
        }
        if report.passed() { ExitCode::SUCCESS } else { ExitCode::from(4) }
    }

    fn chosen(&self) -> Result<Vec<&'static Case>, String> {
        if self.cases.is_empty() {
            // Cases with this ending are parts of others.
            let wanted = |c: &&Case| !c.name.ends_with("-fast") && (self.all || c.cost != Cost::Long);
            return Ok(cases().filter(wanted).collect());
        }
        let mut out = Vec::new();
        for name in &self.cases {
            if name == "paper" {
                out.extend(cases().filter(|c| PAPER.contains(&c.name)));
            } else if let Some(case) = cases().find(|c| c.name == name) {
                out.push(case);
            } else {
                let known: Vec<&str> = cases().map(|c| c.name).collect();
                return Err(format!(
                    "there is no case \"{name}\"; the cases are: paper, {}",
                    known.join(", ")
                ));
            }
        }
        Ok(out)
    }
}

/// Ranks of the run, with their threads.
fn started() -> Result<Ranks, Failure> {
    let ranks = Ranks::start()?;
    if let Some(threads) = ranks.threads(None)? {
        threads::start(Some(threads))?;
    }
    Ok(ranks)
}

fn write(path: &Path, text: &str) -> Result<(), String> {
    write_whole(path, |w| w.write_all(text.as_bytes())).map_err(|e| e.to_string())
}
