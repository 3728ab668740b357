//! The sections of an input file of Nastran: executive control, case control, bulk data.

use std::borrow::Cow;

use super::cards::{self, Card};
use crate::mesh::MeshError;
use crate::mesh::numbered::{self, Reader};

/// First letters of the commands whose value is any text.
const TITLES: &[&str] = &["TITL", "SUBT", "LABE"];

/// An input file of Nastran. A file without `BEGIN BULK` is bulk data alone.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct File<'a> {
    /// Statements of the executive control, before `CEND`, each with its line.
    pub executive: Vec<(usize, &'a str)>,
    /// Commands of the case control, from `CEND` to `BEGIN BULK`.
    pub case: Vec<Command>,
    /// Cards of the bulk data.
    pub cards: Vec<Card<'a>>,
}

/// A command of the case control, such as `DISPLACEMENT(PRINT) = ALL`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Command {
    /// Its name in capitals, without what stands in brackets behind it.
    pub name: String,
    /// Text in the brackets behind the name, in capitals.
    pub option: String,
    /// Value; what stands behind the equal sign or the name.
    pub value: String,
    /// Its line.
    pub line: usize,
}

/// Text of the bytes of a file, with blanks in place of tabs.
pub fn text(bytes: &[u8]) -> Cow<'_, str> {
    cards::without_tabs(numbered::text(bytes))
}

/// Whether a line begins the bulk data.
fn begins_bulk(line: &str) -> bool {
    let mut words = cards::content(line).split_whitespace();
    words.next().is_some_and(|word| word.eq_ignore_ascii_case("BEGIN"))
        && words.next().is_none_or(|word| word.eq_ignore_ascii_case("BULK"))
}

/// Whether the text of a file is an input file of Nastran with executive control and bulk data.
pub fn is_complete(text: &str) -> bool {
    text.lines().any(begins_bulk)
}

/// Takes the text of a file apart. What stands behind `ENDDATA` has no meaning.
///
/// # Errors
/// Sections are incomplete, another file is included, or a card cannot be read.
pub fn file<'t>(reader: &Reader<'_>, text: &'t str) -> Result<File<'t>, MeshError> {
    let lines: Vec<(usize, &str)> = text.lines().enumerate().map(|(i, line)| (i + 1, line)).collect();
    let word = |line: &str, word: &str| cards::content(line).trim().eq_ignore_ascii_case(word);
    let bulk = lines.iter().position(|(_, line)| begins_bulk(line));
    let (control, bulk_lines) = match bulk {
        Some(at) => (lines.get(..at).unwrap_or_default(), lines.get(at + 1..).unwrap_or_default()),
        None => (&[][..], &lines[..]),
    };
    let cend = control.iter().position(|(_, line)| word(line, "CEND"));
    let (executive, case) = match (cend, bulk) {
        (Some(at), _) => (control.get(..at).unwrap_or_default(), control.get(at + 1..).unwrap_or_default()),
        (None, None) => (control, &[][..]),
        (None, Some(at)) => {
            let line = lines.get(at).map_or(1, |(line, _)| *line);
            return Err(reader.error(
                line,
                "there is no CEND before BEGIN BULK",
                "close the executive control with CEND",
            ));
        }
    };
    let end = bulk_lines.iter().position(|(_, line)| word(line, "ENDDATA"));
    control.iter().try_for_each(|(line, text)| cards::not_included(reader, *line, text))?;
    let used = bulk_lines.get(..end.unwrap_or(bulk_lines.len())).unwrap_or_default();
    let statements = |of: &[(usize, &'t str)]| -> Vec<(usize, &'t str)> {
        of.iter()
            .map(|(line, text)| (*line, cards::content(text).trim()))
            .filter(|(_, text)| !text.is_empty())
            .collect()
    };
    Ok(File {
        executive: statements(executive),
        case: commands(&statements(case)),
        cards: cards::cards(reader, used.iter().copied())?,
    })
}

/// Commands of lines; one that ends with a comma continues on the next line.
fn commands(lines: &[(usize, &str)]) -> Vec<Command> {
    let mut out: Vec<Command> = Vec::new();
    let mut continued = false;
    for (line, text) in lines {
        if let (true, Some(command)) = (continued, out.last_mut()) {
            command.value.push_str(text);
        } else {
            let end = text.find(|c: char| !c.is_ascii_alphanumeric()).unwrap_or(text.len());
            let (name, rest) = text.split_at(end);
            let rest = rest.trim_start();
            let (option, rest) = match rest.strip_prefix('(') {
                Some(inside) => inside.split_once(')').unwrap_or(("", inside)),
                None => ("", rest),
            };
            let (option, rest) = (option.trim().to_uppercase(), rest.trim_start());
            let value = rest.strip_prefix('=').unwrap_or(rest).trim();
            out.push(Command { name: name.to_uppercase(), option, value: value.to_owned(), line: *line });
        }
        // A title may end with a comma.
        let title =
            out.last().is_some_and(|command| TITLES.iter().any(|title| command.name.starts_with(title)));
        continued = text.ends_with(',') && !title;
    }
    out
}

/// Whether a command begins a subcase; its name may be cut off behind the fourth letter.
fn begins_subcase(command: &Command) -> bool {
    command.name.len() >= 4 && "SUBCASE".starts_with(&command.name)
}

impl File<'_> {
    /// Cards of a name.
    pub fn named<'s>(&'s self, name: &'s str) -> impl Iterator<Item = &'s Card<'s>> {
        self.cards.iter().filter(move |card| card.name == name)
    }

    /// Commands that hold in each subcase, of which the last one of a name counts: those above all subcases, then `SUBCASE` and its own ones. One list where there are no subcases.
    pub fn subcases(&self) -> Vec<Vec<&Command>> {
        let (mut above, mut out): (Vec<&Command>, Vec<Vec<&Command>>) = (Vec::new(), Vec::new());
        for command in &self.case {
            if begins_subcase(command) {
                out.push(above.iter().copied().chain([command]).collect());
            } else {
                out.last_mut().unwrap_or(&mut above).push(command);
            }
        }
        if out.is_empty() { vec![above] } else { out }
    }

    /// Whether a line of the case control belongs to a subcase.
    pub fn in_subcase(&self, line: usize) -> bool {
        self.case.iter().any(|command| command.line == line)
            && self.case.iter().any(|command| begins_subcase(command) && command.line < line)
    }

    /// Number of the set of supports, where the first subcase selects one, with the line of the command.
    pub fn support_set(&self) -> Option<(u64, usize)> {
        let subcases = self.subcases();
        let command = subcases.first()?.iter().rev().find(|command| command.name == "SPC")?;
        Some((command.value.parse().ok()?, command.line))
    }
}
