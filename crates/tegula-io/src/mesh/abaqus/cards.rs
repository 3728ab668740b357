//! Keyword cards of input files of Abaqus and CalculiX.
//!
//! A line that begins with `*` is a keyword line: the keyword, then parameters `NAME=value` between commas; it continues on the next line
//! where it ends with a comma. The lines up to the next keyword line are its data lines, values between commas. Lines that begin with
//! `**` are comments. Upper and lower case are the same, and blanks around commas and equal signs do not count.

use crate::mesh::MeshError;
pub use crate::mesh::numbered::{Reader, shown, text};

/// A keyword line with its data lines.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Card<'a> {
    /// Keyword in capitals, without the star and with single blanks, such as `SHELL SECTION`.
    pub keyword: String,
    /// Line of the keyword, counted from 1.
    pub line: usize,
    /// Parameters in the order of the file.
    pub parameters: Vec<Parameter<'a>>,
    /// Data lines; empty lines are left out.
    pub data: Vec<DataLine<'a>>,
}

/// A parameter of a keyword line.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Parameter<'a> {
    /// Name in capitals.
    pub name: String,
    /// Value as it stands in the file, without quotes; empty where there is none.
    pub value: &'a str,
}

/// A data line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DataLine<'a> {
    /// Line, counted from 1.
    pub line: usize,
    /// Its text without blanks around it.
    pub text: &'a str,
}

impl Reader<'_> {
    /// Cards of a text.
    ///
    /// # Errors
    /// Data stand before the first keyword, or a keyword line has no keyword or an incomplete parameter.
    pub fn cards<'t>(&self, text: &'t str) -> Result<Vec<Card<'t>>, MeshError> {
        let mut cards: Vec<Card<'t>> = Vec::new();
        let mut continued = false;
        for (line, content) in text.lines().enumerate().map(|(i, line)| (i + 1, line.trim())) {
            if content.is_empty() || content.starts_with("**") {
                continue;
            }
            if let Some(rest) = content.strip_prefix('*') {
                let (keyword, parameters) = rest.split_once(',').unwrap_or((rest, ""));
                let keyword = single_blanks(keyword);
                if keyword.is_empty() {
                    return Err(self.error(
                        line,
                        "the keyword is missing behind the star",
                        "write a keyword such as *NODE",
                    ));
                }
                let parameters = self.parameters(line, parameters)?;
                cards.push(Card { keyword, line, parameters, data: Vec::new() });
                continued = content.ends_with(',');
                continue;
            }
            let Some(card) = cards.last_mut() else {
                return Err(self.error(
                    line,
                    format!("\"{}\" stands before the first keyword", shown(content)),
                    "an input file of Abaqus or CalculiX begins with a keyword such as *HEADING or *NODE",
                ));
            };
            if continued {
                card.parameters.extend(self.parameters(line, content)?);
                continued = content.ends_with(',');
            } else {
                card.data.push(DataLine { line, text: content });
            }
        }
        Ok(cards)
    }

    /// Parameters of a keyword line behind the keyword, or of its continuation.
    fn parameters<'t>(&self, line: usize, text: &'t str) -> Result<Vec<Parameter<'t>>, MeshError> {
        let mut found = Vec::new();
        for part in text.split(',').map(str::trim).filter(|part| !part.is_empty()) {
            let (name, value) = match part.split_once('=') {
                Some((name, value)) => (name, Some(value.trim().trim_matches('"').trim())),
                None => (part, None),
            };
            let name = single_blanks(name);
            if name.is_empty() || value.is_some_and(str::is_empty) {
                return Err(self.error(
                    line,
                    format!("\"{}\" is no parameter", shown(part)),
                    "write NAME=value between commas",
                ));
            }
            found.push(Parameter { name, value: value.unwrap_or("") });
        }
        Ok(found)
    }

    /// Refuses all parameters of a card but the `known` ones, and those that are given twice.
    ///
    /// # Errors
    /// The first such parameter.
    pub fn only(&self, card: &Card<'_>, known: &[&str]) -> Result<(), MeshError> {
        for (i, Parameter { name, .. }) in card.parameters.iter().enumerate() {
            let (keyword, name) = (&card.keyword, name.as_str());
            if !known.contains(&name) {
                return Err(self.error(
                    card.line,
                    format!("the parameter {} of *{keyword} is not read", shown(name)),
                    match known {
                        [] => format!("*{keyword} is read without parameters"),
                        _ => format!("remove it; *{keyword} is read with {}", known.join(", ")),
                    },
                ));
            }
            if card.parameters.iter().take(i).any(|earlier| earlier.name == name) {
                return Err(self.error(
                    card.line,
                    format!("*{keyword} has the parameter {name} twice"),
                    "keep one of them",
                ));
            }
        }
        Ok(())
    }

    /// Value of a parameter that a card must have.
    ///
    /// # Errors
    /// The card does not have it.
    pub fn required<'t>(&self, card: &Card<'t>, name: &str) -> Result<&'t str, MeshError> {
        card.parameter(name).filter(|value| !value.is_empty()).ok_or_else(|| {
            self.error(
                card.line,
                format!("*{} has no {name}", card.keyword),
                format!("add {name}= and a name to the keyword line"),
            )
        })
    }

    /// Value of a parameter that names a set, which must not be a number; `None` where the card does not have it.
    ///
    /// # Errors
    /// The name is missing or is a number.
    pub fn set_name<'t>(&self, card: &Card<'t>, name: &str) -> Result<Option<&'t str>, MeshError> {
        if !card.has(name) {
            return Ok(None);
        }
        let value = self.required(card, name)?;
        match label(value) {
            None => Ok(Some(value)),
            Some(_) => Err(self.error(
                card.line,
                format!("the set \"{}\" is called by a number", shown(value)),
                "give it a name that begins with a letter, as numbers stand for single nodes and elements",
            )),
        }
    }

    /// A finite number; an empty field is 0, and an exponent may begin with D.
    ///
    /// # Errors
    /// The field is no number.
    pub fn number(&self, line: usize, field: &str) -> Result<f64, MeshError> {
        if field.is_empty() {
            return Ok(0.0);
        }
        let plain = field.bytes().all(|b| b.is_ascii_digit() || b"+-.eEdD".contains(&b));
        let parsed = match field.contains(['d', 'D']) {
            true => field.replace(['d', 'D'], "e").parse(),
            false => field.parse(),
        };
        parsed.ok().filter(|x: &f64| plain && x.is_finite()).ok_or_else(|| {
            self.error(
                line,
                format!("\"{}\" is not a number", shown(field)),
                "write a finite number such as 1.5e3, and commas between numbers",
            )
        })
    }

    /// The number of a node or an element, which is above 0; `what` names it in the error.
    ///
    /// # Errors
    /// The field is no such number.
    pub fn label(&self, line: usize, field: &str, what: &str) -> Result<u64, MeshError> {
        label(field).ok_or_else(|| {
            self.error(
                line,
                format!("\"{}\" is not the number of {what}", shown(field)),
                "numbers of nodes and elements are whole and above 0, with commas between them",
            )
        })
    }

    /// Data line of a card that has exactly one.
    ///
    /// # Errors
    /// It has none or several; `what` it should hold stands in the help.
    pub fn single<'t>(&self, card: &Card<'t>, what: &str) -> Result<DataLine<'t>, MeshError> {
        match card.data[..] {
            [line] => Ok(line),
            [] => Err(self.error(
                card.line,
                format!("*{} has no data line", card.keyword),
                format!("give {what} on the line behind it"),
            )),
            [_, second, ..] => Err(self.error(
                second.line,
                format!("*{} has more than one data line", card.keyword),
                format!("give {what} on one line"),
            )),
        }
    }
}

