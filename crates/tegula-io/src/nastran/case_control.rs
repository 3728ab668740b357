//! Executive and case control: the solution sequence, and the loads, supports and methods of the subcases.

use std::collections::BTreeMap;

use crate::mesh::MeshError;
use crate::mesh::nastran::file::{Command, File};
use crate::mesh::numbered::{Reader, shown};

/// Commands whose values are read.
const READ: &[&str] = &["TITLE", "SUBCASE", "SPC", "LOAD", "METHOD", "NLPARM", "STATSUB", "ANALYSIS"];

/// Requests for results and titles, which do not change what is computed.
const IGNORED: &[&str] = &[
    "SUBTITLE",
    "LABEL",
    "DISPLACEMENT",
    "VECTOR",
    "SVECTOR",
    "STRESS",
    "ELSTRESS",
    "STRAIN",
    "ELSTRAIN",
    "FORCE",
    "ELFORCE",
    "SPCFORCES",
    "MPCFORCES",
    "OLOAD",
    "GPFORCE",
    "GPSTRESS",
    "GPSTRAIN",
    "ESE",
    "EKE",
    "EDE",
    "ECHO",
    "LINE",
    "MAXLINES",
    "VELOCITY",
    "ACCELERATION",
    "NLSTRESS",
    "SET",
    "STRFIELD",
    "NLOPRM",
    "MEFFMASS",
    "BOUTPUT",
    "PAGE",
    "RESULTS",
    "SEALL",
    "SUPER",
    "WEIGHTCHECK",
    "GROUNDCHECK",
];

/// Statements of the executive control without effect.
const STATEMENTS: &[&str] =
    &["ID", "APP", "TIME", "DIAG", "ASSIGN", "INIT", "ECHOON", "ECHOOFF", "GEOMCHECK"];

/// Solution sequences that are read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Solution {
    /// 101: linear statics.
    Statics,
    /// 103: modes.
    Modes,
    /// 105: linear buckling.
    Buckling,
    /// 106 and 400: nonlinear statics; whether displacements are large unless `PARAM,LGDISP` says so.
    Nonlinear(bool),
}

/// A subcase with what it takes from the commands above all subcases.
#[derive(Debug, Clone, Default)]
pub(super) struct Subcase {
    /// Its number; 0 where there are no subcases.
    pub number: u64,
    /// Its line.
    pub line: usize,
    /// Numbers that commands select, with their lines.
    numbers: BTreeMap<String, (u64, usize)>,
    /// Value of `ANALYSIS` in capitals, with its line.
    analysis: Option<(String, usize)>,
}

/// Executive control.
struct Executive {
    /// Solution sequence.
    solution: Solution,
    /// Its line.
    line: usize,
    /// Statements without effect, with their lines.
    ignored: Vec<(String, usize)>,
}

/// Executive and case control.
#[derive(Debug)]
pub(super) struct Control {
    /// Solution sequence, and its line.
    pub solution: (Solution, usize),
    /// Subcases; one where the file has none.
    pub subcases: Vec<Subcase>,
    /// Title and its line.
    pub title: Option<(String, usize)>,
    /// Commands without effect.
    pub ignored: Vec<(String, usize)>,
}

impl Subcase {
    /// Number that a command selects, such as `LOAD`, with its line.
    pub fn selected(&self, name: &str) -> Option<(u64, usize)> {
        self.numbers.get(name).copied()
    }
}

/// Whether `short` is a command or its first four letters or more.
fn is(short: &str, name: &str) -> bool {
    short == name || (short.len() >= 4 && name.starts_with(short))
}

/// Full name of a command among the known ones.
pub(super) fn full(command: &Command) -> Option<&'static str> {
    let name = command.name.as_str();
    let exact = READ.iter().chain(IGNORED).find(|known| **known == name);
    exact.or_else(|| READ.iter().chain(IGNORED).find(|known| is(name, known))).copied()
}

/// Reads executive and case control.
///
/// # Errors
/// The solution sequence or a command is not read, or a selection is no number.
pub(super) fn control(reader: &Reader<'_>, file: &File<'_>) -> Result<Control, MeshError> {
    let Executive { solution, line, mut ignored } = executive(reader, file)?;
    let mut title = None;
    let unknown: Vec<&Command> =
        file.case.iter().filter(|command| full(command).is_none() && command.name != "PARAM").collect();
    if let Some(first) = unknown.first() {
        let list: Vec<String> = unknown
            .iter()
            .map(|command| format!("{} (line {})", shown(&command.name), command.line))
            .collect();
        return Err(reader.error(
            first.line,
            format!("these commands of the case control are not read: {}", list.join(", ")),
            "remove them, and add their counterparts to the model file that `tegula convert` writes of the rest",
        ));
    }
    for command in &file.case {
        match full(command) {
            Some("TITLE") => title = Some((command.value.clone(), command.line)),
            Some(name) if !READ.contains(&name) => ignored.push((name.to_owned(), command.line)),
            _ => {}
        }
    }
    let subcases: Vec<Subcase> =
        file.subcases().iter().map(|commands| subcase(reader, commands)).collect::<Result<_, _>>()?;
    for (i, subcase) in subcases.iter().enumerate() {
        if let Some((analysis, line)) = &subcase.analysis {
            check(reader, solution, i, (analysis, *line))?;
        }
    }
    Ok(Control { solution: (solution, line), subcases, title, ignored })
}

