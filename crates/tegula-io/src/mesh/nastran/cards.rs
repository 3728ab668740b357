//! Cards of bulk data: free, small and large fields, with continuations.
//!
//! A line has a name, 8 data fields and a continuation field, between commas or in columns of 8. Where the name ends with a star there are
//! 4 data fields of 16 columns, and the other half of the 8 stands on the next line. A line whose first field is blank or begins with `+`
//! or `*` continues the line before it. A dollar sign begins a comment.

use std::borrow::Cow;

use super::numbers;
use crate::mesh::MeshError;
use crate::mesh::numbered::{Reader, shown};

/// Data fields of a line.
pub const FIELDS: usize = 8;
/// Columns of a tab.
const TAB: usize = 8;
/// Columns of a line.
const COLUMNS: usize = 80;

/// A card with the fields of all its lines; each line has 8 of them, and blank ones at the end are left out.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Card<'a> {
    /// Name in capitals, without the star.
    pub name: String,
    /// Line of the name, counted from 1.
    pub line: usize,
    fields: Vec<Field<'a>>,
}

/// A data field.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Field<'a> {
    /// Its text without blanks around it; empty where the field is blank.
    pub text: &'a str,
    /// Its line.
    pub line: usize,
}

/// A line of bulk data without its comment, taken apart.
struct Line<'a> {
    name: &'a str,
    large: bool,
    data: Vec<&'a str>,
    continuation: &'a str,
}

/// The text with blanks in place of tabs, up to the next multiple of 8 columns.
pub fn without_tabs(text: Cow<'_, str>) -> Cow<'_, str> {
    if !text.contains('\t') {
        return text;
    }
    let mut out = String::with_capacity(text.len() + text.len() / 4);
    let mut column = 0;
    for c in text.chars() {
        match c {
            '\t' => {
                let blanks = TAB - column % TAB;
                out.extend(std::iter::repeat_n(' ', blanks));
                column += blanks;
            }
            _ => {
                out.push(c);
                column = if c == '\n' { 0 } else { column + 1 };
            }
        }
    }
    Cow::Owned(out)
}

/// A line without its comment.
pub fn content(line: &str) -> &str {
    line.split('$').next().unwrap_or_default().trim_end()
}

/// Cards of numbered lines of bulk data.
///
/// # Errors
/// A line cannot be taken apart, or continues no card.
pub fn cards<'t>(
    reader: &Reader<'_>,
    lines: impl Iterator<Item = (usize, &'t str)>,
) -> Result<Vec<Card<'t>>, MeshError> {
    let mut cards: Vec<Card<'t>> = Vec::new();
    let (mut half, mut mnemonic, mut empty) = (false, "", None);
    for (number, line) in lines {
        let content = content(line);
        if content.trim().is_empty() {
            // A comment may stand anywhere.
            empty = if line.trim().is_empty() { Some(number) } else { empty };
            continue;
        }
        let empty = empty.take();
        not_included(reader, number, content)?;
        let Line { name, large, data, continuation } = taken_apart(reader, number, content)?;
        let continues = name.is_empty() || name.starts_with(['+', '*']);
        let fields = data.into_iter().map(|text| Field { text, line: number });
        let blank = Field { text: "", line: number };
        if half && (!continues || !large) {
            cards.last_mut().into_iter().for_each(|card| card.fields.extend([blank; FIELDS / 2]));
            half = false;
        }
        if continues {
            let Some(card) = cards.last_mut() else {
                return Err(reader.error(
                    number,
                    "the line continues no card",
                    "write the name of a card first",
                ));
            };
            if let Some(line) = empty {
                return Err(reader.error(
                    line,
                    format!("an empty line stands within the card {} of line {}", card.name, card.line),
                    "delete it; where it stands for eight blank fields, begin it with +",
                ));
            }
            let own = name.trim_start_matches(['+', '*']);
            if !own.is_empty() && !own.eq_ignore_ascii_case(mnemonic) {
                return Err(detached(reader, number, own, mnemonic));
            }
            card.fields.extend(fields);
        } else {
            let name = name.trim_end_matches('*').trim_end().to_uppercase();
            if !name.bytes().all(|b| b.is_ascii_alphanumeric()) {
                return Err(reader.error(
                    number,
                    format!("\"{}\" is not the name of a card", shown(&name)),
                    "a line of bulk data begins with a name such as GRID; generated lines (=) are not read",
                ));
            }
            cards.push(Card { name, line: number, fields: fields.collect() });
        }
        half = large && !half;
        mnemonic = continuation.trim_start_matches(['+', '*']);
    }
    for card in &mut cards {
        while card.fields.last().is_some_and(|field| field.text.is_empty()) {
            card.fields.pop();
        }
    }
    Ok(cards)
}

