//! The sections of an input file of Nastran: executive control, case control, bulk data.

use std::borrow::Cow;

use super::cards::{self, Card};
use crate::mesh::MeshError;
use crate::mesh::numbered::{self, Reader, shown};

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
    /// Whether there are executive and case control.
    pub complete: bool,
}

/// A command of the case control, such as `DISPLACEMENT(PRINT) = ALL`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Command {
    /// Its name in capitals, without what stands in brackets behind it.
    pub name: String,
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

/// Takes the text of a file apart.
///
/// # Errors
/// Sections are incomplete, text stands behind `ENDDATA`, or a card cannot be read.
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
    let behind = bulk_lines.get(end.map_or(bulk_lines.len(), |end| end + 1)..).unwrap_or_default();
    if let Some((line, text)) = behind.iter().find(|(_, line)| !cards::content(line).trim().is_empty()) {
        return Err(reader.error(
            *line,
            format!("\"{}\" stands behind ENDDATA", shown(text.trim())),
            "remove it, or move ENDDATA to the end",
        ));
    }
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
        complete: bulk.is_some(),
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
            let rest = match rest.strip_prefix('(') {
                Some(inside) => inside.split_once(')').map_or(inside, |(_, behind)| behind).trim_start(),
                None => rest,
            };
            let value = rest.strip_prefix('=').unwrap_or(rest).trim();
            out.push(Command { name: name.to_uppercase(), value: value.to_owned(), line: *line });
        }
        // A title may end with a comma.
        let title =
            out.last().is_some_and(|command| TITLES.iter().any(|title| command.name.starts_with(title)));
        continued = text.ends_with(',') && !title;
    }
    out
}

impl File<'_> {
    /// Cards of a name.
    pub fn named<'s>(&'s self, name: &'s str) -> impl Iterator<Item = &'s Card<'s>> {
        self.cards.iter().filter(move |card| card.name == name)
    }

    /// Number of the set of supports, where the case control selects one.
    pub fn support_set(&self) -> Option<u64> {
        let command = self.case.iter().find(|command| command.name == "SPC")?;
        command.value.parse().ok()
    }
}
