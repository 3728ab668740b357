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
fn full(command: &Command) -> Option<&'static str> {
    let name = command.name.as_str();
    let exact = READ.iter().chain(IGNORED).find(|known| **known == name);
    exact.or_else(|| READ.iter().chain(IGNORED).find(|known| is(name, known))).copied()
}

/// Reads executive and case control.
///
/// # Errors
/// The solution sequence or a command is not read, or a selection is no number.
pub(super) fn control(reader: &Reader<'_>, file: &File<'_>) -> Result<Control, MeshError> {
    let (solution, mut ignored) = solution(reader, file)?;
    let mut title = None;
    let mut defaults = Subcase::default();
    let mut subcases: Vec<Subcase> = Vec::new();
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
        let Some(name) = full(command) else { continue };
        match name {
            "TITLE" => title = Some((command.value.clone(), command.line)),
            "SUBCASE" => {
                let number = number(reader, command)?;
                subcases.push(Subcase { number, line: command.line, numbers: defaults.numbers.clone() });
            }
            "ANALYSIS" => {
                let known = ["STATICS", "STATIC", "NLSTATIC", "NLSTATICS", "MODES", "BUCKLING", "BUCK"];
                if !known.iter().any(|word| command.value.eq_ignore_ascii_case(word)) {
                    let message = format!("ANALYSIS = {} is not read", shown(&command.value));
                    return Err(reader.error(
                        command.line,
                        message,
                        "give statics, modes or buckling by SOL 101, 103, 105, 106",
                    ));
                }
            }
            name if READ.contains(&name) => {
                let entry = (number(reader, command)?, command.line);
                let of = subcases.last_mut().unwrap_or(&mut defaults);
                of.numbers.insert(name.to_owned(), entry);
            }
            name => ignored.push((name.to_owned(), command.line)),
        }
    }
    if subcases.is_empty() {
        subcases.push(defaults);
    }
    Ok(Control { solution, subcases, title, ignored })
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
#[allow(clippy::type_complexity)]
fn solution(
    reader: &Reader<'_>,
    file: &File<'_>,
) -> Result<((Solution, usize), Vec<(String, usize)>), MeshError> {
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
        Some(solution) => Ok((solution, ignored)),
        None => Err(reader.whole(
            "the file has no SOL, so there is nothing to compute",
            "add executive and case control (SOL 101, CEND, BEGIN BULK), or name the file in a model file: [mesh] with type = \"nastran\"",
        )),
    }
}