/// Error of a line whose name is not the continuation name of the line before.
fn detached(reader: &Reader<'_>, number: usize, own: &str, mnemonic: &str) -> MeshError {
    let expected = match mnemonic {
        "" => "has no continuation name".to_owned(),
        name => format!("asks for \"{}\"", shown(name)),
    };
    reader.error(
        number,
        format!("the line \"{}\" does not continue the one before, which {expected}", shown(own)),
        "put continuations right behind the lines that they continue, with the same name in field 10, or begin them with a bare +",
    )
}

/// Refuses a line that includes another file.
///
/// # Errors
/// The line does so.
pub fn not_included(reader: &Reader<'_>, number: usize, line: &str) -> Result<(), MeshError> {
    let line = line.trim_start();
    let end = line.find(|c: char| !c.is_ascii_alphanumeric()).unwrap_or(line.len());
    match line.get(..end) {
        Some(word) if word.eq_ignore_ascii_case("INCLUDE") => {
            Err(reader.error(number, "INCLUDE is not read", "write the lines of the other file in its place"))
        }
        _ => Ok(()),
    }
}

/// Name, data fields and continuation field of a line.
fn taken_apart<'t>(reader: &Reader<'_>, number: usize, line: &'t str) -> Result<Line<'t>, MeshError> {
    let is_large = |name: &str| name.ends_with('*') || name.starts_with('*');
    if line.contains(',') {
        let mut parts = line.split(',').map(str::trim);
        let name = parts.next().unwrap_or_default();
        let large = is_large(name);
        let width = if large { FIELDS / 2 } else { FIELDS };
        let mut data: Vec<&str> = parts.by_ref().take(width).collect();
        data.resize(width, "");
        let continuation = parts.next().unwrap_or_default();
        let further = [continuation].into_iter().filter(|field| !field.starts_with(['+', '*'])).chain(parts);
        if let Some(value) = further.into_iter().find(|value| !value.is_empty()) {
            return Err(reader.error(
                number,
                format!("the line has the value \"{}\" behind its {width} data fields", shown(value)),
                "continue the card on the next line, which begins with a comma or +",
            ));
        }
        return Ok(Line { name, large, data, continuation });
    }
    let ascii = line.is_ascii().then_some(()).ok_or_else(|| {
        reader.error(
            number,
            "the line has characters that have no columns",
            "write plain ASCII, or commas between the fields",
        )
    });
    ascii?;
    let columns = |from: usize, to: usize| {
        line.get(from.min(line.len())..to.min(line.len())).unwrap_or_default().trim()
    };
    let name = columns(0, TAB);
    let large = is_large(name);
    let width = if large { 2 * TAB } else { TAB };
    let data = (0..COLUMNS - 2 * TAB).step_by(width).map(|at| columns(TAB + at, TAB + at + width)).collect();
    if !columns(COLUMNS, line.len()).is_empty() {
        return Err(reader.error(
            number,
            format!("the line goes on behind column {COLUMNS}"),
            "a line has 10 fields of 8 columns; continue the card on the next line",
        ));
    }
    Ok(Line { name, large, data, continuation: columns(COLUMNS - TAB, COLUMNS) })
}

