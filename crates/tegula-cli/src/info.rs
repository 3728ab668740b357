//! `tegula info`

use std::path::PathBuf;

use clap::Args;
use tegula_io::deck::Deck;
use tegula_io::job::Summary;

use crate::report::Failure;
use crate::{check, run};

/// Arguments of `tegula info`.
#[derive(Debug, Args)]
pub struct Arguments {
    /// Model file or result folder; without it the program itself
    path: Option<PathBuf>,
}

/// Prints the summary of the program, a model or a result.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let Some(path) = &arguments.path else {
        say!("tegula   {}", env!("CARGO_PKG_VERSION"));
        say!("threads  {}", rayon::current_num_threads());
        say!("SIMD     {}", instruction_set());
        say!("target   {}-{}", std::env::consts::ARCH, std::env::consts::OS);
        return Ok(());
    };
    if !path.is_dir() {
        return check::print(&Deck::read(path).map_err(Failure::Model)?);
    }
    let summary = Summary::read(path).map_err(|e| Failure::Usage(e.to_string()))?;
    if !summary.title.is_empty() {
        say!("{}", summary.title);
    }
    say!(
        "{} analysis of {}, {} elements, {} unknowns, mass {:.6e}",
        summary.analysis,
        summary.model,
        summary.elements,
        summary.unknowns,
        summary.mass
    );
    say!("reached {} of {} with tegula {}", summary.time, summary.end, summary.version);
    run::print(&summary, path);
    if let Some(error) = &summary.error {
        say!("error: {error}");
    }
    Ok(())
}

/// The widest vector instructions that the element loops can use here.
fn instruction_set() -> &'static str {
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