impl<'a> Card<'a> {
    /// Value of a parameter; empty where it has none.
    pub fn parameter(&self, name: &str) -> Option<&'a str> {
        self.parameters.iter().find(|p| p.name == name).map(|p| p.value)
    }

    /// Whether a parameter is there, with or without a value.
    pub fn has(&self, name: &str) -> bool {
        self.parameter(name).is_some()
    }

    /// Fields of all data lines one after another, each with its line; an empty field behind the last comma of a line is none.
    pub fn fields(&self) -> impl Iterator<Item = (usize, &'a str)> {
        self.data.iter().flat_map(|data| data.fields().map(|field| (data.line, field)))
    }
}

impl<'a> DataLine<'a> {
    /// Values between the commas; an empty one behind the last comma is none.
    pub fn fields(self) -> impl Iterator<Item = &'a str> {
        self.text.strip_suffix(',').unwrap_or(self.text).split(',').map(str::trim)
    }

    /// Values between the commas, as a list.
    pub fn list(self) -> Vec<&'a str> {
        self.fields().collect()
    }
}

/// Number of a node or an element; `None` for anything else, such as the name of a set.
pub fn label(field: &str) -> Option<u64> {
    let digits = !field.is_empty() && field.bytes().all(|b| b.is_ascii_digit());
    field.parse().ok().filter(|&n| digits && n > 0)
}

/// Words in capitals with one blank between them.
fn single_blanks(text: &str) -> String {
    let words: Vec<String> = text.split_whitespace().map(str::to_uppercase).collect();
    words.join(" ")
}
