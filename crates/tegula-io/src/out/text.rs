//! Foreign text made safe for a terminal.

use std::borrow::Cow;

/// The text with its control characters written as escapes, so that names from a file cannot steer a terminal. Line feeds
/// and tabs stay; marks that turn the direction of writing count as control characters.
pub fn printable(text: &str) -> Cow<'_, str> {
    if !text.contains(steers) {
        return Cow::Borrowed(text);
    }
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        if steers(c) { out.extend(c.escape_default()) } else { out.push(c) }
    }
    Cow::Owned(out)
}

fn steers(c: char) -> bool {
    (c.is_control() && c != '\n' && c != '\t')
        || matches!(c, '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

#[cfg(test)]
mod tests {
    use super::printable;

    #[test]
    fn escape_sequences_are_shown_instead_of_obeyed() {
        assert_eq!(printable("a\x1b[31mb\u{9b}2J\r\n\tc"), "a\\u{1b}[31mb\\u{9b}2J\\r\n\tc");
        assert_eq!(printable("\u{202e}txt.exe"), "\\u{202e}txt.exe");
        assert!(matches!(printable("plain text, Größe, 図"), std::borrow::Cow::Borrowed(_)));
    }
}
