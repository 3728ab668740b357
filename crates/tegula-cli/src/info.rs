//! `tegula info`

use std::path::PathBuf;

use clap::Args;
use serde_json::json;
use tegula_io::deck::Deck;
use tegula_io::job::Summary;
use tegula_io::out::numbers::{grouped, significant};

use crate::report::Failure;
use crate::{check, run};

/// Arguments of `tegula info`.
#[derive(Debug, Args)]
pub struct Arguments {
    /// Model file or result folder; without it the program itself
    path: Option<PathBuf>,
    /// Print it as JSON on standard output
    #[arg(long)]
    pub json: bool,
}

/// Prints the summary of the program, a model or a result.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let Some(path) = &arguments.path else {
        program(arguments.json);
        return Ok(());
    };
    if !path.is_dir() {
        return check::print(&Deck::read(path).map_err(Failure::Model)?, arguments.json);
    }
    let summary = Summary::read(path).map_err(|e| Failure::File(e.to_string()))?;
    if arguments.json {
        say!("{}", run::as_json(&summary)?);
        return Ok(());
    }
    if !summary.title.is_empty() {
        say!("{}", summary.title);
    }
    say!(
        "{} analysis of {}, {} elements, {} unknowns, mass {}",
        summary.analysis,
        summary.model,
        grouped(summary.elements),
        grouped(summary.unknowns),
        significant(summary.mass, 7)
    );
    let place = if summary.analysis == "static" { "load factor" } else { "time" };
    say!(
        "reached {place} {} of {} with tegula {}",
        significant(summary.time, 5),
        significant(summary.end, 5),
        summary.version
    );
    run::print(&summary, path);
    if let Some(error) = &summary.error {
        say!("error: {error}");
    }
    Ok(())
}

fn program(as_json: bool) {
    let (version, threads) = (env!("CARGO_PKG_VERSION"), rayon::current_num_threads());
    let target = format!("{}-{}", std::env::consts::ARCH, std::env::consts::OS);
    if as_json {
        let simd = instruction_set();
        say!("{:#}", json!({ "version": version, "threads": threads, "simd": simd, "target": target }));
        return;
    }
    say!("tegula   {version}");
    say!("threads  {threads}");
    say!("SIMD     {}", instruction_set());
    say!("target   {target}");
}

/// The widest vector instructions that the element loops can use here.
pub fn instruction_set() -> &'static str {
    #[cfg(target_arch = "x86_64")]
    {
        if std::arch::is_x86_feature_detected!("avx512f") {
            return "AVX-512";
        }
        if std::arch::is_x86_feature_detected!("avx2") && std::arch::is_x86_feature_detected!("fma") {
            return "AVX2 with FMA";
        }
        "SSE2"
    }
    #[cfg(target_arch = "aarch64")]
    {
        "NEON"
    }
    #[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
    {
        "none"
    }
}
