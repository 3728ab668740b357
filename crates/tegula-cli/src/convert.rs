//! `tegula convert`

use std::path::{Path, PathBuf};

use clap::Args;
use tegula_io::deck::Deck;
use tegula_io::export;
use tegula_io::out::numbers::counted;

use crate::new;
use crate::report::{Failure, warn};
use crate::terminal;

/// Arguments of `tegula convert`.
#[derive(Debug, Args)]
pub struct Arguments {
    /// Input file of Abaqus, CalculiX (.inp) or Nastran (.bdf, .nas); or a result folder, one of its lists of field files (.pvd) or one of
    /// its tables (.csv)
    input: PathBuf,
    /// File to write: of an input file a model file (.toml), which reads the mesh from it; of field files one file of all instants or modes for
    /// ParaView (.vtkhdf); of a table a Parquet file (.parquet)
    output: PathBuf,
}

/// Writes the file; never over a file.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let Arguments { input, output } = arguments;
    let has =
        |path: &Path, extension: &str| path.extension().is_some_and(|e| e.eq_ignore_ascii_case(extension));
    let [vtkhdf, parquet] = ["vtkhdf", "parquet"].map(|extension| has(output, extension));
    let of_results = input.is_dir() || has(input, "pvd") || has(input, "csv");
    if of_results && !vtkhdf && !parquet {
        return Err(Failure::Usage(format!(
            "`{}` is no file that results are converted to; let its name end in .vtkhdf (field files) or .parquet (tables)",
            output.display()
        )));
    }
    if (vtkhdf || parquet) && output.exists() {
        return Err(new::exists(output));
    }
    match (vtkhdf, parquet) {
        (true, _) => to_vtkhdf(input, output),
        (_, true) => to_parquet(input, output),
        _ => to_model(input, output),
    }
}

fn to_model(input: &Path, model: &Path) -> Result<(), Failure> {
    let deck = Deck::convert(input, &mesh_file(input, model)).map_err(Failure::Model)?;
    new::write(model, &deck.text)?;
    deck.locate(&deck.warnings).iter().for_each(warn);
    say!("{}", model.display());
    say!("next: tegula run {}", model.display());
    Ok(())
}

fn to_vtkhdf(input: &Path, output: &Path) -> Result<(), Failure> {
    let exported = export::to_vtkhdf(input, output).map_err(|e| Failure::File(e.to_string()))?;
    let instants = counted(exported.instants as u64, "instant");
    say!("{}: {instants} of {}", output.display(), exported.list.display());
    if exported.missing > 0 {
        let missing = counted(exported.missing as u64, "file");
        terminal::report(
            "warning",
            &format!("the list names {missing} that cannot be found: these instants are left out"),
        );
    }
    for other in &exported.others {
        say!("also there: {}, to be converted by its name", other.display());
    }
    Ok(())
}

fn to_parquet(input: &Path, output: &Path) -> Result<(), Failure> {
    let (columns, rows) = export::to_parquet(input, output).map_err(|e| Failure::File(e.to_string()))?;
    let [columns, rows] = [(columns, "column"), (rows, "row")].map(|(n, noun)| counted(n as u64, noun));
    say!("{}: {columns}, {rows}", output.display());
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