/// A subcase of the commands that hold in it; the last one of a name counts.
fn subcase(reader: &Reader<'_>, commands: &[&Command]) -> Result<Subcase, MeshError> {
    let mut out = Subcase::default();
    for command in commands {
        match full(command) {
            None | Some("TITLE") => {}
            Some("SUBCASE") => (out.number, out.line) = (number(reader, command)?, command.line),
            Some("ANALYSIS") => out.analysis = Some((command.value.to_uppercase(), command.line)),
            Some("METHOD") if !command.option.is_empty() && !is(&command.option, "STRUCTURE") => {
                return Err(reader.error(
                    command.line,
                    format!("METHOD({}) is not read", shown(&command.option)),
                    "remove it: there are modes of the structure only",
                ));
            }
            Some(name) if READ.contains(&name) => {
                out.numbers.insert(name.to_owned(), (number(reader, command)?, command.line));
            }
            Some(_) => {}
        }
    }
    Ok(out)
}

/// Refuses an `ANALYSIS` of the subcase at an index that is not the one of the solution sequence.
fn check(
    reader: &Reader<'_>,
    solution: Solution,
    index: usize,
    (analysis, line): (&str, usize),
) -> Result<(), MeshError> {
    let fits = match solution {
        Solution::Statics => matches!(analysis, "STATICS" | "STATIC"),
        Solution::Modes => analysis == "MODES",
        Solution::Buckling if index == 0 => matches!(analysis, "STATICS" | "STATIC"),
        Solution::Buckling => matches!(analysis, "BUCK" | "BUCKLING"),
        Solution::Nonlinear(_) => matches!(analysis, "NLSTATIC" | "NLSTATICS"),
    };
    let message = format!("ANALYSIS = {} is not read in this solution sequence", shown(analysis));
    let help = "remove it, and give linear statics by SOL 101, modes by 103, buckling by 105, nonlinear statics by 106 or 400";
    if fits { Ok(()) } else { Err(reader.error(line, message, help)) }
}

fn number(reader: &Reader<'_>, command: &Command) -> Result<u64, MeshError> {
    command.value.parse().ok().filter(|&n: &u64| n > 0).ok_or_else(|| {
        reader.error(
            command.line,
            format!("{} is \"{}\", which is no number above 0", command.name, shown(&command.value)),
            "write the number of the set, such as LOAD = 2",
        )
    })
}

/// Solution sequence of the statement `SOL`, and statements without effect.
fn executive(reader: &Reader<'_>, file: &File<'_>) -> Result<Executive, MeshError> {
    let (mut found, mut ignored) = (None, Vec::new());
    for (line, statement) in &file.executive {
        let mut words = statement.split([' ', ',', '=']).filter(|word| !word.is_empty());
        let name = words.next().unwrap_or_default().to_uppercase();
        match name.as_str() {
            "SOL" => {
                let of = words.next().unwrap_or_default().to_uppercase();
                let solution = match of.as_str() {
                    "101" | "SESTATIC" | "SESTATICS" => Solution::Statics,
                    "103" | "SEMODES" => Solution::Modes,
                    "105" | "SEBUCKL" => Solution::Buckling,
                    "106" | "NLSTATIC" => Solution::Nonlinear(false),
                    "400" | "NONLIN" => Solution::Nonlinear(true),
                    other => {
                        return Err(reader.error(
                            *line,
                            format!("SOL {} is not read", shown(other)),
                            "101 (linear statics), 103 (modes), 105 (buckling), 106 and 400 (nonlinear statics) are; \
                             for others name the file in a model file: [mesh] with type = \"nastran\"",
                        ));
                    }
                };
                if found.replace((solution, *line)).is_some() {
                    return Err(reader.error(
                        *line,
                        "SOL stands twice",
                        "keep one of the solution sequences",
                    ));
                }
            }
            name if STATEMENTS.contains(&name) => ignored.push((name.to_owned(), *line)),
            name => {
                return Err(reader.error(
                    *line,
                    format!("the statement {} of the executive control is not read", shown(name)),
                    "remove it",
                ));
            }
        }
    }
    match found {
        Some((solution, line)) => Ok(Executive { solution, line, ignored }),
        None => Err(reader.whole(
            "the file has no SOL, so there is nothing to compute",
            "add executive and case control (SOL 101, CEND, BEGIN BULK), or name the file in a model file: [mesh] with type = \"nastran\"",
        )),
    }
}
