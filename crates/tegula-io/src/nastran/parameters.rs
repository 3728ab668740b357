//! `PARAM`: what changes the model is read or refused, and what does not is named in a warning.

use crate::mesh::MeshError;
use crate::mesh::nastran::cards::Card;
use crate::mesh::nastran::file::File;
use crate::mesh::nastran::numbers;
use crate::mesh::numbered::{Reader, shown};

/// Parameters without effect: numerics, printing, and stiffness of drilling rotations, which do not exist here.
const IGNORED: &[&str] = &[
    "AUTOSPC", "AUTOSPCR", "K6ROT", "POST", "PRGPST", "GRDPNT", "MAXRATIO", "BAILOUT", "DBALL", "OGEOM",
    "PRTMAXIM", "RESVEC", "NLAYERS", "USETPRT", "EPZERO", "EPPRT", "AUTOMSET", "OUGCORD", "PATVER",
    "POSTEXT", "OIBULK", "OMACHPR", "CHECKOUT", "NOCOMPS", "TINY", "PRTRESLT", "SIGMA", "LMODES", "STRESS",
    "MARCBUG", "NASPRT", "DESPCH", "COMPMATT",
];

/// Parameters that change results a little in Nastran and have no counterpart here.
const APPROXIMATE: &[&str] = &["COUPMASS", "SNORM"];

/// Parameters that are read.
#[derive(Debug, Default)]
pub(super) struct Parameters {
    /// `LGDISP`: whether displacements are large.
    pub large_displacements: Option<bool>,
    /// Parameters without effect, with their lines.
    pub ignored: Vec<(String, usize)>,
    /// Parameters that change results a little in Nastran, with their lines.
    pub approximate: Vec<(String, usize)>,
}

/// Reads the parameters of bulk data and case control.
///
/// # Errors
/// A parameter that changes the model and is not read, or is not known.
pub(super) fn parameters(reader: &Reader<'_>, file: &File<'_>) -> Result<Parameters, MeshError> {
    let mut out = Parameters::default();
    let of_bulk =
        file.named("PARAM").map(|card: &Card<'_>| (card.field(0).text, card.field(1).text, card.line));
    let of_case = file.case.iter().filter(|command| command.name == "PARAM").map(|command| {
        let value = command.value.trim_start_matches(',');
        let (name, value) = value.split_once(',').unwrap_or((value, ""));
        (name.trim(), value.trim(), command.line)
    });
    for (name, value, line) in of_bulk.chain(of_case) {
        let name = name.to_uppercase();
        let number = numbers::real(value).or(numbers::integer(value).map(|n| n as f64));
        match name.as_str() {
            "WTMASS" if number == Some(1.0) => out.ignored.push((name, line)),
            "WTMASS" => {
                return Err(reader.error(
                    line,
                    format!("PARAM,WTMASS is {}", shown(value)),
                    "leave it out, and give densities as masses in consistent units: multiply RHO of each material by it",
                ));
            }
            "LGDISP" if file.in_subcase(line) => {
                return Err(reader.error(
                    line,
                    "PARAM,LGDISP of a subcase is not read",
                    "write it above all subcases or into the bulk data: it holds for all of them",
                ));
            }
            "LGDISP" => match number.map(|n| n as i64) {
                Some(1) => out.large_displacements = Some(true),
                Some(-1 | 0) => out.large_displacements = Some(false),
                _ => {
                    let message = format!("PARAM,LGDISP is {}", shown(value));
                    return Err(reader.error(
                        line,
                        message,
                        "write 1 for large displacements with follower loads, or -1 for small ones",
                    ));
                }
            },
            "FOLLOWK" if matches!(value.to_uppercase().as_str(), "" | "YES") => {
                out.ignored.push((name, line))
            }
            "FOLLOWK" => {
                return Err(reader.error(
                    line,
                    format!("PARAM,FOLLOWK is {}", shown(value)),
                    "leave it out: pressures follow the surface, and buckling has their load stiffness",
                ));
            }
            "INREL" if number != Some(0.0) => {
                let help =
                    "give `inertia_relief = true` in the model file that `tegula convert` writes of the rest";
                return Err(reader.error(line, "PARAM,INREL is not read", help));
            }
            "INREL" => out.ignored.push((name, line)),
            known if APPROXIMATE.contains(&known) => out.approximate.push((name, line)),
            known if IGNORED.contains(&known) => out.ignored.push((name, line)),
            _ => {
                return Err(reader.error(
                    line,
                    format!("PARAM,{} is not read", shown(&name)),
                    "remove it, if the model does not depend on it",
                ));
            }
        }
    }
    Ok(out)
}
