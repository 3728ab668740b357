//! Messages for the syntax errors of the TOML parser.

use std::collections::HashSet;

use super::Diagnostic;
use super::diagnostic::Source;

/// First error of the parser on each line: the parser continues after an error, and further errors on the same line
/// are mostly consequences of the first one.
pub(super) fn diagnostics(source: &Source, errors: &[toml::de::Error]) -> Vec<Diagnostic> {
    let text = source.text();
    if text.trim_start().starts_with('{') {
        let start = text.len() - text.trim_start().len();
        let help = "write tables such as [analysis] and lines key = value; in Python tegula.Model(json.load(file)) takes the same keys from JSON";
        return vec![source.at(start..start + 1, "", "this is not TOML, but looks like JSON", help)];
    }
    let mut found: Vec<Diagnostic> = errors
        .iter()
        .map(|error| {
            let span = error.span().unwrap_or_default();
            let token = text.get(span.clone()).unwrap_or_default();
            let before = text.get(..span.start).unwrap_or_default();
            let after = text.get(span.end..).unwrap_or_default();
            let line_start = before.rfind('\n').map_or(0, |i| i + 1);
            let before = &before[line_start..];
            let line = text.get(line_start..).and_then(|t| t.lines().next()).unwrap_or_default();
            let (message, help) = explain(error.message(), token, [before, after], line.trim());
            source.at(span, "", message, help)
        })
        .collect();
    found.sort_by_key(|d| d.span.start);
    let mut lines = HashSet::new();
    found.retain(|d| lines.insert(d.line));
    found
}

const ONE_PER_LINE: &str = "write one key = value on each line; comments begin with #";
const NO_END: &str = "the string has no end";

/// Known errors: beginning of the parser's message, replacement, and remedy.
const PLAIN: &[(&str, &str, &str)] = &[
    (
        "invalid fraction",
        "a number needs digits on both sides of its decimal point",
        "write 1.0 instead of 1. and 0.5 instead of .5",
    ),
    (
        "invalid mantissa",
        "a number needs digits on both sides of its decimal point",
        "write 1.0 instead of 1. and 0.5 instead of .5",
    ),
    ("invalid exponent", "a number needs digits behind its e", "write 1e5 or 1.5e-3"),
    ("unexpected leading zero", "a number begins with a zero", "leave out the leading zeros"),
    ("invalid float", "this is not a number", "write a plain number such as 1.5e3"),
    ("invalid integer", "this is not a number", "write a plain number such as 1.5e3"),
    ("redundant numeric sign", "a number has two signs", "keep one of them"),
    ("unquoted keys cannot be empty", "the key is missing", "write a key here"),
    ("invalid basic string", NO_END, "close it on the same line with the quote it begins with"),
    ("invalid literal string", NO_END, "close it on the same line with the quote it begins with"),
    ("invalid multi-line", NO_END, "close it with the three quotes it begins with"),
    (
        "missing escaped value",
        "a backslash begins a special character here",
        "write paths with /, or put the string in single quotes",
    ),
    ("invalid comment character", "the comment holds a control character", "remove it"),
    (
        "unclosed table",
        "the header has no end",
        "close it with ] on the same line, or ]] if it begins with [[",
    ),
    (
        "unclosed array table",
        "the header has no end",
        "close it with ] on the same line, or ]] if it begins with [[",
    ),
    (
        "missing comma between array elements",
        "the list has no end here",
        "put commas between its entries and ] behind the last",
    ),
    (
        "unexpected `=` in array",
        "the list has no end here",
        "put commas between its entries and ] behind the last",
    ),
    ("unclosed array", "the list has no end", "close it with ]"),
    (
        "missing comma between key-value pairs",
        "the table in braces has no end here",
        "put commas between its keys and } behind the last",
    ),
    ("unclosed inline table", "the table in braces has no end", "close it with }"),
    ("extra comma", "there is nothing between two commas", "remove one of them"),
    ("extra `=`", "there are two equals signs", "write key = value"),
    ("cannot recurse", "lists or tables are nested too deeply", "close the brackets that are left open"),
    ("recursion limit", "the key has too many dots", "shorten it"),
];

/// Mistake and remedy in words: from the parser's message, the text it points
/// to, the text before that on its line and behind it, and the whole line.
fn explain(error: &str, token: &str, [before, after]: [&str; 2], line: &str) -> (String, String) {
    let is = |start: &str| error.starts_with(start);
    let say = |message: &str, help: &str| (message.to_owned(), help.to_owned());
    if line.starts_with(['%', '!', ';']) || line.starts_with("//") {
        return say("this is neither a key nor a comment", "begin comments with #");
    }
    if let Some((_, message, help)) = PLAIN.iter().find(|(start, ..)| is(start)) {
        return say(message, help);
    }
    let short = shorten(token);
    if is("string values must be quoted") {
        return match token.chars().next() {
            None => say("the value is missing", "write a value behind the equals sign"),
            Some(c) if c.is_ascii_digit() || "+-.".contains(c) => (
                format!("\"{short}\" is not a value"),
                "write a plain number such as 1.5e3, without units, formulas or commas".to_owned(),
            ),
            Some('(' | '<' | '|') => say("lists stand in square brackets", "write [x, y, z]"),
            Some(_) => (format!("text must stand in quotes: {short}"), format!("write \"{short}\"")),
        };
    }
    if is("invalid boolean") {
        return (format!("\"{short}\" is not a value"), "write true or false in small letters".to_owned());
    }
    if is("unexpected key or value") {
        return if after.starts_with(',') {
            say(
                "a comma stands outside of a list",
                "write the decimal point as a dot, 0.5, and lists in brackets, [1, 2]",
            )
        } else {
            say("something stands behind the value", ONE_PER_LINE)
        };
    }
    if is("key with no value") {
        return (format!("the key {} has no value", shorten(before.trim())), ONE_PER_LINE.to_owned());
    }
    if is("invalid unquoted key") {
        let help = if token.starts_with(':') {
            "write key = value, with an equals sign"
        } else {
            "keys consist of a–z, A–Z, 0–9, _ and -; put other names in quotes"
        };
        return (format!("\"{short}\" cannot stand in a key"), help.to_owned());
    }
    if is("duplicate key") || is("cannot extend value") {
        let help = if line.starts_with('[') && !line.starts_with("[[") {
            "keep one of them; a list of tables has double brackets, such as [[loads]]"
        } else {
            "keep one of them"
        };
        return (format!("\"{short}\" is given twice"), help.to_owned());
    }
    (
        format!("this is not valid TOML: {error}"),
        "the format of the file is described at https://toml.io".to_owned(),
    )
}

/// First characters of the offending text, on one line.
pub(super) fn shorten(text: &str) -> String {
    let mut short: String =
        text.chars().map(|c| if c.is_control() { '\u{fffd}' } else { c }).take(40).collect();
    if text.chars().nth(40).is_some() {
        short.push('…');
    }
    short
}