impl<'a> Card<'a> {
    /// The data field at an index, counted from 0; blank behind the last one.
    pub fn field(&self, index: usize) -> Field<'a> {
        let line = self.fields.last().map_or(self.line, |field| field.line);
        self.fields.get(index).copied().unwrap_or(Field { text: "", line })
    }

    /// Data fields from an index on.
    pub fn fields_from(&self, index: usize) -> impl Iterator<Item = Field<'a>> {
        self.fields.iter().skip(index).copied()
    }

    /// The card without its last field.
    pub fn without_last(&self) -> Self {
        let mut card = self.clone();
        card.fields.pop();
        card
    }

    /// Number of data fields up to the last one that is not blank.
    pub fn count(&self) -> usize {
        self.fields.len()
    }

    /// A real number; `None` where the field is blank.
    ///
    /// # Errors
    /// The field is none.
    pub fn real(&self, reader: &Reader<'_>, index: usize, what: &str) -> Result<Option<f64>, MeshError> {
        let field = self.field(index);
        if field.text.is_empty() {
            return Ok(None);
        }
        numbers::real(field.text).map(Some).ok_or_else(|| {
            reader.error(
                field.line,
                format!("{what} of {} is \"{}\", which is no real number", self.name, shown(field.text)),
                "write a number with a decimal point, such as 2. or 1.5E-3",
            )
        })
    }

    /// A real number that must be given.
    ///
    /// # Errors
    /// The field is blank or none.
    pub fn required(&self, reader: &Reader<'_>, index: usize, what: &str) -> Result<f64, MeshError> {
        self.real(reader, index, what)?.ok_or_else(|| self.missing(reader, index, what))
    }

    /// A whole number; `None` where the field is blank.
    ///
    /// # Errors
    /// The field is none.
    pub fn integer(&self, reader: &Reader<'_>, index: usize, what: &str) -> Result<Option<i64>, MeshError> {
        let field = self.field(index);
        if field.text.is_empty() {
            return Ok(None);
        }
        numbers::integer(field.text).map(Some).ok_or_else(|| {
            reader.error(
                field.line,
                format!("{what} of {} is \"{}\", which is no whole number", self.name, shown(field.text)),
                "write a number without a decimal point",
            )
        })
    }

    /// A number above 0 that must be given.
    ///
    /// # Errors
    /// The field is blank or none.
    pub fn id(&self, reader: &Reader<'_>, index: usize, what: &str) -> Result<u64, MeshError> {
        let Some(number) = self.integer(reader, index, what)? else {
            return Err(self.missing(reader, index, what));
        };
        u64::try_from(number).ok().filter(|&n| n > 0).ok_or_else(|| {
            let message = format!("{what} of {} is {number}", self.name);
            reader.error(self.field(index).line, message, "write a number above 0")
        })
    }

    /// Refuses a field that is neither blank nor 0.
    ///
    /// # Errors
    /// It is not.
    pub fn none(&self, reader: &Reader<'_>, index: usize, what: &str, help: &str) -> Result<(), MeshError> {
        self.zero(reader, index, &format!("{what} of {}", self.name), help)
    }

    /// Refuses a field that is neither blank nor 0, with a message that begins with `what`.
    ///
    /// # Errors
    /// It is not.
    pub fn zero(&self, reader: &Reader<'_>, index: usize, what: &str, help: &str) -> Result<(), MeshError> {
        let field = self.field(index);
        let zero = numbers::real(field.text) == Some(0.0) || numbers::integer(field.text) == Some(0);
        if field.text.is_empty() || zero {
            return Ok(());
        }
        Err(reader.error(field.line, format!("{what} is {}, which is not read", shown(field.text)), help))
    }

    /// Refuses values behind the first `count` data fields.
    ///
    /// # Errors
    /// There is one.
    pub fn only(&self, reader: &Reader<'_>, count: usize) -> Result<(), MeshError> {
        match self.fields_from(count).find(|field| !field.text.is_empty()) {
            None => Ok(()),
            Some(field) => Err(reader.error(
                field.line,
                format!("{} has a further value \"{}\", which is not read", self.name, shown(field.text)),
                "remove it, or check the columns of the card",
            )),
        }
    }

    /// Error of a field that must not be blank.
    pub fn missing(&self, reader: &Reader<'_>, index: usize, what: &str) -> MeshError {
        let line = if index < self.fields.len() { self.field(index).line } else { self.line };
        let row = match index / FIELDS {
            0 => String::new(),
            row => format!(" of line {} of the card", row + 1),
        };
        reader.error(
            line,
            format!("{what} of {} is missing", self.name),
            format!("fill field {}{row}", index % FIELDS + 2),
        )
    }

    /// Numbers of a list from an index on, with `THRU` between the first and the last one of a range. Of ranges only the `known` numbers are
    /// taken.
    ///
    /// # Errors
    /// The list is empty, or a field is no such number.
    pub fn list(
        &self,
        reader: &Reader<'_>,
        index: usize,
        what: &str,
        known: &std::collections::BTreeSet<u64>,
    ) -> Result<Vec<u64>, MeshError> {
        let mut out: Vec<u64> = Vec::new();
        let mut first = None;
        let mut thru = None;
        for at in index..self.count() {
            let field = self.field(at);
            if field.text.is_empty() {
                continue;
            }
            if field.text.eq_ignore_ascii_case("THRU") {
                let from = first.take().filter(|_| thru.is_none());
                thru = Some(from.ok_or_else(|| self.range(reader, field))?);
                continue;
            }
            let number = self.id(reader, at, what)?;
            match thru.take() {
                None => out.extend([number]),
                Some(from) if from > number => return Err(self.range(reader, field)),
                Some(from) => {
                    out.pop();
                    out.extend(known.range(from..=number));
                }
            }
            first = Some(number).filter(|_| out.last() == Some(&number));
        }
        match (thru, out.is_empty()) {
            (None, false) => Ok(out),
            _ => Err(self.missing(reader, index, what)),
        }
    }

    fn range(&self, reader: &Reader<'_>, field: Field<'_>) -> MeshError {
        reader.error(
            field.line,
            format!("\"{}\" of {} ends no range", shown(field.text), self.name),
            "write a range as first, THRU, last; EXCEPT and BY are not read",
        )
    }
}
